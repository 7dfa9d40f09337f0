//! Constants of laws of rubber from test curves: published points, and curves of known constants.

mod treloar;

use signorini::calibration::{
    Calibrated, CalibrationError, Test, TestKind, Weighting, calibrate, stress,
};
use signorini::scene::RubberModel;

fn ogden(terms: &[(f64, f64)]) -> RubberModel {
    RubberModel::Ogden {
        mu: terms.iter().map(|term| term.0).collect(),
        alpha: terms.iter().map(|term| term.1).collect(),
    }
}

fn laws() -> Vec<RubberModel> {
    vec![
        RubberModel::NeoHookean { shear_modulus: 0.8 },
        RubberModel::MooneyRivlin {
            c10: 0.3,
            c01: 0.05,
        },
        RubberModel::Yeoh {
            c10: 0.25,
            c20: -0.003,
            c30: 2e-4,
        },
        ogden(&[(0.6, 1.3), (0.01, 5.0)]),
        RubberModel::Gent {
            shear_modulus: 0.4,
            limit: 40.0,
        },
        RubberModel::ArrudaBoyce {
            mu: 0.35,
            locking_stretch: 3.2,
        },
        RubberModel::VanDerWaals {
            shear_modulus: 0.5,
            locking_stretch: 7.0,
            a: 0.25,
            beta: 0.1,
        },
    ]
}

/// A law to begin from that is another one of its family.
fn elsewhere(law: &RubberModel) -> RubberModel {
    match law {
        RubberModel::NeoHookean { .. } => RubberModel::NeoHookean { shear_modulus: 5.0 },
        RubberModel::MooneyRivlin { .. } => RubberModel::MooneyRivlin { c10: 3.0, c01: 1.0 },
        RubberModel::Yeoh { .. } => RubberModel::Yeoh {
            c10: 2.0,
            c20: 0.0,
            c30: 0.0,
        },
        RubberModel::Gent { .. } => RubberModel::Gent {
            shear_modulus: 2.0,
            limit: 300.0,
        },
        RubberModel::ArrudaBoyce { .. } => RubberModel::ArrudaBoyce {
            mu: 1.0,
            locking_stretch: 9.0,
        },
        RubberModel::VanDerWaals { .. } => RubberModel::VanDerWaals {
            shear_modulus: 1.0,
            locking_stretch: 12.0,
            a: 0.0,
            beta: 0.0,
        },
        RubberModel::Ogden { .. }
        | RubberModel::Polynomial { .. }
        | RubberModel::Hyperfoam { .. }
        | RubberModel::BlatzKo { .. } => ogden(&[(0.5, 2.0), (-0.1, -2.0)]),
    }
}

/// All constants, terms of Ogden's law in the order of their exponents.
fn numbers(law: &RubberModel) -> Vec<f64> {
    match law {
        RubberModel::NeoHookean { shear_modulus } => vec![*shear_modulus],
        RubberModel::MooneyRivlin { c10, c01 } => vec![*c10, *c01],
        RubberModel::Yeoh { c10, c20, c30 } => vec![*c10, *c20, *c30],
        RubberModel::Ogden { mu, alpha } => {
            let mut terms: Vec<[f64; 2]> = alpha.iter().zip(mu).map(|(a, m)| [*a, *m]).collect();
            terms.sort_by(|a, b| a[0].total_cmp(&b[0]));
            terms.concat()
        }
        RubberModel::Gent {
            shear_modulus,
            limit,
        } => vec![*shear_modulus, *limit],
        RubberModel::ArrudaBoyce {
            mu,
            locking_stretch,
        } => vec![*mu, *locking_stretch],
        RubberModel::VanDerWaals {
            shear_modulus,
            locking_stretch,
            a,
            beta,
        } => vec![*shear_modulus, *locking_stretch, *a, *beta],
        RubberModel::Polynomial { coefficients } => coefficients.to_vec(),
        RubberModel::Hyperfoam { .. } | RubberModel::BlatzKo { .. } => Vec::new(),
    }
}

/// Curves of all three kinds up to stretches of five, 3.6 and three, with relative errors.
fn curves(law: &RubberModel, error: &mut dyn FnMut() -> f64) -> Vec<Test> {
    let ranges = [
        (TestKind::Uniaxial, 5.0),
        (TestKind::Planar, 3.6),
        (TestKind::Equibiaxial, 3.0),
    ];
    let mut tests = Vec::new();
    for (kind, most) in ranges {
        for step in 1..=20 {
            let stretch = 1.0 + (most - 1.0) * f64::from(step) / 20.0;
            let exact = stress(law, kind, stretch).expect("a valid law");
            let stress = exact * (1.0 + error());
            tests.push(Test {
                kind,
                stretch,
                stress,
            });
        }
    }
    tests
}

fn fit(law: &RubberModel, tests: &[Test]) -> Calibrated {
    calibrate(law, tests, Weighting::Relative).expect("there is a fit")
}

#[test]
fn closed_forms_are_those_of_the_books() {
    let law = RubberModel::MooneyRivlin {
        c10: 0.3,
        c01: 0.07,
    };
    let at = |kind, l: f64| stress(&law, kind, l).expect("a valid law");
    for l in [0.5_f64, 1.0, 1.7, 4.0] {
        let rivlin = 2.0 * (l - l.powi(-2)) * (0.3 + 0.07 / l);
        assert!((at(TestKind::Uniaxial, l) - rivlin).abs() < 1e-13);
        let shear = 2.0 * (l - l.powi(-3)) * (0.3 + 0.07);
        assert!((at(TestKind::Planar, l) - shear).abs() < 1e-13);
        let biaxial = 2.0 * (l - l.powi(-5)) * (0.3 + 0.07 * l * l);
        assert!((at(TestKind::Equibiaxial, l) - biaxial).abs() < 1e-12);
    }
}

#[test]
fn constants_are_recovered_from_curves_of_known_ones() {
    for law in laws() {
        let found = fit(&elsewhere(&law), &curves(&law, &mut || 0.0));
        for (known, found) in numbers(&law).iter().zip(numbers(&found.model)) {
            let error = (found - known).abs();
            assert!(error < 1e-6 * known.abs(), "{law:?}: {found} for {known}");
        }
        assert!(found.misfit < 1e-9, "{law:?}: {}", found.misfit);
    }
}

/// Numbers of a normal distribution (G. E. P. Box, M. E. Muller), the same in every run.
struct Normal(u64);

impl Normal {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005);
        self.0 = self.0.wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn next(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

#[test]
fn noise_of_two_per_cent_leaves_constants_within_their_intervals() {
    let law = RubberModel::MooneyRivlin {
        c10: 0.3,
        c01: 0.05,
    };
    let mut noise = Normal(1);
    let (mut within, rounds) = ([0; 2], 200);
    for _ in 0..rounds {
        let found = fit(&law, &curves(&law, &mut || 0.02 * noise.next()));
        for (count, (known, one)) in within
            .iter_mut()
            .zip([0.3, 0.05].iter().zip(&found.constants))
        {
            let half_width = one.half_width.expect("it is determined");
            *count += u32::from((one.value - known).abs() <= half_width);
        }
        assert!((0.01..0.03).contains(&found.misfit), "{}", found.misfit);
    }
    // 95 % of 200, give or take three standard deviations of such a count.
    assert!(
        within.iter().all(|count| (180..=199).contains(count)),
        "{within:?}"
    );
}

#[test]
fn treloars_points_are_met_by_three_laws_as_by_an_independent_fit() {
    let tests = treloar::points();
    for (law, constants, misfit) in treloar::fits() {
        let found = fit(&law, &tests);
        for (known, found) in constants.iter().zip(numbers(&found.model)) {
            assert!(
                (found - known).abs() < 2e-4 * known.abs(),
                "{law:?}: {found} for {known}"
            );
        }
        assert!(
            (found.misfit - misfit).abs() < 1e-4,
            "{law:?}: {}",
            found.misfit
        );
    }
}

#[test]
fn a_law_that_loses_stability_says_where() {
    let tests: Vec<Test> = treloar::points();
    let uniaxial: Vec<Test> = tests
        .into_iter()
        .filter(|one| one.kind == TestKind::Uniaxial)
        .collect();
    let start = RubberModel::Polynomial {
        coefficients: [0.0; 9],
    };
    let found = fit(&start, &uniaxial);
    assert!(!found.unstable.is_empty());
    for limit in &found.unstable {
        assert!((0.1..=10.0).contains(&limit.stretch), "{limit:?}");
    }
    let stable = fit(&RubberModel::NeoHookean { shear_modulus: 1.0 }, &uniaxial);
    assert!(stable.unstable.is_empty());
}

#[test]
fn what_gives_no_fit_is_refused_by_name() {
    let law = RubberModel::MooneyRivlin {
        c10: 0.3,
        c01: 0.05,
    };
    let tests = curves(&law, &mut || 0.0);
    let refused = |law: &RubberModel, tests: &[Test]| {
        calibrate(law, tests, Weighting::Absolute).expect_err("it is refused")
    };
    let few = refused(&law, &tests[..1]);
    assert_eq!(
        few,
        CalibrationError::TooFew {
            points: 1,
            constants: 2
        }
    );
    let foam = refused(&RubberModel::BlatzKo { shear_modulus: 1.0 }, &tests);
    assert_eq!(foam, CalibrationError::Compressible { law: "blatz-ko" });
    for stretch in [0.0, -1.0, f64::NAN, 1e9] {
        let mut wrong = tests.clone();
        wrong[3].stretch = stretch;
        assert_eq!(
            refused(&law, &wrong),
            CalibrationError::NoPoint { number: 4 }
        );
    }
}
