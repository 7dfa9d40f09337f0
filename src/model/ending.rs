//! How an increment ended: what the report says of the solve beside the state.
//!
//! Residuals are relative to the load or the first residual, penetration is in units of
//! the scaled body. An increment that does not converge ends with its last good state and
//! the residuals of that state.

use super::push::{Control, Part};
use crate::plan::{Plan, Units};
use crate::report::{Cause, CauseSite, Residuals, Snapped, Stability, Termination};

/// The estimated error of the displacement.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Estimate {
    /// theta, the energy norm of the error over that of the displacement.
    pub(crate) relative: f64,
    /// Energy norm of the displacement with the error included, non-dimensional.
    pub(crate) norm: f64,
    /// Squares of the energy norms of the error and of the displacement in each connected
    /// part of the body `[parts]`.
    pub(crate) parts: Vec<[f64; 2]>,
}

/// A snap-through from a lost equilibrium to the next minimum, non-dimensional.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Snap {
    /// Potential energy that was lost.
    pub(crate) energy_drop: f64,
    /// Largest motion of a vertex.
    pub(crate) largest_motion: f64,
    /// Undeformed place of that vertex, in the mesh's lengths.
    pub(crate) point: [f64; 3],
    /// Whether the equilibrium before was seen to be lost; else it could not be followed.
    pub(crate) was_lost: bool,
}

impl Snap {
    /// Both snap-throughs of an increment: all energy, and the larger motion.
    pub(crate) fn and(self, other: Self) -> Self {
        let larger = if other.largest_motion > self.largest_motion {
            other
        } else {
            self
        };
        Self {
            energy_drop: self.energy_drop + other.energy_drop,
            was_lost: self.was_lost && other.was_lost,
            ..larger
        }
    }

    /// In the caller's units.
    pub(crate) fn in_units(self, units: &Units) -> Snapped {
        Snapped {
            energy_drop: self.energy_drop * units.energy(),
            largest_motion: self.largest_motion * units.length,
            point: units.of_mesh(self.point),
        }
    }
}

/// Where an increment lost its equilibrium.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Site {
    /// Undeformed point, in the mesh's lengths.
    pub(crate) point: Option<[f64; 3]>,
    /// Unit vector of the motion.
    pub(crate) motion: Option<[f64; 3]>,
    /// Push that nothing balances.
    pub(crate) unbalanced: Option<Control>,
}

impl Site {
    /// In the caller's units and names.
    pub(crate) fn in_words_of(self, plan: &Plan) -> CauseSite {
        let key = |control: Control| {
            let problem = &plan.problem;
            let (kind, name) = match control.part {
                Part::Obstacle(index) => ("obstacle", &problem.obstacles.get(index)?.name),
                Part::Support(index) => ("support", &problem.resolved.supports.get(index)?.name),
            };
            Some(format!("{kind}.{name}.{}", control.key()))
        };
        CauseSite {
            point: self.point.map(|point| plan.problem.units.of_mesh(point)),
            motion: self.motion,
            key: self.unbalanced.and_then(key),
        }
    }
}

/// Another equilibrium under the same drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AlternativeEquilibrium {
    /// How strongly pressures wedge each other: from one on there may be several.
    pub(crate) indicator: f64,
    /// Points that stick, slip and are open at the equilibrium that was found.
    pub(crate) own: [usize; 3],
    /// The same at the other one.
    pub(crate) other: [usize; 3],
}

/// A fluid where it must not be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Leak {
    /// The fluid, by its place in the scene.
    pub(crate) fluid: usize,
    /// The displacement node that it has reached; none where it has lifted the body.
    pub(crate) node: Option<u32>,
    /// Its pressure at the last tight equilibrium, and where it leaks, the caller's stress; zeros
    /// until they are bracketed.
    pub(crate) pressures: [f64; 2],
    /// Whether nothing holds the body at the second one.
    pub(crate) is_pushed_out: bool,
    /// What flowed for a unit of pressure where it was seen to leak, volume over time and stress in the
    /// caller's units; none without a viscosity, or where no equilibrium was found.
    pub(crate) conductance: Option<f64>,
}

/// How an increment ended.
#[derive(Clone, Debug)]
pub(crate) struct Ending {
    /// Whether the increment converged, was stopped or failed.
    pub(crate) termination: Termination,
    /// Why it did not converge; none where it did.
    pub(crate) cause: Option<Cause>,
    /// Where the cause lies, as far as it is known.
    pub(crate) site: Option<Site>,
    /// The four residuals at the state kept.
    pub(crate) residuals: Residuals,
    /// Deepest penetration at a point of the rule, in units of the scaled body.
    pub(crate) max_penetration: f64,
    /// Norm of the force that counts as one in the equilibrium residual,
    /// non-dimensional.
    pub(crate) force_scale: f64,
    /// Bound on the residuals that counted: that of the scene, or of the
    /// discretisation.
    pub(crate) tolerance: f64,
    /// Of the discretisation error, where the increment's end depended on it.
    pub(crate) estimate: Option<Estimate>,
    /// What kind of equilibrium it is, where one was reached and certified.
    pub(crate) stability: Option<Stability>,
    /// The snap-through on the way; none where every equilibrium was followed.
    pub(crate) snapped: Option<Snap>,
    /// Another equilibrium that friction may admit; none where none was found.
    pub(crate) alternative: Option<AlternativeEquilibrium>,
    /// The leak that ended the load path; none where fluids are tight.
    pub(crate) leak: Option<Leak>,
}

impl Ending {
    /// Converged, with nothing to say of it.
    #[cfg(test)]
    pub(crate) fn converged() -> Self {
        Self {
            termination: Termination::Converged,
            cause: None,
            site: None,
            residuals: Residuals::default(),
            max_penetration: 0.0,
            force_scale: 1.0,
            tolerance: 1e-8,
            estimate: None,
            stability: None,
            snapped: None,
            alternative: None,
            leak: None,
        }
    }

    /// Whether something outside the solver ended it.
    pub(crate) fn is_stopped(&self) -> bool {
        match self.termination {
            Termination::Converged | Termination::NotConverged => false,
            Termination::Cancelled | Termination::DeadlineExceeded | Termination::InternalError => {
                true
            }
        }
    }
}
