//! Patch tests: fields linear in each body are exact across meshes that do not match.

use std::sync::Arc;

use signorini::{FieldName, Mesh, MeshParts, Step};

use super::scenes::{carried_along, is_of, joined, linear, rubber, tie};
use crate::common::meshes::{irregular, mesh, moved, unit_box, unit_grid};
use crate::common::{difference, node_positions, run_one, values};

/// Stretch along the interface, normal and shear stress on it.
const STRETCH: f64 = 0.03;
const STRESS: [f64; 2] = [-0.2, 0.1];
const POISSON: f64 = 0.3;

/// Lower and upper blocks of a unit square, or of a unit cube, on each other.
fn stacked(lower: MeshParts, upper: MeshParts, up: usize) -> MeshParts {
    let upper = moved(upper, |x| {
        std::array::from_fn(|i| x[i] + f64::from(u8::from(i == up)))
    });
    joined([("low", lower), ("up", upper)])
}

/// The piecewise linear field in bodies of these shear moduli, whose interface is at one along `up`.
fn field(x: [f64; 3], shear: f64, up: usize) -> [f64; 3] {
    let lame = 2.0 * shear * POISSON / (1.0 - 2.0 * POISSON);
    let normal = (STRESS[0] - lame * STRETCH) / (lame + 2.0 * shear);
    let height = x[up] - 1.0;
    let mut u = [0.0; 3];
    u[0] = STRETCH * x[0] + STRESS[1] / shear * height;
    u[up] += normal * height;
    u
}

/// Rotation about z.
fn turned(angle: f64, [x, y, z]: [f64; 3]) -> [f64; 3] {
    let (sine, cosine) = angle.sin_cos();
    [cosine * x - sine * y, sine * x + cosine * y, z]
}

/// Largest errors of displacement and of the force of the tie; the whole turned by `angle`.
fn errors(
    parts: MeshParts,
    (up, angle): (usize, f64),
    [low, high]: [f64; 2],
    carrier: [&str; 2],
) -> [f64; 2] {
    let sides: &[&str] = match up {
        1 => &["low_y0", "low_x0", "low_x1", "up_y1", "up_x0", "up_x1"],
        _ => &[
            "low_z0", "low_x0", "low_x1", "low_y0", "low_y1", "up_z1", "up_x0", "up_x1", "up_y0",
            "up_y1",
        ],
    };
    let mesh: Arc<Mesh> = mesh(moved(parts, |x| turned(angle, x)));
    let exact = |x: [f64; 3], is_low: bool| {
        let shear = if is_low { low } else { high };
        turned(angle, field(turned(-angle, x), shear, up))
    };
    let mut scene = linear(&[("low", low), ("up", high)], POISSON);
    let supports = sides.iter();
    scene.supports = supports
        .map(|side| carried_along(&mesh, side, |x| exact(x, side.starts_with("low"))))
        .collect();
    scene.ties = vec![tie("seam", carrier[0], carrier[1])];
    scene.solver.tolerance = 1e-13;
    let (session, report) = run_one(&scene, &Step::default(), &mesh);
    let is_low = is_of(&mesh, "low_body");
    let places = node_positions(&mesh).into_iter().zip(is_low);
    let expected: Vec<f64> = places.flat_map(|(x, is_low)| exact(x, is_low)).collect();
    let found = values(&session, FieldName::Displacement);
    let tied = &report.ties["seam"];
    let mut force = [STRESS[1], 0.0, 0.0];
    force[up] = STRESS[0];
    if carrier[0].starts_with("up") {
        force = force.map(|x| -x);
    }
    let force = difference(&tied.force, &turned(angle, force));
    assert!((tied.area - 1.0).abs() < 1e-12, "{}", tied.area);
    assert!(tied.gap < 1e-12, "{}", tied.gap);
    [difference(&found, &expected), force]
}

/// Which side carries, and the contrasts of the moduli.
const CARRIERS: [[&str; 2]; 2] = [["up_SIDE", "low_TOP"], ["low_TOP", "up_SIDE"]];

#[test]
fn linear_fields_are_exact_across_turned_interfaces_in_the_plane() {
    for (lower, upper) in [([5, 4], [3, 3]), ([3, 2], [8, 5])] {
        for moduli in [
            [1.0, 1.0],
            [1.0, 10.0],
            [1e3, 1.0],
            [1.0, 1e3],
            [1.0, 1e6],
            [1e6, 1.0],
        ] {
            for carrier in CARRIERS {
                // A stiff carrier has the rounding of its own stresses.
                let carries_stiff = moduli[usize::from(carrier[0].starts_with("up"))] > 1e5;
                if carries_stiff {
                    continue;
                }
                let carrier = carrier.map(|name| name.replace("SIDE", "y0").replace("TOP", "y1"));
                let parts = stacked(
                    unit_grid(lower[0], lower[1]),
                    unit_grid(upper[0], upper[1]),
                    1,
                );
                let carrier = [&carrier[0][..], &carrier[1][..]];
                let [displacement, force] = errors(parts, (1, 0.5), moduli, carrier);
                assert!(
                    displacement < 1e-10,
                    "{moduli:?} {carrier:?} {displacement:e}"
                );
                assert!(force < 1e-10, "{moduli:?} {carrier:?} {force:e}");
            }
        }
    }
}

#[test]
fn linear_fields_are_exact_across_turned_interfaces_in_space() {
    for (lower, upper) in [([3, 3, 2], [2, 2, 2]), ([2, 2, 2], [3, 4, 2])] {
        for moduli in [[1.0, 1.0], [1e3, 1.0], [1.0, 1e3]] {
            let parts = stacked(unit_box(lower), unit_box(upper), 2);
            for carrier in [["up_z0", "low_z1"], ["low_z1", "up_z0"]] {
                let [displacement, force] = errors(parts.clone(), (2, 0.4), moduli, carrier);
                assert!(
                    displacement < 1e-10,
                    "{moduli:?} {carrier:?} {displacement:e}"
                );
                assert!(force < 1e-10, "{moduli:?} {carrier:?} {force:e}");
            }
        }
    }
}

#[test]
fn a_body_that_a_tie_alone_holds_follows_the_other_one() {
    // Rubber on a base that turns by 1: nothing is strained.
    for moduli in [[1.0, 1.0], [1.0, 1e3], [1e3, 1.0], [1.0, 1e6]] {
        let parts = stacked(irregular(unit_grid(5, 4), 5), unit_grid(3, 3), 1);
        let mesh = mesh(parts);
        let mut scene = rubber(&[("low", moduli[0]), ("up", moduli[1])], 10.0);
        scene.supports = vec![crate::common::scenes::support(
            "low_y0",
            crate::common::scenes::HELD_IN_PLANE,
        )];
        scene.ties = vec![tie("seam", "up_y0", "low_y1")];
        let step = Step {
            supports: vec![signorini::scene::SupportTarget {
                name: "low_y0".to_owned(),
                rotation: Some([0.0, 0.0, 1.0]),
                ..Default::default()
            }],
            ..Step::default()
        };
        let (session, report) = run_one(&scene, &step, &mesh);
        let expected: Vec<f64> = node_positions(&mesh)
            .into_iter()
            .flat_map(|x| {
                let y = turned(1.0, x);
                [y[0] - x[0], y[1] - x[1], 0.0]
            })
            .collect();
        let found = values(&session, FieldName::Displacement);
        let error = difference(&found, &expected);
        assert!(error < 1e-6, "{error:e}");
        assert!(report.strain_energy < 1e-10);
    }
}
