//! The rigid motion that supports make together, and the body carried along with
//! them before anything is solved:
//!
//! ```text
//! x + u  ->  R (x + u) + t,   (R, t) = m_1 m_0^-1,   R a for vectors a
//! ```
//!
//! m_0 and m_1 are the motions of a support before and after, or of the obstacles where
//! no support moves. Supports share the motion if the rows of (R, t) that belong to the
//! components they hold are those of their own; where they turn, those of R alone, with
//! t of the first that moves. What is left of the motion of supports, and obstacles
//! that do not go along, are for the programs. Pressures and multipliers do not feel a
//! rigid motion. Cost: some 20 flops a node.

use crate::geometry::rigid_motion::{Matrix3, RigidMotion, multiply};
use crate::geometry::tensor::{product, transposed};
use crate::geometry::vector3::{add, max_norm, scale, sub};
use crate::model::Model;
use crate::model::drive::Drive;

constants! {
    /// Difference of two motions, angles and parts of the body's length, below which they
    /// are the same.
    const SAME: f64 = 1e-9;
}
/// The identity: no rotation.
const UNTURNED: Matrix3 = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// A rigid motion of points in space, non-dimensional.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RigidPredictor {
    /// Rotation as a matrix about the origin of space.
    rotation: Matrix3,
    /// Translation after the rotation `[3]`, in units of the scaled body.
    translation: [f64; 3],
}

impl RigidPredictor {
    /// What the supports of a body share on the way between two drives; none where
    /// they do not, or do not move.
    pub(crate) fn between(model: &Model<'_>, from: &Drive, to: &Drive) -> Option<Self> {
        let length = model.plan.problem.units.length;
        let motions = from.motions.iter().zip(&to.motions);
        let own: Vec<_> = motions
            .map(|(from, to)| Self::of(from, to, length))
            .collect();
        let shared = match own.iter().find(|own| !own.is_rest()) {
            Some(own) => *own,
            None => Self::of_obstacles(model, from, to)?,
        };
        let components = model.prepared.space.components;
        let guides = own.iter().zip(&model.plan.problem.resolved.supports);
        let mut guides = guides
            .filter(|(_, support)| !support.patches.is_empty() || !support.oblique.is_empty());
        let is_guided = guides.all(|(own, _)| own.is(&shared));
        let is_shared = is_guided
            && model.plan.problem.held.iter().all(|&(unknown, support)| {
                let row = unknown as usize % components;
                own.get(usize::from(support))
                    .is_none_or(|own| own.goes_along(&shared, row))
            });
        is_shared.then_some(shared)
    }

    /// What all obstacles share; none where they do not, or do not move.
    fn of_obstacles(model: &Model<'_>, from: &Drive, to: &Drive) -> Option<Self> {
        let length = model.plan.problem.units.length;
        let poses = [from, to].map(|drive| model.interfaces.obstacles(drive, length));
        let motions = poses[0].iter().zip(&poses[1]);
        let mut own = motions.map(|(from, to)| Self::of(&from.motion(), &to.motion(), 1.0));
        let shared = own.next().filter(|own| !own.is_rest())?;
        own.all(|own| own.is(&shared)).then_some(shared)
    }

    /// The rigid motion that leads from one pose to another; `length` makes it
    /// non-dimensional.
    fn of(from: &RigidMotion, to: &RigidMotion, length: f64) -> Self {
        let origin = to.apply(from.inverse_apply([0.0; 3]));
        Self {
            rotation: product(&to.matrix(), &transposed(&from.matrix())),
            translation: scale(length.recip(), origin),
        }
    }

    /// Whether it moves nothing, to rounding.
    fn is_rest(&self) -> bool {
        self.is(&Self {
            rotation: UNTURNED,
            translation: [0.0; 3],
        })
    }

    /// Whether a support with this motion may share `shared` in one component.
    fn goes_along(&self, shared: &Self, row: usize) -> bool {
        let is_turn = (0..3).any(|row| !shared.turns_like(&UNTURNED, row));
        self.turns_like(&shared.rotation, row) && (is_turn || self.shifts_like(shared, row))
    }

    /// Whether both motions are the same, to rounding.
    fn is(&self, other: &Self) -> bool {
        (0..3).all(|row| self.turns_like(&other.rotation, row) && self.shifts_like(other, row))
    }

    /// Whether one row of the rotations is the same, to rounding.
    fn turns_like(&self, rotation: &Matrix3, row: usize) -> bool {
        let difference = sub(self.rotation[row], rotation[row]);
        max_norm(difference) <= SAME
    }

    /// Whether one component of the translations is the same, to rounding.
    fn shifts_like(&self, other: &Self, row: usize) -> bool {
        (self.translation[row] - other.translation[row]).abs() <= SAME
    }

    /// Carries a body displaced by `displacement`, hierarchical.
    pub(crate) fn apply(&self, model: &Model<'_>, displacement: &mut [f64]) {
        let space = &model.prepared.space;
        let (on_vertices, on_edges) = displacement.split_at_mut(space.vertices * space.components);
        let coordinates = model.mesh.coordinates();
        let nodes = on_vertices.chunks_exact_mut(space.components);
        for (u, x) in nodes.zip(coordinates) {
            let x = scale(model.plan.problem.units.coordinate_scale, *x);
            let moved = add(
                multiply(&self.rotation, add(x, padded(u))),
                self.translation,
            );
            u.copy_from_slice(&sub(moved, x)[..u.len()]);
        }
        self.turn(space.components, on_edges);
        if model.mesh.edge_offsets().is_empty() {
            return;
        }
        // The middle of a curved edge is o + u from that of its ends: R (o + u) - o.
        for (edge, u) in on_edges.chunks_exact_mut(space.components).enumerate() {
            let offset = scale(
                model.plan.problem.units.coordinate_scale,
                model.mesh.offset_of(edge),
            );
            let turned = sub(multiply(&self.rotation, offset), offset);
            u.iter_mut().zip(turned).for_each(|(u, part)| *u += part);
        }
    }

    /// Turns vectors at nodes.
    pub(crate) fn turn(&self, components: usize, vectors: &mut [f64]) {
        for vector in vectors.chunks_exact_mut(components) {
            let turned = multiply(&self.rotation, padded(vector));
            vector.copy_from_slice(&turned[..components]);
        }
    }
}

/// The components of a node padded to three with zeros.
fn padded(vector: &[f64]) -> [f64; 3] {
    std::array::from_fn(|i| vector.get(i).copied().unwrap_or(0.0))
}
