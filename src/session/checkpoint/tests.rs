//! Every field travels, and every key of a scene counts.

use std::sync::Arc;

use super::{Checkpoint, CheckpointError, MOST_STEPS, Rounding, scene_digest};
use crate::mesh::samples;
use crate::model::push::Push;
use crate::obstacle::grid::{HeightField, Lattice};
use crate::plan::Plan;
use crate::saddle::Status;
use crate::scene::validate::{Spread, Table};
use crate::scene::{
    Choice, ElementKind, Formulation, Material, MaterialModel, Modulus, Obstacle, Pressure, Probe,
    Profile, RubberModel, Scene, SceneKind, Shape, Support, ToleranceRule, Traction, ValuePlace,
    Values,
};

/// An incompressible block on a support under a ball.
fn scene() -> Scene {
    Scene {
        materials: vec![Material {
            group: "body".to_owned(),
            model: MaterialModel::LinearElastic {
                modulus: Modulus::Shear(2.0),
                poisson_ratio: 0.5,
                formulation: Formulation::Auto,
            },
        }],
        supports: vec![Support {
            name: "wall".to_owned(),
            on: vec!["z0".to_owned()],
            normal: None,
            displacement: [Some(0.0); 3],
            profile: Profile::Constant,
            values: None,
            load: Default::default(),
        }],
        obstacles: vec![Obstacle {
            name: "ball".to_owned(),
            on: vec!["z1".to_owned()],
            shape: Shape::Sphere {
                centre: [0.5, 0.5, 2.0],
                radius: 1.0,
            },
            surface: crate::scene::SurfaceGeometry::default(),
            friction: 0.0,
            tresca: None,
            initial_penetration: crate::scene::PenetrationPolicy::default(),
        }],
        ..Scene::default()
    }
}

fn plan() -> Plan {
    Plan::new(&scene(), &[], &samples::cube(2)).expect("a valid scene")
}

fn at_rest(plan: &Plan) -> Checkpoint {
    Checkpoint {
        steps: 1,
        ..Checkpoint::shaped(plan)
    }
}

/// Values of another code at one node.
fn row(node: u32, value: f64) -> Values {
    Values {
        place: ValuePlace::Nodes,
        numbers: vec![node],
        rows: vec![[value, 0.0, 0.0]],
    }
}

/// The same as a drive has them.
fn spread(keys: &[u32], value: f64) -> Spread {
    Spread {
        nodes: Table {
            keys: keys.into(),
            rows: keys.iter().map(|_| [value; 3]).collect(),
        },
        ..Spread::default()
    }
}

#[test]
fn tables_of_any_claimed_length_are_refused_without_memory_for_them() {
    let plan = plan();
    let mut one = at_rest(&plan);
    one.target.given.supports = vec![spread(&[1, 2], 0.5)];
    let bytes = one.encode(&plan);
    let written = [2_u64.to_le_bytes().as_slice(), &1_u32.to_le_bytes()].concat();
    let place = bytes.windows(written.len()).position(|at| at == written);
    let place = place.expect("the count of rows");
    let sealed = |change: &dyn Fn(&mut [u8])| {
        let mut changed = bytes.clone();
        change(&mut changed);
        let end = changed.len() - 32;
        let seal = <sha2::Sha256 as sha2::Digest>::digest(&changed[..end]);
        changed[end..].copy_from_slice(&seal);
        Checkpoint::decode(&plan, &changed, Rounding::Same)
    };
    for count in [3, 1 << 20, 1 << 60, u64::MAX] {
        let claimed = sealed(&|all| all[place..place + 8].copy_from_slice(&count.to_le_bytes()));
        assert!(claimed.is_err(), "{count}");
    }
    let twice = sealed(&|all| all[place + 8] = 2);
    let message = twice.expect_err("a number twice").to_string();
    assert!(message.contains("do not ascend"), "{message}");
}

/// A push of the ball along one axis.
fn pushed(axis: usize, value: f64) -> Vec<Push> {
    let mut push = Push::default();
    push.components[axis] = Some(value);
    vec![push]
}

#[test]
fn every_field_is_read_back_and_changes_the_bytes() {
    let plan = plan();
    let rest = at_rest(&plan);
    let changes: [fn(&mut Checkpoint); 31] = [
        |one| one.steps += 1,
        |one| one.moved = true,
        |one| one.begun = None,
        |one| one.begun.iter_mut().for_each(|begun| begun.load = 0.25),
        |one| one.target.load = 0.5,
        |one| one.target.poses[0].translation[2] = -0.5,
        |one| one.target.poses[0].rotation[0] = -0.0,
        |one| one.target.pushes = pushed(2, -0.5),
        |one| one.state.drive.pushes = pushed(5, 0.0),
        |one| {
            one.begun
                .iter_mut()
                .for_each(|begun| begun.pushes = pushed(0, 1.0))
        },
        |one| one.target.support_pushes = pushed(1, -0.5),
        |one| one.state.drive.support_pushes = pushed(4, 0.0),
        |one| one.state.displacement[7] = 1e-300,
        |one| one.state.pressure[3] = -2.0,
        |one| one.state.multiplier[1] = f64::MIN_POSITIVE / 4.0,
        |one| one.state.status[8] = Status::Stick,
        |one| one.state.drive.load = f64::MAX,
        |one| one.state.drive.poses[0].translation[0] = 0.1,
        |one| one.state.drive.supports[0][2] = 0.1,
        |one| one.state.drive.motions[0].translation[1] = 0.1,
        |one| one.state.drive.motions[0].rotation[1] = 0.1,
        |one| one.state.drive.motions[0].about[1] = 0.1,
        |one| one.state.scales.constraint = 0.1,
        |one| one.state.scales.gap = 0.1,
        |one| one.state.force_scale = 0.1,
        |one| one.state.penalty = 0.1,
        |one| one.state.by_factor = true,
        |one| one.target.given.supports = vec![spread(&[0, 7], -0.0)],
        |one| one.target.given.supports = vec![spread(&[0, 8], -0.0)],
        |one| one.state.drive.given.tractions = vec![Spread::default(), spread(&[3], 1.0)],
        |one| one.state.drive.given.body_force = vec![spread(&[], 1.0)],
    ];
    let bytes = rest.clone().encode(&plan);
    assert_eq!(
        Checkpoint::decode(&plan, &bytes, Rounding::Same),
        Ok(rest.clone())
    );
    for (index, change) in changes.into_iter().enumerate() {
        let mut changed = rest.clone();
        change(&mut changed);
        let other = changed.clone().encode(&plan);
        assert_ne!(other, bytes, "{index}");
        let read = Checkpoint::decode(&plan, &other, Rounding::Same).expect("what was written");
        assert_eq!(read, changed, "{index}");
        // Equal numbers may differ in the sign of a zero.
        assert_eq!(read.encode(&plan), other, "{index}");
    }
}

/// A change, and the field that it spoils.
type Fault = (fn(&mut Checkpoint), &'static str);

#[test]
fn what_no_session_writes_is_refused_by_the_name_of_the_field() {
    let plan = plan();
    let cases: [Fault; 7] = [
        (|one| one.steps = 0, "steps"),
        (|one| one.steps = MOST_STEPS, "steps"),
        (|one| one.state.penalty = -1.0, "penalty"),
        (|one| one.state.force_scale = f64::NAN, "scale of the force"),
        (|one| one.state.pressure[0] = f64::INFINITY, "pressure"),
        (|one| one.state.displacement[0] = f64::NAN, "displacement"),
        (|one| one.state.status.truncate(1), "contact statuses"),
    ];
    for (change, expected) in cases {
        let mut changed = at_rest(&plan);
        change(&mut changed);
        match Checkpoint::decode(&plan, &changed.encode(&plan), Rounding::Same) {
            Err(CheckpointError::Malformed { field, .. }) => assert_eq!(field, expected),
            other => panic!("{expected}: {other:?}"),
        }
    }
}

#[test]
fn a_drive_of_other_obstacles_is_refused() {
    let plan = plan();
    let mut changed = at_rest(&plan);
    changed.target.poses.clear();
    let refusal = Checkpoint::decode(&plan, &changed.encode(&plan), Rounding::Same);
    let message = refusal.expect_err("a refusal").to_string();
    assert!(
        message.contains("`obstacles` has another length"),
        "{message}"
    );
}

#[test]
fn every_key_of_a_scene_counts_but_its_name_and_its_limit_of_time() {
    let changes: [fn(&mut Scene); 31] = [
        |scene| scene.mesh_scale = Some(2.0),
        |scene| scene.kind = Some(SceneKind::Solid),
        |scene| scene.materials[0].group.push('s'),
        |scene| {
            let model = RubberModel::NeoHookean { shear_modulus: 2.0 };
            let (bulk_modulus, formulation) = (None, Formulation::Auto);
            scene.materials[0].model = MaterialModel::Rubber {
                model,
                bulk_modulus,
                formulation,
            };
        },
        |scene| {
            scene.materials[0].model = MaterialModel::LinearElastic {
                modulus: Modulus::Young(2.0),
                poisson_ratio: 0.5,
                formulation: Formulation::Auto,
            };
        },
        |scene| scene.supports[0].name.push('s'),
        |scene| scene.supports[0].on.push("x0".to_owned()),
        |scene| scene.supports[0].displacement[0] = None,
        |scene| scene.supports[0].normal = Some(0.0),
        |scene| scene.supports[0].profile = Profile::Parabolic,
        |scene| scene.supports[0].load.force[0] = Some(0.0),
        |scene| scene.supports[0].load.moment[0] = Some(0.0),
        |scene| scene.supports[0].load.stiffness[0] = Some(0.0),
        |scene| scene.supports[0].load.about = Some([0.0, 0.0, 1.0]),
        |scene| {
            let (on, value) = (Vec::new(), [0.0; 3]);
            let rest = Traction::default();
            scene.tractions.push(Traction { on, value, ..rest });
        },
        |scene| {
            let (on, value) = (Vec::new(), 0.0);
            scene.pressures.push(Pressure { on, value });
        },
        |scene| scene.body_force[2] = -0.0,
        |scene| scene.obstacles[0].on.clear(),
        |scene| {
            let (point, normal) = ([0.5, 0.5, 2.0], [0.0, 0.0, 1.0]);
            scene.obstacles[0].shape = Shape::HalfSpace { point, normal };
        },
        |scene| scene.manufactured = Some("rotation".to_owned()),
        |scene| {
            let (name, point) = (String::new(), [0.0; 3]);
            scene.probes.push(Probe { name, point });
        },
        |scene| scene.solver.tolerance_rule = ToleranceRule::Discretisation,
        |scene| scene.solver.element = Choice::Named(ElementKind::TaylorHood),
        |scene| scene.solver.penalty = Some(0.0),
        |scene| scene.solver.verify = true,
        |scene| scene.supports[0].values = Some(Values::default()),
        |scene| scene.supports[0].values = Some(row(0, 0.0)),
        |scene| scene.supports[0].values = Some(row(1, 0.0)),
        |scene| scene.body_force_values = Some(row(0, 1.0)),
        |scene| {
            let values = Some(row(0, 0.0));
            let rest = Traction::default();
            scene.tractions.push(Traction { values, ..rest });
        },
        |scene| {
            let name = Some("wind".to_owned());
            let rest = Traction::default();
            scene.tractions.push(Traction { name, ..rest });
        },
    ];
    let mut digests = vec![scene_digest::of(&scene())];
    for change in changes {
        let mut changed = scene();
        change(&mut changed);
        digests.push(scene_digest::of(&changed));
    }
    let count = digests.len();
    digests.sort_unstable();
    digests.dedup();
    assert_eq!(digests.len(), count);
    let mut same = scene();
    same.name.push('s');
    same.solver.max_wall_time = Some(1.0);
    assert!(scene_digest::of(&same) == scene_digest::of(&scene()));
}

#[test]
fn every_number_of_a_grid_counts_in_a_scene() {
    let plane = |counts: [usize; 2], first: f64| {
        let lattice = Lattice {
            counts,
            origin: [0.0; 2],
            spacing: [1.0; 2],
        };
        let mut values = vec![0.25; 20];
        values[0] = first;
        let field = HeightField::new(lattice, &values).expect("a field");
        Shape::HeightField(Arc::new(field))
    };
    let inside = |shape: Shape| Shape::Cavity(Arc::new(shape));
    let shapes = [
        plane([4, 5], 0.25),
        plane([5, 4], 0.25),
        plane([4, 5], 0.26),
        inside(plane([4, 5], 0.25)),
    ];
    let digest = |shape: Shape| {
        let mut scene = scene();
        scene.obstacles[0].shape = shape;
        scene_digest::of(&scene)
    };
    let mut digests = shapes.map(digest).to_vec();
    digests.sort_unstable();
    digests.dedup();
    assert_eq!(digests.len(), 4);
    assert!(digests.contains(&digest(plane([4, 5], 0.25))));
}
