//! Estimates of the discretisation error of a state:
//!
//! ```text
//! theta^2 = eta^2 / (|u_h|^2 + eta^2),   |v|^2 = int 2 mu |eps(v)|^2 + lambda (div v)^2
//! |F_h - F| ~ theta^2 max(|F_h|, sqrt(k) |u_h|)
//! ```
//!
//! eta comes from the recovered strain ([`crate::assembly::recovery`]), regions
//! being the materials. In mixed forms the volume term is left out: the pressure
//! carries it.
//!
//! The contact force F of an obstacle is a(u, z) with z the body's answer to a
//! unit motion of the obstacle and k = |z|^2 its stiffness. The error of F is
//! a(u - u_h, z - z_h): at most the product of two norms, and theta^2 sqrt(k) |u|
//! where z is resolved as well as u is. k is that of a rigid punch on a half-space
//! with the present contact area A: 2 E* sqrt(A / pi), in the plane E* / 2, E* =
//! 2 mu / (1 - nu). This is no bound, and it does not see that flat faces stand
//! for a curved surface. Non-dimensional.

use std::f64::consts::PI;

use crate::assembly::recovery::{CellSquares, Recovery};
use crate::contact::Resultant;
use crate::model::Model;
use crate::model::ending::Estimate;
use crate::model::interfaces::Interface;
use crate::model::state::State;

/// mu and lambda of a cell's energy norm.
pub(crate) fn moduli(model: &Model<'_>, cell: usize) -> [f64; 2] {
    let resolved = &model.plan.resolved;
    let law = resolved.materials[usize::from(resolved.cell_material[cell])].law;
    let stress = model.plan.units.stress;
    let lame = match model.plan.is_mixed() {
        true => 0.0,
        false => law.lame() / stress,
    };
    [law.shear_modulus / stress, lame]
}

/// Squares of the error and of u cell by cell, and their sum.
fn squares(model: &Model<'_>, state: &State) -> (CellSquares, f64) {
    let cells = 0..model.mesh.cell_count();
    let moduli: Vec<[f64; 2]> = cells.map(|cell| moduli(model, cell)).collect();
    let recovery = Recovery {
        mesh: model.mesh,
        scale: model.plan.units.coordinate_scale,
        space: &model.prepared.space,
        geometry: &model.prepared.geometry,
        regions: &model.plan.resolved.cell_material,
        moduli: &moduli,
        displacement: &state.displacement,
    };
    let squares = recovery.squares();
    let whole = squares.energy.iter().sum::<f64>() + squares.error.iter().sum::<f64>();
    // A body at rest has no error.
    (squares, whole.max(f64::MIN_POSITIVE))
}

/// Estimates the error of `state`.
pub(crate) fn estimate(model: &Model<'_>, state: &State) -> Estimate {
    let (squares, whole) = squares(model, state);
    Estimate {
        relative: (squares.error.iter().sum::<f64>() / whole).sqrt(),
        norm: whole.sqrt(),
    }
}

/// Each cell's part of theta: the squares add up to theta^2 `[cells]`.
pub(crate) fn cell_estimates(model: &Model<'_>, state: &State) -> Vec<f64> {
    let (squares, whole) = squares(model, state);
    squares.error.iter().map(|e| (e / whole).sqrt()).collect()
}

/// Estimated error of the length of an obstacle's force.
pub(crate) fn force_error(
    model: &Model<'_>,
    interface: &Interface,
    found: &Resultant,
    estimate: &Estimate,
) -> f64 {
    let force = found.force.iter().map(|x| x * x).sum::<f64>().sqrt();
    let modulus = contact_modulus(model, interface);
    let stiffness = punch_stiffness(model.plan.units.dimension, modulus, found.area);
    estimate.relative.powi(2) * force.max(stiffness.sqrt() * estimate.norm)
}

/// Largest E* = 2 mu / (1 - nu) behind the surface of an interface.
pub(crate) fn contact_modulus(model: &Model<'_>, interface: &Interface) -> f64 {
    let resolved = &model.plan.resolved;
    let facets = interface.facets.iter();
    let materials = facets.map(|&facet| {
        let cell = model.mesh.facet_cell(facet as usize).0;
        usize::from(resolved.cell_material[cell])
    });
    let moduli = materials.map(|material| {
        let law = resolved.materials[material].law;
        2.0 * law.shear_modulus / model.plan.units.stress / (1.0 - law.poisson_ratio())
    });
    moduli.fold(0.0, f64::max)
}

/// Force per indentation of a rigid punch of this area; per thickness in the
/// plane, where it depends on distant supports too.
pub(crate) fn punch_stiffness(dimension: usize, modulus: f64, area: f64) -> f64 {
    match dimension {
        2 => 0.5 * modulus * f64::from(u8::from(area > 0.0)),
        _ => 2.0 * modulus * (area / PI).sqrt(),
    }
}
