//! The element: Taylor-Hood, or one that it is compared with.
//!
//! The usual one is P2 - P1; comparison elements serve mixed, linear scenes, and are
//! refused by the path of the key elsewhere.

use crate::mesh::Mesh;
use crate::plan::{Plan, chooser};
use crate::report::Unknowns;
use crate::scene::validate::Resolved;
use crate::scene::{Choice, ElementKind};
use crate::space::TaylorHood;

/// Chooses; `asked` is the scene's `solver.element`.
pub(super) fn choose(asked: Choice<ElementKind>) -> ElementKind {
    asked.named().unwrap_or(ElementKind::TaylorHood)
}

impl ElementKind {
    /// Distinguishes prepared data.
    pub(crate) fn number(self) -> u8 {
        match self {
            Self::TaylorHood => 0,
            Self::Mini => 1,
            Self::BernardiRaugel => 2,
        }
    }

    /// Displacement and pressure unknowns.
    pub(crate) fn unknowns(self, mesh: &Mesh, resolved: &Resolved) -> Unknowns {
        let (displacement, pressure) = chooser::unknowns(self, mesh).unwrap_or_else(|| {
            let space = TaylorHood::new(mesh);
            let pressure = if resolved.mixed { space.vertices } else { 0 };
            (space.displacement_unknowns(), pressure)
        });
        Unknowns {
            displacement: displacement as u64,
            pressure: pressure as u64,
            contact: 0,
        }
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
        match (self.element, self.resolved.mixed) {
            (ElementKind::TaylorHood, true) => format!("Taylor-Hood: P2 {field}, P1 pressure"),
            (ElementKind::TaylorHood, false) => format!("P2 {field}"),
            (ElementKind::Mini, _) => {
                format!("MINI: P1 {field} with cell bubbles, P1 pressure")
            }
            (ElementKind::BernardiRaugel, _) => {
                format!("Bernardi-Raugel: P1 {field} with normal facet bubbles, P0 pressure")
            }
        }
    }

    /// Why.
    pub(crate) fn formulation_reason(&self) -> &'static str {
        match (self.element, self.resolved.mixed) {
            (ElementKind::Mini | ElementKind::BernardiRaugel, _) => "asked for, to compare",
            (ElementKind::TaylorHood, true) if self.resolved.is_flow() => {
                "Stokes flow: u is a velocity, the modulus a viscosity (stress times time)"
            }
            (ElementKind::TaylorHood, true) if self.resolved.is_rubber() => {
                "rubber is always mixed"
            }
            (ElementKind::TaylorHood, true) => "a material has a Poisson ratio of at least 0.45",
            (ElementKind::TaylorHood, false) => "every Poisson ratio is below 0.45",
        }
    }
}
