//! Tools that come far, or turn about a far point, are felt as those that start at the body.

use crate::common::meshes::{cube, file, mesh};
use crate::common::scenes::{HELD, elastic, hertz_sphere, obstacle, push, rubber, support, travel};
use crate::common::{close, solve, solve_one};
use signorini::scene::{RubberModel, Shape};
use signorini::{Scene, Termination};

/// The quarter block of that scene under a small ball that ends so deep below its surface.
fn needle((scene, depth): (&Scene, f64), height: f64) -> f64 {
    let radius = 0.1;
    let (block, _) = hertz_sphere(0.5);
    let shape = Shape::Sphere {
        centre: [0.0, 0.0, height + radius],
        radius,
    };
    let scene = Scene {
        supports: block.supports,
        obstacles: vec![obstacle("ball", "z1", shape)],
        ..scene.clone()
    };
    let step = push("ball", [0.0, 0.0, -height - depth]);
    solve_one(&scene, &step, &file("indent_l1")).obstacles["ball"].force[2]
}

#[test]
fn a_small_ball_presses_alike_from_wherever_it_comes() {
    let law = RubberModel::NeoHookean { shear_modulus: 1.0 };
    for (scene, depth) in [(elastic(0.3), 0.16), (rubber(law, None), 0.06)] {
        let near = needle((&scene, depth), 0.0);
        assert!(near < 0.0, "{near}");
        for height in [20.0, 50.0, 200.0, 1e5] {
            let far = needle((&scene, depth), height);
            assert!(close(far, near, 1e-6), "{height} {far} {near}");
        }
    }
}

/// A bar along y that turns about a point far behind the block, sideways over it and 0.05 deep,
/// and back into the air.
#[test]
fn a_bar_that_turns_over_the_body_within_an_increment_is_named() {
    let mut scene = elastic(0.3);
    scene.supports = vec![support("z0", HELD)];
    let shape = Shape::Cylinder {
        point: [2.0, 8.0, 1.05],
        axis: [0.0, 1.0, 0.0],
        radius: 0.1,
    };
    scene.obstacles = vec![obstacle("bar", "z1", shape)];
    let step = travel("bar", 1, [0.0; 3], [0.0, 0.0, -0.5]);
    let report = solve_one(&scene, &step, &mesh(cube(4)));
    let named: Vec<&str> = report
        .warnings
        .iter()
        .map(|warning| warning.kind.name())
        .collect();
    assert_eq!(named, ["passed_through"]);
}

#[test]
fn an_increment_in_the_air_ends_where_its_time_is_up() {
    let (mut scene, _) = hertz_sphere(0.5);
    scene.solver.max_wall_time = Some(1e-9);
    let step = push("ball", [0.0, 0.0, 1e5]);
    let reports = solve(&scene, &[step], &file("indent_l1"));
    assert_eq!(reports[0].termination, Termination::DeadlineExceeded);
}
