//! Fluids that meet each other, and one that finds a body not in equilibrium yet: where they leak does
//! not depend on the order of their names, nor on where the body begins.
//!
//! Exact: a block between rollers bears its load evenly, so that a fluid enters at that pressure.

use std::sync::Arc;

use crate::common::meshes::{mesh, unit_grid, with_group};
use crate::common::scenes::{plane, support};
use crate::common::{assert_converged, solve};
use crate::fluids::{LOAD, Lid, block, jack, last, raised};
use signorini::report::{FluidResult, Tightness};
use signorini::scene::{Fluid, FluidLoad};
use signorini::{Mesh, Scene, Step};

/// A gas at the other end of the sole, under a pressure that is too low to enter.
fn gas() -> Fluid {
    Fluid {
        name: "gas".to_owned(),
        on: vec!["y0".to_owned()],
        from: vec!["end".to_owned()],
        pressure: 0.2 * LOAD,
        ..Fluid::default()
    }
}

/// The block with both ends of its sole as groups.
fn sole() -> Arc<Mesh> {
    let start = with_group(unit_grid(8, 8), "y0", "start", |x| x[0] < 0.125);
    mesh(with_group(start, "y0", "end", |x| x[0] > 0.875))
}

/// The jack with a gas before or after the water, neither with a surface that must stay dry.
fn with_gas(place: usize) -> Scene {
    let mut scene = jack(Lid::Load);
    scene.fluids[0].dry.clear();
    scene.fluids.insert(place, gas());
    scene
}

/// The end of a search for the pressure at which the water leaks.
fn blown_off(scene: &Scene, steps: &[Step], mesh: &Arc<Mesh>) -> [FluidResult; 2] {
    let reports = solve(scene, steps, mesh);
    reports.iter().for_each(assert_converged);
    let fluids = &last(&reports).fluids;
    [
        &fluids["water"],
        fluids.get("gas").unwrap_or(&FluidResult::default()),
    ]
    .map(Clone::clone)
}

#[test]
fn the_fluid_that_rises_leaks_into_the_other_whatever_their_order() {
    let steps = [Step::default(), raised(FluidLoad::ToBlowOff(3.0 * LOAD))];
    let ends = [0, 1].map(|place| blown_off(&with_gas(place), &steps, &sole()));
    for [water, gas] in &ends {
        assert_eq!(
            [water.tightness, gas.tightness],
            [Tightness::Leaks, Tightness::Tight]
        );
        let [tight, leaks] = water.blow_off.expect("a bracket");
        assert!(tight <= LOAD * (1.0 + 1e-9) && LOAD <= leaks * (1.0 + 1e-9));
        assert!(leaks - tight <= 0.01 * leaks, "{tight} {leaks}");
        // The way into the other fluid has a margin, too.
        let path = water.leak_path.as_ref().expect("a way to the gas");
        assert!((path.margin - LOAD).abs() <= 1e-8, "{}", path.margin);
    }
    assert_eq!(ends[0][0].blow_off, ends[1][0].blow_off);
}

#[test]
fn fluids_that_begin_at_one_place_are_refused_with_the_names_of_both() {
    let mut scene = with_gas(1);
    scene.fluids[1].from = vec!["start".to_owned()];
    let error = signorini::Plan::new(&scene, &[], &sole()).expect_err("refused");
    let refused = error.to_string();
    assert!(
        refused.contains("fluid.gas.from") && refused.contains("`water`"),
        "{refused}"
    );
}

#[test]
fn a_body_that_begins_inside_its_obstacle_leaks_at_the_pressure_of_its_contact() {
    let mut scene = jack(Lid::Travel);
    scene.supports.pop();
    scene.supports.push(support("y1", [None, Some(0.0), None]));
    scene.obstacles[0].shape = plane([0.0, 0.02, 0.0], [0.0, 1.0, 0.0]);
    let mut dry = scene.clone();
    dry.fluids.clear();
    let at_rest = solve(&dry, &[Step::default()], &block());
    let pressed = last(&at_rest).obstacles["ground"].force[1];
    let up = raised(FluidLoad::ToBlowOff(10.0 * pressed));
    for steps in [vec![up.clone()], vec![Step::default(), up]] {
        let [water, _] = blown_off(&scene, &steps, &block());
        let [tight, leaks] = water.blow_off.expect("a bracket");
        let holds = tight <= pressed * (1.0 + 1e-6) && pressed <= leaks * (1.0 + 1e-6);
        assert!(
            holds && leaks - tight <= 0.01 * leaks,
            "{pressed}: {tight} {leaks}"
        );
    }
}
