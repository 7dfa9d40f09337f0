//! Rigid motions that nothing resists: those of each body which contact alone holds,
//!
//! ```text
//! r = t + w x (x + u),   K r = 0
//! ```
//!
//! Where K r vanishes K says of every motion what it says of the part that is orthogonal to r,
//! so that K is positive there where K + M r (M r)^T / r.M r is positive everywhere. Shapes
//! `[displacement]`. Cost: six products, and an application for each motion found.

use super::QuadraticProgram;
use crate::linalg::eigen::symmetric;
use crate::linalg::vector::{add_scaled, dot, scale};
use crate::linalg::{DenseMatrix, LinearOperator, Preconditioner, Workspace};
use crate::model::Model;
use crate::model::held::mask;
use crate::model::proximal::mass;
use crate::model::state::State;
use crate::scene::validate::parts;

constants! {
    /// What resists the motions instead, in mu / L^2: what the approximate inverse of a body that
    /// nothing holds has for them.
    const RESISTANCE: f64 = 1e-2;
    /// Force of a motion over what resists it instead, in the norms of the approximate inverse, that
    /// is rounding.
    const NONE: f64 = 1e-4;
    /// Length of a motion over its own, less those before it, that is rounding.
    const DEPENDENT: f64 = 1e-8;
}

/// What takes the place of the stiffness that the body lacks.
pub(super) struct RigidModes {
    /// M r of each motion, r of unit length in M `[motions][displacement]`.
    forces: Vec<Vec<f64>>,
}

impl RigidModes {
    /// Adds what resists the motion `x` to `y`.
    pub(super) fn add(&self, x: &[f64], y: &mut [f64]) {
        for force in &self.forces {
            add_scaled(y, RESISTANCE * dot(force, x), force);
        }
    }
}

impl QuadraticProgram<'_> {
    /// The motions on which `stiffness` vanishes; none where supports hold the body.
    pub(super) fn resisted_rigid_modes(
        &self,
        state: &State,
        (stiffness, inverse): (&dyn LinearOperator, &dyn Preconditioner),
        work: &mut Workspace,
    ) -> Option<RigidModes> {
        if !self.model.plan.is_floating() {
            return None;
        }
        let mass = mass(&self.model);
        let motions = orthonormal(rigid_motions(&self.model, state), &mass);
        let forces: Vec<Vec<f64>> = motions
            .iter()
            .map(|motion| {
                let mut force = vec![0.0; motion.len()];
                stiffness.apply(motion, &mut force, work);
                mask(&self.model.prepared.held, &mut force);
                force
            })
            .collect();
        let count = motions.len();
        let mut matrix = DenseMatrix::zeros(count, count);
        for (i, motion) in motions.iter().enumerate() {
            for (j, force) in forces.iter().enumerate() {
                *matrix.at_mut(i, j) = dot(motion, force);
            }
        }
        let vectors = symmetric(&matrix)?;
        let mut rigid_modes = RigidModes { forces: Vec::new() };
        for shares in vectors {
            let force = combination(&shares, &forces);
            let mut moved = work.scratch(force.len());
            inverse.apply(&force, &mut moved, work);
            if dot(&force, &moved).sqrt() <= NONE * RESISTANCE.sqrt() {
                let motion = combination(&shares, &motions);
                let weighted = motion.iter().zip(&mass).map(|(r, m)| r * m);
                rigid_modes.forces.push(weighted.collect());
            }
            work.give(moved);
        }
        Some(rigid_modes)
    }
}

/// The sum of `shares` of `vectors`.
fn combination(shares: &[f64], vectors: &[Vec<f64>]) -> Vec<f64> {
    let mut sum = vec![0.0; vectors.first().map_or(0, Vec::len)];
    for (share, vector) in shares.iter().zip(vectors) {
        add_scaled(&mut sum, *share, vector);
    }
    sum
}

/// The rigid motions of each connected part of the body as it stands, zero where it is held.
fn rigid_motions(model: &Model<'_>, state: &State) -> Vec<Vec<f64>> {
    let whole = rigid_motions_together(model, state);
    let of_vertex = parts(model.mesh);
    let count = of_vertex.iter().max().map_or(0, |&last| last + 1);
    if count <= 1 {
        return whole;
    }
    let space = &model.prepared.space;
    let part_of = |node: usize| match node.checked_sub(space.vertices) {
        None => of_vertex[node],
        Some(edge) => of_vertex[space.edges[edge][0] as usize],
    };
    let own = |part: u32, motion: &Vec<f64>| {
        let mut own = motion.clone();
        let nodes = own.chunks_exact_mut(space.components).enumerate();
        let others = nodes.filter(|(node, _)| part_of(*node) != part);
        others.for_each(|(_, node)| node.fill(0.0));
        own
    };
    let motions = (0..count).flat_map(|part| whole.iter().map(move |motion| own(part, motion)));
    motions.collect()
}

/// The rigid motions of all parts together.
fn rigid_motions_together(model: &Model<'_>, state: &State) -> Vec<Vec<f64>> {
    let axes = |count: usize| (0..count).map(|axis| (axis, 0));
    // A pair is a translation along the first, or a turn from the first axis to the second.
    let pairs: Vec<(usize, usize)> = match model.prepared.space.components {
        2 if model.plan.is_axisymmetric() => vec![(1, 1)],
        2 => axes(2)
            .map(|(axis, _)| (axis, axis))
            .chain([(0, 1)])
            .collect(),
        _ => axes(3)
            .map(|(axis, _)| (axis, axis))
            .chain([(0, 1), (1, 2), (2, 0)])
            .collect(),
    };
    let motions = pairs
        .into_iter()
        .map(|pair| rigid_motion(model, state, pair));
    motions.collect()
}

/// A translation along `from`, where both axes are the same, or the turn from one to the other.
fn rigid_motion(model: &Model<'_>, state: &State, (from, to): (usize, usize)) -> Vec<f64> {
    let space = &model.prepared.space;
    let c = space.components;
    let mut motion = vec![0.0; state.displacement.len()];
    let vertices = model.mesh.coordinates().len();
    for (node, own) in motion.chunks_exact_mut(c).enumerate() {
        // Corrections of edges turn, and have no place of their own.
        let place = model.place(node, &state.displacement);
        if from != to {
            (own[from], own[to]) = (-place[to], place[from]);
        } else if node < vertices {
            own[from] = 1.0;
        }
    }
    mask(&model.prepared.held, &mut motion);
    motion
}

/// `motions` made orthogonal and of unit length in `mass`; what is left of none is dropped.
fn orthonormal(motions: Vec<Vec<f64>>, mass: &[f64]) -> Vec<Vec<f64>> {
    let product = |a: &[f64], b: &[f64]| -> f64 {
        let terms = a.iter().zip(b).zip(mass);
        terms.map(|((a, b), m)| a * b * m).sum()
    };
    let mut found: Vec<Vec<f64>> = Vec::new();
    for mut motion in motions {
        let before = product(&motion, &motion).sqrt();
        for _ in 0..2 {
            for other in &found {
                let share = product(&motion, other);
                add_scaled(&mut motion, -share, other);
            }
        }
        let length = product(&motion, &motion).sqrt();
        if length > DEPENDENT * before {
            scale(&mut motion, 1.0 / length);
            found.push(motion);
        }
    }
    found
}
