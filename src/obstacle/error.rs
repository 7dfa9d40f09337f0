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
    /// A length below zero.
    #[error("{parameter} must not be below zero, as {value} is")]
    Negative {
        /// Name of the parameter.
        parameter: &'static str,
        /// What was given.
        value: f64,
    },
    /// A length that the others leave no room for.
    #[error("{parameter} is {value}, the other lengths leave room for {limit} at most")]
    TooLarge {
        /// Name of the parameter.
        parameter: &'static str,
        /// What was given.
        value: f64,
        /// Largest value.
        limit: f64,
    },
    /// Half an angle of a cone that is not one.
    #[error(
        "{parameter} must lie between 0 and 1.5708 radians, a right angle, as {value} does not"
    )]
    NotAnAngle {
        /// Name of the parameter.
        parameter: &'static str,
        /// What was given, radians.
        value: f64,
    },
    /// An angle between facets that is none.
    #[error("{parameter} must lie between 0 and 180 degrees, as {degrees} does not")]
    NotBetweenFacets {
        /// Name of the parameter.
        parameter: &'static str,
        /// What was given, degrees.
        degrees: f64,
    },
    /// A cavity in the form of a shape without an inside.
    #[error("the shape has no inside: only closed shapes are cavities")]
    NotClosed {
        /// Name of the parameter.
        parameter: &'static str,
    },
    /// A shape that would push a flat body out of its plane.
    #[error(
        "does not lie in the plane z = 0 of the body (centres and points need z = 0, a cylinder the axis z, a box half sizes along z above its others')"
    )]
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
            | Self::Negative { parameter, .. }
            | Self::TooLarge { parameter, .. }
            | Self::NotAnAngle { parameter, .. }
            | Self::NotBetweenFacets { parameter, .. }
            | Self::NotClosed { parameter }
            | Self::OutOfPlane { parameter } => parameter,
        }
    }
}
