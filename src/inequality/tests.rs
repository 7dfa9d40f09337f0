//! All methods against the optimality conditions of the same small problems.

use super::samples::{CONTACTS, Exact, Problem, assert_optimal, schur, solve, sparse};
use super::*;
use crate::krylov::gcr::Directions;
use crate::krylov::{Outcome, Verdict};
use crate::linalg::{DenseMatrix, SparseRows, Workspace};
use crate::saddle::{BlockStep, MultiplierBlock};

/// Twice the diagonal of the exact compliance and, as weights, the sum of its
/// absolute columns, which bounds it.
fn metric_and_weights(exact: &DenseMatrix) -> (DenseMatrix, Vec<f64>) {
    let mut metric = DenseMatrix::zeros(CONTACTS, CONTACTS);
    (0..CONTACTS).for_each(|k| *metric.at_mut(k, k) = 4.0 * exact.at(k, k));
    let weights = (0..CONTACTS).map(|j| exact.column(j).iter().map(|x| x.abs()).sum());
    (metric, weights.collect())
}

/// One row that sums some unknowns.
fn equality() -> Vec<Vec<f64>> {
    vec![(0..samples::SIZE).map(|i| 1.0 + (i % 3) as f64).collect()]
}

#[test]
fn every_method_ends_random_problems_optimal() {
    let mut failures = 0;
    for method in ContactMethod::ALL {
        for seed in 0..20 {
            let problem = Problem::new(seed);
            let inverse = Exact::new(&problem.stiffness);
            let (metric, weights) = metric_and_weights(&schur(&inverse, &problem.coupling));
            let parts = QpProblem {
                stiffness: &sparse(&problem.stiffness),
                curvature: None,
                step: BlockStep::UpperTriangular,
                displacement: &inverse,
                equality: &[],
                coupling: &sparse(&problem.coupling),
                metric: &metric,
                weights: &weights,
            };
            let mut iterate = problem.iterate(0);
            let outcome = solve(&*choose(method, parts), &mut iterate);
            assert_eq!(outcome.products > 0, method.is_nested());
            // Nothing keeps sets from returning, nor bounds the number of fixed steps.
            let limit = QpStatus::Krylov(Outcome::IterationLimit);
            let is_known = match method {
                ContactMethod::ActiveSet => outcome.status == QpStatus::ActiveSetCycle,
                ContactMethod::ProjectedArrowHurwicz => outcome.status == limit,
                ContactMethod::OneLevel
                | ContactMethod::Nested
                | ContactMethod::Mprgp
                | ContactMethod::ConjugateProjectedGradient => false,
            };
            if is_known {
                failures += 1;
                continue;
            }
            assert_eq!(outcome.status, QpStatus::Solved, "{method:?} {seed}");
            assert_optimal(&problem, &[], &iterate);
        }
    }
    assert!(failures < 8, "{failures}");
}

#[test]
fn every_method_bears_an_equality_and_a_curvature() {
    for method in ContactMethod::ALL {
        let mut problem = Problem::new(3);
        let inverse = Exact::new(&problem.stiffness);
        let rows = equality();
        let coupling = sparse(&rows);
        let block_metric = Exact::new(&[vec![0.5 * schur(&inverse, &rows).at(0, 0)]]);
        let (metric, weights) = metric_and_weights(&schur(&inverse, &problem.coupling));
        let parts = QpProblem {
            stiffness: &sparse(&problem.stiffness),
            curvature: Some(&identity(0.02)),
            step: BlockStep::UpperTriangular,
            displacement: &inverse,
            equality: &[MultiplierBlock {
                coupling: &coupling,
                stabilisation: None,
                metric: &block_metric,
                joint: None,
            }],
            coupling: &sparse(&problem.coupling),
            metric: &metric,
            weights: &weights,
        };
        let mut iterate = problem.iterate(1);
        let outcome = solve(&*choose(method, parts), &mut iterate);
        assert_eq!(outcome.status, QpStatus::Solved, "{method:?}");
        (0..samples::SIZE).for_each(|i| problem.stiffness[i][i] -= 0.02);
        assert_optimal(&problem, &rows, &iterate);
    }
}

fn identity(factor: f64) -> SparseRows {
    let entry = |i, j| factor * f64::from(u8::from(i == j));
    let row = |i| (0..samples::SIZE).map(|j| entry(i, j)).collect();
    sparse(&(0..samples::SIZE).map(row).collect::<Vec<Vec<f64>>>())
}

#[test]
fn every_nested_method_can_be_interrupted_inside_an_inner_solve() {
    for method in ContactMethod::ALL.into_iter().filter(|m| m.is_nested()) {
        let problem = Problem::new(1);
        let inverse = Exact::new(&problem.stiffness);
        let (metric, weights) = metric_and_weights(&schur(&inverse, &problem.coupling));
        let parts = QpProblem {
            stiffness: &sparse(&problem.stiffness),
            curvature: Some(&identity(0.02)),
            step: BlockStep::UpperTriangular,
            displacement: &inverse,
            equality: &[],
            coupling: &sparse(&problem.coupling),
            metric: &metric,
            weights: &weights,
        };
        let mut calls = 0;
        let mut iterate = problem.iterate(0);
        let outcome = choose(method, parts).solve(
            &mut iterate,
            &mut QpRun {
                targets: QpTargets {
                    force_scale: 1.0,
                    level: 1e-12,
                },
                scales: &mut QpScales::default(),
                iterations: 400,
                directions: &mut Directions::default(),
                progress: &mut |_, _, _| {
                    calls += 1;
                    match calls < 3 {
                        true => Verdict::Continue,
                        false => Verdict::Stop,
                    }
                },
                work: &mut Workspace::new(),
            },
        );
        assert_eq!(outcome.status, QpStatus::Interrupted, "{method:?}");
        assert_eq!(outcome.iterations, 3);
    }
}

#[test]
fn products_that_are_spent_end_with_a_typed_status_and_a_better_iterate() {
    // The metric is ten thousand times too large, the steps as much too short.
    let problem = Problem::new(0);
    let inverse = Exact::new(&problem.stiffness);
    let (mut metric, _) = metric_and_weights(&schur(&inverse, &problem.coupling));
    metric.scale(1e4);
    let parts = QpProblem {
        stiffness: &sparse(&problem.stiffness),
        curvature: None,
        step: BlockStep::UpperTriangular,
        displacement: &inverse,
        equality: &[],
        coupling: &sparse(&problem.coupling),
        metric: &metric,
        weights: &[],
    };
    let mut iterate = problem.iterate(0);
    let method = ContactMethod::ProjectedArrowHurwicz;
    let outcome = solve(&*choose(method, parts), &mut iterate);
    let spent = QpStatus::Krylov(Outcome::IterationLimit);
    assert_eq!((outcome.status, outcome.products), (spent, 400));
    assert!(iterate.multiplier.iter().any(|&l| l > 0.0));
}
