//! What is wrong with a tie, or not solved yet, is told with its key.

use signorini::scene::SceneError;
use signorini::{MeshParts, Plan, Scene};

use super::scenes::{joined, linear, tie};
use crate::common::meshes::{mesh, moved, unit_grid};
use crate::common::scenes::{HELD_IN_PLANE, obstacle, plane, support};

/// Two squares on each other, `apart` between them.
fn blocks(apart: f64) -> MeshParts {
    let upper = moved(unit_grid(3, 3), |[x, y, z]| [x, y + 1.0 + apart, z]);
    joined([("low", unit_grid(4, 4)), ("up", upper)])
}

fn scene() -> Scene {
    Scene {
        supports: vec![support("low_y0", HELD_IN_PLANE)],
        ties: vec![tie("seam", "up_y0", "low_y1")],
        ..linear(&[("low", 1.0), ("up", 2.0)], 0.3)
    }
}

/// Path and message of the first fault.
fn fault(apart: f64, change: impl FnOnce(&mut Scene)) -> (String, String) {
    let mut scene = scene();
    change(&mut scene);
    let error = Plan::new(&scene, &[], &mesh(blocks(apart))).expect_err("a fault");
    let first = match error {
        SceneError::Invalid(all) => all.into_iter().next().expect("a fault"),
        SceneError::Unsupported(one) => one,
    };
    (first.path, first.message)
}

/// A change of a scene.
type Change<'a> = &'a dyn Fn(&mut Scene);

#[test]
fn names_and_groups_of_ties_are_checked() {
    let cases: [(Change<'_>, &str, &str); 7] = [
        (
            &|scene| scene.ties[0].between[0] = "up_y00".to_owned(),
            "tie.seam.between",
            "the mesh has no group of surface facets named `up_y00`; did you mean `up_y0`?",
        ),
        (
            &|scene| scene.ties[0].carries = Some("up".to_owned()),
            "tie.seam.carries",
            "`up` is none of the groups `up_y0` and `low_y1`",
        ),
        (
            &|scene| scene.ties[0].name = "low_y0".to_owned(),
            "tie.low_y0.name",
            "is that of a contact, an obstacle or a support, too",
        ),
        (
            &|scene| {
                scene.supports.push(support("up_y1", HELD_IN_PLANE));
                scene.ties[0].between[0] = "low_x0".to_owned();
                scene.ties[0].carries = None;
            },
            "tie.seam.between",
            "both groups have facets on part 0 of the mesh: bodies that share nodes are bonded already",
        ),
        (
            &|scene| scene.ties.push(tie("again", "up_y0", "low_x0")),
            "tie.again.between",
            "facets belong to tie `seam`, too: a facet meets one thing",
        ),
        (
            &|scene| {
                let wall = plane([0.0, 2.0, 0.0], [0.0, -1.0, 0.0]);
                scene.obstacles = vec![obstacle("wall", "up_y0", wall)];
            },
            "tie.seam.between",
            "facets may touch obstacle `wall`, too: a facet meets one thing",
        ),
        (
            &|scene| scene.supports.clear(),
            "support",
            "nothing holds the body against translation along x",
        ),
    ];
    for (change, path, message) in cases {
        let found = fault(0.0, change);
        assert_eq!(found.0, path, "{}", found.1);
        assert!(found.1.starts_with(message), "{}", found.1);
    }
}

#[test]
fn surfaces_that_do_not_meet_are_refused_with_their_distance() {
    let (path, message) = fault(0.2, |_| {});
    assert_eq!(path, "tie.seam.between");
    assert!(message.starts_with("the surfaces do not meet"), "{message}");
    assert!(message.contains("2.000e-1 apart"), "{message}");
}

#[test]
fn a_plan_says_who_carries_how_far_surfaces_are_apart_and_what_is_not_tied() {
    let mut scene = scene();
    scene.ties[0].carries = None;
    let plan = Plan::new(&scene, &[], &mesh(blocks(0.02))).expect("a valid scene");
    let report = plan.report();
    let own = report
        .decisions
        .iter()
        .find(|entry| entry.what == "tie seam");
    let own = own.expect("an entry");
    assert_eq!(
        own.choice,
        "`low_y1` carries 18 tractions; surfaces at most 2.0e-2 apart"
    );
    assert_eq!(own.reason, "bodies are alike, its faces are smaller");
    assert!(report.warnings.is_empty(), "{:?}", report.warnings);
    let shifted = moved(unit_grid(3, 3), |[x, y, z]| [x + 0.5, y + 1.0, z]);
    let parts = joined([("low", unit_grid(4, 4)), ("up", shifted)]);
    let plan = Plan::new(&scene, &[], &mesh(parts)).expect("a valid scene");
    let warnings = plan.report().warnings;
    let told = [
        "tie `seam`: 50 % of `low_y1` has no partner on `up_y0` and is free",
        "tie `seam`: 50 % of `up_y0` has no partner on `low_y1` and is free",
    ];
    assert_eq!(warnings, told);
}
