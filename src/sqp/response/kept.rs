//! What is kept of a body's response; all of it a function of the body, or of loads and supports.

use super::columns::Columns;
use crate::inequality::BodyFactor;
use crate::model::drive::Drive;

/// What is known of a body's response.
#[derive(Debug)]
pub(crate) struct Response {
    /// K as a factor.
    pub(super) factor: BodyFactor,
    /// G where it was asked for.
    pub(super) columns: Columns,
    /// u0 and p0 under the last loads and supports.
    pub(super) free: Option<Free>,
    /// Norm of the volumes that a smooth load on the surface changes where no pressure resists,
    /// over that of the load.
    pub(super) volumes: f64,
}

/// A response, or that there is none.
#[derive(Debug, Default)]
pub(crate) enum Known {
    /// It was not asked for yet.
    #[default]
    Nothing,
    /// The body's.
    Response(Box<Response>),
    /// The factor does not fit.
    Refused,
}

impl Known {
    /// Bytes held.
    pub(crate) fn bytes(&self) -> u64 {
        match self {
            Self::Response(response) => {
                let free = response.free.as_ref().map_or(0, Free::bytes);
                response.factor.bytes() + response.columns.bytes() + free
            }
            Self::Nothing | Self::Refused => 0,
        }
    }
}

/// u0 and p0.
#[derive(Debug)]
pub(super) struct Free {
    /// What they belong to, obstacles at their poses of then.
    pub(super) drive: Drive,
    /// Hierarchical displacement `[displacement]`.
    pub(super) displacement: Vec<f64>,
    /// Pressure `[pressures]`.
    pub(super) pressure: Vec<f64>,
}

impl Free {
    /// Whether they are those of `drive`, wherever its obstacles are.
    pub(super) fn is_of(&self, drive: &Drive) -> bool {
        self.drive.load.to_bits() == drive.load.to_bits()
            && self.drive.supports == drive.supports
            && self.drive.motions == drive.motions
            && self.drive.given == drive.given
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> u64 {
        8 * (self.displacement.len() + self.pressure.len()) as u64
    }
}
