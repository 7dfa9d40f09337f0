use std::f64::consts::{PI, TAU};

use super::*;
use crate::geometry::vector3::{norm, sub};
use crate::mesh::samples;
use crate::scene::{
    Formulation, Material, MaterialModel, Modulus, Obstacle, Profile, Scene, Shape, Support,
};

fn plan() -> Plan {
    let scene = Scene {
        materials: vec![Material {
            group: "body".to_owned(),
            model: MaterialModel::LinearElastic {
                modulus: Modulus::Shear(1.0),
                poisson_ratio: 0.3,
                formulation: Formulation::Auto,
            },
        }],
        supports: vec![Support {
            name: "wall".to_owned(),
            on: vec!["x0".to_owned()],
            normal: None,
            displacement: [Some(0.5), None, Some(0.0)],
            profile: Profile::Constant,
            values: None,
            load: Default::default(),
        }],
        obstacles: vec![Obstacle {
            name: "ball".to_owned(),
            on: vec!["z1".to_owned()],
            shape: Shape::Sphere {
                centre: [0.0; 3],
                radius: 1.0,
            },
            surface: crate::scene::SurfaceGeometry::default(),
            friction: 0.0,
            tresca: None,
            initial_penetration: crate::scene::PenetrationPolicy::default(),
        }],
        ..Scene::default()
    };
    Plan::new(&scene, &[], &samples::cube(1)).expect("a valid scene")
}

fn step() -> Step {
    Step {
        load: Some(-2.0),
        obstacles: vec![ObstacleTarget {
            name: "ball".to_owned(),
            translation: Some([1.0, 2.0, 3.0]),
            ..ObstacleTarget::default()
        }],
        supports: vec![SupportTarget {
            name: "wall".to_owned(),
            displacement: [None, None, Some(4.0)],
            ..SupportTarget::default()
        }],
        ..Step::default()
    }
}

/// Bits, so that equal means the same number.
fn bits(vector: [f64; 3]) -> [u64; 3] {
    vector.map(f64::to_bits)
}

#[test]
fn the_first_step_leads_to_full_load_and_the_scenes_values() {
    let target = Drive::first_target(&plan()).after(&plan(), &Step::default());
    assert_eq!(target.load.to_bits(), 1.0_f64.to_bits());
    assert_eq!(bits(target.supports[0]), bits([0.5, 0.0, 0.0]));
    assert_eq!(bits(target.poses[0].translation), bits([0.0; 3]));
}

#[test]
fn a_step_changes_what_it_names() {
    let first = Drive::first_target(&plan());
    let end = first.after(&plan(), &step());
    assert_eq!(end.load.to_bits(), (-2.0_f64).to_bits());
    assert_eq!(bits(end.supports[0]), bits([0.5, 0.0, 4.0]));
    assert_eq!(bits(end.poses[0].translation), bits([1.0, 2.0, 3.0]));
    assert_eq!(bits(end.poses[0].rotation), bits([0.0; 3]));
    assert_eq!(end.after(&plan(), &Step::default()), end);
}

#[test]
fn everything_ramps_linearly_and_ends_exactly() {
    let start = Drive::undeformed(&plan());
    let end = Drive::first_target(&plan()).after(&plan(), &step());
    let half = start.towards(&end, 0.5);
    assert!((half.load + 1.0).abs() < 1e-15);
    assert_eq!(bits(half.supports[0]), bits([0.25, 0.0, 2.0]));
    assert_eq!(bits(half.poses[0].translation), bits([0.5, 1.0, 1.5]));
    assert_eq!(start.towards(&end, 0.0), start);
    assert_eq!(start.towards(&end, 1.0), end);
}

/// A step that turns the wall about z through `turn`, then shifts it along x.
fn turning(turn: f64, about: [f64; 3], shift: f64) -> Step {
    Step {
        obstacles: vec![ObstacleTarget {
            name: "ball".to_owned(),
            rotation: Some([0.0, 0.0, turn]),
            ..ObstacleTarget::default()
        }],
        supports: vec![SupportTarget {
            name: "wall".to_owned(),
            translation: Some([shift, 0.0, 0.0]),
            rotation: Some([0.0, 0.0, turn]),
            about: Some(about),
            ..SupportTarget::default()
        }],
        ..Step::default()
    }
}

#[test]
fn several_turns_of_supports_and_obstacles_survive_a_ramp() {
    let start = Drive::undeformed(&plan());
    let end = start.after(&plan(), &turning(3.0 * TAU, [1.0, 0.0, 0.0], 0.0));
    let part = start.towards(&end, 0.25);
    assert_eq!(bits(part.poses[0].rotation), bits([0.0, 0.0, 0.75 * TAU]));
    // Three quarters of a turn about (1, 0, 0) lead from the origin to (1, 1, 0).
    let moved = part.motions[0].apply([0.0; 3]);
    assert!(norm(sub(moved, [1.0, 1.0, 0.0])) < 1e-15, "{moved:?}");
    assert!(part.moves_supports() && !start.moves_supports());
}

#[test]
fn a_motion_is_kept_until_a_step_names_another() {
    let first = Drive::first_target(&plan());
    let turned = first.after(&plan(), &turning(PI, [1.0, 0.0, 0.0], 0.5));
    let later = turned.after(&plan(), &step());
    assert_eq!(later.motions, turned.motions);
    assert_eq!(bits(later.supports[0]), bits([0.5, 0.0, 4.0]));
}

#[test]
fn a_motion_about_another_point_starts_where_the_last_one_ended() {
    let start = Drive::undeformed(&plan());
    let turned = start.after(&plan(), &turning(0.5 * PI, [1.0, 0.0, 0.0], 0.3));
    let end = turned.after(&plan(), &turning(PI, [0.0, 2.0, 0.0], -0.2));
    let point = [0.4, 0.7, -0.2];
    let soon = turned.towards(&end, 1e-9).motions[0].apply(point);
    let before = turned.motions[0].apply(point);
    assert!(norm(sub(soon, before)) < 1e-8, "{soon:?} {before:?}");
    let late = turned.towards(&end, 1.0 - 1e-9).motions[0].apply(point);
    let after = end.motions[0].apply(point);
    assert!(norm(sub(late, after)) < 1e-8, "{late:?} {after:?}");
}

#[test]
fn equal_increments_of_a_ramp_continue_each_other() {
    let start = Drive::undeformed(&plan());
    let end = start.after(&plan(), &turning(PI, [1.0, 0.0, 0.0], 0.3));
    let [a, b, c] = [0.1, 0.3, 0.8].map(|fraction| start.towards(&end, fraction));
    let further = c.continues(&a, &b).expect("the same direction");
    assert!((further - 2.5).abs() < 1e-12, "{further}");
    let back = a.continues(&b, &c).expect("the way back");
    assert!((back + 1.4).abs() < 1e-12, "{back}");
}

#[test]
fn another_direction_and_rest_continue_nothing() {
    let start = Drive::undeformed(&plan());
    let turned = start.after(&plan(), &turning(PI, [1.0, 0.0, 0.0], 0.3));
    let loaded = Drive {
        load: 1.0,
        ..turned.clone()
    };
    let further = loaded.towards(
        &turned.after(&plan(), &turning(2.0 * PI, [1.0, 0.0, 0.0], 0.6)),
        0.5,
    );
    assert_eq!(loaded.continues(&start, &turned), None);
    assert_eq!(further.continues(&turned, &loaded), None);
    assert_eq!(turned.continues(&start, &start), None);
    assert_eq!(turned.continues(&start, &turned), None);
}

#[test]
fn units_do_not_change_how_far_a_ramp_goes_on() {
    for unit in [1e-6, 1.0, 1e6] {
        let shifted = |by: f64| Drive {
            load: 0.5 * by,
            ..Drive::undeformed(&plan()).after(&plan(), &turning(by, [0.0; 3], unit * by))
        };
        let further = shifted(0.7).continues(&shifted(0.1), &shifted(0.3));
        assert!(further.is_some_and(|further| (further - 2.0).abs() < 1e-12));
    }
}
