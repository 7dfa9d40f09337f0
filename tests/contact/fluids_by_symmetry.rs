//! Fluids where symmetry says what must be the same: a slice in space and plane strain, a wedge and the
//! axis, other numbers of the nodes, another pressure everywhere.

use std::sync::Arc;

use crate::common::meshes::{mesh, moved, unit_box, unit_grid, with_group};
use crate::common::scenes::{elastic, in_parts, obstacle, plane, push, support};
use crate::common::{assert_converged, close, solve};
use crate::fluids::{last, plate_down, raised, rolled, under_a_roller, wave_parts, wavy};
use signorini::report::StepReport;
use signorini::scene::{Film, Fluid, FluidLoad, SceneKind};
use signorini::{Mesh, MeshParts, Scene};

/// Cells along the sides of a block.
const COUNT: usize = 16;
/// Thickness of the slice, one layer of cells.
const THICKNESS: f64 = 1.0 / COUNT as f64;

/// The places of a block that is finer towards its top and, there, towards the roller.
fn graded([x, y, z]: [f64; 3]) -> [f64; 3] {
    [x * x, 1.0 - (1.0 - y) * (1.0 - y), z]
}

/// The block of those cells with its last facets on top as group `start`.
fn graded_block(parts: MeshParts, thickness: f64) -> Arc<Mesh> {
    let last = 1.0 - 1.0 / COUNT as f64;
    let parts = with_group(parts, "y1", "start", |x| x[0] > last);
    mesh(moved(parts, |[x, y, z]| graded([x, y, thickness * z])))
}

fn wet_area(report: &StepReport) -> f64 {
    report.fluids["water"].wet_area
}

#[test]
fn a_slice_in_space_is_wet_and_pressed_as_in_plane_strain() {
    let (flat, _) = under_a_roller();
    let mut slice = flat.clone();
    for side in ["z0", "z1"] {
        slice.supports.push(support(side, [None, None, Some(0.0)]));
    }
    let [flat, slice] = [
        (flat, graded_block(unit_grid(COUNT, COUNT), 1.0)),
        (slice, graded_block(unit_box([COUNT, COUNT, 1]), THICKNESS)),
    ]
    .map(|body| rolled(&body, 0.06, 2));
    let force = |one: &StepReport| one.obstacles["roller"].force[1];
    assert!(close(wet_area(&slice), THICKNESS * wet_area(&flat), 1e-3));
    assert!(
        close(force(&slice), THICKNESS * force(&flat), 1e-3),
        "{} {}",
        force(&slice) / THICKNESS,
        force(&flat)
    );
}

/// A ring about the y axis, from radius one to two, with a bump on top under a lid, bonded below; water
/// outside it.
fn bumped(kind: SceneKind) -> Scene {
    let mut scene = elastic(0.45);
    scene.kind = Some(kind);
    scene.supports = vec![support("y0", [Some(0.0); 3])];
    if kind != SceneKind::Solid {
        scene.supports[0].displacement[2] = None;
    }
    let lid = plane([0.0, 1.0 + BUMP, 0.0], [0.0, -1.0, 0.0]);
    scene.obstacles = vec![obstacle("roller", "y1", lid)];
    scene.fluids = vec![Fluid {
        name: "water".to_owned(),
        on: vec!["y1".to_owned()],
        from: vec!["start".to_owned()],
        dry: vec!["x0".to_owned()],
        ..Fluid::default()
    }];
    scene
}

/// Height of the bump.
const BUMP: f64 = 0.05;
/// Angle of the wedge.
const ANGLE: f64 = 0.04;

/// The places of the ring, x along its radius and z about its axis.
fn about_the_axis([x, y, z]: [f64; 3]) -> [f64; 3] {
    let across = 2.0 * (x - 0.5);
    let radius = 1.5 + 0.5 * across * across.abs().sqrt();
    let up = 1.0 - (1.0 - y) * (1.0 - y);
    let height = up * (1.0 + BUMP * (1.0 - (2.0 * (radius - 1.5)).powi(2)));
    let (sin, cos) = (ANGLE * z).sin_cos();
    [radius * cos, height, radius * sin]
}

#[test]
fn a_wedge_is_wet_and_pressed_as_about_the_axis() {
    let last = 1.0 - 1.0 / COUNT as f64;
    let made = |parts: MeshParts| {
        let parts = with_group(parts, "y1", "start", |x| x[0] > last);
        mesh(moved(parts, about_the_axis))
    };
    let mut wedge = bumped(SceneKind::Solid);
    let mut side = support("z1", [None; 3]);
    side.normal = Some(0.0);
    wedge.supports.push(support("z0", [None, None, Some(0.0)]));
    wedge.supports.push(side);
    let ring = bumped(SceneKind::Axisymmetric);
    let bodies = [
        (ring, made(unit_grid(COUNT, COUNT))),
        (wedge, made(unit_box([COUNT, COUNT, 1]))),
    ];
    let [ring, wedge] = bodies.map(|(scene, mesh)| {
        let up = in_parts(raised(FluidLoad::To(0.05)), 2);
        let reports = solve(&scene, &[push("roller", [0.0, -0.02, 0.0]), up], &mesh);
        reports.iter().for_each(assert_converged);
        last_of(&reports)
    });
    // The sides of the wedge are chords.
    let share = ANGLE.sin() / (2.0 * std::f64::consts::PI);
    let force = |one: &StepReport| one.obstacles["roller"].force[1];
    assert!(
        close(wet_area(&wedge), share * wet_area(&ring), 1e-3),
        "{} {}",
        wet_area(&wedge) / share,
        wet_area(&ring)
    );
    assert!(
        close(force(&wedge), share * force(&ring), 1e-3),
        "{} {}",
        force(&wedge) / share,
        force(&ring)
    );
}

fn last_of(reports: &[StepReport]) -> StepReport {
    last(reports).clone()
}

/// The same mesh with its vertices and cells in the opposite order.
fn turned_round(groups: &MeshParts) -> Arc<Mesh> {
    let count = groups.coordinates.len() as u32;
    let vertices = |all: &[u32]| -> Vec<u32> { all.iter().map(|&v| count - 1 - v).collect() };
    let mut parts = groups.clone();
    parts.coordinates.reverse();
    parts.cells = vertices(&groups.cells);
    parts.facets = vertices(&groups.facets);
    mesh(parts)
}

#[test]
fn fluids_come_as_far_whatever_the_numbers_of_the_nodes() {
    let last = 1.0 - 1.0 / COUNT as f64;
    let parts = with_group(unit_grid(COUNT, COUNT), "y1", "start", |x| x[0] > last);
    let parts = moved(parts, graded);
    let (scene, _) = under_a_roller();
    let plain = mesh(parts.clone());
    let other = turned_round(&parts);
    let [plain, other] = [plain, other].map(|mesh| rolled(&(scene.clone(), mesh), 0.07, 3));
    assert!(close(wet_area(&plain), wet_area(&other), 1e-12));
    let force = |one: &StepReport| one.obstacles["roller"].force[1];
    assert!(close(force(&plain), force(&other), 1e-8));
}

/// A wave of compressible rubber under a plate that is `travel` down, in water that rises until it gets
/// over the crest: the mean pressure of plate and water on the last tight state, and that of the water.
fn sealed(travel: f64) -> [f64; 2] {
    let height = 2e-3;
    let mut scene = wavy(height);
    scene.materials = elastic(0.3).materials;
    let count = 24;
    let mut parts = wave_parts(height, count);
    parts = with_group(parts, "y1", "crest", |x| x[0] < 0.5 / count as f64);
    scene.fluids[0].dry = vec!["crest".to_owned()];
    scene.fluids[0].blow_off_tolerance = 1e-5;
    let steps = [
        plate_down(travel * height, 0.0),
        raised(FluidLoad::ToBlowOff(1.0)),
    ];
    let reports = solve(&scene, &steps, &mesh(parts));
    reports.iter().for_each(assert_converged);
    let end = last(&reports);
    let [tight, _] = end.fluids["water"].blow_off.expect("a bracket");
    let mean = -(end.obstacles["plate"].force[1] + end.fluids["water"].force[1]) / 0.5;
    [mean, tight]
}

#[test]
fn the_pressure_that_seals_a_wave_is_affine_in_that_of_the_fluid() {
    let points = [0.4, 0.8, 1.2, 1.6].map(sealed);
    let slope = (points[3][0] - points[0][0]) / (points[3][1] - points[0][1]);
    for [mean, water] in points {
        let line = points[0][0] + slope * (water - points[0][1]);
        assert!((mean - line).abs() <= 1e-3 * points[3][0], "{points:?}");
    }
    // What presses everywhere changes no gap, so that the slope is one.
    assert!((slope - 1.0).abs() <= 1e-2, "{slope}");
}

#[test]
fn a_film_stays_under_a_tool_unless_it_may_be_squeezed_out() {
    let (scene, mesh) = under_a_roller();
    let [stays, leaves] = [Film::Stays, Film::SqueezedOut].map(|film| {
        let mut scene = scene.clone();
        scene.fluids[0].film = film;
        let steps = [
            push("roller", [0.0, -0.02, 0.0]),
            raised(FluidLoad::To(0.08)),
            in_parts(push("roller", [0.0, -0.04, 0.0]), 4),
        ];
        let reports = solve(&scene, &steps, &mesh);
        reports.iter().for_each(assert_converged);
        last_of(&reports)
    });
    assert!(
        wet_area(&leaves) < 0.99 * wet_area(&stays),
        "{} {}",
        wet_area(&leaves),
        wet_area(&stays)
    );
}
