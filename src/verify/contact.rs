//! Weighted gaps and contact forces, face by face:
//!
//! ```text
//! g_m = int psi_m d(x + u),   f(v) += int lambda n . v,   lambda = sum_m lambda_m psi_m
//! ```
//!
//! over the undeformed surface, for bodies of finite strain over the deformed one, whose change
//! adds int lambda d (da/du) . v to the force; in the caller's units.

use std::f64::consts::TAU;

use super::{shapes, turn};
use crate::contact::{ContactFace, Counterpart, Places};
use crate::element::quadrature::{Rule, Simplex, rule};
use crate::geometry::vector3::{add, cross, norm, sub};
use crate::mesh::CurvedFacet;
use crate::model::Model;
use crate::model::interfaces::Interface;
use crate::model::placed::Placed;
use crate::model::state::State;
use crate::obstacle::{Contact, Derivatives};

/// Another rule on the faces than the solver's own would change the discrete
/// problem; this is the degree that the contract names.
const FACE_DEGREE: u32 = 8;
/// Degree where the curvature of an obstacle jumps.
const KINKED_DEGREE: u32 = 16;

/// Weighted gaps, those of tractions zero, and contact pressures `[multipliers]`; adds the contact force to
/// `force` `[nodes, 3]`.
pub(super) fn residuals(
    faces: &Faces<'_, '_>,
    state: &State,
    force: &mut [[f64; 3]],
) -> (Vec<f64>, Vec<f64>) {
    let model = faces.model;
    let units = &model.plan.problem.units;
    let pressure: Vec<f64> = state.multiplier.iter().map(|l| l * units.stress).collect();
    let mut gap = vec![0.0; pressure.len()];
    for (interface, met) in model.placed(&state.drive) {
        let surface = &interface.surface;
        if !met.is_by_points() {
            let own = between_bodies((model, state), (interface, &met), force);
            interface.add_own(&own, &mut gap);
            continue;
        }
        let coefficients = interface.coefficients(&pressure);
        let mut integrals = vec![0.0; surface.carriers.len()];
        for face in &surface.faces {
            let sums = (&mut integrals[..], &mut *force);
            faces.add(face, &met, &coefficients, sums);
        }
        interface.add_own(&surface.shares.gather(integrals), &mut gap);
    }
    for interface in &model.interfaces.list {
        for &multiplier in &interface.idle {
            gap[interface.multipliers[multiplier as usize] as usize] = 0.0;
        }
    }
    (gap, pressure)
}

/// Gaps between two bodies, and their force on `force` `[nodes, 3]`, by the solver's own integrals:
/// those have their checks in closed curves and differences.
fn between_bodies(
    (model, state): (&Model<'_>, &State),
    (interface, met): (&Interface, &Placed),
    force: &mut [[f64; 3]],
) -> Vec<f64> {
    let units = &model.plan.problem.units;
    let body = model.deformed(&state.displacement);
    let free = vec![false; state.displacement.len()];
    let part = met.linearise(&body, &interface.surface, &free);
    let mut pushed = vec![0.0; state.displacement.len()];
    for (row, pressure) in part
        .rows
        .iter()
        .zip(interface.own(&state.multiplier).iter())
    {
        for &(unknown, value) in row {
            pushed[unknown as usize] -= value * pressure * units.force();
        }
    }
    let space = &model.prepared.space;
    let nodes = space.node_forces(&pushed);
    for (own, pushed) in force.iter_mut().zip(nodes.chunks_exact(space.components)) {
        own.iter_mut().zip(pushed).for_each(|(sum, x)| *sum += x);
    }
    let unit = units.area() * units.length;
    part.gap.iter().map(|gap| gap * unit).collect()
}

/// Faces of a body displaced by `nodal` and how they are integrated.
pub(super) struct Faces<'a, 'm> {
    pub(super) model: &'a Model<'m>,
    pub(super) nodal: &'a [[f64; 3]],
    pub(super) rule: Rule,
    /// Ends of the edges of a face.
    pub(super) pairs: &'a [(usize, usize)],
}

impl<'a, 'm> Faces<'a, 'm> {
    /// Of the body of `model`.
    pub(super) fn new(model: &'a Model<'m>, nodal: &'a [[f64; 3]]) -> Self {
        let (simplex, pairs): (_, &[(usize, usize)]) = match model.plan.problem.units.dimension {
            2 => (Simplex::Segment, &[(0, 1)]),
            _ => (Simplex::Triangle, &[(0, 1), (0, 2), (1, 2)]),
        };
        let mut shapes = model.plan.problem.obstacles.iter().map(|one| &one.shape);
        let degree = if shapes.all(|shape| shape.is_smooth()) {
            FACE_DEGREE
        } else {
            KINKED_DEGREE
        };
        Self {
            model,
            nodal,
            rule: rule(simplex, degree),
            pairs,
        }
    }

    /// Adds one face that meets `met`; pressures and gaps are those of the functions of
    /// its interface.
    fn add(
        &self,
        face: &ContactFace,
        met: &dyn Counterpart,
        pressure: &[f64],
        (gap, force): (&mut [f64], &mut [[f64; 3]]),
    ) {
        let units = &self.model.plan.problem.units;
        for (point, weight) in self.rule.points.iter().zip(&self.rule.weights) {
            let l = &point[..units.dimension];
            let (values, _) = shapes(l, &[], self.pairs);
            let (x, radius) = self.place(face, l, &values);
            let deformed = (self.model.is_rubber()).then(|| self.area(face, l, x[0]));
            let area = match &deformed {
                Some(deformed) => deformed.size,
                None => self.measure(face, l) * turn(self.model, radius),
            };
            let mut contact = [Contact::default()];
            let places = Places {
                coordinates: &[*point],
                deformed: &[x.map(|x| x / units.length)],
            };
            met.probe_on(face, places, Derivatives::Normal, &mut contact);
            let [contact] = contact;
            let functions = pressure_functions(l, self.pairs, face.functions.len());
            let at = face.functions.iter().zip(&functions);
            let local: f64 = at.clone().map(|(&m, l)| l * pressure[m as usize]).sum();
            for (&m, l) in at {
                gap[m as usize] += weight * area * l * contact.distance * units.length;
            }
            for (&node, shape) in face.nodes.iter().zip(&values) {
                for i in 0..3 {
                    force[node as usize][i] += weight * area * shape * local * contact.normal[i];
                }
            }
            if let Some(deformed) = &deformed {
                let change = weight * local * contact.distance * units.length;
                let at = (l, deformed, change);
                self.add_change(face, at, force);
            }
        }
    }

    /// Area or, where the way around is that of each point, length.
    pub(super) fn measure(&self, face: &ContactFace, l: &[f64]) -> f64 {
        let units = &self.model.plan.problem.units;
        if let Some(curve) = &face.curve {
            let unit = match units.dimension {
                2 => units.length,
                _ => units.area(),
            };
            return curved_measure(curve, l) * unit;
        }
        match face.radii {
            None => face.area * units.area(),
            Some([a, b]) => face.area / (0.5 * TAU * (a + b)) * units.length,
        }
    }

    /// The displaced point with coordinates `l`, and the undeformed radius; `values`
    /// are those of the shape functions.
    pub(super) fn place(&self, face: &ContactFace, l: &[f64], values: &[f64]) -> ([f64; 3], f64) {
        let units = &self.model.plan.problem.units;
        let scale = units.coordinate_scale * units.length;
        let mut x = [0.0; 3];
        for (&vertex, l) in face.corners.iter().zip(l) {
            let corner = self.model.mesh.coordinates()[vertex as usize];
            (0..3).for_each(|i| x[i] += l * corner[i] * scale);
        }
        let offsets = face.curve.iter().flat_map(|curve| curve.offsets);
        for (value, offset) in values[l.len()..].iter().zip(offsets) {
            x = add(x, offset.map(|o| value * o * units.length));
        }
        let radius = x[0];
        for (&node, shape) in face.nodes.iter().zip(values) {
            (0..3).for_each(|i| x[i] += shape * self.nodal[node as usize][i]);
        }
        (x, radius)
    }
}

/// Area (length in 2D) per weight of a rule at `l`, undeformed, without any turn: by central
/// differences of the position, which is quadratic.
fn curved_measure(curve: &CurvedFacet, l: &[f64]) -> f64 {
    let along = |end: usize| {
        let moved = |by: f64| {
            let mut l = l.to_vec();
            l[0] -= by;
            l[end] += by;
            curve.position(&l)
        };
        sub(moved(0.5), moved(-0.5))
    };
    match l.len() {
        2 => norm(along(1)),
        _ => 0.5 * norm(cross(along(1), along(2))),
    }
}

/// The functions of the contact pressure at a point: hats, or the quadratic Bernstein
/// polynomials of vertices and edges.
pub(super) fn pressure_functions(l: &[f64], pairs: &[(usize, usize)], count: usize) -> Vec<f64> {
    if count == l.len() {
        return l.to_vec();
    }
    let vertices = l.iter().map(|l| l * l);
    vertices
        .chain(pairs.iter().map(|&(a, b)| 2.0 * l[a] * l[b]))
        .collect()
}
