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
        let field = if self.resolved.is_flow() {
            "velocity"
        } else {
            "displacement"
        };
        match self.resolved.mixed {
            true => format!("Taylor-Hood: P2 {field}, P1 pressure"),
            false => format!("P2 {field}"),
        }
    }

    /// Why.
    pub(crate) fn formulation_reason(&self) -> &'static str {
        match self.resolved.mixed {
            true if self.resolved.is_flow() => {
                "Stokes flow: u is a velocity, the modulus a viscosity (stress times time)"
            }
            true if self.resolved.is_rubber() => "rubber is always mixed",
            true => "a material has a Poisson ratio of at least 0.45",
            false => "every Poisson ratio is below 0.45",
        }
    }
}
