//! What every admissible set promises.

use super::*;
use crate::linalg::vector::{dot, largest, norm};
use proptest::prelude::*;

const SIZE: usize = 9;

/// Parts of all kinds; one disc has no radius.
fn parts<'a>(discs: &'a [f64; 2], intervals: &'a [f64; 2]) -> [SetPart<'a>; 4] {
    let part = |size, set| SetPart { size, set };
    let set = |radii, components| AdmissibleSet::Discs(Discs { radii, components });
    [
        part(2, AdmissibleSet::NonNegative),
        part(1, AdmissibleSet::Free),
        part(4, set(&discs[..], Components::Two)),
        part(2, set(&intervals[..], Components::One)),
    ]
}

fn vectors() -> impl Strategy<Value = Vec<f64>> {
    proptest::collection::vec(-2.0..2.0_f64, SIZE)
}

fn projected(set: ProductSet<'_>, x: &[f64]) -> Vec<f64> {
    let mut x = x.to_vec();
    set.project(&mut x);
    x
}

fn minus(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

proptest! {
    #[test]
    fn a_projection_stays_and_nothing_admissible_is_nearer(
        x in vectors(),
        other in vectors(),
        radius in 0.1..1.5_f64,
    ) {
        let (discs, intervals) = ([radius, 0.0], [radius, 0.5]);
        let parts = parts(&discs, &intervals);
        let set = ProductSet::Parts(&parts);
        let (p, q) = (projected(set, &x), projected(set, &other));
        prop_assert!(largest(&minus(&projected(set, &p), &p)) < 1e-15);
        prop_assert!(largest(&minus(&minus(&x, &p), &set.violation(&x))) < 1e-15);
        prop_assert!(norm(&minus(&x, &p)) <= norm(&minus(&x, &q)) + 1e-14);
        // The condition that makes p the nearest point of a convex set.
        prop_assert!(dot(&minus(&x, &p), &minus(&q, &p)) <= 1e-14);
    }

    /// With s = p - x the pair (p, s) is a solution of the law: -s is normal at p.
    #[test]
    fn at_a_projection_the_residual_fits_the_status(x in vectors(), radius in 0.1..1.5_f64) {
        let (discs, intervals) = ([radius, 0.0], [radius, 0.5]);
        let parts = parts(&discs, &intervals);
        let set = ProductSet::Parts(&parts);
        let p = projected(set, &x);
        let status = set.status(&p);
        let residual = minus(&p, &x);
        let at = SetPoint { multiplier: &p, residual: &residual, status: &status };
        prop_assert!(largest(&set.misfit(at)) < 1e-14);
        for i in 0..2 {
            prop_assert_eq!(status[i], Status::of_contact(x[i] > 0.0));
        }
        prop_assert_eq!(status[2], Status::Stick);
        let slips = norm(&x[3..5]) > radius;
        prop_assert_eq!(status[3], if slips { Status::Slip } else { Status::Stick });
        prop_assert_eq!(status[3], status[4]);
        prop_assert_eq!(&status[5..7], &[Status::Open; 2]);
        // A residual along the traction is no slip: it would feed energy.
        let wrong: Vec<f64> = residual.iter().map(|s| -s).collect();
        let at = SetPoint { multiplier: &p, residual: &wrong, status: &status };
        if slips {
            prop_assert!(norm(&minus(&set.misfit(at)[3..5], &wrong[3..5])) < 1e-14);
        }
    }

    #[test]
    fn the_longest_step_ends_on_the_edge(
        x in vectors(),
        direction in vectors(),
        radius in 0.1..1.5_f64,
    ) {
        let (discs, intervals) = ([radius, 0.3], [radius, 0.5]);
        let parts = parts(&discs, &intervals);
        let set = ProductSet::Parts(&parts);
        let start = projected(set, &x);
        let longest = set.longest_step(&start, &direction);
        prop_assert!(longest >= 0.0 && longest.is_finite());
        let after = |length: f64| -> Vec<f64> {
            start.iter().zip(&direction).map(|(x, d)| x + length * d).collect()
        };
        prop_assert!(largest(&set.violation(&after(longest))) < 1e-12);
        prop_assert!(largest(&set.violation(&after(longest + 1e-3))) > 0.0);
    }
}

#[test]
fn bounds_are_told_where_nothing_else_makes_the_set() {
    let (discs, intervals) = ([1.0; 2], [1.0; 2]);
    let parts = parts(&discs, &intervals);
    assert_eq!(ProductSet::Parts(&parts).lower_bounds(), None);
    let bounds = ProductSet::Parts(&parts[..2]).lower_bounds();
    assert_eq!(bounds, Some(vec![0.0, 0.0, f64::NEG_INFINITY]));
}

#[test]
fn no_set_hides_a_value_that_is_not_a_number() {
    let (discs, intervals) = ([1.0; 2], [1.0; 2]);
    for part in parts(&discs, &intervals) {
        let set = ProductSet::Uniform(part);
        let (x, zero) = (vec![f64::NAN; part.size], vec![0.0; part.size]);
        assert!(projected(set, &x).iter().all(|v| v.is_nan()), "{part:?}");
        assert!(set.violation(&x).iter().all(|v| v.is_nan()), "{part:?}");
        let at = SetPoint {
            multiplier: &zero,
            residual: &x,
            status: &set.status(&zero),
        };
        assert!(set.misfit(at).iter().all(|v| v.is_nan()), "{part:?}");
    }
}

#[test]
fn what_rounding_leaves_of_a_pressure_is_dropped_and_nothing_else() {
    let left = f64::EPSILON;
    for (set, expected) in [
        (AdmissibleSet::NonNegative, 0.0),
        (AdmissibleSet::Free, left),
    ] {
        let mut x = [left, 1e-3, left];
        set.drop_rounding(&mut x, &[-1.0, -1.0, 1.0]);
        assert_eq!(
            x.map(f64::to_bits),
            [expected, 1e-3, left].map(f64::to_bits)
        );
    }
}
