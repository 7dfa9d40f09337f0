//! Rotations of rubber: the torsion of a cylinder, and a stressed body that turns
//! with all that holds it, 60 and 90 degrees at once.
//!
//! Rivlin's torsion by tau per length of a cylinder of radius A that keeps its
//! height: torque pi A^4 tau (C10 + C01), so that the energy is half of torque
//! times angle; axial force -(pi / 2) A^4 tau^2 (C10 + 2 C01).

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use crate::common::curved::cylinder;
use crate::common::meshes::{cube, irregular, mesh, square};
use crate::common::rounded::{round, together, whole_ring};
use crate::common::scenes::{HELD, mooney_rivlin, press, pull, push, rubber, support, turned};
use crate::common::{assert_converged, close, open, solve, solve_one, take};
use signorini::scene::{ObstacleTarget, Support, SupportTarget};
use signorini::{Cause, Mesh, Session, Step, StepReport};

const TWIST: f64 = 0.5;
/// Along this axis, so that turns leave a stretch along it as it is,
const AXIS: [f64; 3] = [12.0 / 13.0, 3.0 / 13.0, 4.0 / 13.0];
/// the body turns about the point that the plane of an obstacle has when it presses.
const PIVOT: [f64; 3] = [0.0, 0.0, 0.85];

/// Relative errors of energy, axial force and torque for a mesh.
fn torsion((rings, layers): (usize, usize)) -> [f64; 3] {
    let height = 0.4;
    let mut scene = rubber(mooney_rivlin(), None);
    scene.supports = vec![support("z0", HELD), support("z1", HELD)];
    let step = Step {
        supports: vec![turned("z1", [0.0, 0.0, TWIST * height], [0.0; 3])],
        ..Step::default()
    };
    let reports = solve(&scene, &[step], &mesh(cylinder(rings, layers, height)));
    assert_converged(&reports[0]);
    let torque = PI * TWIST * 0.5;
    let axial = -0.5 * PI * TWIST * TWIST * 0.6;
    let energy = 0.5 * torque * TWIST * height;
    let [held, turned] = ["z0", "z1"].map(|name| reports[0].supports[name].moment);
    for i in 0..3 {
        assert!(
            (held[i] + turned[i]).abs() < 1e-7 * torque,
            "{held:?} {turned:?}"
        );
    }
    [
        (reports[0].strain_energy - energy).abs() / energy,
        (reports[0].supports["z1"].force[2] - axial).abs() / axial.abs(),
        (turned[2] - torque).abs() / torque,
    ]
}

#[test]
fn a_twisted_cylinder_has_the_exact_torque_and_axial_force() {
    let errors = [(5, 1), (10, 2), (20, 4)].map(torsion);
    let [coarse, middle, fine] = errors;
    assert!(
        middle[0] <= coarse[0] / 3.8 && fine[0] <= middle[0] / 3.8,
        "{errors:?}"
    );
    assert!(
        fine.iter()
            .zip(coarse)
            .all(|(fine, coarse)| *fine <= coarse / 15.0),
        "{errors:?}"
    );
    assert!(fine.iter().all(|error| *error <= 1e-3), "{errors:?}");
}

/// Pressed by a plane at a slant and turned off its axis: moments of the support, about the point
/// that it turns about, of one that only holds and of the tool balance.
#[test]
fn moments_of_supports_and_tools_balance() {
    let mut scene = rubber(mooney_rivlin(), None);
    scene.solver.tolerance = 1e-10;
    scene.supports = vec![support("z0", HELD), support("x0", HELD)];
    scene.obstacles = vec![press("z1")];
    let (about, travel) = ([0.0, 0.5, 0.2], [0.02, 0.0, -0.05]);
    let mut step = push("press", travel);
    step.supports = vec![turned("x0", [0.0, 0.05, 0.02], about)];
    let report = solve_one(&scene, &step, &mesh(irregular(cube(3), 5)));
    let tool = &report.obstacles["press"];
    let at: [f64; 3] = std::array::from_fn(|i| [0.0, 0.0, 1.0][i] + travel[i]);
    let [held, turned] = ["z0", "x0"].map(|name| &report.supports[name]);
    let all = [
        ([0.0; 3], held.force, held.moment),
        (about, turned.force, turned.moment),
        (at, tool.force, tool.moment),
    ];
    let scale = tool.force[2].abs();
    assert!(scale > 0.01, "{scale}");
    for i in 0..3 {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let moment = |(c, f, m): ([f64; 3], [f64; 3], [f64; 3])| m[i] + c[j] * f[k] - c[k] * f[j];
        let sum: f64 = all.into_iter().map(moment).sum();
        assert!(sum.abs() < 1e-7 * scale, "{i}: {sum:e}");
    }
}

/// What a rotation of everything leaves as it is.
fn invariants(report: &StepReport) -> Vec<f64> {
    let size = |force: [f64; 3]| force.iter().map(|x| x * x).sum::<f64>().sqrt();
    let jacobian = report.min_jacobian.expect("a rubber");
    let mut all = vec![report.strain_energy, report.volume_ratio, jacobian];
    all.extend(report.supports.values().map(|support| size(support.force)));
    for obstacle in report.obstacles.values() {
        all.extend([size(obstacle.force), obstacle.max_pressure]);
    }
    all
}

/// Turns a stressed body about a slanted axis and compares every increment with
/// the state before.
fn turn(session: &mut Session, stressed: &StepReport, turns: f64, increments: u32) {
    let rotation = AXIS.map(|x| turns * TAU * x);
    let scene = session.plan().scene();
    let held = scene.supports.iter();
    let supports = held.map(|support| turned(&support.name, rotation, PIVOT));
    let touching = scene.obstacles.iter();
    let obstacles = touching.map(|obstacle| ObstacleTarget {
        name: obstacle.name.clone(),
        rotation: Some(rotation),
        ..ObstacleTarget::default()
    });
    let step = Step {
        increments,
        supports: supports.collect(),
        obstacles: obstacles.collect(),
        ..Step::default()
    };
    let reports = take(session, &step);
    assert_eq!(reports.len(), increments as usize);
    let expected = invariants(stressed);
    for report in &reports {
        assert_converged(report);
        assert_eq!(report.sqp_iterations, 0, "nothing is left to solve");
        for (value, expected) in invariants(report).into_iter().zip(&expected) {
            assert!(close(value, *expected, 1e-9), "{report:?}");
        }
    }
}

#[test]
fn a_stretched_body_turns_ten_times_with_its_supports() {
    let mut scene = rubber(mooney_rivlin(), None);
    scene.solver.tolerance = 1e-11;
    scene.supports = vec![support("z0", HELD), support("z1", HELD)];
    let mut session = open(&scene, &mesh(irregular(cube(2), 2)));
    let stretched = take(&mut session, &pull("z1", AXIS.map(|x| Some(0.4 * x)), 1));
    assert_converged(&stretched[0]);
    turn(&mut session, &stretched[0], 10.0, 60);
}

#[test]
fn a_pressed_body_turns_ten_times_with_its_support_and_its_obstacle() {
    let mut scene = rubber(mooney_rivlin(), None);
    scene.solver.tolerance = 1e-11;
    scene.supports = vec![support("z0", HELD)];
    scene.obstacles = vec![press("z1")];
    let mut session = open(&scene, &mesh(irregular(cube(2), 2)));
    let pressed = take(&mut session, &push("press", [0.0, 0.0, -0.15]));
    assert_converged(&pressed[0]);
    turn(&mut session, &pressed[0], 10.0, 40);
}

/// A support that turns by `angle` about the axis and goes on along it.
fn screwed(name: &str, angle: f64, travel: f64) -> SupportTarget {
    SupportTarget {
        translation: Some(AXIS.map(|x| travel * x)),
        ..turned(name, AXIS.map(|x| angle * x), PIVOT)
    }
}

#[test]
fn a_body_is_stretched_while_it_turns_by_a_right_angle() {
    let mut scene = rubber(mooney_rivlin(), None);
    scene.supports = vec![support("z0", HELD), support("z1", HELD)];
    let stretched = |angle| {
        let step = Step {
            supports: vec![screwed("z0", angle, 0.0), screwed("z1", angle, 0.3)],
            ..Step::default()
        };
        let report = solve_one(&scene, &step, &mesh(irregular(cube(2), 2)));
        assert_eq!(report.cut_backs, 0);
        report
    };
    let (straight, slanted) = (stretched(0.0), stretched(0.5 * PI));
    let [straight, slanted] = [straight, slanted].map(|report| invariants(&report));
    for (value, expected) in slanted.into_iter().zip(straight) {
        assert!(close(value, expected, 1e-7), "{value} {expected}");
    }
}

/// Nothing turns with the plane of a press: its normal is the axis.
#[test]
fn a_pressed_body_turns_under_a_press_that_stands_still() {
    let mut scene = rubber(mooney_rivlin(), None);
    scene.supports = vec![support("z0", HELD)];
    scene.obstacles = vec![press("z1")];
    let mut session = open(&scene, &mesh(irregular(cube(2), 2)));
    let pressed = take(&mut session, &push("press", [0.0, 0.0, -0.15]));
    let step = Step {
        increments: 4,
        supports: vec![turned("z0", [0.0, 0.0, TAU], [0.5, 0.5, 0.0])],
        ..Step::default()
    };
    let expected = invariants(&pressed[0]);
    for report in take(&mut session, &step) {
        assert_converged(&report);
        for (value, expected) in invariants(&report).into_iter().zip(&expected) {
            assert!(close(value, *expected, 1e-7), "{report:?}");
        }
    }
}

/// A ring of second order whose supports turn about its axis by these angles, one step each.
fn ring_turned(
    (inner, bulk_modulus): (Support, Option<f64>),
    steps: &[[f64; 2]],
) -> Vec<StepReport> {
    let mut scene = rubber(mooney_rivlin(), bulk_modulus);
    scene.supports = vec![inner, support("outer", [Some(0.0), Some(0.0), None])];
    let steps: Vec<Step> = steps
        .iter()
        .map(|angles| Step {
            supports: vec![
                turned("inner", [0.0, 0.0, angles[0]], [0.0; 3]),
                turned("outer", [0.0, 0.0, angles[1]], [0.0; 3]),
            ],
            ..Step::default()
        })
        .collect();
    let parts = whole_ring(16, 3);
    let arcs = together(round(&parts, 1.0, 2), round(&parts, 2.0, 2));
    let mesh = Mesh::second_order(parts, arcs).expect("a valid mesh");
    solve(&scene, &steps, &Arc::new(mesh))
}

#[test]
fn a_twisted_ring_of_curved_cells_turns_with_its_supports() {
    let inner = support("inner", [Some(0.0), Some(0.0), None]);
    let reports = ring_turned((inner, Some(10.0)), &[[0.0, 0.2], [1.0, 1.2]]);
    reports.iter().for_each(assert_converged);
    assert_eq!(reports[1].sqp_iterations, 0, "nothing is left to solve");
    let [before, after] = [&reports[0], &reports[1]].map(|report| report.strain_energy);
    assert!(
        before > 1e-3 && close(after, before, 1e-9),
        "{before} {after}"
    );
}

/// To first order a turn by a finite angle asks for another volume than the body has, which is
/// bonded all around. Adkins and Gent: moment 4 pi mu angle / (1 / a^2 - 1 / b^2) at any angle.
#[test]
fn a_ring_that_cannot_change_its_volume_turns_with_what_it_is_bonded_to() {
    for angle in [0.05, 0.5, 1.0] {
        let inner = support("inner", [Some(0.0), Some(0.0), None]);
        let reports = ring_turned((inner, None), &[[angle, 0.0]]);
        assert_converged(&reports[0]);
        let moment = reports[0].supports["inner"].moment[2];
        assert!(close(moment, 4.0 * PI * angle / 0.75, 1e-2), "{moment}");
    }
}

#[test]
fn a_body_that_cannot_change_its_volume_is_not_pressed_by_what_it_is_bonded_to() {
    let mut scene = rubber(mooney_rivlin(), None);
    scene.supports = vec![
        support("x0", [Some(0.0), None, None]),
        support("x1", [Some(0.0), None, None]),
        support("y0", [None, Some(0.0), None]),
        support("y1", [None, Some(0.0), None]),
    ];
    let step = pull("y1", [None, Some(-0.1), None], 1);
    let reports = solve(&scene, &[step], &mesh(square(4)));
    assert_eq!(reports[0].cause, Some(Cause::EnclosedVolume));
}

/// Its bore is a cylinder, which points leave by the sagitta of a facet where arcs are taken for
/// their chords.
#[test]
fn a_ring_of_curved_cells_that_its_bore_guides_is_free_of_stress_at_rest_and_turned() {
    let inner = Support {
        normal: Some(0.0),
        ..support("inner", [None; 3])
    };
    for report in ring_turned((inner, Some(10.0)), &[[0.0, 0.0], [1.0, 1.0]]) {
        assert_converged(&report);
        assert!(report.strain_energy < 1e-14, "{:e}", report.strain_energy);
    }
}
