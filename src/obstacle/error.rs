//! Why a shape is refused; the parameter has the name it has in scenes.

use thiserror::Error;

/// A parameter without meaning.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ObstacleError {
    /// A parameter is NaN or infinite.
    #[error("{parameter} is not finite")]
    NotFinite {
        /// Name of the parameter.
        parameter: &'static str,
    },
    /// A length is zero or negative where one above zero is needed.
    #[error("{parameter} must be above zero, not {value}")]
    NotPositive {
        /// Name of the parameter.
        parameter: &'static str,
        /// What was given.
        value: f64,
    },
    /// A direction is the zero vector.
    #[error("{parameter} is the zero vector and has no direction")]
    ZeroLength {
        /// Name of the parameter.
        parameter: &'static str,
    },
    /// A shape that would push a flat body out of its plane.
    #[error("does not lie in the plane z = 0 of the body (a cylinder's axis must be z)")]
    OutOfPlane {
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
            | Self::ZeroLength { parameter }
            | Self::OutOfPlane { parameter } => parameter,
        }
    }
}
