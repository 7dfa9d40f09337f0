//! Scenes of the stories. All ask for the independent verification.

use std::sync::Arc;

use signorini::scene::{
    Formulation, Material, MaterialModel, Modulus, Obstacle, ObstacleTarget, PenetrationPolicy,
    Probe, Profile, RubberModel, Shape, Support, SupportTarget, SurfaceGeometry, Traction,
};
use signorini::{Mesh, Scene, Step};

/// All components held at zero.
pub(crate) const HELD: [Option<f64>; 3] = [Some(0.0); 3];

/// Both components of a plane body held at zero.
pub(crate) const HELD_IN_PLANE: [Option<f64>; 3] = [Some(0.0), Some(0.0), None];

/// A body of shear modulus one, without supports and loads.
pub(crate) fn elastic(poisson_ratio: f64) -> Scene {
    let mut scene = Scene {
        name: "story".to_owned(),
        materials: vec![material(Modulus::Shear(1.0), poisson_ratio)],
        ..Scene::default()
    };
    scene.solver.verify = true;
    scene
}

/// Linear elasticity in the group `body`.
pub(crate) fn material(modulus: Modulus, poisson_ratio: f64) -> Material {
    Material {
        group: "body".to_owned(),
        model: MaterialModel::LinearElastic {
            modulus,
            poisson_ratio,
            formulation: Formulation::Auto,
        },
    }
}

/// A body of rubber, without supports and loads.
pub(crate) fn rubber(model: RubberModel, bulk_modulus: Option<f64>) -> Scene {
    let mut scene = elastic(0.5);
    scene.materials[0].model = MaterialModel::Rubber {
        model,
        bulk_modulus,
        formulation: Formulation::Auto,
    };
    scene
}

/// The law of the reference problems, of shear modulus one.
pub(crate) fn mooney_rivlin() -> RubberModel {
    RubberModel::MooneyRivlin { c10: 0.4, c01: 0.1 }
}

/// A support named like its group.
pub(crate) fn support(on: &str, displacement: [Option<f64>; 3]) -> Support {
    Support {
        name: on.to_owned(),
        on: vec![on.to_owned()],
        normal: None,
        displacement,
        profile: Profile::Constant,
        values: None,
        load: Default::default(),
    }
}

/// A dead load on one group.
pub(crate) fn traction(on: &str, value: [f64; 3]) -> Traction {
    Traction {
        on: vec![on.to_owned()],
        value,
        ..Traction::default()
    }
}

/// A probe.
pub(crate) fn probe(name: &str, point: [f64; 3]) -> Probe {
    Probe {
        name: name.to_owned(),
        point,
    }
}

/// An obstacle that one group may touch.
pub(crate) fn obstacle(name: &str, on: &str, shape: Shape) -> Obstacle {
    Obstacle {
        name: name.to_owned(),
        on: vec![on.to_owned()],
        shape,
        surface: SurfaceGeometry::default(),
        friction: 0.0,
        tresca: None,
        initial_penetration: PenetrationPolicy::default(),
    }
}

/// A step that moves one obstacle from its initial pose.
pub(crate) fn push(name: &str, translation: [f64; 3]) -> Step {
    Step {
        obstacles: vec![ObstacleTarget {
            name: name.to_owned(),
            translation: Some(translation),
            ..ObstacleTarget::default()
        }],
        ..Step::default()
    }
}

/// A step of equal increments that moves and turns one obstacle from its initial pose.
pub(crate) fn travel(
    name: &str,
    increments: u32,
    translation: [f64; 3],
    rotation: [f64; 3],
) -> Step {
    let mut step = push(name, translation);
    step.increments = increments;
    step.obstacles[0].rotation = Some(rotation);
    step
}

/// A half-space whose free side `normal` points to.
pub(crate) fn plane(point: [f64; 3], normal: [f64; 3]) -> Shape {
    Shape::HalfSpace { point, normal }
}

/// A step that moves one support.
pub(crate) fn pull(name: &str, displacement: [Option<f64>; 3], increments: u32) -> Step {
    Step {
        increments,
        supports: vec![SupportTarget {
            name: name.to_owned(),
            displacement,
            ..SupportTarget::default()
        }],
        ..Step::default()
    }
}

/// Step data that turns one support by a rotation vector about a point.
pub(crate) fn turned(name: &str, rotation: [f64; 3], about: [f64; 3]) -> SupportTarget {
    SupportTarget {
        name: name.to_owned(),
        rotation: Some(rotation),
        about: Some(about),
        ..SupportTarget::default()
    }
}

/// A plane over the unit cube.
pub(crate) fn press(on: &str) -> Obstacle {
    let shape = Shape::HalfSpace {
        point: [0.0, 0.0, 1.0],
        normal: [0.0, 0.0, -1.0],
    };
    obstacle("press", on, shape)
}

/// Rollers on the three sides of the unit cube at the origin.
pub(crate) fn rollers() -> Vec<Support> {
    vec![
        support("x0", [Some(0.0), None, None]),
        support("y0", [None, Some(0.0), None]),
        support("z0", [None, None, Some(0.0)]),
    ]
}

/// A cube of rubber under a plane that presses by a quarter: between
/// frictionless planes, and the increments of its reference.
pub(crate) fn squeezed_cube() -> (Scene, Step) {
    let mut scene = rubber(mooney_rivlin(), None);
    scene.supports = rollers();
    scene.obstacles = vec![press("z1")];
    (scene, in_parts(push("press", [0.0, 0.0, -0.25]), 5))
}

/// The same, bonded below with free sides.
pub(crate) fn bonded_cube() -> (Scene, Step) {
    let (mut scene, step) = squeezed_cube();
    scene.supports = vec![support("z0", HELD)];
    (scene, in_parts(step, 10))
}

/// A quarter of a block of rubber under a sphere.
pub(crate) fn indented_block() -> (Scene, Step) {
    let (block, _) = hertz_sphere(0.5);
    let scene = Scene {
        supports: block.supports,
        obstacles: block.obstacles,
        ..rubber(mooney_rivlin(), None)
    };
    (scene, in_parts(push("ball", [0.0, 0.0, -0.125]), 5))
}

/// `step` in equal parts.
pub(crate) fn in_parts(mut step: Step, increments: u32) -> Step {
    step.increments = increments;
    step
}

/// The unit cube clamped at x0 and sheared at x1.
pub(crate) fn cube_bend(poisson_ratio: f64) -> Scene {
    let mut scene = elastic(poisson_ratio);
    scene.supports = vec![support("x0", HELD)];
    scene.tractions = vec![traction("x1", [0.0, 0.0, -1.0])];
    scene.probes = vec![probe("corner", [1.0; 3])];
    scene
}

/// Quarter block on `indent` meshes; the caller adds what presses on z1.
pub(crate) fn quarter_block(poisson_ratio: f64) -> Scene {
    let mut scene = elastic(poisson_ratio);
    scene.supports = vec![
        support("z0", HELD),
        support("x0", [Some(0.0), None, None]),
        support("y0", [None, Some(0.0), None]),
    ];
    scene.probes = vec![probe("pole", [0.0; 3])];
    scene
}

/// A quarter block under a rigid sphere, and the step that presses by 0.05.
pub(crate) fn hertz_sphere(poisson_ratio: f64) -> (Scene, Step) {
    let mut scene = quarter_block(poisson_ratio);
    let shape = Shape::Sphere {
        centre: [0.0, 0.0, 1.0],
        radius: 1.0,
    };
    scene.obstacles = vec![obstacle("ball", "z1", shape)];
    scene.solver.tolerance = 1e-10;
    (scene, push("ball", [0.0, 0.0, -0.05]))
}

/// Quarter of a half ball on `hemi` meshes, held at its top.
pub(crate) fn quarter_ball(poisson_ratio: f64) -> Scene {
    let mut scene = elastic(poisson_ratio);
    scene.supports = vec![
        support("top", HELD),
        support("x0", [Some(0.0), None, None]),
        support("y0", [None, Some(0.0), None]),
    ];
    scene.probes = vec![probe("pole", [0.0, 0.0, -1.0])];
    scene
}

/// A quarter ball and a plane pressed up by 0.05.
pub(crate) fn hertz_plane(poisson_ratio: f64) -> (Scene, Step) {
    let mut scene = quarter_ball(poisson_ratio);
    let shape = Shape::HalfSpace {
        point: [0.0, 0.0, -1.0],
        normal: [0.0, 0.0, 1.0],
    };
    scene.obstacles = vec![obstacle("floor", "contact", shape)];
    scene.solver.tolerance = 1e-10;
    (scene, push("floor", [0.0, 0.0, 0.05]))
}

/// A small block, bonded at z0, under a sphere: the irregular unit cube.
pub(crate) fn small_indentation(mesh_cells: usize) -> (Scene, Arc<Mesh>) {
    let parts = super::meshes::irregular(super::meshes::cube(mesh_cells), mesh_cells);
    let mut scene = elastic(0.5);
    scene.supports = vec![support("z0", HELD)];
    let shape = Shape::Sphere {
        centre: [0.45, 0.55, 2.0],
        radius: 1.0,
    };
    scene.obstacles = vec![obstacle("ball", "z1", shape)];
    scene.probes = vec![probe("top", [0.45, 0.55, 1.0])];
    (scene, super::meshes::mesh(parts))
}
