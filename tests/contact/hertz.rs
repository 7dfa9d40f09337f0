//! How far contact extends and where it presses most: against Hertz, on surfaces of five to ten
//! facets across half the contact, of two crests, and where contact fills the surface; the pressure
//! along the surface.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use crate::common::meshes::{cube, half_space, irregular, mesh, moved, square, unit_grid};
use crate::common::scenes::{
    HELD, bonded_cube, elastic, obstacle, plane, push, rollers, rubber, support,
};
use crate::common::{close, run, run_one, solve_one};
use signorini::report::ObstacleResult;
use signorini::scene::{Choice, ContactSpace, RubberModel, SceneKind, Shape};
use signorini::{FieldName, Mesh, Scene, Session};

/// Young's modulus of bodies of shear modulus one, over 1 - nu^2.
fn modulus(poisson_ratio: f64) -> f64 {
    2.0 / (1.0 - poisson_ratio)
}

/// What stands for a half-space of depth one under a round tool that touches it at the origin.
fn indented(dimension: usize, poisson_ratio: f64, radius: f64) -> Scene {
    let mut scene = elastic(poisson_ratio);
    let (shape, supports, on) = match dimension {
        2 => {
            let shape = Shape::Cylinder {
                point: [0.0, radius, 0.0],
                axis: [0.0, 0.0, 1.0],
                radius,
            };
            let held = [Some(0.0), Some(0.0), None];
            (shape, vec![support("y0", held)], "y1")
        }
        _ => {
            let centre = [0.0, 0.0, radius];
            let mut supports = rollers();
            supports[2] = support("z0", HELD);
            (Shape::Sphere { centre, radius }, supports, "z1")
        }
    };
    scene.supports = supports;
    scene.obstacles = vec![obstacle("tool", on, shape)];
    scene
}

/// What the tool does when it has gone so far down along the last axis.
fn pressed(scene: &Scene, depth: f64, mesh: &Arc<Mesh>) -> ObstacleResult {
    let mut way = [0.0; 3];
    let is_solid = scene.obstacles[0].on[0] == "z1";
    way[if is_solid { 2 } else { 1 }] = -depth;
    let report = solve_one(scene, &push("tool", way), mesh);
    report.obstacles["tool"].clone()
}

/// a = sqrt(4 F R / (pi E*)), p0 = 2 F / (pi a) under a cylinder: the width within `bound`, each
/// end within twice that, since diagonals of cells lean to one side, the peak within 3e-3.
fn check_cylinder(scene: &Scene, ratio: f64, (depth, bound): (f64, f64), body: &Arc<Mesh>) {
    let tool = pressed(scene, depth, body);
    let force = tool.force[1].abs();
    let half = (4.0 * force / (PI * modulus(ratio))).sqrt();
    let width = tool.contact_width.expect("in the plane");
    assert!(close(width, 2.0 * half, bound), "{width} {half}");
    assert!(close(tool.deformed_contact_area, width, 1e-12));
    let [one] = tool.contact_intervals[..] else {
        panic!("one interval: {:?}", tool.contact_intervals);
    };
    // The body is below, so that its surface is followed from the right to the left.
    assert!(close(one.start[0], half, 2.0 * bound) && close(one.end[0], -half, 2.0 * bound));
    assert!(close(one.force[1], tool.force[1], 1e-12));
    let mean = tool.mean_pressure.expect("contact");
    assert!(close(mean, force / width, 1e-3), "{mean}");
    let place = tool.peak_pressure_place.expect("contact");
    assert!(close(tool.peak_pressure, 2.0 * force / (PI * half), 3e-3));
    assert!(tool.peak_pressure >= tool.max_pressure);
    assert!(place[0].abs() < 0.1 * half && close(place[1], -depth, 1e-2));
}

#[test]
fn a_cylinder_presses_on_the_width_of_hertz() {
    let body = mesh(half_space(2, 36, 5.0, &[]));
    for ratio in [0.3, 0.5] {
        let scene = indented(2, ratio, 1.0);
        for depth in [0.0007, 0.0008, 0.001, 0.0011] {
            check_cylinder(&scene, ratio, (depth, 0.006), &body);
        }
    }
    let mut hats = indented(2, 0.3, 1.0);
    hats.solver.contact_space = Choice::Named(ContactSpace::Linear);
    for depth in [0.0007, 0.001] {
        check_cylinder(&hats, 0.3, (depth, 0.01), &body);
    }
}

/// a^3 = 3 F R / (4 E*) on a quarter of the body, six facets across the radius; its vertices are
/// ten per cent off.
#[test]
fn a_ball_presses_on_the_circle_of_hertz() {
    let (radius, ratio) = (4.0, 0.3);
    let body = mesh(half_space(3, 12, 4.0, &[0, 1]));
    for depth in [0.003, 0.004] {
        let tool = pressed(&indented(3, ratio, radius), depth, &body);
        let force = 4.0 * tool.force[2].abs();
        let exact = (0.75 * force * radius / modulus(ratio)).cbrt();
        let found = (4.0 * tool.deformed_contact_area / PI).sqrt();
        assert!(close(found, exact, 0.01), "{found} {exact}");
        let peak = 3.0 * force / (TAU * exact * exact);
        assert!(close(tool.peak_pressure, peak, 0.05), "{peak}");
        assert_eq!(
            (tool.contact_width, &tool.contact_intervals[..]),
            (None, &[][..])
        );
    }
}

/// A plate that covers a block: linear bodies and their sides keep the area that they have moved to.
#[test]
fn contact_that_fills_a_surface_has_its_whole_deformed_area() {
    let mut scene = elastic(0.3);
    scene.supports = rollers();
    scene.obstacles = vec![obstacle(
        "tool",
        "z1",
        plane([0.0, 0.0, 1.0], [0.0, 0.0, -1.0]),
    )];
    let tool = pressed(&scene, 0.1, &mesh(irregular(cube(3), 3)));
    // Sides move out by the depth times the ratio.
    let (area, pressure) = (1.03 * 1.03, tool.force[2].abs());
    assert!(close(tool.deformed_contact_area, area, 1e-7), "{tool:?}");
    assert!(close(tool.contact_area, 1.0, 1e-12));
    assert!(close(tool.peak_pressure, pressure, 1e-6));
    let mean = tool.mean_pressure.expect("contact");
    assert!(close(mean, pressure / area, 1e-7), "{mean}");
}

#[test]
fn a_surface_of_two_crests_is_pressed_in_two_intervals() {
    // Crests at a quarter and three quarters of the top.
    let crests = |[x, y, z]: [f64; 3]| [x, y * (1.0 - 0.02 * (1.0 + (2.0 * TAU * x).cos())), z];
    let mut scene = elastic(0.5);
    scene.supports = vec![support("y0", [Some(0.0), Some(0.0), None])];
    let down = plane([0.0, 1.0, 0.0], [0.0, -1.0, 0.0]);
    scene.obstacles = vec![obstacle("tool", "y1", down)];
    let body = mesh(moved(unit_grid(40, 20), crests));
    let (session, report) = run_one(&scene, &push("tool", [0.0, -0.01, 0.0]), &body);
    let tool = report.obstacles["tool"].clone();
    let [right, left] = tool.contact_intervals[..] else {
        panic!("two intervals: {:?}", tool.contact_intervals);
    };
    assert!(close(left.width, right.width, 0.02), "{left:?} {right:?}");
    let width = tool.contact_width.expect("in the plane");
    assert!(close(width, left.width + right.width, 1e-14));
    for (interval, crest) in [(right, 0.75), (left, 0.25)] {
        let middle = 0.5 * (interval.start[0] + interval.end[0]);
        assert!((middle - crest).abs() < 0.02, "{interval:?}");
        assert!(interval.width > 0.05 && interval.start[0] > interval.end[0]);
    }
    let force = left.force[1] + right.force[1];
    assert!(close(force, tool.force[1], 1e-12), "{force}");
    let path = path(&session);
    assert!(path.is_sorted_by(|a, b| a[2] < b[2] && a[1] <= b[1]));
    for (number, interval) in [right, left].iter().enumerate() {
        let own: Vec<_> = path
            .iter()
            .filter(|row| (row[1] - number as f64).abs() < 0.5)
            .copied()
            .collect();
        let x = 0.5 * (own[0][4] + own[own.len() - 1][4]);
        let middle = 0.5 * (interval.start[0] + interval.end[0]);
        assert!((x - middle).abs() < 0.03, "{interval:?}");
        let force = integral(&own, |_| 1.0);
        assert!(close(force, -interval.force[1], 1e-9), "{force}");
    }
}

#[test]
fn a_tool_that_touches_nothing_has_no_extent() {
    let scene = indented(2, 0.5, 1.0);
    let body = mesh(half_space(2, 4, 2.0, &[]));
    let (session, report) = run_one(&scene, &push("tool", [0.0, 0.1, 0.0]), &body);
    assert!(path(&session).is_empty());
    let tool = &report.obstacles["tool"];
    assert_eq!(
        (tool.deformed_contact_area, tool.contact_width),
        (0.0, Some(0.0))
    );
    assert_eq!((tool.peak_pressure, tool.peak_pressure_place), (0.0, None));
    assert!(tool.contact_intervals.is_empty() && tool.mean_pressure.is_none());
    let (scene, step) = bonded_cube();
    let (session, reports) = run(&scene, &[step], &mesh(cube(2)));
    assert!(session.field(FieldName::ContactPath).is_none());
    let widths = reports.iter().flat_map(|report| report.obstacles.values());
    assert!(widths.clone().count() > 0 && widths.map(|one| one.contact_width).all(|w| w.is_none()));
}

/// Obstacle, interval, arc length, pressure and place of the points along the surface.
fn path(session: &Session) -> Vec<[f64; 6]> {
    let field = session.field(FieldName::ContactPath).expect("a section");
    assert_eq!(field.components, 6);
    field.values.as_chunks().0.to_vec()
}

/// int weight p ds by Simpson's rule over the faces of one interval, which have a point in common
/// each two.
fn integral(path: &[[f64; 6]], weight: impl Fn(&[f64; 6]) -> f64) -> f64 {
    let value = |row: &[f64; 6]| weight(row) * row[3];
    let faces = path.windows(3).step_by(2);
    let parts = faces.map(|face| {
        let sum = value(&face[0]) + 4.0 * value(&face[1]) + value(&face[2]);
        (face[2][2] - face[0][2]) / 6.0 * sum
    });
    parts.sum()
}

/// p = p0 sqrt(1 - x^2 / a^2) under a cylinder, from the force alone: within three hundredths of p0
/// but for the last facet at the edge.
#[test]
fn the_pressure_along_the_surface_is_the_half_ellipse_of_hertz() {
    let (ratio, depth, half_width) = (0.3, 0.001, 5.0);
    let body = mesh(half_space(2, 36, half_width, &[]));
    for space in [ContactSpace::Quadratic, ContactSpace::Linear] {
        let mut scene = indented(2, ratio, 1.0);
        scene.solver.contact_space = Choice::Named(space);
        let (session, report) = run_one(&scene, &push("tool", [0.0, -depth, 0.0]), &body);
        let tool = &report.obstacles["tool"];
        let half = (4.0 * tool.force[1].abs() / (PI * modulus(ratio))).sqrt();
        let peak = 2.0 * tool.force[1].abs() / (PI * half);
        let path = path(&session);
        assert!(path.len() > 20 && path.len() % 2 == 1, "{}", path.len());
        let facet = path[2][2] - path[0][2];
        for [_, interval, way, pressure, x, y] in path.iter().copied() {
            let exact = peak * (1.0 - (x / half).powi(2)).max(0.0).sqrt();
            let is_inside = x.abs() < half - facet;
            assert!(
                !is_inside || (pressure - exact).abs() < 0.03 * peak,
                "{x} {pressure} {exact}"
            );
            assert!(interval.abs() < 0.5, "{interval}");
            // The surface begins at its right end and has moved by little.
            let from_right = path[0][2] + path[0][4] - x;
            assert!((way - from_right).abs() < depth && y.abs() < 2.0 * depth);
        }
        let mean = tool.mean_pressure.expect("contact");
        let force = mean * tool.deformed_contact_area;
        assert!(close(integral(&path, |_| 1.0), force, 1e-12), "{force}");
        let largest = path.iter().map(|row| row[3]).fold(0.0, f64::max);
        assert!(close(largest, tool.max_pressure, 0.01));
    }
}

/// 1 / l - l^2 at the stretch l, over a radius of l^(-1/2): the force of the full turn.
#[test]
fn the_pressure_along_a_section_of_rubber_is_over_its_deformed_length() {
    let mut scene = rubber(RubberModel::NeoHookean { shear_modulus: 1.0 }, None);
    scene.kind = Some(SceneKind::Axisymmetric);
    scene.supports = vec![support("y0", [None, Some(0.0), None])];
    scene.obstacles = vec![obstacle(
        "plate",
        "y1",
        plane([0.0, 1.0, 0.0], [0.0, -1.0, 0.0]),
    )];
    let step = push("plate", [0.0, -0.2, 0.0]);
    let (session, report) = run_one(&scene, &step, &mesh(irregular(square(4), 4)));
    let path = path(&session);
    let (first, last) = (path[0], path[path.len() - 1]);
    let radius = 0.8_f64.powf(-0.5);
    assert!(first[2] == 0.0 && close(last[2], radius, 1e-6), "{last:?}");
    assert!(close(first[4], radius, 1e-6) && last[4].abs() < 1e-9);
    assert!(
        path.iter()
            .all(|row| close(row[3], 0.61, 1e-6) && close(row[5], 0.8, 1e-6))
    );
    let force = integral(&path, |row| TAU * row[4]);
    assert!(
        close(force, -report.obstacles["plate"].force[1], 1e-6),
        "{force}"
    );
}
