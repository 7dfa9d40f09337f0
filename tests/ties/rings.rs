//! Rings tied along a round interface whose faces do not match.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::sync::Arc;

use signorini::scene::{SupportTarget, Tie};
use signorini::{CellKind, FieldName, GroupKind, Mesh, Scene, Step};
use signorini::{Group, MeshParts};

use super::scenes::{carried_along, joined, linear, places_of, rubber, tie};
use crate::common::rounded::{round, together};
use crate::common::scenes::{HELD_IN_PLANE, support};
use crate::common::{difference, run_one, values};

/// A ring, or a quarter of one, with so many faces along and across: groups `body`, `bore`, `skin`, and
/// of a quarter `x0`, `y0` on the planes of symmetry.
fn ring([along, across]: [usize; 2], [bore, skin]: [f64; 2], angle: f64) -> MeshParts {
    let is_whole = angle > 6.0;
    let (mut coordinates, mut cells) = (Vec::new(), Vec::new());
    let rows = if is_whole { along } else { along + 1 };
    let number = |i: usize, j: usize| ((i % rows) * (across + 1) + j) as u32;
    for i in 0..rows {
        let (sine, cosine) = (angle * i as f64 / along as f64).sin_cos();
        for j in 0..=across {
            let radius = bore + (skin - bore) * j as f64 / across as f64;
            coordinates.push([radius * cosine, radius * sine, 0.0]);
        }
    }
    for (i, j) in (0..along).flat_map(|i| (0..across).map(move |j| (i, j))) {
        let (low, far) = (number(i, j), number(i + 1, j + 1));
        cells.extend([low, number(i, j + 1), far, low, far, number(i + 1, j)]);
    }
    let mut facets = Vec::new();
    let mut groups = vec![Group {
        name: "body".to_owned(),
        kind: GroupKind::Cells,
        members: (0..cells.len() as u32 / 3).collect(),
    }];
    let mut side = |name: &str, pairs: Vec<[u32; 2]>| {
        let from = facets.len() as u32 / 2;
        facets.extend(pairs.into_iter().flatten());
        groups.push(Group {
            name: name.to_owned(),
            kind: GroupKind::Facets,
            members: (from..facets.len() as u32 / 2).collect(),
        });
    };
    let around = |j: usize| (0..along).map(move |i| [number(i, j), number(i + 1, j)]);
    side("bore", around(0).collect());
    side("skin", around(across).collect());
    if !is_whole {
        let cut = |i: usize| (0..across).map(move |j| [number(i, j), number(i, j + 1)]);
        side("y0", cut(0).collect());
        side("x0", cut(along).collect());
    }
    MeshParts {
        cell_kind: CellKind::Triangle,
        coordinates,
        cells,
        facets,
        groups,
    }
}

/// Edges of a mesh: lines, or arcs at those radii.
fn edges(parts: MeshParts, radii: &[f64]) -> Arc<Mesh> {
    let arcs = radii.iter().map(|&radius| round(&parts, radius, 2));
    let arcs = arcs.fold(Vec::new(), together);
    Arc::new(Mesh::second_order(parts, arcs).expect("a valid mesh"))
}

/// Motion of the bore outwards.
const WAY: f64 = 0.01;

/// Errors of displacement and of the force of the tie of two quarters, incompressible, whose bore is
/// widened: u = c x / r^2 in both whatever their moduli.
fn widened(along: [usize; 2], moduli: [f64; 2], radii: &[f64]) -> [f64; 2] {
    let inner = ring([along[0], along[0]], [0.5, 1.0], FRAC_PI_2);
    let outer = ring([along[1], along[1]], [1.0, 2.0], FRAC_PI_2);
    let mesh = edges(joined([("in", inner), ("out", outer)]), radii);
    let exact = |[x, y, _]: [f64; 3]| {
        let factor = 0.5 * WAY / (x * x + y * y);
        [factor * x, factor * y, 0.0]
    };
    let mut scene = linear(&[("in", moduli[0]), ("out", moduli[1])], 0.5);
    scene.supports = vec![
        carried_along(&mesh, "in_bore", exact),
        support("in_x0", [Some(0.0), None, None]),
        support("out_x0", [Some(0.0), None, None]),
        support("in_y0", [None, Some(0.0), None]),
        support("out_y0", [None, Some(0.0), None]),
    ];
    scene.ties = vec![Tie {
        carries: None,
        ..tie("seam", "out_bore", "in_skin")
    }];
    scene.solver.tolerance = 1e-11;
    let (session, report) = run_one(&scene, &Step::default(), &mesh);
    let places = places_of(&mesh);
    let expected: Vec<f64> = places.into_iter().flat_map(exact).collect();
    let found = values(&session, FieldName::Displacement);
    // c = WAY / 2, the skin of the outer one free.
    let pressure = 2.0 * moduli[1] * 0.5 * WAY * (1.0 - 0.25);
    let [x, y, _] = report.ties["seam"].force;
    let force = 0.5 * (x + y) / pressure - 1.0;
    [difference(&found, &expected) / WAY, force.abs()]
}

#[test]
fn round_interfaces_converge_with_the_mesh() {
    for moduli in [[1.0, 1.0], [1e3, 1.0], [1.0, 1e3]] {
        for (radii, least) in [(&[0.5, 1.0, 2.0][..], 3.5), (&[][..], 3.5)] {
            let [coarse, fine] = [[4, 7], [8, 14]].map(|along| widened(along, moduli, radii));
            for (coarse, fine) in coarse.into_iter().zip(fine) {
                assert!(fine < coarse / least, "{moduli:?} {coarse:e} {fine:e}");
            }
        }
    }
}

/// A bush: steel within and without rubber, all three round bodies with faces of their own.
fn bush(along: [usize; 3], radii: &[f64], steel: f64) -> (Scene, Arc<Mesh>) {
    let inner = ring([along[0], 1], [0.4, 0.5], TAU);
    let rubber_ring = ring([along[1], along[1] / 6], [0.5, 1.0], TAU);
    let outer = ring([along[2], 1], [1.0, 1.1], TAU);
    let parts = joined([("pin", inner), ("pad", rubber_ring), ("shell", outer)]);
    let mesh = edges(parts, radii);
    let mut scene = rubber(&[("pin", steel), ("pad", 1.0), ("shell", steel)], 20.0);
    scene.supports = vec![
        support("pin_bore", HELD_IN_PLANE),
        support("shell_skin", HELD_IN_PLANE),
    ];
    scene.ties = vec![
        tie("inner", "pad_bore", "pin_skin"),
        tie("outer", "pad_skin", "shell_bore"),
    ];
    (scene, mesh)
}

/// The pin moved and turned.
fn pushed() -> Step {
    Step {
        supports: vec![SupportTarget {
            name: "pin_bore".to_owned(),
            translation: Some([0.05, 0.02, 0.0]),
            rotation: Some([0.0, 0.0, 0.2]),
            ..SupportTarget::default()
        }],
        ..Step::default()
    }
}

#[test]
fn rubber_that_ties_alone_hold_between_steel_carries_the_load_of_the_pin() {
    for steel in [1e1, 1e3, 1e5] {
        for radii in [&[0.4, 0.5, 1.0, 1.1][..], &[]] {
            let (scene, mesh) = bush([16, 24, 28], radii, steel);
            let (_, report) = run_one(&scene, &pushed(), &mesh);
            let [pin, shell] = ["pin_bore", "shell_skin"].map(|name| report.supports[name]);
            let [inner, outer] = ["inner", "outer"].map(|name| report.ties[name]);
            let size = pin.force[0].abs();
            let forces = [(inner.force, 1.0), (outer.force, -1.0), (shell.force, -1.0)];
            for (force, sign) in forces {
                let apart = [0, 1].map(|i| (force[i] - sign * pin.force[i]).abs());
                assert!(apart.iter().all(|x| *x < 1e-6 * size), "{apart:?}");
            }
            // About the origin, which is the middle of the pin at rest.
            let turn = inner.moment[2] + outer.moment[2];
            assert!(turn.abs() < 1e-6 * size, "{turn:e}");
        }
    }
}

/// The bush in one mesh, its rings with common nodes.
fn bush_of_one(along: usize, steel: f64) -> (Scene, Arc<Mesh>) {
    let radii = [0.4, 0.5, 1.0, 1.1];
    let across = [1, along / 6, 1];
    let layers: usize = across.iter().sum();
    let mut parts = ring([along, layers], [0.0, layers as f64], TAU);
    for [x, y, _] in &mut parts.coordinates {
        let layer = (x.hypot(*y)).round() as usize;
        let inner = layer.saturating_sub(1).min(across[1]) as f64 / across[1] as f64;
        let radius = match layer {
            0 => radii[0],
            layer if layer == layers => radii[3],
            _ => radii[1] + (radii[2] - radii[1]) * inner,
        };
        let size = x.hypot(*y);
        (*x, *y) = if size > 0.0 {
            (*x / size * radius, *y / size * radius)
        } else {
            (radius, 0.0)
        };
    }
    // The bore had no angle at radius zero.
    for i in 0..along {
        let (sine, cosine) = (TAU * i as f64 / along as f64).sin_cos();
        parts.coordinates[i * (layers + 1)] = [radii[0] * cosine, radii[0] * sine, 0.0];
    }
    let layer_of = |cell: u32| (cell as usize / 2) % layers;
    let group = |name: &str, own: &dyn Fn(usize) -> bool| Group {
        name: name.to_owned(),
        kind: GroupKind::Cells,
        members: (0..parts.cells.len() as u32 / 3)
            .filter(|&cell| own(layer_of(cell)))
            .collect(),
    };
    let cells = [
        group("pin_body", &|layer| layer == 0),
        group("pad_body", &|layer| layer > 0 && layer + 1 < layers),
        group("shell_body", &|layer| layer + 1 == layers),
    ];
    parts.groups.retain(|group| group.kind == GroupKind::Facets);
    for (group, name) in parts.groups.iter_mut().zip(["pin_bore", "shell_skin"]) {
        group.name = name.to_owned();
    }
    parts.groups.extend(cells);
    let (scene, _) = bush([12, 12, 12], &[], steel);
    let scene = Scene {
        ties: Vec::new(),
        ..scene
    };
    (scene, edges(parts, &radii))
}

#[test]
fn a_tied_bush_converges_to_the_bush_of_one_mesh() {
    for steel in [1e3, 1e5] {
        let (scene, mesh) = bush_of_one(96, steel);
        let (_, one) = run_one(&scene, &pushed(), &mesh);
        let errors = [[12, 18, 20], [24, 36, 40]].map(|along| {
            let (scene, mesh) = bush(along, &[0.4, 0.5, 1.0, 1.1], steel);
            let (_, tied) = run_one(&scene, &pushed(), &mesh);
            let [own, exact] = [&tied, &one].map(|report| report.supports["pin_bore"].force);
            difference(&own, &exact) / exact[0]
        });
        assert!(errors[1] < errors[0] / 6.0, "{errors:?}");
        assert!(errors[1] < 2e-4, "{errors:?}");
    }
}

#[test]
fn a_bush_that_turns_as_a_whole_is_not_strained() {
    for radii in [&[0.4, 0.5, 1.0, 1.1][..], &[]] {
        let (scene, mesh) = bush([16, 24, 28], radii, 1e3);
        let turned = |name: &str| SupportTarget {
            name: name.to_owned(),
            rotation: Some([0.0, 0.0, 1.0]),
            ..SupportTarget::default()
        };
        let step = Step {
            supports: vec![turned("pin_bore"), turned("shell_skin")],
            ..Step::default()
        };
        let (session, report) = run_one(&scene, &step, &mesh);
        let (sine, cosine) = 1.0_f64.sin_cos();
        let places = places_of(&mesh).into_iter();
        let expected: Vec<f64> = places
            .flat_map(|[x, y, _]| {
                let [a, b] = [cosine * x - sine * y, sine * x + cosine * y];
                [a - x, b - y, 0.0]
            })
            .collect();
        let found = values(&session, FieldName::Displacement);
        assert!(difference(&found, &expected) < 1e-8);
        assert!(report.strain_energy < 1e-10, "{:e}", report.strain_energy);
    }
}
