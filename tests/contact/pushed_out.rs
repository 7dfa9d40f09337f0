//! Seals that a fluid pushes out before it creeps through.
//!
//! ```text
//! q h <= mu (N_floor + N_lid) + what the ring itself holds
//! ```
//!
//! A block between two plates that friction alone holds slides as soon as the fluid on its side presses
//! more than friction bears. A ring resists a little, but gets thinner as it is blown up: it lets go at once.

use std::sync::Arc;

use crate::common::meshes::{file, mesh, moved, unit_grid};
use crate::common::scenes::{obstacle, plane, push, rubber};
use crate::common::{assert_converged, solve};
use crate::fluids::{last, raised};
use signorini::report::{StepReport, Tightness, WarningKind};
use signorini::scene::{Fluid, FluidLoad, RubberModel, SceneKind};
use signorini::{Mesh, Scene};

/// Coefficient of friction of both plates.
const FRICTION: f64 = 0.3;

/// A unit square between plates, water on its left side.
fn between_plates(kind: Option<SceneKind>) -> Scene {
    let mut scene = rubber(RubberModel::NeoHookean { shear_modulus: 1.0 }, Some(50.0));
    scene.kind = kind;
    let plates = [("floor", "y0", 0.0, 1.0), ("lid", "y1", 1.0, -1.0)];
    scene.obstacles = plates
        .map(|(name, on, height, up)| {
            let mut plate = obstacle(name, on, plane([0.0, height, 0.0], [0.0, up, 0.0]));
            plate.friction = FRICTION;
            plate
        })
        .to_vec();
    scene.fluids = vec![Fluid {
        name: "water".to_owned(),
        on: vec!["y0".to_owned(), "y1".to_owned()],
        from: vec!["x0".to_owned()],
        dry: vec!["x1".to_owned()],
        ..Fluid::default()
    }];
    scene
}

/// What friction bears of both plates over what it could.
fn share_of_friction(end: &StepReport) -> f64 {
    let sum = |axis: usize| -> f64 {
        let all = end.obstacles.values();
        all.map(|plate| plate.force[axis].abs()).sum()
    };
    sum(0) / (FRICTION * sum(1))
}

/// Six by six cells, their left side at `inner`.
fn square(inner: f64) -> Arc<Mesh> {
    mesh(moved(unit_grid(6, 6), |[x, y, z]| [inner + x, y, z]))
}

/// The end of a search for the blow-off.
fn blown_off(kind: Option<SceneKind>, square: &Arc<Mesh>) -> StepReport {
    let steps = [
        push("lid", [0.0, -0.1, 0.0]),
        raised(FluidLoad::ToBlowOff(2.0)),
    ];
    let reports = solve(&between_plates(kind), &steps, square);
    reports.iter().for_each(assert_converged);
    last(&reports).clone()
}

/// Whether a leak is told as a body that is pushed out.
fn is_pushed_out(end: &StepReport) -> bool {
    let kinds = end.warnings.iter().map(|one| (one.kind, &one.subject[..]));
    kinds
        .into_iter()
        .any(|told| told == (WarningKind::PushedOut, "water"))
}

#[test]
fn a_block_between_plates_is_pushed_out_at_the_limit_of_friction() {
    for block in [square(0.0), file("square_u8")] {
        let end = blown_off(None, &block);
        let water = &end.fluids["water"];
        let [tight, leaks] = water.blow_off.expect("a bracket");
        assert!(is_pushed_out(&end));
        assert_eq!(water.tightness, Tightness::Leaks);
        assert!(leaks - tight <= 0.01 * leaks, "{tight} {leaks}");
        // Between the ends friction comes to its limit.
        let share = share_of_friction(&end);
        assert!(
            share <= 1.0 + 1e-9 && share * leaks / tight >= 0.99,
            "{share}"
        );
    }
}

#[test]
fn a_ring_between_plates_is_pushed_out_once_all_of_it_slides() {
    let end = blown_off(Some(SceneKind::Axisymmetric), &square(7.0));
    let [tight, leaks] = end.fluids["water"].blow_off.expect("a bracket");
    assert!(is_pushed_out(&end));
    assert!(leaks - tight <= 0.01 * leaks, "{tight} {leaks}");
    assert!(
        share_of_friction(&end) >= 0.9,
        "{}",
        share_of_friction(&end)
    );
}
