//! The W-cycle: smooth, correct on the next level, smooth again; two cycles on
//! every level below the finest, which are small: they cost a sixth more than
//! one, and the count no longer grows with the number of levels.
//!
//! Symmetric positive definite, since both smoothings are the same polynomial
//! in D^-1 A. Each cycle takes four products with the level's matrix and two with
//! its prolongator; scratch comes from the pool.

use super::block_rows::{BlockRows, in_pieces, nodes, nodes_mut};
use super::coarsest::Coarsest;
use super::smoother::{AllRows, DEGREE, Smoother};
use crate::linalg::Scalar;
use crate::linalg::Workspace;

/// One level and its way to the next.
#[derive(Clone, Debug)]
pub(super) struct Level<S, const N: usize, const K: usize> {
    /// The Galerkin matrix of the level, or A11 on the finest.
    pub(super) matrix: BlockRows<S, N, N>,
    /// Chebyshev smoother in the inverted diagonal blocks.
    pub(super) smoother: Smoother<S, N>,
    /// Smoothed prolongation from the next coarser level `[nodes, groups]`.
    pub(super) prolongation: BlockRows<S, N, K>,
    /// Its transpose, stored so that restriction runs along rows too.
    pub(super) restriction: BlockRows<S, K, N>,
}

impl<S: Scalar, const N: usize, const K: usize> Level<S, N, K> {
    /// `x ~ A^-1 r` with `coarser` for the next level; spends `r`.
    fn cycle(
        &self,
        r: &mut [S],
        x: &mut [S],
        work: &mut Workspace,
        coarser: impl FnOnce(&mut [S], &mut [S], &mut Workspace),
    ) {
        let mut d = S::take(work, r.len());
        let mut next = S::take(work, r.len());
        self.smoother.start(r, &mut d, x);
        for index in 1..DEGREE {
            let rows = AllRows {
                r: &mut *r,
                next: &mut next,
                x: &mut *x,
            };
            self.smoother.step(index, &self.matrix, &d, rows);
            std::mem::swap(&mut d, &mut next);
        }
        subtract_product(&self.matrix, &d, r);
        let mut coarse_residual = S::take(work, K * self.restriction.rows());
        let mut coarse = S::take(work, coarse_residual.len());
        multiply(&self.restriction, r, &mut coarse_residual);
        coarser(&mut coarse_residual, &mut coarse, work);
        multiply(&self.prolongation, &coarse, &mut d);
        add(x, &d);
        for index in 0..DEGREE {
            let rows = AllRows {
                r: &mut *r,
                next: &mut next,
                x: &mut *x,
            };
            self.smoother.step(index, &self.matrix, &d, rows);
            std::mem::swap(&mut d, &mut next);
        }
        for vector in [d, next, coarse_residual, coarse] {
            S::give(work, vector);
        }
    }

    /// Bytes of the level's matrix, smoother and transfers.
    fn bytes(&self) -> u64 {
        self.matrix.bytes()
            + self.smoother.bytes()
            + self.prolongation.bytes()
            + self.restriction.bytes()
    }
}

/// `y += x`.
fn add<S: Scalar>(y: &mut [S], x: &[S]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += *x;
    }
}

/// `y = A x`.
fn multiply<S: Scalar, const R: usize, const C: usize>(
    matrix: &BlockRows<S, R, C>,
    x: &[S],
    y: &mut [S],
) {
    let x = nodes::<S, C, 1>(x);
    in_pieces(nodes_mut::<S, R, 1>(y), |first, rows| {
        for (row, y) in rows.iter_mut().enumerate() {
            *y = matrix.row_product(first + row, x);
        }
    });
}

/// `y -= A x`.
fn subtract_product<S: Scalar, const N: usize>(matrix: &BlockRows<S, N, N>, x: &[S], y: &mut [S]) {
    let x = nodes::<S, N, 1>(x);
    in_pieces(nodes_mut::<S, N, 1>(y), |first, rows| {
        for (row, y) in rows.iter_mut().enumerate() {
            let product = matrix.row_product(first + row, x);
            for (y, [product]) in y.as_flattened_mut().iter_mut().zip(product) {
                *y -= product;
            }
        }
    });
}

/// All levels: blocks of N components on the finest, of K modes below.
#[derive(Clone, Debug)]
pub(super) struct Hierarchy<S, const N: usize, const K: usize> {
    /// The level of A11 itself, with N components a node.
    pub(super) finest: Level<S, N, K>,
    /// The levels below it, with K modes a group, finest first.
    pub(super) coarser: Vec<Level<S, K, K>>,
    /// The dense inverse below them.
    pub(super) coarsest: Coarsest<S>,
}

impl<S: Scalar, const N: usize, const K: usize> Hierarchy<S, N, K> {
    /// One cycle from zero; spends `r`.
    pub(super) fn cycle(&self, r: &mut [S], x: &mut [S], work: &mut Workspace) {
        self.finest.cycle(r, x, work, |r, x, work| {
            self.descend(0, (r, x), work);
        });
    }

    /// The two cycles on a level below the finest, whose cost stays linear because levels
    /// shrink fast; the exact inverse on the last.
    fn descend(&self, depth: usize, (r, x): (&mut [S], &mut [S]), work: &mut Workspace) {
        let Some(level) = self.coarser.get(depth) else {
            return self.coarsest.solve::<1>(r, x);
        };
        let below = |r: &mut [S], x: &mut [S], work: &mut Workspace| {
            self.descend(depth + 1, (r, x), work);
        };
        let mut rest = S::take(work, r.len());
        rest.copy_from_slice(r);
        level.cycle(r, x, work, below);
        subtract_product(&level.matrix, x, &mut rest);
        let mut second = S::take(work, r.len());
        level.cycle(&mut rest, &mut second, work, below);
        add(x, &second);
        S::give(work, rest);
        S::give(work, second);
    }

    /// Nodes and stored blocks of each level but the coarsest.
    pub(super) fn shape(&self) -> Vec<(usize, usize)> {
        let finest = (self.finest.matrix.rows(), self.finest.matrix.blocks.len());
        let coarser = self.coarser.iter();
        let shapes = coarser.map(|level| (level.matrix.rows(), level.matrix.blocks.len()));
        std::iter::once(finest).chain(shapes).collect()
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> u64 {
        let coarser: u64 = self.coarser.iter().map(Level::bytes).sum();
        self.finest.bytes() + coarser + self.coarsest.bytes()
    }
}
