//! Loads on a block that stands on a frictional plane, and lids over one in a box.

use std::sync::Arc;

use super::*;
use crate::mesh::samples;
use crate::model::conditions::Conditions;
use crate::model::interfaces::Interfaces;
use crate::model::loads::reference_load;
use crate::plan::Plan;
use crate::prepare::TaylorHoodData;
use crate::report::CancelToken;
use crate::saddle::Status;
use crate::scene::{
    Formulation, Material, MaterialModel, Obstacle, Pressure, Profile, RubberModel, Scene, Shape,
    Step, Support, SurfaceGeometry, Traction,
};

/// A block of rubber on a plane with a coefficient of friction of 0.3, `pull` on the side x1.
fn standing(pull: [f64; 3]) -> Scene {
    Scene {
        materials: vec![Material {
            group: "body".to_owned(),
            model: MaterialModel::Rubber {
                model: RubberModel::NeoHookean { shear_modulus: 1.0 },
                bulk_modulus: None,
                formulation: Formulation::Auto,
            },
        }],
        obstacles: vec![Obstacle {
            name: "floor".to_owned(),
            on: vec!["z0".to_owned()],
            shape: Shape::HalfSpace {
                point: [0.0; 3],
                normal: [0.0, 0.0, 1.0],
            },
            surface: SurfaceGeometry::default(),
            friction: 0.3,
            tresca: None,
            initial_penetration: crate::scene::PenetrationPolicy::default(),
        }],
        tractions: vec![on("x1", pull)],
        ..Scene::default()
    }
}

fn on(group: &str, value: [f64; 3]) -> Traction {
    Traction {
        on: vec![group.to_owned()],
        value,
        ..Traction::default()
    }
}

/// What `ask` finds of that scene at rest at that load factor.
fn found<T>(scene: &Scene, load: f64, ask: impl Fn(&Model<'_>, &mut State) -> T) -> T {
    let mesh = Arc::new(samples::cube(2));
    let plan = Plan::new(scene, &[Step::default()], &mesh).expect("a valid scene");
    let prepared =
        TaylorHoodData::build(&plan, &mesh, &CancelToken::new()).expect("a solvable body");
    let model = Model {
        plan: &plan,
        mesh: &mesh,
        interfaces: &Interfaces::new(&plan, &mesh, &prepared.space),
        load: &reference_load(&plan, &mesh, &prepared),
        prepared: &prepared,
        conditions: Conditions::to(1e-8),
    };
    let mut state = State::undeformed(&plan);
    state.drive.load = load;
    ask(&model, &mut state)
}

fn slides(scene: &Scene, load: f64) -> Option<bool> {
    found(scene, load, |model, state| slides_off(model, state))
}

/// Whether a lid at that height closes a box without friction.
fn is_closed(height: f64, status: Status) -> bool {
    let mut scene = standing([0.0; 3]);
    scene.tractions.clear();
    let floor = scene.obstacles.remove(0);
    scene.obstacles = vec![Obstacle {
        name: "lid".to_owned(),
        on: vec!["z1".to_owned()],
        shape: Shape::HalfSpace {
            point: [0.0, 0.0, height],
            normal: [0.0, 0.0, -1.0],
        },
        friction: 0.0,
        ..floor
    }];
    let sides = ["x0", "x1", "y0", "y1", "z0"];
    scene.supports = vec![Support {
        name: "box".to_owned(),
        on: sides.map(str::to_owned).to_vec(),
        normal: Some(0.0),
        displacement: [None; 3],
        profile: Profile::Constant,
        values: None,
        load: Default::default(),
    }];
    found(&scene, 1.0, |model, state| {
        state.status.fill(status);
        is_closed_by_contact(model, state, &mut Workspace::new())
    })
}

#[test]
fn a_lid_closes_a_box_where_it_is_near_or_touches() {
    for (height, status, expected) in [
        (1.0, Status::Open, true),
        (0.95, Status::Open, true),
        (51.0, Status::Open, false),
        (51.0, Status::Stick, true),
    ] {
        let found = is_closed(height, status);
        assert_eq!(found, expected, "{height} {status:?}");
    }
}

#[test]
fn a_load_outside_of_the_cone_of_friction_slides_off() {
    for (pull, is_sliding) in [([0.2, 0.0, -1.0], false), ([0.4, 0.0, -1.0], true)] {
        assert_eq!(slides(&standing(pull), 1.0), Some(is_sliding), "{pull:?}");
        assert_eq!(slides(&standing(pull), 0.0), None, "{pull:?}");
    }
}

#[test]
fn follower_pressures_hold_a_body_on_its_plane() {
    let mut scene = standing([0.2, 0.0, 0.0]);
    assert_eq!(slides(&scene, 1.0), Some(true));
    scene.pressures = vec![Pressure {
        on: vec!["z1".to_owned()],
        value: 1.0,
    }];
    assert_eq!(slides(&scene, 1.0), Some(false));
}

#[test]
fn the_rounding_of_tractions_that_balance_has_no_direction() {
    let mut scene = standing([0.1, 0.7, 0.3]);
    scene.tractions.push(on("x0", [-0.1, -0.7, -0.3]));
    scene.tractions.push(on("z1", [0.1, -0.1, 0.3]));
    scene.tractions.push(on("y1", [-0.1, 0.1, -0.3]));
    assert_eq!(slides(&scene, 1.0), None);
}
