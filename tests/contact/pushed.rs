//! Obstacles that are pushed: their poses follow from forces and moments.

use crate::common::meshes::{cube, file, mesh};
use crate::common::scenes::{
    HELD, bonded_cube, elastic, hertz_sphere, mooney_rivlin, obstacle, plane, push, rubber,
    support, traction,
};
use crate::common::{assert_converged, close, open, take};
use signorini::report::{Cause, Termination};
use signorini::scene::{Choice, ContactSpace, ObstacleTarget, Shape};
use signorini::{Scene, Session, Step, StepReport};

/// A step that pushes one obstacle by the named components.
fn pushed(name: &str, force: [Option<f64>; 3], moment: [Option<f64>; 3]) -> Step {
    Step {
        obstacles: vec![ObstacleTarget {
            name: name.to_owned(),
            force,
            moment,
            ..ObstacleTarget::default()
        }],
        ..Step::default()
    }
}

/// The same along z alone.
fn down(name: &str, force: f64) -> Step {
    pushed(name, [None, None, Some(force)], [None; 3])
}

/// Takes a step, all of whose increments must converge; the last report.
fn last(session: &mut Session, step: &Step) -> StepReport {
    let reports = take(session, step);
    reports.iter().for_each(assert_converged);
    reports.into_iter().last().expect("an increment")
}

/// Translation and rotation of the first obstacle.
fn pose(session: &Session) -> [[f64; 3]; 2] {
    let pose = &session.obstacle_poses()[0];
    [pose.translation, pose.rotation]
}

/// A quarter of a block of incompressible material under a ball.
fn ball(space: ContactSpace) -> Scene {
    let (mut scene, _) = hertz_sphere(0.5);
    scene.solver.contact_space = Choice::Named(space);
    scene.solver.tolerance = 1e-10;
    scene
}

#[test]
fn a_ball_under_a_force_goes_as_deep_as_another_code_says() {
    let scene = ball(ContactSpace::Linear);
    let name = scene.obstacles[0].name.clone();
    let mut session = open(&scene, &file("indent_l2"));
    let report = last(&mut session, &down(&name, -0.0125));
    let [translation, _] = pose(&session);
    assert!(
        close(-translation[2], 0.039_401_744_684_87, 1e-8),
        "{translation:?}"
    );
    assert!(close(report.strain_energy, 1.919_051_016_580_5e-4, 1e-8));
    assert!(close(report.obstacles[&name].force[2], -0.0125, 1e-9));
    assert_eq!(report.active_vertices, 21);
}

#[test]
fn force_and_travel_are_two_ways_to_one_state() {
    let scene = ball(ContactSpace::Quadratic);
    let name = scene.obstacles[0].name.clone();
    let body = file("indent_l2");
    let mut led = open(&scene, &body);
    let expected = last(&mut led, &push(&name, [0.0, 0.0, -0.05]));
    let force = expected.obstacles[&name].force[2];
    let mut session = open(&scene, &body);
    let mut step = down(&name, force);
    step.increments = 3;
    let found = last(&mut session, &step);
    assert!(close(pose(&session)[0][2], -0.05, 1e-8));
    assert!(close(found.strain_energy, expected.strain_energy, 1e-8));
    // Less force, then a pose again: each ramps from what is there.
    last(&mut session, &down(&name, 0.25 * force));
    assert!(pose(&session)[0][2] > -0.05);
    let again = last(&mut session, &push(&name, [0.0, 0.0, -0.05]));
    assert!(close(again.obstacles[&name].force[2], force, 1e-8));
    // And off altogether.
    let free = last(&mut session, &down(&name, 0.0));
    assert!(free.obstacles[&name].force[2].abs() < 1e-9 * force.abs());
}

#[test]
fn a_force_takes_hardly_more_iterations_than_the_travel_that_it_leads_to() {
    for (space, mesh) in [
        (ContactSpace::Linear, "indent_l1"),
        (ContactSpace::Linear, "indent_l2"),
        (ContactSpace::Quadratic, "indent_l2"),
    ] {
        let mut scene = ball(space);
        scene.solver.tolerance = 1e-8;
        let name = scene.obstacles[0].name.clone();
        let body = file(mesh);
        let led = last(&mut open(&scene, &body), &push(&name, [0.0, 0.0, -0.05]));
        let force = led.obstacles[&name].force[2];
        let found = last(&mut open(&scene, &body), &down(&name, force));
        let counts = [&found, &led].map(|report| f64::from(report.preconditioner_applications));
        assert!(counts[0] <= 1.25 * counts[1], "{counts:?} {mesh}");
    }
}

#[test]
fn a_ball_above_the_body_comes_down_by_itself() {
    let mut scene = ball(ContactSpace::Quadratic);
    let Shape::Sphere { centre, .. } = &mut scene.obstacles[0].shape else {
        panic!("a ball");
    };
    centre[2] += 0.3;
    let name = scene.obstacles[0].name.clone();
    let mut session = open(&scene, &file("indent_l1"));
    last(&mut session, &down(&name, -0.01));
    assert!(pose(&session)[0][2] < -0.3);
}

/// Forces far below what the body feels elsewhere, on a ball whose contact begins at a point.
#[test]
fn a_ball_is_pressed_by_any_force_however_small() {
    let least = [
        (elastic(0.5), -1e-7),
        (rubber(mooney_rivlin(), None), -1e-6),
    ];
    for (mut scene, least) in least {
        let body = ball(ContactSpace::Quadratic);
        scene.supports = body.supports;
        scene.obstacles = body.obstacles;
        let name = scene.obstacles[0].name.clone();
        for force in [-1e-4, -1e-6, least] {
            let mut session = open(&scene, &file("indent_l1"));
            let report = last(&mut session, &down(&name, force));
            assert!(
                close(report.obstacles[&name].force[2], force, 1e-7),
                "{force:e}"
            );
        }
    }
}

/// A ring of rubber lies loosely between two planes; the lid is first led to it, and both to
/// the floor.
#[test]
fn a_body_that_only_obstacles_hold_is_squeezed_by_any_force() {
    let mut scene = rubber(mooney_rivlin(), None);
    scene.obstacles = vec![
        obstacle("lid", "z1", plane([0.5, 0.5, 1.01], [0.0, 0.0, -1.0])),
        obstacle("floor", "z0", plane([0.5, 0.5, -0.02], [0.0, 0.0, 1.0])),
    ];
    for force in [-1e-4, -1e-2, -0.5] {
        let mut session = open(&scene, &mesh(cube(3)));
        let report = last(&mut session, &down("lid", force));
        for (name, sign) in [("lid", 1.0), ("floor", -1.0)] {
            let found = report.obstacles[name].force[2];
            assert!(
                close(found, sign * force, 1e-6),
                "{name} {found:e} {force:e}"
            );
        }
        assert!(pose(&session)[0][2] < -0.03);
    }
}

/// An elastic block under a rigid plate whose reference point is not above its middle.
fn plate(friction: f64) -> Scene {
    let mut scene = elastic(0.3);
    scene.supports = vec![support("z0", HELD)];
    let mut plate = obstacle("plate", "z1", plane([0.6, 0.55, 1.0], [0.0, 0.0, -1.0]));
    plate.friction = friction;
    scene.obstacles = vec![plate];
    scene.solver.tolerance = 1e-10;
    scene
}

#[test]
fn a_plate_tilts_until_its_moments_vanish() {
    let mut session = open(&plate(0.0), &mesh(cube(4)));
    let step = pushed(
        "plate",
        [None, None, Some(-0.02)],
        [Some(0.0), Some(0.0), None],
    );
    let report = last(&mut session, &step);
    let plate = &report.obstacles["plate"];
    assert!(close(plate.force[2], -0.02, 1e-9));
    assert!(plate.moment[0].abs().max(plate.moment[1].abs()) < 1e-10);
    let [translation, rotation] = pose(&session);
    // Deeper on the side of its reference point, which moves with it.
    assert!(translation[2] < 0.0 && rotation[1] > 0.0 && rotation[0] < 0.0);
    // Without friction nothing holds a tilted plate along.
    let all = pushed(
        "plate",
        [Some(0.0), Some(0.0), Some(-0.02)],
        [Some(0.0), Some(0.0), None],
    );
    assert_unbalanced(&mut session, &all, "obstacle.plate.force.x");
}

#[test]
fn a_rough_plate_is_in_balance_in_all_six_components() {
    let mut session = open(&plate(0.6), &mesh(cube(4)));
    let step = pushed(
        "plate",
        [Some(0.002), Some(-0.001), Some(-0.02)],
        [Some(0.0), Some(0.0), Some(5e-4)],
    );
    let report = last(&mut session, &step);
    let plate = &report.obstacles["plate"];
    let goal = [0.002, -0.001, -0.02, 0.0, 0.0, 5e-4];
    let found = plate.force.iter().chain(&plate.moment);
    for (found, goal) in found.zip(goal) {
        assert!((found - goal).abs() < 1e-9, "{plate:?}");
    }
}

#[test]
fn a_push_is_met_while_other_loads_ramp_and_tools_move() {
    let mut scene = elastic(0.3);
    scene.supports = vec![support("z0", HELD)];
    scene.tractions = vec![traction("x1", [0.05, 0.0, 0.02])];
    scene.obstacles = vec![
        obstacle("lid", "z1", plane([0.0, 0.0, 1.0], [0.0, 0.0, -1.0])),
        obstacle("wall", "y1", plane([0.0, 1.0, 0.0], [0.0, -1.0, 0.0])),
    ];
    let mut step = down("lid", -0.05);
    step.increments = 3;
    step.obstacles
        .extend(push("wall", [0.0, -0.02, 0.0]).obstacles);
    let mut session = open(&scene, &mesh(cube(3)));
    let report = last(&mut session, &step);
    assert!(close(report.obstacles["lid"].force[2], -0.05, 1e-7));
    let poses = session.obstacle_poses();
    assert!(close(poses[1].translation[1], -0.02, 1e-15));
    // The push goes on while the load is taken off.
    let unload = Step {
        load: Some(-1.0),
        ..Step::default()
    };
    let report = last(&mut session, &unload);
    assert!(close(report.obstacles["lid"].force[2], -0.05, 1e-7));
}

fn assert_unbalanced(session: &mut Session, step: &Step, key: &str) {
    let report = take(session, step).pop().expect("a report");
    assert_eq!(
        (report.termination, report.cause),
        (Termination::NotConverged, Some(Cause::NoEquilibrium)),
        "{:?}",
        report.residuals
    );
    let site = report.cause_site.expect("a place");
    assert_eq!(site.key.as_deref(), Some(key));
}

#[test]
fn what_nothing_balances_is_named() {
    let (scene, _) = bonded_cube();
    let name = scene.obstacles[0].name.clone();
    let body = mesh(cube(3));
    let along = pushed(&name, [Some(0.01), None, Some(-0.05)], [None; 3]);
    let mut session = open(&scene, &body);
    assert_unbalanced(&mut session, &along, &format!("obstacle.{name}.force.x"));
    let mut session = open(&scene, &body);
    assert_unbalanced(
        &mut session,
        &down(&name, 0.05),
        &format!("obstacle.{name}.force.z"),
    );
    // The session goes on.
    last(&mut session, &down(&name, -0.05));
}

#[test]
fn rubber_is_pressed_as_far_by_its_force() {
    let mut scene = rubber(mooney_rivlin(), None);
    scene.supports = vec![support("z0", HELD)];
    scene.obstacles = vec![obstacle(
        "lid",
        "z1",
        plane([0.0, 0.0, 1.0], [0.0, 0.0, -1.0]),
    )];
    let body = mesh(cube(3));
    let mut step = push("lid", [0.0, 0.0, -0.2]);
    step.increments = 4;
    let mut led = open(&scene, &body);
    let force = last(&mut led, &step).obstacles["lid"].force[2];
    let mut step = down("lid", force);
    step.increments = 4;
    let mut session = open(&scene, &body);
    last(&mut session, &step);
    assert!(
        close(pose(&session)[0][2], -0.2, 1e-6),
        "{:?}",
        pose(&session)
    );
}

#[test]
fn friction_holds_a_tool_that_is_pushed_along_until_it_slides() {
    let mut scene = elastic(0.3);
    scene.supports = vec![support("z0", HELD)];
    let mut lid = obstacle("lid", "z1", plane([0.0, 0.0, 1.0], [0.0, 0.0, -1.0]));
    lid.friction = 0.5;
    scene.obstacles = vec![lid];
    let body = mesh(cube(3));
    let mut session = open(&scene, &body);
    last(&mut session, &down("lid", -0.05));
    let drag = |x: f64| pushed("lid", [Some(x), None, Some(-0.05)], [None; 3]);
    let held = last(&mut session, &drag(0.01));
    assert!(close(held.obstacles["lid"].force[0], 0.01, 1e-6));
    assert!(pose(&session)[0][0] > 0.0);
    assert_unbalanced(&mut session, &drag(0.03), "obstacle.lid.force.x");
}
