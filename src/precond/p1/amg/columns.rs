//! Columns of A11^-1 by the cycle, for the metric of the contact pressure.
//!
//! ```text
//! D^T C D = sum_l X_l^T (B_l + R_l) + B_L^T A_L^-1 B_L,
//! X_l = S_l B_l,  R_l = B_l - A_l X_l,  B_(l+1) = P_l^T R_l,  B_0 = D
//! ```
//!
//! C: one V-cycle, S_l its smoother, D the unit traces of the contact surface
//! `[unknowns, traces]`: symmetric, positive, between 1/2 and 1 times the exact
//! block on good meshes. Only the way down is gone, and each column is kept on the
//! nodes that it has reached: the smoother's polynomial reaches few rings of
//! neighbours on a level. Columns of traces that lie together share their nodes and
//! the way through the matrices. Pieces run in parallel with the same bits for any
//! number of threads. Cost in flops, of 2208 traces on 37 k vertices: 7 M a trace, and
//! 9 k a pair of traces.

use std::sync::atomic::{AtomicBool, Ordering};

use super::aggregate::NONE;
use super::block_rows::{BlockRows, Lanes, Pattern, add_block_product, wide};
use super::coarsest::Coarsest;
use super::cycle::{Hierarchy, Level};
use super::smoother::{DEGREE, RowStep};
use crate::linalg::{DenseMatrix, Scalar};
use crate::parallel::{self, Pieces, Scratch};
use crate::precond::p1::Traces;

/// Columns that share nodes. Loops over sixteen are unrolled whole, and slower.
const LANES: usize = 64;

/// The values of a piece of columns at one node.
type Node<S, const N: usize> = [Lanes<S, LANES>; N];

/// A product of two pieces `[LANES, LANES]`.
type Product<S> = [Lanes<S, LANES>; LANES];

/// A piece of columns on the nodes where they are not zero.
struct Piece<S, const N: usize> {
    /// Ascending.
    nodes: Vec<u32>,
    /// `[nodes]`
    values: Vec<Node<S, N>>,
}

/// What one piece adds to the products of a level.
struct Share<S, const N: usize> {
    /// Ascending.
    nodes: Vec<u32>,
    /// X `[nodes]`.
    moved: Vec<Node<S, N>>,
    /// B + R `[nodes]`.
    weights: Vec<Node<S, N>>,
}

/// D^T C D, or none when `proceed` says no between two pieces of columns.
pub(super) fn compliance<S: Scalar, const N: usize, const K: usize>(
    cycle: &Hierarchy<S, N, K>,
    traces: &Traces<'_>,
    proceed: &(dyn Fn() -> bool + Sync),
) -> Option<DenseMatrix> {
    let order = by_groups(cycle, traces);
    let own = order.chunks(LANES);
    let pieces: Vec<Piece<S, N>> = own.map(|own| unit_traces(traces, own)).collect();
    let mut products = Products::new(pieces.len(), proceed);
    let mut pieces = products.descend(&cycle.finest, &pieces)?;
    for level in &cycle.coarser {
        pieces = products.descend(level, &pieces)?;
    }
    products.finish(&cycle.coarsest, pieces)?;
    Some(products.matrix(&order))
}

/// All traces, those of a coarse group together, within it those of a finer one.
fn by_groups<S: Scalar, const N: usize, const K: usize>(
    cycle: &Hierarchy<S, N, K>,
    traces: &Traces<'_>,
) -> Vec<usize> {
    let mut of_trace: Vec<Vec<u32>> = traces.vertices.iter().map(|&v| vec![v]).collect();
    for groups in &mut of_trace {
        groups.push(main_group(&cycle.finest.prolongation, groups[0]));
        for level in &cycle.coarser {
            groups.push(main_group(&level.prolongation, groups[groups.len() - 1]));
        }
        groups.reverse();
    }
    let mut order: Vec<usize> = (0..of_trace.len()).collect();
    order.sort_by(|&a, &b| of_trace[a].cmp(&of_trace[b]).then(a.cmp(&b)));
    order
}

/// The group that moves a node most.
fn main_group<S: Scalar, const N: usize, const K: usize>(
    prolongation: &BlockRows<S, N, K>,
    node: u32,
) -> u32 {
    if node == NONE {
        return NONE;
    }
    let (groups, blocks) = prolongation.row(node as usize);
    let mut most = (0.0, NONE);
    for (&group, block) in groups.iter().zip(blocks) {
        let entries = block.iter().flatten();
        let size = entries.map(|entry| entry.widen() * entry.widen()).sum();
        if size > most.0 {
            most = (size, group);
        }
    }
    most.1
}

/// The columns of D that belong to traces `own`.
fn unit_traces<S: Scalar, const N: usize>(traces: &Traces<'_>, own: &[usize]) -> Piece<S, N> {
    let mut nodes: Vec<u32> = own.iter().map(|&trace| traces.vertices[trace]).collect();
    nodes.sort_unstable();
    nodes.dedup();
    let mut values = vec![[[S::default(); LANES]; N]; nodes.len()];
    for (lane, &trace) in own.iter().enumerate() {
        let place = nodes.partition_point(|&node| node < traces.vertices[trace]);
        for (value, direction) in values[place].iter_mut().zip(traces.directions[trace]) {
            value[lane] = S::narrow(direction);
        }
    }
    Piece { nodes, values }
}

/// The sums over the levels, and who may stop them.
struct Products<'a, S> {
    /// Piece by piece, with those up to it.
    lower: Vec<Vec<Product<S>>>,
    proceed: &'a (dyn Fn() -> bool + Sync),
}

impl<'a, S: Scalar> Products<'a, S> {
    fn new(pieces: usize, proceed: &'a (dyn Fn() -> bool + Sync)) -> Self {
        let zero = [[S::default(); LANES]; LANES];
        Self {
            lower: (1..=pieces).map(|count| vec![zero; count]).collect(),
            proceed,
        }
    }

    /// Adds what a level gives, and takes the columns to the next one.
    fn descend<const N: usize, const K: usize>(
        &mut self,
        level: &Level<S, N, K>,
        pieces: &[Piece<S, N>],
    ) -> Option<Vec<Piece<S, K>>> {
        let places = || Places::new(level.matrix.rows());
        let scratch = Scratch::new(&places);
        let smoothed = parallel::map(pieces.len(), 1, &|k| {
            (self.proceed)().then(|| scratch.lend(|places| smoothed(level, &pieces[k], places)))
        });
        let smoothed: Option<Vec<_>> = smoothed.into_iter().collect();
        let (shares, next): (Vec<_>, Vec<_>) = smoothed?.into_iter().unzip();
        self.add(&shares, level.matrix.rows())?;
        Some(next)
    }

    /// Adds what the coarsest level gives.
    fn finish<const K: usize>(
        &mut self,
        coarsest: &Coarsest<S>,
        pieces: Vec<Piece<S, K>>,
    ) -> Option<()> {
        let rows = coarsest.size() / K;
        let share = |k: usize| {
            let piece = &pieces[k];
            let mut weights = vec![[[S::default(); LANES]; K]; rows];
            for (&node, value) in piece.nodes.iter().zip(&piece.values) {
                weights[node as usize] = *value;
            }
            let mut moved = vec![[[S::default(); LANES]; K]; rows];
            coarsest.solve::<LANES>(
                weights.as_flattened().as_flattened(),
                moved.as_flattened_mut().as_flattened_mut(),
            );
            Share {
                nodes: (0..rows as u32).collect(),
                moved,
                weights,
            }
        };
        let shares: Vec<Share<S, K>> = parallel::map(pieces.len(), 1, &share);
        self.add(&shares, rows)
    }

    /// Adds the products X^T (B + R) of a level of `rows` nodes.
    fn add<const N: usize>(&mut self, shares: &[Share<S, N>], rows: usize) -> Option<()> {
        let (proceed, is_stopped) = (self.proceed, AtomicBool::new(false));
        let fresh = || Places::new(rows);
        let scratch = Scratch::new(&fresh);
        parallel::each(Pieces::of(&mut self.lower, 1), 1, &|k, products| {
            if !proceed() {
                return is_stopped.store(true, Ordering::Relaxed);
            }
            let own = &shares[k];
            scratch.lend(|places| {
                places.mark(&own.nodes);
                let products = products.iter_mut().flatten().zip(shares);
                products.for_each(|(product, other)| add_product(product, own, other, places));
                places.clear(&own.nodes);
            });
        });
        (!is_stopped.into_inner()).then_some(())
    }

    /// The matrix of all traces, whose pieces are `order`'s.
    fn matrix(&self, order: &[usize]) -> DenseMatrix {
        let mut matrix = DenseMatrix::zeros(order.len(), order.len());
        for (rows, products) in order.chunks(LANES).zip(&self.lower) {
            for (columns, product) in order.chunks(LANES).zip(products) {
                for (&i, product) in rows.iter().zip(product) {
                    for (&j, entry) in columns.iter().zip(product) {
                        *matrix.at_mut(i.max(j), i.min(j)) = entry.widen();
                    }
                }
            }
        }
        matrix.mirror();
        matrix
    }
}

/// Where nodes are in a piece.
struct Places(Vec<u32>);

impl Places {
    fn new(nodes: usize) -> Self {
        Self(vec![NONE; nodes])
    }

    fn mark(&mut self, nodes: &[u32]) {
        for (place, &node) in (0..).zip(nodes) {
            self.0[node as usize] = place;
        }
    }

    fn clear(&mut self, nodes: &[u32]) {
        for &node in nodes {
            self.0[node as usize] = NONE;
        }
    }

    #[inline(always)]
    fn of(&self, node: u32) -> Option<usize> {
        let place = self.0[node as usize];
        (place != NONE).then_some(place as usize)
    }
}

/// `product += X_own^T (B + R)_other`.
fn add_product<S: Scalar, const N: usize>(
    product: &mut Product<S>,
    own: &Share<S, N>,
    other: &Share<S, N>,
    places: &Places,
) {
    wide::<LANES>(
        #[inline(always)]
        || {
            for (&node, weights) in other.nodes.iter().zip(&other.weights) {
                let Some(place) = places.of(node) else {
                    continue;
                };
                for (moved, weights) in own.moved[place].iter().zip(weights) {
                    for i in 0..LANES {
                        for j in 0..LANES {
                            product[i][j] += moved[i] * weights[j];
                        }
                    }
                }
            }
        },
    );
}

/// What smoothing makes of a piece, and what it leaves for the next level.
fn smoothed<S: Scalar, const N: usize, const K: usize>(
    level: &Level<S, N, K>,
    piece: &Piece<S, N>,
    places: &mut Places,
) -> (Share<S, N>, Piece<S, K>) {
    let nodes = reached(&level.matrix.pattern, &piece.nodes);
    places.mark(&nodes);
    let mut weights = vec![[[S::default(); LANES]; N]; nodes.len()];
    for (&node, value) in piece.nodes.iter().zip(&piece.values) {
        weights[places.0[node as usize] as usize] = *value;
    }
    let mut residual = weights.clone();
    let mut moved = vec![[[S::default(); LANES]; N]; nodes.len()];
    for (place, &node) in nodes.iter().enumerate() {
        moved[place] = level.smoother.first(node as usize, &residual[place]);
    }
    let mut last = moved.clone();
    for index in 1..DEGREE {
        let of = Column {
            level,
            nodes: &nodes,
            places,
        };
        last = step(&of, index, &last, (&mut residual, &mut moved));
    }
    subtract_product(level, (&nodes, places), &last, &mut residual);
    for (weights, residual) in weights.iter_mut().zip(&residual) {
        let entries = weights.as_flattened_mut().iter_mut();
        for (weight, left) in entries.zip(residual.as_flattened()) {
            *weight += *left;
        }
    }
    let restricted = restricted(level, (&nodes, &residual), places);
    places.clear(&nodes);
    let share = Share {
        nodes,
        moved,
        weights,
    };
    (share, restricted)
}

/// Where a column has entries.
struct Column<'a, S, const N: usize, const K: usize> {
    level: &'a Level<S, N, K>,
    nodes: &'a [u32],
    places: &'a Places,
}

/// A step of the smoother after `moved` has moved by `last`; returns the next move.
fn step<S: Scalar, const N: usize, const K: usize>(
    of: &Column<'_, S, N, K>,
    index: usize,
    last: &[Node<S, N>],
    (residual, moved): (&mut [Node<S, N>], &mut [Node<S, N>]),
) -> Vec<Node<S, N>> {
    let mut next = last.to_vec();
    wide::<LANES>(
        #[inline(always)]
        || {
            for (place, &node) in of.nodes.iter().enumerate() {
                let product = product_of_row(&of.level.matrix, node, last, of.places);
                let row = RowStep {
                    r: &mut residual[place],
                    next: &mut next[place],
                    x: &mut moved[place],
                };
                let smoother = &of.level.smoother;
                smoother.step_of_row((index, node as usize), (&product, &last[place]), row);
            }
        },
    );
    next
}

/// `residual -= A move`.
fn subtract_product<S: Scalar, const N: usize, const K: usize>(
    level: &Level<S, N, K>,
    (nodes, places): (&[u32], &Places),
    last: &[Node<S, N>],
    residual: &mut [Node<S, N>],
) {
    wide::<LANES>(
        #[inline(always)]
        || {
            for (residual, &node) in residual.iter_mut().zip(nodes) {
                let product = product_of_row(&level.matrix, node, last, places);
                let entries = residual.as_flattened_mut().iter_mut();
                for (left, taken) in entries.zip(product.as_flattened()) {
                    *left -= *taken;
                }
            }
        },
    );
}

/// P^T of what is left at `nodes`.
fn restricted<S: Scalar, const N: usize, const K: usize>(
    level: &Level<S, N, K>,
    (nodes, residual): (&[u32], &[Node<S, N>]),
    places: &Places,
) -> Piece<S, K> {
    let groups = ring(&level.prolongation.pattern, nodes);
    let mut values = vec![[[S::default(); LANES]; K]; groups.len()];
    wide::<LANES>(
        #[inline(always)]
        || {
            for (value, &group) in values.iter_mut().zip(&groups) {
                *value = product_of_row(&level.restriction, group, residual, places);
            }
        },
    );
    Piece {
        nodes: groups,
        values,
    }
}

/// One row times the values of the nodes that have a place.
#[inline(always)]
fn product_of_row<S: Scalar, const R: usize, const C: usize>(
    matrix: &BlockRows<S, R, C>,
    row: u32,
    values: &[Node<S, C>],
    places: &Places,
) -> Node<S, R> {
    let mut sum = [[S::default(); LANES]; R];
    let (columns, blocks) = matrix.row(row as usize);
    for (&column, block) in columns.iter().zip(blocks) {
        if let Some(place) = places.of(column) {
            add_block_product(&mut sum, block, &values[place]);
        }
    }
    sum
}

/// Nodes that smoothing and its residual reach from `nodes`, ascending.
fn reached(pattern: &Pattern, nodes: &[u32]) -> Vec<u32> {
    (0..DEGREE).fold(nodes.to_vec(), |nodes, _| ring(pattern, &nodes))
}

/// Columns of the rows of `nodes`, ascending.
fn ring(pattern: &Pattern, nodes: &[u32]) -> Vec<u32> {
    let rows = nodes.iter().flat_map(|&node| pattern.row(node as usize));
    let mut columns: Vec<u32> = rows.copied().collect();
    columns.sort_unstable();
    columns.dedup();
    columns
}
