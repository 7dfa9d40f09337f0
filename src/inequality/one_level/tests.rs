//! The one-level method against optimality conditions of small problems.

use super::*;
use crate::inequality::samples::{
    CONTACTS, Exact, Problem, SIZE, assert_optimal, block, equality, identity, schur, solve,
    solve_watched, springs,
};
use crate::krylov::Verdict;
use crate::linalg::DenseMatrix;
use crate::linalg::samples::rows;
use crate::linalg::vector::largest;

#[test]
fn random_problems_end_optimal_without_equalities() {
    for seed in 0..20 {
        let problem = Problem::new(seed);
        let matrices = problem.matrices();
        let mut iterate = problem.iterate(0);
        let outcome = solve(&OneLevel::new(matrices.problem()), &mut iterate);
        assert_eq!(outcome.status, QpStatus::Solved, "{seed}");
        assert_optimal(&problem, &[], &iterate);
    }
}

#[test]
fn random_problems_end_optimal_with_an_equality_and_poor_metrics() {
    for seed in 0..20 {
        let problem = Problem::new(seed);
        let (mut matrices, equality) = (problem.matrices(), equality());
        let coupling = rows(&equality);
        // Half the true Schur complement, and only the diagonal for contact.
        let metric = Exact::new(&[vec![0.5 * schur(&matrices.inverse, &equality).at(0, 0)]]);
        let mut compliance = DenseMatrix::zeros(CONTACTS, CONTACTS);
        (0..CONTACTS).for_each(|k| *compliance.at_mut(k, k) = matrices.metric.at(k, k));
        matrices.metric = compliance;
        let parts = QpProblem {
            equality: &[block(&coupling, &metric)],
            ..matrices.problem()
        };
        let mut iterate = problem.iterate(1);
        let outcome = solve(&OneLevel::new(parts), &mut iterate);
        assert_eq!(outcome.status, QpStatus::Solved, "{seed}");
        assert_optimal(&problem, &equality, &iterate);
    }
}

#[test]
fn the_curvature_term_is_taken_off_the_stiffness() {
    let mut problem = Problem::new(3);
    let matrices = problem.matrices();
    let parts = QpProblem {
        curvature: Some(&identity(0.02)),
        ..matrices.problem()
    };
    let mut iterate = problem.iterate(0);
    let outcome = solve(&OneLevel::new(parts), &mut iterate);
    assert_eq!(outcome.status, QpStatus::Solved);
    (0..SIZE).for_each(|i| problem.stiffness[i][i] -= 0.02);
    assert_optimal(&problem, &[], &iterate);
}

#[test]
fn a_body_that_only_contact_holds_finds_its_support() {
    let mut problem = Problem::new(0);
    problem.stiffness = springs(0.0);
    // One end touches already; the load pushes the other end towards it.
    problem.coupling = vec![vec![0.0; SIZE]];
    problem.coupling[0][0] = 1.0;
    problem.gap = vec![0.0];
    problem.force = vec![0.0; SIZE];
    problem.force[SIZE - 1] = 1.0;
    let matrices = problem.matrices_about(Exact::new(&springs(0.01)));
    let mut iterate = problem.iterate(0);
    let outcome = solve(&OneLevel::new(matrices.problem()), &mut iterate);
    assert_eq!(outcome.status, QpStatus::Solved);
    assert_optimal(&problem, &[], &iterate);
    assert!((iterate.multiplier[0] - 1.0).abs() < 1e-10);
}

#[test]
fn the_observer_can_interrupt() {
    let problem = Problem::new(1);
    let matrices = problem.matrices();
    let mut iterate = problem.iterate(0);
    let one_level = OneLevel::new(matrices.problem());
    let outcome = solve_watched(&one_level, &mut iterate, &mut |_, _, _| Verdict::Stop);
    assert_eq!(
        (outcome.status, outcome.iterations),
        (QpStatus::Interrupted, 1)
    );
    assert!(largest(&iterate.displacement) > 0.0);
}

#[test]
fn an_indefinite_metric_is_a_typed_failure() {
    let problem = Problem::new(2);
    let mut matrices = problem.matrices();
    matrices.metric = DenseMatrix::zeros(CONTACTS, CONTACTS);
    (0..CONTACTS).for_each(|k| *matrices.metric.at_mut(k, k) = -1.0);
    let mut iterate = problem.iterate(0);
    iterate.active.fill(true);
    let outcome = solve(&OneLevel::new(matrices.problem()), &mut iterate);
    assert_eq!(outcome.status, QpStatus::IndefiniteMetric);
}
