//! Optimality conditions of random problems over products of sets.

use super::*;
use crate::linalg::DenseMatrix;
use crate::linalg::vector::largest;
use crate::saddle::{AdmissibleSet, Components, Discs, SetPart, SetPoint};
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

proptest! {
    #[test]
    fn the_solution_satisfies_the_optimality_conditions(
        entries in proptest::collection::vec(-1.0..1.0_f64, 36),
        linear in proptest::collection::vec(-1.0..1.0_f64, 6),
        guess in proptest::collection::vec(any::<bool>(), 6),
    ) {
        let matrix = positive_definite(&entries, 6);
        let set = ProductSet::Uniform(part(6, AdmissibleSet::NonNegative));
        let solution = solve(&matrix, &linear, set, &closed(&guess)).expect("positive definite");
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
        let solution = solve(&matrix, &linear, set, &closed(&guess)).expect("positive definite");
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
        let solution = solve(&matrix, &linear, set, &guess).expect("positive definite");
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
    let failed = solve(&matrix, &[1.0], set, &[Status::Stick]);
    assert!(matches!(failed, Err(DenseConeError::Factorise(_))));
}
