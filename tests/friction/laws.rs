//! What friction promises: exact thresholds, no creep, no dependence on the frame, history
//! that is state, and nothing of it where nothing is rough.

use std::sync::Arc;

use crate::common::meshes::{cube, file, mesh, moved, unit_grid};
use crate::common::scenes::{
    HELD, elastic, mooney_rivlin, obstacle, plane, pull, rubber, support, turned,
};
use crate::common::{assert_converged, open, take};
use signorini::report::WarningKind;
use signorini::scene::{ObstacleTarget, Shape};
use signorini::{
    CancelToken, Cause, FieldName, Mesh, Prepared, Reuse, Scene, Session, Step, StepReport,
    Termination,
};

/// With one rough obstacle named `tool`.
fn rough(mut scene: Scene, on: &str, shape: Shape, friction: f64) -> Scene {
    let mut tool = obstacle("tool", on, shape);
    tool.friction = friction;
    scene.obstacles = vec![tool];
    scene
}

fn travel(increments: u32, translation: [f64; 3]) -> Step {
    Step {
        increments,
        obstacles: vec![ObstacleTarget {
            name: "tool".to_owned(),
            translation: Some(translation),
            ..ObstacleTarget::default()
        }],
        ..Step::default()
    }
}

fn reports(scene: &Scene, steps: &[Step], mesh: &Arc<Mesh>) -> Vec<StepReport> {
    let mut session = open(scene, mesh);
    steps
        .iter()
        .flat_map(|step| take(&mut session, step))
        .collect()
}

/// A cube, bonded below, under a rough lid.
fn pressed_cube(friction: f64) -> Scene {
    let mut scene = elastic(0.5);
    scene.supports = vec![support("z0", HELD)];
    rough(
        scene,
        "z1",
        plane([0.0, 0.0, 1.0], [0.0, 0.0, -1.0]),
        friction,
    )
}

#[test]
fn a_dragged_wedge_pulls_by_the_law_to_rounding() {
    // F / G = (tan a + mu) / (1 - mu tan a) where everything slips.
    let slope: f64 = 0.1;
    let length = slope.hypot(1.0);
    let normal = [-slope / length, -1.0 / length, 0.0];
    let mut scene = elastic(0.3);
    scene.supports = vec![support("y0", [Some(0.0), Some(0.0), None])];
    for friction in [0.1, 0.2, 0.3] {
        let scene = rough(
            scene.clone(),
            "y1",
            plane([1.0, 1.0, 0.0], normal),
            friction,
        );
        let steps = [travel(1, [0.0, -0.1, 0.0]), travel(3, [-0.6, -0.04, 0.0])];
        let reports = reports(&scene, &steps, &file("square_n8"));
        let last = reports.last().expect("a result");
        assert_converged(last);
        let tool = &last.obstacles["tool"];
        assert_eq!(tool.stick_vertices, 0);
        let [x, y, _] = tool.force;
        let exact = (slope + friction) / (1.0 - friction * slope);
        assert!(
            (x / y - exact).abs() < 1e-6,
            "{friction}: {} {exact}",
            x / y
        );
    }
}

#[test]
fn a_block_on_a_slope_stays_up_to_the_angle_of_friction_and_no_further() {
    let mut scene = elastic(0.3);
    let friction = 0.3;
    for (factor, holds) in [(0.5, true), (1.0 - 1e-4, true), (1.0 + 1e-6, false)] {
        scene.body_force = [factor * friction, -1.0, 0.0];
        let scene = rough(
            scene.clone(),
            "y0",
            plane([0.0; 3], [0.0, 1.0, 0.0]),
            friction,
        );
        let report = &reports(&scene, &[Step::default()], &file("square_n8"))[0];
        let expected = match holds {
            true => (Termination::Converged, None),
            false => (Termination::NotConverged, Some(Cause::NoEquilibrium)),
        };
        assert_eq!((report.termination, report.cause), expected, "{factor}");
        if holds {
            let force = report.obstacles["tool"].tangential_force[0];
            assert!((force + factor * friction).abs() < 1e-7, "{force}");
        }
    }
}

/// A body under its weight on a rough slope whose tangent is `share` of what
/// friction holds.
fn on_a_slope(mesh: &Arc<Mesh>, (friction, share): (f64, f64)) -> StepReport {
    let mut scene = elastic(0.3);
    scene.body_force = [0.01 * friction * share, -0.01, 0.0];
    let scene = rough(scene, "y0", plane([0.0; 3], [0.0, 1.0, 0.0]), friction);
    reports(&scene, &[Step::default()], mesh).remove(0)
}

#[test]
fn bodies_of_any_shape_stay_on_slopes_below_the_angle_of_friction_and_slide_above() {
    for size in [[1.0, 1.0], [2.0, 0.6], [0.4, 1.0]] {
        let block = moved(unit_grid(6, 5), |[x, y, _]| [size[0] * x, size[1] * y, 0.0]);
        let block = mesh(block);
        for (friction, share) in [
            (0.05, 0.5),
            (0.3, 0.9),
            (0.3, 1.0 - 1e-4),
            (0.3, 1.0 - 1e-6),
        ] {
            let report = on_a_slope(&block, (friction, share));
            assert_converged(&report);
            let force = report.obstacles["tool"].force;
            let weight = 0.01 * size[0] * size[1];
            assert!((force[1] - weight).abs() < 1e-6 * weight, "{force:?}");
            assert!(
                (force[0] + friction * share * weight).abs() < 1e-6 * weight,
                "{force:?}"
            );
        }
        let report = on_a_slope(&block, (0.3, 1.0 + 1e-6));
        assert_eq!(report.cause, Some(Cause::NoEquilibrium));
    }
}

#[test]
fn a_rough_plate_is_pushed_aside_though_all_of_its_points_slip_under_the_press() {
    let mut scene = pressed_cube(0.05);
    scene.supports = vec![support("z0", HELD)];
    let push = |x, z| {
        let mut step = travel(1, [0.0; 3]);
        step.obstacles[0].translation = None;
        step.obstacles[0].force = [x, None, Some(z)];
        step
    };
    let pushed = |share: f64| {
        let steps = [push(None, -0.05), push(Some(share * 0.05 * 0.05), -0.05)];
        reports(&scene, &steps, &mesh(cube(3)))
    };
    let found = pushed(0.5);
    assert_eq!(found[0].obstacles["tool"].stick_vertices, 0);
    assert_converged(&found[1]);
    let force = found[1].obstacles["tool"].force;
    assert!((force[0] - 0.5 * 0.05 * 0.05).abs() < 1e-7 && (force[2] + 0.05).abs() < 1e-7);
    assert_eq!(pushed(1.05)[1].cause, Some(Cause::NoEquilibrium));
}

#[test]
fn a_block_that_tips_over_is_no_result() {
    // Inside the cone of friction, but the resultant leaves the base.
    let mut scene = elastic(0.3);
    scene.body_force = [1.999_998, -1.0, 0.0];
    let scene = rough(scene, "y0", plane([0.0; 3], [0.0, 1.0, 0.0]), 2.0);
    let report = &reports(&scene, &[Step::default()], &file("square_n8"))[0];
    assert_eq!(report.termination, Termination::NotConverged);
}

#[test]
fn what_sticks_does_not_creep() {
    let scene = pressed_cube(0.3);
    let press = [travel(1, [0.0, 0.0, -0.05]), travel(2, [0.012, 0.0, -0.05])];
    let mut session = open(&scene, &mesh(cube(3)));
    let before = press.iter().flat_map(|step| take(&mut session, step));
    let before = before.last().expect("a result");
    assert!(before.obstacles["tool"].stick_vertices > 0);
    let rest = take(&mut session, &travel(1000, [0.012, 0.0, -0.05]));
    let after = rest.last().expect("a result");
    let pairs = before.obstacles["tool"]
        .force
        .iter()
        .zip(after.obstacles["tool"].force);
    let drift = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(drift < 1e-8, "{drift}");
    assert!((before.strain_energy - after.strain_energy).abs() < 1e-8 * before.strain_energy);
}

#[test]
fn increments_below_the_tolerance_drag_what_sticks_all_the_same() {
    let mut scene = pressed_cube(1.5);
    scene.solver.tolerance = 1e-3;
    let press = travel(1, [0.0, 0.0, -0.05]);
    let pull = |increments| {
        let drag = travel(increments, [0.01, 0.0, -0.05]);
        let last = reports(&scene, &[press.clone(), drag], &mesh(cube(2))).pop();
        last.expect("a result").obstacles["tool"].force[0]
    };
    let (one, many) = (pull(1), pull(2000));
    assert!(one > 1e-3, "{one}");
    assert!((many - one).abs() < 0.01 * one, "{one} {many}");
}

#[test]
fn a_plane_of_symmetry_is_the_same_by_components_and_by_its_normal() {
    let ball = Shape::Sphere {
        centre: [0.0, 0.4, 1.8],
        radius: 0.8,
    };
    let found = [true, false].map(|by_component| {
        let mut scene = elastic(0.3);
        scene.supports = vec![support("z0", HELD), support("x0", [Some(0.0), None, None])];
        if !by_component {
            scene.supports[1].displacement = [None; 3];
            scene.supports[1].normal = Some(0.0);
        }
        let scene = rough(scene, "z1", ball.clone(), 0.3);
        let steps = [
            travel(2, [0.0, 0.0, -0.05]),
            travel(2, [0.0, 0.02, -0.06]),
            travel(1, [0.0, 0.02, -0.02]),
        ];
        reports(&scene, &steps, &mesh(cube(4)))
    });
    for (a, b) in found[0].iter().zip(&found[1]) {
        assert_converged(b);
        let [one, other] = [a, b].map(|report| &report.obstacles["tool"]);
        assert!((a.strain_energy - b.strain_energy).abs() < 1e-7 * a.strain_energy);
        assert!((one.dissipated_total - other.dissipated_total).abs() < 1e-7 * a.strain_energy);
        for axis in [1, 2] {
            let error = (one.force[axis] - other.force[axis]).abs();
            assert!(error < 1e-6 * one.force[2].abs(), "{one:?} {other:?}");
        }
        assert_eq!(one.stick_vertices, other.stick_vertices);
    }
}

#[test]
fn a_tool_that_turns_far_in_one_increment_says_so() {
    let coarse = |increments| {
        let mut turn = travel(increments, [0.0, 0.0, -0.05]);
        turn.obstacles[0].rotation = Some([0.0, 0.0, 2.0]);
        let steps = [travel(1, [0.0, 0.0, -0.05]), turn];
        let found = reports(&pressed_cube(0.2), &steps, &mesh(cube(2)));
        let kinds = found.iter().flat_map(|report| &report.warnings);
        let angles = kinds.filter(|warning| warning.kind == WarningKind::CoarseTurn);
        angles
            .filter_map(|warning| warning.value)
            .collect::<Vec<f64>>()
    };
    let [once] = coarse(1)[..] else {
        panic!("one warning");
    };
    assert!((once - 2.0).abs() < 0.2, "{once}");
    assert!(coarse(8).is_empty());
}

#[test]
fn slip_costs_energy_and_the_tool_pays_for_it() {
    // F dc >= dE + D for a flat tool on a linear body, equal as increments shrink.
    let scene = pressed_cube(0.2);
    let mut lost = Vec::new();
    for increments in [4, 8] {
        let mut again = open(&scene, &mesh(cube(3)));
        let (mut work, mut energy) = (0.0, 0.0);
        let mut before = take(&mut again, &travel(1, [0.0, 0.0, -0.05]))[0].strain_energy;
        for report in take(&mut again, &travel(increments, [0.2, 0.0, -0.05])) {
            let tool = &report.obstacles["tool"];
            assert!(tool.dissipated_energy >= 0.0);
            work += tool.force[0] * 0.2 / f64::from(increments);
            energy += report.strain_energy - before + tool.dissipated_energy;
            before = report.strain_energy;
        }
        assert!(work >= energy - 1e-10, "{work} {energy}");
        lost.push(work - energy);
    }
    assert!(lost[1] < 0.7 * lost[0], "{lost:?}");
}

/// A session where `other` is.
fn session_like(scene: &Scene, other: &mut Session) -> Session {
    let mesh = mesh(cube(3));
    let plan = Arc::new(signorini::Plan::new(scene, &[], &mesh).expect("a valid scene"));
    let prepared = Prepared::build(&plan, &mesh, &CancelToken::new()).expect("prepared");
    let bytes = other.export();
    Session::import(plan, mesh, Arc::new(prepared), Reuse::Built, &bytes).expect("its own bytes")
}

#[test]
fn a_session_goes_on_from_a_checkpoint_with_the_same_bits() {
    let scene = pressed_cube(0.3);
    let mut session = open(&scene, &mesh(cube(3)));
    take(&mut session, &travel(2, [0.03, 0.0, -0.05]));
    let mut other = session_like(&scene, &mut session);
    let step = travel(2, [-0.02, 0.01, -0.04]);
    let [own, others] = [&mut session, &mut other].map(|session| take(session, &step));
    for (a, b) in own.iter().zip(&others) {
        assert_eq!(a.obstacles, b.obstacles);
        assert_eq!(a.strain_energy.to_bits(), b.strain_energy.to_bits());
    }
    for field in [
        FieldName::FrictionTraction,
        FieldName::Slip,
        FieldName::Displacement,
    ] {
        let values = [&session, &other].map(|session| session.field(field));
        assert!(values[0].is_some() && values[0] == values[1], "{field:?}");
    }
}

#[test]
fn body_and_tool_that_turn_together_slip_by_nothing() {
    let mut scene = rubber(mooney_rivlin(), None);
    scene.supports = vec![support("z0", HELD)];
    let scene = rough(scene, "z1", plane([0.5, 0.5, 1.0], [0.0, 0.0, -1.0]), 0.2);
    let press = travel(1, [0.0, 0.0, -0.1]);
    let angle: f64 = 0.4;
    // About the tool's reference point, which stays.
    let about = [0.5, 0.5, 0.9];
    let mut turn = travel(2, [0.0, 0.0, -0.1]);
    turn.obstacles[0].rotation = Some([0.0, -angle, 0.0]);
    turn.supports = vec![turned("z0", [0.0, -angle, 0.0], about)];
    let found = reports(&scene, &[press, turn], &mesh(cube(3)));
    let [pressed, .., turned] = &found[..] else {
        panic!("three results");
    };
    assert_converged(turned);
    let [before, after] = [pressed, turned].map(|report| report.obstacles["tool"].clone());
    assert!((pressed.strain_energy - turned.strain_energy).abs() < 1e-7 * pressed.strain_energy);
    let size = |force: [f64; 3]| force.iter().fold(0.0, |sum: f64, x| sum.hypot(*x));
    assert!((size(before.force) - size(after.force)).abs() < 1e-7 * size(before.force));
    assert!((before.dissipated_total - after.dissipated_total).abs() < 1e-9);
}

#[test]
fn no_friction_in_a_step_is_the_frictionless_body() {
    let step = travel(1, [0.02, 0.0, -0.05]);
    let mut without = step.clone();
    without.obstacles[0].friction = Some(0.0);
    let mesh = mesh(cube(3));
    let smooth = &reports(&pressed_cube(0.0), &[step], &mesh)[0];
    let rough = &reports(&pressed_cube(0.5), &[without], &mesh)[0];
    assert_converged(rough);
    assert!((smooth.strain_energy - rough.strain_energy).abs() < 1e-8 * smooth.strain_energy);
    assert_eq!(rough.obstacles["tool"].stick_vertices, 0);
    assert!(smooth.unknowns.contact * 3 == rough.unknowns.contact);
}

#[test]
fn a_body_that_is_let_go_stays_at_rest_without_work() {
    for friction in [0.0, 0.8] {
        let steps = [
            travel(2, [0.01, 0.0, -0.05]),
            travel(12, [0.01, 0.0, 0.02]),
            travel(20, [0.01, 0.0, 0.03]),
        ];
        let found = reports(&pressed_cube(friction), &steps, &mesh(cube(3)));
        assert_eq!(found.len(), 34);
        found.iter().for_each(assert_converged);
        let programs = |report: &StepReport| report.sqp_iterations;
        assert!(found[..12].iter().any(|report| programs(report) > 0));
        assert_eq!(found[14..].iter().map(programs).sum::<u32>(), 0);
        assert!(found[33].strain_energy < 1e-16);
    }
}

#[test]
fn friction_within_the_tolerance_is_none() {
    let mesh = mesh(cube(4));
    let steps = [
        travel(1, [0.0, 0.0, -0.07]),
        travel(2, [0.03, -0.02, -0.04]),
    ];
    let ends = [0.0, 1e-12].map(|friction| {
        let found = reports(&pressed_cube(friction), &steps, &mesh);
        found.iter().for_each(assert_converged);
        found.last().expect("a result").strain_energy
    });
    assert!((ends[0] - ends[1]).abs() < 1e-8 * ends[0], "{ends:?}");
}

/// A slanting strut, held above, whose foot is on a rough floor, under a load that lifts it
/// where it is free and presses it where it sticks.
fn strut() -> (Scene, Arc<Mesh>) {
    let slant = 20_f64.to_radians().tan();
    let strip = moved(unit_grid(1, 12), |[x, y, _]| [0.08 * x + slant * y, y, 0.0]);
    let mut scene = elastic(0.3);
    scene.supports = vec![support("y1", [Some(0.0), Some(0.0), None])];
    let load = 246_f64.to_radians();
    scene.body_force = [0.004 * load.cos(), 0.004 * load.sin(), 0.0];
    let floor = plane([0.0; 3], [0.0, 1.0, 0.0]);
    (rough(scene, "y0", floor, 1.5), mesh(strip))
}

/// The size of the warning that a state is not the only one.
fn not_unique(report: &StepReport) -> Option<f64> {
    let mut warnings = report.warnings.iter();
    let warning = warnings.find(|warning| warning.kind == WarningKind::NotUnique);
    warning.and_then(|warning| warning.value)
}

#[test]
fn a_strut_wedges_or_swings_free_by_its_path_and_both_say_so() {
    let (scene, mesh) = strut();
    let top = |increments, load, y| Step {
        load: Some(load),
        ..pull("y1", [Some(0.0), Some(y), None], increments)
    };
    let pressed = |depth: f64, increments| {
        [
            top(increments, 0.0, -depth),
            top(4, 1.0, -depth),
            top(6, 1.0, 0.0),
        ]
    };
    let free = reports(&scene, &[Step::default()], &mesh);
    let free = free.last().expect("a result");
    assert_converged(free);
    assert!(not_unique(free) > Some(1.0));
    assert!(
        free.obstacles["tool"]
            .force
            .iter()
            .all(|&value| value == 0.0)
    );
    // Where two states are near, the last digits decide which one an increment ends in, or
    // whether it ends at all: half of the paths wedge, one in ten does not end.
    let depths = [0.008, 0.009, 0.01, 0.011, 0.012, 0.013];
    let ends = depths.iter().flat_map(|&depth| [(depth, 1), (depth, 2)]);
    let (mut wedged, mut failed) = (0, 0);
    for (depth, increments) in ends {
        let path = reports(&scene, &pressed(depth, increments), &mesh);
        let end = path.last().expect("a result");
        let [x, y, _] = end.obstacles["tool"].force;
        let has_ended = path.iter().all(|r| r.termination == Termination::Converged);
        failed += usize::from(!has_ended);
        if has_ended && y > 1e-4 {
            assert!(x.abs() < 1.5 * y);
            assert!(not_unique(end) > Some(1.0), "{depth} {increments}");
            wedged += 1;
        }
    }
    assert!(wedged >= 4 && failed <= 6, "{wedged} {failed}");
    // Where friction is too weak to wedge there is one state, and no warning.
    let mut weak = scene;
    weak.obstacles[0].friction = 0.3;
    let path = reports(&weak, &pressed(0.01, 2), &mesh);
    let report = path.last().expect("a result");
    assert_converged(report);
    assert_eq!(not_unique(report), None);
}
