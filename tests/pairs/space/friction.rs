//! Friction between bodies in space.

use std::sync::Arc;

use signorini::scene::SupportTarget;
use signorini::{
    CancelToken, Mesh, Plan, Prepared, Reuse, Scene, Session, Step, StepReport, Termination,
};

use crate::common::meshes::{irregular, mesh, moved, unit_box};
use crate::common::scenes::{obstacle, plane, pull, support, traction};
use crate::common::{assert_converged, close, open, solve, take};
use crate::scenes::{between, joined, linear_of, rubber};

const HELD: [Option<f64>; 3] = [Some(0.0); 3];

/// A low block on a wide one, whose meshes do not match and have no common direction.
fn block_on_block(cells: [usize; 3]) -> Arc<Mesh> {
    let low = moved(irregular(unit_box([4, 4, 1]), 4), |[x, y, z]| {
        [2.0 * x - 0.9, 2.0 * y - 1.1, 0.5 * (z - 1.0)]
    });
    let up = moved(unit_box(cells), |[x, y, z]| {
        let (sine, cosine) = 0.3_f64.sin_cos();
        let [x, y] = [x - 0.5, y - 0.5];
        [cosine * x - sine * y, sine * x + cosine * y, 0.4 * z]
    });
    mesh(joined(&[("low_", low), ("up_", up)]))
}

/// Along the surface, skew to axes and edges.
fn direction() -> [f64; 2] {
    let (sine, cosine) = 0.7_f64.sin_cos();
    [cosine, sine]
}

/// The block that friction alone holds, pressed by one and pulled by `pull`.
fn pulled(scene: Scene, pull: f64, [friction, tresca]: [Option<f64>; 2]) -> StepReport {
    let [x, y] = direction();
    let mut scene = Scene {
        supports: vec![support("low_z0", HELD)],
        contacts: between("up_z0", "low_z1"),
        tractions: vec![traction("up_z1", [pull * x, pull * y, -1.0])],
        ..scene
    };
    scene.contacts[0].friction = friction.unwrap_or(0.0);
    scene.contacts[0].tresca = tresca;
    scene.solver.tolerance = 1e-10;
    solve(&scene, &[Step::default()], &block_on_block([2, 3, 1])).remove(0)
}

/// Sticks a millionth below the `limit` and slides a millionth above.
fn check_limit(scene: &Scene, limit: f64, law: [Option<f64>; 2]) {
    let below = limit * (1.0 - 1e-6);
    let report = pulled(scene.clone(), below, law);
    assert_converged(&report);
    let force = report.contacts["pair"].force;
    for (found, along) in force.iter().zip(direction()) {
        assert!(close(*found, -below * along, 1e-7), "{force:?}");
    }
    assert!(close(force[2], 1.0, 1e-8), "{force:?}");
    let above = pulled(scene.clone(), limit * (1.0 + 1e-6), law);
    assert_eq!(above.termination, Termination::NotConverged);
}

#[test]
fn a_block_on_a_block_in_space_sticks_just_below_the_limit_and_slides_just_above() {
    let scene = linear_of(0.3, [("low_body", 10.0), ("up_body", 10.0)]);
    check_limit(&scene, 0.2, [Some(0.2), None]);
}

#[test]
fn a_block_on_a_block_in_space_sticks_just_below_its_bound_and_slides_just_above() {
    // All of the sole presses: the block stands up straight on what hardly gives.
    let scene = linear_of(0.0, [("low_body", 1e5), ("up_body", 10.0)]);
    check_limit(&scene, 0.05, [None, Some(0.05)]);
}

/// Force between two blocks, the upper one pressed, and pushed by a side that begins `off` the plane in which the
/// lower one is held.
fn pushed_by_its_side(scene: Scene, off: f64) -> [f64; 3] {
    let low = moved(unit_box([4, 3, 2]), |[x, y, z]| {
        [2.0 * x, 1.6 * y - 0.3, 0.5 * (z - 1.0)]
    });
    let up = moved(unit_box([2, 2, 1]), |[x, y, z]| [x + off, y, 0.5 * z]);
    let body = mesh(joined(&[("low_", low), ("up_", up)]));
    let mut scene = Scene {
        supports: vec![
            support("low_z0", HELD),
            support("low_x0", [Some(0.0), None, None]),
            support("up_x0", [Some(0.0), None, None]),
            support("up_z1", [None, Some(0.0), Some(0.0)]),
        ],
        contacts: between("up_z0", "low_z1"),
        ..scene
    };
    scene.contacts[0].friction = 0.3;
    let mut press = pull("up_z1", [None, Some(0.0), Some(-0.05)], 2);
    press
        .supports
        .extend(pull("up_x0", [Some(0.08), None, None], 1).supports);
    let reports = solve(&scene, &[press, Step::default()], &body);
    reports.iter().for_each(assert_converged);
    let [.., pushed, rests] = &reports[..] else {
        panic!("{reports:?}");
    };
    let [pushed, rests] = [pushed, rests].map(|report| report.contacts["pair"].force);
    // An increment that moves nothing leaves the friction that is there.
    let apart = pushed.iter().zip(rests).map(|(a, b)| (a - b).abs());
    assert!(apart.fold(0.0, f64::max) < 1e-6, "{pushed:?} {rests:?}");
    pushed
}

/// Both blocks are held at sides that lie in one plane, and one of them is moved off it: it slips there too, as
/// where the sides never were in one plane.
#[test]
fn a_block_that_its_side_pushes_off_a_common_plane_slips_there_too() {
    for scene in [
        rubber([("low_body", 1.0), ("up_body", 1.0)], Some(10.0)),
        linear_of(0.3, [("low_body", 1.0), ("up_body", 1.0)]),
    ] {
        let [flush, off] = [0.0, 1e-4].map(|off| pushed_by_its_side(scene.clone(), off));
        let apart = flush
            .iter()
            .zip(off)
            .map(|(one, other)| (one - other).abs());
        assert!(
            apart.fold(0.0, f64::max) < 1e-3 * flush[2].abs(),
            "{flush:?} {off:?}"
        );
        assert!(flush[0].abs() > 0.97 * 0.3 * flush[2].abs(), "{flush:?}");
    }
}

/// A block of rubber pressed and pushed along a stiff block, or along a plane in its place. Where the sole opens
/// at its corners its rays tilt, and tractions with them: in cells twice as large ten times as much.
fn pushed(is_pair: bool) -> Vec<StepReport> {
    let [x, y] = direction();
    let law = rubber([("low_body", 1e6), ("up_body", 1.0)], None);
    let mut scene = Scene {
        supports: vec![support("up_z1", HELD)],
        ..law
    };
    scene.solver.tolerance = 1e-9;
    let body = if is_pair {
        scene.supports.push(support("low_z0", HELD));
        scene.contacts = between("up_z0", "low_z1");
        scene.contacts[0].friction = 0.3;
        block_on_block([4, 6, 2])
    } else {
        scene.materials.remove(0);
        let mut floor = obstacle("pair", "up_z0", plane([0.0; 3], [0.0, 0.0, 1.0]));
        floor.friction = 0.3;
        scene.obstacles = vec![floor];
        let up = moved(unit_box([4, 6, 2]), |[x, y, z]| {
            let (sine, cosine) = 0.3_f64.sin_cos();
            let [x, y] = [x - 0.5, y - 0.5];
            [cosine * x - sine * y, sine * x + cosine * y, 0.4 * z]
        });
        mesh(joined(&[("up_", up)]))
    };
    let to = |way: f64| pull("up_z1", [Some(way * x), Some(way * y), Some(-0.04)], 1);
    let reports = solve(&scene, &[to(0.0), to(0.015)], &body);
    reports.iter().for_each(assert_converged);
    reports
}

#[test]
fn a_block_pushed_along_a_stiff_block_in_space_is_the_block_pushed_along_a_plane() {
    let (pair, tool) = (pushed(true), pushed(false));
    for (pair, tool) in pair.iter().zip(&tool) {
        let (found, expected) = (&pair.contacts["pair"], &tool.obstacles["pair"]);
        let friction = found.friction.expect("friction");
        for i in 0..3 {
            let miss = (found.force[i] - expected.force[i]).abs();
            assert!(miss < 1e-4 * expected.force[2], "{:?}", found.force);
        }
        let [found, expected] = [friction.dissipated_total, expected.dissipated_total];
        assert!(close(found, expected, 5e-4), "{found} {expected}");
        let counts = [friction.stick_vertices, friction.slip_vertices];
        let tool = &tool.obstacles["pair"];
        assert_eq!(counts, [tool.stick_vertices, tool.slip_vertices]);
        assert!(pair.sqp_iterations <= 6, "{}", pair.sqp_iterations);
    }
}

/// The bodies pressed and sheared below the limit, then turned as one.
#[test]
fn bodies_that_turn_together_about_a_skew_axis_slip_by_nothing() {
    let [x, y] = direction();
    let mut scene = Scene {
        supports: vec![support("low_z0", HELD), support("up_z1", HELD)],
        contacts: between("up_z0", "low_z1"),
        ..rubber([("low_body", 1.0), ("up_body", 1.0)], Some(10.0))
    };
    scene.contacts[0].friction = 0.5;
    scene.solver.tolerance = 1e-11;
    let angle = 40.0_f64.to_radians();
    let axis = [1.0, -2.0, 2.0].map(|x| x / 3.0 * angle);
    let target = |name: &str, way: [f64; 3], rotation: [f64; 3]| SupportTarget {
        name: name.to_owned(),
        translation: Some(way),
        rotation: Some(rotation),
        about: Some([0.0; 3]),
        ..SupportTarget::default()
    };
    let way = [0.01 * x, 0.01 * y, -0.05];
    let step = |rotation: [f64; 3], way: [f64; 3]| Step {
        supports: vec![
            target("low_z0", [0.0; 3], rotation),
            target("up_z1", way, rotation),
        ],
        ..Step::default()
    };
    let steps = [step([0.0; 3], way), step(axis, turned(way, axis))];
    let reports = solve(&scene, &steps, &block_on_block([2, 3, 1]));
    reports.iter().for_each(assert_converged);
    let [before, after] = [&reports[0], &reports[1]].map(|report| &report.contacts["pair"]);
    let expected = turned(before.force, axis);
    let size = expected.iter().map(|x| x * x).sum::<f64>().sqrt();
    for (found, expected) in after.force.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-9 * size, "{found} {expected}");
    }
    let [before, after] = [before, after].map(|one| one.friction.expect("friction"));
    assert_eq!(after.stick_vertices, before.stick_vertices);
    assert!(after.max_slip < 1e-9, "{}", after.max_slip);
}

/// Pressed, taken up again from a checkpoint and pushed until some slips: the last checkpoint.
fn taken_up(threads: usize) -> Vec<u8> {
    let mut scene = Scene {
        supports: vec![support("low_z0", HELD), support("up_z1", HELD)],
        contacts: between("up_z0", "low_z1"),
        ..rubber([("low_body", 2.0), ("up_body", 1.0)], Some(10.0))
    };
    scene.contacts[0].friction = 0.3;
    let [x, y] = direction();
    let to = |way: f64| pull("up_z1", [Some(way * x), Some(way * y), Some(-0.04)], 1);
    let mesh = block_on_block([2, 3, 1]);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.expect("a pool").install(|| {
        let mut session = open(&scene, &mesh);
        take(&mut session, &to(0.0));
        let bytes = session.export();
        let plan = Arc::new(Plan::new(&scene, &[], &mesh).expect("a valid scene"));
        let prepared = Prepared::build(&plan, &mesh, &CancelToken::new());
        let prepared = Arc::new(prepared.expect("a solvable scene"));
        let other = Session::import(plan, mesh.clone(), prepared, Reuse::Reused, &bytes);
        let [own, other] = [session, other.expect("a checkpoint")].map(|mut session| {
            let reports = take(&mut session, &to(0.02));
            assert_converged(&reports[0]);
            let friction = reports[0].contacts["pair"].friction.expect("friction");
            assert!(friction.slip_vertices > 0 && friction.dissipated_total > 0.0);
            session.export()
        });
        assert!(own == other);
        own
    })
}

#[test]
fn bodies_that_rub_in_space_go_on_with_the_same_bits_on_any_number_of_threads() {
    assert!(taken_up(1) == taken_up(3));
}

/// v turned by a rotation vector.
fn turned(v: [f64; 3], rotation: [f64; 3]) -> [f64; 3] {
    let angle = rotation.iter().map(|x| x * x).sum::<f64>().sqrt();
    let k = rotation.map(|x| x / angle);
    let (sine, cosine) = angle.sin_cos();
    let along: f64 = k.iter().zip(v).map(|(k, v)| k * v).sum();
    [0, 1, 2].map(|i: usize| {
        let [j, l] = [(i + 1) % 3, (i + 2) % 3];
        let across = k[j] * v[l] - k[l] * v[j];
        cosine * v[i] + sine * across + (1.0 - cosine) * along * k[i]
    })
}
