//! Supports that hold the normal component of a surface: the same as components where
//! these can say it, and more where they cannot.

use crate::common::meshes::{cube, file, mesh, moved, square};
use crate::common::refusals::assert_refused;
use crate::common::scenes::{
    HELD, HELD_IN_PLANE, elastic, mooney_rivlin, probe, pull, rubber, support, traction, turned,
};
use crate::common::{assert_converged, close, solve_one};
use signorini::geometry::{Matrix3, rotation_matrix};
use signorini::scene::{Profile, Support};
use signorini::{Scene, Step, StepReport};

/// A support of that group along its normal.
fn along_normal(on: &str, value: f64) -> Support {
    Support {
        normal: Some(value),
        ..support(on, [None; 3])
    }
}

fn turn(rotation: &Matrix3, x: [f64; 3]) -> [f64; 3] {
    rotation.map(|row| (0..3).map(|i| row[i] * x[i]).sum())
}

const LOAD: [f64; 3] = [0.06, -0.03, -0.2];
const INSIDE: [f64; 3] = [0.8, 0.7, 0.6];

/// A cube pulled at its top, on rollers below and at two sides.
fn on_rollers(mut scene: Scene, supports: Vec<Support>, rotation: &Matrix3) -> StepReport {
    scene.solver.tolerance = 1e-12;
    scene.supports = supports;
    scene.tractions = vec![traction("z1", turn(rotation, LOAD))];
    scene.probes = vec![probe("inside", turn(rotation, INSIDE))];
    let parts = moved(cube(3), |x| turn(rotation, x));
    solve_one(&scene, &Step::default(), &mesh(parts))
}

fn assert_same_rollers(scene: fn() -> Scene) {
    let components = crate::common::scenes::rollers();
    let unturned = rotation_matrix([0.0; 3]);
    let expected = on_rollers(scene(), components, &unturned);
    let rotation = rotation_matrix([0.4, -0.7, 0.3]);
    let normals = ["x0", "y0", "z0"].map(|on| along_normal(on, 0.0)).to_vec();
    let found = on_rollers(scene(), normals, &rotation);
    assert!(close(found.strain_energy, expected.strain_energy, 1e-10));
    let [taken, least] = [&found, &expected].map(|report| report.preconditioner_applications);
    assert!(taken <= least + least / 5 + 3, "{taken} {least}");
    for (name, support) in &expected.supports {
        let [force, moment] = [support.force, support.moment].map(|x| turn(&rotation, x));
        for i in 0..3 {
            let error = found.supports[name].force[i] - force[i];
            assert!(error.abs() < 1e-10, "{name} {i}: {error:e}");
            let error = found.supports[name].moment[i] - moment[i];
            assert!(error.abs() < 1e-10, "moment of {name} {i}: {error:e}");
        }
    }
    let moved = turn(&rotation, expected.probes["inside"].displacement);
    for i in 0..3 {
        let error = found.probes["inside"].displacement[i] - moved[i];
        assert!(error.abs() < 1e-10, "{i}: {error:e}");
    }
}

#[test]
fn rollers_of_a_turned_cube_hold_as_those_along_the_axes() {
    assert_same_rollers(|| elastic(0.5));
    assert_same_rollers(|| elastic(0.3));
}

#[test]
fn rollers_of_turned_rubber_hold_as_those_along_the_axes() {
    assert_same_rollers(|| rubber(mooney_rivlin(), None));
}

#[test]
fn a_lid_pressed_along_its_normal_is_one_pressed_by_its_component() {
    let press = |lid: Support| {
        let mut scene = rubber(mooney_rivlin(), Some(50.0));
        scene.solver.tolerance = 1e-11;
        scene.supports = vec![support("z0", HELD), lid];
        solve_one(&scene, &Step::default(), &mesh(cube(3)))
    };
    let expected = press(support("z1", [None, None, Some(-0.1)]));
    let found = press(along_normal("z1", -0.1));
    assert!(close(found.strain_energy, expected.strain_energy, 1e-9));
    let (force, reference) = (found.supports["z1"].force, expected.supports["z1"].force);
    assert!(close(force[2], reference[2], 1e-8), "{force:?}");
    assert!(force[2] < 0.0 && force[0].abs() < 1e-9 && force[1].abs() < 1e-9);
}

#[test]
fn a_plane_body_slides_along_two_walls() {
    let hold = |supports: Vec<Support>| {
        let mut scene = elastic(0.5);
        scene.solver.tolerance = 1e-12;
        scene.supports = supports;
        scene.tractions = vec![traction("y1", [0.02, -0.1, 0.0])];
        solve_one(&scene, &Step::default(), &mesh(square(4)))
    };
    let expected = hold(vec![
        support("x0", [Some(0.0), None, None]),
        support("y0", [None, Some(0.0), None]),
    ]);
    let found = hold(vec![along_normal("x0", 0.0), along_normal("y0", 0.0)]);
    assert!(close(found.strain_energy, expected.strain_energy, 1e-10));
}

/// Walls at sixty degrees that come nearer by `DEEP` each: the body between them shrinks evenly.
const DEEP: f64 = 0.03;

/// A rhombus of unit sides in the plane, turned so that no side lies along an axis, between walls.
fn between_walls(mut scene: Scene) -> StepReport {
    let shrink = DEEP / 0.75_f64.sqrt();
    let moves = [("x0", 0.0), ("y0", 0.0), ("x1", -DEEP), ("y1", -DEEP)];
    scene.supports = moves.map(|(on, value)| along_normal(on, value)).to_vec();
    scene.probes = vec![probe("inside", rhombus([0.5, 0.25, 0.0]))];
    scene.solver.tolerance = 1e-12;
    let report = solve_one(&scene, &Step::default(), &mesh(moved(square(3), rhombus)));
    let found = report.probes["inside"].displacement;
    let expected = rhombus([0.5, 0.25, 0.0]).map(|x| -shrink * x);
    for i in 0..2 {
        assert!(
            (found[i] - expected[i]).abs() < 1e-10,
            "{found:?} {expected:?}"
        );
    }
    report
}

fn rhombus([x, y, _]: [f64; 3]) -> [f64; 3] {
    let rotation = rotation_matrix([0.0, 0.0, 0.3]);
    turn(&rotation, [x + 0.5 * y, 0.75_f64.sqrt() * y, 0.0])
}

#[test]
fn a_rhombus_between_oblique_walls_shrinks_evenly() {
    let shrink = DEEP / 0.75_f64.sqrt();
    // 2 mu eps : eps + lambda tr^2 over two, on the area.
    let report = between_walls(elastic(0.3));
    let density = 2.0 * shrink * shrink * (1.0 + 0.6 / 0.4);
    assert!(close(report.strain_energy, density * 0.75_f64.sqrt(), 1e-9));
    // Each wall bears the even pressure along its normal.
    let pressure = 2.0 * shrink * (1.0 + 2.0 * 0.3 / 0.4);
    for (name, normal) in [("y0", [0.0, -1.0]), ("x0", [-0.75_f64.sqrt(), 0.5])] {
        let rotation = rotation_matrix([0.0, 0.0, 0.3]);
        let expected = turn(&rotation, [normal[0], normal[1], 0.0]).map(|n| -pressure * n);
        let force = report.supports[name].force;
        let error = (0..2)
            .map(|i| (force[i] - expected[i]).abs())
            .fold(0.0, f64::max);
        assert!(error < 1e-9, "{name}: {force:?} {expected:?}");
    }
    let rubber = between_walls(rubber(mooney_rivlin(), Some(5.0)));
    let ratio = (1.0 - shrink).powi(2);
    assert!(
        close(rubber.volume_ratio, ratio, 1e-9),
        "{}",
        rubber.volume_ratio
    );
}

#[test]
fn a_body_that_is_carried_away_rests_where_it_comes_to() {
    for mut scene in [elastic(0.3), elastic(0.5), rubber(mooney_rivlin(), None)] {
        scene.supports = vec![support("x0", HELD_IN_PLANE)];
        let step = pull("x0", [Some(0.1), Some(2.0), None], 1);
        let report = solve_one(&scene, &step, &mesh(square(4)));
        assert_converged(&report);
        assert!(
            report.strain_energy.abs() < 1e-15,
            "{:e}",
            report.strain_energy
        );
    }
}

#[test]
fn a_body_led_at_one_side_slides_along_its_oblique_plane() {
    let rotation = rotation_matrix([0.0, 0.0, 0.35]);
    let oblique = mesh(moved(square(3), |x| turn(&rotation, x)));
    for mut scene in [elastic(0.3), rubber(mooney_rivlin(), Some(5.0))] {
        scene.solver.tolerance = 1e-12;
        scene.supports = vec![
            along_normal("y0", 0.0),
            support("x0", [Some(0.0), None, None]),
        ];
        scene.probes = vec![probe("inside", turn(&rotation, [0.5, 0.5, 0.0]))];
        let report = solve_one(&scene, &pull("x0", [Some(0.1), None, None], 1), &oblique);
        let energy = report.strain_energy;
        assert!(energy.abs() < 1e-15, "{energy:e}");
        let found = report.probes["inside"].displacement;
        let off = (found[0] - 0.1).hypot(found[1] - 0.1 * 0.35_f64.tan());
        assert!(off < 1e-8, "{found:?}");
    }
}

/// A quarter of a ball whose flat top turns by half a right angle about a tilted axis,
/// all else with it; energy and where its probe comes.
fn turned_ball(of_curved_face: Support) -> (f64, [f64; 3]) {
    let mut scene = rubber(mooney_rivlin(), None);
    scene.solver.tolerance = 1e-10;
    scene.supports = vec![support("top", HELD), of_curved_face];
    scene.probes = vec![probe("inside", [0.3, 0.3, -0.4])];
    let rotation = [0.5, -0.3, 0.6];
    let step = Step {
        increments: 1,
        supports: ["top", "contact"]
            .map(|name| turned(name, rotation, [0.2, 0.0, 0.1]))
            .to_vec(),
        ..Step::default()
    };
    let report = solve_one(&scene, &step, &file("hemi_l1"));
    (report.strain_energy, report.probes["inside"].displacement)
}

#[test]
fn a_ball_held_along_its_curved_face_turns_as_a_bonded_one() {
    let (energy, moved) = turned_ball(along_normal("contact", 0.0));
    let (bonded_energy, expected) = turned_ball(support("contact", HELD));
    assert!(
        energy.abs() < 1e-12 && bonded_energy.abs() < 1e-12,
        "{energy:e}"
    );
    for i in 0..3 {
        let error = moved[i] - expected[i];
        assert!(error.abs() < 1e-8, "{i}: {error:e}");
    }
    assert!(expected.iter().any(|x| x.abs() > 0.05));
}

/// A clamped block with one more support.
fn with(extra: Support) -> Scene {
    let mut scene = elastic(0.5);
    scene.supports = vec![support("z0", HELD), extra];
    scene
}

#[test]
fn a_normal_that_makes_no_sense_is_refused_by_its_key() {
    let beside = Support {
        normal: Some(0.0),
        ..support("x1", [Some(0.0), None, None])
    };
    assert_refused(&with(beside), "support.x1.normal", &["displacement"]);
    let varied = Support {
        profile: Profile::Parabolic,
        ..along_normal("x1", 0.1)
    };
    assert_refused(&with(varied), "support.x1.normal", &["profile"]);
    let infinite = along_normal("x1", f64::INFINITY);
    assert_refused(&with(infinite), "support.x1.normal", &["finite"]);
    // A group of anything but facets.
    let elsewhere = Support {
        on: vec!["body".to_owned()],
        ..along_normal("x1", 0.0)
    };
    assert_refused(
        &with(elsewhere),
        "support.x1.on",
        &["surface facets", "body"],
    );
    let held = along_normal("z0", 0.1);
    let twice = Support {
        name: "floor".to_owned(),
        ..held
    };
    assert_refused(
        &with(twice),
        "support.floor.normal",
        &["hold all its components"],
    );
}
