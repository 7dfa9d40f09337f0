//! Rubber pressed as far as it goes: the step converges, or it ends with a cause
//! that names what happened to the body, where it happened, and the last good
//! state kept.

use std::sync::Arc;

use crate::common::curved::slab;
use crate::common::meshes::{cube, file, irregular, mesh, square, unit_grid};
use crate::common::scenes::{
    HELD, bonded_cube, cube_bend, in_parts, indented_block, mooney_rivlin, obstacle, plane, press,
    pull, push, rubber, squeezed_cube, support, traction,
};
use crate::common::{assert_converged, close, open, run, solve, solve_one, take, values};
use signorini::report::Stability;
use signorini::scene::{
    Choice, ContactSpace, OnInstability, RubberModel, SceneKind, Shape, StabilityCheck,
};
use signorini::{Cause, FieldName, Mesh, Scene, Session, Step, StepReport, Termination};

fn block() -> Arc<Mesh> {
    mesh(irregular(cube(3), 3))
}

/// What may end the loading of a body: it loses its equilibrium or its shape.
fn is_of_the_body(cause: Option<Cause>) -> bool {
    matches!(
        cause,
        Some(Cause::LimitPoint | Cause::UnstableEquilibrium | Cause::NegativeJacobian)
    )
}

/// The part of the loading reached; fails unless the end is an allowed one with a
/// state that is good.
fn reached(reports: &[StepReport]) -> f64 {
    let last = reports.last().expect("an increment");
    assert!(
        reports[..reports.len() - 1]
            .iter()
            .all(|r| r.cause.is_none())
    );
    let is_converged = last.termination == Termination::Converged;
    assert!(
        is_converged || is_of_the_body(last.cause),
        "{:?} at {}",
        last.cause,
        last.time
    );
    assert!(last.strain_energy.is_finite());
    assert!(last.min_jacobian.is_some_and(|least| least > 0.0));
    last.time
}

/// A ball of another radius over the quarter block, pressed to `depth`.
fn indented((radius, depth, increments): (f64, f64, u32)) -> Vec<StepReport> {
    let (mut scene, _) = indented_block();
    scene.obstacles[0].shape = Shape::Sphere {
        centre: [0.0, 0.0, radius],
        radius,
    };
    scene.solver.stability = Choice::Named(StabilityCheck::Exact);
    let step = in_parts(push("ball", [0.0, 0.0, -depth]), increments);
    solve(&scene, &[step], &file("indent_l1"))
}

/// Fails unless every increment converged to a minimum of the energy.
fn assert_minima(reports: &[StepReport]) {
    reports.iter().for_each(assert_converged);
    assert!(
        reports
            .iter()
            .all(|r| r.stability == Some(Stability::Minimum))
    );
}

#[test]
fn a_small_ball_is_pressed_in_by_half_its_radius() {
    let reports = indented((0.5, 0.25, 5));
    assert_minima(&reports);
    assert!(reports.iter().all(|report| report.penalty == 0.0));
}

#[test]
fn a_large_ball_is_pressed_in_by_two_fifths_of_its_radius() {
    assert_minima(&indented((1.0, 0.4, 8)));
}

/// Nothing but friction, which there is not, holds the top sideways: the block sways, in
/// an independent solver between 37.5 and 40 per cent, under a support as under the press.
#[test]
fn a_bonded_cube_under_a_smooth_press_stands_until_it_sways() {
    let (mut scene, _) = bonded_cube();
    scene.solver.on_instability = Choice::Named(OnInstability::Stop);
    let step = in_parts(push("press", [0.0, 0.0, -0.6]), 24);
    let reports = solve(&scene, &[step], &mesh(cube(4)));
    let last = reports.last().expect("an increment");
    assert!(0.6 * last.time >= 0.375, "{}", last.time);
}

/// By the inertia of an independent solver's tangent (`saddle_contact.py`): stable at 45 per
/// cent, one unstable motion at 48.75.
#[test]
fn an_evenly_pressed_cube_is_stable_until_it_is_not_and_needs_no_penalty() {
    let (mut scene, _) = squeezed_cube();
    scene.solver.penalty = Some(0.0);
    scene.solver.on_instability = Choice::Named(OnInstability::Stop);
    let step = in_parts(push("press", [0.0, 0.0, -0.6]), 16);
    let reports = solve(&scene, &[step], &mesh(cube(4)));
    let part = reached(&reports);
    assert!((0.449..0.4875).contains(&(0.6 * part)), "{part}");
    let last = reports.last().expect("an increment");
    assert_eq!(last.cause, Some(Cause::UnstableEquilibrium));
}

/// Hats for the contact pressure: the pair loses the state before the body does.
#[test]
fn an_evenly_pressed_cube_is_stable_to_two_fifths_under_hats() {
    let (mut scene, _) = squeezed_cube();
    scene.solver.contact_space = Choice::Named(ContactSpace::Linear);
    scene.solver.on_instability = Choice::Named(OnInstability::Stop);
    let step = in_parts(push("press", [0.0, 0.0, -0.4]), 8);
    let part = reached(&solve(&scene, &[step], &mesh(cube(4))));
    assert!(part >= 1.0, "{part}");
}

/// A strip of a layer of 32 to 1, bonded below.
fn layer(bulk_modulus: Option<f64>) -> (Scene, Arc<Mesh>) {
    let mut scene = rubber(mooney_rivlin(), bulk_modulus);
    scene.supports = vec![
        support("z0", HELD),
        support("y0", [None, Some(0.0), None]),
        support("y1", [None, Some(0.0), None]),
    ];
    (scene, mesh(slab([64, 1, 3], [32.0, 0.5, 1.0])))
}

#[test]
fn a_layer_of_32_to_1_bonded_on_both_sides_is_pressed_by_a_tenth() {
    let (mut scene, layer) = layer(Some(100.0));
    scene.supports.push(support("z1", HELD));
    let step = pull("z1", [None, None, Some(-0.1)], 5);
    let reports = solve(&scene, &[step], &layer);
    reports.iter().for_each(assert_converged);
    let last = &reports[4];
    assert!(last.volume_ratio > 0.9 && last.volume_ratio < 0.95);
    // Of a soft spring between its bulk modulus and its shear modulus.
    let nominal = -last.supports["z1"].force[2] / (32.0 * 0.5);
    assert!(nominal > 5.0 && nominal < 12.0, "{nominal}");
}

/// Plane, so that what is pressed out leaves by two sides: sheared by one at the rims. Pressed
/// twice as far a cell of this mesh is inside out.
#[test]
fn an_incompressible_strip_of_32_to_1_bonded_on_both_sides_is_pressed_by_a_50th() {
    let (mut scene, layer) = layer(None);
    scene.supports.push(support("z1", HELD));
    let step = pull("z1", [None, None, Some(-0.02)], 2);
    let reports = solve(&scene, &[step], &layer);
    reports.iter().for_each(assert_converged);
    assert!(close(reports[1].volume_ratio, 1.0, 1e-8));
}

#[test]
fn an_incompressible_layer_of_32_to_1_bears_a_roller_a_tenth_deep() {
    let (mut scene, layer) = layer(None);
    let shape = Shape::Cylinder {
        point: [16.0, 0.0, 9.0],
        axis: [0.0, 1.0, 0.0],
        radius: 8.0,
    };
    scene.obstacles = vec![obstacle("roller", "z1", shape)];
    let step = in_parts(push("roller", [0.0, 0.0, -0.1]), 5);
    let reports = solve(&scene, &[step], &layer);
    reports.iter().for_each(assert_converged);
    let [across, _, up] = reports[4].obstacles["roller"].force;
    assert!(up < -0.1 && across.abs() < 1e-2 * up.abs(), "{across} {up}");
}

/// The cube with five clamped faces under what presses on the sixth.
fn enclosed(bulk_modulus: Option<f64>) -> Scene {
    let mut scene = rubber(mooney_rivlin(), bulk_modulus);
    let sides = ["x0", "x1", "y0", "y1", "z0"];
    scene.supports = sides.map(|side| support(side, HELD)).to_vec();
    scene.obstacles = vec![press("z1")];
    scene
}

#[test]
fn a_lid_cannot_compress_what_fills_its_box() {
    let scene = enclosed(None);
    let reports = solve(&scene, &[push("press", [0.0, 0.0, -0.05])], &block());
    let last = reports.last().expect("an increment");
    assert_eq!(last.termination, Termination::NotConverged);
    assert_eq!(last.cause, Some(Cause::EnclosedVolume));
}

/// A strip bonded to the floor of a groove with a tenth of room on either side, which is full
/// when the lid has come down by a sixth.
#[test]
fn a_lid_cannot_squeeze_what_fills_its_groove() {
    let mut scene = rubber(RubberModel::NeoHookean { shear_modulus: 1.0 }, None);
    scene.kind = Some(SceneKind::PlaneStrain);
    scene.supports = vec![support("y0", [Some(0.0), Some(0.0), None])];
    scene.obstacles = vec![
        obstacle("left", "x0", plane([-0.1, 0.0, 0.0], [1.0, 0.0, 0.0])),
        obstacle("right", "x1", plane([1.1, 0.0, 0.0], [-1.0, 0.0, 0.0])),
        obstacle("lid", "y1", plane([0.0, 1.0, 0.0], [0.0, -1.0, 0.0])),
    ];
    let step = in_parts(push("lid", [0.0, -0.18, 0.0]), 9);
    let reports = solve(&scene, &[step], &mesh(unit_grid(6, 12)));
    reports[..8].iter().for_each(assert_converged);
    assert_eq!(reports[8].termination, Termination::NotConverged);
    assert_eq!(reports[8].cause, Some(Cause::EnclosedVolume));
}

/// A round lid fills the box on the way: until then the body gives way to it.
#[test]
fn a_round_lid_comes_no_deeper_than_the_box_is_full() {
    let mut scene = rubber(mooney_rivlin(), None);
    scene.kind = Some(SceneKind::PlaneStrain);
    let floor = support("y0", [None, Some(0.0), None]);
    let wall = |name: &str| support(name, [Some(0.0), None, None]);
    scene.supports = vec![floor, wall("x0"), wall("x1")];
    let shape = Shape::Cylinder {
        point: [0.5, 2.0, 0.0],
        axis: [0.0, 0.0, 1.0],
        radius: 1.0,
    };
    scene.obstacles = vec![obstacle("lid", "y1", shape)];
    let step = push("lid", [0.0, -0.2, 0.0]);
    let reports = solve(&scene, std::slice::from_ref(&step), &mesh(square(4)));
    let full = reports.last().expect("an increment");
    assert_eq!(full.cause, Some(Cause::EnclosedVolume));
    // Of the unit length, by the area under the arc of sixty degrees.
    let depth = 1.0 - (3.0_f64.sqrt() / 4.0 + std::f64::consts::PI / 6.0);
    assert!(
        (0.9 * depth..depth).contains(&(0.2 * full.load)),
        "{}",
        full.load
    );
    // With a side that is free it never is.
    scene.supports.pop();
    let step = in_parts(step, 4);
    let reports = solve(&scene, &[step], &mesh(square(4)));
    reports.iter().for_each(assert_converged);
}

#[test]
fn a_lid_compresses_what_fills_its_box_and_can_give_way() {
    let scene = enclosed(Some(10.0));
    let step = in_parts(push("press", [0.0, 0.0, -0.05]), 5);
    let reports = solve(&scene, &[step], &block());
    reports.iter().for_each(assert_converged);
    assert!(reports[1].volume_ratio < 1.0);
}

/// Homogeneous, so exact on any mesh; finer ones buckle before one half, pushed or
/// pressed.
#[test]
fn a_body_half_inside_its_obstacle_at_first_is_pushed_out() {
    for (cells, height) in [(1, 0.5_f64), (2, 0.6)] {
        let (mut scene, _) = squeezed_cube();
        scene.obstacles[0].shape = Shape::HalfSpace {
            point: [0.0, 0.0, height],
            normal: [0.0, 0.0, -1.0],
        };
        let report = solve_one(&scene, &Step::default(), &mesh(cube(cells)));
        let force = -report.obstacles["press"].force[2];
        let exact = 2.0 * (height.powi(-2) - height) * (0.4 + 0.1 / height);
        assert!(close(force, exact, 1e-6), "{height} {force} {exact}");
    }
}

/// A bonded block under a dead load on its top.
fn loaded(load: [f64; 3]) -> Scene {
    let mut scene = rubber(mooney_rivlin(), None);
    scene.supports = vec![support("z0", HELD)];
    scene.tractions = vec![traction("z1", load)];
    scene
}

#[test]
fn absurd_loads_end_with_the_body_as_it_was() {
    for load in [[0.0, 0.0, -1e6], [0.0, 0.0, 1e6], [1e6, 0.0, 0.0]] {
        let (session, reports) = run(&loaded(load), &[], &block());
        let cause = reports[0].cause;
        assert!(is_of_the_body(cause), "{load:?} {cause:?}");
        assert!(reports[0].residuals.largest() <= 1e-8);
        let largest = largest_displacement(&session);
        assert!(largest.is_finite(), "{largest}");
    }
}

fn largest_displacement(session: &Session) -> f64 {
    let all = values(session, FieldName::Displacement);
    all.iter().fold(0.0, |most: f64, x| most.max(x.abs()))
}

#[test]
fn a_session_goes_on_after_a_load_that_was_too_much() {
    let mut session = open(&loaded([0.0, 0.0, -1e6]), &block());
    let failed = take(&mut session, &Step::default());
    assert_eq!(failed[0].termination, Termination::NotConverged);
    let small = Step {
        load: Some(1e-7),
        ..Step::default()
    };
    let reports = take(&mut session, &small);
    assert_converged(&reports[0]);
    assert!(largest_displacement(&session) > 0.0);
}

#[test]
fn a_load_taken_back_leaves_no_displacement() {
    let mut scene = loaded([0.3, 0.0, -0.1]);
    scene.solver.tolerance = 1e-10;
    let mut session = open(&scene, &block());
    let load = |factor, increments| Step {
        load: Some(factor),
        increments,
        ..Step::default()
    };
    for step in [load(1.0, 2), load(-1.0, 2), load(0.0, 2)] {
        let reports = take(&mut session, &step);
        reports.iter().for_each(assert_converged);
    }
    let left = largest_displacement(&session);
    assert!(left <= 1e-10, "{left:e}");
}

#[test]
fn an_obstacle_taken_back_leaves_no_displacement() {
    let (mut scene, _) = bonded_cube();
    scene.solver.tolerance = 1e-10;
    // At rest the stresses of the second path are rounding.
    scene.solver.verify = false;
    let mut session = open(&scene, &block());
    for travel in [-0.2, 0.0, 0.1] {
        let step = in_parts(push("press", [0.0, 0.0, travel]), 2);
        let reports = take(&mut session, &step);
        reports.iter().for_each(assert_converged);
    }
    let left = largest_displacement(&session);
    assert!(left <= 1e-10, "{left:e}");
}

/// The last increment ends without a contact pressure to measure it by.
#[test]
fn a_press_taken_back_in_small_increments_lets_go() {
    let (scene, _) = bonded_cube();
    let step = |travel| in_parts(push("press", [0.0, 0.0, travel]), 5);
    let reports = solve(&scene, &[step(-0.25), step(0.0)], &mesh(cube(4)));
    assert_eq!(reports.len(), 10);
    reports.iter().for_each(assert_converged);
    assert!(reports[9].strain_energy < 1e-16);
}

#[test]
fn an_increment_a_hundred_times_too_large_ends_where_small_ones_do() {
    let mut scene = rubber(RubberModel::NeoHookean { shear_modulus: 1.0 }, None);
    let bent = cube_bend(0.5);
    scene.supports = bent.supports;
    // Half of it: under the whole a cell at the support is inside out.
    scene.tractions = bent.tractions;
    scene.tractions[0].value = scene.tractions[0].value.map(|x| 0.5 * x);
    let at_once = solve_one(&scene, &Step::default(), &block());
    let parts = in_parts(Step::default(), 100);
    let reports = solve(&scene, &[parts], &block());
    assert_eq!(reports.len(), 100);
    reports.iter().for_each(assert_converged);
    let slowly = reports[99].strain_energy;
    assert!(close(at_once.strain_energy, slowly, 1e-6), "{slowly}");
}
