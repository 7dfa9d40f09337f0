//! Bodies that lose their equilibrium: they fall to the next one, as a real body would, or
//! stop, or go on along saddles, as the scene asks.

use std::f64::consts::PI;
use std::sync::Arc;

use crate::common::meshes::{cube, mesh, moved, square, unit_grid};
use crate::common::scenes::{
    HELD, in_parts, mooney_rivlin, obstacle, plane, pull, push, rollers, rubber, support, traction,
};
use crate::common::{assert_converged, close, run, solve, values};
use signorini::report::{Stability, WarningKind};
use signorini::scene::{Choice, OnInstability, RubberModel, SceneKind, Shape, StabilityCheck};
use signorini::{Cause, FieldName, Mesh, Scene, Step, StepReport, Termination};

/// Height of the column over its width.
const SLENDERNESS: f64 = 8.0;

/// A column of unit width, bent by `bow` in the middle.
fn column(bow: f64) -> Arc<Mesh> {
    mesh(moved(unit_grid(3, 24), |[x, y, _]| {
        let bent = bow * (0.5 - 0.5 * (2.0 * PI * y).cos());
        [x + bent, SLENDERNESS * y, 0.0]
    }))
}

/// The column pressed between clamped ends by that share of its height.
fn pressed(
    mesh: &Arc<Mesh>,
    (share, increments): (f64, u32),
    asked: OnInstability,
) -> Vec<StepReport> {
    let mut scene = clamped();
    scene.solver.on_instability = Choice::Named(asked);
    solve(&scene, &[squeeze(share, increments)], mesh)
}

/// The step that presses the column by that share of its height.
fn squeeze(share: f64, increments: u32) -> Step {
    let end = [Some(0.0), Some(-share * SLENDERNESS), None];
    pull("y1", end, increments)
}

fn clamped() -> Scene {
    clamped_of(None)
}

/// Of rubber with that bulk modulus.
fn clamped_of(bulk: Option<f64>) -> Scene {
    let mut scene = rubber(mooney_rivlin(), bulk);
    scene.kind = Some(SceneKind::PlaneStrain);
    let held = [Some(0.0), Some(0.0), None];
    scene.supports = vec![support("y0", held), support("y1", held)];
    scene
}

/// Force along the column that the upper end exerts.
fn force(report: &StepReport) -> f64 {
    report.supports["y1"].force[1]
}

/// Share of its height at which a clamped column of that slenderness buckles: Euler's load
/// of a beam with shear, 1 / P = L^2 / (4 pi^2 E I) + 6 / (5 mu A), E = 4 mu.
fn euler_share() -> f64 {
    let bending = SLENDERNESS.powi(2) / (4.0 * PI * PI * 4.0 / 12.0);
    1.0 / (bending + 1.2) / 4.0
}

#[test]
fn a_straight_column_is_a_minimum_below_its_euler_load_and_a_saddle_above() {
    let mesh = column(0.0);
    for (share, expected) in [
        (0.8 * euler_share(), Stability::Minimum),
        (1.25 * euler_share(), Stability::Saddle),
        (3.0 * euler_share(), Stability::Saddle),
    ] {
        let reports = pressed(&mesh, (share, 1), OnInstability::Continue);
        assert_converged(&reports[0]);
        assert_eq!(reports[0].stability, Some(expected), "{share}");
        let doubts = reports[0].warnings.iter().map(|warning| warning.kind);
        let is_doubted = doubts
            .collect::<Vec<_>>()
            .contains(&WarningKind::UnstableEquilibrium);
        assert_eq!(is_doubted, expected == Stability::Saddle);
    }
}

#[test]
fn a_straight_column_pressed_far_at_once_falls_to_the_buckled_equilibrium() {
    let mesh = column(0.0);
    let share = 2.0 * euler_share();
    let straight = pressed(&mesh, (share, 1), OnInstability::Continue);
    for increments in [1, 10] {
        let reports = pressed(&mesh, (share, increments), OnInstability::Descend);
        reports.iter().for_each(assert_converged);
        let last = reports.last().expect("an increment");
        assert_eq!(last.stability, Some(Stability::Minimum));
        let fall = reports
            .iter()
            .find_map(|report| report.snapped)
            .expect("a fall");
        assert!(
            fall.energy_drop > 0.0 && fall.largest_motion > 0.1,
            "{fall:?}"
        );
        let middle = 0.5 * SLENDERNESS;
        assert!((fall.point[1] - middle).abs() < 0.2 * middle, "{fall:?}");
        assert!(force(last).abs() < 0.7 * force(&straight[0]).abs());
        assert!(last.strain_energy < straight[0].strain_energy);
    }
}

#[test]
fn a_straight_column_pressed_far_beyond_its_load_comes_to_rest_too() {
    let mesh = column(0.0);
    for (factor, increments) in [(3.0, 1), (5.0, 1), (5.0, 4)] {
        let share = factor * euler_share();
        let reports = pressed(&mesh, (share, increments), OnInstability::Descend);
        reports.iter().for_each(assert_converged);
        let last = reports.last().expect("an increment");
        assert_eq!(last.stability, Some(Stability::Minimum), "{factor}");
    }
}

#[test]
fn a_bent_column_comes_to_one_equilibrium_however_it_is_pressed() {
    let mesh = column(0.02);
    let share = 2.0 * euler_share();
    let ends = [1, 4, 20].map(|increments| {
        let reports = pressed(&mesh, (share, increments), OnInstability::Descend);
        reports.iter().for_each(assert_converged);
        let last = reports.last().expect("an increment").clone();
        assert_eq!(last.stability, Some(Stability::Minimum));
        last
    });
    for other in &ends[1..] {
        assert!(close(force(other), force(&ends[0]), 1e-6));
        assert!(close(other.strain_energy, ends[0].strain_energy, 1e-6));
    }
}

#[test]
fn a_scene_that_asks_for_it_stops_at_the_last_minimum() {
    let mesh = column(0.0);
    let share = 2.0 * euler_share();
    let mut scene = clamped();
    scene.solver.on_instability = Choice::Named(OnInstability::Stop);
    let (session, reports) = run(&scene, &[squeeze(share, 1)], &mesh);
    assert_eq!(reports[0].termination, Termination::NotConverged);
    assert_eq!(reports[0].cause, Some(Cause::UnstableEquilibrium));
    assert_eq!(reports[0].stability, Some(Stability::Minimum));
    assert!((0.3..0.7).contains(&reports[0].time), "{}", reports[0].time);
    let mode = values(&session, FieldName::LowestMode);
    let across = mode.chunks_exact(3).map(|x| x[0].abs()).fold(0.0, f64::max);
    assert!((across - 1.0).abs() < 0.01, "{across}");
    let site = reports[0].cause_site.clone().expect("where it buckles");
    let ([_, height, _], [across, ..]) =
        (site.point.expect("a point"), site.motion.expect("a motion"));
    assert!((0.4..0.6).contains(&(height / SLENDERNESS)), "{site:?}");
    assert!(across.abs() > 0.95, "{site:?}");
}

#[test]
fn an_equilibrium_that_nobody_has_certified_is_said_to_be_not_determined() {
    let mesh = column(0.0);
    let mut scene = clamped();
    scene.solver.stability = Choice::Named(StabilityCheck::Off);
    let step = pull("y1", [Some(0.0), Some(-0.1), None], 1);
    let reports = solve(&scene, &[step], &mesh);
    assert_converged(&reports[0]);
    assert_eq!(reports[0].stability, Some(Stability::NotDetermined));
}

/// Strain energy of the bent cantilever by an independent Newton method, with a side load that is
/// taken away, on a mesh of the same size that leans to one side as this one does.
const ELASTICA: f64 = 0.13181;

/// A cantilever of ten widths under a dead load beyond its Euler load bends, at once and in parts.
#[test]
fn a_straight_cantilever_under_a_dead_load_beyond_euler_bends() {
    let mesh = mesh(moved(unit_grid(1, 10), |[x, y, _]| [x, 10.0 * y, 0.0]));
    for increments in [1, 20] {
        let mut scene = rubber(RubberModel::NeoHookean { shear_modulus: 1.0 }, None);
        scene.kind = Some(SceneKind::PlaneStrain);
        scene.supports = vec![support("y0", HELD)];
        scene.tractions = vec![traction("y1", [0.0, -0.02, 0.0])];
        scene.solver.quadrature_degree = Some(8);
        let step = Step {
            increments,
            ..Step::default()
        };
        let reports = solve(&scene, &[step], &mesh);
        reports.iter().for_each(assert_converged);
        let last = reports.last().expect("an increment");
        assert_eq!(last.stability, Some(Stability::Minimum));
        assert!(reports.iter().any(|report| report.snapped.is_some()));
        assert!(
            close(last.strain_energy, ELASTICA, 2e-2),
            "{increments}: {}",
            last.strain_energy
        );
    }
}

/// Columns below and above their Euler load, straight and bent, pressed at once and in parts,
/// of rubber that keeps its volume and of foam: what Lanczos steps say is what a count of the
/// motions says.
#[test]
fn the_sign_of_the_least_eigenvalue_agrees_with_a_count_of_all_unstable_motions() {
    let mut seen = [0, 0];
    for (bow, share, increments, bulk) in [
        (0.0, 0.5, 1, None),
        (0.0, 0.95, 1, None),
        (0.0, 1.05, 1, None),
        (0.0, 2.0, 4, None),
        (0.0, 4.0, 1, None),
        (0.02, 0.95, 1, None),
        (0.02, 3.0, 3, None),
        (0.0, 0.9, 1, Some(3.0)),
        (0.0, 1.3, 2, Some(3.0)),
        (0.0, 1.1, 1, Some(100.0)),
    ] {
        let verdicts = [StabilityCheck::Exact, StabilityCheck::Follow].map(|check| {
            let mut scene = clamped_of(bulk);
            scene.solver.stability = Choice::Named(check);
            scene.solver.on_instability = Choice::Named(OnInstability::Continue);
            let step = squeeze(share * euler_share(), increments);
            let reports = solve(&scene, &[step], &column(bow));
            reports.iter().for_each(assert_converged);
            reports
                .iter()
                .map(|report| report.stability)
                .collect::<Vec<_>>()
        });
        // Near the critical load it may leave the matter open, but never says the contrary.
        for (counted, found) in verdicts[0].iter().zip(&verdicts[1]) {
            if *found != Some(Stability::NotDetermined) {
                assert_eq!(counted, found, "{bow} {share} {bulk:?}");
                seen[usize::from(*found == Some(Stability::Saddle))] += 1;
            }
        }
    }
    assert!(seen[0] >= 3 && seen[1] >= 3, "{seen:?}");
}

/// A square of that material between a floor and a lid, held by nothing else.
fn between_plates(scene: Scene) -> Scene {
    let floor = plane([0.0; 3], [0.0, 1.0, 0.0]);
    let lid = plane([0.0, 1.0, 0.0], [0.0, -1.0, 0.0]);
    Scene {
        obstacles: vec![obstacle("floor", "y0", floor), obstacle("lid", "y1", lid)],
        ..scene
    }
}

/// A block between two plates, free to slide: that motion, which costs nothing, hides none.
#[test]
fn a_body_that_slides_freely_is_certified_where_its_softest_motion_is_seen() {
    let verdicts = [StabilityCheck::Exact, StabilityCheck::Follow].map(|check| {
        let mut scene = between_plates(rubber(mooney_rivlin(), None));
        scene.solver.stability = Choice::Named(check);
        let step = in_parts(push("lid", [0.0, -0.2, 0.0]), 4);
        let reports = solve(&scene, &[step], &mesh(square(4)));
        reports.iter().for_each(assert_converged);
        let found = reports.iter().map(|report| report.stability);
        found.collect::<Vec<_>>()
    });
    assert!(
        verdicts[0]
            .iter()
            .all(|said| *said == Some(Stability::Minimum))
    );
    // Its softest motion is one of many that nothing resists: seen or not, it is no saddle.
    let is_saddle = |said: &Option<Stability>| *said == Some(Stability::Saddle);
    assert!(!verdicts[1].iter().any(is_saddle), "{:?}", verdicts[1]);
}

/// A square block between two plates without friction, 30 % shorter: even strains are stable up to
/// 42 %, F = l - l^-3. The pair of elements alone has a zigzag of the vertices from 29 % on, along
/// which this mesh falls to 1.70.
#[test]
fn a_block_between_plates_is_not_let_down_by_its_mesh() {
    let scene = between_plates(rubber(RubberModel::NeoHookean { shear_modulus: 1.0 }, None));
    let length = 0.7_f64;
    let expected = length.powi(-3) - length;
    for increments in [1, 4, 10] {
        let step = in_parts(push("lid", [0.0, length - 1.0, 0.0]), increments);
        let reports = solve(&scene, &[step], &mesh(unit_grid(8, 6)));
        reports.iter().for_each(assert_converged);
        assert!(reports.iter().all(|report| report.snapped.is_none()));
        let last = reports.last().expect("an increment");
        assert_eq!(last.stability, Some(Stability::Minimum));
        assert!((last.penalty - 1.0).abs() < 1e-12, "{}", last.penalty);
        let force = -last.obstacles["lid"].force[1];
        assert!(close(force, expected, 1e-6), "{force} {expected}");
    }
}

/// A ball on two faces an edge fills the lid of a roller box after a fifth of its way; from then on
/// the pressure rises by K dV / V. By the undeformed area the mesh gave way at 59 shear moduli.
#[test]
fn a_lid_that_a_ball_fills_stays_filled() {
    let mut scene = rubber(RubberModel::NeoHookean { shear_modulus: 1.0 }, Some(1000.0));
    scene.supports = rollers();
    let ball = Shape::Sphere {
        centre: [0.5, 0.5, 5.0],
        radius: 4.0,
    };
    scene.supports.extend([
        support("x1", [Some(0.0), None, None]),
        support("y1", [None, Some(0.0), None]),
    ]);
    scene.obstacles = vec![obstacle("lid", "z1", ball)];
    let step = in_parts(push("lid", [0.0, 0.0, -0.1]), 10);
    let reports = solve(&scene, &[step], &mesh(cube(2)));
    assert_eq!(reports.len(), 10);
    reports.iter().for_each(assert_converged);
    assert!(reports.iter().all(|report| report.snapped.is_none()));
    let forces: Vec<f64> = reports
        .iter()
        .map(|report| -report.obstacles["lid"].force[2])
        .collect();
    for pair in forces[3..].windows(2) {
        assert!(close(pair[1] - pair[0], 10.0, 3e-3), "{forces:?}");
    }
}

/// Half a wave of height 8 and rise 1, a third thick, clamped at both ends.
fn arch() -> Arc<Mesh> {
    mesh(moved(unit_grid(2, 32), |[x, y, _]| {
        [
            0.3 * x + 0.5 - 0.5 * (2.0 * PI * y).cos(),
            SLENDERNESS * y,
            0.0,
        ]
    }))
}

#[test]
fn an_arch_pushed_through_snaps_to_one_equilibrium_in_one_increment_and_in_twenty() {
    let mut scene = rubber(RubberModel::NeoHookean { shear_modulus: 1.0 }, None);
    scene.supports = vec![support("y0", HELD), support("y1", HELD)];
    let roller = Shape::Cylinder {
        point: [2.3, 0.5 * SLENDERNESS, 0.0],
        axis: [0.0, 0.0, 1.0],
        radius: 1.0,
    };
    scene.obstacles = vec![obstacle("roller", "x1", roller)];
    let ends = [1, 20].map(|increments| {
        let step = in_parts(push("roller", [-1.5, 0.0, 0.0]), increments);
        let reports = solve(&scene, &[step], &arch());
        reports.iter().for_each(assert_converged);
        let falls = reports.iter().filter_map(|report| report.snapped);
        let energy: f64 = falls.map(|fall| fall.energy_drop).sum();
        assert!(energy > 0.0, "{increments}: {energy}");
        reports.last().expect("an increment").clone()
    });
    assert!(close(ends[0].strain_energy, ends[1].strain_energy, 1e-6));
    let [once, slowly] = ends.map(|end| end.obstacles["roller"].force[0]);
    assert!(once < 0.0 && close(once, slowly, 1e-6), "{once} {slowly}");
}
