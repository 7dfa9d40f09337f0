//! Fluids between soft bodies.
//!
//! Exact: a block between rollers bears its load evenly on another one, whatever their meshes, and a
//! fluid enters between them from one end as soon as its pressure is above that; what a fluid presses on from all
//! sides is under its pressure everywhere; a body on its mirror image is the body on a rigid plane.

use std::sync::Arc;

use super::scenes::{between, joined, linear_of, rubber};
use crate::common::meshes::{mesh, moved, unit_box, unit_grid, with_group};
use crate::common::scenes::{HELD_IN_PLANE, in_parts, obstacle, plane, pull, support, traction};
use crate::common::{assert_converged, close, run, solve, take, values};
use signorini::report::Tightness;
use signorini::scene::{Fluid, FluidLoad, FluidTarget, FluidThreshold, SceneKind, SupportTarget};
use signorini::{Cause, FieldName, Mesh, MeshParts, Scene, Step, StepReport, Termination};

/// Load on the lid.
const LOAD: f64 = 0.5;

pub(crate) fn fluid(on: &[&str], from: &[&str], dry: &[&str]) -> Fluid {
    let names = |all: &[&str]| all.iter().map(|name| (*name).to_owned()).collect();
    Fluid {
        name: "water".to_owned(),
        on: names(on),
        from: names(from),
        dry: names(dry),
        ..Fluid::default()
    }
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

/// A block `a_` of those cells below one `b_`, each of unit height.
fn stacked(counts: [usize; 2]) -> MeshParts {
    let [low, up] = counts.map(|count| unit_grid(count, count));
    joined(&[("a_", low), ("b_", moved(up, |[x, y, z]| [x, y + 1.0, z]))])
}

/// Which block carries the pressure of the contact.
const CARRIERS: [[&str; 2]; 2] = [["b_y0", "a_y1"], ["a_y1", "b_y0"]];

/// Two blocks between rollers, under a load on the upper one, with water at one end between them.
fn jack(carries: [&str; 2]) -> Scene {
    let side = |name: &str| support(name, [Some(0.0), None, None]);
    Scene {
        supports: vec![
            support("a_y0", [None, Some(0.0), None]),
            side("a_x0"),
            side("a_x1"),
            side("b_x0"),
            side("b_x1"),
        ],
        tractions: vec![traction("b_y1", [0.0, -LOAD, 0.0])],
        contacts: between(carries[0], carries[1]),
        fluids: vec![fluid(
            &["a_y1", "b_y0"],
            &["a_start", "b_start"],
            &["a_x1", "b_x1"],
        )],
        ..rubber([("a_body", 1.0), ("b_body", 2.0)], None)
    }
}

/// The blocks of the jack: water begins on the first eighth or sixth.
fn jack_blocks(counts: [usize; 2]) -> Arc<Mesh> {
    let parts = stacked(counts);
    let parts = with_group(parts, "a_y1", "a_start", |x| x[0] < 1.0 / counts[0] as f64);
    let parts = with_group(parts, "b_y0", "b_start", |x| x[0] < 1.0 / counts[1] as f64);
    mesh(parts)
}

#[test]
fn a_fluid_below_the_contact_pressure_stays_where_it_is() {
    for carries in CARRIERS {
        let steps = [Step::default(), raised(FluidLoad::To(0.9 * LOAD))];
        let reports = solve(&jack(carries), &steps, &jack_blocks([8, 8]));
        reports.iter().for_each(assert_converged);
        let water = &last(&reports).fluids["water"];
        assert_eq!(water.tightness, Tightness::Tight);
        let path = water.leak_path.as_ref().expect("a way to the dry end");
        assert!(close(path.margin, LOAD, 1e-8), "{}", path.margin);
        // On either block the first facet and, falling to zero over it, a third of the next.
        let expected = 2.0 * (0.125 + 0.125 / 3.0);
        assert!(close(water.wet_area, expected, 1e-9), "{}", water.wet_area);
        assert!(close(water.leak_paths["pair"].margin, LOAD, 1e-8));
        let contact = last(&reports).contacts["pair"].force[1].abs();
        assert!(close(contact + 0.9 * LOAD * 0.5 * expected, LOAD, 1e-8));
    }
}

#[test]
fn a_jack_lifts_one_body_off_another_at_the_pressure_of_its_load() {
    for (carries, counts) in [(CARRIERS[0], [8, 8]), (CARRIERS[1], [8, 8])] {
        let mut scene = jack(carries);
        scene.fluids[0].blow_off_tolerance = 1e-5;
        let steps = [Step::default(), raised(FluidLoad::ToBlowOff(3.0 * LOAD))];
        let reports = solve(&scene, &steps, &jack_blocks(counts));
        reports.iter().for_each(assert_converged);
        let water = &last(&reports).fluids["water"];
        assert_eq!(water.tightness, Tightness::Leaks);
        let [tight, leaks] = water.blow_off.expect("a bracket");
        assert!(
            tight <= LOAD * (1.0 + 1e-9) && LOAD <= leaks,
            "{tight} {leaks}"
        );
        assert!(leaks - tight <= 1e-5 * leaks, "{tight} {leaks}");
    }
}

/// Meshes that do not match wet a little more of one block than of the other beside the front.
#[test]
fn a_jack_lifts_blocks_whose_meshes_do_not_match() {
    for carries in CARRIERS {
        for counts in [[6, 9], [9, 6]] {
            let steps = [Step::default(), raised(FluidLoad::ToBlowOff(3.0 * LOAD))];
            let reports = solve(&jack(carries), &steps, &jack_blocks(counts));
            reports.iter().for_each(assert_converged);
            let water = &last(&reports).fluids["water"];
            assert_eq!(water.tightness, Tightness::Leaks);
            let [tight, leaks] = water.blow_off.expect("a bracket");
            assert!(
                0.95 * LOAD < tight && leaks < 1.05 * LOAD,
                "{tight} {leaks}"
            );
        }
    }
}

#[test]
fn a_fluid_that_is_through_leaks() {
    let steps = [Step::default(), raised(FluidLoad::To(2.0 * LOAD))];
    let reports = solve(&jack(CARRIERS[0]), &steps, &jack_blocks([8, 8]));
    let end = last(&reports);
    let told = (end.termination, end.cause);
    assert_eq!(told, (Termination::NotConverged, Some(Cause::Leaks)));
    let [tight, leaks] = end.fluids["water"].blow_off.expect("a bracket");
    assert!(tight <= LOAD * (1.0 + 1e-9) && LOAD <= leaks && leaks - tight <= 0.01 * leaks);
}

/// Two blocks in water from above and from the right, rollers below and on the left.
fn drowned(on: &[&str], law: Scene) -> Scene {
    let side = |name: &str| support(name, [Some(0.0), None, None]);
    Scene {
        supports: vec![
            support("a_y0", [None, Some(0.0), None]),
            side("a_x0"),
            side("b_x0"),
        ],
        contacts: between("b_y0", "a_y1"),
        fluids: vec![fluid(on, &["a_x1", "b_x1", "b_y1"], &[])],
        ..law
    }
}

/// Largest difference of displacements from `strain` times the place.
fn beyond(strain: f64, mesh: &Mesh, displacement: &[f64]) -> f64 {
    let places = crate::common::node_positions(mesh);
    let pairs = places.iter().zip(displacement.chunks(3));
    let apart = pairs.flat_map(|(x, u)| [0, 1].map(|i| (u[i] - strain * x[i]).abs()));
    apart.fold(0.0, f64::max)
}

#[test]
fn blocks_in_water_are_under_its_pressure_everywhere() {
    let pressure = 0.4;
    // Plane strain: strain = - (1 - 2 nu) p / 2 mu.
    let laws = [(0.3, -0.2 * pressure), (0.5, 0.0)];
    let wet = ["a_x1", "b_x1", "b_y1", "a_y1", "b_y0"];
    let bodies = |poisson_ratio| linear_of(poisson_ratio, [("a_body", 1.0), ("b_body", 1.0)]);
    let closed = FluidThreshold::Pressure(0.0);
    for (poisson_ratio, strain) in laws {
        // The water may get between them or not; where it must not it may do so with any meshes.
        for (on, counts, threshold) in [
            (&wet[..3], [5, 7], closed),
            (&wet[..], [6, 6], closed),
            (&wet[..], [6, 6], FluidThreshold::Fluid),
        ] {
            let mut scene = drowned(on, bodies(poisson_ratio));
            scene.fluids[0].threshold = threshold;
            scene.solver.tolerance = 1e-11;
            let mesh = mesh(stacked(counts));
            let (session, reports) = run(&scene, &[raised(FluidLoad::To(pressure))], &mesh);
            reports.iter().for_each(assert_converged);
            let apart = beyond(strain, &mesh, &values(&session, FieldName::Displacement));
            assert!(apart <= 1e-9, "{poisson_ratio} {counts:?} {apart}");
        }
    }
}

#[test]
fn incompressible_rubber_in_water_keeps_its_shape() {
    let law = rubber([("a_body", 1.0), ("b_body", 3.0)], None);
    let mut scene = drowned(&["a_x1", "b_x1", "b_y1", "a_y1", "b_y0"], law);
    scene.solver.tolerance = 1e-11;
    let mesh = mesh(stacked([6, 6]));
    let (session, reports) = run(&scene, &[raised(FluidLoad::To(2.0))], &mesh);
    reports.iter().for_each(assert_converged);
    let apart = beyond(0.0, &mesh, &values(&session, FieldName::Displacement));
    assert!(apart <= 1e-8, "{apart}");
}

/// A fluid beside blocks that part gets between them: each is under its pressure on all sides.
#[test]
fn a_fluid_fills_the_gap_between_blocks_that_part() {
    let pressure = 0.3;
    for carries in CARRIERS {
        for counts in [[6, 6], [5, 8]] {
            let law = rubber([("a_body", 1.0), ("b_body", 1.0)], None);
            let mut scene = drowned(&["a_x1", "b_x1", "a_y1", "b_y0"], law);
            scene.contacts = between(carries[0], carries[1]);
            scene.fluids[0].from = vec!["a_x1".to_owned()];
            scene
                .supports
                .push(support("b_y1", [None, Some(-0.1), None]));
            scene.solver.tolerance = 1e-10;
            let mut wetting = raised(FluidLoad::To(pressure));
            wetting.supports = pull("b_y1", [None, Some(-0.1), None], 1).supports;
            let steps = [wetting, pull("b_y1", [None, Some(0.02), None], 2)];
            let mesh = mesh(stacked(counts));
            let (session, reports) = run(&scene, &steps, &mesh);
            reports.iter().for_each(assert_converged);
            let end = last(&reports);
            let water = &end.fluids["water"];
            // Both sides and both surfaces between.
            assert!(close(water.wet_area, 4.0, 1e-8), "{}", water.wet_area);
            assert!(end.contacts["pair"].force[1].abs() <= 1e-8);
            let moved = values(&session, FieldName::Displacement);
            let places = crate::common::node_positions(&mesh);
            for (x, u) in places.iter().zip(moved.chunks(3)) {
                let up = if x[1] > 1.0 { 0.02 } else { 0.0 };
                let up = if (x[1] - 1.0).abs() < 1e-12 { u[1] } else { up };
                assert!(u[0].abs() + (u[1] - up).abs() <= 1e-7, "{x:?} {u:?}");
            }
        }
    }
}

/// A block with a round sole, its crest at x = 0, and the water's side at x = 1.
fn crowned(counts: [usize; 2]) -> MeshParts {
    moved(unit_grid(counts[0], counts[1]), |[x, y, z]| {
        let rise = 0.2 * x * x;
        [x, rise + (1.0 - rise) * y, z]
    })
}

/// A block in water on its mirror image, water beginning at `from`, and the block on a rigid plane;
/// each is pressed by `way`.
pub(super) fn mirrored(
    upper: MeshParts,
    (from, pressure): (&[&str], f64),
    way: f64,
) -> [StepReport; 2] {
    let mut lower = moved(upper.clone(), |[x, y, z]| [x, -y, z]);
    lower.cells.chunks_mut(3).for_each(|cell| cell.swap(1, 2));
    let pair_mesh = mesh(joined(&[("up_", upper.clone()), ("low_", lower)]));
    let alone_mesh = mesh(joined(&[("up_", upper)]));
    let held = |name: &str| {
        let side = support(&format!("{name}x0"), [Some(0.0), None, None]);
        [support(&format!("{name}y1"), HELD_IN_PLANE), side]
    };
    let mut pair = rubber([("up_body", 1.0), ("low_body", 1.0)], Some(20.0));
    pair.solver.tolerance = 1e-11;
    let mut alone = pair.clone();
    pair.supports = ["up_", "low_"].into_iter().flat_map(held).collect();
    pair.contacts = between("up_y0", "low_y0");
    let on = ["up_y0", "low_y0", "up_x1", "low_x1"];
    pair.fluids = vec![fluid(&on, from, &["up_x0"])];
    alone.materials.truncate(1);
    alone.supports = held("up_").into();
    alone.obstacles = vec![obstacle("floor", "up_y0", plane([0.0; 3], [0.0, 1.0, 0.0]))];
    alone.fluids = vec![fluid(&["up_y0"], &["up_x1"], &["up_x0"])];
    let target = |name: &str, way: f64| SupportTarget {
        name: name.to_owned(),
        displacement: [Some(0.0), Some(way), None],
        ..SupportTarget::default()
    };
    let up = in_parts(raised(FluidLoad::To(pressure)), 2);
    let mut press = raised(FluidLoad::To(0.0));
    press.supports = vec![target("up_y1", -way), target("low_y1", way)];
    let pair = solve(&pair, &[press.clone(), up.clone()], &pair_mesh);
    press.supports.truncate(1);
    let alone = solve(&alone, &[press, up], &alone_mesh);
    pair.iter().chain(&alone).for_each(assert_converged);
    [last(&pair).clone(), last(&alone).clone()]
}

/// Fails unless a pair is twice what its half is.
fn assert_mirrors([pair, alone]: &[StepReport; 2], relative: f64) {
    let [own, one] = [pair, alone].map(|report| &report.fluids["water"]);
    let [force, expected] = [
        pair.contacts["pair"].force[1],
        alone.obstacles["floor"].force[1],
    ];
    assert!(close(own.wet_area, 2.0 * one.wet_area, relative));
    assert!(close(own.force[0], 2.0 * one.force[0], relative));
    assert!(own.force[1].abs() <= relative);
    assert!(close(force, expected, relative), "{force} {expected}");
    assert!(close(
        pair.strain_energy,
        2.0 * alone.strain_energy,
        relative
    ));
    let [own, one] = [own, one].map(|water| water.leak_path.as_ref().expect("a way"));
    assert!(close(own.margin, one.margin, relative));
    assert!(close(own.sealed_width, one.sealed_width, relative));
}

/// Where water begins: on both bodies, or on one of them, from which it gets to the other.
pub(super) const BEGINS: [&[&str]; 3] = [&["up_x1", "low_x1"], &["up_x1"], &["low_x1"]];

#[test]
fn a_block_in_water_on_its_mirror_image_is_the_block_on_a_rigid_plane() {
    let ends = mirrored(unit_grid(6, 4), (BEGINS[0], 0.1), 0.1);
    assert_mirrors(&ends, 1e-9);
}

/// Water that begins on one body alone reaches the other one in the first round, when their corners are
/// not yet opposite. Between open surfaces gaps of a tool are along its normal, gaps of bodies along theirs.
#[test]
fn water_comes_as_far_between_mirror_images_as_under_a_rigid_plane() {
    let ends = mirrored(unit_grid(6, 4), (BEGINS[1], 0.1), 0.1);
    assert_mirrors(&ends, 1e-4);
    for from in BEGINS {
        let ends = mirrored(crowned([12, 6]), (from, 0.3), 0.12);
        assert!(ends[1].fluids["water"].wet_area > 1.1);
        assert_mirrors(&ends, 5e-3);
    }
}

/// A crowned block on a flat one, whose meshes do not match, in water on one side.
pub(super) fn unlike(carries: [&str; 2]) -> (Scene, Arc<Mesh>) {
    let side = |name: &str| support(name, [Some(0.0), None, None]);
    let mut scene = rubber([("up_body", 1.0), ("low_body", 2.0)], Some(20.0));
    scene.supports = vec![
        support("up_y1", HELD_IN_PLANE),
        side("up_x0"),
        support("low_y0", HELD_IN_PLANE),
        side("low_x0"),
    ];
    scene.contacts = between(carries[0], carries[1]);
    let on = ["up_y0", "low_y1", "up_x1", "low_x1"];
    scene.fluids = vec![fluid(&on, &["up_x1"], &["up_x0", "low_x0"])];
    let lower = moved(unit_grid(17, 6), |[x, y, z]| [1.2 * x, y - 1.0, z]);
    (
        scene,
        mesh(joined(&[("up_", crowned([12, 6])), ("low_", lower)])),
    )
}

#[test]
fn forces_balance_and_either_body_may_carry() {
    let ends = [["up_y0", "low_y1"], ["low_y1", "up_y0"]].map(|carries| {
        let (mut scene, mesh) = unlike(carries);
        scene.solver.tolerance = 1e-11;
        let press = pull("up_y1", [Some(0.0), Some(-0.12), None], 1);
        let (session, reports) = run(&scene, &[press, raised(FluidLoad::To(0.25))], &mesh);
        reports.iter().for_each(assert_converged);
        let end = last(&reports).clone();
        let reactions = values(&session, FieldName::NodalForce);
        let sum = |i: usize| reactions.chunks(3).map(|r| r[i]).sum::<f64>();
        let force = end.fluids["water"].force;
        for (i, force) in [0, 1].map(|i: usize| (i, force[i])) {
            assert!((sum(i) + force).abs() <= 1e-9, "{i}: {} {force}", sum(i));
        }
        end
    });
    let [a, b] = ends.each_ref().map(|end| &end.fluids["water"]);
    assert!(
        close(a.wet_area, b.wet_area, 0.03),
        "{} {}",
        a.wet_area,
        b.wet_area
    );
    let [a, b] = ends
        .each_ref()
        .map(|end| end.contacts["pair"].force[1].abs());
    assert!(close(a, b, 0.05), "{a} {b}");
}

#[test]
fn a_saved_state_goes_on_with_the_same_bits() {
    let (scene, mesh) = unlike(["up_y0", "low_y1"]);
    let press = pull("up_y1", [Some(0.0), Some(-0.12), None], 1);
    let half = raised(FluidLoad::To(0.15));
    let whole = raised(FluidLoad::To(0.25));
    let (mut session, _) = run(&scene, &[press, half], &mesh);
    let saved = session.export();
    take(&mut session, &whole);
    let end = session.export();
    session.restore(&saved).expect("its own bytes");
    take(&mut session, &whole);
    assert_eq!(session.export(), end);
}

#[test]
fn blocks_about_an_axis_and_in_space_part_as_in_the_plane() {
    let ring = |parts: MeshParts| moved(parts, |[x, y, z]| [1.0 + x, y, z]);
    let mut about = jack(CARRIERS[0]);
    about.kind = Some(SceneKind::Axisymmetric);
    let rings = {
        let parts = ring(stacked([6, 6]));
        let parts = with_group(parts, "a_y1", "a_start", |x| x[0] < 1.0 + 1.0 / 6.0);
        mesh(with_group(parts, "b_y0", "b_start", |x| {
            x[0] < 1.0 + 1.0 / 6.0
        }))
    };
    let mut space = jack(CARRIERS[0]);
    for name in ["a_z0", "a_z1", "b_z0", "b_z1"] {
        space.supports.push(support(name, [None, None, Some(0.0)]));
    }
    let blocks = {
        let own = || moved(unit_box([4, 1, 2]), |[x, y, z]| [x, y, 0.5 * z]);
        let up = moved(own(), |[x, y, z]| [x, y + 1.0, z]);
        let parts = joined(&[("a_", own()), ("b_", up)]);
        let parts = with_group(parts, "a_y1", "a_start", |x| x[0] < 0.25);
        mesh(with_group(parts, "b_y0", "b_start", |x| x[0] < 0.25))
    };
    for (scene, mesh) in [(about, rings), (space, blocks)] {
        let steps = [Step::default(), raised(FluidLoad::ToBlowOff(3.0 * LOAD))];
        let reports = solve(&scene, &steps, &mesh);
        reports.iter().for_each(assert_converged);
        let [tight, leaks] = last(&reports).fluids["water"].blow_off.expect("a bracket");
        assert!(
            tight <= LOAD * (1.0 + 1e-9) && LOAD <= leaks,
            "{tight} {leaks}"
        );
        assert!(leaks - tight <= 0.01 * leaks, "{tight} {leaks}");
    }
}

#[test]
fn what_is_not_solved_or_half_named_is_told() {
    use signorini::Plan;
    use signorini::scene::SceneError;
    let told = |scene: &Scene| {
        let error = Plan::new(scene, &[], &jack_blocks([8, 8])).expect_err("a fault");
        match error {
            SceneError::Invalid(all) => all.into_iter().next().expect("a fault"),
            SceneError::Unsupported(one) => one,
        }
    };
    let mut scene = jack(CARRIERS[0]);
    scene.fluids[0].on = vec!["a_y1".to_owned()];
    scene.fluids[0].from = vec!["a_start".to_owned()];
    let fault = told(&scene);
    assert_eq!(fault.path, "fluid.water.on");
    assert!(
        fault
            .message
            .contains("one surface of contact `pair` alone")
    );
    let mut scene = jack(CARRIERS[0]);
    scene.fluids[0].viscosity = Some(1.0);
    let fault = told(&scene);
    assert_eq!(fault.path, "fluid.water.viscosity");
    assert!(fault.message.contains("between bodies is not solved yet"));
}
