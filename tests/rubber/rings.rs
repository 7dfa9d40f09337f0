//! Bodies of revolution by their sections, per full turn: against closed forms of a
//! squeezed disc, against the same body in space, and in balance.

use std::f64::consts::PI;

use crate::common::curved::cylinder;
use crate::common::meshes::{half_space, irregular, mesh, moved, square};
use crate::common::scenes::{mooney_rivlin, obstacle, probe, push, rubber, support, traction};
use crate::common::{close, difference, run_one, solve_one, values};
use signorini::scene::{RubberModel, SceneKind, Shape};
use signorini::{FieldName, MeshParts, Scene, Step};

/// The section 0 < x < 1, 0 < y < 1 of a disc of radius and height one.
fn section(count: usize) -> MeshParts {
    irregular(square(count), count)
}

fn disc(model: RubberModel) -> Scene {
    let mut scene = rubber(model, None);
    scene.kind = Some(SceneKind::Axisymmetric);
    scene
}

/// A plate on top of a disc of height one along `axis`.
fn plate(on: &str, axis: usize) -> signorini::scene::Obstacle {
    let (mut point, mut normal) = ([0.0; 3], [0.0; 3]);
    (point[axis], normal[axis]) = (1.0, -1.0);
    obstacle("plate", on, Shape::HalfSpace { point, normal })
}

#[test]
fn an_evenly_squeezed_disc_has_its_closed_form() {
    let mut scene = disc(RubberModel::NeoHookean { shear_modulus: 1.0 });
    scene.supports = vec![support("y0", [None, Some(0.0), None])];
    scene.obstacles = vec![plate("y1", 1)];
    scene.probes = vec![probe("rim", [1.0, 0.5, 0.0])];
    // Pressure is known to some thirty times the tolerance.
    scene.solver.tolerance = 1e-10;
    let step = push("plate", [0.0, -0.2, 0.0]);
    let (session, report) = run_one(&scene, &step, &mesh(section(3)));
    // At stretch 0.8: 1 / l^2 - l per undeformed, 1 / l - l^2 per deformed area.
    let plate = &report.obstacles["plate"];
    assert!(close(plate.force[1], -0.7625 * PI, 1e-7), "{plate:?}");
    assert!(close(plate.contact_area, PI / 0.8, 1e-7), "{plate:?}");
    assert!(close(plate.max_pressure, 0.61, 1e-7), "{plate:?}");
    assert!(
        close(plate.deformed_contact_area, PI / 0.8, 1e-7),
        "{plate:?}"
    );
    assert!(close(plate.peak_pressure, 0.61, 1e-7), "{plate:?}");
    let mean = plate.mean_pressure.expect("contact");
    assert!(close(mean, 0.61, 1e-7), "{plate:?}");
    let width = plate.contact_width.expect("a section");
    assert!(close(width, 0.8_f64.powf(-0.5), 1e-7), "{plate:?}");
    let undeformed = plate.max_pressure_undeformed.expect("finite strain");
    assert!(close(undeformed, 0.7625, 1e-7), "{undeformed}");
    assert!(close(report.supports["y0"].force[1], 0.7625 * PI, 1e-7));
    assert!(close(report.strain_energy, 0.07 * PI, 1e-7));
    assert!(close(report.volume_ratio, 1.0, 1e-9));
    let rim = report.probes["rim"].displacement;
    assert!(close(rim[0], 0.8_f64.powf(-0.5) - 1.0, 1e-7), "{rim:?}");
    for stress in values(&session, FieldName::Stress).chunks_exact(6) {
        assert!(difference(stress, &[0.0, -0.61, 0.0, 0.0, 0.0, 0.0]) < 1e-6);
    }
    for ratio in values(&session, FieldName::Jacobian) {
        assert!((ratio - 1.0).abs() < 1e-7, "{ratio}");
    }
    let least = report.min_jacobian.expect("finite strain");
    let bound = report.min_jacobian_bound.expect("finite strain");
    assert!((least - 1.0).abs() < 1e-7 && (bound - 1.0).abs() < 1e-7);
}

#[test]
fn a_bonded_disc_is_that_in_space() {
    let mut scene = disc(mooney_rivlin());
    scene.supports = vec![support("y0", [Some(0.0), Some(0.0), None])];
    scene.obstacles = vec![plate("y1", 1)];
    let step = push("plate", [0.0, -0.15, 0.0]);
    let section = solve_one(&scene, &step, &mesh(section(8)));
    let mut scene = rubber(mooney_rivlin(), None);
    scene.supports = vec![support("z0", [Some(0.0); 3])];
    scene.obstacles = vec![plate("z1", 2)];
    let step = push("plate", [0.0, 0.0, -0.15]);
    let body = solve_one(&scene, &step, &mesh(cylinder(6, 5, 1.0)));
    // The circle has 36 sides: 0.5 % of its area.
    let forces = [
        section.obstacles["plate"].force[1],
        body.obstacles["plate"].force[2],
    ];
    assert!(close(forces[0], forces[1], 0.02), "{forces:?}");
    let energies = [section.strain_energy, body.strain_energy];
    assert!(close(energies[0], energies[1], 0.02), "{energies:?}");
}

#[test]
fn loads_are_those_of_full_turns() {
    let mut scene = disc(mooney_rivlin());
    scene.supports = vec![support("y0", [Some(0.0), Some(0.0), None])];
    scene.body_force = [0.0, -0.02, 0.0];
    scene.tractions = vec![
        traction("y1", [0.0, 0.03, 0.0]),
        traction("x1", [0.0, 0.01, 0.0]),
    ];
    let report = solve_one(&scene, &Step::default(), &mesh(section(4)));
    // Volume pi, top pi, side 2 pi.
    let load = PI * (-0.02 + 0.03 + 2.0 * 0.01);
    let held = report.supports["y0"].force[1];
    assert!(close(held, -load, 1e-7), "{held} {load}");
}

#[test]
fn a_ball_pressed_into_a_ring_balances_its_support() {
    let yeoh = RubberModel::Yeoh {
        c10: 0.5,
        c20: 0.02,
        c30: 0.01,
    };
    let mut scene = rubber(yeoh, Some(50.0));
    scene.kind = Some(SceneKind::Axisymmetric);
    scene.supports = vec![support("y0", [Some(0.0), Some(0.0), None])];
    let ball = Shape::Sphere {
        centre: [0.0, 1.5, 0.0],
        radius: 0.5,
    };
    scene.obstacles = vec![obstacle("ball", "y1", ball)];
    let step = push("ball", [0.0, -0.1, 0.0]);
    let whole = solve_one(&scene, &step, &mesh(section(6)));
    let (pushed, held) = (
        whole.obstacles["ball"].force[1],
        whole.supports["y0"].force[1],
    );
    assert!(
        pushed < -0.1 && close(held, -pushed, 1e-6),
        "{pushed} {held}"
    );
    // A wide bore leaves the ball nothing to touch.
    let bored = moved(section(6), |[x, y, z]| [0.6 + 0.4 * x, y, z]);
    let report = solve_one(&scene, &step, &mesh(bored));
    assert_eq!(report.active_vertices, 0);
}

/// Of a ball on what stands for the half-space, a^3 = 3 F R (1 - nu^2) / (4 E), of a strain of a
/// hundredth: ten facets across the radius.
#[test]
fn a_ball_on_the_axis_presses_on_the_circle_of_hertz() {
    let (radius, body) = (20.0, mesh(half_space(2, 24, 4.0, &[0])));
    let mut scene = disc(RubberModel::NeoHookean { shear_modulus: 1.0 });
    scene.supports = vec![support("y0", [Some(0.0), Some(0.0), None])];
    let centre = [0.0, radius, 0.0];
    scene.obstacles = vec![obstacle("ball", "y1", Shape::Sphere { centre, radius })];
    for depth in [5e-4, 6e-4, 7e-4] {
        let report = solve_one(&scene, &push("ball", [0.0, -depth, 0.0]), &body);
        let ball = &report.obstacles["ball"];
        let force = ball.force[1].abs();
        let exact = (3.0 * force * radius / 16.0).cbrt();
        let width = ball.contact_width.expect("a section");
        assert!(close(width, exact, 0.007), "{width} {exact}");
        let area = ball.deformed_contact_area;
        assert!(close(area, PI * width * width, 1e-3), "{area}");
        let [one] = ball.contact_intervals[..] else {
            panic!("one interval: {:?}", ball.contact_intervals);
        };
        assert!(
            one.end[0].abs() < 1e-12 && close(one.start[0], width, 1e-3),
            "{one:?}"
        );
        assert!(close(one.force[1], ball.force[1], 1e-12), "{one:?}");
        let peak = 1.5 * force / (PI * exact * exact);
        assert!(close(ball.peak_pressure, peak, 0.02), "{peak} {ball:?}");
    }
}
