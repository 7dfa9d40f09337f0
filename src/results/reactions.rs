//! What supports exert on the body:
//!
//! ```text
//! F = sum_a f_a,   M = sum_a (x_a + u_a - c) x f_a
//! ```
//!
//! over the nodes that a support holds; f = internal force plus contact less load in held rows,
//! of the Lagrange functions, and c the reference point of the support: `about`, the origin where
//! nothing has given one, moved by its translation. About an axis of revolution moments of a full turn are zero; of
//! flows, whose u is a velocity, they are left at zero, too.
//! Cost: one visit a held node, one probe a point of guides.

use std::collections::BTreeMap;

use super::nodal_force::{contact_force, reaction};
use super::touching::Touching;
use crate::geometry::rigid_motion::RigidMotion;
use crate::geometry::vector3::{add, cross, scale, sub};
use crate::model::Model;
use crate::model::state::State;
use crate::report::SupportResult;

/// Forces and moments of the supports by their numbers, non-dimensional.
struct Sums<'a> {
    model: &'a Model<'a>,
    /// Displacement of the nodes `[nodes * components]`.
    moved: Vec<f64>,
    /// Reference points `[supports]`.
    about: Vec<[f64; 3]>,
    results: Vec<SupportResult>,
}

impl<'a> Sums<'a> {
    fn new(model: &'a Model<'a>, state: &State) -> Self {
        let length = model.plan.problem.units.length;
        let motions = state.drive.motions.iter();
        let reference = |one: &RigidMotion| scale(1.0 / length, one.about_moved());
        let about: Vec<[f64; 3]> = motions.map(reference).collect();
        Self {
            model,
            moved: model.prepared.space.node_values(&state.displacement),
            results: vec![SupportResult::default(); about.len()],
            about,
        }
    }

    /// Place of a node in the deformed body.
    fn place(&self, node: usize) -> [f64; 3] {
        let space = &self.model.prepared.space;
        let rest = space.node_place(self.model.mesh, node as u32);
        let scale = self.model.plan.problem.units.coordinate_scale;
        let mut place = rest.map(|x| scale * x);
        let moved = self.moved.iter().skip(node * space.components);
        let moved = moved.take(space.components);
        place.iter_mut().zip(moved).for_each(|(x, u)| *x += u);
        place
    }

    /// Adds a force on a node; what the axis of a body of revolution holds is no support's.
    fn add(&mut self, support: usize, node: usize, force: [f64; 3]) {
        let place = self.place(node);
        if let (Some(sum), Some(about)) = (self.results.get_mut(support), self.about.get(support)) {
            sum.force = add(sum.force, force);
            sum.moment = add(sum.moment, cross(sub(place, *about), force));
        }
    }

    /// Adds the `nodal` forces `[nodes * components]` to the supports that hold the nodes.
    fn add_nodal(&mut self, nodal: &[f64]) {
        let problem = &self.model.plan.problem;
        let components = self.model.prepared.space.components;
        for &(unknown, support) in &problem.held {
            let Some(value) = nodal.get(unknown as usize) else {
                continue;
            };
            let mut force = [0.0; 3];
            force[unknown as usize % components] = *value;
            let node = unknown as usize / components;
            self.add(usize::from(support), node, force);
        }
        for one in &problem.held_nodes {
            for (plane, own) in one.planes.iter().zip(one.reactions(components, nodal)) {
                self.add(usize::from(plane.support), one.held.node as usize, own);
            }
        }
    }
}

/// Reactions of all supports by name, in the caller's units; `internal` are the forces of the
/// body `[displacement]`.
pub(crate) fn reactions(
    model: &Model<'_>,
    state: &State,
    internal: Vec<f64>,
) -> BTreeMap<String, SupportResult> {
    let reaction = reaction(model, state, internal, &contact_force(model, state));
    let mut sums = Sums::new(model, state);
    sums.add_nodal(&model.prepared.space.node_forces(&reaction));
    let touching = Touching::of(model, state);
    let supports = &model.plan.problem.resolved.supports;
    let units = &model.plan.problem.units;
    let has_moments = !model.plan.is_axisymmetric() && !model.plan.problem.resolved.is_flow();
    let pairs = sums
        .results
        .iter()
        .zip(&sums.about)
        .zip(&state.drive.motions);
    let of_support = |((own, about), motion): ((&SupportResult, &[f64; 3]), &RigidMotion),
                      name: &str| {
        let [force, moment] = touching.guided(name, *about);
        SupportResult {
            translation: motion.translation,
            rotation: motion.rotation,
            reference_point: motion.about_moved(),
            force: scale(units.force(), add(own.force, force)),
            moment: if has_moments {
                scale(units.energy(), add(own.moment, moment))
            } else {
                [0.0; 3]
            },
        }
    };
    supports
        .iter()
        .zip(pairs)
        .map(|(support, pair)| (support.name.clone(), of_support(pair, &support.name)))
        .collect()
}
