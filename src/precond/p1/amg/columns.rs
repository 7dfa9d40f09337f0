//! Columns of A11^-1 by the cycle, for the metric of the contact pressure.
//!
//! D^T C D with C one V-cycle and D the unit traces of the contact surface
//! `[unknowns, traces]`: symmetric, positive, between 1/2 and 1 times the exact
//! block on good meshes. Several columns share the way through the matrices:
//! on tetrahedra one column costs about 4 kflop per vertex. Pieces of columns
//! run in parallel; every column has the bits it has alone.

use rayon::prelude::*;

use super::block_rows::nodes;
use super::cycle::{Hierarchy, Visits};
use crate::linalg::Scalar;
use crate::linalg::{DenseMatrix, Workspace};
use crate::precond::p1::Traces;

/// Columns that share one way.
const LANES: usize = 16;

/// D^T C D, or none when `proceed` says no between two pieces of columns.
pub(super) fn compliance<S: Scalar, const N: usize, const K: usize>(
    cycle: &Hierarchy<S, N, K>,
    traces: &Traces<'_>,
    proceed: &(dyn Fn() -> bool + Sync),
) -> Option<DenseMatrix> {
    let size = traces.vertices.len();
    let firsts: Vec<usize> = (0..size).step_by(LANES).collect();
    let pieces: Option<Vec<Vec<f64>>> = firsts
        .into_par_iter()
        .map_init(Workspace::new, |work, first| {
            proceed().then(|| piece(cycle, traces, first, work))
        })
        .collect();
    let values: Vec<f64> = pieces?.into_iter().flatten().collect();
    let mut matrix = DenseMatrix::zeros(size, size);
    for j in 0..size {
        for i in 0..size {
            *matrix.at_mut(i, j) = 0.5 * (values[i + size * j] + values[j + size * i]);
        }
    }
    Some(matrix)
}

/// Up to [`LANES`] columns from `first` on, one after another.
fn piece<S: Scalar, const N: usize, const K: usize>(
    cycle: &Hierarchy<S, N, K>,
    traces: &Traces<'_>,
    first: usize,
    work: &mut Workspace,
) -> Vec<f64> {
    let length = N * LANES * cycle.finest.matrix.rows();
    let mut r = S::take(work, length);
    let mut x = S::take(work, length);
    r.fill(S::default());
    let width = LANES.min(traces.vertices.len() - first);
    for lane in 0..width {
        let direction = traces.directions[first + lane];
        let start = N * LANES * traces.vertices[first + lane] as usize;
        for i in 0..N {
            r[start + LANES * i + lane] = S::narrow(direction[i]);
        }
    }
    cycle.cycle::<LANES>(Visits::One, &mut r, &mut x, work);
    let moved = nodes::<S, N, LANES>(&x);
    let along = |lane: usize| {
        let pairs = traces.vertices.iter().zip(traces.directions);
        pairs.map(move |(&vertex, direction)| {
            let node = &moved[vertex as usize];
            (0..N).map(|i| node[i][lane].widen() * direction[i]).sum()
        })
    };
    let columns = (0..width).flat_map(along).collect();
    S::give(work, r);
    S::give(work, x);
    columns
}
