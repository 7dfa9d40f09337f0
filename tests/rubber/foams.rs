//! Homogeneous states of compressible foams, which the elements hold exactly on any mesh: with the
//! stretches l_k and
//!
//! ```text
//! tau_k = sum 2 mu / alpha (l_k^alpha - J^(-alpha beta))
//! ```
//!
//! the nominal stresses are tau_k / l_k, free directions stretch so that theirs is zero
//! (l^(-nu) in uniaxial stretch where all terms have one nu), and the true stress of Blatz and Ko
//! is mu (1 - l^(-5/2)). A foam that does not widen under a press does not ask whether that is rough.

use std::sync::Arc;

use crate::common::meshes::{cube, irregular, mesh, square};
use crate::common::scenes::{
    HELD, in_parts, obstacle, plane, probe, pull, push, rollers, rubber, support, traction,
};
use crate::common::{assert_converged, solve};
use signorini::scene::{RubberModel, Support};
use signorini::{Mesh, Scene, Step, StepReport};

const TOLERANCE: f64 = 1e-10;
const EXACT: f64 = 1e-8;
/// Of a pressure, which is a small unknown times what it carries of the bulk modulus.
const PRESSURE: f64 = 1e-6;

fn foam(mu: &[f64], alpha: &[f64], nu: &[f64]) -> RubberModel {
    let [mu, alpha, nu] = [mu, alpha, nu].map(<[f64]>::to_vec);
    RubberModel::Hyperfoam { mu, alpha, nu }
}

fn laws() -> [RubberModel; 6] {
    [
        foam(&[1.3], &[8.0], &[0.0]),
        foam(&[0.7, 0.4], &[3.0, -2.5], &[0.3, 0.05]),
        foam(&[1.0], &[2.0], &[-0.3]),
        foam(&[1.0], &[2.0], &[0.42]),
        foam(&[1.0, 0.2], &[2.0, -2.0], &[0.45]),
        RubberModel::BlatzKo { shear_modulus: 0.9 },
    ]
}

/// mu, alpha and beta of each term.
fn terms(law: &RubberModel) -> Vec<[f64; 3]> {
    let ([mu, alpha], nu) = if let RubberModel::Hyperfoam { mu, alpha, nu } = law {
        ([mu.clone(), alpha.clone()], nu.clone())
    } else if let RubberModel::BlatzKo { shear_modulus } = law {
        ([vec![*shear_modulus], vec![-2.0]], vec![0.25])
    } else {
        unreachable!("{law:?} is no foam")
    };
    let ratios = nu.iter().chain(std::iter::repeat(&nu[0]));
    let pairs = mu.iter().zip(&alpha).zip(ratios);
    pairs
        .map(|((mu, alpha), nu)| [*mu, *alpha, nu / (1.0 - 2.0 * nu)])
        .collect()
}

/// Energy and nominal stresses.
fn at(law: &RubberModel, stretches: [f64; 3]) -> (f64, [f64; 3]) {
    let jacobian: f64 = stretches.iter().product();
    let (mut energy, mut stress) = (0.0, [0.0; 3]);
    for [mu, alpha, beta] in terms(law) {
        let held = jacobian.powf(-alpha * beta);
        let volume = if beta == 0.0 {
            -alpha * jacobian.ln()
        } else {
            (held - 1.0) / beta
        };
        let powers = stretches.map(|l| l.powf(alpha));
        energy += 2.0 * mu / alpha.powi(2) * (powers.iter().sum::<f64>() - 3.0 + volume);
        for k in 0..3 {
            stress[k] += 2.0 * mu / alpha * (powers[k] - held) / stretches[k];
        }
    }
    (energy, stress)
}

/// The stretch of the free directions, where that of axis `free` bears no stress.
fn free_stretch(law: &RubberModel, free: usize, stretches: impl Fn(f64) -> [f64; 3]) -> f64 {
    let (mut least, mut most) = (0.3_f64, 3.0_f64);
    for _ in 0..60 {
        let middle = 0.5 * (least + most);
        if at(law, stretches(middle)).1[free] > 0.0 {
            most = middle;
        } else {
            least = middle;
        }
    }
    0.5 * (least + most)
}

fn solid() -> Arc<Mesh> {
    mesh(irregular(cube(2), 2))
}

fn body(law: &RubberModel) -> Scene {
    let mut scene = rubber(law.clone(), None);
    scene.solver.tolerance = TOLERANCE;
    scene.probes = vec![probe("inside", [0.4, 0.45, 0.3])];
    scene
}

/// Rollers, and the supports that stretch.
fn stretched(law: &RubberModel, stretching: &[(&str, usize, f64)]) -> Scene {
    let mut scene = body(law);
    scene.supports = rollers();
    let side = |&(side, axis, stretch): &(&str, usize, f64)| -> Support {
        let mut held = [None; 3];
        held[axis] = Some(stretch - 1.0);
        support(side, held)
    };
    scene.supports.extend(stretching.iter().map(side));
    scene
}

/// The last of the increments, all of which must converge.
fn last(scene: &Scene, step: &Step, mesh: &Arc<Mesh>) -> StepReport {
    let mut reports = solve(scene, std::slice::from_ref(step), mesh);
    reports.iter().for_each(assert_converged);
    reports.pop().expect("an increment")
}

fn parts(increments: u32) -> Step {
    in_parts(Step::default(), increments)
}

fn assert_near(name: &str, (value, exact): (f64, f64), tolerance: f64) {
    let error = (value - exact).abs() / exact.abs().max(1.0);
    assert!(error <= tolerance, "{name}: {value} not {exact}, {error:e}");
}

/// Checks forces, energy, volume and the measure of its change.
fn assert_state(law: &RubberModel, stretches: [f64; 3], report: &StepReport) {
    let (energy, stress) = at(law, stretches);
    for (side, axis) in [("x1", 0), ("y1", 1), ("z1", 2)] {
        if let Some(own) = report.supports.get(side) {
            let told = format!("{law:?} {stretches:?} {side}");
            assert_near(&told, (own.force[axis], stress[axis]), EXACT);
        }
    }
    let jacobian: f64 = stretches.iter().product();
    assert_near("energy", (report.strain_energy, energy), EXACT);
    assert_near("volume", (report.volume_ratio, jacobian), EXACT);
    let bulk: f64 = terms(law)
        .iter()
        .map(|[mu, _, beta]| 2.0 * mu * (1.0 / 3.0 + beta))
        .sum();
    let pressure = report.probes["inside"].pressure.expect("a pressure");
    assert_near(
        "pressure",
        (pressure, bulk * (1.0 - jacobian)),
        PRESSURE * (1.0 + bulk),
    );
}

#[test]
fn uniaxial_stretch() {
    for law in laws() {
        for s in [1.5, 0.5] {
            let scene = stretched(&law, &[("x1", 0, s)]);
            let report = last(&scene, &parts(4), &solid());
            let side = free_stretch(&law, 1, |side| [s, side, side]);
            assert_state(&law, [s, side, side], &report);
        }
    }
}

#[test]
fn one_poisson_ratio_is_that_of_logarithmic_strains() {
    for (law, nu) in [
        (foam(&[1.0, 0.2], &[6.0, -2.0], &[0.3]), 0.3),
        (foam(&[1.0], &[2.0], &[-0.3]), -0.3_f64),
        (RubberModel::BlatzKo { shear_modulus: 0.9 }, 0.25),
    ] {
        let s: f64 = 0.6;
        let scene = stretched(&law, &[("x1", 0, s)]);
        let report = last(&scene, &parts(4), &solid());
        assert_near(
            "volume",
            (report.volume_ratio, s.powf(1.0 - 2.0 * nu)),
            EXACT,
        );
        if matches!(law, RubberModel::BlatzKo { .. }) {
            // mu (1 - l^(-5/2)) on the deformed section of l^(-1/2).
            let exact = 0.9 * (1.0 - s.powf(-2.5)) * s.powf(-0.5);
            assert_near("force", (report.supports["x1"].force[0], exact), EXACT);
        }
    }
}

#[test]
fn equibiaxial_stretch() {
    for law in laws() {
        for s in [1.4, 0.7] {
            let scene = stretched(&law, &[("x1", 0, s), ("y1", 1, s)]);
            let report = last(&scene, &parts(4), &solid());
            let side = free_stretch(&law, 2, |side| [s, s, side]);
            assert_state(&law, [s, s, side], &report);
        }
    }
}

#[test]
fn a_change_of_volume_alone() {
    for law in laws() {
        for s in [1.2, 0.6] {
            let scene = stretched(&law, &[("x1", 0, s), ("y1", 1, s), ("z1", 2, s)]);
            let report = last(&scene, &parts(4), &solid());
            assert_state(&law, [s; 3], &report);
        }
    }
}

#[test]
fn plane_strain_is_planar_stretch() {
    for law in laws() {
        for s in [1.4, 0.6] {
            let mut scene = body(&law);
            scene.probes = vec![probe("inside", [0.4, 0.45, 0.0])];
            scene.supports = vec![
                support("x0", [Some(0.0), None, None]),
                support("y0", [None, Some(0.0), None]),
                support("x1", [Some(s - 1.0), None, None]),
            ];
            let report = last(&scene, &parts(4), &mesh(irregular(square(3), 3)));
            let side = free_stretch(&law, 1, |side| [s, side, 1.0]);
            assert_state(&law, [s, side, 1.0], &report);
        }
    }
}

#[test]
fn simple_shear() {
    let shear: f64 = 0.5;
    let stretch = 0.5 * shear + (1.0 + 0.25 * shear * shear).sqrt();
    // The principal axes of F F^T lie at atan(1 / l); the volume stays.
    let (sine, cosine) = (1.0 / stretch).atan().sin_cos();
    for law in laws() {
        let stretches = [stretch, 1.0, 1.0 / stretch];
        let (energy, nominal) = at(&law, stretches);
        let [most, _, least] = [0, 1, 2].map(|k| nominal[k] * stretches[k]);
        let along = most * cosine * cosine + least * sine * sine;
        let across = most * sine * sine + least * cosine * cosine;
        let mixed = (most - least) * sine * cosine;
        let side = [along - shear * mixed, mixed - shear * across];
        let mut scene = body(&law);
        scene.supports = vec![support("z0", HELD), support("z1", HELD)];
        scene.tractions = vec![
            traction("x1", [side[0], 0.0, side[1]]),
            traction("x0", [-side[0], 0.0, -side[1]]),
        ];
        let step = pull("z1", [Some(shear), None, None], 4);
        let report = last(&scene, &step, &solid());
        let force = report.supports["z1"].force;
        assert_near("shear", (force[0], mixed), EXACT);
        assert_near("normal", (force[2], across), EXACT);
        assert_near("energy", (report.strain_energy, energy), EXACT);
    }
}

/// A cube on its base under a press, both rough or smooth, down to this part of its height; the force.
fn pressed(law: &RubberModel, friction: f64, height: f64) -> f64 {
    let mut scene = rubber(law.clone(), None);
    scene.solver.tolerance = 1e-8;
    scene.supports = if friction > 0.0 {
        vec![support("z0", HELD)]
    } else {
        rollers()
    };
    let shape = plane([0.0, 0.0, 1.0], [0.0, 0.0, -1.0]);
    let mut press = obstacle("press", "z1", shape);
    press.friction = friction;
    scene.obstacles = vec![press];
    let step = in_parts(push("press", [0.0, 0.0, height - 1.0]), 5);
    let report = last(&scene, &step, &mesh(cube(3)));
    report.obstacles["press"].force[2].abs()
}

#[test]
fn a_foam_pressed_to_half_its_height_between_rough_plates_bears_what_it_does_between_smooth_ones() {
    for alpha in [2.0, 8.0, 20.0] {
        let law = foam(&[1.0], &[alpha], &[0.0]);
        let exact = at(&law, [1.0, 1.0, 0.5]).1[2].abs();
        for friction in [0.0, 0.8] {
            assert_near("force", (pressed(&law, friction, 0.5), exact), 1e-6);
        }
    }
}

#[test]
fn a_foam_that_widens_bears_more_between_rough_plates_than_smooth_ones_and_less_than_in_a_box() {
    // Farther down the free sides wrinkle between smooth plates.
    let height = 0.7;
    for law in [
        RubberModel::BlatzKo { shear_modulus: 1.0 },
        foam(&[1.0, 0.2], &[8.0, -2.0], &[0.2]),
    ] {
        let side = free_stretch(&law, 0, |side| [side, side, height]);
        let free = at(&law, [side, side, height]).1[2].abs();
        let closed_in = at(&law, [1.0, 1.0, height]).1[2].abs();
        assert_near("smooth", (pressed(&law, 0.0, height), free), 1e-6);
        let rough = pressed(&law, 0.8, height);
        assert!(
            free < rough && rough < closed_in,
            "{free} {rough} {closed_in}"
        );
    }
}
