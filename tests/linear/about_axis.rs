//! Linear bodies of revolution by their sections, per full turn: against Lame, Hertz and Poiseuille.

use std::f64::consts::PI;

use crate::common::meshes::{irregular, mesh, moved, square, unit_grid};
use crate::common::scenes::{elastic, obstacle, probe, pull, push, support, traction};
use crate::common::{assert_converged, close, open, run_one, solve_one, take, values};
use signorini::scene::{Formulation, Material, MaterialModel, SceneKind, Shape};
use signorini::{FieldName, Scene, Step};

/// A body of revolution of shear modulus one.
fn turned(poisson_ratio: f64) -> Scene {
    let mut scene = elastic(poisson_ratio);
    scene.kind = Some(SceneKind::Axisymmetric);
    scene
}

#[test]
fn a_pulled_rod_is_as_stiff_as_youngs_modulus_and_thins() {
    for ratio in [-0.3, 0.0, 0.3, 0.4999, 0.5] {
        let mut scene = turned(ratio);
        scene.supports = vec![
            support("y0", [None, Some(0.0), None]),
            support("y1", [None, Some(0.0), None]),
        ];
        scene.probes = vec![probe("rim", [1.0, 0.5, 0.0])];
        scene.solver.tolerance = 1e-10;
        scene.solver.verify = true;
        let mut session = open(&scene, &mesh(irregular(square(4), 4)));
        let report = take(&mut session, &pull("y1", [None, Some(1e-3), None], 1)).remove(0);
        assert_converged(&report);
        let young = 2.0 * (1.0 + ratio);
        let force = report.supports["y1"].force[1];
        assert!(close(force, 1e-3 * young * PI, 1e-8), "{ratio} {force}");
        let rim = report.probes["rim"].displacement[0];
        assert!((rim + 1e-3 * ratio).abs() < 1e-11, "{ratio} {rim}");
        let energy = 0.5e-6 * young * PI;
        assert!(close(report.strain_energy, energy, 1e-7), "{ratio}");
        let volume = 1.0 + 1e-3 * (1.0 - 2.0 * ratio);
        assert!((report.volume_ratio - volume).abs() < 1e-9, "{ratio}");
        let stress = values(&session, FieldName::Stress);
        let [across, along, around] = [stress[0], stress[1], stress[2]];
        assert!(close(along, 1e-3 * young, 1e-6), "{ratio} {stress:?}");
        assert!(across.abs() < 1e-9 && around.abs() < 1e-9, "{ratio}");
    }
}

/// Lame: u = (1 + nu) / E p a^2 / (b^2 - a^2) ((1 - 2 nu) r + b^2 / r) in plane strain.
#[test]
fn a_thick_tube_opens_as_lame_has_it() {
    for ratio in [0.3, 0.45, 0.5] {
        let mut scene = turned(ratio);
        let along = |on| support(on, [None, Some(0.0), None]);
        scene.supports = vec![along("y0"), along("y1")];
        scene.tractions = vec![traction("x0", [0.01, 0.0, 0.0])];
        scene.probes = vec![
            probe("bore", [1.0, 0.5, 0.0]),
            probe("rim", [2.0, 0.5, 0.0]),
        ];
        let tube = moved(unit_grid(24, 4), |[x, y, z]| [1.0 + x, y, z]);
        let report = solve_one(&scene, &Step::default(), &mesh(tube));
        let expected = |r: f64| 0.5 * 0.01 / 3.0 * ((1.0 - 2.0 * ratio) * r + 4.0 / r);
        for (name, r) in [("bore", 1.0), ("rim", 2.0)] {
            let moved = report.probes[name].displacement[0];
            assert!(close(moved, expected(r), 3e-5), "{ratio} {name} {moved}");
        }
    }
}

/// Hertz: p0^3 = 6 F E*^2 / (pi^3 R^2), E* = 2 / (1 - nu) for a shear modulus of one.
#[test]
fn a_ball_on_a_block_has_the_pressure_of_hertz() {
    for ratio in [0.3, 0.5] {
        let mut scene = turned(ratio);
        scene.supports = vec![support("y0", [Some(0.0), Some(0.0), None])];
        let (centre, radius) = ([0.0, 1.0, 0.0], 1.0);
        scene.obstacles = vec![obstacle("ball", "y1", Shape::Sphere { centre, radius })];
        // Finest where the ball touches.
        let graded = moved(unit_grid(100, 40), |[x, y, z]| {
            let down = 1.0 - y;
            [2.0 * x * x, -2.0 * down * down, z]
        });
        let report = solve_one(&scene, &push("ball", [0.0, -0.01, 0.0]), &mesh(graded));
        assert_converged(&report);
        let ball = &report.obstacles["ball"];
        let modulus = 2.0 / (1.0 - ratio);
        let cube = 6.0 * -ball.force[1] * modulus * modulus / PI.powi(3);
        assert!(close(ball.max_pressure, cube.cbrt(), 1e-2), "{ball:?}");
        // Its rim moves inwards by (1 - 2 nu) (1 + nu) / (3 E) p0 of its radius.
        let inwards = (1.0 - 2.0 * ratio) / 6.0 * ball.max_pressure;
        let radius = (0.75 * -ball.force[1] / modulus).cbrt() * (1.0 - inwards);
        let width = ball.contact_width.expect("a section");
        assert!(close(width, radius, 5e-3), "{ratio} {width} {radius}");
        let below = &report.supports["y0"];
        assert!((below.force[1] + ball.force[1]).abs() < 1e-8, "{below:?}");
    }
}

/// Poiseuille: a flow of viscosity one that a body force of one drives through a pipe of radius one
/// is (1 - r^2) / 4 along it.
#[test]
fn a_flow_through_a_pipe_is_poiseuilles() {
    let mut scene = Scene {
        kind: Some(SceneKind::Axisymmetric),
        body_force: [0.0, 1.0, 0.0],
        supports: vec![
            support("x1", [Some(0.0), Some(0.0), None]),
            support("y0", [Some(0.0), None, None]),
            support("y1", [Some(0.0), None, None]),
        ],
        probes: vec![probe("middle", [0.0, 0.5, 0.0])],
        materials: vec![Material {
            group: "body".to_owned(),
            model: MaterialModel::Stokes {
                viscosity: 1.0,
                formulation: Formulation::Auto,
            },
        }],
        ..Scene::default()
    };
    scene.solver.tolerance = 1e-10;
    let (_, report) = run_one(&scene, &Step::default(), &mesh(irregular(square(4), 4)));
    let fastest = report.probes["middle"].displacement[1];
    assert!(close(fastest, 0.25, 1e-8), "{fastest}");
    let wall = report.supports["x1"].force[1];
    assert!(close(wall, -PI, 1e-8), "{wall}");
}
