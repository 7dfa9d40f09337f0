//! Optimality conditions of random problems over products of sets.

use super::*;
use crate::linalg::DenseMatrix;
use crate::linalg::vector::largest;
use crate::saddle::{AdmissibleSet, Components, Cones, Discs, FrictionBound, SetPart, SetPoint};
use proptest::prelude::*;

const SIZE: usize = 9;

fn positive_definite(entries: &[f64], size: usize) -> DenseMatrix {
    let mut matrix = DenseMatrix::zeros(size, size);
    for i in 0..size {
        for j in 0..size {
            let row = |k: usize| entries[k * size..(k + 1) * size].iter();
            let product: f64 = row(i).zip(row(j)).map(|(a, b)| a * b).sum();
            *matrix.at_mut(i, j) = product + if i == j { 0.1 } else { 0.0 };
        }
    }
    matrix
}

fn slope(matrix: &DenseMatrix, linear: &[f64], x: &[f64]) -> Vec<f64> {
    let mut slope = vec![0.0; x.len()];
    matrix.multiply(x, &mut slope);
    slope.iter_mut().zip(linear).for_each(|(s, q)| *s += q);
    slope
}

fn part(size: usize, set: AdmissibleSet<'_>) -> SetPart<'_> {
    SetPart { size, set }
}

fn closed(guess: &[bool]) -> Vec<Status> {
    guess.iter().map(|&g| Status::of_contact(g)).collect()
}

/// A large face far away, whose gap is wide, and two small ones that overlap the tool.
#[test]
fn what_small_faces_lack_is_no_rounding_of_a_wide_gap() {
    let mut matrix = DenseMatrix::zeros(3, 3);
    for (i, row) in [[1e2, 1e-9, 1e-9], [1e-9, 2e-9, 1e-9], [1e-9, 1e-9, 2e-9]]
        .iter()
        .enumerate()
    {
        for (j, entry) in row.iter().enumerate() {
            *matrix.at_mut(i, j) = *entry;
        }
    }
    let linear = [1e3, -3e-11, -3e-11];
    let set = ProductSet::Uniform(part(3, AdmissibleSet::NonNegative));
    let guess = (&[Status::Open; 3][..], &[0.0; 3][..]);
    let solution = solve(&matrix, &linear, set, guess).expect("positive definite");
    let expected = [0.0, 1e-2, 1e-2];
    for (found, expected) in solution.values.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-12, "{:?}", solution.values);
    }
}

proptest! {
    #[test]
    fn the_solution_satisfies_the_optimality_conditions(
        entries in proptest::collection::vec(-1.0..1.0_f64, 36),
        linear in proptest::collection::vec(-1.0..1.0_f64, 6),
        guess in proptest::collection::vec(any::<bool>(), 6),
    ) {
        let matrix = positive_definite(&entries, 6);
        let set = ProductSet::Uniform(part(6, AdmissibleSet::NonNegative));
        let solution = solve(&matrix, &linear, set, (&closed(&guess), &vec![0.0; linear.len()])).expect("positive definite");
        let slope = slope(&matrix, &linear, &solution.values);
        for i in 0..6 {
            let s = slope[i];
            prop_assert!(solution.values[i] >= -1e-10);
            prop_assert!(s >= -1e-10);
            prop_assert!((s * solution.values[i]).abs() < 1e-10);
        }
    }

    #[test]
    fn a_free_part_has_no_slope_left_whatever_its_sign(
        entries in proptest::collection::vec(-1.0..1.0_f64, 36),
        linear in proptest::collection::vec(-1.0..1.0_f64, 6),
        guess in proptest::collection::vec(any::<bool>(), 6),
    ) {
        let matrix = positive_definite(&entries, 6);
        let parts = [part(2, AdmissibleSet::NonNegative), part(4, AdmissibleSet::Free)];
        let set = ProductSet::Parts(&parts);
        let solution = solve(&matrix, &linear, set, (&closed(&guess), &vec![0.0; linear.len()])).expect("positive definite");
        let slope = slope(&matrix, &linear, &solution.values);
        for i in 0..2 {
            prop_assert!(solution.values[i] >= -1e-10 && slope[i] >= -1e-10);
            prop_assert!((slope[i] * solution.values[i]).abs() < 1e-10);
        }
        for i in 2..6 {
            prop_assert!(slope[i].abs() < 1e-10);
            prop_assert_eq!(solution.status[i], Status::Stick);
        }
    }

    /// Pressures, a support, tractions in space and in the plane, one with nothing to
    /// rub on. The condition -s in the normal cone at x reads x = P(x - s).
    #[test]
    fn tractions_that_slip_end_on_their_discs_against_the_slip(
        entries in proptest::collection::vec(-1.0..1.0_f64, SIZE * SIZE),
        linear in proptest::collection::vec(-1.0..1.0_f64, SIZE),
        radius in 0.01..1.0_f64,
    ) {
        let (radii, interval) = ([radius, 0.3], [radius, 0.0]);
        let discs = |radii, components| AdmissibleSet::Discs(Discs { radii, components });
        let parts = [
            part(2, AdmissibleSet::NonNegative),
            part(4, discs(&radii, Components::Two)),
            part(1, AdmissibleSet::Free),
            part(2, discs(&interval, Components::One)),
        ];
        let set = ProductSet::Parts(&parts);
        let matrix = positive_definite(&entries, SIZE);
        let guess = [Status::Open; SIZE];
        let solution = solve(&matrix, &linear, set, (&guess, &[0.0; SIZE])).expect("positive definite");
        let slope = slope(&matrix, &linear, &solution.values);
        let mut back = solution.values.clone();
        back.iter_mut().zip(&slope).for_each(|(x, s)| *x -= s);
        set.project(&mut back);
        back.iter_mut().zip(&solution.values).for_each(|(p, x)| *p -= x);
        prop_assert!(largest(&back) < 1e-9, "{:?}", back);
        prop_assert!(largest(&set.violation(&solution.values)) < 1e-12);
        let at = SetPoint {
            multiplier: &solution.values,
            residual: &slope,
            status: &solution.status,
        };
        prop_assert!(largest(&set.misfit(at)) < 1e-9, "{:?}", solution);
        prop_assert_eq!(solution.status[8], Status::Open);
    }
}

#[test]
fn an_indefinite_matrix_is_a_typed_failure() {
    let mut matrix = DenseMatrix::zeros(1, 1);
    *matrix.at_mut(0, 0) = -1.0;
    let set = ProductSet::Uniform(part(1, AdmissibleSet::Free));
    let failed = solve(&matrix, &[1.0], set, (&[Status::Stick], &[0.0]));
    assert!(matches!(failed, Err(DenseConeError::Factorise(_))));
}

/// Of pressures, then tractions of two numbers a point, then a support.
fn frictional(partners: &[u32], bounds: &[FrictionBound]) -> [SetPart<'static>; 2] {
    let cones = Cones {
        normals: 3,
        partners: partners.to_vec().leak(),
        bounds: bounds.to_vec().leak(),
        components: Components::Two,
    };
    [
        part(7, AdmissibleSet::Cones(cones)),
        part(2, AdmissibleSet::Free),
    ]
}

proptest! {
    /// Pressures push and leave, tractions stick or slip against their slip, on the disc
    /// that their pressure allows.
    #[test]
    fn friction_follows_coulombs_law(
        entries in proptest::collection::vec(-1.0..1.0_f64, SIZE * SIZE),
        linear in proptest::collection::vec(-1.0..1.0_f64, SIZE),
        friction in 0.0..0.6_f64,
        guess in proptest::collection::vec(any::<bool>(), SIZE),
    ) {
        let mut matrix = positive_definite(&entries, SIZE);
        (0..SIZE).for_each(|i| *matrix.at_mut(i, i) += 1.0);
        let bounds = [friction, 0.3].map(FrictionBound::Coulomb);
        let set = ProductSet::Pair(frictional(&[2, 0], &bounds));
        let solution = solve(&matrix, &linear, set, (&closed(&guess), &vec![0.0; linear.len()])).expect("a solution");
        let (x, s) = (&solution.values, slope(&matrix, &linear, &solution.values));
        for i in 0..3 {
            prop_assert!(x[i] >= 0.0 && s[i] >= -1e-8 && (x[i] * s[i]).abs() < 1e-8);
        }
        prop_assert!(largest(&s[7..]) < 1e-8);
        for (first, radius) in [(3, friction * x[2]), (5, 0.3 * x[0])] {
            let (t, slip) = (&x[first..first + 2], &s[first..first + 2]);
            let (size, way) = (t[0].hypot(t[1]), slip[0].hypot(slip[1]));
            prop_assert!(size <= radius * (1.0 + 1e-8));
            match solution.status[first] {
                Status::Stick => prop_assert!(way < 1e-8),
                Status::Slip => (0..2).for_each(|i| {
                    assert!((t[i] * way + radius * slip[i]).abs() < 1e-8, "{t:?} {slip:?}");
                }),
                Status::Open => prop_assert!(radius == 0.0),
            }
        }
    }
}

/// A. Klarbring's node (Ingenieur-Archiv 60, 1990): three states are at rest under one load
/// where friction is strong, one where it is weak.
#[test]
fn klarbrings_node_ends_in_one_of_its_states() {
    // Normal first; the inverse of the stiffness [[1, 2], [2, 5]] of (tangent, normal).
    let mut matrix = DenseMatrix::zeros(2, 2);
    for (i, row) in [[1.0, -2.0], [-2.0, 5.0]].iter().enumerate() {
        (0..2).for_each(|j| *matrix.at_mut(i, j) = row[j]);
    }
    let linear = [0.1, -0.75];
    let known = [[0.0, 0.0], [1.0, 0.55], [0.5, 0.3]];
    for (friction, states) in [(0.6, &known[..]), (0.3, &known[..1])] {
        for near in [[0.0, 0.0], [2.0, 1.0], [0.6, 0.4]] {
            let bounds = [FrictionBound::Coulomb(friction)];
            let cones = Cones {
                normals: 1,
                partners: &[0],
                bounds: &bounds,
                components: Components::One,
            };
            let set = ProductSet::Uniform(part(2, AdmissibleSet::Cones(cones)));
            let solution =
                solve(&matrix, &linear, set, (&[Status::Stick; 2], &near)).expect("a state");
            let is_known = |state: &&[f64; 2]| {
                let pairs = state.iter().zip(&solution.values);
                pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < 1e-12
            };
            assert!(
                states.iter().any(|state| is_known(&state)),
                "{friction} {solution:?}"
            );
        }
    }
}

/// One node of which the bound b = 1 opens what zero traction closes: at rest it touches without
/// pressure under t = 0.1 / 0.5, where n + 0.5 t - 0.1 = 0.
#[test]
fn a_node_that_its_bound_opens_and_nothing_else_does_rests_in_between() {
    let mut matrix = DenseMatrix::zeros(2, 2);
    for (i, row) in [[1.0, 0.5], [0.5, 1.0]].iter().enumerate() {
        (0..2).for_each(|j| *matrix.at_mut(i, j) = row[j]);
    }
    for (linear, t) in [([-0.1, -5.0], 0.2), ([-0.4, -5.0], 0.8)] {
        for near in [[0.0, 0.0], [1.0, 1.0], [0.1, -1.0]] {
            let cones = Cones {
                normals: 1,
                partners: &[0],
                bounds: &[FrictionBound::Tresca(1.0)],
                components: Components::One,
            };
            let set = ProductSet::Uniform(part(2, AdmissibleSet::Cones(cones)));
            let solution =
                solve(&matrix, &linear, set, (&[Status::Stick; 2], &near)).expect("a state");
            let [n, traction] = solution.values[..] else {
                panic!("{solution:?}");
            };
            assert!((0.0..1e-8).contains(&n), "{solution:?}");
            assert!((traction - t).abs() < 1e-8, "{solution:?}");
            assert_eq!(solution.status[1], Status::Slip);
        }
    }
}
