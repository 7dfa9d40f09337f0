//! Smoothing along strongly coupled nodes, around another preconditioner.
//!
//! In stretched cells the couplings along short edges exceed the others by the
//! square of the aspect; node blocks smooth nothing across. Groups of strongly
//! coupled Lagrange nodes (lines through flat cells, planes across tall ones) are
//! solved exactly instead: with F the stiffness restricted to the groups,
//! a few Chebyshev steps around F^-1, `inner`, the same steps again. Symmetric
//! positive definite. The compliance of contact takes blocks of F^-1. The factor of F costs O(n) on
//! lines, O(n^1.5) on planes.
//!
//! U. Trottenberg, C. Oosterlee and A. Schueller, Multigrid, section 5.1 (2001).

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use super::chebyshev::{Chebyshev, Step};
use super::node_pairs::{Block, NodePairs};
use super::spectrum::Lanczos;
use super::{NodeBlocks, Transfer};
use crate::linalg::cholesky::{LowerColumns, Precision};
use crate::linalg::ordering::{Graph, nested_dissection};
use crate::linalg::vector::add_scaled;
use crate::linalg::{LinearOperator, Preconditioner, SparseCholesky, Workspace};

/// Couplings tried, relative to the nodes' own blocks, weakest first: groups that are too large for
/// a line fall apart by the next.
const THRESHOLDS: [f64; 3] = [0.1, 0.2, 0.35];
/// A group with a larger part of the nodes is no group.
const LARGEST_PART: usize = 4;
/// Chebyshev steps before and after.
const DEGREE: usize = 2;
/// Ratio of the ends of the damped interval.
const RATIO: f64 = 6.0;
/// Lanczos steps for the largest eigenvalue.
const LANCZOS_STEPS: usize = 12;
/// Nodes of a group that are asked how they move with it, each by a solution with F a component:
/// three lines that meet at the corner of a layer of 42 cells have fewer. With 64, layers of 12^3
/// cells took 619 to 654 applications, now 15 to 20. The planes of tall cells have more and stay out.
const MOST_IN_A_LINE: u32 = 256;
/// Loads that are solved for together: a layer 2.5 : 2.5 : 1 of 12^3 cells takes 1.42 s one by one, 1.12 s so.
const TOGETHER: usize = 16;
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
    /// The lowest node of the group of each node `[nodes]`.
    of_node: Vec<u32>,
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
        let group_of = groups(nodes)?;
        let matrix = restricted(nodes, &group_of);
        let order = order(nodes, &group_of);
        let factor = SparseCholesky::new(&matrix, &order, Precision::Double).ok()?;
        let groups = Groups {
            factor,
            transfer,
            of_node: group_of,
        };
        let lanczos = Lanczos {
            operator: &*operator,
            preconditioner: &groups,
            held: Some(groups.transfer.held()),
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
        self.groups.factor.bytes() + 4 * self.groups.of_node.len() as u64
    }

    /// How nodes move under loads on them and take their groups along: the diagonal blocks of F^-1,
    /// and those between two nodes that `is_seen` `[nodes]`; `alone` where the group is large. Cost:
    /// one solution with F for each place in the largest group and each component.
    pub fn with_groups(&self, alone: &NodeBlocks, is_seen: &[bool]) -> NodeBlocks {
        let group_of = &self.groups.of_node;
        let places = &places(group_of);
        let (c, nodes) = (alone.components(), group_of.len());
        let mut seen: HashMap<u32, Vec<usize>> = HashMap::new();
        for node in (0..nodes).filter(|&node| is_seen[node] && places[node].is_some()) {
            seen.entry(group_of[node]).or_default().push(node);
        }
        let own = (0..nodes).flat_map(|node| alone.block(node).into_iter().take(c * c));
        let mut own: Vec<f64> = own.collect();
        let mut pairs: BTreeMap<[u32; 2], [f64; 9]> = BTreeMap::new();
        let mut work = Workspace::new();
        let most = places.iter().flatten().copied().max().unwrap_or(0);
        let loads = (0..=most).flat_map(|place| (0..c).map(move |i| (place, i)));
        let loads: Vec<(u32, usize)> = loads.collect();
        let loaded = |place| (0..nodes).filter(move |&node| places[node] == Some(place));
        for batch in loads.chunks(TOGETHER) {
            let mut all = vec![0.0; batch.len() * nodes * c];
            for (x, &(place, i)) in all.chunks_exact_mut(nodes * c).zip(batch) {
                loaded(place).for_each(|node| x[node * c + i] = 1.0);
            }
            self.groups.factor.solve(&mut all, batch.len(), &mut work);
            for (x, &(place, i)) in all.chunks_exact(nodes * c).zip(batch) {
                for node in loaded(place) {
                    for j in 0..c {
                        own[(node * c + j) * c + i] = x[node * c + j];
                    }
                    let others = seen.get(&group_of[node]).filter(|_| is_seen[node]);
                    for &other in others.into_iter().flatten().filter(|&&other| other != node) {
                        let block = pairs.entry([other as u32, node as u32]).or_default();
                        (0..c).for_each(|j| block[j * c + i] = x[other * c + j]);
                    }
                }
            }
        }
        NodeBlocks::of_inverse(c, &own).with_pairs(pairs)
    }

    /// Adds [`DEGREE`] Chebyshev steps to `x` and takes them off `r`, the last
    /// one only where `products` asks for it.
    fn smooth(&self, x: &mut [f64], r: &mut [f64], products: usize, work: &mut Workspace) {
        let mut chebyshev = Chebyshev::new(self.largest / RATIO, self.largest);
        let mut direction = work.zeros(r.len());
        let mut z = work.scratch(r.len());
        for step in 0..DEGREE {
            self.groups.apply(r, &mut z, work);
            let Step { keep, gain } = chebyshev.advance();
            for (d, z) in direction.iter_mut().zip(&z) {
                *d = keep * *d + gain * z;
            }
            add_scaled(x, 1.0, &direction);
            if step < products {
                self.operator.apply(&direction, &mut z, work);
                add_scaled(r, -1.0, &z);
            }
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

/// Place of each node in its group `[nodes]`; none in one of more than [`MOST_IN_A_LINE`].
fn places(group_of: &[u32]) -> Vec<Option<u32>> {
    let mut count = vec![0_u32; group_of.len()];
    let place = |&group: &u32| {
        count[group as usize] += 1;
        count[group as usize] - 1
    };
    let places: Vec<u32> = group_of.iter().map(place).collect();
    let pairs = places.into_iter().zip(group_of);
    pairs
        .map(|(place, &group)| (count[group as usize] <= MOST_IN_A_LINE).then_some(place))
        .collect()
}

/// Frobenius norm of a block.
fn size(block: &Block<3>) -> f64 {
    let squares = block.iter().flatten().map(|value| value * value);
    squares.sum::<f64>().sqrt()
}

/// The lowest node of each node's group: lines where most nodes are in one, small groups where
/// they are not; none where there is neither.
fn groups(nodes: &LagrangeNodes<'_>) -> Option<Vec<u32>> {
    let candidates = THRESHOLDS.map(|threshold| coupled(nodes, threshold));
    let lines = lines(&candidates);
    let sizes = group_sizes(&lines);
    let in_lines = lines
        .iter()
        .filter(|&&group| is_line(sizes[group as usize]));
    if 2 * in_lines.count() >= lines.len() {
        return Some(lines);
    }
    candidates.into_iter().find(|of| are_small(of))
}

/// Whether that many nodes are a line.
fn is_line(nodes: u32) -> bool {
    (2..=MOST_IN_A_LINE).contains(&nodes)
}

/// The groups by the weakest coupling by which each is no larger than a line.
fn lines(candidates: &[Vec<u32>]) -> Vec<u32> {
    let sizes: Vec<Vec<u32>> = candidates.iter().map(|of| group_sizes(of)).collect();
    let of_node = |node: usize| {
        let mut groups = candidates
            .iter()
            .zip(&sizes)
            .map(|(of, sizes)| (of[node], sizes));
        let fitting = groups.find(|&(group, sizes)| sizes[group as usize] <= MOST_IN_A_LINE);
        fitting.map_or_else(
            || candidates[candidates.len() - 1][node],
            |(group, _)| group,
        )
    };
    (0..candidates[0].len()).map(of_node).collect()
}

/// The lowest node of each node's group, which couplings beyond `threshold` connect.
fn coupled(nodes: &LagrangeNodes<'_>, threshold: f64) -> Vec<u32> {
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
    let largest = group_sizes(group_of).into_iter().max().unwrap_or(0) as usize;
    largest > 1 && LARGEST_PART * largest <= group_of.len()
}

/// Nodes of the group that each node is the lowest of `[nodes]`.
fn group_sizes(group_of: &[u32]) -> Vec<u32> {
    let mut sizes = vec![0; group_of.len()];
    let nodes = group_of.iter();
    nodes.for_each(|&group| sizes[group as usize] += 1);
    sizes
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
                let value = if is_held[row] || is_held[column] {
                    f64::from(u8::from(row == column))
                } else {
                    value
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_of_lines_have_places_and_those_of_large_groups_none() {
        let mut group_of = vec![0, 0, 2, 0];
        let places_of_lines = [Some(0), Some(1), Some(0), Some(2)];
        assert_eq!(places(&group_of), places_of_lines);
        group_of.extend(vec![4; MOST_IN_A_LINE as usize + 1]);
        let found = places(&group_of);
        assert_eq!(found[..4], places_of_lines);
        assert!(found[4..].iter().all(Option::is_none));
    }

    #[test]
    fn a_group_too_large_for_a_line_falls_apart_by_the_next_coupling() {
        let large = MOST_IN_A_LINE + 1;
        let weak: Vec<u32> = (0..large).map(|_| 0).chain([large, large]).collect();
        let strong: Vec<u32> = (0..large)
            .map(|node| node / 2 * 2)
            .chain([large, large + 1])
            .collect();
        let found = lines(&[weak, strong.clone()]);
        assert_eq!(found[..large as usize], strong[..large as usize]);
        assert_eq!(found[large as usize..], [large, large]);
    }
}
