//! Homogeneous states of incompressible rubber, which Taylor-Hood elements hold
//! exactly on any mesh (Rivlin): with W1, W2 the slopes of the energy in the
//! invariants of B = F F^T, sigma = -q I + 2 W1 B - 2 W2 B^-1, and
//!
//! ```text
//! uniaxial     2 (W1 + W2 / s) (s - s^-2)
//! equibiaxial  2 (W1 + W2 s^2) (s - s^-5)
//! planar       2 (W1 + W2) (s - s^-3)
//! shear        s12 = 2 (W1 + W2) k, s11 - s33 = 2 W1 k^2, s22 - s33 = -2 W2 k^2
//! ```
//!
//! are the nominal stresses at stretch s and the true ones at shear k.

use std::sync::Arc;

use crate::common::meshes::{cube, irregular, mesh, square};
use crate::common::scenes::{HELD, in_parts, probe, pull, rollers, rubber, support, traction};
use crate::common::{assert_converged, solve};
use signorini::scene::{RubberModel, Support};
use signorini::{Mesh, Scene, Step, StepReport};

const TOLERANCE: f64 = 1e-10;
const EXACT: f64 = 1e-8;

fn solid() -> Arc<Mesh> {
    mesh(irregular(cube(2), 2))
}

fn plane() -> Arc<Mesh> {
    mesh(irregular(square(3), 3))
}

fn laws() -> [RubberModel; 7] {
    [
        RubberModel::MooneyRivlin { c10: 0.4, c01: 0.1 },
        RubberModel::NeoHookean { shear_modulus: 1.3 },
        RubberModel::Yeoh {
            c10: 0.5,
            c20: 0.05,
            c30: 0.01,
        },
        RubberModel::Polynomial {
            coefficients: [0.4, 0.1, 0.03, 0.02, 0.01, 0.004, 0.003, 0.002, 0.001],
        },
        RubberModel::Gent {
            shear_modulus: 1.1,
            limit: 20.0,
        },
        RubberModel::ArrudaBoyce {
            mu: 0.9,
            locking_stretch: 2.5,
        },
        RubberModel::VanDerWaals {
            shear_modulus: 0.9,
            locking_stretch: 3.5,
            a: 0.2,
            beta: 0.3,
        },
    ]
}

/// Nine terms of Rivlin's polynomial at a = i1 - 3, b = i2 - 3, and their slopes.
fn polynomial([c10, c01, c20, c11, c02, c30, c21, c12, c03]: [f64; 9], a: f64, b: f64) -> [f64; 3] {
    let linear = c10 * a + c01 * b;
    let square = c20 * a * a + c11 * a * b + c02 * b * b;
    let cubic = c30 * a * a * a + c21 * a * a * b + c12 * a * b * b + c03 * b * b * b;
    let first = c10 + 2.0 * c20 * a + c11 * b + 3.0 * c30 * a * a + 2.0 * c21 * a * b + c12 * b * b;
    let second =
        c01 + c11 * a + 2.0 * c02 * b + c21 * a * a + 2.0 * c12 * a * b + 3.0 * c03 * b * b;
    [linear + square + cubic, first, second]
}

/// Arruda and Boyce's five terms and their slope.
fn eight_chains(mu: f64, locking_stretch: f64, i1: f64) -> [f64; 3] {
    let n = locking_stretch * locking_stretch;
    let energy = 0.5 * (i1 - 3.0)
        + (i1.powi(2) - 9.0) / (20.0 * n)
        + 11.0 * (i1.powi(3) - 27.0) / (1050.0 * n.powi(2))
        + 19.0 * (i1.powi(4) - 81.0) / (7000.0 * n.powi(3))
        + 519.0 * (i1.powi(5) - 243.0) / (673_750.0 * n.powi(4));
    let slope = 0.5
        + i1 / (10.0 * n)
        + 11.0 * i1.powi(2) / (350.0 * n.powi(2))
        + 19.0 * i1.powi(3) / (1750.0 * n.powi(3))
        + 519.0 * i1.powi(4) / (134_750.0 * n.powi(4));
    [mu * energy, mu * slope, 0.0]
}

/// The van der Waals network at x = (1 - beta) i1 + beta i2 - 3, and its slopes.
fn network(mu: f64, [locking_stretch, a, beta]: [f64; 3], x: f64) -> [f64; 3] {
    let limit = locking_stretch.powi(2) - 3.0;
    let eta = (x / limit).sqrt();
    let energy = -limit * ((1.0 - eta).ln() + eta) - 2.0 / 3.0 * a * (0.5 * x).powf(1.5);
    let slope = 0.5 / (1.0 - eta) - 0.5 * a * (0.5 * x).sqrt();
    [energy, slope * (1.0 - beta), slope * beta].map(|one| mu * one)
}

/// Energy, W1 and W2 at the invariants of an isochoric F.
fn energy(law: &RubberModel, i1: f64, i2: f64) -> [f64; 3] {
    let [a, b] = [i1 - 3.0, i2 - 3.0];
    match *law {
        RubberModel::MooneyRivlin { c10, c01 } => [c10 * a + c01 * b, c10, c01],
        RubberModel::NeoHookean { shear_modulus } => {
            [0.5 * shear_modulus * a, 0.5 * shear_modulus, 0.0]
        }
        RubberModel::Yeoh { c10, c20, c30 } => [
            c10 * a + c20 * a * a + c30 * a * a * a,
            c10 + 2.0 * c20 * a + 3.0 * c30 * a * a,
            0.0,
        ],
        RubberModel::Polynomial { coefficients } => polynomial(coefficients, a, b),
        RubberModel::Gent {
            shear_modulus: mu,
            limit,
        } => [
            -0.5 * mu * limit * (1.0 - a / limit).ln(),
            0.5 * mu / (1.0 - a / limit),
            0.0,
        ],
        RubberModel::ArrudaBoyce {
            mu,
            locking_stretch,
        } => eight_chains(mu, locking_stretch, i1),
        RubberModel::VanDerWaals {
            shear_modulus,
            locking_stretch,
            a: interaction,
            beta,
        } => {
            let x = (1.0 - beta) * a + beta * b;
            network(shear_modulus, [locking_stretch, interaction, beta], x)
        }
        RubberModel::Ogden { .. } | RubberModel::Hyperfoam { .. } | RubberModel::BlatzKo { .. } => {
            unreachable!("no law of stretches here")
        }
    }
}

/// Energy, W1 and W2 at principal stretches.
fn at_stretches(law: &RubberModel, stretches: [f64; 3]) -> [f64; 3] {
    let sum = |power: i32| stretches.iter().map(|s| s.powi(power)).sum();
    energy(law, sum(2), sum(-2))
}

fn body(law: &RubberModel) -> Scene {
    let mut scene = rubber(law.clone(), None);
    scene.solver.tolerance = TOLERANCE;
    scene.probes = vec![probe("inside", [0.4, 0.45, 0.3])];
    scene
}

/// The last of the increments, all of which must converge.
fn last(scene: &Scene, step: &Step, mesh: &Arc<Mesh>) -> StepReport {
    let mut reports = solve(scene, std::slice::from_ref(step), mesh);
    reports.iter().for_each(assert_converged);
    reports.pop().expect("an increment")
}

fn assert_close(name: &str, value: f64, exact: f64) {
    let error = (value - exact).abs() / exact.abs().max(1.0);
    assert!(error <= EXACT, "{name}: {value} not {exact}, {error:e}");
}

/// Checks energy, volume and internal pressure, p = -tr(sigma) / 3.
fn assert_inside(report: &StepReport, energy: f64, trace: f64) {
    assert_close("energy", report.strain_energy, energy);
    assert_close("volume", report.volume_ratio, 1.0);
    let pressure = report.probes["inside"].pressure.expect("a pressure");
    assert_close("pressure", pressure, -trace / 3.0);
}

/// Rollers, and the supports that stretch.
fn stretched(law: &RubberModel, stretching: Vec<Support>) -> Scene {
    let mut scene = body(law);
    scene.supports = rollers();
    scene.supports.extend(stretching);
    scene
}

fn parts(increments: u32) -> Step {
    in_parts(Step::default(), increments)
}

#[test]
fn uniaxial_stretch() {
    for law in laws() {
        for s in [2.0, 1.5, 0.6] {
            let scene = stretched(&law, vec![support("x1", [Some(s - 1.0), None, None])]);
            let report = last(&scene, &parts(4), &solid());
            let [w, w1, w2] = at_stretches(&law, [s, s.powf(-0.5), s.powf(-0.5)]);
            let exact = 2.0 * (w1 + w2 / s) * (s - s.powi(-2));
            assert_close("force", report.supports["x1"].force[0], exact);
            assert_inside(&report, w, exact * s);
        }
    }
}

#[test]
fn equibiaxial_stretch() {
    for law in laws() {
        for s in [2.0, 1.5, 0.8] {
            let scene = stretched(
                &law,
                vec![
                    support("x1", [Some(s - 1.0), None, None]),
                    support("y1", [None, Some(s - 1.0), None]),
                ],
            );
            let report = last(&scene, &parts(4), &solid());
            let [w, w1, w2] = at_stretches(&law, [s, s, s.powi(-2)]);
            let exact = 2.0 * (w1 + w2 * s * s) * (s - s.powi(-5));
            assert_close("force x", report.supports["x1"].force[0], exact);
            assert_close("force y", report.supports["y1"].force[1], exact);
            assert_inside(&report, w, 2.0 * exact * s);
        }
    }
}

#[test]
fn a_penalty_changes_nothing_where_the_pressure_accounts_for_the_volume() {
    for bulk_modulus in [None, Some(20.0)] {
        let [plain, penalised] = [0.0, 4.0].map(|penalty| {
            let stretch = support("x1", [Some(-0.4), None, None]);
            let mut scene = rubber(laws()[0].clone(), bulk_modulus);
            scene.supports = rollers();
            scene.supports.push(stretch);
            scene.probes = vec![probe("inside", [0.4, 0.45, 0.3])];
            scene.solver.tolerance = TOLERANCE;
            scene.solver.penalty = Some(penalty);
            last(&scene, &parts(4), &solid())
        });
        assert_eq!((plain.penalty, penalised.penalty), (0.0, 4.0));
        let force = |report: &StepReport| report.supports["x1"].force[0];
        let pressure = |report: &StepReport| report.probes["inside"].pressure.expect("one");
        assert_close("force", force(&penalised), force(&plain));
        assert_close("pressure", pressure(&penalised), pressure(&plain));
        assert_close("volume", penalised.volume_ratio, plain.volume_ratio);
    }
}

/// Nominal stresses along and across, and the energy, of planar stretch.
fn planar(law: &RubberModel, s: f64) -> ([f64; 2], f64) {
    let [w, w1, w2] = at_stretches(law, [s, 1.0, 1.0 / s]);
    let along = 2.0 * (w1 + w2) * (s - s.powi(-3));
    let across = 2.0 * w1 * (1.0 - s.powi(-2)) - 2.0 * w2 * (1.0 - s * s);
    ([along, across], w)
}

#[test]
fn planar_stretch() {
    for law in laws() {
        for s in [2.0, 1.5, 0.7] {
            let scene = stretched(
                &law,
                vec![
                    support("x1", [Some(s - 1.0), None, None]),
                    support("y1", [None, Some(0.0), None]),
                ],
            );
            let report = last(&scene, &parts(4), &solid());
            let ([along, across], w) = planar(&law, s);
            assert_close("along", report.supports["x1"].force[0], along);
            assert_close("across", report.supports["y1"].force[1], across);
            assert_inside(&report, w, along * s + across);
        }
    }
}

#[test]
fn planar_stretch_is_uniaxial_stretch_in_plane_strain() {
    for law in laws() {
        for s in [2.0, 1.5, 0.7] {
            let mut scene = body(&law);
            scene.probes = vec![probe("inside", [0.4, 0.45, 0.0])];
            scene.supports = vec![
                support("x0", [Some(0.0), None, None]),
                support("y0", [None, Some(0.0), None]),
                support("x1", [Some(s - 1.0), None, None]),
            ];
            let report = last(&scene, &parts(4), &plane());
            let ([along, across], w) = planar(&law, s);
            assert_close("along", report.supports["x1"].force[0], along);
            assert_inside(&report, w, along * s + across);
        }
    }
}

/// Nominal stress P = sigma F^-T of the shear u = k z e_x, or k y e_x in the
/// plane, with no stress on the third axis: columns of the sheared axis and of the
/// axis of the gradient [along, across], and the trace of sigma.
fn sheared(law: &RubberModel, k: f64) -> ([[f64; 2]; 2], f64, f64) {
    let [w, w1, w2] = energy(law, 3.0 + k * k, 3.0 + k * k);
    let (shear, along, across) = (2.0 * (w1 + w2) * k, 2.0 * w1 * k * k, -2.0 * w2 * k * k);
    let side = [along - k * shear, shear - k * across];
    ([side, [shear, across]], along + across, w)
}

const SHEAR: f64 = 0.7;

#[test]
fn simple_shear() {
    for law in laws() {
        let ([side, top], trace, w) = sheared(&law, SHEAR);
        let mut scene = body(&law);
        scene.supports = vec![support("z0", HELD), support("z1", HELD)];
        scene.tractions = vec![
            traction("x1", [side[0], 0.0, side[1]]),
            traction("x0", [-side[0], 0.0, -side[1]]),
        ];
        let step = pull("z1", [Some(SHEAR), None, None], 4);
        let report = last(&scene, &step, &solid());
        assert_close("shear", report.supports["z1"].force[0], top[0]);
        assert_close("normal", report.supports["z1"].force[2], top[1]);
        assert_inside(&report, w, trace);
    }
}

#[test]
fn simple_shear_in_plane_strain() {
    for law in laws() {
        let ([side, top], trace, w) = sheared(&law, SHEAR);
        let mut scene = body(&law);
        scene.probes = vec![probe("inside", [0.4, 0.45, 0.0])];
        let held = [Some(0.0), Some(0.0), None];
        scene.supports = vec![support("y0", held), support("y1", held)];
        scene.tractions = vec![
            traction("x1", [side[0], side[1], 0.0]),
            traction("x0", [-side[0], -side[1], 0.0]),
        ];
        let step = pull("y1", [Some(SHEAR), None, None], 4);
        let report = last(&scene, &step, &plane());
        assert_close("shear", report.supports["y1"].force[0], top[0]);
        assert_close("normal", report.supports["y1"].force[1], top[1]);
        assert_inside(&report, w, trace);
    }
}

#[test]
fn a_body_of_finite_bulk_modulus_swells_by_its_volume_energy_alone() {
    let bulk_modulus = 20.0;
    for law in laws() {
        for s in [1.2_f64, 0.9] {
            let mut scene = stretched(&law, Vec::new());
            scene.materials = rubber(law.clone(), Some(bulk_modulus)).materials;
            let sides = [("x1", 0), ("y1", 1), ("z1", 2)];
            scene.supports.extend(sides.map(|(side, axis)| {
                let mut held = [None; 3];
                held[axis] = Some(s - 1.0);
                support(side, held)
            }));
            let report = last(&scene, &parts(2), &solid());
            let change = s.powi(3) - 1.0;
            let stress = bulk_modulus * change;
            assert_close("energy", report.strain_energy, 0.5 * stress * change);
            assert_close("volume", report.volume_ratio, 1.0 + change);
            for (side, axis) in sides {
                let force = report.supports[side].force[axis];
                assert_close("force", force, stress * s * s);
            }
            let pressure = report.probes["inside"].pressure.expect("a pressure");
            assert_close("pressure", pressure, -stress);
        }
    }
}
