//! The reference problems of rubber: forces and energies of independent codes,
//! how many programs an increment takes, and how fast they end.

use std::sync::Arc;

use crate::common::meshes::{cube, file, mesh};
use crate::common::scenes::{bonded_cube, in_parts, indented_block, push, squeezed_cube};
use crate::common::{assert_converged, close, open, solve};
use serde_json::Value;
use signorini::scene::{Choice, ContactSpace};
use signorini::{CancelToken, IterationRecord, Mesh, Observer, Scene, Step};

/// Largest relative difference that the default rule may make.
const DEFAULT_RULE: f64 = 2e-3;
/// Programs that an increment may take.
const MOST_PROGRAMS: u32 = 6;

fn number(value: &Value, key: &str) -> f64 {
    let value = &value[key];
    value
        .as_f64()
        .unwrap_or_else(|| panic!("a number `{key}`, not {value}"))
}

/// Every increment of a case against its reference.
fn check(case: &str, mesh_name: &str, (scene, step): (&Scene, &Step), mesh: &Arc<Mesh>) {
    let all: Value =
        serde_json::from_str(include_str!("../reference/references.json")).expect("valid JSON");
    let case = &all[case];
    let factor = number(case, "whole_body_factor");
    let tolerance = match scene.solver.quadrature_degree {
        Some(_) => number(case, "tolerance"),
        None => DEFAULT_RULE,
    };
    let exact = case["meshes"][mesh_name]["steps"]
        .as_array()
        .expect("steps");
    let reports = solve(scene, std::slice::from_ref(step), mesh);
    // Of an equilibrium it does not matter in how many increments it is come to.
    let each = exact.len() / step.increments as usize;
    assert_eq!(reports.len() * each, exact.len());
    for (report, exact) in reports
        .iter()
        .zip(exact.iter().skip(each - 1).step_by(each))
    {
        assert_converged(report);
        let obstacle = report.obstacles.values().next().expect("one obstacle");
        let force = factor * obstacle.force[2].abs();
        let energy = factor * report.strain_energy;
        assert!(
            close(force, number(exact, "force"), tolerance)
                && close(energy, number(exact, "strain_energy"), tolerance),
            "{force} {energy} {exact}"
        );
        assert!(
            report.sqp_iterations <= MOST_PROGRAMS,
            "{}",
            report.sqp_iterations
        );
    }
}

/// By the default rule, with the contact pressure of the reference, hats at the vertices.
fn check_as_planned(case: &str, mesh_name: &str, body: (Scene, Step), parts: Arc<Mesh>) {
    let (mut scene, step) = body;
    scene.solver.contact_space = Choice::Named(ContactSpace::Linear);
    check(case, mesh_name, (&scene, &step), &parts);
}

/// The same with the rule of the reference, to its tolerance.
fn check_by_its_rule(case: &str, mesh_name: &str, body: (Scene, Step), parts: Arc<Mesh>) {
    let (mut scene, step) = body;
    scene.solver.quadrature_degree = Some(8);
    scene.solver.tolerance = 1e-10;
    check_as_planned(case, mesh_name, (scene, step), parts);
}

#[test]
fn a_cube_between_planes_has_the_exact_force() {
    let parts = mesh(cube(6));
    check_as_planned("mr-uniax", "cube_n6", squeezed_cube(), Arc::clone(&parts));
    check_by_its_rule("mr-uniax", "cube_n6", squeezed_cube(), parts);
}

#[test]
fn a_bonded_cube_has_the_published_force() {
    check_as_planned("mr-block", "cube_n6", bonded_cube(), mesh(cube(6)));
}

#[test]
fn a_bonded_cube_has_the_published_force_to_its_digits() {
    let (scene, step) = bonded_cube();
    let step = in_parts(step, 5);
    check_by_its_rule("mr-block", "cube_n6", (scene, step), mesh(cube(6)));
}

#[test]
fn a_block_under_a_sphere_has_the_published_force() {
    let parts = file("indent_l2");
    check_as_planned("mr-sphere", "indent_l2", indented_block(), parts);
}

#[test]
fn a_block_under_a_sphere_has_the_published_force_to_its_digits() {
    let parts = file("indent_l2");
    check_by_its_rule("mr-sphere", "indent_l2", indented_block(), parts);
}

/// Keeps the first record of every program: the residual it starts from, but for
/// one iteration.
#[derive(Default)]
struct FirstRecords(Vec<(u32, f64)>);

impl Observer for FirstRecords {
    fn iteration(&mut self, record: &IterationRecord) {
        if self
            .0
            .last()
            .is_none_or(|last| last.0 < record.sqp_iteration)
        {
            self.0
                .push((record.sqp_iteration, record.residuals.largest()));
        }
    }
}

#[test]
fn every_program_near_the_end_squares_the_residual() {
    let (mut scene, _) = bonded_cube();
    scene.solver.tolerance = 1e-12;
    // From rest, where nothing is predicted.
    for travel in [-0.025, -0.05, -0.075, -0.1] {
        let mut session = open(&scene, &mesh(cube(3)));
        let step = push("press", [0.0, 0.0, travel]);
        let mut run = session.begin_step(&step).expect("a valid step");
        let mut seen = FirstRecords::default();
        let report = session.advance(&mut run, &mut seen, &CancelToken::new());
        assert_converged(&report.expect("an increment"));
        let tail: Vec<f64> = seen.0.iter().map(|(_, r)| *r).skip(1).collect();
        assert!(tail.len() >= 3, "{tail:?}");
        let is_squared = tail
            .windows(2)
            .all(|pair| pair[1] <= 16.0 * pair[0].powi(2));
        assert!(is_squared, "{tail:?}");
    }
}

#[test]
fn increments_in_one_direction_start_where_the_last_ones_lead() {
    let (scene, step) = bonded_cube();
    let reports = solve(&scene, &[step], &mesh(cube(4)));
    reports.iter().for_each(assert_converged);
    let programs: Vec<u32> = reports.iter().map(|r| r.sqp_iterations).collect();
    // Three each without a prediction.
    assert!(programs.iter().sum::<u32>() <= 24, "{programs:?}");
}

#[test]
fn a_body_led_back_the_way_it_came_needs_no_program() {
    let (scene, _) = bonded_cube();
    let out = in_parts(push("press", [0.0, 0.0, -0.1]), 2);
    let back = push("press", [0.0, 0.0, -0.05]);
    let reports = solve(&scene, &[out, back], &mesh(cube(3)));
    reports.iter().for_each(assert_converged);
    assert_eq!(reports[2].sqp_iterations, 0);
    let energies = [reports[0].strain_energy, reports[2].strain_energy];
    assert!(close(energies[0], energies[1], 1e-7), "{energies:?}");
}
