//! Rigid tools: discrete references by two independent codes, in the linear space, and
//! triangulated tools beside analytic ones.
//!
//! The distances of box and cone have one normal but jumps of the curvature, where no rule is
//! exact: forces of the reference, by rules of its own, are kept to 2e-6 (cone) and 6e-5 (box,
//! whose forces by rules of degree 16 and 20 and by a rule of degree 14 on sixteenths of the
//! faces agree among each other to 1e-5).

use std::collections::HashMap;
use std::sync::Arc;

use crate::common::meshes::{cube, file, mesh};
use crate::common::scenes::{bonded_cube, hertz_sphere, push};
use crate::common::{assert_converged, close, solve};
use serde_json::Value;
use signorini::StepReport;
use signorini::obstacle::surface::{Interpolation, SurfaceShape, TriangulatedSurface};
use signorini::scene::{Choice, ContactSpace, Shape};

fn reference(name: &str) -> Value {
    let all: Value =
        serde_json::from_str(include_str!("../reference/tools.json")).expect("valid JSON");
    all[name].clone()
}

fn vector(value: &Value) -> [f64; 3] {
    std::array::from_fn(|i| value[i].as_f64().expect("a number"))
}

/// |a - b| over |b|.
pub(crate) fn difference(a: [f64; 3], b: [f64; 3]) -> f64 {
    let length = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    length(std::array::from_fn(|i| a[i] - b[i])) / length(b)
}

/// The quarter block of incompressible material under a tool that comes down by `travel`.
fn pressed(shape: Shape, travel: f64, space: ContactSpace) -> Vec<StepReport> {
    let (mut scene, _) = hertz_sphere(0.5);
    scene.obstacles[0].shape = shape;
    scene.solver.contact_space = Choice::Named(space);
    scene.solver.tolerance = 1e-10;
    let name = scene.obstacles[0].name.clone();
    let mut step = push(&name, [0.0, 0.0, -travel]);
    step.increments = 2;
    solve(&scene, &[step], &file("indent_l2"))
}

fn check(name: &str, (shape, travel): (Shape, f64), tolerance: f64) {
    let expected = reference(name);
    let reports = pressed(shape, travel, ContactSpace::Linear);
    assert_eq!(reports.len(), 2);
    for (report, exact) in reports.iter().zip(expected.as_array().expect("steps")) {
        assert_converged(report);
        let found = report.obstacles.values().next().expect("a tool");
        let force = difference(found.force, vector(&exact["force"]));
        assert!(force < tolerance, "{name}: force {force:e}");
        let moment = difference(found.moment, vector(&exact["moment"]));
        assert!(moment < 2.0 * tolerance, "{name}: moment {moment:e}");
        let energy = exact["strain_energy"].as_f64().expect("a number");
        assert!(close(report.strain_energy, energy, tolerance));
        assert_eq!(u64::from(report.active_vertices), exact["active"]);
    }
}

#[test]
fn a_torus_presses_as_other_codes_say() {
    let torus = Shape::Torus {
        centre: [0.0, 0.0, 0.25],
        axis: [0.0, 0.0, 1.0],
        radius: 0.35,
        tube_radius: 0.25,
    };
    check("tool-torus", (torus, 0.04), 1e-9);
}

#[test]
fn a_cone_presses_as_other_codes_say() {
    let cone = Shape::Cone {
        apex: [0.0, 0.0, 0.3 - 0.3 / 1.1_f64.sin()],
        axis: [0.0, 0.0, 1.0],
        angle: 1.1,
        rounding: 0.3,
    };
    check("tool-cone", (cone, 0.06), 2e-6);
}

#[test]
fn a_box_presses_as_other_codes_say() {
    let cuboid = Shape::Box {
        centre: [0.0, 0.0, 0.2],
        half_sizes: [0.3, 0.25, 0.2],
        rounding: 0.05,
    };
    check("tool-box", (cuboid, 0.03), 6e-5);
}

/// An octahedron divided `levels` times, its vertices on the unit sphere around (0, 0, 1).
fn globe(levels: usize) -> TriangulatedSurface {
    let unit = |v: [f64; 3]| {
        let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        v.map(|x| x / length)
    };
    let axis = |i: usize, sign: f64| {
        let mut v = [0.0; 3];
        v[i] = sign;
        v
    };
    let mut vertices: Vec<[f64; 3]> = (0..6)
        .map(|i| axis(i / 2, if i % 2 == 0 { 1.0 } else { -1.0 }))
        .collect();
    let mut facets: Vec<[u32; 3]> = vec![
        [0, 2, 4],
        [2, 1, 4],
        [1, 3, 4],
        [3, 0, 4],
        [2, 0, 5],
        [1, 2, 5],
        [3, 1, 5],
        [0, 3, 5],
    ];
    for _ in 0..levels {
        let mut middles = HashMap::new();
        let mut next = Vec::new();
        for [a, b, c] in facets {
            let mut middle = |i: u32, j: u32| {
                *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                    let [p, q] = [vertices[i as usize], vertices[j as usize]];
                    vertices.push(unit(std::array::from_fn(|k| p[k] + q[k])));
                    vertices.len() as u32 - 1
                })
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            next.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        facets = next;
    }
    let raised = vertices.into_iter().map(|[x, y, z]| [x, y, z + 1.0]);
    TriangulatedSurface::new(raised.collect(), facets).expect("closed")
}

#[test]
fn a_triangulated_ball_presses_as_the_ball_does() {
    let ball = Shape::Sphere {
        centre: [0.0, 0.0, 1.0],
        radius: 1.0,
    };
    let triangulated = |between| {
        Shape::Surface(SurfaceShape {
            surface: Arc::new(globe(5)),
            scale: 1.0,
            between,
        })
    };
    let smooth = triangulated(Interpolation::Patches(std::f64::consts::FRAC_PI_6));
    let exact = pressed(ball, 0.05, ContactSpace::Quadratic);
    let found = pressed(smooth, 0.05, ContactSpace::Quadratic);
    for (found, exact) in found.iter().zip(&exact) {
        assert_converged(found);
        let [a, b] = [found, exact].map(|report| report.obstacles.values().next().expect("one"));
        let force = difference(a.force, b.force);
        assert!(force < 1e-4, "force {force:e}");
        assert!(close(a.max_pressure, b.max_pressure, 1e-3));
        assert!(found.sqp_iterations <= exact.sqp_iterations + 2);
    }
    let facets = pressed(
        triangulated(Interpolation::Facets),
        0.05,
        ContactSpace::Quadratic,
    );
    let last = |reports: &[StepReport]| {
        let report = reports.last().expect("one");
        report.obstacles.values().next().expect("one").force
    };
    let force = difference(last(&facets), last(&exact));
    assert!(force > 1e-3, "facets are felt: {force:e}");
}

#[test]
fn the_lid_of_a_box_shaped_cavity_is_a_plane() {
    let (scene, step) = bonded_cube();
    let mesh = mesh(cube(3));
    let plane = solve(&scene, std::slice::from_ref(&step), &mesh);
    let mut inside = scene;
    let cuboid = Shape::Box {
        centre: [0.5, 0.5, -4.0],
        half_sizes: [9.0, 9.0, 5.0],
        rounding: 0.5,
    };
    inside.obstacles[0].shape = Shape::Cavity(cuboid.into());
    let cavity = solve(&inside, &[step], &mesh);
    for (cavity, plane) in cavity.iter().zip(&plane) {
        assert_converged(cavity);
        let [a, b] = [cavity, plane].map(|report| report.obstacles.values().next().expect("one"));
        assert!(difference(a.force, b.force) < 1e-7);
    }
}
