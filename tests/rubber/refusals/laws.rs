//! Faults of networks and foams.

use super::*;

fn van_der_waals([shear_modulus, locking_stretch, a, beta]: [f64; 4]) -> Scene {
    let law = RubberModel::VanDerWaals {
        shear_modulus,
        locking_stretch,
        a,
        beta,
    };
    rubber(law, None)
}

fn hyperfoam(mu: &[f64], alpha: &[f64], nu: &[f64]) -> Scene {
    let [mu, alpha, nu] = [mu, alpha, nu].map(<[f64]>::to_vec);
    rubber(RubberModel::Hyperfoam { mu, alpha, nu }, None)
}

#[test]
fn the_chains_of_a_network_have_a_length() {
    let path = "material.body.locking_stretch";
    for stretch in [0.0, 1.0, 3.0_f64.sqrt(), -5.0, f64::NAN, f64::INFINITY] {
        let scene = van_der_waals([1.0, stretch, 0.2, 0.0]);
        assert_refused(&scene, path, "above the square root of three");
    }
    assert_planned(&van_der_waals([1.0, 1.74, 0.2, 0.0]));
}

#[test]
fn a_network_has_a_modulus_an_interaction_and_a_share() {
    let nan = f64::NAN;
    for (numbers, key, word) in [
        ([0.0, 5.0, 0.2, 0.0], "shear_modulus", "above zero"),
        ([nan, 5.0, 0.2, 0.0], "shear_modulus", "above zero"),
        ([1.0, 5.0, -0.1, 0.0], "a", "at least zero"),
        ([1.0, 5.0, nan, 0.0], "a", "at least zero"),
        ([1.0, 5.0, 0.2, -0.1], "beta", "between zero and one"),
        ([1.0, 5.0, 0.2, 1.1], "beta", "between zero and one"),
        ([1.0, 5.0, 0.2, nan], "beta", "between zero and one"),
    ] {
        let path = format!("material.body.{key}");
        assert_refused(&van_der_waals(numbers), &path, word);
    }
}

#[test]
fn a_foam_has_moduli_exponents_and_poisson_ratios() {
    let nan = f64::NAN;
    let many = [1.0; 7];
    for (scene, key, word) in [
        (hyperfoam(&many, &many, &[0.1]), "mu", "1 to 6 terms, not 7"),
        (
            hyperfoam(&[1.0], &[2.0, 3.0], &[0.1]),
            "alpha",
            "1 exponents",
        ),
        (hyperfoam(&[1.0], &[0.0], &[0.1]), "alpha", "not be zero"),
        (hyperfoam(&[1.0], &[nan], &[0.1]), "alpha", "must be finite"),
        (hyperfoam(&[nan], &[2.0], &[0.1]), "mu", "must be finite"),
        (
            hyperfoam(&[1.0, -1.5], &[2.0, 3.0], &[0.1]),
            "mu",
            "the sum of mu",
        ),
        (hyperfoam(&[1.0], &[2.0], &[]), "nu", "one Poisson ratio"),
        (hyperfoam(&[1.0; 3], &[2.0; 3], &[0.1; 2]), "nu", "or 3 as"),
        (hyperfoam(&[1.0], &[2.0], &[0.5]), "nu", "below 0.5"),
        (hyperfoam(&[1.0], &[2.0], &[-1.0]), "nu", "above -1"),
        (hyperfoam(&[1.0], &[2.0], &[nan]), "nu", "above -1"),
        (
            hyperfoam(&[2.0, -1.0], &[2.0, 3.0], &[-0.4, 0.4]),
            "nu",
            "bulk modulus at rest",
        ),
    ] {
        assert_refused(&scene, &format!("material.body.{key}"), word);
    }
    let blatz_ko = |shear_modulus| RubberModel::BlatzKo { shear_modulus };
    let flat = rubber(blatz_ko(0.0), None);
    assert_refused(&flat, "material.body.shear_modulus", "above zero");
    let doubled = rubber(blatz_ko(1.0), Some(10.0));
    assert_refused(&doubled, "material.body.bulk_modulus", "leave it out");
}

#[test]
fn foams_of_every_poisson_ratio_are_planned_with_it() {
    for nu in [-0.95, 0.0, 0.3, 0.49] {
        let report = assert_planned(&hyperfoam(&[1.0], &[8.0], &[nu]));
        let material = report.decisions.iter().find(|one| one.what == "material");
        let exact = format!("hyperfoam, Poisson ratio {nu:.3} at rest");
        assert_eq!(material.expect("a law").choice, exact);
        // Where it is below zero the volume gives way.
        let is_stable = report.warnings.is_empty();
        assert_eq!(is_stable, nu >= 0.0, "{:?}", report.warnings);
    }
    let report = assert_planned(&hyperfoam(&[2.0, -1.0], &[2.0, 8.0], &[0.0]));
    let said = "unstable in uniaxial tension beyond a stretch of 1.12";
    let mut warnings = report.warnings.iter();
    assert!(warnings.any(|one| one.contains(said)), "{report:?}");
}
