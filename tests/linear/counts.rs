//! How many preconditioner applications the product promises.

use std::sync::Arc;

use crate::common::meshes::{cube, file, mesh, moved};
use crate::common::scenes::{
    HELD, cube_bend, elastic, hertz_plane, hertz_sphere, obstacle, push, quarter_ball,
    quarter_block, support, traction,
};
use crate::common::{assert_converged, solve_one};
use signorini::scene::Shape;
use signorini::{Mesh, Scene, Step, StepReport};

const TOLERANCE: f64 = 1e-8;

fn applications(scene: &Scene, mesh: &Arc<Mesh>) -> u32 {
    solve_one(scene, &Step::default(), mesh).preconditioner_applications
}

#[test]
fn the_saddle_point_takes_at_most_24_applications_on_every_mesh() {
    for count in [4, 6, 8, 10] {
        let taken = applications(&cube_bend(0.5), &mesh(cube(count)));
        assert!(taken <= 24, "cube_n{count}: {taken}");
    }
}

#[test]
fn no_mixed_poisson_ratio_takes_4_more_than_one_half() {
    let mesh = mesh(cube(6));
    let incompressible = applications(&cube_bend(0.5), &mesh);
    for distance in [0.05, 0.04, 0.02, 1e-2, 1e-3, 1e-4, 1e-6, 1e-9, 1e-12] {
        let taken = applications(&cube_bend(0.5 - distance), &mesh);
        assert!(
            taken <= 30 && taken <= incompressible + 4,
            "{distance:e}: {taken}"
        );
    }
}

#[test]
fn conjugate_gradients_take_at_most_20_below_the_mixed_range() {
    let mesh = mesh(cube(6));
    for poisson_ratio in [-0.9, -0.5, 0.0, 0.2, 0.3, 0.4, 0.44, 0.449] {
        let taken = applications(&cube_bend(poisson_ratio), &mesh);
        assert!(taken <= 20, "{poisson_ratio}: {taken}");
    }
}

fn contact((mut scene, step): (Scene, Step), mesh: &Arc<Mesh>) -> StepReport {
    scene.solver.tolerance = TOLERANCE;
    let report = solve_one(&scene, &step, mesh);
    assert!(
        report.active_set_changes <= 3 * report.sqp_iterations,
        "{report:?}"
    );
    report
}

#[test]
fn a_flat_obstacle_costs_at_most_1_3_times_a_traction() {
    for name in ["hemi_l1", "hemi_l2"] {
        let mesh = file(name);
        let mut scene = quarter_ball(0.5);
        scene.tractions = vec![traction("contact", [0.0, 0.0, 0.01])];
        let bound = 1.3 * f64::from(applications(&scene, &mesh));
        let report = contact(hertz_plane(0.5), &mesh);
        let taken = report.preconditioner_applications;
        assert!(f64::from(taken) <= bound, "{name}: {taken} {bound}");
        assert_eq!(report.sqp_iterations, 1);
    }
}

#[test]
fn a_curved_obstacle_costs_at_most_twice_a_traction() {
    for name in ["indent_l1", "indent_l2"] {
        let mesh = file(name);
        let mut scene = quarter_block(0.5);
        scene.tractions = vec![traction("z1", [0.0, 0.0, -0.01])];
        let bound = 2 * applications(&scene, &mesh);
        let taken = contact(hertz_sphere(0.5), &mesh).preconditioner_applications;
        assert!(taken <= bound, "{name}: {taken} {bound}");
    }
}

/// A bonded layer of 6^3 flat cells under a ball that comes in by a fifth of its thickness.
fn pressed_layer(aspect: f64, poisson_ratio: f64) -> StepReport {
    let mut scene = elastic(poisson_ratio);
    scene.solver.tolerance = TOLERANCE;
    scene.supports = vec![support("z0", HELD)];
    let thickness = 1.0 / aspect;
    let ball = Shape::Sphere {
        centre: [0.5, 0.5, 5.0 + thickness],
        radius: 5.0,
    };
    scene.obstacles = vec![obstacle("ball", "z1", ball)];
    let flat = moved(cube(6), |[x, y, z]| [x, y, thickness * z]);
    solve_one(
        &scene,
        &push("ball", [0.0, 0.0, -0.2 * thickness]),
        &mesh(flat),
    )
}

/// A layer of n^3 cells of that aspect, bonded below, under a flat lid.
fn layer_under_a_lid(n: usize, aspect: f64, poisson_ratio: f64) -> StepReport {
    let mut scene = elastic(poisson_ratio);
    scene.solver.tolerance = TOLERANCE;
    scene.supports = vec![support("z0", HELD)];
    let lid = Shape::HalfSpace {
        point: [0.0, 0.0, 1.0],
        normal: [0.0, 0.0, -1.0],
    };
    scene.obstacles = vec![obstacle("lid", "z1", lid)];
    let layer = moved(cube(n), |[x, y, z]| [aspect * x, aspect * y, z]);
    solve_one(&scene, &push("lid", [0.0, 0.0, -0.02]), &mesh(layer))
}

/// By nodes alone 650 applications and a fallback from 2.5 to 4.
#[test]
fn cells_of_any_aspect_under_a_lid_take_few_applications() {
    for (poisson_ratio, most) in [(0.3, 40), (0.5, 60)] {
        for aspect in [1.0, 1.5, 2.0, 2.2, 2.5, 3.0, 4.0, 6.0] {
            let taken = layer_under_a_lid(5, aspect, poisson_ratio).preconditioner_applications;
            assert!(taken <= most, "{aspect}, {poisson_ratio}: {taken}");
        }
    }
}

/// Steps of contact go too far by a metric below half the compliance: 650 applications and a
/// fallback by 0.7 of its parts, 22 by 1, 20 by 1.4.
#[test]
fn tall_cells_under_a_lid_take_few_applications() {
    for (aspect, poisson_ratio, most) in [(0.2, 0.3, 28), (0.2, 0.5, 40), (0.5, 0.3, 32)] {
        let report = layer_under_a_lid(12, aspect, poisson_ratio);
        assert_converged(&report);
        let taken = report.preconditioner_applications;
        assert!(taken <= most, "{aspect}, {poisson_ratio}: {taken}");
    }
}

/// Lines of the corners and edges that are coupled are one group, which is not left out: 650
/// applications and a fallback where it was.
#[test]
fn coupled_lines_at_the_edges_of_a_layer_take_few_applications() {
    for aspect in [2.5, 20.0] {
        let report = layer_under_a_lid(12, aspect, 0.3);
        assert_converged(&report);
        let taken = report.preconditioner_applications;
        assert!(taken <= 40, "{aspect}: {taken}");
    }
}

#[test]
fn thin_bonded_layers_take_few_applications_and_no_second_attempt() {
    for (poisson_ratio, most) in [(0.3, 20), (0.5, 60)] {
        for aspect in [5.0, 10.0, 20.0, 30.0, 50.0, 100.0] {
            let report = pressed_layer(aspect, poisson_ratio);
            assert_converged(&report);
            let taken = report.preconditioner_applications;
            assert!(taken <= most, "{aspect}, {poisson_ratio}: {taken}");
        }
    }
}
