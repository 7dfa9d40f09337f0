//! Small random problems and their optimality conditions, for the tests.

use super::qp::Progress;
use super::{InequalitySolver, QpIterate, QpOutcome, QpProblem, QpRun, QpScales, QpTargets};
use crate::krylov::Verdict;
use crate::krylov::gcr::Directions;
use crate::linalg::samples::rows;
use crate::linalg::vector::{dot, reproducible_noise};
use crate::linalg::{DenseCholesky, DenseMatrix, Preconditioner, SparseRows, Workspace};
use crate::saddle::{BlockStep, MultiplierBlock};

/// The inverse of a dense matrix as a preconditioner.
pub(super) struct Exact(DenseCholesky);

impl Exact {
    pub(super) fn new(rows: &[Vec<f64>]) -> Self {
        let mut matrix = DenseMatrix::zeros(rows.len(), rows.len());
        for (i, row) in rows.iter().enumerate() {
            for (j, &value) in row.iter().enumerate() {
                *matrix.at_mut(i, j) = value;
            }
        }
        Self(DenseCholesky::new(&matrix).expect("positive definite"))
    }
}

impl Preconditioner for Exact {
    fn apply(&self, r: &[f64], z: &mut [f64], _work: &mut Workspace) {
        z.copy_from_slice(r);
        self.0.solve(z);
    }
}

/// C A^-1 C^T.
pub(super) fn schur(inverse: &Exact, coupling: &[Vec<f64>]) -> DenseMatrix {
    let size = coupling.len();
    let mut matrix = DenseMatrix::zeros(size, size);
    for (j, row) in coupling.iter().enumerate() {
        let mut column = row.clone();
        inverse.0.solve(&mut column);
        for (i, other) in coupling.iter().enumerate() {
            *matrix.at_mut(i, j) = dot(other, &column);
        }
    }
    matrix
}

/// A chain of springs with random load, coupling and gaps.
pub(super) struct Problem {
    pub(super) stiffness: Vec<Vec<f64>>,
    pub(super) coupling: Vec<Vec<f64>>,
    pub(super) force: Vec<f64>,
    pub(super) gap: Vec<f64>,
}

pub(super) const SIZE: usize = 8;
pub(super) const CONTACTS: usize = 4;

impl Problem {
    pub(super) fn new(seed: usize) -> Self {
        let noise = reproducible_noise(1000 * (seed + 1));
        let mut noise = noise[1000 * seed..].iter().copied();
        let mut take = |count: usize| noise.by_ref().take(count).collect::<Vec<f64>>();
        Self {
            stiffness: springs(0.1),
            coupling: (0..CONTACTS).map(|_| take(SIZE)).collect(),
            force: take(SIZE),
            gap: take(CONTACTS),
        }
    }

    pub(super) fn iterate(&self, equalities: usize) -> QpIterate {
        QpIterate {
            displacement: vec![0.0; SIZE],
            equality: vec![0.0; equalities],
            multiplier: vec![0.0; self.gap.len()],
            force: self.force.clone(),
            constraint: vec![0.1; equalities],
            gap: self.gap.clone(),
            active: vec![false; self.gap.len()],
        }
    }
}

impl Problem {
    pub(super) fn matrices(&self) -> Matrices {
        self.matrices_about(Exact::new(&self.stiffness))
    }

    /// With an inverse that is not that of the stiffness.
    pub(super) fn matrices_about(&self, inverse: Exact) -> Matrices {
        Matrices {
            stiffness: rows(&self.stiffness),
            coupling: rows(&self.coupling),
            metric: schur(&inverse, &self.coupling),
            weights: Vec::new(),
            inverse,
        }
    }
}

/// A problem as the methods take it; the metric is the exact compliance.
pub(super) struct Matrices {
    stiffness: SparseRows,
    coupling: SparseRows,
    pub(super) inverse: Exact,
    pub(super) metric: DenseMatrix,
    pub(super) weights: Vec<f64>,
}

impl Matrices {
    /// Without equalities and curvature.
    pub(super) fn problem(&self) -> QpProblem<'_> {
        QpProblem {
            stiffness: &self.stiffness,
            curvature: None,
            displacement: &self.inverse,
            step: BlockStep::UpperTriangular,
            equality: &[],
            coupling: &self.coupling,
            metric: &self.metric,
            weights: &self.weights,
        }
    }
}

/// One row that sums some unknowns.
pub(super) fn equality() -> Vec<Vec<f64>> {
    vec![(0..SIZE).map(|i| 1.0 + (i % 3) as f64).collect()]
}

/// The block of an equality.
pub(super) fn block<'a>(coupling: &'a SparseRows, metric: &'a Exact) -> MultiplierBlock<'a> {
    MultiplierBlock {
        coupling,
        stabilisation: None,
        metric,
        joint: None,
    }
}

/// A multiple of the identity.
pub(super) fn identity(factor: f64) -> SparseRows {
    let entry = |i, j| if i == j { factor } else { 0.0 };
    let row = |i| (0..SIZE).map(|j| entry(i, j)).collect();
    rows(&(0..SIZE).map(row).collect::<Vec<Vec<f64>>>())
}

/// A chain of springs with free ends, each node held by one more of stiffness
/// `hold`.
pub(super) fn springs(hold: f64) -> Vec<Vec<f64>> {
    let entry = |i, j| spring(i, j) + if i == j { hold } else { 0.0 };
    let row = |i| (0..SIZE).map(|j| entry(i, j)).collect();
    (0..SIZE).map(row).collect()
}

/// Entry of a chain with free ends.
fn spring(i: usize, j: usize) -> f64 {
    match i.abs_diff(j) {
        0 if i == 0 || i == SIZE - 1 => 1.0,
        0 => 2.0,
        1 => -1.0,
        _ => 0.0,
    }
}

pub(super) fn solve(method: &dyn InequalitySolver, iterate: &mut QpIterate) -> QpOutcome {
    solve_watched(method, iterate, &mut |_, _, _| Verdict::Continue)
}

pub(super) fn solve_watched(
    method: &dyn InequalitySolver,
    iterate: &mut QpIterate,
    progress: &mut Progress<'_>,
) -> QpOutcome {
    let mut run = QpRun {
        targets: QpTargets {
            force_scale: 1.0,
            level: 1e-12,
        },
        scales: &mut QpScales {
            constraint: 1.0,
            gap: 1.0,
        },
        iterations: 400,
        directions: &mut Directions::default(),
        progress,
        work: &mut Workspace::new(),
    };
    method.solve(iterate, &mut run)
}

/// Force balance with everything put in again, and complementarity.
pub(super) fn assert_optimal(problem: &Problem, equality: &[Vec<f64>], iterate: &QpIterate) {
    let u = &iterate.displacement;
    for i in 0..SIZE {
        let contact: f64 = (0..problem.gap.len())
            .map(|k| problem.coupling[k][i] * iterate.multiplier[k])
            .sum();
        let constraint: f64 = equality
            .iter()
            .zip(&iterate.equality)
            .map(|(row, x)| row[i] * x)
            .sum();
        let balance = problem.force[i] - dot(&problem.stiffness[i], u) - contact - constraint;
        assert!(balance.abs() < 1e-10, "{balance}");
    }
    for row in equality {
        assert!((dot(row, u) - 0.1).abs() < 1e-10);
    }
    for (k, row) in problem.coupling.iter().enumerate() {
        let (gap, pressure) = (problem.gap[k] - dot(row, u), iterate.multiplier[k]);
        assert!(gap > -1e-10 && pressure > -1e-10, "{gap} {pressure}");
        assert!((gap * pressure).abs() < 1e-10);
        assert!((gap - iterate.gap[k]).abs() < 1e-10);
    }
}
