//! Friction: bodies stick exactly, slip on the disc, and agree with independent codes.

use crate::common::meshes::{cube, file, mesh, square};
use crate::common::scenes::{elastic, mooney_rivlin, obstacle, plane, rubber, support, travel};
use crate::common::{assert_converged, open, take};
use serde_json::Value;
use signorini::scene::{
    Choice, ContactSpace, Formulation, Material, MaterialModel, Modulus, RubberModel, Shape,
};
use signorini::{Scene, Step, StepReport, Termination};

const HELD: [Option<f64>; 3] = [Some(0.0); 3];
const HELD_IN_PLANE: [Option<f64>; 3] = [Some(0.0), Some(0.0), None];

/// Keys are `scene|mesh|overrides`; two independent codes agree on them to 1e-10, but for
/// mr-rough to 1e-8.
fn references() -> Value {
    serde_json::from_str(include_str!("../reference/friction.json")).expect("valid JSON")
}

/// A body that touches one rough obstacle, with the functions of the references.
fn rough(mut scene: Scene, (name, on): (&str, &str), shape: Shape, friction: f64) -> Scene {
    let mut floor = obstacle(name, on, shape);
    floor.friction = friction;
    scene.obstacles = vec![floor];
    scene.solver.tolerance = 1e-10;
    scene.solver.contact_space = Choice::Named(ContactSpace::Linear);
    scene
}

/// A block, bonded below, under a plate that presses, slides and comes back.
fn slide_block(poisson_ratio: f64, friction: f64) -> (Scene, Vec<Step>) {
    let mut scene = elastic(poisson_ratio);
    scene.supports = vec![support("y0", HELD_IN_PLANE)];
    let shape = plane([0.0, 1.0, 0.0], [0.0, -1.0, 0.0]);
    let slide = |increments, x| travel("plate", increments, [x, -0.02, 0.0], [0.0; 3]);
    (
        rough(scene, ("plate", "y1"), shape, friction),
        vec![slide(2, 0.0), slide(6, 0.12), slide(4, 0.04)],
    )
}

/// Half a ball, held at its flat top, on a floor that presses, then moves.
fn ball(symmetric: bool, end: ([f64; 3], [f64; 3])) -> (Scene, Vec<Step>) {
    let mut scene = elastic(0.5);
    scene.supports = vec![support("top", HELD)];
    if symmetric {
        scene.supports.push(support("y0", [None, Some(0.0), None]));
    }
    let shape = plane([0.0, 0.0, -1.0], [0.0, 0.0, 1.0]);
    let press = travel("floor", 2, [0.0, 0.0, 0.05], [0.0; 3]);
    (
        rough(scene, ("floor", "contact"), shape, 0.3),
        vec![press, travel("floor", 4, end.0, end.1)],
    )
}

/// Each increment against the reference `key`: force, energies, and what sticks and slips
/// where no margin is small.
fn check(key: &str, mesh: &std::sync::Arc<signorini::Mesh>, (scene, steps): (Scene, Vec<Step>)) {
    let references = references();
    let reference = &references[key];
    let mut session = open(&scene, mesh);
    let reports: Vec<StepReport> = steps.iter().flat_map(|s| take(&mut session, s)).collect();
    let exact = reference["steps"].as_array().expect("increments");
    assert_eq!(reports.len(), exact.len(), "{key}");
    for (report, exact) in reports.iter().zip(exact) {
        assert_converged(report);
        check_increment(key, report, exact);
    }
}

fn check_increment(key: &str, report: &StepReport, exact: &Value) {
    let number = |value: &Value| value.as_f64().expect("a number");
    let energy = number(&exact["strain_energy"]);
    assert!(
        (report.strain_energy - energy).abs() < 1e-7 * energy,
        "{key}"
    );
    for (name, exact) in exact["obstacles"].as_object().expect("obstacles") {
        let found = &report.obstacles[name];
        let (mut error, mut size) = (0.0_f64, 0.0_f64);
        for (i, own) in found.force.iter().enumerate() {
            let exact = number(&exact["force"][i]);
            (error, size) = (error.hypot(own - exact), size.hypot(exact));
        }
        assert!(error < 1e-7 * size, "{key} {:?}", found.force);
        let Some(sticking) = exact["stick_vertices"].as_u64() else {
            continue;
        };
        let dissipated = number(&exact["dissipated_energy"]);
        assert!(
            (found.dissipated_energy - dissipated).abs() < 1e-7 * energy,
            "{key}"
        );
        let counts = ["slip_vertices", "open_vertices"].map(|count| exact[count].as_u64());
        let own = [found.slip_vertices, found.open_vertices].map(|count| Some(u64::from(count)));
        assert_eq!(
            (u64::from(found.stick_vertices), own),
            (sticking, counts),
            "{key}"
        );
    }
}

#[test]
fn a_block_is_dragged_to_and_fro_as_two_other_codes_say() {
    for friction in ["0.1", "0.3", "1"] {
        let scene = slide_block(0.5, friction.parse().expect("a number"));
        check(
            &format!("slide-block|square_n8|friction={friction}"),
            &file("square_n8"),
            scene,
        );
    }
    let scene = slide_block(0.3, 0.3);
    check(
        "slide-block-compressible|square_n16|friction=0.3",
        &file("square_n16"),
        scene,
    );
}

#[test]
fn a_ball_slides_and_twists_as_two_other_codes_say() {
    let down = [0.0, 0.0, 0.05];
    check(
        "ball-slide|ball_c",
        &file("ball_c"),
        ball(false, ([0.03, 0.0, 0.05], [0.0; 3])),
    );
    check(
        "ball-twist|ball_c",
        &file("ball_c"),
        ball(false, (down, [0.0, 0.0, 0.2])),
    );
    let half = ball(true, ([0.03, 0.0, 0.05], [0.0; 3]));
    check("halfball-slide|halfball_c", &file("halfball_c"), half);
}

#[test]
fn the_greco_plate_that_only_the_floor_holds_slips_where_two_other_codes_say() {
    let mut scene = elastic(0.2);
    scene.materials = vec![Material {
        group: "body".to_owned(),
        model: MaterialModel::LinearElastic {
            modulus: Modulus::Young(130_000.0),
            poisson_ratio: 0.2,
            formulation: Formulation::Auto,
        },
    }];
    scene.supports = vec![support("x1", [Some(0.0), None, None])];
    scene.tractions = vec![
        crate::common::scenes::traction("y1", [0.0, -50.0, 0.0]),
        crate::common::scenes::traction("x0", [150.0, 0.0, 0.0]),
    ];
    let floor = plane([0.0; 3], [0.0, 1.0, 0.0]);
    let scene = rough(scene, ("floor", "y0"), floor, 1.0);
    check(
        "raous-plate|plate_n16",
        &file("plate_n16"),
        (scene, vec![Step::default()]),
    );
}

#[test]
fn friction_that_a_later_step_brings_follows_cattaneo() {
    let mut scene = elastic(0.5);
    scene.supports = vec![support("top", HELD_IN_PLANE)];
    let floor = plane([0.0, -1.0, 0.0], [0.0, 1.0, 0.0]);
    let scene = rough(scene, ("floor", "contact"), floor, 0.4);
    let mut press = travel("floor", 1, [0.0, 0.008, 0.0], [0.0; 3]);
    press.obstacles[0].friction = Some(0.0);
    let mut shear = travel("floor", 4, [0.004, 0.008, 0.0], [0.0; 3]);
    shear.obstacles[0].friction = Some(0.4);
    check(
        "cattaneo|disc_c",
        &file("disc_c"),
        (scene, vec![press, shear]),
    );
}

#[test]
fn rough_rubber_is_pressed_as_another_code_says() {
    let mut scene = rubber(mooney_rivlin(), None);
    scene.supports = vec![support("z0", HELD)];
    let shape = plane([0.0, 0.0, 1.0], [0.0, 0.0, -1.0]);
    let mut scene = rough(scene, ("press", "z1"), shape, 0.3);
    scene.solver.quadrature_degree = Some(2);
    let key = "mr-rough|cube_n6|friction=0.3|degree=2";
    let exact = references()[key]["steps"].clone();
    let mut session = open(&scene, &mesh(cube(6)));
    let press = travel("press", 3, [0.0, 0.0, -0.15], [0.0; 3]);
    for (report, exact) in take(&mut session, &press)
        .iter()
        .zip(exact.as_array().expect("steps"))
    {
        assert_converged(report);
        check_increment(key, report, exact);
    }
}

/// A method that diverges leaves no scale behind beside which any state is a solution.
#[test]
fn a_travel_that_is_not_reached_is_no_result() {
    let mut parts = square(4);
    parts
        .coordinates
        .iter_mut()
        .for_each(|x| x[0] = 0.8 * (x[0] - 0.5));
    let law = RubberModel::NeoHookean { shear_modulus: 1.0 };
    let mut scene = rubber(law, Some(1e3));
    let sides = ["y0", "y1", "x0", "x1"];
    let walls = [
        ("bottom", [0.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
        ("top", [0.0, 1.0, 0.0], [0.0, -1.0, 0.0]),
        ("left", [-0.5, 0.0, 0.0], [1.0, 0.0, 0.0]),
        ("right", [0.5, 0.0, 0.0], [-1.0, 0.0, 0.0]),
    ];
    scene.obstacles = walls
        .map(|(name, point, normal)| {
            let mut wall = obstacle(name, "y1", plane(point, normal));
            wall.on = sides.map(str::to_owned).into();
            wall.friction = 1.0;
            wall
        })
        .into();
    let steps = [travel("top", 1, [0.0, -0.23, 0.0], [0.0; 3])];
    let mut session = open(&scene, &mesh(parts));
    let report = take(&mut session, &steps[0]).remove(0);
    let is_reached = report.max_penetration < 0.05;
    assert!(
        is_reached || report.termination != Termination::Converged,
        "{report:?}"
    );
}
