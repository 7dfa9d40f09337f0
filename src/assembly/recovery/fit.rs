//! Quadratic polynomials fitted by least squares,
//!
//! ```text
//! min sum over points |P(x) - e|^2,   P(x) = sum_k c_k m_k(x - centre)
//! ```
//!
//! with the monomials 1, x_i, x_i x_j (i <= j). Where the points do not determine
//! a quadratic polynomial a linear one is fitted, or a constant.

/// A pivot this much below its diagonal entry counts as dependent.
const DEPENDENT: f64 = 1e-10;

/// Coefficients `[monomials, strains]` about a centre that the user keeps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Quadratic<const M: usize, const S: usize>([[f64; S]; M]);

impl<const M: usize, const S: usize> Default for Quadratic<M, S> {
    fn default() -> Self {
        Self([[0.0; S]; M])
    }
}

impl<const M: usize, const S: usize> Quadratic<M, S> {
    /// Value at a distance from the centre.
    pub(super) fn at<const D: usize>(&self, distance: [f64; 3]) -> [f64; S] {
        let mut value = [0.0; S];
        for (m, row) in monomials::<D, M>(distance).iter().zip(&self.0) {
            for s in 0..S {
                value[s] += m * row[s];
            }
        }
        value
    }

    /// Value at the centre.
    pub(super) fn at_centre(&self) -> [f64; S] {
        self.0[0]
    }

    /// The same polynomial about a centre moved by `shift`.
    pub(super) fn centred_at<const D: usize>(&self, shift: [f64; 3]) -> Self {
        let mut moved = *self;
        moved.0[0] = self.at::<D>(shift);
        let mut k = 1 + D;
        for i in 0..D {
            for j in i..D {
                for s in 0..S {
                    moved.0[1 + i][s] += shift[j] * self.0[k][s];
                    moved.0[1 + j][s] += shift[i] * self.0[k][s];
                }
                k += 1;
            }
        }
        moved
    }

    /// Adds another polynomial about the same centre.
    pub(super) fn add(&mut self, other: &Self) {
        for (row, its_row) in self.0.iter_mut().zip(&other.0) {
            for s in 0..S {
                row[s] += its_row[s];
            }
        }
    }

    /// The polynomial times a number.
    pub(super) fn scaled(mut self, factor: f64) -> Self {
        self.0
            .as_flattened_mut()
            .iter_mut()
            .for_each(|c| *c *= factor);
        self
    }
}

fn monomials<const D: usize, const M: usize>(x: [f64; 3]) -> [f64; M] {
    let mut values = [0.0; M];
    values[0] = 1.0;
    values[1..=D].copy_from_slice(&x[..D]);
    let mut k = 1 + D;
    for i in 0..D {
        for j in i..D {
            values[k] = x[i] * x[j];
            k += 1;
        }
    }
    values
}

/// Normal equations of a fit.
#[derive(Clone, Debug)]
pub(super) struct Fit<const D: usize, const M: usize, const S: usize> {
    /// Both triangles: whole rows of a fixed length are added fastest.
    normal: [[f64; M]; M],
    right: [[f64; S]; M],
}

impl<const D: usize, const M: usize, const S: usize> Default for Fit<D, M, S> {
    fn default() -> Self {
        Self {
            normal: [[0.0; M]; M],
            right: [[0.0; S]; M],
        }
    }
}

impl<const D: usize, const M: usize, const S: usize> Fit<D, M, S> {
    /// Takes a value at a distance from the centre into account.
    pub(super) fn add(&mut self, distance: [f64; 3], value: &[f64; S]) {
        let m = monomials::<D, M>(distance);
        for (k, factor) in m.iter().enumerate() {
            for l in 0..M {
                self.normal[k][l] += factor * m[l];
            }
            for s in 0..S {
                self.right[k][s] += factor * value[s];
            }
        }
    }

    /// The polynomial of the highest degree that the points determine.
    pub(super) fn solve(&self) -> Quadratic<M, S> {
        [M, 1 + D, 1]
            .into_iter()
            .find_map(|size| self.solve_first(size))
            .unwrap_or_default()
    }

    /// Cholesky's method on the first `size` monomials; none where they are
    /// dependent on the points.
    fn solve_first(&self, size: usize) -> Option<Quadratic<M, S>> {
        let mut factor = self.normal;
        let mut solution = Quadratic::default();
        for k in 0..size {
            for l in 0..=k {
                let known: f64 = (0..l).map(|i| factor[k][i] * factor[l][i]).sum();
                let rest = self.normal[k][l] - known;
                if l < k {
                    factor[k][l] = rest / factor[l][l];
                } else if rest > DEPENDENT * self.normal[k][k] {
                    factor[k][k] = rest.sqrt();
                } else {
                    return None;
                }
            }
        }
        for s in 0..S {
            self.substitute(&factor, size, s, &mut solution.0);
        }
        Some(solution)
    }

    fn substitute(&self, factor: &[[f64; M]; M], size: usize, s: usize, x: &mut [[f64; S]; M]) {
        for k in 0..size {
            let known: f64 = (0..k).map(|i| factor[k][i] * x[i][s]).sum();
            x[k][s] = (self.right[k][s] - known) / factor[k][k];
        }
        for k in (0..size).rev() {
            let known: f64 = (k + 1..size).map(|i| factor[i][k] * x[i][s]).sum();
            x[k][s] = (x[k][s] - known) / factor[k][k];
        }
    }
}
