//! Cook's membrane in plane strain, 64 by 64 by 2 triangles. The published tips
//! belong to other diagonals of the quadrilaterals; turning them moves the tip by
//! up to 1.4e-3 of its value.

mod common;

use common::meshes::{cook, mesh};
use common::scenes::{HELD, elastic, material, probe, support, traction};
use common::{close, solve_one};
use signorini::Step;
use signorini::scene::Modulus;

/// Vertical displacement of the upper right corner under `shear` on the right
/// side.
fn corner(modulus: Modulus, poisson_ratio: f64, shear: f64) -> f64 {
    let mut scene = elastic(poisson_ratio);
    scene.materials = vec![material(modulus, poisson_ratio)];
    scene.supports = vec![support("x0", [Some(0.0), Some(0.0), None])];
    scene.tractions = vec![traction("x1", [0.0, shear, 0.0])];
    scene.probes = vec![probe("corner", [48.0, 60.0, 0.0])];
    solve_one(&scene, &Step::default(), &mesh(cook(64))).probes["corner"].displacement[1]
}

#[test]
fn a_compressible_membrane_has_the_published_tip() {
    let tip = corner(Modulus::Young(70.0), 1.0 / 3.0, 6.25);
    assert!(close(tip, 32.2565, 2e-3), "{tip}");
}

#[test]
fn an_incompressible_membrane_has_the_published_tip() {
    let tip = corner(Modulus::Shear(0.375), 0.5, 1.0 / 16.0);
    assert!(close(tip, 17.244, 2e-3), "{tip}");
}

#[test]
fn a_support_may_hold_the_absent_component_of_a_plane_scene() {
    let mut scene = elastic(0.3);
    scene.supports = vec![support("x0", HELD)];
    scene.tractions = vec![traction("x1", [0.0, 0.1, 0.0])];
    let report = solve_one(&scene, &Step::default(), &mesh(cook(4)));
    assert!(report.strain_energy > 0.0);
}
