//! What a solve holds at its peak against what its plan predicts. Alone in its process: the heap
//! is counted, and its peak is that of the largest body so far.

mod common;

use std::alloc::System;
use std::sync::Arc;

use cap::Cap;
use common::meshes::cube;
use common::scenes::{HELD, elastic, obstacle, push, support};
use common::{assert_converged, meshes};
use signorini::scene::Shape;
use signorini::{CancelToken, Mesh, Plan, Prepared, Reuse, Scene, Session, Silent, Step};

#[global_allocator]
static HEAP: Cap<System> = Cap::new(System, usize::MAX);

/// The unit cube, bonded at its foot, under a sphere.
fn indented(poisson_ratio: f64) -> (Scene, Step) {
    let mut scene = elastic(poisson_ratio);
    scene.supports = vec![support("z0", HELD)];
    let shape = Shape::Sphere {
        centre: [0.5, 0.5, 2.0],
        radius: 1.0,
    };
    scene.obstacles = vec![obstacle("ball", "z1", shape)];
    (scene, push("ball", [0.0, 0.0, -0.05]))
}

/// Bytes predicted for a first step, and those held beside the mesh at its peak. Only for a
/// body that is larger than all before.
fn memory(scene: &Scene, step: &Step, mesh: &Arc<Mesh>) -> [usize; 2] {
    let before = HEAP.allocated();
    let plan = Arc::new(Plan::new(scene, &[], mesh).unwrap());
    let predicted = plan.first_bytes() as usize;
    let prepared = Arc::new(Prepared::build(&plan, mesh, &CancelToken::new()).unwrap());
    let mut session = Session::new(plan, mesh.clone(), prepared, Reuse::Built);
    let mut run = session.begin_step(step).unwrap();
    let report = session.advance(&mut run, &mut Silent, &CancelToken::new());
    assert_converged(&report.unwrap());
    [predicted, HEAP.max_allocated() - before]
}

#[test]
fn a_plan_predicts_what_is_held_at_the_peak() {
    for (count, poisson_ratio) in [(12, 0.3), (12, 0.5), (20, 0.5)] {
        let (scene, step) = indented(poisson_ratio);
        let mesh = meshes::mesh(cube(count));
        let [predicted, peak] = memory(&scene, &step, &mesh);
        let numbers = format!("{count}: {predicted} bytes for {peak}");
        assert!(3 * predicted >= 2 * peak, "{numbers}");
        assert!(2 * predicted <= 3 * peak, "{numbers}");
    }
}
