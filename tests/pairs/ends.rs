//! Surfaces that end on faces of what carries the pressure: functions that meet next to nothing.

use std::sync::Arc;

use super::scenes::{between, joined, linear_of, rubber};
use crate::common::meshes::{mesh, moved, unit_grid};
use crate::common::scenes::{HELD_IN_PLANE, pull, support};
use crate::common::{assert_converged, open, run, solve_one, take};
use signorini::report::StepReport;
use signorini::{CancelToken, Mesh, Plan, Prepared, Reuse, Scene, Session};

/// A punch of some width on a block of width 2 with faces of a quarter.
fn punch(width: f64) -> Arc<Mesh> {
    let place = |[x, y, z]: [f64; 3]| [width * (x - 0.5), 0.5 * y, z];
    mesh(joined(&[
        (
            "a_",
            moved(unit_grid(8, 4), |[x, y, z]| [2.0 * x - 1.0, y - 1.0, z]),
        ),
        ("b_", moved(unit_grid(4, 2), place)),
    ]))
}

/// Which is held at the bottom of the block and the top of the punch.
fn held(scene: Scene, carrier: &str, other: &str) -> Scene {
    Scene {
        supports: vec![
            support("a_y0", HELD_IN_PLANE),
            support("b_y1", HELD_IN_PLANE),
        ],
        contacts: between(carrier, other),
        ..scene
    }
}

fn peak_and_force(report: &StepReport) -> [f64; 2] {
    let contact = &report.contacts["pair"];
    [contact.peak_pressure, contact.force[1].abs()]
}

#[test]
fn pressures_stay_bounded_where_a_punch_ends_anywhere_on_a_face_of_the_block_that_carries() {
    for hundredths in [98, 100, 101, 102, 105, 110, 130, 148, 150, 152] {
        let punch = punch(f64::from(hundredths) / 100.0);
        let pressed = |carrier: &str, other: &str| {
            let scene = held(
                linear_of(0.3, [("a_body", 1.0), ("b_body", 10.0)]),
                carrier,
                other,
            );
            let step = pull("b_y1", [Some(0.0), Some(-0.02), None], 1);
            let report = solve_one(&scene, &step, &punch);
            let contact = &report.contacts["pair"];
            // What is told of the mean is the force over the width.
            let mean = contact.mean_pressure.expect("contact");
            let force = mean * contact.contact_width;
            assert!(
                (force / contact.force[1].abs() - 1.0).abs() < 0.02,
                "{contact:?}"
            );
            peak_and_force(&report)
        };
        let block = pressed("a_y1", "b_y0");
        let punch = pressed("b_y0", "a_y1");
        // Without functions that are lent up to 40 times.
        assert!(
            block[0] < 2.0 * punch[0],
            "{hundredths}: {block:?} {punch:?}"
        );
        assert!(
            (block[1] / punch[1] - 1.0).abs() < 0.08,
            "{hundredths}: {block:?} {punch:?}"
        );
    }
}

/// A punch that presses a block of rubber and goes on along it, past a vertex.
fn slid(carrier: &str, other: &str) -> (Scene, Vec<signorini::Step>, Arc<Mesh>) {
    let scene = held(
        rubber([("a_body", 1.0), ("b_body", 10.0)], Some(20.0)),
        carrier,
        other,
    );
    let steps = vec![
        pull("b_y1", [Some(0.0), Some(-0.05), None], 1),
        pull("b_y1", [Some(0.3), Some(-0.05), None], 6),
    ];
    (scene, steps, punch(1.02))
}

#[test]
fn pressures_stay_bounded_while_the_ends_of_a_punch_slide_over_faces_of_rubber() {
    let told = |carrier: &str, other: &str| {
        let (scene, steps, mesh) = slid(carrier, other);
        let (_, reports) = run(&scene, &steps, &mesh);
        reports.iter().for_each(assert_converged);
        reports.iter().map(peak_and_force).collect::<Vec<_>>()
    };
    let [block, punch] = [told("a_y1", "b_y0"), told("b_y0", "a_y1")];
    for (block, punch) in block.iter().zip(&punch) {
        assert!(block[0] < 2.0 * punch[0], "{block:?} {punch:?}");
        assert!(
            (block[1] / punch[1] - 1.0).abs() < 0.08,
            "{block:?} {punch:?}"
        );
    }
}

#[test]
fn a_session_goes_on_with_the_same_bits_where_functions_are_lent() {
    let (scene, steps, mesh) = slid("a_y1", "b_y0");
    let mut session = open(&scene, &mesh);
    // Pressed from rest, then slid: functions that a pressed neighbour slides onto lend, too.
    for [before, after] in [[0, 1], [1, 0]] {
        take(&mut session, &steps[before]);
        let bytes = session.export();
        let plan = Arc::new(Plan::new(&scene, &[], &mesh).expect("a valid scene"));
        let prepared = Prepared::build(&plan, &mesh, &CancelToken::new());
        let prepared = Arc::new(prepared.expect("a solvable scene"));
        let other = Session::import(plan, mesh.clone(), prepared, Reuse::Reused, &bytes);
        let mut other = other.expect("a checkpoint");
        assert!(other.export() == bytes, "after step {before}");
        let [own, other] = [&mut session, &mut other].map(|session| {
            take(session, &steps[after]);
            session.export()
        });
        assert!(own == other, "step {after} after step {before}");
    }
}
