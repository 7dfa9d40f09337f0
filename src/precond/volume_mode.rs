//! What the volume of a body takes off the compliance of its contact surface:
//!
//! ```text
//! K~ = C Y C^T - w w^T / (s + b^T Y b),   Y = P A11^-1 P^T + D^-1,   w = C Y b
//! ```
//!
//! b = B^T 1: the change of the volume of one connected part `[displacement]`;
//! s = 1^T S 1: its volume over the bulk modulus, zero where it is incompressible. Without
//! this term a closed body seems to give way under an even pressure, and the condition
//! of K grows like the bulk over the shear modulus. It is positive definite where s is
//! above zero; `FLOOR` keeps it so. Cost: one P1 solve and one pass over the nodes a
//! part.

use super::NodeBlocks;
use crate::linalg::vector::dot;
use crate::linalg::{Preconditioner, Workspace};

/// Least s over b^T Y b: a P1 factor in single precision knows the difference no better.
const FLOOR: f64 = 1e-5;

/// Y b of a part with its numbers.
#[derive(Clone, Debug)]
pub struct VolumeMode {
    /// One at the pressures of the part, else zero `[pressures]`.
    pub pressures: Vec<f64>,
    /// A11^-1 P^T b `[vertex unknowns]`.
    pub smooth: Vec<f64>,
    /// D^-1 b in the Lagrange basis `[displacement]`: nodes that move alone.
    pub alone: Vec<f64>,
    /// s + b^T Y b, a volume over a modulus.
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
    /// Of a part with these `pressures`, whose volume changes by `change` in the
    /// hierarchical basis and whose pressure takes `slack`; none where it does not change.
    pub fn new(
        flexibility: &Flexibility<'_>,
        (pressures, change): (Vec<f64>, &[f64]),
        slack: f64,
        work: &mut Workspace,
    ) -> Option<Self> {
        let vertices = flexibility.vertex_count * flexibility.node_blocks.components();
        let mut smooth = vec![0.0; vertices];
        flexibility.p1.apply(&change[..vertices], &mut smooth, work);
        let forces = flexibility.on_nodes(change);
        let alone = flexibility.alone(&forces);
        let own = dot(&change[..vertices], &smooth) + dot(&forces, &alone);
        (own > 0.0).then(|| Self {
            pressures,
            smooth,
            alone,
            work: own + slack.max(FLOOR * own),
        })
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
            let rows = self.node_blocks.block(node).chunks_exact(c);
            for (value, row) in moved.iter_mut().zip(rows) {
                *value = dot(row, force);
            }
        }
        moved
    }
}
