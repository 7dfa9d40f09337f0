//! A scene on curved faces that is turned as a whole, x -> R x, has the turned forces:
//!
//! ```text
//! F' = R F,   M' = R M,   E' = E
//! ```
//!
//! Middles of edges turn with their ends; the algebra is solved far below what is compared.

use std::sync::Arc;

use crate::common::curved::cylinder;
use crate::common::meshes::{file_parts, moved};
use crate::common::rounded::{round, together, whole_ring};
use crate::common::scenes::{HELD, elastic, obstacle, support};
use crate::common::{close, solve_one};
use signorini::scene::Shape;
use signorini::{EdgeOffset, Mesh, MeshParts, Scene, Step, StepReport};

/// A point or a direction in the turned scene.
type Turn = fn([f64; 3]) -> [f64; 3];

/// A body with its second-order edges.
type Curved = (MeshParts, Vec<EdgeOffset>);

fn in_the_plane([x, y, z]: [f64; 3]) -> [f64; 3] {
    let (sin, cos) = 0.7_f64.sin_cos();
    [cos * x - sin * y, sin * x + cos * y, z]
}

/// About two axes, so that no axis stays what it was.
fn in_space(point: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = in_the_plane(point);
    let (sin, cos) = 1.1_f64.sin_cos();
    [x, cos * y - sin * z, sin * y + cos * z]
}

fn as_it_is(point: [f64; 3]) -> [f64; 3] {
    point
}

/// The report of the scene on the turned body.
fn report((parts, offsets): &Curved, turn: Turn, scene: &Scene) -> StepReport {
    let turned = offsets.iter().map(|one| EdgeOffset {
        offset: turn(one.offset),
        ..*one
    });
    let body = Mesh::second_order(moved(parts.clone(), turn), turned.collect());
    solve_one(scene, &Step::default(), &Arc::new(body.expect("a mesh")))
}

/// An incompressible body held at one group that touches `shape` with another.
fn scene(held: &str, touching: &str, shape: Shape) -> Scene {
    let mut scene = elastic(0.5);
    scene.supports = vec![support(held, HELD)];
    scene.obstacles = vec![obstacle("tool", touching, shape)];
    scene.solver.tolerance = 1e-13;
    scene
}

/// Compares a body with itself turned; `on` makes the scene from a turn.
fn check(body: &Curved, turn: Turn, on: impl Fn(Turn) -> Scene) {
    let rest = report(body, as_it_is, &on(as_it_is));
    let turned = report(body, turn, &on(turn));
    assert!(close(turned.strain_energy, rest.strain_energy, 1e-12));
    let [found, tool] = [&turned, &rest].map(|report| &report.obstacles["tool"]);
    let size = tool.force.iter().map(|f| f * f).sum::<f64>().sqrt();
    assert!(size > 1e-3 && tool.geometry_error.is_none());
    for (found, expected) in [
        (found.force, turn(tool.force)),
        (found.moment, turn(tool.moment)),
    ] {
        let differences = found.iter().zip(expected).map(|(a, b)| (a - b).abs());
        let largest = differences.fold(0.0, f64::max);
        assert!(largest < 1e-12 * size, "{found:?} {expected:?}");
    }
}

#[test]
fn a_turned_ring_on_a_shaft_beside_its_middle_has_the_turned_force() {
    let parts = whole_ring(24, 3);
    let circles = together(round(&parts, 1.0, 2), round(&parts, 2.0, 2));
    check(&(parts, circles), in_the_plane, |turn| {
        let shaft = Shape::Cylinder {
            point: turn([0.05, 0.02, 0.0]),
            axis: [0.0, 0.0, 1.0],
            radius: 0.98,
        };
        scene("outer", "inner", shaft)
    });
}

#[test]
fn a_turned_ball_on_a_plane_has_the_turned_force() {
    let parts = file_parts("hemi_l1");
    let sphere = round(&parts, 1.0, 3);
    check(&(parts, sphere), in_space, |turn| {
        let plane = Shape::HalfSpace {
            point: turn([0.0, 0.0, -0.95]),
            normal: turn([0.0, 0.0, 1.0]),
        };
        scene("top", "contact", plane)
    });
}

#[test]
fn a_turned_roller_under_a_plane_has_the_turned_force() {
    let parts = cylinder(4, 4, 1.0);
    let circle = round(&parts, 1.0, 2);
    check(&(parts, circle), in_space, |turn| {
        let plane = Shape::HalfSpace {
            point: turn([0.9, 0.0, 0.5]),
            normal: turn([-1.0, 0.0, 0.0]),
        };
        scene("z0", "side", plane)
    });
}
