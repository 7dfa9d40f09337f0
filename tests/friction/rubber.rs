//! Rubber with friction: blocks and bodies pressed as far as without, a wheel that rolls, a
//! block that is twisted, a seal under the pressure of a fluid; what tools do is stored or
//! dissipated.

use std::f64::consts::FRAC_PI_2;

use crate::common::meshes::{cube, file, mesh, moved, ring, unit_grid};
use crate::common::scenes::{
    HELD, mooney_rivlin, obstacle, plane, rubber, squeezed_cube, support, travel,
};
use crate::common::{assert_converged, close, open, solve, take};
use signorini::scene::{
    Choice, ContactMethod, ContactSpace, Formulation, Material, MaterialModel, ObstacleTarget,
    Pressure, RubberModel, Shape, SupportTarget,
};
use signorini::{Cause, Scene, Step, StepReport};

/// With one more obstacle of that friction.
fn with_rough(scene: &mut Scene, (name, on): (&str, &[&str]), shape: Shape, friction: f64) {
    let mut tool = obstacle(name, on[0], shape);
    tool.on = on.iter().map(|&on| on.to_owned()).collect();
    tool.friction = friction;
    scene.obstacles.push(tool);
}

#[test]
fn a_rough_plate_presses_a_block_as_far_as_a_smooth_one() {
    let mut forces = Vec::new();
    for friction in [0.0, 0.3, 1.0] {
        let (mut scene, step) = squeezed_cube();
        scene.supports = vec![support("z0", HELD)];
        scene.obstacles[0].friction = friction;
        let reports = solve(&scene, &[step], &mesh(cube(4)));
        reports.iter().for_each(assert_converged);
        let press = &reports.last().expect("a result").obstacles["press"];
        assert_eq!(friction > 0.0, press.dissipated_total > 0.0);
        forces.push(press.force[2].abs());
    }
    // What friction holds needs more force, and friction that holds all the most.
    assert!(
        forces.is_sorted() && forces[2] < 1.2 * forces[0],
        "{forces:?}"
    );
}

#[test]
fn functions_of_vertices_alone_press_a_rough_block_as_far_with_a_penalty() {
    let mut scene = rubber(mooney_rivlin(), None);
    scene.supports = vec![support("z0", HELD)];
    scene.solver.contact_space = Choice::Named(ContactSpace::Linear);
    let press = plane([0.5, 0.5, 1.0], [0.0, 0.0, -1.0]);
    with_rough(&mut scene, ("press", &["z1"]), press, 0.3);
    let down = travel("press", 10, [0.0, 0.0, -0.25], [0.0; 3]);
    let reports = solve(&scene, &[down], &mesh(cube(6)));
    assert_eq!(reports.len(), 10);
    reports.iter().for_each(assert_converged);
}

/// A roller is pressed on a strip of rubber and turned by a moment: it rolls away from the largest
/// one that sticking points give it.
#[test]
fn a_roller_turned_by_more_than_its_contact_holds_has_no_equilibrium() {
    let model = RubberModel::NeoHookean { shear_modulus: 1.0 };
    let mut scene = rubber(model, Some(50.0));
    scene.supports = vec![support("y0", [Some(0.0), Some(0.0), None])];
    let roller = Shape::Cylinder {
        point: [1.5, 1.4, 0.0],
        axis: [0.0, 0.0, 1.0],
        radius: 0.4,
    };
    with_rough(&mut scene, ("roller", &["y1"]), roller, 0.5);
    let pushed = |increments, force, moment| {
        let mut step = travel("roller", increments, [0.0; 3], [0.0; 3]);
        step.obstacles[0].translation = None;
        step.obstacles[0].rotation = None;
        step.obstacles[0].force = force;
        step.obstacles[0].moment = moment;
        step
    };
    let steps = [
        pushed(2, [None, Some(-0.2), None], [None; 3]),
        pushed(4, [Some(0.0), Some(-0.2), None], [None, None, Some(-0.005)]),
    ];
    let strip = moved(unit_grid(24, 8), |[x, y, _]| [3.0 * x, y, 0.0]);
    let reports = solve(&scene, &steps, &mesh(strip));
    let (last, held) = reports.split_last().expect("a result");
    assert!(held.len() >= 2);
    held.iter().for_each(assert_converged);
    assert_eq!(last.cause, Some(Cause::NoEquilibrium));
    let key = last.cause_site.as_ref().and_then(|site| site.key.clone());
    assert!(key.is_some_and(|key| key.starts_with("obstacle.roller.")));
}

/// Force on a rough plate that presses and drags a soft block and, apart from it, one of that
/// modulus, and the applications that it took.
fn on_two_blocks(modulus: f64, method: Choice<ContactMethod>) -> ([f64; 3], u32) {
    let block = |group: &str, shear_modulus: f64| Material {
        group: group.to_owned(),
        model: MaterialModel::Rubber {
            model: RubberModel::NeoHookean { shear_modulus },
            bulk_modulus: None,
            formulation: Formulation::Auto,
        },
    };
    let mut scene = Scene {
        materials: vec![block("a", 1.0), block("b", modulus)],
        supports: vec![support("y0", [Some(0.0), Some(0.0), None])],
        ..Scene::default()
    };
    scene.solver.contact = method;
    let plate = plane([0.0, 1.0, 0.0], [0.0, -1.0, 0.0]);
    with_rough(&mut scene, ("plate", &["y1"]), plate, 0.3);
    let drag = travel("plate", 3, [0.02, -0.15, 0.0], [0.0; 3]);
    let reports = solve(&scene, &[drag], &file("two_blocks"));
    assert_eq!(reports.len(), 3);
    reports.iter().for_each(assert_converged);
    let counts = reports
        .iter()
        .map(|report| report.preconditioner_applications);
    (reports[2].obstacles["plate"].force, counts.sum())
}

#[test]
fn blocks_apart_are_solved_under_one_rough_plate_whatever_their_moduli() {
    // Each block is what it is alone, so that the force is a + b c for the modulus c.
    let [low, middle, high] = [100.0, 1e3, 1e4].map(|modulus| {
        let (force, spent) = on_two_blocks(modulus, Choice::Auto);
        assert!(spent < 400, "{modulus}: {spent} applications");
        force
    });
    for axis in 0..2 {
        let slope = (middle[axis] - low[axis]) / 900.0;
        let expected = middle[axis] + 9000.0 * slope;
        let error = (high[axis] - expected).abs() / expected.abs();
        assert!(error < 1e-6, "{axis}: {error:e}");
    }
}

#[test]
fn a_factor_finds_what_iterations_find_and_sooner() {
    // A scene that names its method keeps to iterations.
    let named = Choice::Named(ContactMethod::OneLevel);
    let [by_factor, by_iterations] =
        [Choice::Auto, named].map(|method| on_two_blocks(100.0, method));
    for (own, other) in by_factor.0.iter().zip(by_iterations.0) {
        assert!(
            (own - other).abs() < 1e-6 * by_iterations.0[1].abs(),
            "{own} {other}"
        );
    }
    let [few, many] = [by_factor.1, by_iterations.1];
    assert!(3 * few <= 2 * many, "{few} {many}");
}

/// Work of a plate that twists a pressed block, over what is stored and dissipated.
fn twisted(increments: u32) -> f64 {
    let mut scene = rubber(mooney_rivlin(), None);
    scene.supports = vec![support("z0", HELD)];
    let plate = plane([0.5, 0.5, 1.0], [0.0, 0.0, -1.0]);
    with_rough(&mut scene, ("plate", &["z1"]), plate, 0.5);
    let down = [0.0, 0.0, -0.15];
    let mut session = open(&scene, &mesh(cube(3)));
    let pressed = take(&mut session, &travel("plate", 3, down, [0.0; 3]));
    let mut before = pressed.last().expect("a result").clone();
    let first = before.strain_energy;
    let (mut work, mut lost) = (0.0, 0.0);
    for report in take(
        &mut session,
        &travel("plate", increments, down, [0.0, 0.0, 0.8]),
    ) {
        assert_converged(&report);
        let moment = |report: &StepReport| report.obstacles["plate"].moment[2];
        work += 0.5 * (moment(&before) + moment(&report)) * 0.8 / f64::from(increments);
        lost += report.obstacles["plate"].dissipated_energy;
        before = report;
    }
    assert!(before.obstacles["plate"].slip_vertices > 0 && lost > 0.0);
    (work - (before.strain_energy - first) - lost) / work
}

#[test]
fn what_twists_a_block_is_stored_or_dissipated() {
    let [coarse, fine] = [40, 80].map(twisted);
    assert!(
        fine.abs() < 1e-3 && fine.abs() < 0.75 * coarse.abs(),
        "{coarse} {fine}"
    );
}

/// Reports of a wheel that is pressed onto a road and rolls a quarter turn by `increments`.
fn rolled(increments: u32) -> Vec<StepReport> {
    let mut scene = rubber(mooney_rivlin(), None);
    scene.supports = vec![support("rim", [Some(0.0), Some(0.0), None])];
    let road = plane([0.0, -1.0, 0.0], [0.0, 1.0, 0.0]);
    with_rough(&mut scene, ("road", &["tread"]), road, 0.8);
    let rim = |translation, angle: f64| SupportTarget {
        name: "rim".to_owned(),
        translation: Some(translation),
        rotation: Some([0.0, 0.0, angle]),
        about: Some([0.0; 3]),
        ..SupportTarget::default()
    };
    let step = |increments, support| Step {
        increments,
        supports: vec![support],
        ..Step::default()
    };
    let steps = [
        step(2, rim([0.0, -0.06, 0.0], 0.0)),
        step(increments, rim([FRAC_PI_2, -0.06, 0.0], -FRAC_PI_2)),
    ];
    let reports = solve(&scene, &steps, &mesh(ring(64, 4, 0.6)));
    assert_eq!(reports.len(), increments as usize + 2);
    reports.iter().for_each(assert_converged);
    reports
}

#[test]
fn a_wheel_rolls_a_quarter_turn_without_sliding() {
    let reports = rolled(18);
    for report in &reports {
        let road = &report.obstacles["road"];
        let pull = road.tangential_force[0].abs();
        assert!(road.stick_vertices > 0 && pull < 0.8 * road.force[1]);
    }
    // The axle moves on by the unloaded radius, the pressed wheel rolls on a shorter one: it
    // is pushed back, more and more.
    let pulls: Vec<f64> = (reports[3..].iter())
        .map(|report| report.obstacles["road"].force[0])
        .collect();
    assert!(pulls.is_sorted(), "{pulls:?}");
}

/// Work that rolls a wheel over what is stored and dissipated: what is missing, over the work
/// that presses it.
fn lost_by_rolling(increments: u32) -> f64 {
    let reports = rolled(increments);
    let part = FRAC_PI_2 / f64::from(increments);
    // The rim answers the road: - F along the way, - M about the axle, which is at `x`.
    let power = |report: &StepReport, x: f64| {
        let road = &report.obstacles["road"];
        let arm = [-x, -1.0 + 0.06];
        let about = road.moment[2] + arm[0] * road.force[1] - arm[1] * road.force[0];
        -road.force[0] + about
    };
    let (mut work, mut dissipated) = (0.0, 0.0);
    for (number, pair) in (0..).zip(reports[1..].windows(2)) {
        let ends = [0, 1].map(|end| power(&pair[end], f64::from(number + end as u32) * part));
        work += 0.5 * (ends[0] + ends[1]) * part;
        dissipated += pair[1].obstacles["road"].dissipated_energy;
    }
    let (first, last) = (&reports[1], &reports[reports.len() - 1]);
    (work - (last.strain_energy - first.strain_energy) - dissipated) / first.strain_energy
}

#[test]
fn what_rolls_a_wheel_is_stored_or_dissipated_as_increments_shrink() {
    // Points leave the road under traction within an increment: what that frees is of the first
    // order in the increment.
    let [coarse, fine] = [72, 144].map(lost_by_rolling);
    assert!(coarse < 0.2 && fine > 0.0, "{coarse} {fine}");
    assert!(fine < 0.6 * coarse, "{coarse} {fine}");
}

/// Work of a lid that squeezes a seal between rough plates, over what is stored and dissipated.
fn squeezed(increments: u32) -> f64 {
    let mut scene = rubber(mooney_rivlin(), Some(1000.0));
    let sides: &[&str] = &["left", "right"];
    let floor = plane([0.0, -1.0, 0.0], [0.0, 1.0, 0.0]);
    let lid = plane([0.0, 1.0, 0.0], [0.0, -1.0, 0.0]);
    with_rough(&mut scene, ("floor", sides), floor, 0.3);
    with_rough(&mut scene, ("lid", sides), lid, 0.3);
    let squeeze = travel("lid", increments, [0.0, -0.4, 0.0], [0.0; 3]);
    let reports = solve(&scene, &[squeeze], &file("section_h20"));
    reports.iter().for_each(assert_converged);
    let mut force = 0.0;
    let (mut work, mut lost) = (0.0, 0.0);
    for report in &reports {
        let next = report.obstacles["lid"].force[1];
        work -= 0.5 * (force + next) * 0.4 / f64::from(increments);
        let dissipated = |name: &str| report.obstacles[name].dissipated_energy;
        lost += dissipated("floor") + dissipated("lid");
        force = next;
    }
    let stored = reports.last().expect("a result").strain_energy;
    (work - stored - lost) / work
}

#[test]
fn what_squeezes_a_rough_seal_is_stored_or_dissipated() {
    let [coarse, fine] = [12, 24].map(squeezed);
    assert!(
        fine.abs() < 1e-3 && fine.abs() < 0.75 * coarse.abs(),
        "{coarse} {fine}"
    );
}

#[test]
fn a_cylinder_that_is_turned_rolls_where_nothing_holds_it_along() {
    let radius = 1.15;
    let mut scene = rubber(RubberModel::NeoHookean { shear_modulus: 1.0 }, None);
    scene.supports = vec![support("y0", [Some(0.0), Some(0.0), None])];
    let roller = Shape::Cylinder {
        point: [1.8, 1.0 + radius, 0.0],
        axis: [0.0, 0.0, 1.0],
        radius,
    };
    with_rough(&mut scene, ("roller", &["y1"]), roller, 0.05);
    let pressed = |along: Option<f64>, turn: Option<f64>| Step {
        increments: 4,
        obstacles: vec![ObstacleTarget {
            name: "roller".to_owned(),
            force: [along, Some(-0.17), None],
            rotation: turn.map(|angle| [0.0, 0.0, angle]),
            ..ObstacleTarget::default()
        }],
        ..Step::default()
    };
    let steps = [
        (None, None),
        (Some(0.0), Some(0.4)),
        (Some(0.0), Some(-0.2)),
    ];
    let steps = steps.map(|(along, turn)| pressed(along, turn));
    let mut parts = unit_grid(36, 10);
    parts.coordinates.iter_mut().for_each(|x| x[0] *= 3.6);
    let reports = solve(&scene, &steps, &mesh(parts));
    reports.iter().for_each(assert_converged);
    assert_eq!(reports.len(), 12);
    let rolled = &|number: usize| reports[number].obstacles["roller"].clone();
    // Down a soft body a roller goes by a few percent farther than its rim.
    for (number, turn) in [(7, 0.4), (11, -0.2)] {
        let roller = rolled(number);
        let way = roller.centre_of_pressure[0] - 1.8;
        assert!(close(way, -radius * turn, 0.06), "{way}");
        assert!(roller.force[0].abs() < 1e-7, "{roller:?}");
    }
    // Were it to slide, friction would take as much as force and way over the normal say.
    let slid = 0.05 * 0.17 * radius * 1.0;
    assert!(rolled(11).dissipated_total < 0.05 * slid);
    let most = reports
        .iter()
        .map(|report| report.preconditioner_applications);
    assert!(most.max() <= Some(150));
}

#[test]
fn a_fluid_pushes_a_rough_seal_to_the_wall_of_its_groove() {
    let mut scene = rubber(mooney_rivlin(), Some(1000.0));
    let sides: &[&str] = &["left", "right"];
    let floor = plane([0.0, -1.0, 0.0], [0.0, 1.0, 0.0]);
    let lid = plane([0.0, 1.0, 0.0], [0.0, -1.0, 0.0]);
    let wall = plane([1.3, 0.0, 0.0], [-1.0, 0.0, 0.0]);
    with_rough(&mut scene, ("floor", sides), floor, 0.3);
    with_rough(&mut scene, ("lid", sides), lid, 0.3);
    with_rough(&mut scene, ("wall", &["right"]), wall, 0.3);
    scene.pressures = vec![Pressure {
        on: vec!["left".to_owned()],
        value: 1.0,
    }];
    let mut squeeze = travel("lid", 5, [0.0, -0.4, 0.0], [0.0; 3]);
    squeeze.load = Some(0.0);
    let fill = Step {
        increments: 10,
        load: Some(1.0),
        ..Step::default()
    };
    let reports = solve(&scene, &[squeeze, fill], &file("section_h20"));
    assert_eq!(reports.len(), 15);
    reports.iter().for_each(assert_converged);
    let [squeezed, held, filled] = [4, 6, 14].map(|number| &reports[number].obstacles);
    // Friction alone holds the seal at first, then it slides to the wall.
    assert!(squeezed["wall"].force[0] == 0.0 && held["wall"].force[0] == 0.0);
    assert!(held["floor"].tangential_force[0] < -0.1);
    assert!(filled["wall"].force[0] < -0.5);
    for name in ["floor", "lid"] {
        let [x, y, _] = filled[name].force;
        assert!(x < 0.0 && x.abs() <= 0.3 * y.abs() * (1.0 + 1e-9));
        assert!(filled[name].dissipated_total > 0.0);
    }
}
