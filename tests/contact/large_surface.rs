//! Surfaces larger than a dense compliance may be.

use crate::common::meshes::{mesh, moved, unit_box};
use crate::common::scenes::{HELD, elastic, obstacle, push, support};
use crate::common::solve_one;
use signorini::Plan;
use signorini::scene::Shape;

/// A ball on a plate with 3136 vertices in reach, more than a dense compliance knows.
#[test]
fn a_small_tool_on_a_large_surface_asks_for_the_compliance_beside_it_alone() {
    let mut scene = elastic(0.3);
    scene.supports = vec![support("z0", HELD)];
    scene.solver.tolerance = 1e-6;
    scene.solver.verify = true;
    let shape = Shape::Sphere {
        centre: [0.3, 0.4, 0.15],
        radius: 0.1,
    };
    scene.obstacles = vec![obstacle("ball", "z1", shape)];
    let plate = mesh(moved(unit_box([55, 55, 1]), |[x, y, z]| [x, y, 0.05 * z]));
    // Far from where the plan of the first session expects it, too.
    let step = push("ball", [0.0, 0.0, -0.002]);
    let plan = Plan::new(&scene, std::slice::from_ref(&step), &plate).expect("a plan");
    let entries = plan.report().decisions;
    let contact = entries.iter().find(|entry| entry.what == "contact");
    let contact = contact.expect("a decision");
    assert!(contact.choice.starts_with("one level"), "{contact:?}");
    assert!(
        contact.reason.contains("nearest to the tools"),
        "{contact:?}"
    );
    let report = solve_one(&scene, &step, &plate);
    assert!(
        report.preconditioner_applications <= 60,
        "{}",
        report.preconditioner_applications
    );
    let elsewhere = push("ball", [0.5, 0.4, -0.002]);
    solve_one(&scene, &elsewhere, &plate);
}
