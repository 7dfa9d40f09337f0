//! Tensor products of cubic B-splines through the values at the nodes.
//!
//! Along a line of n values f the coefficients c_(-1) .. c_n solve
//!
//! ```text
//! c_(i-1) + 4 c_i + c_(i+1) = 6 f_i,   c_1 = f_1 - (f_0 - 2 f_1 + f_2) / 6
//! ```
//!
//! the latter, and the same at the other end, being that the third derivative does not jump
//! at the second node. Cost: a tridiagonal system a line, 4^N coefficients an evaluation.

use super::error::GridError;
use super::lattice::Lattice;

/// What lies beyond the border.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Beyond {
    /// The values of the border, brought back into the grid.
    Clamped,
    /// The values of the border too, reached over three more cells: the spline has continuous
    /// second derivatives everywhere.
    Flat,
}

impl Beyond {
    /// Cells that are added at an end.
    fn cells(self) -> usize {
        match self {
            Self::Clamped => 0,
            Self::Flat => 3,
        }
    }
}

/// Value, gradient and Hessian.
#[derive(Clone, Copy, Debug)]
pub(super) struct Jet<const N: usize> {
    pub(super) value: f64,
    pub(super) gradient: [f64; N],
    pub(super) hessian: [[f64; N]; N],
}

/// The coefficients around a place: how far they lie apart along each axis, and their weights
/// with two derivatives.
struct Around<const N: usize> {
    strides: [usize; N],
    weights: [[[f64; 3]; 4]; N],
}

/// A spline over a lattice.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Spline<const N: usize> {
    lattice: Lattice<N>,
    beyond: Beyond,
    /// Of each axis: its nodes, one more at each end, and the cells beyond.
    coefficients: Vec<f64>,
}

impl<const N: usize> Spline<N> {
    /// The spline through `values` (one a node of a checked lattice).
    pub(super) fn new(lattice: Lattice<N>, values: &[f64], beyond: Beyond) -> Self {
        let mut shape = lattice.counts;
        let mut coefficients = values.to_vec();
        for axis in 0..N {
            coefficients = along(&coefficients, (&shape, axis), beyond);
            shape[axis] += 2 + 2 * beyond.cells();
        }
        Self {
            lattice,
            beyond,
            coefficients,
        }
    }

    /// The nodes.
    pub(super) fn lattice(&self) -> &Lattice<N> {
        &self.lattice
    }

    /// Refuses values that are too large for their spline, by the largest of them.
    pub(super) fn check(&self, values: &[f64]) -> Result<(), GridError> {
        let is_finite = |value: &f64| value.is_finite();
        if self.coefficients.iter().all(is_finite) {
            return Ok(());
        }
        let larger = |most: (usize, f64), (index, value): (usize, &f64)| {
            if value.abs() > most.1 {
                (index, value.abs())
            } else {
                most
            }
        };
        let (index, _) = values.iter().enumerate().fold((0, 0.0), larger);
        let node = self.lattice.node(index).to_vec();
        Err(GridError::NotFinite { node })
    }

    /// The coefficients, which the values determine.
    pub(super) fn coefficients(&self) -> &[f64] {
        &self.coefficients
    }

    /// Value and derivatives at a place `[N]`; beyond the border at the nearest place that
    /// the spline has.
    pub(super) fn jet(&self, place: [f64; N]) -> Jet<N> {
        let mut around = Around {
            strides: [1; N],
            weights: [[[0.0; 3]; 4]; N],
        };
        let (mut first, mut stride) = (0, 1);
        for axis in (0..N).rev() {
            let (cell, weights) = self.cell(axis, place[axis]);
            first += cell * stride;
            around.strides[axis] = stride;
            around.weights[axis] = weights;
            stride *= self.lattice.counts[axis] + 2 + 2 * self.beyond.cells();
        }
        let mut jet = self.sum(first, &around, 0);
        let scale = self.lattice.spacing.map(f64::recip);
        for a in 0..N {
            jet.gradient[a] *= scale[a];
            for b in a..N {
                jet.hessian[a][b] *= scale[a] * scale[b];
                jet.hessian[b][a] = jet.hessian[a][b];
            }
        }
        jet
    }

    /// The cell of a coordinate along an axis, from the first that is stored, and the weights
    /// of its coefficients.
    fn cell(&self, axis: usize, x: f64) -> (usize, [[f64; 3]; 4]) {
        let beyond = self.beyond.cells() as f64;
        let cells = (self.lattice.counts[axis] - 1) as f64 + 2.0 * beyond;
        let t = (x - self.lattice.origin[axis]) / self.lattice.spacing[axis] + beyond;
        let t = t.clamp(0.0, cells);
        let cell = t.floor().min(cells - 1.0);
        (cell as usize, weights(t - cell))
    }

    /// The sum over the axes from `axis` on, its derivatives along those only.
    fn sum(&self, first: usize, around: &Around<N>, axis: usize) -> Jet<N> {
        let mut jet = Jet {
            value: 0.0,
            gradient: [0.0; N],
            hessian: [[0.0; N]; N],
        };
        for (i, [weight, slope, bend]) in around.weights[axis].into_iter().enumerate() {
            let place = first + i * around.strides[axis];
            if axis + 1 == N {
                let coefficient = self.coefficients[place];
                jet.value += weight * coefficient;
                jet.gradient[axis] += slope * coefficient;
                jet.hessian[axis][axis] += bend * coefficient;
                continue;
            }
            let inner = self.sum(place, around, axis + 1);
            jet.value += weight * inner.value;
            jet.gradient[axis] += slope * inner.value;
            jet.hessian[axis][axis] += bend * inner.value;
            for b in axis + 1..N {
                jet.gradient[b] += weight * inner.gradient[b];
                jet.hessian[axis][b] += slope * inner.gradient[b];
                for c in b..N {
                    jet.hessian[b][c] += weight * inner.hessian[b][c];
                }
            }
        }
        jet
    }
}

/// Weights of the four coefficients at u from 0 to 1 in a cell, with two derivatives.
fn weights(u: f64) -> [[f64; 3]; 4] {
    let v = 1.0 - u;
    let middle = |u: f64, v: f64| {
        let value = (4.0 - 3.0 * u * u * (1.0 + v)) / 6.0;
        (value, 0.5 * u * (3.0 * u - 4.0), 3.0 * u - 2.0)
    };
    let (second, third) = (middle(u, v), middle(v, u));
    [
        [v * v * v / 6.0, -0.5 * v * v, v],
        [second.0, second.1, second.2],
        [third.0, -third.1, third.2],
        [u * u * u / 6.0, 0.5 * u * u, u],
    ]
}

/// The coefficients along one axis of values of some shape.
fn along<const N: usize>(
    values: &[f64],
    (shape, axis): (&[usize; N], usize),
    beyond: Beyond,
) -> Vec<f64> {
    let inner: usize = shape[axis + 1..].iter().product();
    let outer: usize = shape[..axis].iter().product();
    let count = shape[axis];
    let longer = count + 2 + 2 * beyond.cells();
    let mut all = vec![0.0; outer * longer * inner];
    let mut line = vec![0.0; count];
    for place in 0..outer * inner {
        let (row, column) = (place / inner, place % inner);
        for (i, value) in line.iter_mut().enumerate() {
            *value = values[(row * count + i) * inner + column];
        }
        let found = flattened(coefficients(&line), beyond);
        for (i, value) in found.into_iter().enumerate() {
            all[(row * longer + i) * inner + column] = value;
        }
    }
    all
}

/// The coefficients c_(-1) .. c_n of at least four values.
fn coefficients(f: &[f64]) -> Vec<f64> {
    let n = f.len();
    let bend = |i: usize| f[i - 1] - 2.0 * f[i] + f[i + 1];
    let mut c = vec![0.0; n + 2];
    // c[i + 1] is c_i.
    c[2] = f[1] - bend(1) / 6.0;
    c[n - 1] = f[n - 2] - bend(n - 2) / 6.0;
    // Elimination from the left; the pivots tend to 2 + sqrt(3).
    let mut ratios = vec![0.0; n + 2];
    for i in 2..n.saturating_sub(2) {
        let pivot = 4.0 - ratios[i];
        ratios[i + 1] = 1.0 / pivot;
        c[i + 1] = (6.0 * f[i] - c[i]) / pivot;
    }
    for i in (2..n - 2).rev() {
        c[i + 1] -= ratios[i + 1] * c[i + 2];
    }
    c[1] = 6.0 * f[1] - 4.0 * c[2] - c[3];
    c[0] = 6.0 * f[0] - 4.0 * c[1] - c[2];
    c[n] = 6.0 * f[n - 2] - 4.0 * c[n - 1] - c[n - 2];
    c[n + 1] = 6.0 * f[n - 1] - 4.0 * c[n] - c[n - 1];
    c
}

/// The coefficients with those of the cells beyond: all equal, they make a constant, and it is
/// the value at the end.
fn flattened(c: Vec<f64>, beyond: Beyond) -> Vec<f64> {
    let end = |a: f64, b: f64, c: f64| (a + 4.0 * b + c) / 6.0;
    let last = c.len() - 1;
    let low = vec![end(c[0], c[1], c[2]); beyond.cells()];
    let high = vec![end(c[last - 2], c[last - 1], c[last]); beyond.cells()];
    [low, c, high].concat()
}
