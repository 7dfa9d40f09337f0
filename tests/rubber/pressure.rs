//! Bodies of rubber blown up by a pressure that follows their inner surface, with
//! a the inner radius, A and B the radii at rest and b^3 = B^3 + a^3 - A^3 or
//! b^2 = B^2 + a^2 - A^2 (Rivlin):
//!
//! ```text
//! sphere    p = f(a / A) - f(b / B), f(s) = C10 (-4 / s - s^-4) + C01 (4 s - 2 s^-2)
//! cylinder  p = mu (ln(a B / (A b)) + (a^2 - A^2) / 2 (a^-2 - b^-2))
//! ```
//!
//! Cells are straight-sided, so that the geometry alone allows order two.

use crate::common::curved::{quarter_ring, thick_cylinder, thick_sphere};
use crate::common::meshes::{mesh, moved, square};
use crate::common::scenes::{in_parts, mooney_rivlin, obstacle, probe, push, rubber, support};
use crate::common::{assert_converged, close, solve};
use signorini::scene::{Choice, Obstacle, OnInstability, Pressure, RubberModel, SceneKind, Shape};
use signorini::{Cause, MeshParts, Scene, Step, Termination};

/// What the finest mesh of a test may miss.
const FINEST: f64 = 1e-3;
/// Least factor between the errors of two meshes: order 1.9 at the corner of the
/// body where the radius is read.
const HALVED: f64 = 3.7;
/// Increments of a step.
const PARTS: u32 = 2;

/// A body under inner pressure, held by its planes of symmetry.
fn inflated(pressure: f64, planes: &[(&str, usize)]) -> Scene {
    let mut scene = rubber(mooney_rivlin(), None);
    scene.pressures = vec![Pressure {
        on: vec!["inner".to_owned()],
        value: pressure,
    }];
    let held = |&(name, axis): &(&str, usize)| {
        let mut values = [None; 3];
        values[axis] = Some(0.0);
        support(name, values)
    };
    scene.supports = planes.iter().map(held).collect();
    scene.probes = vec![
        probe("inner", [1.0, 0.0, 0.0]),
        probe("top", [0.0, 1.0, 0.0]),
    ];
    scene
}

/// Blows bodies of one shape up to each radius and pressure on one way, a mesh finer than the one
/// before, and fails unless the inner radii are as far from these as order two allows.
fn check(cases: &[(f64, f64)], scene: impl Fn(f64) -> Scene, bodies: [MeshParts; 3]) {
    let most = cases.last().expect("a case").1;
    let scene = scene(most);
    let to = |&(_, pressure): &(f64, f64)| Step {
        load: Some(pressure / most),
        increments: PARTS,
        ..Step::default()
    };
    let steps: Vec<Step> = cases.iter().map(to).collect();
    let found = bodies.map(|parts| {
        let reports = solve(&scene, &steps, &mesh(parts));
        reports.iter().for_each(assert_converged);
        let ends = reports.into_iter().skip(PARTS as usize - 1);
        let ends = ends.step_by(PARTS as usize);
        let moved = ends.map(|report| report.probes["inner"].displacement[0]);
        moved.collect::<Vec<f64>>()
    });
    for (case, &(radius, _)) in cases.iter().enumerate() {
        let error = |moved: &Vec<f64>| (1.0 + moved[case] - radius).abs() / radius;
        assert_second_order(&found.each_ref().map(error));
    }
}

fn assert_second_order(errors: &[f64]) {
    let is_fast = errors.windows(2).all(|pair| pair[1] <= pair[0] / HALVED);
    assert!(is_fast, "{errors:?}");
    assert!(
        errors.last().is_some_and(|&last| last <= FINEST),
        "{errors:?}"
    );
}

#[test]
fn a_thick_sphere_is_blown_up_as_rivlin_says() {
    let planes = [("x0", 0), ("y0", 1), ("z0", 2)];
    let cases = [(1.1, 0.293659139), (1.5, 0.847426758)];
    let bodies = [5, 10, 20].map(|n| thick_sphere(n, n / 5 * 3));
    check(&cases, |pressure| inflated(pressure, &planes), bodies);
}

#[test]
fn a_thick_cylinder_is_blown_up_as_rivlin_says() {
    let planes = [("x0", 0), ("y0", 1), ("z0", 2), ("z1", 2)];
    let cases = [(1.1, 0.131562278), (1.5, 0.428228409)];
    let body = |n: usize| thick_cylinder(n, n / 2, 2.0 / n as f64);
    let bodies = [6, 12, 24].map(body);
    check(&cases, |pressure| inflated(pressure, &planes), bodies);
}

#[test]
fn a_thick_ring_in_plane_strain_is_a_thick_cylinder() {
    let cases = [(1.1, 0.131562278), (1.5, 0.428228409), (2.0, 0.574053572)];
    let scene = |pressure| inflated(pressure, &[("x0", 0), ("y0", 1)]);
    check(&cases, scene, [8, 16, 32].map(|n| quarter_ring(n, n / 2)));
}

/// A neo-Hookean sphere bears no more than 0.816 mu, at a / A = 1.8.
#[test]
fn a_balloon_bears_no_more_than_its_limit() {
    let mut scene = inflated(1.0, &[("x0", 0), ("y0", 1), ("z0", 2)]);
    scene.materials = rubber(RubberModel::NeoHookean { shear_modulus: 1.0 }, None).materials;
    // Beyond its limit it would grow without end.
    scene.solver.on_instability = Choice::Named(OnInstability::Stop);
    let steps = [in_parts(Step::default(), 10)];
    let reports = solve(&scene, &steps, &mesh(thick_sphere(4, 2)));
    let (last, borne) = reports.split_last().expect("an increment");
    borne.iter().for_each(assert_converged);
    let found = (last.termination, last.cause);
    assert_eq!(found, (Termination::NotConverged, Some(Cause::LimitPoint)));
    assert!((0.81..0.83).contains(&last.load), "{}", last.load);
}

/// The section x from 1 to 2 of a tall tube, turned about the axis.
fn tube(count: usize) -> MeshParts {
    let parts = square(count);
    let mut parts = moved(parts, |[x, y, z]| [1.0 + x, 0.5 * y, z]);
    for group in &mut parts.groups {
        if group.name == "x0" {
            group.name = "inner".to_owned();
        }
    }
    parts
}

#[test]
fn an_axisymmetric_tube_is_a_thick_cylinder() {
    let cases = [(1.1, 0.131562278), (1.5, 0.428228409), (2.0, 0.574053572)];
    let scene = |pressure| {
        let mut scene = inflated(pressure, &[("y0", 1), ("y1", 1)]);
        scene.kind = Some(SceneKind::Axisymmetric);
        scene.probes.truncate(1);
        scene
    };
    check(&cases, scene, [2, 4, 8].map(tube));
}

#[test]
fn an_axisymmetric_ball_is_a_thick_sphere() {
    let cases = [(1.1, 0.293659139), (1.5, 0.847426758)];
    let scene = |pressure| {
        let mut scene = inflated(pressure, &[("x0", 0), ("y0", 1)]);
        scene.kind = Some(SceneKind::Axisymmetric);
        scene
    };
    check(&cases, scene, [8, 16, 32].map(|n| quarter_ring(n, n / 2)));
}

#[test]
fn supports_balance_the_pressure_on_the_deformed_opening() {
    let (radius, pressure) = (1.5, 0.428228409);
    let scene = inflated(pressure, &[("x0", 0), ("y0", 1)]);
    let reports = solve(
        &scene,
        &[in_parts(Step::default(), 2)],
        &mesh(quarter_ring(16, 8)),
    );
    let report = reports.last().expect("an increment");
    assert_converged(report);
    // A pressure on an arc is one on its chord: the force along an axis is that on
    // the height of the arc along the other.
    for (support, axis, end) in [("x0", 0, "top"), ("y0", 1, "inner")] {
        let opening = 1.0 + report.probes[end].displacement[1 - axis];
        assert!(close(opening, radius, 5e-3), "{opening}");
        let force = report.supports[support].force[axis];
        assert!(close(force, -pressure * opening, 1e-6), "{support} {force}");
    }
}

/// Share of the way from a square to a disc.
const ROUNDED: f64 = 0.8;

/// A section between square and round, from -1 to 1, whose sides are four groups.
fn profile(count: usize) -> MeshParts {
    moved(square(count), |[x, y, z]| {
        let [s, t] = [2.0 * x - 1.0, 2.0 * y - 1.0];
        let round = |s: f64, t: f64| s * (1.0 - ROUNDED * t * t / 2.0).sqrt();
        [round(s, t), round(t, s), z]
    })
}

/// A plane beside the section, on that side of an axis, which all of it may touch.
fn wall(name: &str, axis: usize, side: f64) -> Obstacle {
    let (mut point, mut normal) = ([0.0; 3], [0.0; 3]);
    (point[axis], normal[axis]) = (side, -side);
    Obstacle {
        on: ["x0", "x1", "y0", "y1"].map(str::to_owned).to_vec(),
        ..obstacle(name, "x0", Shape::HalfSpace { point, normal })
    }
}

/// Half the height of the side x1 of the section.
fn edge() -> f64 {
    (1.0 - ROUNDED / 2.0).sqrt()
}

/// A seal between plates, in the corner of a groove, with fluid on its side x1.
fn seal(pressure: f64) -> Scene {
    let mut scene = rubber(mooney_rivlin(), None);
    scene.kind = Some(SceneKind::PlaneStrain);
    scene.pressures = vec![Pressure {
        on: vec!["x1".to_owned()],
        value: pressure,
    }];
    scene.obstacles = vec![
        wall("bottom", 1, -1.0),
        wall("top", 1, 1.0),
        wall("groove", 0, -1.0),
    ];
    scene.probes = vec![
        probe("low", [edge(), -edge(), 0.0]),
        probe("high", [edge(), edge(), 0.0]),
    ];
    scene
}

/// Pressure on one side of a seal has free edges: the forces that it turns with have no
/// potential, and no energy has a saddle for them.
#[test]
fn a_seal_bears_the_fluid_on_one_side_of_it() {
    for (squeeze, pressure) in [(0.2, 0.5), (0.4, 2.0)] {
        let squeezed = Step {
            load: Some(0.0),
            ..push("top", [0.0, -squeeze, 0.0])
        };
        let loaded = Step {
            load: Some(1.0),
            ..Step::default()
        };
        let steps = [squeezed, in_parts(loaded, 4)];
        let reports = solve(&seal(pressure), &steps, &mesh(profile(10)));
        reports.iter().for_each(assert_converged);
        let report = reports.last().expect("an increment");
        let [low, high] = ["low", "high"].map(|name| report.probes[name].displacement);
        let height = 2.0 * edge() + high[1] - low[1];
        let force = report.obstacles["groove"].force[0];
        assert!(close(force, pressure * height, 1e-6), "{force} {height}");
    }
}
