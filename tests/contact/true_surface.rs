//! Contact sees the surface that the edges of a second-order mesh describe, or the one that
//! the normals of the facets stand for, not the polygon of the facets.

use std::f64::consts::PI;
use std::sync::Arc;

use crate::common::curved::quarter_ring;
use crate::common::meshes::{file_parts, mesh};
use crate::common::rounded::{quarter_disc, round, together, whole_ring};
use crate::common::scenes::{
    elastic, hertz_plane, mooney_rivlin, obstacle, push, rubber, squeezed_cube, support, turned,
};
use crate::common::{assert_converged, close, solve, solve_one};
use signorini::scene::{Choice, ContactSpace, Shape, SurfaceGeometry};
use signorini::{EdgeOffset, Mesh, MeshParts, Scene, Step, StepReport};

fn second_order(parts: MeshParts, offsets: Vec<EdgeOffset>) -> Arc<Mesh> {
    Arc::new(Mesh::second_order(parts, offsets).expect("a valid mesh"))
}

/// The same scene on arcs fitted to the normals.
fn smooth(mut scene: Scene) -> Scene {
    scene.obstacles[0].surface = SurfaceGeometry::Smooth;
    scene
}

/// With multipliers at the vertices only.
fn linear(mut scene: Scene) -> Scene {
    scene.solver.contact_space = Choice::Named(ContactSpace::Linear);
    scene
}

fn shaft(radius: f64) -> Shape {
    Shape::Cylinder {
        point: [0.0; 3],
        axis: [0.0, 0.0, 1.0],
        radius,
    }
}

fn symmetric() -> Scene {
    let mut scene = elastic(0.5);
    scene.supports = vec![
        support("x0", [Some(0.0), None, None]),
        support("y0", [None, Some(0.0), None]),
    ];
    scene
}

/// A ring of radii 1 and 2 shrunk onto a shaft that is larger by `interference`.
fn shrink_fit(interference: f64) -> Scene {
    let mut scene = symmetric();
    scene.obstacles = vec![obstacle("shaft", "inner", shaft(1.0 + interference))];
    scene
}

/// A quarter of the ring with that many facets a circle.
fn ring(facets: usize) -> [Arc<Mesh>; 2] {
    let parts = quarter_ring(facets / 4, facets / 8);
    let circles = together(round(&parts, 1.0, 2), round(&parts, 2.0, 2));
    [mesh(parts.clone()), second_order(parts, circles)]
}

/// Error of the mean pressure against 2 mu delta / a (1 - a^2 / b^2), and what the facets
/// say of it.
fn pressure_error(scene: &Scene, mesh: &Arc<Mesh>, interference: f64) -> (f64, Option<f64>) {
    let report = solve_one(scene, &Step::default(), mesh);
    let found = &report.obstacles["shaft"];
    let mean = 0.5 * (found.force[0] + found.force[1]);
    let error = (mean / (1.5 * interference) - 1.0).abs();
    (error, found.geometry_error)
}

#[test]
fn a_ring_on_a_shaft_bears_the_exact_pressure_to_order_four() {
    for interference in [0.05, 0.005] {
        let scene = shrink_fit(interference);
        let errors = [32, 64].map(|facets| {
            let [_, round] = ring(facets);
            let (error, geometry) = pressure_error(&scene, &round, interference);
            assert_eq!(geometry, None);
            error
        });
        assert!(
            errors[0] < 6e-4 && errors[1] < errors[0] / 12.0,
            "{errors:?}"
        );
        let [_, round] = ring(32);
        let (error, _) = pressure_error(&linear(scene), &round, interference);
        assert!(error < 6e-4, "hats: {error}");
    }
}

/// u = A / r stores 3 pi mu A^2 / 8 in a quarter of the ring; straight cells miss it by order two.
#[test]
fn a_ring_of_second_order_stores_the_exact_energy_to_order_four() {
    let energy = |mesh: &Arc<Mesh>| {
        let report = solve_one(&shrink_fit(0.05), &Step::default(), mesh);
        report.strain_energy / (0.375 * PI * 0.05 * 0.05) - 1.0
    };
    let [coarse, fine] = [32, 64].map(|facets| {
        let [straight, round] = ring(facets);
        assert!(energy(&straight).abs() > 30.0 * energy(&round).abs());
        energy(&round).abs()
    });
    assert!(coarse < 1e-3 && fine < coarse / 12.0, "{coarse} {fine}");
}

#[test]
fn arcs_fitted_to_the_normals_bear_the_same_pressure() {
    for interference in [0.05, 0.005] {
        let [straight, _] = ring(32);
        let scene = smooth(shrink_fit(interference));
        let (error, geometry) = pressure_error(&scene, &straight, interference);
        // The outer side stays a polygon, 0.6 % smaller than its circle.
        assert!(error < 2.5e-3 && geometry.is_none(), "{error}");
    }
}

#[test]
fn the_error_of_facets_is_told() {
    for (interference, expected) in [(0.05, 0.074), (0.005, 0.75)] {
        let [straight, _] = ring(32);
        let scene = shrink_fit(interference);
        let (error, geometry) = pressure_error(&scene, &straight, interference);
        assert!(close(error, expected, 0.1), "{error}");
        let told = geometry.expect("facets of a circle");
        assert!(told > 0.5 * error && told < 2.0 * error, "{told} {error}");
    }
}

/// Force on half a disc that plates press by a twentieth of its radius from both sides, on
/// the straight mesh, that of second order and fitted arcs.
fn disc_forces(facets: usize) -> [f64; 3] {
    let plate = Shape::HalfSpace {
        point: [0.0, 1.0, 0.0],
        normal: [0.0, -1.0, 0.0],
    };
    let mut scene = symmetric();
    scene.obstacles = vec![obstacle("plate", "rim", plate)];
    let step = push("plate", [0.0, -0.05, 0.0]);
    let parts = quarter_disc(facets / 8);
    let circle = round(&parts, 1.0, 2);
    let (straight, round) = (mesh(parts.clone()), second_order(parts, circle));
    let force = |scene: &Scene, mesh| -solve_one(scene, &step, mesh).obstacles["plate"].force[1];
    [
        force(&scene, &straight),
        force(&scene, &round),
        force(&smooth(scene.clone()), &straight),
    ]
}

#[test]
fn a_disc_between_plates_needs_few_facets() {
    // Hertz: delta = f (2 ln (4 R / a) - 1), a^2 = 4 f R, F = 4 pi mu f, of a quarter half.
    let approach = |f: f64| f * (2.0 * (2.0 / f.sqrt()).ln() - 1.0) - 0.05;
    let (mut low, mut high) = (1e-3, 2e-2);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        match approach(middle) < 0.0 {
            true => low = middle,
            false => high = middle,
        }
    }
    let hertz = 2.0 * PI * low;
    let [_, reference, _] = disc_forces(256);
    assert!(close(reference, hertz, 0.01), "{reference} {hertz}");
    for (facets, least, most) in [(32, 0.08, 5e-3), (64, 0.02, 5e-3)] {
        let [straight, round, fitted] = disc_forces(facets);
        let error = |force: f64| (force / reference - 1.0).abs();
        assert!(error(straight) > least, "{straight}");
        assert!(
            error(round) < most && error(fitted) < most,
            "{round} {fitted}"
        );
    }
}

#[test]
fn a_ball_on_a_plane_gains_a_level_of_refinement() {
    let forces = |name: &str| {
        let (scene, step) = hertz_plane(0.5);
        let parts = file_parts(name);
        let sphere = round(&parts, 1.0, 3);
        let (straight, round) = (mesh(parts.clone()), second_order(parts, sphere));
        let force = |scene: &Scene, mesh| solve_one(scene, &step, mesh).obstacles["floor"].force[2];
        [
            force(&scene, &straight),
            force(&scene, &round),
            force(&smooth(scene.clone()), &straight),
        ]
    };
    let ([straight, round, fitted], [straight_fine, round_fine, _]) =
        (forces("hemi_l1"), forces("hemi_l2"));
    let error = |force: f64| (force / round_fine - 1.0).abs();
    assert!(error(straight) > 0.03 && error(straight_fine) > 8e-3);
    assert!(
        error(round) < 3e-3 && error(fitted) < 3e-3,
        "{round} {fitted}"
    );
}

/// A ring of rubber on a shaft, bonded outside to a sleeve that turns it by `angle`.
fn turned_ring(mesh: &Arc<Mesh>, angle: f64) -> StepReport {
    let mut scene = rubber(mooney_rivlin(), Some(10.0));
    scene.supports = vec![support("outer", [Some(0.0), Some(0.0), None])];
    scene.obstacles = vec![obstacle("shaft", "inner", shaft(1.02))];
    scene.solver.tolerance = 1e-12;
    let step = Step {
        supports: vec![turned("outer", [0.0, 0.0, angle], [0.0; 3])],
        increments: 3,
        ..Step::default()
    };
    let last = solve(&scene, &[step], mesh).pop().expect("an increment");
    assert_converged(&last);
    last
}

#[test]
fn the_surface_of_rubber_turns_with_it() {
    let parts = whole_ring(16, 3);
    let circles = together(round(&parts, 1.0, 2), round(&parts, 2.0, 2));
    let round = second_order(parts, circles);
    let rest = turned_ring(&round, 0.0);
    for angle in [0.3, 1.6] {
        let turned = turned_ring(&round, angle);
        assert!(
            close(turned.strain_energy, rest.strain_energy, 1e-10),
            "{angle}: {} {}",
            turned.strain_energy,
            rest.strain_energy
        );
        let pressures = [&turned, &rest].map(|report| report.obstacles["shaft"].max_pressure);
        assert!(close(pressures[0], pressures[1], 1e-6), "{pressures:?}");
    }
}

#[test]
fn flat_faces_are_not_touched() {
    let (scene, step) = squeezed_cube();
    let mesh = mesh(crate::common::meshes::cube(2));
    let run = |scene: &Scene| {
        let report = solve(scene, std::slice::from_ref(&step), &mesh).pop();
        let report = report.expect("an increment");
        let press = &report.obstacles["press"];
        assert_eq!(press.geometry_error, None);
        (
            press.force.map(f64::to_bits),
            report.strain_energy.to_bits(),
        )
    };
    assert_eq!(run(&scene), run(&smooth(scene.clone())));
}
