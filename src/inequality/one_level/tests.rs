//! The one-level method against optimality conditions of small problems.

use super::*;
use crate::inequality::samples::{
    CONTACTS, Exact, Problem, SIZE, assert_optimal, schur, solve, sparse, spring,
};
use crate::krylov::Verdict;
use crate::linalg::DenseMatrix;
use crate::linalg::vector::largest;
use crate::saddle::BlockStep;

#[test]
fn random_problems_end_optimal_without_equalities() {
    for seed in 0..20 {
        let problem = Problem::new(seed);
        let inverse = Exact::new(&problem.stiffness);
        let parts = QpProblem {
            stiffness: &sparse(&problem.stiffness),
            curvature: None,
            step: BlockStep::UpperTriangular,
            displacement: &inverse,
            equality: &[],
            coupling: &sparse(&problem.coupling),
            metric: &schur(&inverse, &problem.coupling),
            weights: &[],
        };
        let one_level = OneLevel::new(parts);
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
        let parts = QpProblem {
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
            metric: &compliance,
            weights: &[],
        };
        let one_level = OneLevel::new(parts);
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
    let parts = QpProblem {
        stiffness: &sparse(&problem.stiffness),
        curvature: Some(&curvature),
        step: BlockStep::UpperTriangular,
        displacement: &inverse,
        equality: &[],
        coupling: &sparse(&problem.coupling),
        metric: &schur(&inverse, &problem.coupling),
        weights: &[],
    };
    let one_level = OneLevel::new(parts);
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
    let parts = QpProblem {
        stiffness: &sparse(&problem.stiffness),
        curvature: None,
        step: BlockStep::UpperTriangular,
        displacement: &inverse,
        equality: &[],
        coupling: &sparse(&problem.coupling),
        metric: &schur(&inverse, &problem.coupling),
        weights: &[],
    };
    let one_level = OneLevel::new(parts);
    let mut iterate = problem.iterate(0);
    assert_eq!(solve(&one_level, &mut iterate).status, QpStatus::Solved);
    assert_optimal(&problem, &[], &iterate);
    assert!((iterate.multiplier[0] - 1.0).abs() < 1e-10);
}

#[test]
fn the_observer_can_interrupt() {
    let problem = Problem::new(1);
    let inverse = Exact::new(&problem.stiffness);
    let parts = QpProblem {
        stiffness: &sparse(&problem.stiffness),
        curvature: None,
        step: BlockStep::UpperTriangular,
        displacement: &inverse,
        equality: &[],
        coupling: &sparse(&problem.coupling),
        metric: &schur(&inverse, &problem.coupling),
        weights: &[],
    };
    let one_level = OneLevel::new(parts);
    let mut iterate = problem.iterate(0);
    let mut run = QpRun {
        targets: QpTargets {
            force_scale: 1.0,
            level: 1e-12,
        },
        scales: &mut QpScales::default(),
        iterations: 400,
        directions: &mut gcr::Directions::default(),
        progress: &mut |_, _, _| Verdict::Stop,
        work: &mut Workspace::new(),
    };
    let outcome = one_level.solve(&mut iterate, &mut run);
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
    let parts = QpProblem {
        stiffness: &sparse(&problem.stiffness),
        curvature: None,
        step: BlockStep::UpperTriangular,
        displacement: &inverse,
        equality: &[],
        coupling: &sparse(&problem.coupling),
        metric: &compliance,
        weights: &[],
    };
    let one_level = OneLevel::new(parts);
    let mut iterate = problem.iterate(0);
    iterate.active.fill(true);
    assert_eq!(
        solve(&one_level, &mut iterate).status,
        QpStatus::IndefiniteMetric
    );
}
