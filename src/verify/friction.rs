//! Slips and tractions of frictional obstacles, face by face:
//!
//! ```text
//! S_m = int psi_m [x - Q x0] da,   f(v) += int t . v,   t = sum_m psi_m t_m
//! s = 0 in the disc, s against t on its edge,   |t| <= r
//! ```
//!
//! by the area of the gaps. x0 is where the increment began, Q x0 where the obstacle's point there is now; in the
//! caller's units. Tractions are numbers in the frames of their points, which the solver says.

use std::ops::Range;

use super::contact::{Faces, pressure_functions};
use super::{nodal_displacement, shapes, turn};
use crate::contact::ContactFace;
use crate::geometry::vector3::{add, dot, scale, sub};
use crate::model::Model;
use crate::model::friction::Friction;
use crate::model::state::State;
use crate::obstacle::Moving;
use crate::saddle::Status;

/// What speaks against the law.
pub(super) struct Misfit {
    /// Numbers of the tractions among the multipliers.
    pub(super) tractions: Range<usize>,
    /// Slip that does not fit its traction, weighted `[tractions]`.
    pub(super) slip: Vec<f64>,
    /// Tractions beyond their bounds, or inside where they slip, a stress `[points]`.
    pub(super) excess: Vec<f64>,
}

/// The misfit of `friction` at `state`; adds its tractions to `force` `[nodes, 3]`.
pub(super) fn residuals(
    friction: &Friction,
    (model, state): (&Model<'_>, &State),
    faces: &Faces<'_, '_>,
    force: &mut [[f64; 3]],
) -> Misfit {
    let stress = model.plan.problem.units.stress;
    let frames = friction.frames(model, state);
    let width = friction.components.count();
    let radii = friction
        .law(model.plan, &state.drive)
        .radii(&state.multiplier);
    let tractions = friction.first..friction.first + friction.size();
    let own = state.multiplier[tractions.clone()].chunks_exact(width);
    let vectors: Vec<[f64; 3]> = (own.clone().zip(&frames))
        .map(|(own, frame)| {
            let parts = own.iter().zip(frame);
            parts.fold([0.0; 3], |sum, (value, tangent)| {
                add(sum, scale(stress * value, *tangent))
            })
        })
        .collect();
    let travels = travels((model, state), faces, &vectors, force);
    let mut misfit = Misfit {
        tractions,
        slip: Vec::new(),
        excess: Vec::new(),
    };
    for (point, (own, frame)) in own.zip(&frames).enumerate() {
        let slip: Vec<f64> = (frame[..width].iter())
            .map(|tangent| dot(*tangent, travels[point]))
            .collect();
        let size = |values: &[f64]| values.iter().fold(0.0, |size: f64, x| size.hypot(*x));
        let push = size(own);
        let along = slip.iter().zip(own).map(|(s, t)| s * t).sum::<f64>() / push;
        let excess = push - radii[point];
        let status = state.status[misfit.tractions.start + point * width];
        let wrong = |(s, t): (&f64, &f64)| match status {
            Status::Open => 0.0,
            Status::Stick => *s,
            Status::Slip if along < 0.0 => s - along * t / push,
            Status::Slip => *s,
        };
        misfit.slip.extend(slip.iter().zip(own).map(wrong));
        misfit.excess.push(match status {
            Status::Slip => stress * excess,
            Status::Stick | Status::Open => stress * excess.max(0.0),
        });
    }
    misfit
}

/// S of the points of contacts between bodies, by the solver's own integrals; adds the forces of their
/// tractions to `force`.
fn between_bodies((model, state): (&Model<'_>, &State), force: &mut [[f64; 3]]) -> Vec<[f64; 3]> {
    let Some(friction) = &model.interfaces.friction else {
        return Vec::new();
    };
    let units = &model.plan.problem.units;
    let frames = friction.frames(model, state);
    let mut pushed = vec![0.0; state.displacement.len()];
    let mut slid = Vec::new();
    for own in friction.between(model, state) {
        let tractions = &state.multiplier[friction.tractions_of(&own.points)];
        let rows = own.sliding.rows.iter();
        for (row, traction) in rows.clone().zip(tractions) {
            for &(unknown, value) in row {
                pushed[unknown as usize] += value * traction * units.force();
            }
        }
        let width = friction.components.count();
        let slips = own.sliding.slips.iter().zip(rows);
        let slips: Vec<f64> = slips
            .map(|(&slip, row)| if row.is_empty() { 0.0 } else { slip })
            .collect();
        for (slips, frame) in slips.chunks_exact(width).zip(&frames[own.points]) {
            let along = slips.iter().zip(frame);
            slid.push(along.fold([0.0; 3], |sum, (slip, tangent)| {
                add(sum, scale(units.length * units.area() * slip, *tangent))
            }));
        }
    }
    let space = &model.prepared.space;
    let nodes = space.node_forces(&pushed);
    for (own, pushed) in force.iter_mut().zip(nodes.chunks_exact(space.components)) {
        own.iter_mut().zip(pushed).for_each(|(sum, x)| *sum += x);
    }
    slid
}

/// S of all points; adds their tractions `vectors` to `force`.
fn travels(
    (model, state): (&Model<'_>, &State),
    faces: &Faces<'_, '_>,
    vectors: &[[f64; 3]],
    force: &mut [[f64; 3]],
) -> Vec<[f64; 3]> {
    let Some(start) = &model.conditions.slip_start else {
        return vec![[0.0; 3]; vectors.len()];
    };
    let length = model.plan.problem.units.length;
    let unit = length * model.plan.problem.units.area();
    let [from, to] =
        [start.drive(), &state.drive].map(|drive| model.interfaces.obstacles(drive, length));
    let before = State {
        displacement: start.displacement().to_vec(),
        ..state.clone()
    };
    let before = nodal_displacement(model, &before);
    let mut all = Vec::with_capacity(vectors.len());
    let mut vectors = vectors;
    for (index, (interface, met)) in model.placed(&state.drive).enumerate() {
        if met.obstacle().is_none() || !model.plan.problem.obstacles[index].is_frictional {
            continue;
        }
        let (own, rest) = vectors.split_at(interface.multipliers.len());
        vectors = rest;
        let surface = &interface.surface;
        let shares = &surface.shares;
        let spread = by_axis(own, |values| shares.spread(values).into_owned());
        let slide = Slide {
            faces,
            before: &before,
            poses: [&from[index], &to[index]],
        };
        let mut sums = vec![[0.0; 3]; surface.carriers.len()];
        for face in &surface.faces {
            slide.add(face, &spread, (&mut sums, force));
        }
        let sums = by_axis(&sums, |values| shares.gather(values.to_vec()));
        let residues = start.residue()[all.len()..].iter();
        let slid = sums
            .iter()
            .zip(residues)
            .map(|(sum, residue)| add(*sum, scale(unit, slide.turned(*residue))));
        let slid: Vec<[f64; 3]> = slid.collect();
        all.extend(slid);
    }
    all.extend(between_bodies((model, state), force));
    all
}

/// Vectors of which each component goes through `map`.
fn by_axis(vectors: &[[f64; 3]], map: impl Fn(&[f64]) -> Vec<f64>) -> Vec<[f64; 3]> {
    let parts = [0, 1, 2].map(|i| {
        let component: Vec<f64> = vectors.iter().map(|vector| vector[i]).collect();
        map(&component)
    });
    (0..parts[0].len())
        .map(|k| [0, 1, 2].map(|i| parts[i][k]))
        .collect()
}

/// Faces of a frictional obstacle that has moved from one pose to another one.
struct Slide<'a, 'f, 'm> {
    faces: &'a Faces<'f, 'm>,
    /// Displacement where the increment began `[nodes, 3]`.
    before: &'a [[f64; 3]],
    poses: [&'a Moving; 2],
}

impl Slide<'_, '_, '_> {
    /// Adds the travel of one face to `sums` `[functions]` and its tractions to `force`.
    fn add(
        &self,
        face: &ContactFace,
        tractions: &[[f64; 3]],
        (sums, force): (&mut [[f64; 3]], &mut [[f64; 3]]),
    ) {
        let faces = self.faces;
        let units = &faces.model.plan.problem.units;
        for (point, weight) in faces.rule.points.iter().zip(&faces.rule.weights) {
            let l = &point[..units.dimension];
            let (values, _) = shapes(l, &[], faces.pairs);
            let (x, radius) = faces.place(face, l, &values);
            let moved = |nodal: &[[f64; 3]]| -> [f64; 3] {
                let parts = face.nodes.iter().zip(&values);
                parts.fold([0.0; 3], |sum, (&node, shape)| {
                    add(sum, scale(*shape, nodal[node as usize]))
                })
            };
            let start = add(sub(x, moved(faces.nodal)), moved(self.before));
            let carried = self.carried(start.map(|x| x / units.length));
            let travel = sub(x, carried.map(|x| x * units.length));
            let area = if faces.model.is_rubber() {
                faces.area(face, l, x[0]).size
            } else {
                faces.measure(face, l) * turn(faces.model, radius)
            };
            let functions = pressure_functions(l, faces.pairs, face.functions.len());
            let mut traction = [0.0; 3];
            for (&m, value) in face.functions.iter().zip(&functions) {
                let sum = &mut sums[m as usize];
                *sum = add(*sum, scale(weight * area * value, travel));
                traction = add(traction, scale(*value, tractions[m as usize]));
            }
            for (&node, shape) in face.nodes.iter().zip(&values) {
                let own = &mut force[node as usize];
                *own = add(*own, scale(weight * area * shape, traction));
            }
        }
    }

    /// A vector of the obstacle, turned as the obstacle has.
    fn turned(&self, vector: [f64; 3]) -> [f64; 3] {
        sub(self.carried(vector), self.carried([0.0; 3]))
    }

    /// Where the obstacle's point at `x` is now.
    fn carried(&self, x: [f64; 3]) -> [f64; 3] {
        let [from, to] = self.poses.map(Moving::motion);
        to.apply(from.inverse_apply(x))
    }
}
