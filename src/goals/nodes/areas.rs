//! What the places of vertices do to undeformed areas: of the contact of linear bodies, and of dead
//! tractions,
//!
//! ```text
//! L = int f dS,   f = m d + l n . v  or  t . z,   dL/dX_b = int f d(dS)/dX_b
//! ```
//!
//! d the distance, n the normal, v the motion that pressures l do work on, m the dual pressures. About
//! an axis the radius is in the measure. Non-dimensional. Cost: one probe a point of the rule.

use super::add_share;
use crate::assembly::load::shape_values;
use crate::contact::gap::Deformed;
use crate::contact::{ContactSurface, Counterpart, FaceFields, values_at_points};
use crate::element::quadrature::rule;
use crate::geometry::vector3::{cross, dot, norm, scale, sub};
use crate::model::Model;
use crate::model::loads::simplices;
use crate::model::state::State;

/// Degree of a traction times quadratic functions, times a radius.
const TRACTION_DEGREE: u32 = 3;

/// Adds what areas do in m . g - l . C v of a surface.
pub(super) fn add_contact<C: Counterpart + ?Sized>(
    body: &Deformed<'_>,
    (surface, met): (&ContactSurface, &C),
    at: FaceFields<'_>,
    sums: &mut [[f64; 3]],
) {
    let values = values_at_points(body, surface, met, at);
    let points = body.rule.len();
    for (face, own) in surface.faces.iter().zip(values.chunks_exact(points)) {
        let places = places(body.mesh, body.scale, &face.corners);
        let area = Area::new(&places, face.radii.is_some());
        let points = body.rule.points.iter().zip(&body.rule.weights).zip(own);
        for ((point, weight), value) in points {
            area.add((point, weight * value), &face.corners, sums);
        }
    }
}

/// Adds what areas do in z . f of dead tractions.
pub(super) fn add_tractions(
    model: &Model<'_>,
    state: &State,
    motion: &[f64],
    sums: &mut [[f64; 3]],
) {
    let problem = &model.plan.problem;
    let facet = simplices(problem.units.dimension).1;
    let rule = rule(facet, TRACTION_DEGREE);
    let (space, c) = (&model.prepared.space, model.prepared.space.components);
    for traction in &problem.resolved.tractions {
        let force = scale(state.drive.load / problem.units.stress, traction.value);
        for &index in &traction.facets {
            let vertices = model.mesh.facet(index as usize);
            let places = places(model.mesh, problem.units.coordinate_scale, vertices);
            let area = Area::new(&places, model.plan.is_axisymmetric());
            let nodes = space.facet_nodes(vertices);
            for (point, weight) in rule.points.iter().zip(&rule.weights) {
                let shapes = shape_values(&point[..vertices.len()]);
                let mut value = 0.0;
                for (node, shape) in nodes.iter().zip(shapes) {
                    let own = &motion[*node as usize * c..(*node as usize + 1) * c];
                    let along: f64 = own.iter().zip(force).map(|(z, t)| z * t).sum();
                    value += shape * along;
                }
                area.add((point, weight * value), vertices, sums);
            }
        }
    }
}

fn places(mesh: &crate::mesh::Mesh, factor: f64, vertices: &[u32]) -> Vec<[f64; 3]> {
    let coordinates = mesh.coordinates();
    let places = vertices.iter();
    places
        .map(|&vertex| scale(factor, coordinates[vertex as usize]))
        .collect()
}

/// A straight face: its area and how that changes with its corners.
struct Area {
    size: f64,
    /// `[corners]`.
    slopes: Vec<[f64; 3]>,
    /// Radii of the ends; none where nothing turns.
    radii: Option<[f64; 2]>,
}

impl Area {
    fn new(places: &[[f64; 3]], is_turned: bool) -> Self {
        let unit = |v: [f64; 3]| scale(1.0 / norm(v), v);
        match places {
            [a, b] => {
                let along = sub(*b, *a);
                let direction = unit(along);
                Self {
                    size: norm(along),
                    slopes: vec![scale(-1.0, direction), direction],
                    radii: is_turned.then_some([a[0], b[0]]),
                }
            }
            [a, b, c] => {
                let twice = cross(sub(*b, *a), sub(*c, *a));
                let normal = unit(twice);
                let slope = |from: [f64; 3], to: [f64; 3]| scale(0.5, cross(normal, sub(to, from)));
                Self {
                    size: 0.5 * norm(twice),
                    slopes: vec![slope(*b, *c), slope(*c, *a), slope(*a, *b)],
                    radii: None,
                }
            }
            _ => Self {
                size: 0.0,
                slopes: Vec::new(),
                radii: None,
            },
        }
    }

    /// Adds `value` times the derivative of the measure at a point of the face.
    fn add(&self, (point, value): (&[f64; 4], f64), corners: &[u32], sums: &mut [[f64; 3]]) {
        let radius = self
            .radii
            .map(|radii| dot([radii[0], radii[1], 0.0], [point[0], point[1], 0.0]));
        let turn = radius.map_or(1.0, |radius| std::f64::consts::TAU * radius);
        for ((&corner, slope), share) in corners.iter().zip(&self.slopes).zip(point) {
            let sum = &mut sums[corner as usize];
            add_share(sum, value * turn, *slope);
            if radius.is_some() {
                sum[0] += value * std::f64::consts::TAU * share * self.size;
            }
        }
    }
}
