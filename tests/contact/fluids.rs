//! Fluids that creep in between a body and its obstacles.
//!
//! Exact: between rollers a block bears its load evenly; a fluid enters from one end as soon as its
//! pressure is above that of the contact.

use std::sync::Arc;

use crate::common::meshes::{mesh, moved, unit_grid, with_group};
use crate::common::scenes::{
    elastic, in_parts, mooney_rivlin, obstacle, plane, probe, push, rubber, support, traction,
};
use crate::common::{assert_converged, close, run, solve, take};
use signorini::report::{ObstacleResult, StepReport, Tightness};
use signorini::scene::{Fluid, FluidLoad, FluidTarget, FluidThreshold, RubberModel, Shape};
use signorini::{Cause, Mesh, MeshParts, Scene, Step, Termination};

/// Load on the lid.
pub(super) const LOAD: f64 = 0.5;

/// The unit square with the first eighth of its sole as group `start`.
pub(super) fn block() -> Arc<Mesh> {
    mesh(with_group(unit_grid(8, 8), "y0", "start", |x| x[0] < 0.125))
}

/// A block between rollers on a plane, under a load on its lid, with water at one end of its sole.
pub(super) fn jack(lid: Lid) -> Scene {
    let model = RubberModel::NeoHookean { shear_modulus: 1.0 };
    let mut scene = match lid {
        Lid::Load => rubber(model, None),
        Lid::Travel => rubber(model, Some(10.0)),
    };
    scene.supports = ["x0", "x1"]
        .map(|side| support(side, [Some(0.0), None, None]))
        .to_vec();
    match lid {
        Lid::Load => scene.tractions = vec![traction("y1", [0.0, -LOAD, 0.0])],
        Lid::Travel => scene
            .supports
            .push(support("y1", [None, Some(-0.05), None])),
    }
    scene.obstacles = vec![obstacle("ground", "y0", plane([0.0; 3], [0.0, 1.0, 0.0]))];
    scene.fluids = vec![Fluid {
        name: "water".to_owned(),
        on: vec!["y0".to_owned()],
        from: vec!["start".to_owned()],
        dry: vec!["x1".to_owned()],
        ..Fluid::default()
    }];
    scene
}

#[derive(Clone, Copy)]
pub(super) enum Lid {
    Load,
    Travel,
}

pub(super) fn raised(load: FluidLoad) -> Step {
    Step {
        fluids: vec![FluidTarget {
            name: "water".to_owned(),
            load,
        }],
        ..Step::default()
    }
}

pub(super) fn last(reports: &[StepReport]) -> &StepReport {
    reports.last().expect("an increment")
}

#[test]
fn a_fluid_below_the_contact_pressure_moves_nothing() {
    let steps = [Step::default(), raised(FluidLoad::To(0.9 * LOAD))];
    let reports = solve(&jack(Lid::Load), &steps, &block());
    reports.iter().for_each(assert_converged);
    let water = &last(&reports).fluids["water"];
    assert_eq!(water.tightness, Tightness::Tight);
    let path = water.leak_path.as_ref().expect("a way to the dry end");
    assert!(close(path.margin, LOAD, 1e-8), "{}", path.margin);
    // The first facet and, falling to zero over it, half of the next.
    assert!(
        close(water.wet_area, 0.125 + 0.125 / 3.0, 1e-12),
        "{}",
        water.wet_area
    );
    let ground = &last(&reports).obstacles["ground"];
    let sum = ground.force[1] + water.force[1];
    assert!(close(sum, LOAD, 1e-8), "{sum}");
}

/// Whether a seal that holds at `pressure` does so only up to `blow_off`, to the tolerance of equilibrium.
fn is_tight_at(pressure: f64, blow_off: f64) -> bool {
    pressure <= blow_off * (1.0 + 1e-9)
}

#[test]
fn a_jack_lifts_at_the_pressure_of_its_load() {
    let mut scene = jack(Lid::Load);
    scene.fluids[0].blow_off_tolerance = 1e-6;
    let steps = [Step::default(), raised(FluidLoad::ToBlowOff(3.0 * LOAD))];
    let reports = solve(&scene, &steps, &block());
    reports.iter().for_each(assert_converged);
    let water = &last(&reports).fluids["water"];
    assert_eq!(water.tightness, Tightness::Leaks);
    let [tight, leaks] = water.blow_off.expect("a bracket");
    assert!(is_tight_at(tight, LOAD) && LOAD <= leaks, "{tight} {leaks}");
    assert!(leaks - tight <= 1e-6 * leaks, "{tight} {leaks}");
}

#[test]
fn a_step_to_blow_off_ends_in_the_increment_that_leaks() {
    let up = raised(FluidLoad::ToBlowOff(3.0 * LOAD));
    let (mut session, reports) = run(
        &jack(Lid::Load),
        &[Step::default(), in_parts(up, 8)],
        &block(),
    );
    reports.iter().for_each(assert_converged);
    // Tight at three and six eighths of the load, leaking at nine.
    let ends: Vec<bool> = reports.iter().map(|one| one.ends_step(8)).collect();
    assert_eq!(ends, [false, false, false, true]);
    // The next step starts from there.
    let lower = take(&mut session, &raised(FluidLoad::To(0.5 * LOAD)));
    assert_converged(last(&lower));
    assert_eq!(last(&lower).fluids["water"].tightness, Tightness::Tight);
}

#[test]
fn a_step_that_leaks_ends_at_the_last_tight_state() {
    let steps = [Step::default(), raised(FluidLoad::To(2.0 * LOAD))];
    let reports = solve(&jack(Lid::Load), &steps, &block());
    let end = last(&reports);
    assert_eq!(
        (end.termination, end.cause),
        (Termination::NotConverged, Some(Cause::Leaks))
    );
    let [tight, leaks] = end.fluids["water"].blow_off.expect("a bracket");
    assert!(is_tight_at(tight, LOAD) && LOAD <= leaks && leaks - tight <= 0.01 * leaks);
    assert!(close(end.fluids["water"].pressure, tight, 1e-12));
    assert!(end.residuals.largest() <= end.tolerance);
}

#[test]
fn a_held_lid_bears_whatever_the_fluid_presses() {
    let mut scene = jack(Lid::Travel);
    scene.fluids[0].dry.clear();
    let mut dry = scene.clone();
    dry.fluids.clear();
    let at_rest = solve(&dry, &[Step::default()], &block());
    let pressed = last(&at_rest).obstacles["ground"].force[1];
    let steps = [Step::default(), raised(FluidLoad::To(2.0 * pressed))];
    let reports = solve(&scene, &steps, &block());
    reports.iter().for_each(assert_converged);
    let (end, water) = (last(&reports), &last(&reports).fluids["water"]);
    // All of the sole is wet, and the fluid alone carries the block.
    assert!(close(water.wet_area, 1.0, 1e-12), "{}", water.wet_area);
    assert!(close(water.force[1], 2.0 * pressed, 1e-9));
    assert!(end.obstacles["ground"].force[1].abs() <= 1e-8 * pressed);
}

#[test]
fn with_a_threshold_of_zero_closed_contact_stays_dry() {
    let mut scene = jack(Lid::Travel);
    // Contact presses .571: by its own pressure a fluid of .8 enters it.
    let steps = [Step::default(), raised(FluidLoad::To(0.8))];
    let ends = [FluidThreshold::Fluid, FluidThreshold::Pressure(0.0)].map(|threshold| {
        scene.fluids[0].threshold = threshold;
        last(&solve(&scene, &steps, &block())).fluids["water"].tightness
    });
    assert_eq!(ends, [Tightness::Leaks, Tightness::Tight]);
}

/// Half a wave of length one on a block of depth one, its crest at x = 0, finer towards the top, with
/// the last facet of the valley as group `valley`.
pub(super) fn wave(height: f64, count: usize) -> Arc<Mesh> {
    mesh(wave_parts(height, count))
}

/// Its arrays.
pub(super) fn wave_parts(height: f64, count: usize) -> MeshParts {
    let last = 1.0 - 1.0 / count as f64;
    let parts = with_group(unit_grid(count, count), "y1", "valley", |x| x[0] > last);
    moved(parts, |[x, y, z]| {
        let up = 1.0 - (1.0 - y) * (1.0 - y);
        let crest = 0.5 * height * (1.0 + (std::f64::consts::PI * x).cos());
        [0.5 * x, up + up * crest, z]
    })
}

/// The wave on rollers under a plate, with water in its valley.
pub(super) fn wavy(height: f64) -> Scene {
    let mut scene = elastic(0.5);
    scene.supports = [("x0", 0), ("x1", 0), ("y0", 1)]
        .map(|(side, axis)| support(side, std::array::from_fn(|i| (i == axis).then_some(0.0))))
        .to_vec();
    let over = plane([0.0, 1.0 + height, 0.0], [0.0, -1.0, 0.0]);
    scene.obstacles = vec![obstacle("plate", "y1", over)];
    scene.fluids = vec![Fluid {
        name: "water".to_owned(),
        on: vec!["y1".to_owned()],
        from: vec!["valley".to_owned()],
        ..Fluid::default()
    }];
    scene
}

/// A step that moves the plate down and sets the pressure of the water.
pub(super) fn plate_down(by: f64, pressure: f64) -> Step {
    Step {
        fluids: raised(FluidLoad::To(pressure)).fluids,
        ..push("plate", [0.0, -by, 0.0])
    }
}

/// E* of plane strain at mu = 1, nu = 1/2.
const MODULUS: f64 = 4.0;

#[test]
fn a_wave_with_wet_valleys_bears_as_westergaard_says_above_the_pressure_of_the_water() {
    let height = 2e-3;
    let closing = std::f64::consts::PI * MODULUS * 0.5 * height;
    let water = 0.3 * closing;
    let mut known = 0.0;
    for travel in [0.1, 0.2, 0.3] {
        let steps = [
            plate_down(travel * height, 0.0),
            plate_down(travel * height, water),
        ];
        let reports = solve(&wavy(height), &steps, &wave(height, 48));
        reports.iter().for_each(assert_converged);
        let (plate, fluid) = (
            &last(&reports).obstacles["plate"],
            &last(&reports).fluids["water"],
        );
        let mean = -(plate.force[1] + fluid.force[1]) / 0.5;
        let share = (mean - water) / closing;
        let expected = share.sqrt().asin() / std::f64::consts::PI;
        let width = plate.contact_width.expect("a plane scene");
        assert!(share > known && share < 1.0, "{share}");
        assert!(
            (width - expected).abs() <= 0.01 * 0.5,
            "{share}: {width} {expected}"
        );
        known = share;
    }
}

#[test]
fn what_the_water_presses_is_added_to_all_pressures() {
    let height = 2e-6;
    let closing = std::f64::consts::PI * MODULUS * 0.5 * height;
    let at = |water: f64| {
        let travel = 0.3 * height;
        let steps = [plate_down(travel, 0.0), plate_down(travel, water)];
        let mut scene = wavy(height);
        scene.solver.tolerance = 1e-11;
        let reports = solve(&scene, &steps, &wave(height, 24));
        reports.iter().for_each(assert_converged);
        let end = last(&reports);
        (end.obstacles["plate"].clone(), end.fluids["water"].wet_area)
    };
    let [(low, low_wet), (high, high_wet)] = [0.2 * closing, 0.5 * closing].map(at);
    assert_eq!(low_wet.to_bits(), high_wet.to_bits());
    let shift = high.peak_pressure - low.peak_pressure - 0.3 * closing;
    // Coordinates of one are rounded to 1e-16: over the height, times (1 / h)^2 for a stress, 3e-8.
    assert!(shift.abs() <= 3e-8 * closing, "{:e}", shift / closing);
    let width = |one: &ObstacleResult| one.contact_width.expect("a plane scene");
    assert!(
        (width(&low) - width(&high)).abs() <= 1e-8,
        "{}",
        width(&low) - width(&high)
    );
}

#[test]
fn a_body_between_walls_and_fluid_hands_its_pressure_on() {
    let mut scene = rubber(mooney_rivlin(), None);
    scene.obstacles = vec![
        obstacle("left", "x0", plane([0.01, 0.0, 0.0], [1.0, 0.0, 0.0])),
        obstacle("right", "x1", plane([0.99, 0.0, 0.0], [-1.0, 0.0, 0.0])),
        obstacle("floor", "y0", plane([0.0; 3], [0.0, 1.0, 0.0])),
    ];
    scene.fluids = vec![Fluid {
        name: "water".to_owned(),
        on: ["x0", "x1", "y0"].map(str::to_owned).to_vec(),
        from: vec!["y1".to_owned()],
        ..Fluid::default()
    }];
    scene.probes = vec![probe("top", [0.5, 1.0, 0.0])];
    let pressures = [0.1, 0.7];
    let steps = pressures.map(|pressure| raised(FluidLoad::To(pressure)));
    let reports = solve(&scene, &steps, &mesh(unit_grid(4, 4)));
    reports.iter().for_each(assert_converged);
    let [low, high] = [&reports[0], &reports[1]];
    for name in ["left", "right", "floor"] {
        let peak = |one: &StepReport| one.obstacles[name].peak_pressure;
        let raised = peak(high) - peak(low);
        assert!(close(raised, 0.6, 1e-8), "{name}: {raised}");
    }
    let up = |one: &StepReport| one.probes["top"].displacement[1];
    assert!((up(high) - up(low)).abs() <= 1e-9, "{}", up(high) - up(low));
}

/// Half of a block, bonded below, under a round tool, in water.
pub(super) fn under_a_roller() -> (Scene, Arc<Mesh>) {
    let mut scene = elastic(0.5);
    scene.supports = vec![
        support("x0", [Some(0.0), None, None]),
        support("y0", [Some(0.0), Some(0.0), None]),
    ];
    let roller = Shape::Cylinder {
        point: [0.0, 2.0, 0.0],
        axis: [0.0, 0.0, 1.0],
        radius: 1.0,
    };
    scene.obstacles = vec![obstacle("roller", "y1", roller)];
    scene.fluids = vec![Fluid {
        name: "water".to_owned(),
        on: vec!["y1".to_owned()],
        from: vec!["start".to_owned()],
        dry: vec!["x0".to_owned()],
        ..Fluid::default()
    }];
    let last = 1.0 - 1.0 / 24.0;
    let fine = with_group(unit_grid(24, 24), "y1", "start", |x| x[0] > last);
    let fine = moved(fine, |[x, y, z]| [x * x, 1.0 - (1.0 - y) * (1.0 - y), z]);
    (scene, mesh(fine))
}

/// Presses the roller .02 deep and raises the water to `pressure` in equal increments.
pub(super) fn rolled(
    (scene, mesh): &(Scene, Arc<Mesh>),
    pressure: f64,
    increments: u32,
) -> StepReport {
    let up = in_parts(raised(FluidLoad::To(pressure)), increments);
    let reports = solve(scene, &[push("roller", [0.0, -0.02, 0.0]), up], mesh);
    reports.iter().for_each(assert_converged);
    last(&reports).clone()
}

#[test]
fn fluids_come_as_far_by_many_increments_as_by_one() {
    let body = under_a_roller();
    let ends = [1, 4, 16].map(|increments| rolled(&body, 0.08, increments));
    for end in &ends[1..] {
        let [own, first] = [end, &ends[0]].map(|one| &one.fluids["water"]);
        assert!(close(own.wet_area, first.wet_area, 1e-12));
        let [own, first] = [end, &ends[0]].map(|one| one.obstacles["roller"].force[1]);
        assert!(close(own, first, 1e-8), "{own} {first}");
    }
    assert!(
        ends[0].fluids["water"].rounds <= 5,
        "{}",
        ends[0].fluids["water"].rounds
    );
}

#[test]
fn a_higher_pressure_comes_further_until_it_is_through() {
    let body = under_a_roller();
    let mut wet = 0.0;
    for pressure in [0.02, 0.04, 0.06, 0.08, 0.10] {
        let end = rolled(&body, pressure, 1);
        let water = &end.fluids["water"];
        let path = water.leak_path.as_ref().expect("a way under the roller");
        assert!(water.wet_area >= wet && path.margin > pressure);
        wet = water.wet_area;
    }
    let up = raised(FluidLoad::ToBlowOff(1.0));
    let (scene, mesh) = &body;
    let reports = solve(scene, &[push("roller", [0.0, -0.02, 0.0]), up], mesh);
    reports.iter().for_each(assert_converged);
    let [tight, leaks] = last(&reports).fluids["water"].blow_off.expect("a bracket");
    assert!(
        0.10 < tight && tight < leaks && leaks < 0.15,
        "{tight} {leaks}"
    );
}
