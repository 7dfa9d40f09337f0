//! The one-level method against optimality conditions of small problems.

use super::*;
use crate::krylov::Verdict;
use crate::linalg::DenseCholesky;
use crate::linalg::SparseRowsBuilder;
use crate::linalg::vector::{dot, largest, reproducible_noise};

/// A matrix from rows.
fn sparse(rows: &[Vec<f64>]) -> SparseRows {
    let mut builder = SparseRowsBuilder::new(rows[0].len());
    for row in rows {
        let entries = row
            .iter()
            .enumerate()
            .map(|(column, &value)| (column as u32, value));
        builder.push_row(&mut entries.collect::<Vec<_>>());
    }
    builder.finish()
}

/// The inverse of a dense matrix as a preconditioner.
struct Exact(DenseCholesky);

impl Exact {
    fn new(rows: &[Vec<f64>]) -> Self {
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
fn schur(inverse: &Exact, coupling: &[Vec<f64>]) -> DenseMatrix {
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
struct Problem {
    stiffness: Vec<Vec<f64>>,
    coupling: Vec<Vec<f64>>,
    force: Vec<f64>,
    gap: Vec<f64>,
}

const SIZE: usize = 8;
const CONTACTS: usize = 4;

impl Problem {
    fn new(seed: usize) -> Self {
        let noise = reproducible_noise(1000 * (seed + 1));
        let mut noise = noise[1000 * seed..].iter().copied();
        let mut take = |count: usize| noise.by_ref().take(count).collect::<Vec<f64>>();
        let stiffness = (0..SIZE)
            .map(|i| {
                (0..SIZE)
                    .map(|j| spring(i, j) + if i == j { 0.1 } else { 0.0 })
                    .collect()
            })
            .collect();
        Self {
            stiffness,
            coupling: (0..CONTACTS).map(|_| take(SIZE)).collect(),
            force: take(SIZE),
            gap: take(CONTACTS),
        }
    }

    fn iterate(&self, equalities: usize) -> QpIterate {
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

/// Entry of a chain with free ends.
fn spring(i: usize, j: usize) -> f64 {
    match i.abs_diff(j) {
        0 if i == 0 || i == SIZE - 1 => 1.0,
        0 => 2.0,
        1 => -1.0,
        _ => 0.0,
    }
}

fn solve(problem: &OneLevel<'_>, iterate: &mut QpIterate) -> QpOutcome {
    let targets = QpTargets {
        force_scale: 1.0,
        level: 1e-12,
    };
    let mut scales = QpScales {
        constraint: 1.0,
        gap: 1.0,
    };
    problem.solve(
        iterate,
        &targets,
        &mut scales,
        400,
        &mut gcr::Directions::default(),
        &mut |_, _, _| Verdict::Continue,
        &mut Workspace::new(),
    )
}

/// Force balance with everything put in again, and complementarity.
fn assert_optimal(problem: &Problem, equality: &[Vec<f64>], iterate: &QpIterate) {
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

#[test]
fn random_problems_end_optimal_without_equalities() {
    for seed in 0..20 {
        let problem = Problem::new(seed);
        let inverse = Exact::new(&problem.stiffness);
        let one_level = OneLevel {
            stiffness: &sparse(&problem.stiffness),
            curvature: None,
            step: BlockStep::UpperTriangular,
            displacement: &inverse,
            equality: &[],
            coupling: &sparse(&problem.coupling),
            compliance: &schur(&inverse, &problem.coupling),
        };
        let mut iterate = problem.iterate(0);
        let outcome = solve(&one_level, &mut iterate);
        assert_eq!(outcome.status, QpStatus::Solved, "{seed}");
        assert_optimal(&problem, &[], &iterate);
    }
}

#[test]
fn random_problems_end_optimal_with_an_equality_and_poor_metrics() {
    for seed in 0..20 {
        let problem = Problem::new(seed);
        let inverse = Exact::new(&problem.stiffness);
        let row: Vec<f64> = (0..SIZE).map(|i| 1.0 + (i % 3) as f64).collect();
        let equality = [row];
        let coupling = sparse(&equality);
        // Half the true Schur complement, and only the diagonal for contact.
        let metric = Exact::new(&[vec![0.5 * schur(&inverse, &equality).at(0, 0)]]);
        let exact = schur(&inverse, &problem.coupling);
        let mut compliance = DenseMatrix::zeros(CONTACTS, CONTACTS);
        (0..CONTACTS).for_each(|k| *compliance.at_mut(k, k) = exact.at(k, k));
        let one_level = OneLevel {
            stiffness: &sparse(&problem.stiffness),
            curvature: None,
            step: BlockStep::UpperTriangular,
            displacement: &inverse,
            equality: &[MultiplierBlock {
                coupling: &coupling,
                stabilisation: None,
                metric: &metric,
                joint: None,
            }],
            coupling: &sparse(&problem.coupling),
            compliance: &compliance,
        };
        let mut iterate = problem.iterate(1);
        let outcome = solve(&one_level, &mut iterate);
        assert_eq!(outcome.status, QpStatus::Solved, "{seed}");
        assert_optimal(&problem, &equality, &iterate);
    }
}

#[test]
fn the_curvature_term_is_taken_off_the_stiffness() {
    let mut problem = Problem::new(3);
    let inverse = Exact::new(&problem.stiffness);
    let curvature = sparse(
        &(0..SIZE)
            .map(|i| {
                (0..SIZE)
                    .map(|j| f64::from(u8::from(i == j)) * 0.02)
                    .collect()
            })
            .collect::<Vec<_>>(),
    );
    let one_level = OneLevel {
        stiffness: &sparse(&problem.stiffness),
        curvature: Some(&curvature),
        step: BlockStep::UpperTriangular,
        displacement: &inverse,
        equality: &[],
        coupling: &sparse(&problem.coupling),
        compliance: &schur(&inverse, &problem.coupling),
    };
    let mut iterate = problem.iterate(0);
    assert_eq!(solve(&one_level, &mut iterate).status, QpStatus::Solved);
    (0..SIZE).for_each(|i| problem.stiffness[i][i] -= 0.02);
    assert_optimal(&problem, &[], &iterate);
}

#[test]
fn a_body_that_only_contact_holds_finds_its_support() {
    let mut problem = Problem::new(0);
    problem.stiffness = (0..SIZE)
        .map(|i| (0..SIZE).map(|j| spring(i, j)).collect())
        .collect();
    // One end touches already; the load pushes the other end towards it.
    problem.coupling = vec![vec![0.0; SIZE]];
    problem.coupling[0][0] = 1.0;
    problem.gap = vec![0.0];
    problem.force = vec![0.0; SIZE];
    problem.force[SIZE - 1] = 1.0;
    let shifted: Vec<Vec<f64>> = (0..SIZE)
        .map(|i| {
            (0..SIZE)
                .map(|j| spring(i, j) + if i == j { 0.01 } else { 0.0 })
                .collect()
        })
        .collect();
    let inverse = Exact::new(&shifted);
    let one_level = OneLevel {
        stiffness: &sparse(&problem.stiffness),
        curvature: None,
        step: BlockStep::UpperTriangular,
        displacement: &inverse,
        equality: &[],
        coupling: &sparse(&problem.coupling),
        compliance: &schur(&inverse, &problem.coupling),
    };
    let mut iterate = problem.iterate(0);
    assert_eq!(solve(&one_level, &mut iterate).status, QpStatus::Solved);
    assert_optimal(&problem, &[], &iterate);
    assert!((iterate.multiplier[0] - 1.0).abs() < 1e-10);
}

#[test]
fn the_observer_can_interrupt() {
    let problem = Problem::new(1);
    let inverse = Exact::new(&problem.stiffness);
    let one_level = OneLevel {
        stiffness: &sparse(&problem.stiffness),
        curvature: None,
        step: BlockStep::UpperTriangular,
        displacement: &inverse,
        equality: &[],
        coupling: &sparse(&problem.coupling),
        compliance: &schur(&inverse, &problem.coupling),
    };
    let mut iterate = problem.iterate(0);
    let targets = QpTargets {
        force_scale: 1.0,
        level: 1e-12,
    };
    let outcome = one_level.solve(
        &mut iterate,
        &targets,
        &mut QpScales::default(),
        400,
        &mut gcr::Directions::default(),
        &mut |_, _, _| Verdict::Stop,
        &mut Workspace::new(),
    );
    assert_eq!(
        (outcome.status, outcome.iterations),
        (QpStatus::Interrupted, 1)
    );
    assert!(largest(&iterate.displacement) > 0.0);
}

#[test]
fn an_indefinite_metric_is_a_typed_failure() {
    let problem = Problem::new(2);
    let inverse = Exact::new(&problem.stiffness);
    let mut compliance = DenseMatrix::zeros(CONTACTS, CONTACTS);
    (0..CONTACTS).for_each(|k| *compliance.at_mut(k, k) = -1.0);
    let one_level = OneLevel {
        stiffness: &sparse(&problem.stiffness),
        curvature: None,
        step: BlockStep::UpperTriangular,
        displacement: &inverse,
        equality: &[],
        coupling: &sparse(&problem.coupling),
        compliance: &compliance,
    };
    let mut iterate = problem.iterate(0);
    iterate.active.fill(true);
    assert_eq!(
        solve(&one_level, &mut iterate).status,
        QpStatus::IndefiniteMetric
    );
}
