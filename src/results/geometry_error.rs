//! How far flat facets are from the surface that they stand for, over how far contact has
//! pushed it:
//!
//! ```text
//! geometry error = largest sagitta of a facet in contact / squeeze,   sagitta = h^2 kappa / 8
//! squeeze = largest N . R^T (x + u - R x - t) at a vertex of such a facet
//! ```
//!
//! R and t the rigid motion of the body: R the rotation next to its displacement, t that of
//! what is held, or else of the body. Where the error is not small, forces and pressures
//! are those of the polygon, which no estimate of the discretisation error sees. None where
//! the facets are flat in fact, where the mesh or the scene gives the true surface, or
//! without contact. Cost: one pass over the vertices.

use crate::contact::ContactFace;
use crate::geometry::rigid_motion::{Matrix3, multiply};
use crate::geometry::tensor::{cofactor, contract, plus, scaled};
use crate::geometry::vector3::{add, dot, scale, sub};
use crate::model::Model;
use crate::model::interfaces::Interface;
use crate::model::state::State;

/// Steps of Newton's method towards the rotation next to a matrix; it squares the error.
const POLAR_STEPS: usize = 12;

/// The error of the facets of `interface` in contact.
pub(crate) fn geometry_error(
    model: &Model<'_>,
    state: &State,
    interface: &Interface,
) -> Option<f64> {
    if interface.sagittas.is_empty() {
        return None;
    }
    let rigid = Rigid::of(model, state);
    let (mut sagitta, mut squeeze) = (0.0_f64, 0.0_f64);
    for (face, own) in closed(state, interface) {
        sagitta = sagitta.max(own * model.plan.problem.units.coordinate_scale);
        let normal = multiply(&rigid.rotation, face.normal);
        for &corner in &face.corners {
            let pushed = rigid.rest(model, state, corner as usize);
            squeeze = squeeze.max(dot(normal, pushed).abs());
        }
    }
    (squeeze > 0.0).then(|| sagitta / squeeze)
}

/// The largest sagitta of the facets of `interface` in contact, non-dimensional; zero where they are those of the
/// true surface.
pub(crate) fn largest_sagitta(model: &Model<'_>, state: &State, interface: &Interface) -> f64 {
    let own = closed(state, interface).map(|(_, sagitta)| *sagitta);
    own.fold(0.0, f64::max) * model.plan.problem.units.coordinate_scale
}

/// Faces in contact with their sagittas; none where the facets are the true surface.
fn closed<'a>(
    state: &'a State,
    interface: &'a Interface,
) -> impl Iterator<Item = (&'a ContactFace, &'a f64)> {
    let faces = interface.surface.faces.iter().zip(&interface.sagittas);
    faces.filter(|(face, _)| {
        let functions = face.functions.iter();
        let mut multipliers = functions.flat_map(|&k| interface.surface.shares.of(k));
        multipliers.any(|(m, _)| {
            let place = interface.multipliers[m as usize] as usize;
            state.status[place].is_closed()
        })
    })
}

/// The rigid motion of a body, non-dimensional.
struct Rigid {
    rotation: Matrix3,
    translation: [f64; 3],
}

impl Rigid {
    fn of(model: &Model<'_>, state: &State) -> Self {
        let vertices = 0..model.mesh.coordinates().len();
        let count = vertices.len() as f64;
        let mean = |of: fn([[f64; 3]; 2]) -> [f64; 3]| {
            let points = vertices.clone().map(|v| of(place(model, state, v)));
            scale(1.0 / count, points.fold([0.0; 3], add))
        };
        let (before, after) = (mean(|[x, _]| x), mean(|[_, x]| x));
        let mut moment = [[0.0; 3]; 3];
        for vertex in vertices.clone() {
            let [x, moved] = place(model, state, vertex);
            let (x, moved) = (sub(x, before), sub(moved, after));
            for (row, moved) in moment.iter_mut().zip(moved) {
                row.iter_mut().zip(x).for_each(|(sum, x)| *sum += moved * x);
            }
        }
        if model.prepared.space.components == 2 {
            moment[2][2] = moment[0][0].abs() + moment[1][1].abs();
        }
        let rotation = nearest_rotation(moment);
        let free = sub(after, multiply(&rotation, before));
        let translation = translation(model, state, (&rotation, free));
        Self {
            rotation,
            translation,
        }
    }

    /// How far a vertex has gone beyond the rigid motion.
    fn rest(&self, model: &Model<'_>, state: &State, vertex: usize) -> [f64; 3] {
        let [x, moved] = place(model, state, vertex);
        sub(moved, add(multiply(&self.rotation, x), self.translation))
    }
}

/// Means of x + u - R x over the vertices at which a component is held, else `free`.
fn translation(
    model: &Model<'_>,
    state: &State,
    (rotation, free): (&Matrix3, [f64; 3]),
) -> [f64; 3] {
    let components = model.prepared.space.components;
    let is_held = &model.prepared.is_held;
    std::array::from_fn(|i| {
        let vertices = 0..model.mesh.coordinates().len();
        let held = vertices.filter(|v| i < components && is_held[v * components + i]);
        let (mut sum, mut count) = (0.0, 0.0_f64);
        for vertex in held {
            let [x, moved] = place(model, state, vertex);
            sum += sub(moved, multiply(rotation, x))[i];
            count += 1.0;
        }
        if count > 0.0 { sum / count } else { free[i] }
    })
}

/// A vertex before and after the displacement, non-dimensional.
fn place(model: &Model<'_>, state: &State, vertex: usize) -> [[f64; 3]; 2] {
    let components = model.prepared.space.components;
    let x = scale(
        model.plan.problem.units.coordinate_scale,
        model.mesh.coordinates()[vertex],
    );
    let own = &state.displacement[vertex * components..(vertex + 1) * components];
    let moved = std::array::from_fn(|i| x[i] + own.get(i).copied().unwrap_or(0.0));
    [x, moved]
}

/// The rotation next to `matrix`, by Newton's method; the identity for a reflection.
fn nearest_rotation(matrix: Matrix3) -> Matrix3 {
    const UNTURNED: Matrix3 = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let size = contract(&matrix, &matrix).sqrt();
    let mut rotation = scaled(1.0 / size, &matrix);
    for _ in 0..POLAR_STEPS {
        let adjoint = cofactor(&rotation);
        let determinant = contract(&rotation, &adjoint) / 3.0;
        if determinant.is_nan() || determinant <= 1e-12 {
            return UNTURNED;
        }
        rotation = scaled(0.5, &plus(&rotation, 1.0 / determinant, &adjoint));
    }
    rotation
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::rigid_motion::rotation_matrix;
    use crate::geometry::tensor::product;

    #[test]
    fn the_rotation_next_to_a_stretched_one_is_that_one() {
        let turned = rotation_matrix([0.4, -2.0, 1.1]);
        let stretch = [[1.3, 0.1, 0.0], [0.1, 0.8, -0.2], [0.0, -0.2, 0.6]];
        let found = nearest_rotation(product(&turned, &stretch));
        for (found, row) in found.iter().zip(turned) {
            assert!(sub(*found, row).iter().all(|x| x.abs() < 1e-13));
        }
    }

    #[test]
    fn a_plane_body_that_is_a_line_does_not_turn() {
        assert_eq!(nearest_rotation([[0.0; 3]; 3])[0][1].to_bits(), 0);
    }
}
