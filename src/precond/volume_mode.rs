//! What volume takes off the compliance of a body's contact surface:
//!
//! ```text
//! K~ = C Y C^T - sum_k w_k w_k^T / W_k,   Y = P A11^-1 P^T + D^-1,   w_k = C Y b_k
//! ```
//!
//! b_k = B^T z_k: the change of the volume that the pressures z_k weigh `[displacement]`:
//! that of a connected part (z = 1), and where a body is thin those of its stretches, made
//! orthogonal, b_j.Y b_k + z_j.S z_k = W_k on the diagonal. S is the volume over the bulk
//! modulus, zero where the body is incompressible. Without these terms a closed body seems
//! to give way under an even pressure and a thin bonded one to let its volume pass below
//! the contact, and the condition of K grows like the bulk over the shear modulus, or like
//! the square of length over thickness. It is positive definite where S is above zero;
//! `FLOOR` keeps it so. Cost: one P1 solve and one pass over the nodes a mode.

use super::NodeBlocks;
use crate::linalg::vector::{add_scaled, dot};
use crate::linalg::{Preconditioner, Workspace};

/// Least s over b^T Y b: a P1 factor in single precision knows the difference no better.
const FLOOR: f64 = 1e-5;

/// Share of a mode's own work below which it is made of the earlier ones.
const DEPENDENT: f64 = 1e-6;

/// Y b of a mode with its numbers.
#[derive(Clone, Debug)]
pub struct VolumeMode {
    /// z `[pressures]`: of a part one at its own, else zero.
    pub pressures: Vec<f64>,
    /// A11^-1 P^T b `[vertex unknowns]`.
    pub smooth: Vec<f64>,
    /// D^-1 b in the Lagrange basis `[displacement]`: nodes that move alone.
    pub alone: Vec<f64>,
    /// W, a volume over a modulus.
    pub work: f64,
}

/// What Y is made of.
pub struct Flexibility<'a> {
    /// A11^-1 `[vertex unknowns]`.
    pub p1: &'a dyn Preconditioner,
    /// Inverted Lagrange node blocks of all nodes.
    pub node_blocks: &'a NodeBlocks,
    /// Number of vertices: nodes below are vertices, the others edges.
    pub vertex_count: usize,
    /// Ends of each edge `[edges]`, where vertices that move alone count, too; see
    /// [`super::compliance`].
    pub edge_ends: Option<&'a [[u32; 2]]>,
    /// Which unknowns are prescribed `[displacement]`.
    pub is_held: &'a [bool],
}

impl VolumeMode {
    /// Of these `pressures`, that change volumes by `change` in the hierarchical basis and
    /// take `slack`, their product with S `[pressures]`; what `earlier` modes know is taken
    /// off. None where nothing is left.
    pub fn new(
        flexibility: &Flexibility<'_>,
        (pressures, change, slack): (Vec<f64>, &[f64], &[f64]),
        earlier: &[Self],
        work: &mut Workspace,
    ) -> Option<Self> {
        let vertices = flexibility.vertex_count * flexibility.node_blocks.components();
        let mut smooth = vec![0.0; vertices];
        flexibility.p1.apply(&change[..vertices], &mut smooth, work);
        let forces = flexibility.on_nodes(change);
        let alone = flexibility.alone(&forces);
        let own = dot(&change[..vertices], &smooth) + dot(&forces, &alone);
        let whole = own + dot(&pressures, slack).max(FLOOR * own);
        let mut mode = Self {
            pressures,
            smooth,
            alone,
            work: whole,
        };
        for known in earlier {
            let common = dot(&change[..vertices], &known.smooth)
                + dot(&forces, &known.alone)
                + dot(slack, &known.pressures);
            mode.take_off(known, common / known.work);
        }
        (mode.work > DEPENDENT * whole).then_some(mode)
    }

    /// Takes a share of an orthogonal mode off.
    fn take_off(&mut self, other: &Self, share: f64) {
        add_scaled(&mut self.pressures, -share, &other.pressures);
        add_scaled(&mut self.smooth, -share, &other.smooth);
        add_scaled(&mut self.alone, -share, &other.alone);
        self.work -= share * share * other.work;
    }
}

impl Flexibility<'_> {
    /// The load on nodes that move alone: at a vertex less half of those at its edges.
    fn on_nodes(&self, load: &[f64]) -> Vec<f64> {
        let c = self.node_blocks.components();
        let mut forces = load.to_vec();
        match self.edge_ends {
            None => forces[..self.vertex_count * c].fill(0.0),
            Some(ends) => {
                for (edge, ends) in ends.iter().enumerate() {
                    let first = (self.vertex_count + edge) * c;
                    for (i, value) in load[first..first + c].iter().enumerate() {
                        ends.iter()
                            .for_each(|&end| forces[end as usize * c + i] -= 0.5 * value);
                    }
                }
            }
        }
        for (force, &is_held) in forces.iter_mut().zip(self.is_held) {
            if is_held {
                *force = 0.0;
            }
        }
        forces
    }

    /// D^-1 `forces`, node by node.
    fn alone(&self, forces: &[f64]) -> Vec<f64> {
        let c = self.node_blocks.components();
        let mut moved = vec![0.0; forces.len()];
        let nodes = moved.chunks_exact_mut(c).zip(forces.chunks_exact(c));
        for (node, (moved, force)) in nodes.enumerate() {
            let block = self.node_blocks.block(node);
            let rows = block.chunks_exact(c);
            for (value, row) in moved.iter_mut().zip(rows) {
                *value = dot(row, force);
            }
        }
        moved
    }
}
