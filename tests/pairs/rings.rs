//! A ring shrunk onto another one: pressures against closed solutions.

use std::sync::Arc;

use super::scenes::{between, linear, rubber};
use crate::common::rounded::{round, together};
use crate::common::scenes::support;
use crate::common::solve_one;
use signorini::{CellKind, GroupKind, Mesh, Scene, Step, StepReport};
use signorini::{Group, MeshParts};

/// Radii of the inner and the outer ring.
type Radii = [[f64; 2]; 2];

/// Quarters of two rings with so many faces along, groups `inner` and `outer` with `inner_skin`,
/// `outer_bore`, and `x0`, `y0` on the planes of symmetry; edges round where they meet.
fn rings(along: [usize; 2], radii: Radii) -> Arc<Mesh> {
    let (mut coordinates, mut cells, mut facets) = (Vec::new(), Vec::new(), Vec::new());
    let mut groups: Vec<Group> = Vec::new();
    let mut held = [Vec::new(), Vec::new()];
    for (body, (along, [bore, skin])) in along.into_iter().zip(radii).enumerate() {
        let across = along;
        let first = coordinates.len() as u32;
        let number = |i: usize, j: usize| first + (i * (across + 1) + j) as u32;
        for i in 0..=along {
            let angle = std::f64::consts::FRAC_PI_2 * i as f64 / along as f64;
            for j in 0..=across {
                let radius = bore + (skin - bore) * j as f64 / across as f64;
                coordinates.push([radius * angle.cos(), radius * angle.sin(), 0.0]);
            }
        }
        let first_cell = cells.len() as u32 / 3;
        for (i, j) in (0..along).flat_map(|i| (0..across).map(move |j| (i, j))) {
            let (low, far) = (number(i, j), number(i + 1, j + 1));
            cells.extend([low, number(i, j + 1), far, low, far, number(i + 1, j)]);
        }
        let mut side = |pairs: Vec<[u32; 2]>| {
            let from = facets.len() as u32 / 2;
            facets.extend(pairs.into_iter().flatten());
            (from..facets.len() as u32 / 2).collect::<Vec<u32>>()
        };
        let touching = if body == 0 { across } else { 0 };
        let skin = side(
            (0..along)
                .map(|i| [number(i, touching), number(i + 1, touching)])
                .collect(),
        );
        held[1].extend(side(
            (0..across)
                .map(|j| [number(0, j), number(0, j + 1)])
                .collect(),
        ));
        held[0].extend(side(
            (0..across)
                .map(|j| [number(along, j), number(along, j + 1)])
                .collect(),
        ));
        let names = [["inner", "inner_skin"], ["outer", "outer_bore"]][body];
        groups.push(group(
            names[0],
            GroupKind::Cells,
            (first_cell..cells.len() as u32 / 3).collect(),
        ));
        groups.push(group(names[1], GroupKind::Facets, skin));
    }
    let [x0, y0] = held;
    groups.push(group("x0", GroupKind::Facets, x0));
    groups.push(group("y0", GroupKind::Facets, y0));
    let parts = MeshParts {
        cell_kind: CellKind::Triangle,
        coordinates,
        cells,
        facets,
        groups,
    };
    let arcs = radii
        .as_flattened()
        .iter()
        .map(|&radius| round(&parts, radius, 2));
    let arcs = arcs.fold(Vec::new(), together);
    Arc::new(Mesh::second_order(parts, arcs).expect("a valid mesh"))
}

fn group(name: &str, kind: GroupKind, members: Vec<u32>) -> Group {
    Group {
        name: name.to_owned(),
        kind,
        members,
    }
}

/// The report of two rings that are let go overlapping.
fn shrunk(scene: Scene, along: [usize; 2], radii: Radii, carrier: [&str; 2]) -> StepReport {
    let mesh = rings(along, radii);
    let mut scene = Scene {
        supports: vec![
            support("x0", [Some(0.0), None, None]),
            support("y0", [None, Some(0.0), None]),
        ],
        contacts: between(carrier[0], carrier[1]),
        ..scene
    };
    scene.solver.tolerance = 1e-10;
    solve_one(&scene, &Step::default(), &mesh)
}

/// Pressure of a contact over a quarter of a ring of that radius: an even one p has the force (p r, p r).
fn even(report: &StepReport, radius: f64) -> f64 {
    let [x, y, _] = report.contacts["pair"].force;
    0.5 * (x.abs() + y.abs()) / radius
}

/// Pressure of a shrink fit of incompressible linear rings where an even pressure closes the volume
/// of their overlap.
fn lame([[a, skin], [bore, b]]: Radii, [inner, outer]: [f64; 2]) -> f64 {
    let by_inner = a * a / (2.0 * inner * (skin * skin - a * a)) * skin * skin;
    let by_outer = b * b / (2.0 * outer * (b * b - bore * bore)) * bore * bore;
    0.5 * (skin * skin - bore * bore) / (by_inner + by_outer)
}

#[test]
fn linear_rings_shrink_onto_each_other_by_lame() {
    let radii = [[0.5, 1.0005], [0.9995, 2.0]];
    for moduli in [[1.0, 1.0], [1000.0, 1.0]] {
        let exact = lame(radii, moduli);
        for carrier in [["inner_skin", "outer_bore"], ["outer_bore", "inner_skin"]] {
            let errors = [[8, 12], [16, 24]].map(|along| {
                let scene = linear([("inner", moduli[0]), ("outer", moduli[1])]);
                let report = shrunk(scene, along, radii, carrier);
                assert_eq!(report.sqp_iterations, 1);
                even(&report, 1.0) / exact - 1.0
            });
            // To first order in the overlap, 1e-3 of the radius.
            assert!(
                errors[1].abs() < 1.5e-3,
                "{moduli:?} {carrier:?} {errors:?}"
            );
        }
    }
}

#[test]
fn rings_of_rubber_shrink_onto_each_other_by_the_closed_solution() {
    for (skin, moduli, radius, exact) in [
        (1.05, [1.0, 1.0], 1.041496959, 0.058860102),
        (1.05, [1000.0, 1.0], 1.049989206, 0.070117802),
        (1.2, [1.0, 1.0], 1.177944258, 0.213020451),
    ] {
        let radii = [[0.5, skin], [1.0, 2.0]];
        for carrier in [["outer_bore", "inner_skin"], ["inner_skin", "outer_bore"]] {
            let errors = [[8, 12], [16, 24]].map(|along| {
                let scene = rubber([("inner", moduli[0]), ("outer", moduli[1])], None);
                let report = shrunk(scene, along, radii, carrier);
                let mean = report.contacts["pair"].mean_pressure.expect("contact");
                let found = even(&report, radius);
                assert!(report.sqp_iterations <= 6, "{}", report.sqp_iterations);
                assert!((mean / found - 1.0).abs() < 1e-4, "{mean} {found}");
                found / exact - 1.0
            });
            assert!(
                errors[1].abs() < 1e-4,
                "{skin} {moduli:?} {carrier:?} {errors:?}"
            );
        }
    }
}
