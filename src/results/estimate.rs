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
//! 2 mu / (1 - nu). Energies, theta and E* are those of the connected parts of the body that
//! the obstacle presses. This is no bound, and it does not see that flat faces stand for a
//! curved surface. Non-dimensional.

use std::f64::consts::PI;

use crate::assembly::recovery::{CellSquares, Recovery};
use crate::contact::Resultant;
use crate::model::Model;
use crate::model::ending::Estimate;
use crate::model::interfaces::Interface;
use crate::model::state::State;
use crate::scene::validate::parts;

/// mu and lambda of a cell's energy norm.
pub(crate) fn moduli(model: &Model<'_>, cell: usize) -> [f64; 2] {
    let resolved = &model.plan.problem.resolved;
    let law = resolved.materials[usize::from(resolved.cell_material[cell])].law;
    let stress = model.plan.problem.units.stress;
    let lame = if model.plan.is_mixed() {
        0.0
    } else {
        law.lame() / stress
    };
    [law.shear_modulus / stress, lame]
}

/// Squares of the error and of u cell by cell.
fn squares(model: &Model<'_>, state: &State) -> CellSquares {
    let cells = 0..model.mesh.cell_count();
    let moduli: Vec<[f64; 2]> = cells.map(|cell| moduli(model, cell)).collect();
    let recovery = Recovery {
        mesh: model.mesh,
        scale: model.plan.problem.units.coordinate_scale,
        space: &model.prepared.space,
        geometry: &model.prepared.geometry,
        regions: &model.plan.problem.resolved.cell_material,
        moduli: &moduli,
        displacement: &state.displacement,
        pressure: &[],
    };
    recovery.squares()
}

/// Square of the norm with the error included; a body at rest has no error.
fn whole([error, energy]: [f64; 2]) -> f64 {
    (energy + error).max(f64::MIN_POSITIVE)
}

/// theta and the norm from the squares of error and displacement.
fn in_norms(squares: [f64; 2]) -> [f64; 2] {
    let whole = whole(squares);
    [(squares[0] / whole).sqrt(), whole.sqrt()]
}

/// Sums over all cells.
fn sums(squares: &CellSquares) -> [f64; 2] {
    [&squares.error, &squares.energy].map(|all| all.iter().sum())
}

/// Estimates the error of `state`.
pub(crate) fn estimate(model: &Model<'_>, state: &State) -> Estimate {
    let squares = squares(model, state);
    let [relative, norm] = in_norms(sums(&squares));
    Estimate {
        relative,
        norm,
        parts: by_part(model, &squares),
    }
}

/// Sums over the cells of each connected part `[parts]`.
fn by_part(model: &Model<'_>, squares: &CellSquares) -> Vec<[f64; 2]> {
    let part_of = parts(model.mesh);
    let count = part_of.iter().max().map_or(0, |&last| last as usize + 1);
    let mut sums = vec![[0.0; 2]; count];
    for (cell, (error, energy)) in squares.error.iter().zip(&squares.energy).enumerate() {
        let part = part_of[model.mesh.cell(cell)[0] as usize] as usize;
        sums[part][0] += error;
        sums[part][1] += energy;
    }
    sums
}

/// Each cell's part of theta: the squares add up to theta^2 `[cells]`.
pub(crate) fn cell_estimates(model: &Model<'_>, state: &State) -> Vec<f64> {
    let squares = squares(model, state);
    let whole = whole(sums(&squares));
    squares.error.iter().map(|e| (e / whole).sqrt()).collect()
}

/// Estimated error of the length of an obstacle's force `found` on the `pressed` facets.
pub(crate) fn force_error(
    model: &Model<'_>,
    (found, pressed): (&Resultant, &[u32]),
    estimate: &Estimate,
) -> f64 {
    let force = found.force.iter().map(|x| x * x).sum::<f64>().sqrt();
    let modulus = modulus_behind(model, pressed);
    let stiffness = punch_stiffness(model.plan.problem.units.dimension, modulus, found.area);
    let [relative, norm] = in_norms(of_touched(model, pressed, estimate));
    relative.powi(2) * force.max(stiffness.sqrt() * norm)
}

/// Squares of error and displacement in the parts of the body that own some `facets`.
fn of_touched(model: &Model<'_>, facets: &[u32], estimate: &Estimate) -> [f64; 2] {
    let part_of = parts(model.mesh);
    let mut is_touched = vec![false; estimate.parts.len()];
    for &facet in facets {
        let cell = model.mesh.facet_cell(facet as usize).0;
        is_touched[part_of[model.mesh.cell(cell)[0] as usize] as usize] = true;
    }
    let touched = estimate.parts.iter().zip(is_touched);
    let touched = touched.filter(|(_, is_touched)| *is_touched);
    touched.fold([0.0; 2], |[error, energy], (part, _)| {
        [error + part[0], energy + part[1]]
    })
}

/// Largest E* = 2 mu / (1 - nu) behind the surface of an interface.
pub(crate) fn contact_modulus(model: &Model<'_>, interface: &Interface) -> f64 {
    modulus_behind(model, &interface.facets)
}

/// Largest E* behind some facets.
fn modulus_behind(model: &Model<'_>, facets: &[u32]) -> f64 {
    let resolved = &model.plan.problem.resolved;
    let materials = facets.iter().map(|&facet| {
        let cell = model.mesh.facet_cell(facet as usize).0;
        usize::from(resolved.cell_material[cell])
    });
    let moduli = materials.map(|material| {
        let law = resolved.materials[material].law;
        2.0 * law.shear_modulus / model.plan.problem.units.stress / (1.0 - law.poisson_ratio())
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
