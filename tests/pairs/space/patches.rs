//! Patch tests in space on surfaces whose meshes do not match.

use std::sync::Arc;

use signorini::{FieldName, Mesh, Scene, Step};

use super::blocks;
use crate::common::meshes::{mesh, moved};
use crate::common::{difference, node_positions, run_one, values};
use crate::scenes::{between, carried_along, is_of, linear_of};

/// Change of the contact pressure 1 + BEND x along the interface.
const BEND: f64 = 1.5;

/// Turn of all of it about two axes, radians.
fn turned([x, y, z]: [f64; 3], sense: f64) -> [f64; 3] {
    let about_y = |[x, y, z]: [f64; 3]| {
        let (sine, cosine) = (0.5 * sense).sin_cos();
        [cosine * x + sine * z, y, cosine * z - sine * x]
    };
    let about_x = |[x, y, z]: [f64; 3]| {
        let (sine, cosine) = (0.3 * sense).sin_cos();
        [x, cosine * y - sine * z, sine * y + cosine * z]
    };
    match sense > 0.0 {
        true => about_x(about_y([x, y, z])),
        false => about_y(about_x([x, y, z])),
    }
}

/// Displacement in a body of that shear modulus and Poisson's ratio that is pressed and bent across the
/// interface; its normal component is zero there.
fn bent(at: [f64; 3], [shear, ratio]: [f64; 2]) -> [f64; 3] {
    let [x, y, z] = turned(at, -1.0);
    let young = 2.0 * shear * (1.0 + ratio);
    let u = ratio * x + 0.5 * BEND * (z * z + ratio * (x * x - y * y));
    let v = ratio * y + BEND * ratio * x * y;
    let w = -z - BEND * x * z;
    turned([u, v, w].map(|x| x / young), 1.0)
}

/// Largest errors of displacement and of the force for these moduli of the lower and the upper body.
fn errors(mesh: &Arc<Mesh>, [low, up]: [f64; 2], ratio: f64) -> [f64; 2] {
    let mut scene = Scene {
        supports: vec![
            carried_along(mesh, "low_z0", |at| bent(at, [low, ratio])),
            carried_along(mesh, "up_z1", |at| bent(at, [up, ratio])),
        ],
        contacts: between("up_z0", "low_z1"),
        ..linear_of(ratio, [("low_body", low), ("up_body", up)])
    };
    scene.solver.tolerance = 1e-13;
    let (session, report) = run_one(&scene, &Step::default(), mesh);
    let is_low = is_of(mesh, "low_body");
    let places = node_positions(mesh).into_iter().zip(is_low);
    let exact: Vec<f64> = places
        .flat_map(|(at, is_low)| bent(at, [if is_low { low } else { up }, ratio]))
        .collect();
    let found = values(&session, FieldName::Displacement);
    let force = report.contacts["pair"].force;
    let exact_force = turned([0.0, 0.0, 1.0], 1.0);
    [difference(&found, &exact), difference(&force, &exact_force)]
}

#[test]
fn a_bent_patch_in_space_is_exact_across_meshes_that_do_not_match() {
    for counts in [[3, 2], [2, 3]] {
        let [low, up] = counts.map(|count| [count, count, 2]);
        let mesh = mesh(moved(blocks(low, up), |x| turned(x, 1.0)));
        for ratio in [0.5, 0.3, 0.0] {
            for moduli in [[1.0, 1.0], [1e3, 1.0], [1.0, 1e3]] {
                let [displacement, force] = errors(&mesh, moduli, ratio);
                assert!(
                    displacement < 1e-10,
                    "{counts:?} {moduli:?} {displacement:e}"
                );
                assert!(force < 1e-10, "{counts:?} {moduli:?} {force:e}");
            }
        }
    }
}
