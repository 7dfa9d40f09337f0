//! Bodies that a support pushes against each other.

use crate::common::meshes::curved_file;
use crate::common::scenes::{HELD_IN_PLANE, pull, support};
use crate::common::{assert_converged, close, solve};
use crate::scenes::{between, linear, rubber};
use signorini::scene::SupportTarget;
use signorini::{Scene, Step, StepReport};

const FORCE: f64 = -0.1;

/// A half disc on a slab, at rest.
fn disc(scene: Scene, friction: f64) -> Scene {
    let mut contacts = between("d_con", "s_top");
    contacts[0].friction = friction;
    Scene {
        supports: vec![
            support("s_bot", HELD_IN_PLANE),
            support("d_top", HELD_IN_PLANE),
        ],
        contacts,
        ..scene
    }
}

fn push() -> Step {
    Step {
        supports: vec![SupportTarget {
            name: "d_top".to_owned(),
            force: [None, Some(FORCE), None],
            ..SupportTarget::default()
        }],
        ..Step::default()
    }
}

fn last(scene: &Scene, steps: &[Step]) -> StepReport {
    let reports = solve(scene, steps, &curved_file("pair_slide"));
    reports.iter().for_each(assert_converged);
    reports.into_iter().last().expect("a report")
}

/// How far the disc goes, which led as far exerts the force.
fn travel(scene: &Scene, before: &[Step]) -> f64 {
    let steps: Vec<Step> = before.iter().cloned().chain([push()]).collect();
    let found = last(scene, &steps);
    let force = found.contacts["pair"].force[1];
    assert!(close(force.abs(), FORCE.abs(), 1e-7), "{force}");
    let support = &found.supports["d_top"];
    support.translation[1]
}

fn assert_led_alike(scene: &Scene, way: f64) {
    let led = last(scene, &[pull("d_top", [Some(0.0), Some(way), None], 1)]);
    let force = led.contacts["pair"].force[1];
    assert!(close(force.abs(), FORCE.abs(), 1e-6), "{force}");
}

#[test]
fn a_disc_that_is_pushed_onto_a_slab_goes_as_far_as_one_that_is_led() {
    let laws = [("disc", 1.0), ("slab", 2.0)];
    for scene in [rubber(laws, None), linear(laws)] {
        let scene = disc(scene, 0.0);
        let way = travel(&scene, &[]);
        assert_led_alike(&scene, way);
        let lift = |height: f64| Step {
            supports: vec![SupportTarget {
                name: "d_top".to_owned(),
                translation: Some([0.0, height, 0.0]),
                ..SupportTarget::default()
            }],
            ..Step::default()
        };
        for height in [0.03, 0.4] {
            let found = travel(&scene, &[lift(height)]);
            assert!(close(found, way, 1e-6), "{height}: {found} {way}");
        }
    }
}

#[test]
fn a_rough_disc_that_is_pushed_finds_its_slab_too() {
    let scene = disc(rubber([("disc", 1.0), ("slab", 2.0)], None), 0.2);
    let way = travel(&scene, &[]);
    assert_led_alike(&scene, way);
}
