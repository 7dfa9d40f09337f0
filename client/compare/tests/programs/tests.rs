//! All methods against the optimality conditions of the same small problems.

use super::samples::{
    CONTACTS, Exact, Matrices, Problem, assert_optimal, block, equality, identity, schur, solve,
    solve_watched,
};
use super::*;
use crate::inequality::mprgp::Mprgp;
use crate::krylov::{Outcome, Verdict};
use crate::linalg::DenseMatrix;
use crate::linalg::samples::rows;
use crate::linalg::vector::{dot, largest};
use crate::saddle::{
    AdmissibleSet, Components, Discs, Metric, MultiplierBlock, ProductSet, SetPart, Status,
};
use signorini::Comparisons as _;
use signorini::scene::{ContactMethod, Named};
use signorini_compare::Methods;

/// The solver of `problem` by one of all methods.
fn choose<'a>(method: ContactMethod, problem: QpProblem<'a>) -> Box<dyn InequalitySolver + 'a> {
    match method {
        ContactMethod::OneLevel => Box::new(OneLevel::new(problem)),
        ContactMethod::Mprgp => Box::new(Mprgp { problem }),
        ContactMethod::ActiveSet
        | ContactMethod::Nested
        | ContactMethod::ConjugateProjectedGradient
        | ContactMethod::ProjectedArrowHurwicz
        | ContactMethod::ThresholdIteration
        | ContactMethod::RegularisedFriction => Methods.contact(method, problem).expect("a method"),
    }
}

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
    for &method in ContactMethod::ALL {
        for seed in 0..20 {
            let problem = Problem::new(seed);
            let matrices = matrices(&problem);
            let mut iterate = problem.iterate(0);
            let outcome = solve(
                &*choose(method, matrices.problem(&[matrices.unilateral()])),
                &mut iterate,
            );
            assert_eq!(outcome.products > 0, method.is_nested());
            // Nothing keeps sets from returning, nor bounds the number of fixed steps.
            let limit = QpStatus::Krylov(Outcome::IterationLimit);
            let is_known = match method {
                ContactMethod::ActiveSet => outcome.status == QpStatus::ActiveSetCycle,
                ContactMethod::ProjectedArrowHurwicz => outcome.status == limit,
                ContactMethod::OneLevel
                | ContactMethod::Nested
                | ContactMethod::Mprgp
                | ContactMethod::ConjugateProjectedGradient
                | ContactMethod::ThresholdIteration
                | ContactMethod::RegularisedFriction => false,
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
    for &method in ContactMethod::ALL {
        let mut problem = Problem::new(3);
        let (matrices, equality) = (matrices(&problem), equality());
        let coupling = rows(&equality);
        let metric = Exact::new(&[vec![0.5 * schur(&matrices.inverse, &equality).at(0, 0)]]);
        let blocks = [block(&coupling, &metric), matrices.unilateral()];
        let parts = QpProblem {
            curvature: Some(&identity(0.02)),
            augmentation: None,
            ..matrices.problem(&blocks)
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
    for &method in ContactMethod::ALL.iter().filter(|m| m.is_nested()) {
        let problem = Problem::new(1);
        let matrices = matrices(&problem);
        let blocks = [matrices.unilateral()];
        let parts = QpProblem {
            curvature: Some(&identity(0.02)),
            augmentation: None,
            ..matrices.problem(&blocks)
        };
        let mut calls = 0;
        let mut iterate = problem.iterate(0);
        let outcome = solve_watched(&*choose(method, parts), &mut iterate, &mut |_, _, _| {
            calls += 1;
            if calls < 3 {
                Verdict::Continue
            } else {
                Verdict::Stop
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
    let outcome = solve(
        &*choose(method, matrices.problem(&[matrices.unilateral()])),
        &mut iterate,
    );
    let spent = QpStatus::Krylov(Outcome::IterationLimit);
    assert_eq!((outcome.status, outcome.products), (spent, 400));
    assert!(iterate.blocks[0].multiplier.iter().any(|&l| l > 0.0));
}

fn part(size: usize, set: AdmissibleSet<'_>) -> SetPart<'_> {
    SetPart { size, set }
}

/// Force balance, and x = P(x - s): the law of every convex set.
fn assert_lawful(problem: &Problem, set: ProductSet<'_>, iterate: &QpIterate) {
    let (u, contact) = (&iterate.displacement, &iterate.blocks[0]);
    let mut back = contact.multiplier.clone();
    for (k, row) in problem.coupling.iter().enumerate() {
        back[k] -= problem.gap[k] - dot(row, u);
    }
    set.project(&mut back);
    for (back, x) in back.iter().zip(&contact.multiplier) {
        assert!((back - x).abs() < 1e-9, "{iterate:?}");
    }
    for i in 0..samples::SIZE {
        let columns = problem.coupling.iter().zip(&contact.multiplier);
        let pushed: f64 = columns.map(|(row, l)| row[i] * l).sum();
        let balance = problem.force[i] - dot(&problem.stiffness[i], u) - pushed;
        assert!(balance.abs() < 1e-9, "{balance}");
    }
}

#[test]
fn every_method_bears_a_support_that_also_pulls_beside_contact() {
    let parts = [
        part(2, AdmissibleSet::NonNegative),
        part(2, AdmissibleSet::Free),
    ];
    let set = ProductSet::Parts(&parts);
    let mut solved = 0;
    for &method in ContactMethod::ALL {
        for seed in 0..10 {
            let problem = Problem::new(seed);
            let matrices = matrices(&problem);
            let contact = matrices.unilateral();
            let blocks = [MultiplierBlock { set, ..contact }];
            let mut iterate = problem.iterate(0);
            let outcome = solve(&*choose(method, matrices.problem(&blocks)), &mut iterate);
            let may_fail = matches!(
                method,
                ContactMethod::ActiveSet | ContactMethod::ProjectedArrowHurwicz
            );
            if outcome.status == QpStatus::Solved {
                assert_lawful(&problem, set, &iterate);
                assert_eq!(iterate.blocks[0].status[2..], [Status::Stick; 2]);
                solved += 1;
            } else {
                assert!(may_fail, "{method:?} {seed} {outcome:?}");
            }
        }
    }
    assert!(solved > 50, "{solved}");
}

#[test]
fn methods_of_general_sets_find_where_tractions_stick_and_slip() {
    let discs = Discs {
        radii: &[0.05],
        components: Components::Two,
    };
    let parts = [
        part(1, AdmissibleSet::Free),
        part(1, AdmissibleSet::NonNegative),
        part(2, AdmissibleSet::Discs(discs)),
    ];
    let set = ProductSet::Parts(&parts);
    let mut slipping = 0;
    for method in [ContactMethod::OneLevel, ContactMethod::Nested] {
        for seed in 0..20 {
            let problem = Problem::new(seed);
            let matrices = problem.matrices();
            let contact = matrices.unilateral();
            let blocks = [MultiplierBlock { set, ..contact }];
            let mut iterate = problem.iterate(0);
            let outcome = solve(&*choose(method, matrices.problem(&blocks)), &mut iterate);
            assert_eq!(outcome.status, QpStatus::Solved, "{method:?} {seed}");
            assert_lawful(&problem, set, &iterate);
            slipping += usize::from(iterate.blocks[0].status[2] == Status::Slip);
        }
    }
    assert!((10..50).contains(&slipping), "{slipping}");
}

#[test]
fn what_a_method_does_not_take_is_refused_and_left_alone() {
    let problem = Problem::new(0);
    let matrices = matrices(&problem);
    let discs = AdmissibleSet::Discs(Discs {
        radii: &[1.0; CONTACTS],
        components: Components::One,
    });
    for method in [
        ContactMethod::ActiveSet,
        ContactMethod::Mprgp,
        ContactMethod::ConjugateProjectedGradient,
    ] {
        let blocks = [matrices.contact(discs)];
        let mut iterate = problem.iterate(0);
        let outcome = solve(&*choose(method, matrices.problem(&blocks)), &mut iterate);
        assert_eq!(outcome.status, QpStatus::Unsupported, "{method:?}");
        assert!(largest(&iterate.blocks[0].multiplier) <= 0.0);
    }
    let metric = Exact::new(&[vec![1.0; 1]]);
    let signed = MultiplierBlock {
        metric: Metric::Inverse(&metric),
        ..matrices.unilateral()
    };
    for &method in ContactMethod::ALL {
        for blocks in [
            &[][..],
            &[signed][..],
            &[signed, matrices.unilateral()],
            &[matrices.unilateral(), matrices.unilateral()],
        ] {
            let mut iterate = problem.iterate(0);
            let contact = iterate.blocks[0].clone();
            iterate.blocks = vec![contact; blocks.len()];
            let outcome = solve(&*choose(method, matrices.problem(blocks)), &mut iterate);
            assert_eq!(outcome.status, QpStatus::Unsupported, "{method:?}");
        }
    }
}
