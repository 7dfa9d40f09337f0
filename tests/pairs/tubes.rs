//! Tubes shrunk onto each other: about the axis as the rings of their sections are in the plane.

use std::f64::consts::TAU;
use std::sync::Arc;

use super::scenes::{between, rubber};
use crate::common::meshes::{moved, unit_grid};
use crate::common::scenes::support;
use crate::common::solve_one;
use signorini::scene::SceneKind;
use signorini::{Group, GroupKind, Mesh, MeshParts, Scene, Step};

/// Half sections of two tubes with those radii, of height one; sides `a_x0`, `a_y0` and so on.
fn tubes(counts: [usize; 2], radii: [[f64; 2]; 2]) -> Arc<Mesh> {
    let part = |body: usize| {
        let [bore, skin] = radii[body];
        let place = |[x, y, _]: [f64; 3]| [bore + (skin - bore) * x, y, 0.0];
        moved(unit_grid(counts[body], counts[body] / 2), place)
    };
    let (mut all, other) = (part(0), part(1));
    let [vertices, cells, facets] = [
        all.coordinates.len() as u32,
        all.cells.len() as u32 / 3,
        all.facets.len() as u32 / 2,
    ];
    let named = |group: &Group, prefix: &str, by: u32| Group {
        name: format!("{prefix}{}", group.name),
        kind: group.kind,
        members: group.members.iter().map(|member| member + by).collect(),
    };
    let groups = |parts: &MeshParts, prefix: &str, by: [u32; 2]| -> Vec<Group> {
        let of = |group: &Group| {
            named(
                group,
                prefix,
                by[usize::from(group.kind == GroupKind::Facets)],
            )
        };
        parts.groups.iter().map(of).collect()
    };
    all.groups = [
        groups(&all, "a_", [0, 0]),
        groups(&other, "b_", [cells, facets]),
    ]
    .concat();
    all.coordinates.extend(other.coordinates);
    all.cells
        .extend(other.cells.iter().map(|vertex| vertex + vertices));
    all.facets
        .extend(other.facets.iter().map(|vertex| vertex + vertices));
    Arc::new(Mesh::new(all).expect("a valid mesh"))
}

#[test]
fn tubes_of_rubber_shrink_onto_each_other_by_the_closed_solution() {
    for (skin, outer, exact) in [(1.05, 1.0, 0.058860102), (1.2, 1.0, 0.213020451)] {
        for carrier in [["a_x1", "b_x0"], ["b_x0", "a_x1"]] {
            let mut scene = Scene {
                kind: Some(SceneKind::Axisymmetric),
                supports: ["a_y0", "a_y1", "b_y0", "b_y1"]
                    .map(|on| support(on, [None, Some(0.0), None]))
                    .into(),
                contacts: between(carrier[0], carrier[1]),
                ..rubber([("a_body", 1.0), ("b_body", outer)], None)
            };
            scene.solver.tolerance = 1e-10;
            let mesh = tubes([10, 14], [[0.5, skin], [1.0, 2.0]]);
            let report = solve_one(&scene, &Step::default(), &mesh);
            let found = report.contacts["pair"].mean_pressure.expect("contact");
            assert!(
                (found / exact - 1.0).abs() < 1e-5,
                "{skin} {carrier:?} {found}"
            );
            let pair = &report.contacts["pair"];
            let radius = pair.contact_area / pair.contact_width / TAU;
            assert!(radius > 1.0 && radius < skin, "{radius}");
            let axial = pair.force[1];
            assert!(axial.abs() < 1e-4 * found, "{axial}");
            let inwards = if carrier[0] == "a_x1" { -1.0 } else { 1.0 };
            let radial = pair.force[0] / (inwards * found * pair.contact_area);
            assert!((radial - 1.0).abs() < 1e-6, "{carrier:?} {radial}");
        }
    }
}

#[test]
fn bodies_that_overlap_by_more_than_the_reach_are_warned_of() {
    let mut scene = Scene {
        kind: Some(SceneKind::Axisymmetric),
        supports: ["a_y0", "a_y1", "b_y0", "b_y1"]
            .map(|on| support(on, [None, Some(0.0), None]))
            .into(),
        contacts: between("a_x1", "b_x0"),
        ..rubber([("a_body", 1.0), ("b_body", 1.0)], None)
    };
    scene.solver.tolerance = 1e-10;
    // A quarter of their height of one is the reach.
    let report = solve_one(
        &scene,
        &Step::default(),
        &tubes([10, 14], [[0.5, 1.4], [1.0, 2.0]]),
    );
    assert_eq!(report.contacts["pair"].mean_pressure, None);
    let kinds: Vec<&str> = report.warnings.iter().map(|one| one.kind.name()).collect();
    let texts: Vec<&str> = report
        .warnings
        .iter()
        .map(|one| one.message.as_str())
        .collect();
    assert!(kinds.contains(&"untouched_obstacle"), "{texts:?}");
}
