//! A body in space against its mirror image is the body on a rigid plane.

use signorini::scene::SupportTarget;
use signorini::{MeshParts, Scene, Step, StepReport};

use crate::common::meshes::{mesh, moved, unit_box};
use crate::common::scenes::{obstacle, plane, support};
use crate::common::{close, solve_one};
use crate::scenes::{between, joined, rubber};

const HELD: [Option<f64>; 3] = [Some(0.0); 3];

fn block() -> MeshParts {
    unit_box([3, 3, 2])
}

/// Blocks of a cube each above and below z = 0, which mirrors them.
fn blocks() -> MeshParts {
    let mut lower = moved(block(), |[x, y, z]| [x, y, -z]);
    lower.cells.chunks_mut(4).for_each(|cell| cell.swap(2, 3));
    joined(&[("up_", block()), ("low_", lower)])
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
fn a_block_in_space_on_its_mirror_image_is_the_block_on_a_rigid_plane() {
    let law = rubber([("up_body", 1.0), ("low_body", 1.0)], Some(20.0));
    let pair = Scene {
        supports: vec![support("up_z1", HELD), support("low_z1", HELD)],
        contacts: between("up_z0", "low_z0"),
        ..law
    };
    let target = |name: &str, way: f64| SupportTarget {
        name: name.to_owned(),
        displacement: [Some(0.0), Some(0.0), Some(way)],
        ..SupportTarget::default()
    };
    let together = vec![target("up_z1", -0.1), target("low_z1", 0.1)];
    let pair = squeezed(&pair, together, blocks());
    let mut alone = block();
    alone
        .groups
        .iter_mut()
        .for_each(|group| group.name = format!("up_{}", group.name));
    let mut scene = rubber([("up_body", 1.0), ("low_body", 1.0)], Some(20.0));
    scene.materials.truncate(1);
    let tool = Scene {
        supports: vec![support("up_z1", HELD)],
        obstacles: vec![obstacle("floor", "up_z0", plane([0.0; 3], [0.0, 0.0, 1.0]))],
        ..scene
    };
    let tool = squeezed(&tool, vec![target("up_z1", -0.1)], alone);
    let [found, expected] = [
        pair.contacts["pair"].force[2],
        tool.obstacles["floor"].force[2],
    ];
    assert!(close(found, expected, 1e-9), "{found} {expected}");
    assert!(close(pair.strain_energy, 2.0 * tool.strain_energy, 1e-9));
    let [pair, tool] = [pair.sqp_iterations, tool.sqp_iterations];
    assert!(pair <= tool + 1, "{pair} {tool}");
}
