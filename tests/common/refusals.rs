//! What the stories of faults share: the scenes they spoil, and how a refusal
//! reads.

use std::sync::Arc;

use signorini::scene::Shape;
use signorini::{Mesh, Plan, Scene, SceneError, Step, Violation};

use super::meshes::{cube, mesh};
use super::scenes::{HELD, elastic, obstacle, support};

pub(crate) fn block() -> Arc<Mesh> {
    mesh(cube(2))
}

/// All faults.
pub(crate) fn violations(scene: &Scene, steps: &[Step], mesh: &Mesh) -> Vec<Violation> {
    match Plan::new(scene, steps, mesh) {
        Err(SceneError::Invalid(violations)) => violations,
        other => panic!("{other:?}"),
    }
}

/// A fault on `path` whose message has all of `words`.
pub(crate) fn assert_refused(scene: &Scene, path: &str, words: &[&str]) {
    assert_step_refused(scene, &[], path, words);
}

pub(crate) fn assert_step_refused(scene: &Scene, steps: &[Step], path: &str, words: &[&str]) {
    let found = violations(scene, steps, &block());
    let on_path = |violation: &&Violation| violation.path == path;
    let violation = found
        .iter()
        .find(on_path)
        .unwrap_or_else(|| panic!("{path}: {found:?}"));
    for word in words {
        assert!(violation.message.contains(word), "{violation}");
    }
    let error = Plan::new(scene, steps, &block())
        .expect_err("a faulty scene")
        .to_string();
    assert!(error.contains(path), "{error}");
}

/// What this version does not serve.
pub(crate) fn unsupported(scene: &Scene, mesh: &Mesh) -> Violation {
    match Plan::new(scene, &[], mesh) {
        Err(SceneError::Unsupported(violation)) => violation,
        other => panic!("{other:?}"),
    }
}

pub(crate) fn with_ball(shape: Shape) -> Scene {
    let mut scene = elastic(0.5);
    scene.supports = vec![support("z0", HELD)];
    scene.obstacles = vec![obstacle("ball", "z1", shape)];
    scene
}

pub(crate) fn sphere(radius: f64) -> Shape {
    Shape::Sphere {
        centre: [0.5, 0.5, 2.0],
        radius,
    }
}
