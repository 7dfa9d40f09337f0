//! What is wrong with a contact, or not solved yet, is told with its key.

use super::folds::{of_itself, with_union};
use super::scenes::{between, joined, linear};
use crate::common::meshes::{file, file_parts, mesh, moved, unit_grid};
use crate::common::scenes::{HELD_IN_PLANE, obstacle, plane, support};
use signorini::scene::{Choice, ContactSpace, SceneError, SceneKind};
use signorini::{Plan, Scene};

fn scene() -> Scene {
    Scene {
        supports: vec![
            support("a_bot", HELD_IN_PLANE),
            support("b_top", HELD_IN_PLANE),
        ],
        contacts: between("b_bot", "a_top"),
        ..linear([("a", 1.0), ("b", 2.0)])
    }
}

/// A change of a scene.
type Change<'a> = &'a dyn Fn(&mut Scene);

/// Path and message of the first fault.
fn fault(change: impl FnOnce(&mut Scene)) -> (String, String) {
    let mut scene = scene();
    change(&mut scene);
    let error = Plan::new(&scene, &[], &file("pair_box_6_8")).expect_err("a fault");
    let first = match error {
        SceneError::Invalid(all) => all.into_iter().next().expect("a fault"),
        SceneError::Unsupported(one) => one,
    };
    (first.path, first.message)
}

#[test]
fn names_and_groups_of_contacts_are_checked() {
    let cases: [(Change<'_>, &str, &str); 7] = [
        (
            &|scene| scene.contacts[0].between[0] = "b_bott".to_owned(),
            "contact.pair.between",
            "the mesh has no group of surface facets named `b_bott`; did you mean `b_bot`?",
        ),
        (
            &|scene| scene.contacts[0].carries = Some("a".to_owned()),
            "contact.pair.carries",
            "`a` is none of the groups `b_bot` and `a_top`",
        ),
        (
            &|scene| scene.contacts[0].name = "a_bot".to_owned(),
            "contact.a_bot.name",
            "is that of an obstacle or a support, too",
        ),
        (
            &|scene| {
                scene.contacts[0].between[0] = "a_top".to_owned();
                scene.contacts[0].carries = Some("a_top".to_owned());
            },
            "contact.pair.carries",
            "stands beside `self`",
        ),
        (
            &|scene| {
                let mut again = scene.contacts[0].clone();
                again.name = "again".to_owned();
                again.between.reverse();
                scene.contacts.push(again);
            },
            "contact.again.between",
            "facets that meet in contact `pair`, too",
        ),
        (
            &|scene| scene.solver.contact_space = Choice::Named(ContactSpace::Linear),
            "solver.contact_space",
            "of contacts between bodies pressures are quadratic",
        ),
        (
            &|scene| scene.kind = Some(SceneKind::PlaneStress),
            "contact",
            "contact between sheets is not solved yet",
        ),
    ];
    for (change, path, message) in cases {
        let found = fault(change);
        assert_eq!(found.0, path, "{}", found.1);
        assert!(found.1.starts_with(message), "{}", found.1);
    }
}

#[test]
fn a_body_that_no_contact_can_hold_is_refused() {
    let (path, message) = fault(|scene| {
        scene.supports.pop();
        scene.contacts.clear();
        let up = plane([0.0; 3], [0.0, 1.0, 0.0]);
        scene.obstacles = vec![obstacle("floor", "a_left", up)];
    });
    assert_eq!(path, "support");
    assert!(message.contains("contact alone holds"), "{message}");
    let mesh = mesh(joined(&[
        ("a_", unit_grid(2, 2)),
        ("b_", moved(unit_grid(2, 2), |[x, y, z]| [x, y + 1.0, z])),
        ("c_", moved(unit_grid(2, 2), |[x, y, z]| [x + 3.0, y, z])),
    ]));
    let loose = Scene {
        supports: vec![support("a_y0", HELD_IN_PLANE)],
        contacts: between("b_y0", "a_y1"),
        ..linear([("a_body", 1.0), ("b_body", 2.0), ("c_body", 2.0)])
    };
    let error = Plan::new(&loose, &[], &mesh).expect_err("a fault");
    let message = format!("{error:?}");
    let expected = "nothing holds or meets part 2 of the mesh";
    assert!(message.contains(expected), "{message}");
}

#[test]
fn a_plan_says_who_carries_and_why() {
    let mut scene = scene();
    scene.contacts[0].carries = None;
    let mut said = |change: &dyn Fn(&mut Scene)| {
        change(&mut scene);
        let plan = Plan::new(&scene, &[], &file("pair_box_6_8")).expect("a valid scene");
        let entries = plan.report().decisions;
        let own = entries
            .into_iter()
            .find(|entry| entry.what == "contact pair");
        let own = own.expect("an entry");
        format!("{}: {}", own.choice, own.reason)
    };
    let finer = said(&|_| {});
    assert!(
        finer.ends_with("bodies are alike, its faces are smaller"),
        "{finer}"
    );
    let softer =
        said(&|scene| scene.materials[0] = linear([("a", 0.1), ("b", 2.0)]).materials[0].clone());
    assert_eq!(
        softer,
        "`a_top` carries 13 pressures, gaps by volume: it is the softer one"
    );
    let tool = said(&|scene| {
        scene.obstacles = vec![obstacle(
            "wall",
            "a_left",
            plane([-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]),
        )];
    });
    assert_eq!(tool, softer);
}

#[test]
fn two_groups_with_a_common_facet_and_bodies_that_meet_themselves_alone_are_refused() {
    let parts = with_union(file_parts("fold_12_10"), "slit", &["f_upper", "f_lower"]);
    let folded = mesh(parts);
    let scene = |contacts, supports| Scene {
        contacts,
        supports,
        ..linear([("body_f", 1.0)])
    };
    let held = vec![support("f_left", HELD_IN_PLANE)];
    let refused = |scene: Scene| {
        let error = Plan::new(&scene, &[], &folded).expect_err("a fault");
        format!("{error:?}")
    };
    let common = refused(scene(between("slit", "f_upper"), held));
    assert!(
        common.contains("both groups have the same facets"),
        "{common}"
    );
    let loose = refused(scene(of_itself("slit"), Vec::new()));
    let expected = "nothing holds the body against translation along x";
    assert!(loose.contains(expected), "{loose}");
}
