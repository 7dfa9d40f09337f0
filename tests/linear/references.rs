//! The reference problems, against solutions of independent codes.

use crate::common::meshes::{cube, file, mesh};
use crate::common::scenes::{cube_bend, hertz_plane, hertz_sphere};
use crate::common::{close, solve_one};
use serde_json::Value;
use signorini::scene::{Choice, ContactSpace};
use signorini::{Scene, Step};

fn references() -> Value {
    serde_json::from_str(include_str!("../reference/references.json")).expect("valid JSON")
}

fn number(value: &Value, key: &str) -> f64 {
    value[key]
        .as_f64()
        .unwrap_or_else(|| panic!("a number `{key}` in {value}"))
}

#[test]
fn the_bent_cube_has_the_published_energy_and_corner() {
    for count in [6, 10] {
        let reference = &references()["cube-bend"]["meshes"][format!("cube_n{count}")];
        let mut scene = cube_bend(0.5);
        scene.solver.tolerance = 1e-10;
        let report = solve_one(&scene, &Step::default(), &mesh(cube(count)));
        let tolerance = number(reference, "tolerance");
        assert_eq!(
            report.unknowns.displacement,
            count_of(reference, "displacement_unknowns")
        );
        assert_eq!(
            report.unknowns.pressure,
            count_of(reference, "pressure_unknowns")
        );
        let energy = number(reference, "strain_energy");
        assert!(
            close(report.strain_energy, energy, tolerance),
            "{} {energy}",
            report.strain_energy
        );
        let corner = report.probes["corner"].displacement;
        let (mut error, mut size) = (0.0, 0.0);
        for (i, value) in corner.iter().enumerate() {
            let exact = reference["probes"]["corner"][i].as_f64().expect("a number");
            error += (value - exact).powi(2);
            size += exact * exact;
        }
        assert!((error / size).sqrt() < tolerance, "{corner:?}");
    }
}

fn count_of(value: &Value, key: &str) -> u64 {
    value[key]
        .as_u64()
        .unwrap_or_else(|| panic!("a count `{key}` in {value}"))
}

/// Force and energy of one contact case on its meshes, with the contact pressure of the
/// references: hats at the vertices.
fn check_contact(case: &str, meshes: [&str; 2], (mut scene, step): (Scene, Step)) {
    scene.solver.contact_space = Choice::Named(ContactSpace::Linear);
    let references = references();
    let case = &references[case];
    let (factor, tolerance) = (number(case, "whole_body_factor"), number(case, "tolerance"));
    for name in meshes {
        let reference = &case["meshes"][name];
        let report = solve_one(&scene, &step, &file(name));
        assert_eq!(
            report.unknowns.contact,
            count_of(reference, "contact_multipliers")
        );
        let exact = &reference["steps"][0];
        let force = factor
            * report
                .obstacles
                .values()
                .next()
                .expect("one obstacle")
                .force[2]
                .abs();
        let energy = factor * report.strain_energy;
        assert!(
            close(force, number(exact, "force"), tolerance),
            "{name} {force}"
        );
        assert!(
            close(energy, number(exact, "strain_energy"), tolerance),
            "{name} {energy}"
        );
    }
}

#[test]
fn a_ball_on_a_plane_has_the_published_force() {
    check_contact("hertz-plane", ["hemi_l1", "hemi_l2"], hertz_plane(0.5));
}

#[test]
fn a_block_under_a_sphere_has_the_published_force() {
    check_contact(
        "hertz-sphere",
        ["indent_l1", "indent_l2"],
        hertz_sphere(0.5),
    );
}

#[test]
fn the_reference_problems_converge_at_other_poisson_ratios() {
    for poisson_ratio in [0.3, 0.45, 0.49, 0.499999] {
        solve_one(&cube_bend(poisson_ratio), &Step::default(), &mesh(cube(4)));
        let (scene, step) = hertz_plane(poisson_ratio);
        solve_one(&scene, &step, &file("hemi_l1"));
        let (scene, step) = hertz_sphere(poisson_ratio);
        solve_one(&scene, &step, &file("indent_l1"));
    }
}
