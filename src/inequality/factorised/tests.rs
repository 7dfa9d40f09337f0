//! The factorised method against optimality conditions of small problems.

use super::*;
use crate::inequality::samples::{
    Exact, Problem, SIZE, assert_optimal, block, equality, identity, schur, solve, solve_watched,
    springs,
};
use crate::krylov::Verdict;
use crate::linalg::samples::rows;
use crate::linalg::{SparseRows, SparseRowsBuilder, Workspace};

/// A problem as it is stored, in the order of its unknowns.
fn stored<'a>(problem: &Problem, contact: &'a SparseRows) -> Matrices<'a> {
    Matrices {
        stiffness: rows(&problem.stiffness),
        coupling: None,
        stabilisation: None,
        contact,
        places: (0..SIZE as u32).collect(),
        is_loose: false,
        may_be_indefinite: false,
        most_flops: f64::INFINITY,
    }
}

/// Solves a problem whose stiffness is `curvature` less on the diagonal.
fn solve_curved(problem: &Problem, curvature: f64, iterate: &mut QpIterate) -> QpOutcome {
    let (matrices, contact) = (problem.matrices(), rows(&problem.coupling));
    let blocks = [matrices.unilateral()];
    let curvature = identity(curvature);
    let mut kept = stored(problem, &contact);
    kept.stiffness = kept.stiffness.plus_multiple(-1.0, &curvature);
    let method = Factorised {
        faces: MOST_FACES,
        problem: QpProblem {
            curvature: Some(&curvature),
            ..matrices.problem(&blocks)
        },
        matrices: kept,
    };
    solve(&method, iterate)
}

#[test]
fn random_problems_end_optimal_without_equalities() {
    for seed in 0..20 {
        let problem = Problem::new(seed);
        let (matrices, contact) = (problem.matrices(), rows(&problem.coupling));
        let blocks = [matrices.unilateral()];
        let method = Factorised {
            faces: MOST_FACES,
            problem: matrices.problem(&blocks),
            matrices: stored(&problem, &contact),
        };
        let mut iterate = problem.iterate(0);
        assert_eq!(solve(&method, &mut iterate).status, QpStatus::Solved);
        assert_optimal(&problem, &[], &iterate);
    }
}

#[test]
fn random_problems_end_optimal_with_an_equality_whatever_its_metric() {
    for seed in 0..20 {
        let problem = Problem::new(seed);
        let (matrices, equality) = (problem.matrices(), equality());
        let (contact, coupling) = (rows(&problem.coupling), rows(&equality));
        let metric = Exact::new(&[vec![1e6 * schur(&matrices.inverse, &equality).at(0, 0)]]);
        let blocks = [block(&coupling, &metric), matrices.unilateral()];
        let method = Factorised {
            faces: MOST_FACES,
            problem: matrices.problem(&blocks),
            matrices: Matrices {
                coupling: Some(coupling.clone()),
                ..stored(&problem, &contact)
            },
        };
        let mut iterate = problem.iterate(1);
        assert_eq!(solve(&method, &mut iterate).status, QpStatus::Solved);
        assert_optimal(&problem, &equality, &iterate);
    }
}

#[test]
fn stiffness_of_any_contrast_and_curvature_are_no_matter() {
    for contrast in [1e-2_f64, 1e6, 1e10] {
        let mut problem = Problem::new(3);
        let factor = |i: usize| if i < SIZE / 2 { 1.0 } else { contrast.sqrt() };
        for (i, row) in problem.stiffness.iter_mut().enumerate() {
            let entries = row.iter_mut().enumerate();
            entries.for_each(|(j, entry)| *entry *= factor(i) * factor(j));
        }
        let mut iterate = problem.iterate(0);
        let outcome = solve_curved(&problem, 1e-3, &mut iterate);
        assert_eq!(outcome.status, QpStatus::Solved, "{contrast}");
        (0..SIZE).for_each(|i| problem.stiffness[i][i] -= 1e-3);
        // Of a force that stiff springs make of rounding.
        let open = iterate.blocks[0].residual.iter().all(|&gap| gap > -1e-10);
        assert!(open && iterate.force.iter().all(|f| f.abs() < 1e-9));
    }
}

#[test]
fn a_body_that_only_contact_holds_finds_its_support() {
    let mut problem = Problem::new(0);
    problem.stiffness = springs(0.0);
    problem.coupling = vec![vec![0.0; SIZE]];
    problem.coupling[0][0] = 1.0;
    problem.gap = vec![0.5];
    problem.force = vec![0.0; SIZE];
    problem.force[SIZE - 1] = 1.0;
    let matrices = problem.matrices_about(Exact::new(&springs(0.01)));
    let blocks = [matrices.unilateral()];
    let contact = rows(&problem.coupling);
    let method = Factorised {
        faces: MOST_FACES,
        problem: matrices.problem(&blocks),
        matrices: Matrices {
            is_loose: true,
            ..stored(&problem, &contact)
        },
    };
    let mut iterate = problem.iterate(0);
    assert_eq!(solve(&method, &mut iterate).status, QpStatus::Solved);
    assert_optimal(&problem, &[], &iterate);
    assert!((iterate.blocks[0].multiplier[0] - 1.0).abs() < 1e-10);
}

#[test]
fn two_constraints_that_say_the_same_share_their_pressure() {
    let mut problem = Problem::new(1);
    let row = problem.coupling[0].clone();
    problem.coupling = vec![row.clone(), row];
    problem.gap = vec![-0.5, -0.5];
    let matrices = problem.matrices();
    let blocks = [matrices.unilateral()];
    let contact = rows(&problem.coupling);
    let method = Factorised {
        faces: MOST_FACES,
        problem: matrices.problem(&blocks),
        matrices: stored(&problem, &contact),
    };
    let mut iterate = problem.iterate(0);
    assert_eq!(solve(&method, &mut iterate).status, QpStatus::Solved);
    assert_optimal(&problem, &[], &iterate);
}

#[test]
fn a_factor_beyond_its_bound_is_not_made() {
    let problem = Problem::new(1);
    let (matrices, contact) = (problem.matrices(), rows(&problem.coupling));
    let blocks = [matrices.unilateral()];
    let method = Factorised {
        faces: MOST_FACES,
        problem: matrices.problem(&blocks),
        matrices: Matrices {
            most_flops: 10.0,
            ..stored(&problem, &contact)
        },
    };
    let mut iterate = problem.iterate(0);
    assert_eq!(solve(&method, &mut iterate).status, QpStatus::TooLarge);
}

#[test]
fn the_observer_can_interrupt_before_any_factor_is_made() {
    let problem = Problem::new(1);
    let (matrices, contact) = (problem.matrices(), rows(&problem.coupling));
    let blocks = [matrices.unilateral()];
    let method = Factorised {
        faces: MOST_FACES,
        problem: matrices.problem(&blocks),
        matrices: stored(&problem, &contact),
    };
    let mut iterate = problem.iterate(0);
    let outcome = solve_watched(&method, &mut iterate, &mut |_, _, _| Verdict::Stop);
    assert_eq!(outcome.status, QpStatus::Interrupted);
}

#[test]
fn loads_without_a_potential_lead_back_what_lowers_the_energy_where_they_are_strong() {
    // Eigenvalues of [[-1, s], [-s, 2]]: one is negative for s^2 < 2, none for s^2 > 2.
    let contact = SparseRowsBuilder::new(2).finish();
    let matrices = Matrices {
        stiffness: rows(&[vec![-1.0, 0.0], vec![0.0, 2.0]]),
        coupling: None,
        stabilisation: None,
        contact: &contact,
        places: vec![0, 1],
        is_loose: false,
        may_be_indefinite: false,
        most_flops: f64::INFINITY,
    };
    for (strength, led_back) in [(0.5, 0), (1.4, 0), (1.42, 1), (3.0, 1)] {
        let skew = rows(&[vec![0.0, strength], vec![-strength, 0.0]]);
        let problem = (&matrices, Some(&skew));
        let found = inertia(problem, &[], &[1.0, 1.0], &mut Workspace::new()).expect("a factor");
        assert_eq!(
            (found.unstable, found.led_back),
            (1, Some(led_back)),
            "{strength}"
        );
    }
}

#[test]
fn a_cycle_without_end_ends_where_it_closes() {
    let problem = Problem::new(3);
    let outcome = solve_curved(&problem, 1e3, &mut problem.iterate(0));
    assert_eq!(outcome.status, QpStatus::ActiveSetCycle);
    assert!(outcome.set_changes < MOST_FACES / 2, "{outcome:?}");
}
