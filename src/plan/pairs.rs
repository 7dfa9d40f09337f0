//! Which of two surfaces that may touch carries the pressure of their contact.
//!
//! The softer one, by the least shear modulus of the cells beside it: multipliers on a stiff finer
//! surface are not held by the motions of the soft one (inf-sup 0.02 at 1000 : 1). Of surfaces that
//! are alike the finer one, by the mean size of its facets; the scene may say otherwise. Cost: one
//! pass over the facets.

use super::PlanEntry;
use crate::assembly::load::facet_measure;
use crate::mesh::Mesh;
use crate::pairs::Meets;
use crate::scene::ContactPair;
use crate::scene::validate::{Resolved, ResolvedPair};

/// Ratio of moduli up to which bodies are alike.
pub(crate) const ALIKE: f64 = 3.0;
/// Why a surface carries that `carries` names.
const NAMED: &str = "the scene has it carry";

/// A contact with its carrier chosen.
#[derive(Clone, Debug)]
pub(crate) struct PlannedPair {
    /// Name of the contact.
    pub(crate) name: String,
    /// Facets of the surface that carries the multipliers.
    pub(crate) carrier: Vec<u32>,
    /// Facets of the other one.
    pub(crate) other: Vec<u32>,
    /// Whom the carrier meets.
    pub(crate) meets: Meets,
    /// Coefficient of Coulomb friction.
    pub(crate) friction: f64,
    /// Largest traction in its place, the caller's stress.
    pub(crate) tresca: Option<f64>,
    /// Which side of the scene carries.
    side: usize,
    reason: &'static str,
}

impl PlannedPair {
    /// Whether it has friction.
    pub(crate) fn is_frictional(&self) -> bool {
        self.friction > 0.0 || self.tresca.is_some()
    }

    /// Whether the scene says which side carries.
    pub(super) fn is_named(&self) -> bool {
        self.reason == NAMED
    }

    /// The same with the other side as carrier.
    pub(super) fn turned(&self, reason: &'static str) -> Self {
        Self {
            carrier: self.other.clone(),
            other: self.carrier.clone(),
            side: 1 - self.side,
            reason,
            ..self.clone()
        }
    }

    /// Whether the group that the scene names first carries.
    pub(crate) fn first_carries(&self) -> bool {
        self.side == 0
    }

    /// Which side of the scene carries.
    pub(super) fn side(&self) -> usize {
        self.side
    }

    /// Why that one does.
    pub(super) fn reason(&self) -> &'static str {
        self.reason
    }
}

/// All contacts of a scene, or all ties.
pub(super) fn choose(pairs: &[ResolvedPair], resolved: &Resolved, mesh: &Mesh) -> Vec<PlannedPair> {
    let planned = pairs.iter().map(|pair| {
        let (side, reason) = carrier(pair, resolved, mesh);
        PlannedPair {
            name: pair.name.clone(),
            carrier: pair.sides[side].clone(),
            other: pair.sides[1 - side].clone(),
            meets: pair.meets,
            friction: pair.friction,
            tresca: pair.tresca,
            side,
            reason,
        }
    });
    planned.collect()
}

fn carrier(pair: &ResolvedPair, resolved: &Resolved, mesh: &Mesh) -> (usize, &'static str) {
    if pair.meets == Meets::Itself {
        return (
            0,
            "of two of its parts that touch the one that comes first along it",
        );
    }
    if let Some(side) = pair.named {
        return (side, NAMED);
    }
    let [first, second] = [0, 1].map(|side: usize| modulus(&pair.sides[side], resolved, mesh));
    if first > ALIKE * second {
        return (1, "it is the softer one");
    }
    if second > ALIKE * first {
        return (0, "it is the softer one");
    }
    let [first, second] = [0, 1].map(|side: usize| size(&pair.sides[side], mesh));
    if second < (1.0 - 1e-9) * first {
        (1, "bodies are alike, its faces are smaller")
    } else if first < (1.0 - 1e-9) * second {
        (0, "bodies are alike, its faces are smaller")
    } else {
        (0, "both are alike, it is named first")
    }
}

/// Least shear modulus beside facets, the caller's stress.
fn modulus(facets: &[u32], resolved: &Resolved, mesh: &Mesh) -> f64 {
    let of = |&facet: &u32| {
        let (cell, _) = mesh.facet_cell(facet as usize);
        let material = usize::from(resolved.cell_material[cell]);
        resolved.materials[material].law.shear_modulus
    };
    facets.iter().map(of).fold(f64::INFINITY, f64::min)
}

/// Mean size of facets, in units of the mesh.
fn size(facets: &[u32], mesh: &Mesh) -> f64 {
    let sizes = facets.iter();
    let sizes = sizes.map(|&facet| facet_measure(mesh, mesh.facet(facet as usize), 1.0).0);
    sizes.sum::<f64>() / facets.len().max(1) as f64
}

/// What a plan says of its contacts, which have that many `multipliers` each.
pub(super) fn entries(
    planned: &[PlannedPair],
    given: &[ContactPair],
    multipliers: impl Iterator<Item = usize>,
) -> Vec<PlanEntry> {
    let all = planned.iter().zip(given).zip(multipliers);
    all.map(|((pair, given), multipliers)| PlanEntry {
        what: format!("contact {}", pair.name),
        choice: format!(
            "`{}` carries {multipliers} pressures, gaps by volume",
            given.between[pair.side]
        ),
        reason: pair.reason.to_owned(),
    })
    .collect()
}
