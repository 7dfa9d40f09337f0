//! What must not meet, and where contact ends: thin walls, three parts in a corner, corners of partners.

use super::folds::{of_itself, with_union};
use super::scenes::{between, joined, rubber};
use crate::common::meshes::{mesh, moved, unit_grid};
use crate::common::scenes::{HELD_IN_PLANE, obstacle, plane, pull, push, support};
use crate::common::{assert_converged, close, node_positions, run, solve_one, values};
use signorini::scene::ContactPair;
use signorini::{FieldName, Scene};

#[test]
fn a_thin_wall_that_is_pressed_flat_never_meets_its_own_back() {
    let wall = moved(unit_grid(30, 2), |[x, y, z]| [2.0 * x, 0.07 * y, z]);
    let wall = mesh(with_union(wall, "skin", &["x0", "x1", "y0", "y1"]));
    let pressed = |contacts: Vec<ContactPair>| {
        let mut scene = rubber([("body", 1.0)], Some(5.0));
        scene.supports = vec![support("x0", [Some(0.0), None, None])];
        scene.obstacles = vec![
            obstacle("floor", "y0", plane([0.0; 3], [0.0, 1.0, 0.0])),
            obstacle("lid", "y1", plane([0.0, 0.07, 0.0], [0.0, -1.0, 0.0])),
        ];
        scene.contacts = contacts;
        // Down to half its thickness.
        solve_one(&scene, &push("lid", [0.0, -0.035, 0.0]), &wall)
    };
    let [alone, with] = [Vec::new(), of_itself("skin")].map(pressed);
    let contact = &with.contacts["pair"];
    let told = contact
        .force
        .iter()
        .chain([&contact.peak_pressure, &contact.contact_width]);
    assert!(
        told.into_iter().all(|value| value.abs() < f64::EPSILON),
        "{contact:?}"
    );
    assert!(close(with.strain_energy, alone.strain_energy, 1e-9));
}

#[test]
fn three_blocks_that_meet_in_a_corner_of_a_closed_box_have_even_pressure() {
    let block = |count: [usize; 2], [x0, y0]: [f64; 2], width: f64| {
        let place = move |[x, y, z]: [f64; 3]| [x0 + width * x, y0 + y, z];
        moved(unit_grid(count[0], count[1]), place)
    };
    let parts = joined(&[
        ("a_", block([7, 3], [0.0, 0.0], 2.0)),
        ("b_", block([4, 3], [0.0, 1.0], 0.9)),
        ("c_", block([5, 4], [0.9, 1.0], 1.1)),
    ]);
    let faced = ["a_y1", "b_y0", "b_x1", "c_y0", "c_x0"];
    let sides = ["x0", "x1", "y0", "y1"];
    let whole = ["a_", "b_", "c_"].map(|body| sides.map(|side| format!("{body}{side}")));
    let whole: Vec<&str> = whole.as_flattened().iter().map(|name| &name[..]).collect();
    let parts = with_union(with_union(parts, "faced", &faced), "whole", &whole);
    let parts = mesh(parts);
    let along = [Some(0.0), None, None];
    let up = [None, Some(0.0), None];
    let mut scene = Scene {
        supports: vec![
            support("a_x0", along),
            support("a_x1", along),
            support("a_y0", up),
            support("b_x0", along),
            support("c_x1", along),
            support("b_y1", up),
            support("c_y1", up),
        ],
        ..rubber(
            [("a_body", 1.0), ("b_body", 1.0), ("c_body", 1.0)],
            Some(20.0),
        )
    };
    let step = signorini::Step {
        supports: ["b_y1", "c_y1"]
            .map(|name| pull(name, [None, Some(-0.1), None], 1).supports.remove(0))
            .into(),
        ..signorini::Step::default()
    };
    let named = |name: &str, first: &str, second: &str| ContactPair {
        name: name.to_owned(),
        ..between(first, second).remove(0)
    };
    let pairs = vec![
        named("ab", "b_y0", "a_y1"),
        named("ac", "c_y0", "a_y1"),
        named("bc", "c_x0", "b_x1"),
    ];
    // Uniaxial: p = K (1 - J), and what the law adds to it along and across.
    let stretch: f64 = 0.95;
    let mean = (stretch * stretch + 2.0) / 3.0;
    let added = |square: f64| stretch.powf(-5.0 / 3.0) * (mean - square);
    scene.solver.tolerance = 1e-10;
    // As pairs, as one surface, and with the sides where nothing is met in it, too; soft and hard.
    for contacts in [pairs, of_itself("faced"), of_itself("whole")] {
        for bulk in [20.0, 200.0] {
            scene.materials = rubber(
                [("a_body", 1.0), ("b_body", 1.0), ("c_body", 1.0)],
                Some(bulk),
            )
            .materials;
            scene.contacts.clone_from(&contacts);
            let report = solve_one(&scene, &step, &parts);
            let down = bulk * (1.0 - stretch) + added(stretch * stretch);
            let across = bulk * (1.0 - stretch) + added(1.0);
            let lid = ["b_y1", "c_y1"].map(|name| -report.supports[name].force[1]);
            assert!(close(lid[0], 0.9 * down, 1e-7), "{lid:?}");
            assert!(close(lid[1], 1.1 * down, 1e-7), "{lid:?}");
            let wall = report.supports["b_x0"].force[0];
            assert!(close(wall, 0.95 * across, 1e-7), "{wall}");
            if let Some(contact) = report.contacts.get("bc") {
                assert!(close(contact.force[0], 0.95 * across, 1e-7), "{contact:?}");
            }
        }
    }
}

#[test]
fn contact_ends_with_the_corner_of_what_is_met() {
    let parts = joined(&[
        ("a_", moved(unit_grid(5, 4), |[x, y, z]| [x, y - 1.0, z])),
        (
            "b_",
            moved(unit_grid(8, 4), |[x, y, z]| [2.0 * x - 0.5, y, z]),
        ),
    ]);
    let mesh = mesh(parts);
    let scene = Scene {
        supports: vec![
            support("a_y0", HELD_IN_PLANE),
            support("b_y1", HELD_IN_PLANE),
        ],
        contacts: between("b_y0", "a_y1"),
        ..rubber([("a_body", 1.0), ("b_body", 1.0)], Some(20.0))
    };
    let step = pull("b_y1", [Some(0.0), Some(-0.08), None], 1);
    let (session, reports) = run(&scene, &[step], &mesh);
    assert_converged(&reports[0]);
    let moved = values(&session, FieldName::Displacement);
    let places = node_positions(&mesh);
    let corner = |x: f64| {
        let at = places
            .iter()
            .position(|at| (at[0] - x).abs() < 1e-12 && at[1].abs() < 1e-12);
        let node = at.expect("a corner");
        [0, 1].map(|i| places[node][i] + moved[3 * node + i])
    };
    let [left, right] = [0.0, 1.0].map(corner);
    let width = f64::hypot(right[0] - left[0], right[1] - left[1]);
    let contact = &reports[0].contacts["pair"];
    // The face between the corners is bent a little.
    assert!(contact.contact_width < 1.01 * width, "{contact:?} {width}");
    assert!(contact.contact_width > 0.97 * width, "{contact:?} {width}");
    let mean = contact.mean_pressure.expect("contact");
    assert!(close(mean * width, contact.force[1], 0.05), "{contact:?}");
}
