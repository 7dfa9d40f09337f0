//! An open ring that is pinched until its lips press on each other: half of it on a rigid plane.

use std::collections::HashMap;
use std::f64::consts::PI;

use super::folds::{of_itself, together, with_union};
use super::scenes::{between, joined, rubber};
use crate::common::meshes::{mesh, moved, unit_grid, with_pad};
use crate::common::scenes::{HELD_IN_PLANE, obstacle, plane, support};
use crate::common::{assert_converged, close, solve};
use signorini::scene::ContactPair;
use signorini::{MeshParts, Scene, Step, StepReport};

/// Half the opening between the lips.
const OPEN: f64 = 0.1;
/// Radii of the ring.
const RADII: [f64; 2] = [0.7, 1.0];
/// Cells along half the ring, and across.
pub(crate) const CELLS: [usize; 2] = [24, 4];

/// The upper half of the ring, groups `pad` the lip, `cut` the plane of symmetry, `bore`, `skin` and
/// `grip` the part of the skin beside the lip.
pub(crate) fn half([along, across]: [usize; 2]) -> MeshParts {
    let parts = unit_grid(along, across);
    let bent = |[s, t, z]: [f64; 3]| {
        let radius = RADII[1] + t * (RADII[0] - RADII[1]);
        let open = (OPEN / radius).asin();
        let angle = PI + s * (open - PI);
        [radius * angle.cos(), radius * angle.sin(), z]
    };
    let parts = with_pad(parts, ("grip", "y0"), |[s, ..]| (0.66..0.93).contains(&s));
    let mut parts = moved(parts, bent);
    parts.cells.chunks_mut(3).for_each(|cell| cell.swap(1, 2));
    for group in &mut parts.groups {
        let name = match &group.name[..] {
            "x0" => "cut",
            "x1" => "pad",
            "y0" => "skin",
            "y1" => "bore",
            _ => continue,
        };
        group.name = name.to_owned();
    }
    parts
}

/// The whole ring: the upper half and its mirror image, one body; `surface` all of it.
pub(crate) fn whole(cells: [usize; 2]) -> MeshParts {
    let upper = half(cells);
    let mut lower = moved(upper.clone(), |[x, y, z]| [x, -y, z]);
    lower.cells.chunks_mut(3).for_each(|cell| cell.swap(1, 2));
    let parts = glued(joined(&[("up_", upper), ("low_", lower)]));
    let all =
        ["pad", "skin", "bore"].map(|name| ["up_", "low_"].map(|side| format!("{side}{name}")));
    let all: Vec<&str> = all.as_flattened().iter().map(String::as_str).collect();
    with_union(parts, "surface", &all)
}

/// `parts` with one vertex in the place of several at the same place.
pub(crate) fn glued(mut parts: MeshParts) -> MeshParts {
    let at = |x: &[f64; 3]| x.map(|x| (x * 1e9).round() as i64);
    let mut known = HashMap::new();
    let mut coordinates = Vec::new();
    let number = parts.coordinates.iter().map(|x| {
        *known.entry(at(x)).or_insert_with(|| {
            coordinates.push(*x);
            coordinates.len() as u32 - 1
        })
    });
    let number: Vec<u32> = number.collect();
    for vertex in parts.cells.iter_mut().chain(&mut parts.facets) {
        *vertex = number[*vertex as usize];
    }
    parts.coordinates = coordinates;
    parts
}

/// Pinched at the grips until each lip has gone `way`, in four increments.
fn pinched(scene: &Scene, parts: MeshParts, way: f64) -> StepReport {
    let mut scene = scene.clone();
    scene.solver.tolerance = 1e-11;
    let mut step = Step {
        increments: 4,
        ..together(["up_grip", "low_grip"], way)
    };
    let grips = scene
        .supports
        .iter()
        .filter(|one| one.name.ends_with("grip"));
    step.supports.truncate(grips.count());
    let mut reports = solve(&scene, &[step], &mesh(parts));
    reports.iter().for_each(assert_converged);
    reports.pop().expect("a report")
}

fn whole_ring(contacts: Vec<ContactPair>, way: f64) -> StepReport {
    let scene = Scene {
        supports: vec![
            support("up_grip", HELD_IN_PLANE),
            support("low_grip", HELD_IN_PLANE),
        ],
        contacts,
        ..rubber([("up_body", 1.0), ("low_body", 1.0)], Some(50.0))
    };
    pinched(&scene, whole(CELLS), way)
}

fn half_ring(way: f64) -> StepReport {
    let floor = |name: &str| {
        let on = format!("up_{name}");
        obstacle(name, &on, plane([0.0; 3], [0.0, 1.0, 0.0]))
    };
    let scene = Scene {
        supports: vec![
            support("up_grip", HELD_IN_PLANE),
            support("up_cut", [None, Some(0.0), None]),
        ],
        obstacles: ["pad", "bore"].map(floor).into(),
        ..rubber([("up_body", 1.0)], Some(50.0))
    };
    pinched(&scene, joined(&[("up_", half(CELLS))]), way)
}

#[test]
fn a_ring_pinched_shut_is_half_of_it_on_a_rigid_plane() {
    let alone = half_ring(0.13);
    let expected = alone.obstacles["pad"].force[1];
    for (contacts, sign) in [
        (between("up_pad", "low_pad"), 1.0),
        (between("low_pad", "up_pad"), -1.0),
        (of_itself("surface"), -1.0),
    ] {
        let report = whole_ring(contacts, 0.13);
        let [x, y, _] = report.contacts["pair"].force;
        assert!(close(sign * y, expected, 1e-8), "{y} {expected}");
        assert!(x.abs() < 1e-8 * expected, "{x}");
        assert!(close(report.strain_energy, 2.0 * alone.strain_energy, 1e-8));
    }
}
