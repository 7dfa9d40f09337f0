//! Quadratic contact pressure: discrete references of an independent code, stability
//! under pressures far above the shear modulus, and the multipliers of held nodes,
//! corners and neighbouring obstacles.

use std::sync::Arc;

use crate::common::meshes::{cube, file, mesh, square, unit_grid};
use crate::common::scenes::{
    HELD, bonded_cube, elastic, hertz_plane, hertz_sphere, obstacle, press, pull, push, rollers,
    rubber, support,
};
use crate::common::{assert_converged, close, solve, solve_one};
use serde_json::Value;
use signorini::report::Stability;
use signorini::scene::{Choice, ContactSpace, RubberModel, Shape, StabilityCheck};
use signorini::{Mesh, Scene, Step, StepReport};

fn references() -> Value {
    serde_json::from_str(include_str!("../reference/contact_space.json")).expect("valid JSON")
}

fn number(value: &Value, key: &str) -> f64 {
    let value = &value[key];
    value
        .as_f64()
        .unwrap_or_else(|| panic!("a number `{key}`, not {value}"))
}

fn only_force(report: &StepReport) -> [f64; 3] {
    let obstacle = report.obstacles.values().next().expect("one obstacle");
    obstacle.force
}

fn check_contact(case: &str, meshes: [&str; 2], (scene, step): (Scene, Step)) {
    for name in meshes {
        let exact = &references()[case][name];
        let report = solve_one(&scene, &step, &file(name));
        assert_eq!(u64::from(report.active_vertices), exact["active"]);
        let force = 4.0 * only_force(&report)[2].abs();
        assert!(close(force, number(exact, "force"), 1e-9), "{name} {force}");
        let energy = report.strain_energy;
        let expected = number(exact, "strain_energy");
        assert!(close(energy, expected, 1e-9), "{name} {energy}");
    }
}

#[test]
fn a_ball_on_a_plane_has_the_published_force() {
    check_contact("hertz-plane", ["hemi_l1", "hemi_l2"], hertz_plane(0.5));
}

#[test]
fn a_block_under_a_sphere_has_the_published_force() {
    let meshes = ["indent_l1", "indent_l2"];
    check_contact("hertz-sphere", meshes, hertz_sphere(0.5));
}

#[test]
fn a_bonded_cube_of_rubber_has_the_published_force() {
    let (mut scene, mut step) = bonded_cube();
    scene.solver.quadrature_degree = Some(8);
    scene.solver.tolerance = 1e-10;
    let exact = &references()["mr-block"]["cube_n6"]["degree_8"];
    // Of an equilibrium it does not matter in how many increments it is come to: every second one.
    step.increments /= 2;
    let reports = solve(&scene, &[step], &mesh(cube(6)));
    let exact = exact.as_array().expect("steps").iter();
    for (report, exact) in reports.iter().zip(exact.skip(1).step_by(2)) {
        assert_converged(report);
        let force = only_force(report)[2].abs();
        assert!(close(force, number(exact, "force"), 1e-7), "{force}");
        let energy = report.strain_energy;
        assert!(close(energy, number(exact, "strain_energy"), 1e-7));
        assert!(report.penalty.abs() < f64::EPSILON);
    }
}

/// The unit cube of rubber in a box without friction, its lid still open.
fn box_of_rubber(bulk_modulus: f64) -> Scene {
    let model = RubberModel::NeoHookean { shear_modulus: 1.0 };
    let mut scene = rubber(model, Some(bulk_modulus));
    scene.supports = rollers();
    let walls = [
        support("x1", [Some(0.0), None, None]),
        support("y1", [None, Some(0.0), None]),
    ];
    scene.supports.extend(walls);
    scene
}

/// The lid as an obstacle, and as a support; the certificate is that of a factor.
fn lids(bulk_modulus: f64, squeeze: f64, mesh: &Arc<Mesh>) -> [StepReport; 2] {
    under_lids((bulk_modulus, squeeze), StabilityCheck::Exact, mesh)
}

/// The same with any certificate.
fn under_lids(
    (bulk_modulus, squeeze): (f64, f64),
    stability: StabilityCheck,
    mesh: &Arc<Mesh>,
) -> [StepReport; 2] {
    let mut pressed = box_of_rubber(bulk_modulus);
    pressed.obstacles = vec![press("z1")];
    let down = push("press", [0.0, 0.0, -squeeze]);
    let mut held = box_of_rubber(bulk_modulus);
    held.supports.push(support("z1", [None, None, Some(0.0)]));
    let pulled = pull("z1", [None, None, Some(-squeeze)], 1);
    for scene in [&mut pressed, &mut held] {
        scene.solver.stability = Choice::Named(stability);
    }
    [(pressed, down), (held, pulled)].map(|(scene, step)| solve_one(&scene, &step, mesh))
}

#[test]
fn a_confined_block_carries_any_pressure_on_an_obstacle_as_on_a_support() {
    for (bulk_modulus, squeeze, count) in [
        (1e2, 0.05, 4),
        (1e3, 0.05, 2),
        (1e4, 0.1, 3),
        (1e6, 0.2, 3),
        (1e6, 0.01, 5),
    ] {
        let [pressed, held] = lids(bulk_modulus, squeeze, &mesh(cube(count)));
        for report in [&pressed, &held] {
            assert_eq!(report.stability, Some(Stability::Minimum));
        }
        assert!(pressed.penalty.abs() < f64::EPSILON);
        let force = only_force(&pressed)[2];
        let exact = held.supports["z1"].force[2];
        assert!(close(force, exact, 1e-7), "{bulk_modulus} {force} {exact}");
        let (own, other) = (
            pressed.preconditioner_applications,
            held.preconditioner_applications,
        );
        assert!(
            own <= 2 * other,
            "{bulk_modulus} {squeeze} {count}: {own} {other}"
        );
    }
}

#[test]
fn a_fine_confined_block_costs_no_more_under_high_pressure() {
    // 100 and 200 shear moduli.
    for (bulk_modulus, squeeze) in [(1e3, 0.2), (1e4, 0.01)] {
        let off = StabilityCheck::Off;
        let [pressed, held] = under_lids((bulk_modulus, squeeze), off, &mesh(cube(8)));
        let counts = [&pressed, &held].map(|report| report.preconditioner_applications);
        assert!(counts[0] <= 2 * counts[1], "{bulk_modulus}: {counts:?}");
    }
}

#[test]
fn a_bonded_strip_of_rubber_is_pressed_without_a_cut_back() {
    let mut parts = unit_grid(16, 2);
    parts.coordinates.iter_mut().for_each(|x| x[0] *= 8.0);
    for bulk_modulus in [None, Some(1e3)] {
        let mut scene = rubber(RubberModel::NeoHookean { shear_modulus: 1.0 }, bulk_modulus);
        scene.supports = vec![support("y0", [Some(0.0), Some(0.0), None])];
        scene.obstacles = vec![obstacle(
            "press",
            "y1",
            Shape::HalfSpace {
                point: [0.0, 1.0, 0.0],
                normal: [0.0, -1.0, 0.0],
            },
        )];
        let step = Step {
            increments: 10,
            ..push("press", [0.0, -0.1, 0.0])
        };
        for report in solve(&scene, &[step], &mesh(parts.clone())) {
            assert_converged(&report);
            let counts = [report.preconditioner_applications, report.sqp_iterations];
            assert!(counts[0] <= 110 && counts[1] <= 5, "{counts:?}");
        }
    }
}

#[test]
fn a_box_with_a_wall_and_a_lid_is_pressed_to_half_in_one_increment() {
    let lid = Shape::HalfSpace {
        point: [0.0, 1.0, 0.0],
        normal: [0.0, -1.0, 0.0],
    };
    let wall = Shape::HalfSpace {
        point: [1.0, 0.0, 0.0],
        normal: [-1.0, 0.0, 0.0],
    };
    for bulk_modulus in [30.0, 100.0, 1e4] {
        let model = RubberModel::NeoHookean { shear_modulus: 1.0 };
        let mut scene = rubber(model, Some(bulk_modulus));
        scene.supports = vec![
            support("x0", [Some(0.0), None, None]),
            support("y0", [None, Some(0.0), None]),
        ];
        scene.obstacles = vec![
            obstacle("lid", "y1", lid.clone()),
            obstacle("wall", "x1", wall.clone()),
        ];
        let report = solve_one(
            &scene,
            &push("lid", [0.0, -0.5, 0.0]),
            &mesh(unit_grid(6, 6)),
        );
        assert_eq!(report.cut_backs, 0);
        assert!(report.preconditioner_applications <= 60);
        // Homogeneous, J = 1/2: mu J^(-5/3) dev(b) + K (J - 1).
        let (height, stretched) = (0.5_f64, 0.5_f64.powf(-5.0 / 3.0) * 0.75 / 3.0);
        let lid = -0.5 * bulk_modulus - 2.0 * stretched;
        let wall = height * (-0.5 * bulk_modulus + stretched);
        let forces = ["lid", "wall"].map(|name| report.obstacles[name].force);
        assert!(close(forces[0][1], lid, 1e-7), "{forces:?}");
        assert!(close(forces[1][0], wall, 1e-7), "{forces:?}");
    }
}

#[test]
fn a_body_that_starts_a_quarter_inside_its_lid_is_pressed_as_by_a_lid_that_comes() {
    let lid = |height: f64| Shape::HalfSpace {
        point: [0.0, height, 0.0],
        normal: [0.0, -1.0, 0.0],
    };
    for bulk_modulus in [Some(10.0), Some(1e3), None] {
        let model = RubberModel::NeoHookean { shear_modulus: 1.0 };
        let mut scene = rubber(model, bulk_modulus);
        scene.supports = vec![support("y0", [Some(0.0), Some(0.0), None])];
        scene.obstacles = vec![obstacle("lid", "y1", lid(0.75))];
        let mesh = mesh(unit_grid(10, 10));
        let inside = solve_one(&scene, &Step::default(), &mesh);
        scene.obstacles = vec![obstacle("lid", "y1", lid(1.0))];
        let step = Step {
            increments: 8,
            ..push("lid", [0.0, -0.25, 0.0])
        };
        let led = solve(&scene, &[step], &mesh);
        let led = led.last().expect("a result");
        assert_eq!((inside.cut_backs, led.cut_backs), (0, 0));
        assert!(inside.preconditioner_applications <= 120);
        let [force, exact] = [&inside, led].map(|report| only_force(report)[1]);
        assert!(close(force, exact, 1e-6), "{force} {exact}");
    }
}

#[test]
fn a_confined_block_has_the_exact_force() {
    // Homogeneous, from ../cases/trust of the reference set: K = 100 mu, five per cent.
    let [pressed, _] = lids(100.0, 0.05, &mesh(cube(4)));
    assert!(close(only_force(&pressed)[2], -5.070_801_21, 1e-7));
    assert!(close(pressed.strain_energy, 0.126_734_515_35, 1e-7));
}

#[test]
fn five_clamped_faces_and_a_lid_converge_at_every_compressibility() {
    let mut counts = Vec::new();
    for poisson_ratio in [0.45, 0.49, 0.498, 0.4999, 0.499999] {
        let mut scene = elastic(poisson_ratio);
        scene.supports = ["x0", "x1", "y0", "y1", "z0"]
            .map(|side| support(side, HELD))
            .into();
        scene.obstacles = vec![press("z1")];
        let step = push("press", [0.0, 0.0, -1e-3]);
        let report = solve_one(&scene, &step, &mesh(cube(4)));
        counts.push(report.preconditioner_applications);
    }
    assert!(counts.iter().all(|&count| count <= 70), "{counts:?}");
}

/// A square on rollers under a plane; `walls` are planes beside it.
fn pressed_square(walls: &[(&str, f64)]) -> Scene {
    let mut scene = elastic(0.3);
    scene.supports = vec![
        support("x0", [Some(0.0), None, None]),
        support("y0", [None, Some(0.0), None]),
    ];
    let plane = |x: [f64; 3], normal| Shape::HalfSpace { point: x, normal };
    let roof = plane([0.0, 0.92, 0.0], [0.0, -1.0, 0.0]);
    scene.obstacles = vec![obstacle("roof", "y1", roof)];
    for &(name, at) in walls {
        let wall = plane([at, 0.0, 0.0], [-1.0, 0.0, 0.0]);
        scene.obstacles.push(obstacle(name, "x1", wall));
    }
    scene
}

/// E / (1 - nu^2) of shear modulus one.
const PLANE_MODULUS: f64 = 2.6 / 0.91;

#[test]
fn a_second_plane_at_a_corner_that_is_never_touched_changes_nothing() {
    let scene = pressed_square(&[("far", 9.0)]);
    let report = solve_one(&scene, &Step::default(), &mesh(square(4)));
    let force = report.obstacles["roof"].force[1];
    assert!(close(force, -0.08 * PLANE_MODULUS, 1e-7), "{force}");
    assert!(
        report.obstacles["far"]
            .force
            .iter()
            .all(|f| f.abs() < 1e-14)
    );
    assert!(close(
        report.strain_energy,
        0.08_f64.powi(2) / 2.0 * PLANE_MODULUS,
        1e-7
    ));
}

#[test]
fn one_obstacle_around_a_corner_presses_both_sides_as_two_do() {
    // A wedge of two planes would be two obstacles; a far wall that is one surface with
    // the roof has multipliers of its own on its side of the corner.
    let mut together = pressed_square(&[]);
    together.obstacles[0].on = vec!["y1".to_owned(), "x1".to_owned()];
    let report = solve_one(&together, &Step::default(), &mesh(square(4)));
    let force = report.obstacles["roof"].force[1];
    assert!(close(force, -0.08 * PLANE_MODULUS, 1e-7), "{force}");
}

/// The halves of the top of a square as groups of their own.
fn halved() -> Arc<Mesh> {
    let mut parts = square(4);
    let middle = |facet: &u32| {
        let ends = &parts.facets[*facet as usize * 2..*facet as usize * 2 + 2];
        ends.iter()
            .map(|&v| parts.coordinates[v as usize][0])
            .sum::<f64>()
    };
    let top = parts.groups.iter().find(|group| group.name == "y1");
    let top = top.expect("the top").clone();
    let (left, right): (Vec<u32>, Vec<u32>) = top.members.iter().partition(|f| middle(f) < 1.0);
    for (name, members) in [("left", left), ("right", right)] {
        let group = signorini::Group {
            name: name.to_owned(),
            members,
            ..top.clone()
        };
        parts.groups.push(group);
    }
    mesh(parts)
}

#[test]
fn two_obstacles_on_halves_of_a_face_press_as_one() {
    let plane = Shape::HalfSpace {
        point: [0.0, 0.92, 0.0],
        normal: [0.0, -1.0, 0.0],
    };
    let mut scene = elastic(0.4999);
    scene.supports = vec![support("y0", HELD)];
    scene.obstacles = vec![obstacle("whole", "y1", plane.clone())];
    let body = halved();
    let one = solve_one(&scene, &Step::default(), &body);
    scene.obstacles = vec![
        obstacle("left", "left", plane.clone()),
        obstacle("right", "right", plane),
    ];
    let two = solve_one(&scene, &Step::default(), &body);
    assert_eq!(one.unknowns.contact, two.unknowns.contact);
    assert!(close(two.strain_energy, one.strain_energy, 1e-10));
    let force = two.obstacles["left"].force[1] + two.obstacles["right"].force[1];
    assert!(close(force, only_force(&one)[1], 1e-9));
    let [left, right] = ["left", "right"].map(|side| two.obstacles[side].contact_area);
    assert!((left + right - 1.0).abs() < 1e-12, "{left} {right}");
}

#[test]
fn the_linear_space_stays_when_asked_for() {
    let (mut scene, step) = hertz_sphere(0.5);
    scene.solver.contact_space = Choice::Named(ContactSpace::Linear);
    let report = solve_one(&scene, &step, &file("indent_l1"));
    assert_eq!(report.unknowns.contact, 48);
    let force = 4.0 * only_force(&report)[2].abs();
    let all: Value =
        serde_json::from_str(include_str!("../reference/references.json")).expect("valid JSON");
    let exact = number(
        &all["hertz-sphere"]["meshes"]["indent_l1"]["steps"][0],
        "force",
    );
    assert!(close(force, exact, 1e-9), "{force} {exact}");
}
