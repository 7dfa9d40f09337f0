//! Why a shape is refused; the parameter has the name it has in scenes.

use thiserror::Error;

/// A parameter without meaning.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ObstacleError {
    /// NaN or infinite.
    #[error("{parameter} is not finite")]
    NotFinite {
        /// Name of the parameter.
        parameter: &'static str,
    },
    /// Zero or negative where a length is needed.
    #[error("{parameter} must be above zero, not {value}")]
    NotPositive {
        /// Name of the parameter.
        parameter: &'static str,
        /// What was given.
        value: f64,
    },
    /// The zero vector where a direction is needed.
    #[error("{parameter} is the zero vector and has no direction")]
    ZeroLength {
        /// Name of the parameter.
        parameter: &'static str,
    },
}

impl ObstacleError {
    /// Name of the faulty parameter, as in scenes.
    pub fn parameter(&self) -> &'static str {
        match self {
            Self::NotFinite { parameter }
            | Self::NotPositive { parameter, .. }
            | Self::ZeroLength { parameter } => parameter,
        }
    }
}
