//! Patch tests on surfaces whose meshes do not match.

use signorini::FieldName;

use super::scenes::{between, carried_along, linear};
use crate::common::meshes::file;
use crate::common::{difference, node_positions, run_one, values};
use signorini::{Scene, Step};

/// Turn of the interface, radians.
const TURN: f64 = 0.5;

/// The field of the bending patch at `at` in a body of shear modulus `shear`: two blocks bent
/// together, the interface turned; contact pressure 1 - 1.5 y along it.
fn bent([x, y, _]: [f64; 3], shear: f64) -> [f64; 3] {
    let (sine, cosine) = TURN.sin_cos();
    let (x, y) = (cosine * x + sine * y, cosine * y - sine * x);
    let u = (-1.0 + 1.5 * y) * x / (4.0 * shear);
    let v = (y - 0.75 * y * y - 0.75 * x * x) / (4.0 * shear);
    [cosine * u - sine * v, sine * u + cosine * v, 0.0]
}

/// Largest errors of displacement and of the force of a bent patch with these moduli of master
/// and slave.
fn errors(name: &str, [master, slave]: [f64; 2]) -> [f64; 2] {
    let mesh = file(name);
    let mut scene = Scene {
        supports: vec![
            carried_along(&mesh, "master_left", |at| bent(at, master)),
            carried_along(&mesh, "slave_right", |at| bent(at, slave)),
        ],
        contacts: between("slave_left", "master_right"),
        ..linear([("master", master), ("slave", slave)])
    };
    scene.solver.tolerance = 1e-13;
    let (session, report) = run_one(&scene, &Step::default(), &mesh);
    let places = node_positions(&mesh);
    let slave_nodes = {
        let group = mesh
            .group("slave", signorini::GroupKind::Cells)
            .expect("a body");
        let mut is_slave = vec![false; places.len()];
        for &cell in &group.members {
            let corners = mesh.cell(cell as usize);
            for (i, &a) in corners.iter().enumerate() {
                is_slave[a as usize] = true;
                for &b in &corners[i + 1..] {
                    let edge = mesh.edge_between(a, b).expect("an edge") as usize;
                    is_slave[mesh.vertex_count() + edge] = true;
                }
            }
        }
        is_slave
    };
    let exact: Vec<f64> = places
        .iter()
        .zip(&slave_nodes)
        .flat_map(|(&at, &is_slave)| bent(at, if is_slave { slave } else { master }))
        .collect();
    let found = values(&session, FieldName::Displacement);
    let force = report.contacts["pair"].force;
    let exact_force = [TURN.cos(), TURN.sin(), 0.0];
    [difference(&found, &exact), difference(&force, &exact_force)]
}

#[test]
fn a_bent_patch_is_exact_across_meshes_that_do_not_match() {
    for name in ["pair_bend_5_3", "pair_bend_3_8"] {
        for moduli in [[1.0, 10.0], [10.0, 1.0], [1.0, 1.0], [1e3, 1.0], [1.0, 1e3]] {
            let [displacement, force] = errors(name, moduli);
            assert!(displacement < 1e-10, "{name} {moduli:?} {displacement:e}");
            assert!(force < 1e-10, "{name} {moduli:?} {force:e}");
        }
    }
}
