//! Films of fluids between soft bodies: how they slide along, where they begin. Ends of
//! different increments, and of fluids that begin on different bodies, against each other.

use super::fluids::{BEGINS, last, mirrored, raised, unlike};
use crate::common::meshes::unit_grid;
use crate::common::scenes::{in_parts, pull};
use crate::common::{assert_converged, close, solve};
use signorini::scene::{FluidLoad, SceneKind};
use signorini::StepReport;

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

#[test]
fn a_fluid_gets_past_a_pressed_edge_along_either_flank() {
    let [both, one, other] = BEGINS.map(|from| mirrored(unit_grid(6, 4), (from, 0.1), 0.1));
    for [pair, _] in [one, other] {
        let [own, expected] = [&pair, &both[0]].map(|report| &report.fluids["water"]);
        assert!(close(own.wet_area, expected.wet_area, 1e-8));
        assert!(close(own.force[0], expected.force[0], 1e-8));
        assert!(close(pair.strain_energy, both[0].strain_energy, 1e-8));
    }
}
