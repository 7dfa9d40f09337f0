//! What results say of a body of rubber, cell by cell:
//!
//! ```text
//! sigma = P F^T / J,   J averaged over a cell,   a number that J is nowhere below
//! ```
//!
//! in the caller's units; contact pressure per deformed area. None of it where the
//! scene is linear. Cost: four gradients a cell.

use crate::element::jacobian::{least_jacobian_bound, sharper_jacobian_bound};
use crate::element::quadrature::rule;
use crate::geometry::tensor::{Tensor, plus_unit, product, scaled, transposed};
use crate::linalg::vector::scale;
use crate::material::Rubber;
use crate::model::Model;
use crate::model::loads::simplices;
use crate::model::state::State;
use crate::model::values::{deformation_from_straight, gradient_at, radius_at};
use crate::scene::validate::ON_AXIS;

/// J is a cubic polynomial on a cell.
const JACOBIAN_DEGREE: u32 = 3;

/// The rubber of a cell; none in linear scenes.
pub(crate) fn rubber<'a>(model: &Model<'a>, cell: usize) -> Option<&'a Rubber> {
    let resolved = &model.plan.problem.resolved;
    let material = &resolved.materials[usize::from(resolved.cell_material[cell])];
    material.rubber.as_ref()
}

/// True stress at displacement gradient `h` under internal pressure `pressure`, with
/// `penalty` shear moduli of the volume defect.
pub(crate) fn true_stress(
    rubber: &Rubber,
    h: &Tensor<f64>,
    pressure: f64,
    penalty: f64,
) -> Tensor<f64> {
    let (gradient, jacobian) = (plus_unit(h), 1.0 + rubber.volume_change(h));
    let share = penalty * rubber.shear_modulus() * rubber.volume_defect(h, pressure);
    let nominal = rubber.stress(h, pressure + share);
    scaled(jacobian.recip(), &product(&nominal, &transposed(&gradient)))
}

/// Deformed over undeformed volume of a cell.
pub(crate) fn volume_ratio(model: &Model<'_>, state: &State, cell: usize) -> f64 {
    let (simplex, _) = simplices(model.plan.problem.units.dimension);
    let rule = rule(simplex, JACOBIAN_DEGREE);
    let mean = model.prepared.geometry.radii.get(cell);
    let (mut change, mut whole) = (0.0, 0.0);
    for (point, weight) in rule.points.iter().zip(&rule.weights) {
        let share = mean.map_or(1.0, |mean| radius_at(model, cell, point) / mean);
        let share = weight * share * model.prepared.geometry.curves.measure(cell, point);
        let gradient = gradient_at(model, state, cell, point);
        change += share * rubber(model, cell).map_or(0.0, |law| law.volume_change(&gradient));
        whole += share;
    }
    1.0 + change / whole
}

/// A number that J is nowhere in the body below; none in linear scenes, and where
/// the two bounds of a body of revolution do not show that J is above zero.
pub(crate) fn jacobian_bound(model: &Model<'_>, state: &State) -> Option<f64> {
    if !model.plan.problem.resolved.is_rubber() {
        return None;
    }
    let is_turned = model.plan.is_axisymmetric();
    let cells = 0..model.mesh.cell_count();
    let bounds = cells.map(|cell| {
        if is_turned {
            ring_bound(model, state, cell)
        } else {
            cell_bound(model, state, cell)
        }
    });
    let bound = bounds.reduce(|a, b| if a.is_nan() || a < b { a } else { b });
    bound.filter(|bound| !is_turned || !bound.is_nan())
}

/// The bound of the section times that of the stretch around the axis; NaN where one
/// of them is not above zero.
fn ring_bound(model: &Model<'_>, state: &State, cell: usize) -> f64 {
    let section = cell_bound(model, state, cell);
    let stretch = least_stretch(model, state, cell);
    if section > 0.0 && stretch > 0.0 {
        section * stretch
    } else {
        f64::NAN
    }
}

/// A number that (x + u_x) / x is nowhere in a cell below: the least ratio of the
/// Bernstein coefficients of both, those on the axis left out.
fn least_stretch(model: &Model<'_>, state: &State, cell: usize) -> f64 {
    let space = &model.prepared.space;
    let u = |node: usize| state.displacement[node * space.components];
    let scale = model.plan.problem.units.coordinate_scale;
    let corners = model.mesh.cell(cell);
    let x = |corner: usize| scale * model.mesh.coordinates()[corners[corner] as usize][0];
    let bend = |edge: u32| scale * model.mesh.offset_of(edge as usize)[0];
    let at_corners = (0..corners.len()).map(|a| (x(a), u(corners[a] as usize)));
    let pairs = model.mesh.cell_kind().edges();
    let edges = &model.mesh.cell_edges()[cell * pairs.len()..(cell + 1) * pairs.len()];
    let at_edges = edges.iter().zip(pairs).map(|(&edge, &(a, b))| {
        let ends = u(corners[a] as usize) + u(corners[b] as usize);
        let middle = 2.0 * u(space.vertices + edge as usize);
        (0.5 * (x(a) + x(b)) + 2.0 * bend(edge), 0.5 * ends + middle)
    });
    let off_axis = at_corners.chain(at_edges).filter(|(x, _)| *x > ON_AXIS);
    let stretches = off_axis.map(|(x, moved)| (x + moved) / x);
    stretches.fold(
        f64::INFINITY,
        |a, b| if a.is_nan() || a < b { a } else { b },
    )
}

/// The plain bound where it shows that J is above zero, else the sharper one: of the section, in
/// curved cells that from the straight cell over the most or least that their edges bend it.
fn cell_bound(model: &Model<'_>, state: &State, cell: usize) -> f64 {
    let corners = model.mesh.cell(cell).len();
    let mut gradients = [[[0.0; 3]; 3]; 4];
    for (corner, gradient) in gradients.iter_mut().enumerate().take(corners) {
        let mut at = [0.0; 4];
        at[corner] = 1.0;
        *gradient = deformation_from_straight(model, state, cell, &at);
    }
    let plain = least_jacobian_bound(&gradients[..corners]);
    let bound = if plain > 0.0 {
        plain
    } else {
        sharper_jacobian_bound(&gradients[..corners])
    };
    let bent = model.prepared.geometry.curves.of(cell);
    bound
        / bent.map_or(1.0, |bent| {
            if bound > 0.0 {
                bent.most_measure()
            } else {
                bent.least_measure()
            }
        })
}

/// Coefficients of the contact pressure per undeformed area, interface by interface
/// `[interfaces][functions]`; none in linear scenes.
pub(crate) fn undeformed_pressure(model: &Model<'_>, state: &State) -> Option<Vec<Vec<f64>>> {
    if !model.plan.problem.resolved.is_rubber() {
        return None;
    }
    let body = model.deformed(&state.displacement);
    let unit = model.plan.problem.units.stress;
    let interfaces = model.interfaces.list.iter();
    let all = interfaces.map(|interface| {
        let pressure = interface.own(&state.multiplier);
        let mut undeformed = interface.surface.undeformed_pressure(&body, &pressure);
        scale(&mut undeformed, unit);
        undeformed
    });
    Some(all.collect())
}
