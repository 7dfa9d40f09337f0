//! Small random problems and their optimality conditions, for the tests.

use super::qp::Progress;
use super::{
    BlockIterate, InequalitySolver, QpIterate, QpOutcome, QpProblem, QpRun, QpScales, QpTargets,
};
use crate::krylov::Verdict;
use crate::krylov::gcr::Directions;
use crate::linalg::samples::rows;
use crate::linalg::vector::{dot, reproducible_noise};
use crate::linalg::{
    DenseCholesky, DenseMatrix, LinearOperator, Preconditioner, SparseRows, Workspace,
};
use crate::saddle::{
    AdmissibleSet, EqualityBlock, Metric, MultiplierBlock, ProductSet, SetPart, Status,
    UpperTriangular,
};

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

    /// With that many equality blocks of one row before contact.
    pub(super) fn iterate(&self, equalities: usize) -> QpIterate {
        let pressure = (0..equalities).map(|_| BlockIterate::of_equality(vec![0.1]));
        QpIterate {
            displacement: vec![0.0; SIZE],
            force: self.force.clone(),
            blocks: pressure
                .chain([BlockIterate {
                    multiplier: vec![0.0; self.gap.len()],
                    residual: self.gap.clone(),
                    status: vec![Status::Open; self.gap.len()],
                    slides: Vec::new(),
                }])
                .collect(),
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
    /// Without curvature.
    pub(super) fn problem<'a>(&'a self, blocks: &'a [MultiplierBlock<'a>]) -> QpProblem<'a> {
        QpProblem {
            stiffness: &self.stiffness,
            curvature: None,
            augmentation: None,
            displacement: &self.inverse,
            step: &UpperTriangular { share: 1.0 },
            blocks,
        }
    }

    /// Contact whose multipliers are all in `set`.
    pub(super) fn contact<'a>(&'a self, set: AdmissibleSet<'a>) -> MultiplierBlock<'a> {
        let size = self.coupling.rows();
        MultiplierBlock {
            rows: &self.coupling,
            columns: &self.coupling,
            stabilisation: None,
            metric: Metric::Dense {
                matrix: &self.metric,
                weights: &self.weights,
                moduli: &[],
                shared: None,
            },
            set: ProductSet::Uniform(SetPart { size, set }),
            joint: None,
        }
    }

    /// Contact that pushes and never pulls.
    pub(super) fn unilateral(&self) -> MultiplierBlock<'_> {
        self.contact(AdmissibleSet::NonNegative)
    }
}

/// One row that sums some unknowns.
pub(super) fn equality() -> Vec<Vec<f64>> {
    vec![(0..SIZE).map(|i| 1.0 + (i % 3) as f64).collect()]
}

/// The block of an equality.
pub(super) fn block<'a>(coupling: &'a SparseRows, metric: &'a Exact) -> MultiplierBlock<'a> {
    MultiplierBlock::from(EqualityBlock {
        shared: None,
        rows: coupling,
        columns: coupling,
        stabilisation: None,
        metric,
        joint: None,
    })
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
            multiplier_error: None,
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

/// [A D^T; B 0]^-1 (f, g) by elimination with pivots: displacement, then multipliers.
pub(super) fn saddle_solution(
    stiffness: &[Vec<f64>],
    constraints: &[Vec<f64>],
    columns: &[Vec<f64>],
    right: &[f64],
) -> Vec<f64> {
    let count = SIZE + constraints.len();
    let entry = |i: usize, j: usize| match (i < SIZE, j < SIZE) {
        (true, true) => stiffness[i][j],
        (true, false) => columns[j - SIZE][i],
        (false, true) => constraints[i - SIZE][j],
        (false, false) => 0.0,
    };
    let row = |i| (0..count).map(|j| entry(i, j)).chain([right[i]]).collect();
    let mut rows: Vec<Vec<f64>> = (0..count).map(row).collect();
    for k in 0..count {
        let size = |i: &usize| rows[*i][k].abs();
        let pivot = (k..count).max_by(|i, j| size(i).total_cmp(&size(j)));
        rows.swap(k, pivot.unwrap_or(k));
        let lead = rows[k].clone();
        for row in rows.iter_mut().skip(k + 1) {
            let factor = row[k] / lead[k];
            row.iter_mut()
                .zip(&lead)
                .for_each(|(a, b)| *a -= factor * b);
        }
    }
    let mut x = vec![0.0; count];
    for k in (0..count).rev() {
        let known: f64 = (k + 1..count).map(|j| rows[k][j] * x[j]).sum();
        x[k] = (rows[k][count] - known) / rows[k][k];
    }
    x
}

/// Force balance with everything put in again, and complementarity.
pub(super) fn assert_optimal(problem: &Problem, equality: &[Vec<f64>], iterate: &QpIterate) {
    let u = &iterate.displacement;
    let [pressure @ .., contact] = &iterate.blocks[..] else {
        unreachable!("contact is there")
    };
    for i in 0..SIZE {
        let pushed: f64 = (0..problem.gap.len())
            .map(|k| problem.coupling[k][i] * contact.multiplier[k])
            .sum();
        let constraint: f64 = equality
            .iter()
            .zip(pressure)
            .map(|(row, block)| row[i] * block.multiplier[0])
            .sum();
        let balance = problem.force[i] - dot(&problem.stiffness[i], u) - pushed - constraint;
        assert!(balance.abs() < 1e-10, "{balance}");
    }
    for row in equality {
        assert!((dot(row, u) - 0.1).abs() < 1e-10);
    }
    for (k, row) in problem.coupling.iter().enumerate() {
        let (gap, pressure) = (problem.gap[k] - dot(row, u), contact.multiplier[k]);
        assert!(gap > -1e-10 && pressure > -1e-10, "{gap} {pressure}");
        assert!((gap * pressure).abs() < 1e-10);
        assert!((gap - contact.residual[k]).abs() < 1e-10);
    }
}
