//! A body in space that meets itself: open rings and slits drawn out between two planes, and what must not
//! meet.

use crate::common::meshes::{mesh, moved, unit_box};
use crate::common::prisms::drawn_out;
use crate::common::scenes::{HELD_IN_PLANE, obstacle, plane, pull, support};
use crate::common::{assert_converged, close, solve, solve_one};
use crate::fluids::fluid;
use crate::folds::{lens, lens_scene, of_itself, together, with_union};
use crate::pinched::{half, whole};
use crate::scenes::{between, joined, linear_of, rubber};
use crate::slits::Slit;
use signorini::scene::{ContactPair, Support};
use signorini::{MeshParts, Plan, Scene, Step, StepReport};

/// Height of what is drawn out.
const HIGH: f64 = 0.25;
/// Cells along half a ring, and across.
const CELLS: [usize; 2] = [20, 3];
/// How far each grip goes until the lips press on each other.
const WAY: f64 = 0.13;
const BODIES: [(&str, f64); 2] = [("up_body", 1.0), ("low_body", 1.0)];

/// A law of the two halves.
type Law = fn() -> Scene;

fn soft() -> Scene {
    rubber(BODIES, Some(50.0))
}

fn stiff() -> Scene {
    linear_of(0.4, BODIES)
}

/// The scene of a ring between two planes, whose grips hold it.
fn ring(law: Law, contacts: Vec<ContactPair>) -> Scene {
    let mut scene = law();
    scene.solver.tolerance = 1e-11;
    scene.supports = ["up_grip", "low_grip"]
        .map(|name| support(name, HELD_IN_PLANE))
        .into();
    scene.supports.extend(flat());
    scene.contacts = contacts;
    scene
}

/// What holds the planes z = 0 and above.
fn flat() -> [Support; 2] {
    ["z0", "z1"].map(|name| support(name, [None, None, Some(0.0)]))
}

/// Its grips go `way` in three increments.
fn pinch(way: f64) -> Step {
    Step {
        increments: 3,
        ..together(["up_grip", "low_grip"], way)
    }
}

fn last(scene: &Scene, steps: &[Step], parts: MeshParts) -> StepReport {
    let mut reports = solve(scene, steps, &mesh(parts));
    reports.iter().for_each(assert_converged);
    reports.pop().expect("a report")
}

fn whole_ring(law: Law, contacts: Vec<ContactPair>, cells: [usize; 2]) -> StepReport {
    let parts = drawn_out(&whole(cells), 1, HIGH);
    last(&ring(law, contacts), &[pinch(WAY)], parts)
}

fn half_ring(law: Law, cells: [usize; 2]) -> StepReport {
    let floor = |name: &str| {
        let on = format!("up_{name}");
        obstacle(name, &on, plane([0.0; 3], [0.0, 1.0, 0.0]))
    };
    let mut scene = ring(law, Vec::new());
    scene.materials.truncate(1);
    scene.supports[1] = support("up_cut", [None, Some(0.0), None]);
    scene.obstacles = ["pad", "bore"].map(floor).into();
    let mut step = pinch(WAY);
    step.supports.truncate(1);
    let parts = drawn_out(&joined(&[("up_", half(cells))]), 1, HIGH);
    last(&scene, &[step], parts)
}

/// Force across the plane of symmetry and strain energy against those of half of it, each to a share.
fn is_half(report: &StepReport, alone: &StepReport, shares: [f64; 2]) {
    let expected = alone.obstacles["pad"].force[1];
    let [x, y, z] = report.contacts["pair"].force;
    assert!(close(y.abs(), expected, shares[0]), "{y} {expected}");
    assert!(x.abs().max(z.abs()) < 1e-3 * expected, "{x} {z}");
    assert!(close(
        report.strain_energy,
        2.0 * alone.strain_energy,
        shares[1]
    ));
    let grips = ["up_grip", "low_grip"].map(|name| report.supports[name].force);
    for i in 0..2 {
        let sum = grips[0][i] + grips[1][i];
        assert!(sum.abs() < 1e-8 * expected, "{grips:?}");
    }
}

#[test]
fn a_ring_in_space_pinched_shut_is_half_of_it_on_a_rigid_plane() {
    for cells in [CELLS, [24, 4]] {
        let alone = half_ring(soft, cells);
        for contacts in [
            between("up_pad", "low_pad"),
            between("low_pad", "up_pad"),
            of_itself("surface"),
        ] {
            // Rays leave along averaged normals, which turn by some degrees at the edge of a lip that is not
            // wholly shut: so do those of two bodies.
            is_half(&whole_ring(soft, contacts, cells), &alone, [2e-5, 5e-6]);
        }
        let alone = half_ring(stiff, cells);
        let report = whole_ring(stiff, of_itself("surface"), cells);
        is_half(&report, &alone, [1e-9, 1e-9]);
    }
}

#[test]
fn a_ring_in_space_that_is_shut_and_opened_again_has_no_force() {
    for law in [soft as Law, stiff] {
        let scene = ring(law, of_itself("surface"));
        let parts = mesh(drawn_out(&whole([14, 2]), 1, HIGH));
        let reports = solve(&scene, &[pinch(WAY), pinch(0.0)], &parts);
        reports.iter().for_each(assert_converged);
        let forces: Vec<f64> = reports
            .iter()
            .map(|report| report.contacts["pair"].force[1].abs())
            .collect();
        assert!(forces[2] > 1e-3, "{forces:?}");
        let end = &reports[reports.len() - 1];
        let contact = &end.contacts["pair"];
        let told = contact.force.iter().chain([&contact.peak_pressure]);
        let most = told.fold(0.0_f64, |most, x| most.max(x.abs()));
        assert!(most < 1e-12 * forces[2], "{contact:?}");
        assert!(end.strain_energy < 1e-12 * reports[2].strain_energy);
    }
}

#[test]
fn a_slit_like_a_lens_in_space_closes_from_both_ends() {
    for (contacts, sign) in [
        (between("low", "up"), -1.0),
        (between("up", "low"), 1.0),
        (of_itself("slit"), -1.0),
    ] {
        let mut scene = lens_scene(contacts);
        scene.supports.extend(flat());
        let step = Step {
            increments: 4,
            ..together(["top", "bot"], 0.1)
        };
        let report = last(&scene, &[step], drawn_out(&lens(), 1, HIGH));
        let [_, y, _] = report.contacts["pair"].force;
        assert!(close(
            report.strain_energy,
            0.070_330_861_042_6 * HIGH,
            3e-3
        ));
        assert!(close(sign * y, 0.324_201_318_33 * HIGH, 1.5e-2), "{y}");
        let area = report.contacts["pair"].contact_area;
        assert!(close(area, 1.107 * HIGH, 1e-3), "{area}");
    }
}

#[test]
fn slits_of_many_shapes_in_space_close_whichever_lip_carries() {
    for number in 0..3 {
        let slit = Slit::some(number);
        let [first, second, both] = [
            between("low_lip", "up_lip"),
            between("up_lip", "low_lip"),
            of_itself("slit"),
        ]
        .map(|contacts| {
            let mut scene = Slit::scene(contacts);
            scene.supports.extend(flat());
            let step = Step {
                increments: 3,
                ..together(["up_y1", "low_y1"], 0.1)
            };
            last(&scene, &[step], drawn_out(&slit.parts(), 1, HIGH)).strain_energy
        });
        assert!(close(first, second, 4e-4), "{slit:?} {first} {second}");
        // Both lips follow each other along the surface: one of them carries all along.
        let same = [first, second].map(|one| (both / one - 1.0).abs());
        assert!(same[0].min(same[1]) < 1e-9, "{slit:?} {same:?}");
    }
}

/// What a contact of the whole surface tells, and energies with it and without.
fn with_and_without(scene: &Scene, step: &Step, parts: MeshParts) {
    let sides = ["x0", "x1", "y0", "y1", "z0", "z1"];
    let parts = mesh(with_union(parts, "whole", &sides));
    let [alone, with] = [Vec::new(), of_itself("whole")].map(|contacts| {
        let mut scene = Scene {
            contacts,
            ..scene.clone()
        };
        scene.solver.tolerance = 1e-11;
        solve_one(&scene, step, &parts)
    });
    let contact = &with.contacts["pair"];
    let told = contact.force.iter().chain([&contact.peak_pressure]);
    assert!(
        told.into_iter().all(|x| x.abs() < f64::EPSILON),
        "{contact:?}"
    );
    assert!(close(with.strain_energy, alone.strain_energy, 1e-9));
}

#[test]
fn a_thin_wall_in_space_that_is_pressed_flat_never_meets_its_own_back() {
    let wall = moved(unit_box([8, 6, 2]), |[x, y, z]| [x, 0.6 * y, 0.07 * z]);
    let mut scene = rubber([("body", 1.0)], Some(5.0));
    scene.supports = vec![
        support("x0", [Some(0.0), None, None]),
        support("y0", [None, Some(0.0), None]),
        support("z0", [None, None, Some(0.0)]),
        support("z1", [None, None, Some(0.0)]),
    ];
    // Down to half its thickness.
    with_and_without(&scene, &pull("z1", [None, None, Some(-0.035)], 1), wall);
}

#[test]
fn a_block_and_a_bent_bracket_do_not_meet_themselves() {
    let block = unit_box([4, 3, 3]);
    // A right angle: from x = 1/2 on it goes up, its corner mitred.
    let bracket = moved(unit_box([12, 2, 2]), |[x, y, z]| {
        let [first, second] = [x.min(0.5), x.max(0.5) - 0.5].map(|way| way * (1.0 - 0.2 * z));
        [first, 0.3 * y, 0.1 * z + second]
    });
    for parts in [block, bracket] {
        for mut scene in [
            rubber([("body", 1.0)], Some(20.0)),
            linear_of(0.3, [("body", 1.0)]),
        ] {
            scene.supports = vec![
                support("x0", [Some(0.0); 3]),
                support("x1", [Some(0.0), None, None]),
            ];
            let step = pull("x1", [Some(0.08), None, None], 1);
            with_and_without(&scene, &step, parts.clone());
        }
    }
}

/// What is wrong with a ring.
fn refused(scene: &Scene) -> String {
    let parts = mesh(drawn_out(&whole([14, 2]), 1, HIGH));
    let error = Plan::new(scene, &[], &parts).expect_err("a fault");
    format!("{error:?}")
}

#[test]
fn friction_and_fluids_of_one_body_on_itself_in_space_are_refused() {
    let pads = ["up_pad", "low_pad"];
    for (contacts, on, expected) in [
        (
            between(pads[0], pads[1]),
            &pads[..],
            "of one body with itself in space",
        ),
        (
            of_itself("surface"),
            &["surface"][..],
            "of a surface with itself",
        ),
    ] {
        let mut scene = ring(soft, contacts);
        let smooth = scene.contacts.clone();
        scene.contacts[0].friction = 0.3;
        let error = refused(&scene);
        assert!(error.contains("contact.pair.friction"), "{error}");
        scene.contacts = smooth.clone();
        scene.contacts[0].tresca = Some(0.1);
        let error = refused(&scene);
        assert!(error.contains("contact.pair.tresca"), "{error}");
        assert!(error.contains("of a body on itself in space"), "{error}");
        scene.contacts = smooth;
        scene.fluids = vec![fluid(on, &["up_skin"], &[])];
        let error = refused(&scene);
        assert!(error.contains(expected), "{error}");
    }
}
