//! What has a maximum in a scene: its key, the maximum, and a scene of that size.

use signorini_proto::v1 as wire;

use crate::common::press;

/// A key of the scene, its maximum, and how it is given a size.
pub(crate) type SceneCase = (&'static str, usize, fn(&mut wire::Scene, usize));

pub(crate) fn word(bytes: usize) -> String {
    "n".repeat(bytes)
}

pub(crate) fn words(count: usize) -> Vec<String> {
    (0..count).map(|index| format!("g{index}")).collect()
}

fn solver(scene: &mut wire::Scene) -> &mut wire::SolverOptions {
    scene.solver.get_or_insert_default()
}

fn ogden(terms: usize) -> Option<wire::material::Model> {
    Some(wire::material::Model::Ogden(wire::Ogden {
        mu: vec![1.0; terms],
        alpha: vec![2.0; terms.min(3)],
        bulk_modulus: None,
    }))
}

fn hyperfoam(terms: usize) -> Option<wire::material::Model> {
    Some(wire::material::Model::Hyperfoam(wire::Hyperfoam {
        mu: vec![1.0; terms.min(6)],
        alpha: vec![2.0; terms.min(6)],
        nu: vec![0.1; terms],
    }))
}

fn moved(name: String) -> wire::ObstacleTarget {
    wire::ObstacleTarget {
        name,
        ..Default::default()
    }
}

fn held(name: String) -> wire::SupportTarget {
    wire::SupportTarget {
        name,
        ..Default::default()
    }
}

pub(crate) const LISTS: [SceneCase; 15] = [
    ("material", 4096, |scene, n| {
        scene.materials.resize(n, scene.materials[0].clone());
    }),
    ("support", 4096, |scene, n| {
        scene.supports.resize(n, scene.supports[0].clone());
    }),
    ("traction", 4096, |scene, n| {
        scene.tractions.resize(n, wire::Traction::default());
    }),
    ("pressure", 4096, |scene, n| {
        scene.pressures.resize(n, wire::Pressure::default());
    }),
    ("obstacle", 1000, |scene, n| {
        scene.obstacles.resize(n, scene.obstacles[0].clone());
    }),
    ("probe", 10_000, |scene, n| {
        scene.probes.resize(n, wire::Probe::default());
    }),
    ("step", 10_000, |scene, n| {
        scene.steps.resize(n, wire::LoadStep::default());
    }),
    ("output.fields", 100, |scene, n| {
        scene.output.get_or_insert_default().fields = vec![1; n];
    }),
    ("support.base.on", 1000, |scene, n| {
        scene.supports[0].on = words(n)
    }),
    ("obstacle.ball.on", 1000, |scene, n| {
        scene.obstacles[0].on = words(n)
    }),
    ("traction[0].on", 1000, |scene, n| {
        let (on, value) = (words(n), vec![0.0; 3]);
        scene.tractions = vec![wire::Traction {
            on,
            value,
            ..Default::default()
        }];
    }),
    ("material.body.mu", 3, |scene, n| {
        scene.materials[0].model = ogden(n)
    }),
    ("material.body.nu", 6, |scene, n| {
        scene.materials[0].model = hyperfoam(n)
    }),
    ("step[0].obstacle", 1000, |scene, n| {
        let obstacles = words(n).into_iter().map(moved).collect();
        scene.steps = vec![wire::LoadStep {
            obstacles,
            ..Default::default()
        }];
    }),
    ("step[0].support", 1000, |scene, n| {
        let supports = words(n).into_iter().map(held).collect();
        scene.steps = vec![wire::LoadStep {
            supports,
            ..Default::default()
        }];
    }),
];

pub(crate) const NAMES: [SceneCase; 15] = [
    ("name", 256, |scene, n| scene.name = word(n)),
    ("material", 256, |scene, n| {
        scene.materials[0].group = word(n)
    }),
    ("manufactured.field", 256, |scene, n| {
        scene.manufactured = word(n)
    }),
    ("support.base.on", 256, |scene, n| {
        scene.supports[0].on = vec![word(n)]
    }),
    ("solver.saddle", 256, |scene, n| {
        solver(scene).saddle = word(n)
    }),
    ("solver.displacement_preconditioner", 256, |scene, n| {
        solver(scene).displacement_preconditioner = word(n);
    }),
    ("solver.p1_solver", 256, |scene, n| {
        solver(scene).p1_solver = word(n)
    }),
    ("solver.contact", 256, |scene, n| {
        solver(scene).contact = word(n)
    }),
    ("solver.contact_space", 256, |scene, n| {
        solver(scene).contact_space = word(n)
    }),
    ("solver.stability", 256, |scene, n| {
        solver(scene).stability = word(n)
    }),
    ("solver.on_instability", 256, |scene, n| {
        solver(scene).on_instability = word(n)
    }),
    ("solver.response", 256, |scene, n| {
        solver(scene).response = word(n)
    }),
    ("solver.report", 256, |scene, n| {
        solver(scene).report = word(n)
    }),
    ("solver.contact_metric", 256, |scene, n| {
        solver(scene).contact_metric = word(n)
    }),
    ("solver.error_estimate", 256, |scene, n| {
        solver(scene).error_estimate = word(n)
    }),
];

pub(crate) const NUMBERS: [SceneCase; 3] = [
    ("output.every", 100_000, |scene, n| {
        scene.output.get_or_insert_default().every = Some(n as i32);
    }),
    ("step[0].increments", 100_000, |scene, n| {
        scene.steps = vec![press(0.1, n as i32)];
    }),
    ("solver.quadrature_degree", 20, |scene, n| {
        solver(scene).quadrature_degree = Some(n as i32)
    }),
];
