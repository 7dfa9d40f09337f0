//! The estimated discretisation error is close to the true one, and the algebra
//! stops where it no longer matters.

use std::sync::Arc;

use crate::common::meshes::{cube, file, irregular, mesh, moved, square};
use crate::common::scenes::{
    HELD, cube_bend, elastic, hertz_plane, hertz_sphere, material, obstacle, plane,
    small_indentation, support,
};
use crate::common::{assert_converged, close, open, run_one, solve, solve_one, values};
use serde_json::Value;
use signorini::scene::{Choice, ErrorEstimate, Modulus, ToleranceRule};
use signorini::{
    CancelToken, FieldName, Group, GroupKind, Mesh, MeshParts, Plan, Scene, Silent, Step,
    StepReport, Termination,
};

fn manufactured(field: &str) -> Scene {
    let mut scene = elastic(0.5);
    scene.supports = vec![support("x0", HELD)];
    scene.manufactured = Some(field.to_owned());
    scene
}

/// Estimated over true error.
fn effectivity(field: &str, parts: MeshParts) -> f64 {
    let report = solve_one(&manufactured(field), &Step::default(), &mesh(parts));
    let exact = report.errors.expect("a manufactured scene has errors");
    estimate_of(&report) / exact.relative_energy
}

fn estimate_of(report: &StepReport) -> f64 {
    report
        .error_estimate
        .expect("a converged increment has one")
}

#[test]
fn the_estimate_tends_to_the_true_error_of_analytic_fields() {
    for (field, coarse, fine) in [
        ("A1m", cube(4), cube(10)),
        ("trigonometric", cube(5), cube(10)),
        ("vortex", square(8), square(32)),
        ("A1m", irregular(cube(4), 4), irregular(cube(10), 10)),
        ("vortex", irregular(square(8), 8), irregular(square(32), 32)),
    ] {
        let (coarse, fine) = (effectivity(field, coarse), effectivity(field, fine));
        assert!((0.8..1.3).contains(&coarse), "{field} {coarse}");
        assert!((fine - 1.0).abs() < 0.05, "{field} {coarse} {fine}");
    }
}

#[test]
fn fields_in_the_space_have_no_estimated_error() {
    for parts in [irregular(cube(3), 3), irregular(square(5), 5)] {
        let mut scene = manufactured("polynomial");
        scene.solver.tolerance = 1e-12;
        let report = solve_one(&scene, &Step::default(), &mesh(parts));
        assert!(estimate_of(&report) < 1e-10, "{:e}", estimate_of(&report));
    }
}

#[test]
fn a_displacement_form_has_an_estimate_of_its_energy_error() {
    // Under a dead load |u - u_h|^2 = 2 (W - W_h); W by extrapolation from 6, 12.
    let run = |count| solve_one(&cube_bend(0.3), &Step::default(), &mesh(cube(count)));
    let [coarse, middle, fine] = [3, 6, 12].map(run);
    let [a, b, c] = [&coarse, &middle, &fine].map(|report| report.strain_energy);
    let limit = c + (c - b) * (c - b) / ((b - a) - (c - b));
    for report in [&coarse, &middle] {
        let exact = (1.0 - report.strain_energy / limit).sqrt();
        let index = estimate_of(report) / exact;
        assert!((0.5..2.0).contains(&index), "{index}");
    }
}

/// The cube's cells with x below and above one half as two groups.
fn halves(count: usize) -> Arc<Mesh> {
    let mut parts = cube(count);
    let middle = |cell: &[u32]| {
        let sum: f64 = cell.iter().map(|&v| parts.coordinates[v as usize][0]).sum();
        sum / cell.len() as f64
    };
    let (low, high) = (0_u32..)
        .zip(parts.cells.chunks(4))
        .partition::<Vec<_>, _>(|(_, cell)| middle(cell) < 0.5);
    let group = |name: &str, cells: Vec<(u32, &[u32])>| Group {
        name: name.to_owned(),
        kind: GroupKind::Cells,
        members: cells.into_iter().map(|(cell, _)| cell).collect(),
    };
    let groups = [group("soft", low), group("stiff", high)];
    parts.groups.retain(|group| group.name != "body");
    parts.groups.extend(groups);
    mesh(parts)
}

#[test]
fn bonded_bodies_of_different_stiffness_are_not_averaged() {
    let mut scene = elastic(0.0);
    scene.materials = [("soft", 1.0), ("stiff", 1e3)]
        .map(|(group, shear)| {
            let mut one = material(Modulus::Shear(shear), 0.0);
            one.group = group.to_owned();
            one
        })
        .to_vec();
    scene.supports = vec![
        support("x0", [Some(0.0), None, None]),
        support("x1", [Some(0.1), None, None]),
        support("y0", [None, Some(0.0), None]),
        support("z0", [None, None, Some(0.0)]),
    ];
    scene.solver.tolerance = 1e-12;
    let report = solve_one(&scene, &Step::default(), &halves(4));
    assert!(estimate_of(&report) < 1e-9, "{:e}", estimate_of(&report));
}

#[test]
fn the_parts_of_the_cells_add_up_to_the_estimate() {
    let (scene, step) = hertz_sphere(0.5);
    let (session, report) = run_one(&scene, &step, &file("indent_l1"));
    let cells = values(&session, FieldName::ErrorEstimate);
    assert_eq!(cells.len(), file("indent_l1").cell_count());
    let sum: f64 = cells.iter().map(|part| part * part).sum();
    assert!((sum.sqrt() / estimate_of(&report) - 1.0).abs() < 1e-12);
}

/// Force of the finest mesh, and the limit that it and the one before point to
/// when errors fall with the square of the cell size.
fn limit(case: &str, meshes: [&str; 2]) -> f64 {
    let all: Value =
        serde_json::from_str(include_str!("../reference/references.json")).expect("JSON");
    let meshes = meshes.map(|name| &all[case]["meshes"][name]);
    let number = |value: &Value| value.as_f64().expect("a number");
    let [coarse, fine] = meshes.map(|mesh| number(&mesh["steps"][0]["force"]));
    let [few, many] = meshes.map(|mesh| number(&mesh["displacement_unknowns"]));
    let ratio = (few / many).powf(2.0 / 3.0);
    fine + (fine - coarse) * ratio / (1.0 - ratio)
}

#[test]
fn the_estimated_error_of_a_contact_force_is_of_its_size() {
    // On indent_l1 the force crosses its limit by chance: its error says nothing.
    let sphere = limit("hertz-sphere", ["indent_l4", "indent_l5"]);
    let plane = limit("hertz-plane", ["hemi_l4", "hemi_l5"]);
    for (name, (scene, step), exact) in [
        ("indent_l2", hertz_sphere(0.5), sphere),
        ("hemi_l1", hertz_plane(0.5), plane),
        ("hemi_l2", hertz_plane(0.5), plane),
    ] {
        let report = solve_one(&scene, &step, &file(name));
        let result = report.obstacles.values().next().expect("one obstacle");
        let error = (4.0 * result.force[2].abs() - exact).abs();
        let index = 4.0 * result.force_error.expect("an estimate") / error;
        assert!((0.2..5.0).contains(&index), "{name} {index}");
    }
}

/// A scene at 1e-8 and with the discretisation's tolerance.
fn tight_and_loose(scene: &Scene, step: &Step, mesh: &Arc<Mesh>) -> [StepReport; 2] {
    let mut scene = scene.clone();
    scene.solver.tolerance = 1e-8;
    let tight = solve_one(&scene, step, mesh);
    scene.solver.tolerance_rule = ToleranceRule::Discretisation;
    let loose = solve_one(&scene, step, mesh);
    assert!(loose.tolerance > 1e-8 && loose.residuals.largest() <= loose.tolerance);
    assert!((tight.tolerance - 1e-8).abs() < 1e-20);
    [tight, loose]
}

#[test]
fn the_discretisation_tolerance_loses_no_accuracy_at_half_the_cost() {
    for (field, parts) in [
        ("A1m", cube(6)),
        ("A1m", cube(10)),
        ("trigonometric", cube(8)),
        ("vortex", square(16)),
        ("vortex", square(32)),
    ] {
        let [tight, loose] = tight_and_loose(&manufactured(field), &Step::default(), &mesh(parts));
        let [exact, found] = [&tight, &loose].map(|report| report.errors.expect("errors"));
        let pairs = [
            (found.displacement_l2, exact.displacement_l2),
            (found.displacement_h1, exact.displacement_h1),
            (found.relative_energy, exact.relative_energy),
            (
                found.pressure_l2.expect("mixed"),
                exact.pressure_l2.expect("mixed"),
            ),
        ];
        for (found, exact) in pairs {
            assert!(
                (found / exact - 1.0).abs() < 0.02,
                "{field} {found} {exact}"
            );
        }
        let taken = loose.preconditioner_applications;
        // An estimate and an application of its own stand beside the half.
        let bound = 0.65 * f64::from(tight.preconditioner_applications);
        assert!(f64::from(taken) < bound, "{field} {taken} {bound}");
    }
}

#[test]
fn the_discretisation_tolerance_keeps_contact_forces_to_a_tenth_of_their_error() {
    for (name, (scene, step)) in [
        ("indent_l1", hertz_sphere(0.5)),
        ("indent_l2", hertz_sphere(0.3)),
        ("hemi_l1", hertz_plane(0.5)),
        ("hemi_l2", hertz_plane(0.5)),
    ] {
        let [tight, loose] = tight_and_loose(&scene, &step, &file(name));
        for (exact, found) in tight.obstacles.values().zip(loose.obstacles.values()) {
            let change = (found.force[2] - exact.force[2]).abs();
            assert!(change < 0.1 * exact.force_error.expect("one"), "{name}");
        }
        let taken = loose.preconditioner_applications;
        let bound = 0.7 * f64::from(tight.preconditioner_applications);
        assert!(f64::from(taken) < bound, "{name} {taken} {bound}");
    }
}

#[test]
fn the_discretisation_tolerance_does_not_go_below_the_scene_s() {
    let mut scene = manufactured("vortex");
    scene.solver.tolerance_rule = ToleranceRule::Discretisation;
    scene.solver.tolerance = 5e-4;
    let report = solve_one(&scene, &Step::default(), &mesh(square(64)));
    assert!(
        (report.tolerance - 5e-4).abs() < 1e-18,
        "{}",
        report.tolerance
    );
}

#[test]
fn later_increments_follow_the_discretisation_too() {
    let (mut scene, mesh) = small_indentation(4);
    scene.solver.tolerance_rule = ToleranceRule::Discretisation;
    let step = Step {
        increments: 3,
        ..crate::common::scenes::push("ball", [0.0, 0.0, -0.05])
    };
    let reports = solve(&scene, &[step], &mesh);
    assert_eq!(reports.len(), 3);
    for report in &reports {
        assert_converged(report);
        assert!(report.tolerance > 1e-6, "{}", report.tolerance);
        assert!(estimate_of(report) > 0.0);
    }
}

#[test]
fn an_increment_without_a_result_has_no_estimate() {
    let mut session = open(&cube_bend(0.5), &mesh(cube(3)));
    let mut run = session.begin_step(&Step::default()).expect("a step");
    let cancel = CancelToken::new();
    cancel.cancel();
    let report = session.advance(&mut run, &mut Silent, &cancel);
    let report = report.expect("an increment");
    assert_eq!(report.termination, Termination::Cancelled);
    assert_eq!(report.error_estimate, None);
}

#[test]
fn an_estimate_that_is_off_is_not_there() {
    let (mut scene, step) = hertz_sphere(0.5);
    scene.solver.error_estimate = Choice::Named(ErrorEstimate::Off);
    let report = solve_one(&scene, &step, &file("indent_l1"));
    assert_eq!(report.error_estimate, None);
    assert!(report.obstacles.values().all(|o| o.force_error.is_none()));
}

#[test]
fn a_tolerance_by_the_estimate_needs_the_estimate() {
    let mut scene = cube_bend(0.5);
    scene.solver.tolerance_rule = ToleranceRule::Discretisation;
    scene.solver.error_estimate = Choice::Named(ErrorEstimate::Off);
    let fault = Plan::new(&scene, &[], &mesh(cube(2))).expect_err("a contradiction");
    let text = fault.to_string();
    assert!(
        text.contains("solver.error_estimate") && text.contains("`discretisation`"),
        "{text}"
    );
}

/// Two unit squares, far apart, their groups as `of-a` and `of-b`.
fn two_squares(count: usize) -> MeshParts {
    let named = |mut parts: MeshParts, name: &str| {
        for group in &mut parts.groups {
            group.name = format!("{}-{name}", group.name);
        }
        parts
    };
    let mut both = named(square(count), "a");
    let other = named(moved(square(count), |[x, y, z]| [x + 5.0, y, z]), "b");
    let shift = (both.coordinates.len() as u32, both.cells.len() as u32 / 3);
    let facets = both.facets.len() as u32 / 2;
    both.coordinates.extend(other.coordinates);
    both.cells.extend(other.cells.iter().map(|v| v + shift.0));
    both.facets.extend(other.facets.iter().map(|v| v + shift.0));
    both.groups
        .extend(other.groups.into_iter().map(|mut group| {
            let by = match group.kind {
                GroupKind::Cells => shift.1,
                GroupKind::Facets => facets,
            };
            group.members.iter_mut().for_each(|member| *member += by);
            group
        }));
    both
}

/// Blocks of shear moduli 1 and `contrast`, each under a plate.
fn pressed_blocks(contrast: f64) -> StepReport {
    let mut scene = elastic(0.5);
    scene.materials = [("body-a", 1.0), ("body-b", contrast)]
        .map(|(group, shear)| {
            let mut one = material(Modulus::Shear(shear), 0.5);
            one.group = group.to_owned();
            one
        })
        .to_vec();
    let held = [Some(0.0), Some(0.0), None];
    scene.supports = vec![support("y0-a", held), support("y0-b", held)];
    let lid = |name: &str, on: &str| obstacle(name, on, plane([0.0, 0.95, 0.0], [0.0, -1.0, 0.0]));
    scene.obstacles = vec![lid("a", "y1-a"), lid("b", "y1-b")];
    solve_one(&scene, &Step::default(), &mesh(two_squares(4)))
}

#[test]
fn the_error_of_a_force_is_that_of_the_body_it_presses() {
    let error = |contrast, name: &str| {
        let error = pressed_blocks(contrast).obstacles[name].force_error;
        error.expect("an estimate")
    };
    let alone = error(1.0, "a");
    for contrast in [1e4, 1e8] {
        assert!(close(error(contrast, "a"), alone, 1e-3), "{contrast}");
        assert!(close(error(contrast, "b"), contrast * alone, 1e-3));
    }
}
