//! A body against its mirror image is the body on a rigid plane.

use super::scenes::{between, joined, rubber};
use crate::common::meshes::{mesh, moved, unit_grid};
use crate::common::scenes::{HELD_IN_PLANE, obstacle, plane, support};
use crate::common::{close, solve_one};
use signorini::scene::SupportTarget;
use signorini::{MeshParts, Scene, Step, StepReport};

/// Blocks of a square each above and below y = 0, which mirrors them; the groups of both have their
/// names with `up_` and `low_`.
fn blocks() -> MeshParts {
    let upper = unit_grid(5, 4);
    let mut lower = moved(upper.clone(), |[x, y, z]| [x, -y, z]);
    lower.cells.chunks_mut(3).for_each(|cell| cell.swap(1, 2));
    joined(&[("up_", upper), ("low_", lower)])
}

fn squeezed(scene: &Scene, targets: Vec<SupportTarget>, parts: MeshParts) -> StepReport {
    let mut scene = scene.clone();
    scene.solver.tolerance = 1e-11;
    let step = Step {
        supports: targets,
        ..Step::default()
    };
    solve_one(&scene, &step, &mesh(parts))
}

#[test]
fn a_block_on_its_mirror_image_is_the_block_on_a_rigid_plane() {
    let law = rubber([("up_body", 1.0), ("low_body", 1.0)], Some(20.0));
    let pair = Scene {
        supports: vec![
            support("up_y1", HELD_IN_PLANE),
            support("low_y1", HELD_IN_PLANE),
        ],
        contacts: between("up_y0", "low_y0"),
        ..law
    };
    let target = |name: &str, way: f64| SupportTarget {
        name: name.to_owned(),
        displacement: [Some(0.0), Some(way), None],
        ..SupportTarget::default()
    };
    let together = vec![target("up_y1", -0.1), target("low_y1", 0.1)];
    let pair = squeezed(&pair, together, blocks());
    let mut alone = unit_grid(5, 4);
    alone
        .groups
        .iter_mut()
        .for_each(|group| group.name = format!("up_{}", group.name));
    let mut scene = rubber([("up_body", 1.0), ("low_body", 1.0)], Some(20.0));
    scene.materials.truncate(1);
    let tool = Scene {
        supports: vec![support("up_y1", HELD_IN_PLANE)],
        obstacles: vec![obstacle("floor", "up_y0", plane([0.0; 3], [0.0, 1.0, 0.0]))],
        ..scene
    };
    let tool = squeezed(&tool, vec![target("up_y1", -0.1)], alone);
    let [found, expected] = [
        pair.contacts["pair"].force[1],
        tool.obstacles["floor"].force[1],
    ];
    assert!(close(found, expected, 1e-9), "{found} {expected}");
    assert!(close(pair.strain_energy, 2.0 * tool.strain_energy, 1e-9));
    let [pair, tool] = [pair.sqp_iterations, tool.sqp_iterations];
    assert!(pair <= tool + 1, "{pair} {tool}");
}
