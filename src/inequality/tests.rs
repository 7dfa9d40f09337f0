//! All methods against the optimality conditions of the same small problems.

use super::samples::{
    CONTACTS, Exact, Matrices, Problem, assert_optimal, block, equality, identity, schur, solve,
    solve_watched,
};
use super::*;
use crate::krylov::{Outcome, Verdict};
use crate::linalg::DenseMatrix;
use crate::linalg::samples::rows;

/// With four times the diagonal of the exact compliance as metric and, as weights,
/// the sum of its absolute columns, which bounds it.
fn matrices(problem: &Problem) -> Matrices {
    let mut matrices = problem.matrices();
    let exact = std::mem::replace(&mut matrices.metric, DenseMatrix::zeros(CONTACTS, CONTACTS));
    (0..CONTACTS).for_each(|k| *matrices.metric.at_mut(k, k) = 4.0 * exact.at(k, k));
    let weights = (0..CONTACTS).map(|j| exact.column(j).iter().map(|x| x.abs()).sum());
    matrices.weights = weights.collect();
    matrices
}

#[test]
fn every_method_ends_random_problems_optimal() {
    let mut failures = 0;
    for method in ContactMethod::ALL {
        for seed in 0..20 {
            let problem = Problem::new(seed);
            let matrices = matrices(&problem);
            let mut iterate = problem.iterate(0);
            let outcome = solve(&*choose(method, matrices.problem()), &mut iterate);
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
        let (matrices, equality) = (matrices(&problem), equality());
        let coupling = rows(&equality);
        let metric = Exact::new(&[vec![0.5 * schur(&matrices.inverse, &equality).at(0, 0)]]);
        let parts = QpProblem {
            curvature: Some(&identity(0.02)),
            equality: &[block(&coupling, &metric)],
            ..matrices.problem()
        };
        let mut iterate = problem.iterate(1);
        let outcome = solve(&*choose(method, parts), &mut iterate);
        assert_eq!(outcome.status, QpStatus::Solved, "{method:?}");
        (0..samples::SIZE).for_each(|i| problem.stiffness[i][i] -= 0.02);
        assert_optimal(&problem, &equality, &iterate);
    }
}

#[test]
fn every_nested_method_can_be_interrupted_inside_an_inner_solve() {
    for method in ContactMethod::ALL.into_iter().filter(|m| m.is_nested()) {
        let problem = Problem::new(1);
        let matrices = matrices(&problem);
        let parts = QpProblem {
            curvature: Some(&identity(0.02)),
            ..matrices.problem()
        };
        let mut calls = 0;
        let mut iterate = problem.iterate(0);
        let outcome = solve_watched(&*choose(method, parts), &mut iterate, &mut |_, _, _| {
            calls += 1;
            match calls < 3 {
                true => Verdict::Continue,
                false => Verdict::Stop,
            }
        });
        assert_eq!(outcome.status, QpStatus::Interrupted, "{method:?}");
        assert_eq!(outcome.iterations, 3);
    }
}

#[test]
fn products_that_are_spent_end_with_a_typed_status_and_a_better_iterate() {
    // The metric is ten thousand times too large, the steps as much too short.
    let problem = Problem::new(0);
    let mut matrices = matrices(&problem);
    matrices.metric.scale(1e4);
    let mut iterate = problem.iterate(0);
    let method = ContactMethod::ProjectedArrowHurwicz;
    let outcome = solve(&*choose(method, matrices.problem()), &mut iterate);
    let spent = QpStatus::Krylov(Outcome::IterationLimit);
    assert_eq!((outcome.status, outcome.products), (spent, 400));
    assert!(iterate.multiplier.iter().any(|&l| l > 0.0));
}
