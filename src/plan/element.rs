//! The element: Taylor-Hood, P2 displacement with P1 pressure where the scene is mixed.

use crate::plan::Plan;
use crate::report::Unknowns;
use crate::scene::validate::Resolved;
use crate::space::TaylorHood;

/// Displacement and pressure unknowns.
pub(super) fn unknowns(space: &TaylorHood, resolved: &Resolved) -> Unknowns {
    Unknowns {
        displacement: space.displacement_unknowns() as u64,
        pressure: if resolved.mixed {
            space.vertices as u64
        } else {
            0
        },
        contact: 0,
    }
}

impl Plan {
    /// What carries displacement (or velocity) and pressure.
    pub(crate) fn formulation_name(&self) -> String {
        let field = if self.problem.resolved.is_flow() {
            "velocity"
        } else {
            "displacement"
        };
        if self.problem.resolved.mixed {
            format!("Taylor-Hood: P2 {field}, P1 pressure")
        } else {
            format!("P2 {field}")
        }
    }

    /// Why.
    pub(crate) fn formulation_reason(&self) -> &'static str {
        let resolved = &self.problem.resolved;
        if !resolved.mixed {
            "every Poisson ratio is below 0.45"
        } else if resolved.is_flow() {
            "Stokes flow: u is a velocity, the modulus a viscosity (stress times time)"
        } else if resolved.is_rubber() {
            "rubber is always mixed"
        } else {
            "a material has a Poisson ratio of at least 0.45"
        }
    }
}
