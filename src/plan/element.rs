//! The element: Taylor-Hood, or one that it is compared with.

use super::Plan;
use crate::mesh::Mesh;
use crate::report::Unknowns;
use crate::scene::validate::Resolved;
use crate::space::TaylorHood;
use crate::space::enriched::{Enriched, Enrichment};

/// Discretisations of displacement and pressure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Element {
    /// P2 displacement; P1 pressure where the scene is mixed.
    TaylorHood,
    /// A comparison element.
    Enriched(Enrichment),
}

impl Element {
    /// By the scene's `solver.element`, which is valid.
    pub(super) fn from_name(name: &str) -> Self {
        match name {
            "mini" => Self::Enriched(Enrichment::CellBubbles),
            "bernardi-raugel" => Self::Enriched(Enrichment::FacetBubbles),
            _ => Self::TaylorHood,
        }
    }

    /// Distinguishes prepared data.
    pub(super) fn number(self) -> u8 {
        match self {
            Self::TaylorHood => 0,
            Self::Enriched(Enrichment::CellBubbles) => 1,
            Self::Enriched(Enrichment::FacetBubbles) => 2,
        }
    }

    /// Displacement and pressure unknowns.
    pub(super) fn unknowns(self, mesh: &Mesh, resolved: &Resolved) -> Unknowns {
        let (displacement, pressure) = match self {
            Self::TaylorHood => {
                let space = TaylorHood::new(mesh);
                let pressure = if resolved.mixed { space.vertices } else { 0 };
                (space.displacement_unknowns(), pressure)
            }
            Self::Enriched(enrichment) => {
                let space = Enriched::new(mesh, enrichment);
                (space.displacement_unknowns(), space.pressure_unknowns())
            }
        };
        Unknowns {
            displacement: displacement as u64,
            pressure: pressure as u64,
            contact: 0,
        }
    }
}

impl Plan {
    /// What carries displacement (or velocity) and pressure.
    pub(super) fn formulation_name(&self) -> String {
        let field = match self.resolved.is_flow() {
            true => "velocity",
            false => "displacement",
        };
        match (self.element, self.resolved.mixed) {
            (Element::TaylorHood, true) => format!("Taylor-Hood: P2 {field}, P1 pressure"),
            (Element::TaylorHood, false) => format!("P2 {field}"),
            (Element::Enriched(Enrichment::CellBubbles), _) => {
                format!("MINI: P1 {field} with cell bubbles, P1 pressure")
            }
            (Element::Enriched(Enrichment::FacetBubbles), _) => {
                format!("Bernardi-Raugel: P1 {field} with normal facet bubbles, P0 pressure")
            }
        }
    }

    /// Why.
    pub(super) fn formulation_reason(&self) -> &'static str {
        match (self.element, self.resolved.mixed) {
            (Element::Enriched(_), _) => "asked for, to compare",
            (Element::TaylorHood, true) if self.resolved.is_flow() => {
                "Stokes flow: u is a velocity, the modulus a viscosity (stress times time)"
            }
            (Element::TaylorHood, true) if self.resolved.is_rubber() => "rubber is always mixed",
            (Element::TaylorHood, true) => "a material has a Poisson ratio of at least 0.45",
            (Element::TaylorHood, false) => "every Poisson ratio is below 0.45",
        }
    }

    /// Whether the element is one that Taylor-Hood is compared with.
    pub(crate) fn enrichment(&self) -> Option<Enrichment> {
        match self.element {
            Element::TaylorHood => None,
            Element::Enriched(enrichment) => Some(enrichment),
        }
    }
}
