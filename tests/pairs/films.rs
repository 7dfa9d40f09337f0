//! Films of fluids between soft bodies: how they slide along, what they throw over. Ends of different increments
//! against each other.

use super::fluids::{fluid, last, raised, unlike};
use super::scenes::{between, joined, rubber};
use crate::common::meshes::{mesh, moved, unit_grid};
use crate::common::scenes::{HELD_IN_PLANE, in_parts, pull, support};
use crate::common::{assert_converged, close, solve};
use signorini::scene::{FluidLoad, SceneKind};
use signorini::{Cause, StepReport, Termination};

/// Bodies slide on each other while a fluid presses, and its film with them: where it lies at the end does not
/// depend on where increments began.
#[test]
fn films_between_sliding_bodies_lie_where_bodies_are_whatever_the_increments() {
    let (mut scene, mesh) = unlike(["up_y0", "low_y1"]);
    scene.solver.tolerance = 1e-10;
    for kind in [SceneKind::PlaneStrain, SceneKind::Axisymmetric] {
        scene.kind = Some(kind);
        let press = pull("up_y1", [Some(0.0), Some(-0.12), None], 1);
        let ends = [1, 2, 5].map(|parts| {
            let up = in_parts(raised(FluidLoad::To(0.25)), parts);
            let reports = solve(&scene, &[press.clone(), up], &mesh);
            reports.iter().for_each(assert_converged);
            last(&reports).clone()
        });
        let told = |end: &StepReport| {
            let water = &end.fluids["water"];
            let contact = end.contacts["pair"].force[1].abs();
            [water.wet_area, water.force[1], contact, end.strain_energy]
        };
        let [one, others @ ..] = ends.each_ref().map(told);
        for other in others {
            for (a, b) in one.iter().zip(other) {
                assert!(close(*a, b, 1e-6), "{kind:?} {one:?} {other:?}");
            }
        }
    }
}

/// Without friction a dome gives way at once where the front comes under its crest: it snaps to where the fluid
/// has advanced to.
#[test]
fn a_dome_that_a_fluid_throws_over_leaks_at_one_pressure_whatever_the_increments() {
    let dome = moved(unit_grid(10, 5), |[x, y, z]| {
        let (x, rise) = (x - 0.5, 0.4 * (x - 0.5).powi(2));
        [x, rise + (0.5 - rise) * y, z]
    });
    let slab = moved(unit_grid(17, 5), |[x, y, z]| {
        [2.0 * x - 1.0, 0.5 * y - 0.5, z]
    });
    let mesh = mesh(joined(&[("up_", dome), ("low_", slab)]));
    let mut scene = rubber([("up_body", 1.0), ("low_body", 1.0)], Some(20.0));
    scene.supports = vec![
        support("up_y1", HELD_IN_PLANE),
        support("low_y0", HELD_IN_PLANE),
    ];
    scene.contacts = between("up_y0", "low_y1");
    let on = ["up_y0", "low_y1", "up_x0", "low_x0"];
    scene.fluids = vec![fluid(&on, &["up_x0", "low_x0"], &["up_x1", "low_x1"])];
    let press = pull("up_y1", [Some(0.0), Some(-0.15), None], 2);
    let [one, other] = [1, 3].map(|parts| {
        let up = in_parts(raised(FluidLoad::To(2.0)), parts);
        let reports = solve(&scene, &[press.clone(), up], &mesh);
        let end = last(&reports);
        let told = (end.termination, end.cause);
        assert_eq!(told, (Termination::NotConverged, Some(Cause::Leaks)));
        end.fluids["water"].blow_off.expect("a bracket")
    });
    assert!(
        one[0] <= other[1] && other[0] <= one[1],
        "{one:?} {other:?}"
    );
}
