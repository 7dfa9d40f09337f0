//! Contact patch tests: uniform contact pressure is exact on irregular meshes,
//! in space and in the plane, flat and tilted; nothing and everything closed.

use std::sync::Arc;

use crate::common::meshes::{cube, irregular, mesh, moved, square};
use crate::common::scenes::{elastic, obstacle, support, traction};
use crate::common::{difference, node_positions, run_one, values};
use signorini::geometry::{Matrix3, rotation_matrix};
use signorini::scene::Shape;
use signorini::{FieldName, GroupKind, Mesh, Scene, Session, Step};

const TOLERANCE: f64 = 1e-11;
const EXACT: f64 = 1e-9;
const SQUEEZE: f64 = 0.1;

fn solid() -> Arc<Mesh> {
    mesh(irregular(cube(3), 3))
}

fn plane() -> Arc<Mesh> {
    mesh(irregular(square(4), 4))
}

fn floor(on: &str, point: [f64; 3], normal: [f64; 3]) -> signorini::scene::Obstacle {
    obstacle("floor", on, Shape::HalfSpace { point, normal })
}

/// Free sides, rollers on x0 and y0, contact at z0.
fn flat_solid(poisson_ratio: f64) -> Scene {
    let mut scene = elastic(poisson_ratio);
    scene.solver.tolerance = TOLERANCE;
    scene.supports = vec![
        support("x0", [Some(0.0), None, None]),
        support("y0", [None, Some(0.0), None]),
    ];
    scene.obstacles = vec![floor("z0", [0.0; 3], [0.0, 0.0, 1.0])];
    scene
}

/// Displacement, contact pressure on `side` (none elsewhere) and internal
/// pressure where there is one.
fn assert_patch(
    (session, mesh): (&Session, &Mesh),
    side: &str,
    displacement: impl Fn([f64; 3]) -> [f64; 3],
    contact_pressure: f64,
    pressure: f64,
) {
    let exact: Vec<f64> = node_positions(mesh)
        .into_iter()
        .flat_map(displacement)
        .collect();
    let error = difference(&values(session, FieldName::Displacement), &exact);
    assert!(error < EXACT, "displacement {error:e}");
    let mut expected = vec![0.0; mesh.vertex_count() + mesh.edges().len()];
    let group = mesh
        .group(side, GroupKind::Facets)
        .expect("a side of the mesh");
    for &facet in &group.members {
        let corners = mesh.facet(facet as usize);
        for (i, &vertex) in corners.iter().enumerate() {
            expected[vertex as usize] = contact_pressure;
            for &other in &corners[..i] {
                let edge = mesh.edge_between(vertex, other).expect("an edge");
                expected[mesh.vertex_count() + edge as usize] = contact_pressure;
            }
        }
    }
    let error = difference(&values(session, FieldName::ContactPressure), &expected);
    assert!(error < EXACT, "contact pressure {error:e}");
    if let Some(field) = session.field(FieldName::Pressure) {
        let error = difference(&field.values, &vec![pressure; mesh.vertex_count()]);
        assert!(error < EXACT, "pressure {error:e}");
    }
}

#[test]
fn a_squeezed_block_carries_uniform_pressure() {
    for poisson_ratio in [0.5, 0.49, 0.3] {
        let mut scene = flat_solid(poisson_ratio);
        scene
            .supports
            .push(support("z1", [None, None, Some(-SQUEEZE)]));
        let mesh = solid();
        let (session, report) = run_one(&scene, &Step::default(), &mesh);
        let young = 2.0 * (1.0 + poisson_ratio);
        let bulge = poisson_ratio * SQUEEZE;
        let exact = |[x, y, z]: [f64; 3]| [bulge * x, bulge * y, -SQUEEZE * z];
        // p = -lambda div u, the limit q / 3 at one half.
        let pressure = young * SQUEEZE * poisson_ratio / (1.0 + poisson_ratio);
        assert_patch((&session, &mesh), "z0", exact, young * SQUEEZE, pressure);
        assert!((report.obstacles["floor"].force[2] - young * SQUEEZE).abs() < EXACT);
        assert_eq!(u64::from(report.active_vertices), report.unknowns.contact);
    }
}

#[test]
fn a_block_held_up_by_contact_alone_carries_the_load() {
    let load = 0.3;
    let mut scene = flat_solid(0.5);
    scene.tractions = vec![traction("z1", [0.0, 0.0, -load])];
    let mesh = solid();
    let (session, _) = run_one(&scene, &Step::default(), &mesh);
    let (squeeze, bulge) = (load / 3.0, load / 6.0);
    let exact = |[x, y, z]: [f64; 3]| [bulge * x, bulge * y, -squeeze * z];
    assert_patch((&session, &mesh), "z0", exact, load, load / 3.0);
}

#[test]
fn a_plane_block_carries_uniform_pressure() {
    let mut scene = elastic(0.5);
    scene.solver.tolerance = TOLERANCE;
    scene.supports = vec![
        support("x0", [Some(0.0), None, None]),
        support("y1", [None, Some(-SQUEEZE), None]),
    ];
    scene.obstacles = vec![floor("y0", [0.0; 3], [0.0, 1.0, 0.0])];
    let mesh = plane();
    let (session, _) = run_one(&scene, &Step::default(), &mesh);
    let exact = |[x, y, _]: [f64; 3]| [SQUEEZE * x, -SQUEEZE * y, 0.0];
    assert_patch((&session, &mesh), "y0", exact, 4.0 * SQUEEZE, 2.0 * SQUEEZE);
}

fn turn(rotation: &Matrix3, vector: [f64; 3]) -> [f64; 3] {
    rotation.map(|row| row[0] * vector[0] + row[1] * vector[1] + row[2] * vector[2])
}

/// A block without lateral contraction, bonded at `top` and pressed along
/// `down` (unit, before the rotation) on a plane at `bottom`.
fn check_tilted(parts: signorini::MeshParts, rotation: [f64; 3], down: [f64; 3], sides: [&str; 2]) {
    let rotation = rotation_matrix(rotation);
    let shift = [0.3, -0.8, if down[2] == 0.0 { 0.0 } else { 1.7 }];
    let place = |x: [f64; 3]| {
        let turned = turn(&rotation, x);
        std::array::from_fn(|i| turned[i] + shift[i])
    };
    let mesh = mesh(moved(parts, place));
    let normal = turn(&rotation, down.map(|x| -x));
    let mut scene = elastic(0.0);
    scene.solver.tolerance = TOLERANCE;
    let motion = turn(&rotation, down.map(|x| SQUEEZE * x));
    scene.supports = vec![support(sides[1], motion.map(Some))];
    scene.obstacles = vec![floor(sides[0], shift, normal)];
    let (session, _) = run_one(&scene, &Step::default(), &mesh);
    let exact = |x: [f64; 3]| {
        let height: f64 = (0..3).map(|i| (x[i] - shift[i]) * normal[i]).sum();
        normal.map(|n| -SQUEEZE * height * n)
    };
    assert_patch((&session, &mesh), sides[0], exact, 2.0 * SQUEEZE, 0.0);
}

#[test]
fn a_tilted_block_carries_uniform_pressure() {
    let parts = irregular(cube(3), 3);
    check_tilted(parts, [0.4, -0.3, 0.7], [0.0, 0.0, -1.0], ["z0", "z1"]);
}

#[test]
fn a_tilted_plane_block_carries_uniform_pressure() {
    let parts = irregular(square(4), 4);
    check_tilted(parts, [0.0, 0.0, 0.6], [0.0, -1.0, 0.0], ["y0", "y1"]);
}

#[test]
fn two_obstacles_share_a_face_without_disturbing_it() {
    let mut scene = flat_solid(0.5);
    scene
        .supports
        .push(support("z1", [None, None, Some(-SQUEEZE)]));
    let mesh = solid();
    let mut second = scene.obstacles[0].clone();
    second.name = "twin".to_owned();
    scene.obstacles.push(second);
    scene.solver.tolerance = 1e-10;
    let (session, report) = run_one(&scene, &Step::default(), &mesh);
    // Only the sum of the two pressures is determined.
    let force = report.obstacles["floor"].force[2] + report.obstacles["twin"].force[2];
    assert!((force - 3.0 * SQUEEZE).abs() < 1e-8, "{force}");
    let bulge = 0.5 * SQUEEZE;
    let exact = |[x, y, z]: [f64; 3]| [bulge * x, bulge * y, -SQUEEZE * z];
    let exact: Vec<f64> = node_positions(&mesh).into_iter().flat_map(exact).collect();
    assert!(difference(&values(&session, FieldName::Displacement), &exact) < 1e-8);
}

#[test]
fn an_obstacle_out_of_reach_changes_nothing() {
    for poisson_ratio in [0.5, 0.3] {
        let mut scene = elastic(poisson_ratio);
        scene.solver.tolerance = TOLERANCE;
        scene.supports = vec![support("z1", [Some(0.0); 3])];
        scene.tractions = vec![traction("x1", [0.02, 0.01, 0.03])];
        let mesh = solid();
        let (free, _) = run_one(&scene, &Step::default(), &mesh);
        scene.obstacles = vec![floor("z0", [0.0, 0.0, -1.0], [0.0, 0.0, 1.0])];
        let (open, report) = run_one(&scene, &Step::default(), &mesh);
        assert_eq!(report.active_vertices, 0);
        assert!(difference(&report.obstacles["floor"].force, &[0.0; 3]) < f64::MIN_POSITIVE);
        let field = |session: &Session| values(session, FieldName::Displacement);
        let error = difference(&field(&free), &field(&open));
        assert!(error < 1e-12, "{error:e}");
    }
}

#[test]
fn a_face_that_closes_everywhere_has_no_gap_and_pushes_everywhere() {
    let mut scene = elastic(0.3);
    scene.solver.tolerance = TOLERANCE;
    scene.supports = vec![support("z1", [Some(0.0), Some(0.0), Some(-SQUEEZE)])];
    scene.obstacles = vec![floor("z0", [0.0; 3], [0.0, 0.0, 1.0])];
    let mesh = solid();
    let (session, report) = run_one(&scene, &Step::default(), &mesh);
    assert_eq!(u64::from(report.active_vertices), report.unknowns.contact);
    let state = values(&session, FieldName::ContactState);
    let pressure = values(&session, FieldName::ContactPressure);
    let gap = values(&session, FieldName::Gap);
    for vertex in 0..mesh.vertex_count() {
        if state[vertex] > 0.5 {
            assert!(pressure[vertex] > 0.0 && gap[vertex].abs() < 1e-11);
        } else {
            assert!(pressure[vertex].abs() < f64::MIN_POSITIVE);
        }
    }
}
