//! Smoothing along strongly coupled nodes, around another preconditioner.
//!
//! In stretched cells the couplings along short edges exceed the others by the
//! square of the aspect; node blocks smooth nothing across. Groups of strongly
//! coupled Lagrange nodes (lines through flat cells, planes across tall ones) are
//! solved exactly instead: with F the stiffness restricted to the groups,
//! a few Chebyshev steps around F^-1, `inner`, the same steps again. Symmetric
//! positive definite. The factor of F costs O(n) on lines, O(n^1.5) on planes.
//!
//! U. Trottenberg, C. Oosterlee and A. Schueller, Multigrid, section 5.1 (2001).

use std::sync::Arc;

use super::Transfer;
use super::node_pairs::{Block, NodePairs};
use super::spectrum::Lanczos;
use crate::linalg::cholesky::{LowerColumns, Precision};
use crate::linalg::ordering::{Graph, nested_dissection};
use crate::linalg::vector::add_scaled;
use crate::linalg::{LinearOperator, Preconditioner, SparseCholesky, Workspace};

/// Couplings tried, relative to the nodes' own blocks: the weakest that leaves
/// small groups.
const THRESHOLDS: [f64; 3] = [0.1, 0.2, 0.35];
/// A group with a larger part of the nodes is no group.
const LARGEST_PART: usize = 4;
/// Chebyshev steps before and after.
const DEGREE: usize = 2;
/// Ratio of the ends of the damped interval.
const RATIO: f64 = 6.0;
/// Lanczos steps for the largest eigenvalue.
const LANCZOS_STEPS: usize = 12;
/// The Lanczos process approaches it from below.
const SAFETY: f64 = 1.05;

/// The stiffness by Lagrange nodes.
#[derive(Clone, Copy, Debug)]
pub struct LagrangeNodes<'a> {
    /// Components of a node: 2 or 3.
    pub components: usize,
    /// Undeformed position of each node `[nodes]`: vertices, then midpoints of edges.
    pub coordinates: &'a [[f64; 3]],
    /// Diagonal blocks of the nodes and couplings of pairs of them.
    pub blocks: NodePairs<'a>,
    /// Indices of held unknowns, ascending.
    pub held: &'a [u32],
}

/// `inner` between two smoothings along strongly coupled nodes.
pub struct AlongLines {
    /// A `[unknowns, unknowns]`.
    operator: Arc<dyn LinearOperator>,
    /// The preconditioner between the two smoothings.
    inner: Arc<dyn Preconditioner>,
    /// Exact inverses on groups of strongly coupled nodes.
    groups: Groups,
    /// Largest eigenvalue of the groups' product with A, by which a smoothing is
    /// damped.
    largest: f64,
}

/// F^-1 in the hierarchical basis.
struct Groups {
    /// Cholesky factor of A restricted to the groups, in Lagrange's basis.
    factor: SparseCholesky,
    /// The way between the hierarchical basis and Lagrange's.
    transfer: Transfer,
}

impl AlongLines {
    /// Around `inner`; none where the nodes do not fall into groups. `operator`
    /// acts on hierarchical values.
    pub fn new(
        nodes: &LagrangeNodes<'_>,
        operator: Arc<dyn LinearOperator>,
        transfer: Transfer,
        inner: Arc<dyn Preconditioner>,
    ) -> Option<Self> {
        let group_of = THRESHOLDS
            .iter()
            .map(|&threshold| groups(nodes, threshold))
            .find(|group_of| are_small(group_of))?;
        let matrix = restricted(nodes, &group_of);
        let order = order(nodes, &group_of);
        let factor = SparseCholesky::new(&matrix, &order, Precision::Double).ok()?;
        let groups = Groups { factor, transfer };
        let lanczos = Lanczos {
            operator: &*operator,
            preconditioner: &groups,
            held: groups.transfer.held(),
            steps: LANCZOS_STEPS,
        };
        let interval = lanczos.interval(&mut Workspace::new());
        Some(Self {
            operator,
            inner,
            largest: SAFETY * interval.largest,
            groups,
        })
    }

    /// Bytes held besides those of `inner`.
    pub fn bytes(&self) -> u64 {
        self.groups.factor.bytes()
    }

    /// Adds [`DEGREE`] Chebyshev steps to `x` and takes them off `r`, the last
    /// one only where `products` asks for it.
    fn smooth(&self, x: &mut [f64], r: &mut [f64], products: usize, work: &mut Workspace) {
        let (low, high) = (self.largest / RATIO, self.largest);
        let (centre, half) = (0.5 * (high + low), 0.5 * (high - low));
        let sigma = centre / half;
        let mut rho = 1.0 / sigma;
        let (mut keep, mut gain) = (0.0, 1.0 / centre);
        let mut direction = work.zeros(r.len());
        let mut z = work.scratch(r.len());
        for step in 0..DEGREE {
            self.groups.apply(r, &mut z, work);
            for (d, z) in direction.iter_mut().zip(&z) {
                *d = keep * *d + gain * z;
            }
            add_scaled(x, 1.0, &direction);
            if step < products {
                self.operator.apply(&direction, &mut z, work);
                add_scaled(r, -1.0, &z);
            }
            let next = 1.0 / (2.0 * sigma - rho);
            (keep, gain) = (next * rho, 2.0 * next / half);
            rho = next;
        }
        work.give(direction);
        work.give(z);
    }
}

impl Preconditioner for AlongLines {
    fn apply(&self, r: &[f64], z: &mut [f64], work: &mut Workspace) {
        let mut rest = work.copy(r);
        z.fill(0.0);
        self.smooth(z, &mut rest, DEGREE, work);
        let mut part = work.scratch(r.len());
        let mut product = work.scratch(r.len());
        self.inner.apply(&rest, &mut part, work);
        self.operator.apply(&part, &mut product, work);
        add_scaled(z, 1.0, &part);
        add_scaled(&mut rest, -1.0, &product);
        self.smooth(z, &mut rest, DEGREE - 1, work);
        for vector in [rest, part, product] {
            work.give(vector);
        }
    }
}

impl Preconditioner for Groups {
    fn apply(&self, r: &[f64], z: &mut [f64], work: &mut Workspace) {
        let mut values = work.scratch(r.len());
        self.transfer.residual_to_lagrange(1.0, r, &mut values);
        self.factor.solve(&mut values, 1, work);
        self.transfer.values_to_hierarchical(1.0, &values, z);
        work.give(values);
    }
}

/// Frobenius norm of a block.
fn size(block: &Block<3>) -> f64 {
    let squares = block.iter().flatten().map(|value| value * value);
    squares.sum::<f64>().sqrt()
}

/// The lowest node of each node's group.
fn groups(nodes: &LagrangeNodes<'_>, threshold: f64) -> Vec<u32> {
    let own: Vec<f64> = nodes
        .blocks
        .diagonal
        .iter()
        .map(|block| size(block).sqrt())
        .collect();
    let mut parent: Vec<u32> = (0..own.len() as u32).collect();
    for (&[a, b], block) in nodes.blocks.pairs.iter().zip(nodes.blocks.off) {
        if size(block) > threshold * own[a as usize] * own[b as usize] {
            let (a, b) = (root(&mut parent, a), root(&mut parent, b));
            parent[a.max(b) as usize] = a.min(b);
        }
    }
    (0..parent.len() as u32)
        .map(|node| root(&mut parent, node))
        .collect()
}

/// The representative of the group that holds `node`; halves the path on its way.
fn root(parent: &mut [u32], mut node: u32) -> u32 {
    while parent[node as usize] != node {
        let above = parent[parent[node as usize] as usize];
        parent[node as usize] = above;
        node = above;
    }
    node
}

/// Whether groups are worth factorising: none is a large part of the body, and one has
/// several nodes.
fn are_small(group_of: &[u32]) -> bool {
    let mut sizes = vec![0_usize; group_of.len()];
    group_of
        .iter()
        .for_each(|&group| sizes[group as usize] += 1);
    let largest = sizes.into_iter().max().unwrap_or(0);
    largest > 1 && LARGEST_PART * largest <= group_of.len()
}

/// F: held components are the identity, pairs across groups are left out.
fn restricted(nodes: &LagrangeNodes<'_>, group_of: &[u32]) -> LowerColumns {
    let c = nodes.components;
    let mut is_held = vec![false; c * nodes.blocks.diagonal.len()];
    nodes
        .held
        .iter()
        .for_each(|&unknown| is_held[unknown as usize] = true);
    let mut matrix = LowerColumns {
        offsets: vec![0],
        ..LowerColumns::default()
    };
    let mut pairs = nodes.blocks.pairs.iter().zip(nodes.blocks.off).peekable();
    for (node, diagonal) in nodes.blocks.diagonal.iter().enumerate() {
        let mut below = Vec::new();
        while let Some((ends, block)) = pairs.next_if(|(ends, _)| ends[0] as usize == node) {
            if group_of[ends[0] as usize] == group_of[ends[1] as usize] {
                below.push((ends[1] as usize, block));
            }
        }
        for j in 0..c {
            let column = node * c + j;
            let mut push = |row: usize, value: f64| {
                let value = match is_held[row] || is_held[column] {
                    true => f64::from(u8::from(row == column)),
                    false => value,
                };
                matrix.rows.push(row as u32);
                matrix.values.push(value);
            };
            (j..c).for_each(|i| push(node * c + i, diagonal[i][j]));
            for &(other, block) in &below {
                (0..c).for_each(|i| push(other * c + i, block[j][i]));
            }
            matrix.offsets.push(matrix.rows.len() as u32);
        }
    }
    matrix
}

/// Elimination order of the unknowns: groups are dissected together, since they
/// do not touch each other.
fn order(nodes: &LagrangeNodes<'_>, group_of: &[u32]) -> Vec<u32> {
    let within = |pair: &&[u32; 2]| group_of[pair[0] as usize] == group_of[pair[1] as usize];
    let pairs: Vec<[u32; 2]> = nodes.blocks.pairs.iter().filter(within).copied().collect();
    let graph = Graph::from_edges(group_of.len(), &pairs);
    let c = nodes.components as u32;
    nested_dissection(nodes.coordinates, &graph, &[])
        .into_iter()
        .flat_map(|node| (0..c).map(move |i| node * c + i))
        .collect()
}
