//! What is kept of a body's response; all of it a function of the body, or of loads and supports.

use std::sync::Arc;

use super::columns::Columns;
use super::near::Near;
use crate::inequality::BodyFactor;
use crate::linalg::Workspace;
use crate::model::drive::Drive;
use crate::plan::response::FieldsFrom;

/// What is known of a body's response.
#[derive(Debug)]
pub(crate) struct Response {
    /// What sessions of the same body share.
    pub(super) body: Arc<BodyResponse>,
    /// G where the last problem saw it.
    pub(super) near: Near,
    /// u0 and p0 under the last loads and supports.
    pub(super) free: Option<Free>,
}

/// A function of the body alone.
#[derive(Debug)]
pub(super) struct BodyResponse {
    /// K as a factor.
    pub(super) factor: BodyFactor,
    /// G where it was asked for.
    pub(super) columns: Columns,
    /// Norm of the volumes that a smooth load on the surface changes where no pressure resists,
    /// over that of the load.
    pub(super) volumes: f64,
    /// What a solution with the factor leaves of a load on the surface.
    pub(super) accuracy: Accuracy,
}

impl BodyResponse {
    /// K^-1 of a load on the surface `[displacement]`, in the same way whatever columns are known.
    pub(super) fn solution(&self, mut load: Vec<f64>, work: &mut Workspace) -> Vec<f64> {
        load.resize(self.factor.size(), 0.0);
        match self.columns.fields {
            FieldsFrom::Columns => self.columns.whole_product(&load, &self.factor),
            FieldsFrom::Factor => {
                self.factor.solve(&mut load, work);
                load
            }
        }
    }
}

/// Norms of what a solution leaves of the equations of forces and volumes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Accuracy {
    /// Of forces.
    pub(super) force: f64,
    /// Of volumes.
    pub(super) volume: f64,
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
    /// Bytes held, of what is shared an equal part.
    pub(crate) fn bytes(&self) -> u64 {
        match self {
            Self::Response(response) => {
                let free = response.free.as_ref().map_or(0, Free::bytes);
                let body = &response.body;
                let shared = body.factor.bytes() + body.columns.bytes();
                shared / Arc::strong_count(body) as u64 + response.near.bytes() + free
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
    /// What they leave, non-dimensional.
    pub(super) left: Accuracy,
    /// Norm of the reactions, where supports prescribe a motion.
    pub(super) reaction_norm: f64,
}

impl Free {
    /// Whether they are those of `drive`, wherever its obstacles are.
    pub(super) fn is_of(&self, drive: &Drive) -> bool {
        self.drive.is_loaded_like(drive)
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> u64 {
        8 * (self.displacement.len() + self.pressure.len()) as u64
    }
}
