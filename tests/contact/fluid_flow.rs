//! What flows through open gaps beside a body, against closed forms of Reynolds' equation.

use crate::common::meshes::{mesh, unit_grid};
use crate::common::scenes::{elastic, obstacle, plane, rubber, support};
use crate::common::{close, solve};
use signorini::report::{StepReport, Tightness};
use signorini::scene::{Fluid, FluidLoad, RubberModel};
use signorini::{Cause, Scene, Step, Termination};

use super::fluids::{last, raised};

const VISCOSITY: f64 = 2.0;

/// A block that is held above a floor that falls away from it: a gap of .1 to .2, without contact.
fn above_a_floor(mut scene: Scene) -> Scene {
    scene.supports = vec![support("y1", [Some(0.0), Some(0.0), None])];
    let normal = [0.1, 1.0, 0.0];
    scene.obstacles = vec![obstacle("floor", "y0", plane([0.0, -0.1, 0.0], normal))];
    scene.fluids = vec![Fluid {
        name: "water".to_owned(),
        on: vec!["y0".to_owned()],
        from: vec!["x0".to_owned()],
        dry: vec!["x1".to_owned()],
        viscosity: Some(VISCOSITY),
        ..Fluid::default()
    }];
    scene
}

/// Of gaps from g to h over a length of one: 2 (g h)^2 / (12 eta (g + h)).
fn wedge([g, h]: [f64; 2]) -> f64 {
    2.0 * (g * h).powi(2) / (12.0 * VISCOSITY * (g + h))
}

/// The ends of the gap, normal to the floor.
fn gaps() -> [f64; 2] {
    [0.1, 0.2].map(|y| y / 1.01_f64.sqrt())
}

fn flow(reports: &[StepReport]) -> [f64; 2] {
    let water = &last(reports).fluids["water"];
    [water.conductance, water.flow_rate].map(|one| one.expect("a viscosity"))
}

#[test]
fn a_wedge_under_a_body_lets_through_its_closed_form() {
    let scene = above_a_floor(elastic(0.3));
    let reports = solve(&scene, &[Step::default()], &mesh(unit_grid(6, 4)));
    let [conductance, rate] = flow(&reports);
    let exact = wedge(gaps());
    assert!(close(conductance, exact, 1e-9), "{conductance}");
    assert!(rate == 0.0, "{rate}");
}

#[test]
fn a_fluid_that_finds_an_open_way_leaks_at_once_and_tells_how_much_flows() {
    let scene = above_a_floor(rubber(
        RubberModel::NeoHookean { shear_modulus: 1e6 },
        Some(1e7),
    ));
    let reports = solve(
        &scene,
        &[Step::default(), raised(FluidLoad::To(3.0))],
        &mesh(unit_grid(6, 4)),
    );
    let report = last(&reports);
    assert_eq!(report.termination, Termination::NotConverged);
    assert_eq!(report.cause, Some(Cause::Leaks));
    let water = &report.fluids["water"];
    assert_eq!(water.tightness, Tightness::Leaks);
    let [conductance, rate] = flow(&reports);
    let exact = wedge(gaps());
    assert!(close(conductance, exact, 1e-5), "{conductance} {exact}");
    let [low, high] = water.blow_off.expect("a bracket");
    assert!(low == 0.0 && close(high, 3.0, 1e-12), "{low} {high}");
    assert!(water.rounds <= 2, "{}", water.rounds);
    assert!(close(rate, conductance * high, 1e-12), "{rate} {high}");
}

#[test]
fn a_closed_seal_lets_nothing_through_and_without_a_viscosity_nothing_is_told() {
    let mut scene = above_a_floor(elastic(0.3));
    scene.obstacles = vec![obstacle("floor", "y0", plane([0.0; 3], [0.0, 1.0, 0.0]))];
    scene.supports = vec![support("y1", [Some(0.0), Some(-0.05), None])];
    let grid = mesh(unit_grid(6, 4));
    let reports = solve(&scene, &[Step::default()], &grid);
    assert!(flow(&reports).iter().all(|one| *one == 0.0));
    scene.fluids[0].viscosity = None;
    let reports = solve(&scene, &[Step::default()], &grid);
    let water = &last(&reports).fluids["water"];
    assert_eq!((water.conductance, water.flow_rate), (None, None));
}

#[test]
fn a_viscosity_that_is_not_above_zero_is_refused_by_its_key() {
    for viscosity in [0.0, -1.0, f64::NAN] {
        let mut scene = above_a_floor(elastic(0.3));
        scene.fluids[0].viscosity = Some(viscosity);
        let grid = mesh(unit_grid(2, 2));
        let error = signorini::Plan::new(&scene, &[], &grid).expect_err("refused");
        let text = error.to_string();
        assert!(text.contains("fluid.water.viscosity"), "{text}");
    }
}

#[test]
fn a_leak_through_contact_that_is_not_open_yet_has_no_rate() {
    let mut scene = above_a_floor(rubber(
        RubberModel::NeoHookean { shear_modulus: 1.0 },
        Some(10.0),
    ));
    scene.obstacles = vec![obstacle("floor", "y0", plane([0.0; 3], [0.0, 1.0, 0.0]))];
    scene.supports = vec![
        support("x1", [Some(0.0), None, None]),
        support("x0", [Some(0.0), None, None]),
        support("y1", [None, Some(-0.05), None]),
    ];
    let steps = [Step::default(), raised(FluidLoad::ToBlowOff(20.0))];
    let reports = solve(&scene, &steps, &mesh(unit_grid(6, 4)));
    let water = &last(&reports).fluids["water"];
    assert_eq!(water.tightness, Tightness::Leaks);
    assert_eq!((water.conductance, water.flow_rate), (None, None));
    let tight = &reports[0].fluids["water"];
    assert!(tight.conductance == Some(0.0));
}
