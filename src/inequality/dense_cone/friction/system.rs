//! The equations of a Newton step on many points, by GCR: pressures by the Cholesky factor of
//! their compliance, then tractions by that of theirs with what gives way where points slip.
//!
//! ```text
//! K_nn n = r_n,   (K_tt + D) t = M^-1 (r_t + mu n e / rho),   D = M^-1 (1 - M) / rho
//! ```
//!
//! What couples gaps and tractions is left out, as Poisson's ratio makes it small. Cost: some
//! eight products instead of the cube of an LU factor.

use super::Newton;
use super::slip::SlipRow;
use crate::krylov::gcr::{Directions, Gcr};
use crate::krylov::{Monitor, Outcome, Verdict};
use crate::linalg::vector::norm;
use crate::linalg::{DenseCholesky, DenseMatrix, LinearOperator, Preconditioner, Workspace};

/// Reduction of the error of a step, by what the metric says of it.
const REDUCTION: f64 = 1e-3;
/// Iterations after which a factor is cheaper.
const MOST_ITERATIONS: usize = 40;

/// The metric of the equations of a step.
pub(super) struct StepMetric<'r> {
    /// Places of pressures and guides among the unknowns.
    pressures: Vec<usize>,
    /// Places of tractions.
    tractions: Vec<usize>,
    /// Factor of the compliance of pressures.
    of_pressures: DenseCholesky,
    /// Factor of that of tractions with what gives way.
    of_tractions: DenseCholesky,
    /// Equations of the points that slip.
    rows: &'r [SlipRow],
    /// Tractions a point.
    width: usize,
}

impl Newton<'_> {
    /// The metric of the equations on `selected`, of which `matrix` is the compliance; none
    /// where that is not positive definite.
    pub(super) fn metric<'r>(
        &self,
        rows: &'r [SlipRow],
        (selected, matrix): (&[usize], &DenseMatrix),
    ) -> Option<StepMetric<'r>> {
        let width = self.width();
        let mut is_traction = vec![false; self.diagonal.len()];
        for point in self.points() {
            is_traction[point.first..point.first + width].fill(true);
        }
        let (tractions, pressures): (Vec<usize>, Vec<usize>) =
            (0..selected.len()).partition(|&place| is_traction[selected[place]]);
        let mut compliance = matrix.principal(&tractions);
        for row in rows {
            let own = tractions.partition_point(|&other| other < row.own);
            let softness = row.softness();
            for j in 0..width {
                for i in 0..width {
                    *compliance.at_mut(own + i, own + j) += softness[i][j];
                }
            }
        }
        Some(StepMetric {
            of_pressures: DenseCholesky::new(&matrix.principal(&pressures)).ok()?,
            of_tractions: DenseCholesky::new(&compliance).ok()?,
            pressures,
            tractions,
            rows,
            width,
        })
    }
}

impl StepMetric<'_> {
    /// The solution from `x` on; none where it takes too long.
    pub(super) fn solve(
        &self,
        matrix: &DenseMatrix,
        right: &[f64],
        mut x: Vec<f64>,
    ) -> Option<Vec<f64>> {
        let mut work = Workspace::new();
        let mut residual = vec![0.0; x.len()];
        matrix.multiply(&x, &mut residual);
        residual
            .iter_mut()
            .zip(right)
            .for_each(|(r, b)| *r = b - *r);
        let mut error = vec![0.0; x.len()];
        self.apply(&residual, &mut error, &mut work);
        let operator = Preconditioned {
            matrix,
            metric: self,
        };
        let mut monitor = Reduced {
            bound: REDUCTION * norm(&error),
        };
        if monitor.bound == 0.0 {
            return Some(x);
        }
        let method = Gcr {
            operator: &operator,
            preconditioner: &Same,
            directions: &mut Directions::keeping(MOST_ITERATIONS),
            iterations: MOST_ITERATIONS,
        };
        let outcome = method.solve((&mut x, &mut error), &mut monitor, &mut work);
        (outcome == Outcome::Stopped).then_some(x)
    }
}

impl Preconditioner for StepMetric<'_> {
    fn apply(&self, r: &[f64], z: &mut [f64], _work: &mut Workspace) {
        let mut pressures: Vec<f64> = self.pressures.iter().map(|&place| r[place]).collect();
        self.of_pressures.solve(&mut pressures);
        z.copy_from_slice(r);
        for (&place, value) in self.pressures.iter().zip(pressures) {
            z[place] = value;
        }
        for row in self.rows {
            let pressure = z[row.partner];
            row.gap(pressure, &mut z[row.own..row.own + self.width]);
        }
        let mut tractions: Vec<f64> = self.tractions.iter().map(|&place| z[place]).collect();
        self.of_tractions.solve(&mut tractions);
        for (&place, value) in self.tractions.iter().zip(tractions) {
            z[place] = value;
        }
    }
}

/// The equations in their metric.
struct Preconditioned<'a> {
    matrix: &'a DenseMatrix,
    metric: &'a StepMetric<'a>,
}

impl LinearOperator for Preconditioned<'_> {
    fn rows(&self) -> usize {
        self.matrix.rows()
    }

    fn columns(&self) -> usize {
        self.matrix.columns()
    }

    fn apply(&self, x: &[f64], y: &mut [f64], work: &mut Workspace) {
        let mut product = vec![0.0; x.len()];
        self.matrix.multiply(x, &mut product);
        self.metric.apply(&product, y, work);
    }

    fn apply_transposed(&self, _y: &[f64], _x: &mut [f64], _work: &mut Workspace) {
        unreachable!("GCR asks for products alone")
    }
}

/// No metric.
struct Same;

impl Preconditioner for Same {
    fn apply(&self, r: &[f64], z: &mut [f64], _work: &mut Workspace) {
        z.copy_from_slice(r);
    }
}

/// Stops where the error is reduced.
struct Reduced {
    bound: f64,
}

impl Monitor for Reduced {
    fn judge(&mut self, residual: &[f64]) -> Verdict {
        if norm(residual) <= self.bound {
            Verdict::Stop
        } else {
            Verdict::Continue
        }
    }
}
