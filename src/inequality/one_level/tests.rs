//! The one-level method against optimality conditions of small problems.

use super::*;
use crate::inequality::Augmentation;
use crate::inequality::samples::{
    CONTACTS, Exact, Problem, SIZE, assert_optimal, block, equality, identity, saddle_solution,
    schur, solve, solve_watched, springs,
};
use crate::krylov::Verdict;
use crate::linalg::DenseMatrix;
use crate::linalg::samples::rows;
use crate::linalg::vector::{largest, reproducible_noise};
use crate::saddle::{
    AdmissibleSet, Components, Cones, EqualityBlock, FrictionBound, MultiplierBlock, Status,
};

#[test]
fn random_problems_end_optimal_without_equalities() {
    for seed in 0..20 {
        let problem = Problem::new(seed);
        let matrices = problem.matrices();
        let blocks = [matrices.unilateral()];
        let mut iterate = problem.iterate(0);
        let outcome = solve(&OneLevel::new(matrices.problem(&blocks)), &mut iterate);
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
        let blocks = [block(&coupling, &metric), matrices.unilateral()];
        let mut iterate = problem.iterate(1);
        let outcome = solve(&OneLevel::new(matrices.problem(&blocks)), &mut iterate);
        assert_eq!(outcome.status, QpStatus::Solved, "{seed}");
        assert_optimal(&problem, &equality, &iterate);
    }
}

#[test]
fn the_curvature_term_is_taken_off_the_stiffness() {
    let mut problem = Problem::new(3);
    let matrices = problem.matrices();
    let blocks = [matrices.unilateral()];
    let parts = QpProblem {
        curvature: Some(&identity(0.02)),
        augmentation: None,
        ..matrices.problem(&blocks)
    };
    let mut iterate = problem.iterate(0);
    let outcome = solve(&OneLevel::new(parts), &mut iterate);
    assert_eq!(outcome.status, QpStatus::Solved);
    (0..SIZE).for_each(|i| problem.stiffness[i][i] -= 0.02);
    assert_optimal(&problem, &[], &iterate);
}

/// Two pressures and their tractions under Coulomb's law.
fn frictional() -> AdmissibleSet<'static> {
    AdmissibleSet::Cones(Cones {
        normals: 2,
        partners: &[0, 1],
        bounds: &[FrictionBound::Coulomb(0.3); 2],
        components: Components::One,
    })
}

#[test]
fn terms_that_vanish_on_contact_leave_the_solution_with_friction_as_it_is() {
    let (mut sticking, mut slipping) = (0, 0);
    for seed in 0..20 {
        let problem = Problem::new(seed);
        let matrices = problem.matrices();
        let blocks = [matrices.contact(frictional())];
        let noise = reproducible_noise(CONTACTS * SIZE);
        let terms: Vec<Vec<f64>> = noise
            .chunks_exact(SIZE)
            .map(|row| row.iter().map(|x| 0.1 * x).collect())
            .collect();
        let terms = Augmentation {
            rows: rows(&terms),
            is_traction: vec![false, false, true, true],
            mass: rows(&[
                [2.0, 0.5, 0.0, 0.0],
                [0.5, 1.0, 0.0, 0.0],
                [0.0, 0.0, 2.0, 0.5],
                [0.0, 0.0, 0.5, 1.0],
            ]),
            order: vec![0, 1, 2, 3],
        };
        let [plain, augmented] = [None, Some(&terms)].map(|augmentation| {
            let parts = QpProblem {
                augmentation,
                ..matrices.problem(&blocks)
            };
            let mut iterate = problem.iterate(0);
            let outcome = solve(&OneLevel::new(parts), &mut iterate);
            assert_eq!(outcome.status, QpStatus::Solved, "{seed}");
            iterate
        });
        assert_near(&unknowns(&augmented), &unknowns(&plain));
        let tractions = &augmented.blocks[0].status[2..];
        sticking += tractions.iter().filter(|&&s| s == Status::Stick).count();
        slipping += tractions.iter().filter(|&&s| s == Status::Slip).count();
    }
    assert!(sticking > 3 && slipping > 3, "{sticking} {slipping}");
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
    let blocks = [matrices.unilateral()];
    let mut iterate = problem.iterate(0);
    let outcome = solve(&OneLevel::new(matrices.problem(&blocks)), &mut iterate);
    assert_eq!(outcome.status, QpStatus::Solved);
    assert_optimal(&problem, &[], &iterate);
    assert!((iterate.blocks[0].multiplier[0] - 1.0).abs() < 1e-10);
}

#[test]
fn the_observer_can_interrupt() {
    let problem = Problem::new(1);
    let matrices = problem.matrices();
    let blocks = [matrices.unilateral()];
    let mut iterate = problem.iterate(0);
    let one_level = OneLevel::new(matrices.problem(&blocks));
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
    let blocks = [matrices.unilateral()];
    let mut iterate = problem.iterate(0);
    iterate.blocks[0].status.fill(Status::Stick);
    let outcome = solve(&OneLevel::new(matrices.problem(&blocks)), &mut iterate);
    assert_eq!(outcome.status, QpStatus::IndefiniteMetric);
}

/// Displacement and multipliers of all blocks.
fn unknowns(iterate: &QpIterate) -> Vec<f64> {
    let multipliers = iterate.blocks.iter().flat_map(|block| &block.multiplier);
    iterate
        .displacement
        .iter()
        .chain(multipliers)
        .copied()
        .collect()
}

fn assert_near(found: &[f64], exact: &[f64]) {
    assert_eq!(found.len(), exact.len());
    for (found, exact) in found.iter().zip(exact) {
        assert!((found - exact).abs() < 1e-9, "{found} {exact}");
    }
}

#[test]
fn free_multipliers_hold_in_both_directions_like_an_equality() {
    for seed in 0..20 {
        let problem = Problem::new(seed);
        let matrices = problem.matrices();
        let blocks = [matrices.contact(AdmissibleSet::Free)];
        let mut iterate = problem.iterate(0);
        let outcome = solve(&OneLevel::new(matrices.problem(&blocks)), &mut iterate);
        assert_eq!((outcome.status, outcome.set_changes), (QpStatus::Solved, 0));
        let right = [&problem.force[..], &problem.gap].concat();
        let (rows, stiffness) = (&problem.coupling, &problem.stiffness);
        let exact = saddle_solution(stiffness, rows, rows, &right);
        assert_near(&unknowns(&iterate), &exact);
        assert_eq!(iterate.blocks[0].closed(), CONTACTS);
    }
}

#[test]
fn multipliers_may_act_otherwise_than_they_constrain() {
    for seed in 0..20 {
        let problem = Problem::new(seed);
        let (matrices, equality) = (problem.matrices(), equality());
        let noise = reproducible_noise((CONTACTS + 1) * SIZE);
        let turned = |row: &Vec<f64>, k: usize| -> Vec<f64> {
            let noise = &noise[k * SIZE..(k + 1) * SIZE];
            row.iter().zip(noise).map(|(r, n)| r + 0.3 * n).collect()
        };
        let contact_columns: Vec<_> = (0..CONTACTS)
            .map(|k| turned(&problem.coupling[k], k))
            .collect();
        let equality_columns = vec![turned(&equality[0], CONTACTS)];
        let (constraint, acts) = (rows(&equality), rows(&equality_columns));
        let metric = Exact::new(&[vec![schur(&matrices.inverse, &equality).at(0, 0)]]);
        let pushes = rows(&contact_columns);
        let blocks = [
            MultiplierBlock::from(EqualityBlock {
                shared: None,
                rows: &constraint,
                columns: &acts,
                stabilisation: None,
                metric: &metric,
                joint: None,
            }),
            MultiplierBlock {
                columns: &pushes,
                ..matrices.contact(AdmissibleSet::Free)
            },
        ];
        let mut iterate = problem.iterate(1);
        let outcome = solve(&OneLevel::new(matrices.problem(&blocks)), &mut iterate);
        assert_eq!(outcome.status, QpStatus::Solved, "{seed}");
        let exact = saddle_solution(
            &problem.stiffness,
            &[equality, problem.coupling].concat(),
            &[equality_columns, contact_columns].concat(),
            &[&problem.force[..], &[0.1], &problem.gap].concat(),
        );
        assert_near(&unknowns(&iterate), &exact);
    }
}

#[test]
fn a_force_that_is_not_a_number_is_no_solution() {
    let mut problem = Problem::new(1);
    problem.force[3] = f64::NAN;
    let matrices = problem.matrices();
    let blocks = [matrices.unilateral()];
    let mut iterate = problem.iterate(0);
    let outcome = solve(&OneLevel::new(matrices.problem(&blocks)), &mut iterate);
    assert_eq!(outcome.status, QpStatus::Krylov(Outcome::NotFinite));
}
