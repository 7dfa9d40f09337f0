//! What the plan doubts before anything is solved, and that it doubts nothing else.

use std::sync::Arc;

use crate::common::meshes::{cube, mesh};
use crate::common::scenes::{HELD, elastic, material, obstacle, press, push, rubber, support};
use signorini::obstacle::grid::{DistanceGrid, HeightField, Lattice};
use signorini::scene::{
    Material, Modulus, PenetrationPolicy, RubberModel, Shape, Step, SupportTarget,
};
use signorini::{Group, GroupKind, MeshParts, Plan, Scene, SceneError};

fn warnings(scene: &Scene, parts: MeshParts) -> Vec<String> {
    let plan = Plan::new(scene, &[], &mesh(parts)).expect("a valid scene");
    plan.report().warnings
}

/// A held block under a lid.
fn pressed(scene: Scene) -> Scene {
    Scene {
        supports: vec![support("z0", HELD)],
        obstacles: vec![press("z1")],
        ..scene
    }
}

#[test]
fn a_sound_scene_is_not_doubted() {
    for scene in [elastic(0.3), elastic(0.4999), elastic(0.5)] {
        assert_eq!(warnings(&pressed(scene), cube(3)), [""; 0]);
    }
}

#[test]
fn flat_cells_are_named() {
    let mut parts = cube(3);
    parts.coordinates.iter_mut().for_each(|x| x[2] *= 0.01);
    let mut scene = elastic(0.3);
    scene.supports = vec![support("z0", HELD)];
    let found = warnings(&scene, parts);
    assert!(
        found.len() == 1 && found[0].contains("is nearly flat"),
        "{found:?}"
    );
}

#[test]
fn volumes_that_hardly_change_are_named() {
    let law = RubberModel::NeoHookean { shear_modulus: 1.0 };
    for scene in [rubber(law, Some(1e7)), elastic(0.499_999_99)] {
        let found = warnings(&pressed(scene), cube(2));
        assert!(
            found.len() == 1 && found[0].contains("change of volume"),
            "{found:?}"
        );
    }
}

#[test]
fn edges_of_a_tool_below_the_mesh_are_named() {
    for (rounding, count) in [(0.0, 1), (0.05, 1), (0.9, 0)] {
        let mut scene = pressed(elastic(0.3));
        let shape = Shape::Box {
            centre: [0.5, 0.5, 2.0],
            half_sizes: [1.0; 3],
            rounding,
        };
        scene.obstacles = vec![obstacle("tool", "z1", shape)];
        let found = warnings(&scene, cube(3));
        assert_eq!(found.len(), count, "{found:?}");
        assert!(found.iter().all(|one| one.contains("edges or a tip")));
    }
}

#[test]
fn a_tool_between_the_vertices_is_named() {
    let ball = |radius| Shape::Sphere {
        centre: [0.5, 0.5, 1.0 + radius],
        radius,
    };
    for (radius, count) in [(0.2, 1), (2.0, 0)] {
        let mut scene = elastic(0.3);
        scene.supports = vec![support("z0", HELD)];
        scene.obstacles = vec![obstacle("ball", "z1", ball(radius))];
        let found = warnings(&scene, cube(2));
        assert_eq!(found.len(), count, "{found:?}");
        assert!(
            found.iter().all(|text| text.contains("`ball`")),
            "{found:?}"
        );
    }
}

#[test]
fn a_rigid_part_in_disguise_is_named() {
    let mut parts = cube(2);
    let half = parts.cells.len() / 8;
    split(&mut parts, half);
    let mut scene = pressed(elastic(0.3));
    scene.materials = [("soft", 1.0), ("steel", 1e6)]
        .map(|(group, stiffness)| Material {
            group: group.to_owned(),
            ..material(Modulus::Shear(stiffness), 0.3)
        })
        .into();
    let found = warnings(&scene, parts);
    assert!(
        found.len() == 1 && found[0].contains("`steel`"),
        "{found:?}"
    );
}

/// Parts the cells of the group `body` in two.
fn split(parts: &mut MeshParts, half: usize) {
    let count = parts.cells.len() / 4;
    parts.groups.retain(|group| group.name != "body");
    for (name, cells) in [("soft", 0..half), ("steel", half..count)] {
        parts.groups.push(Group {
            name: name.to_owned(),
            kind: GroupKind::Cells,
            members: cells.map(|cell| cell as u32).collect(),
        });
    }
}

#[test]
fn a_body_whose_place_rounds_its_shape_is_named() {
    for (away, count) in [(1e3, 0), (1e9, 1)] {
        let mut parts = cube(2);
        parts.coordinates.iter_mut().for_each(|x| x[1] += away);
        let mut scene = elastic(0.3);
        scene.supports = vec![support("z0", HELD)];
        let found = warnings(&scene, parts);
        let is_named = found.iter().all(|one| one.contains("away from the origin"));
        assert!(found.len() == count && is_named, "{found:?}");
    }
}

#[test]
fn a_tool_that_lies_in_the_body_is_named_with_its_depth_before_anything_is_solved() {
    let over = |height: f64| {
        let mut scene = pressed(elastic(0.3));
        let shape = Shape::Sphere {
            centre: [0.5, 0.5, height],
            radius: 0.3,
        };
        scene.obstacles = vec![obstacle("ball", "z1", shape)];
        warnings(&scene, cube(4))
    };
    let found = over(1.2);
    let named = found.iter().find(|one| one.contains("begins up to"));
    let named = named.expect("a doubt");
    assert!(named.contains("`ball` begins up to 0.1000"), "{named}");
    assert!(named.contains("(0.5000, 0.5000, 1.0000)"), "{named}");
    // A third of the six facets at the vertex, each a half of a sixteenth.
    let area = "1 of 25 vertices that it may touch, 0.0625 of the surface";
    assert!(named.contains(area), "{named}");
    assert!(!over(1.3).iter().any(|one| one.contains("begins")));
}

#[test]
fn a_tool_that_shall_not_begin_inside_the_body_is_refused_with_depth_place_vertices_and_area() {
    let over = |height: f64, policy: PenetrationPolicy| {
        let mut scene = pressed(elastic(0.3));
        let shape = Shape::Sphere {
            centre: [0.5, 0.5, height],
            radius: 0.3,
        };
        scene.obstacles.push(obstacle("ball", "z1", shape));
        scene.obstacles[1].initial_penetration = policy;
        // The lid touches the body all over.
        scene.obstacles[0].initial_penetration = PenetrationPolicy::Reject;
        Plan::new(&scene, &[], &mesh(cube(4))).map(|_| ())
    };
    let Err(SceneError::Invalid(faults)) = over(1.299_9, PenetrationPolicy::Reject) else {
        panic!("a ball in the body");
    };
    let [fault] = &faults[..] else {
        panic!("{faults:?}");
    };
    assert_eq!(fault.path, "obstacle.ball.initial_penetration");
    let told = "obstacle `ball` begins up to 1.00e-4 inside the body, at (0.5000, 0.5000, 1.0000), with 1 of 25 vertices that it may touch, 0.0625 of the surface";
    assert!(fault.message.starts_with(told), "{fault}");
    assert_eq!(over(1.299_9, PenetrationPolicy::Resolve), Ok(()));
    assert_eq!(over(1.3, PenetrationPolicy::Reject), Ok(()));
}

/// A held block under a plate whose normal is `normal`, in place of `[0, 0, -1]`.
fn under_a_plate(point: [f64; 3], normal: [f64; 3]) -> Scene {
    let mut scene = pressed(elastic(0.3));
    scene.obstacles[0].shape = Shape::HalfSpace { point, normal };
    scene
}

#[test]
fn a_plane_whose_normal_points_away_from_the_body_is_refused_with_the_normal_that_it_needs() {
    let steps = [push("press", [0.0, 0.0, -0.1])];
    // The plate touches the block, and is away from it.
    for height in [1.0, 1.3] {
        let scene = under_a_plate([0.0, 0.0, height], [0.0, 0.0, 2.0]);
        let Err(SceneError::Invalid(faults)) = Plan::new(&scene, &steps, &mesh(cube(2))) else {
            panic!("a plate from {height} downwards holds the block");
        };
        let [fault] = &faults[..] else {
            panic!("{faults:?}");
        };
        assert_eq!(fault.path, "obstacle.press.shape.normal");
        assert!(fault.message.contains("turn it to [0, 0, -2]"), "{fault}");
        // A session may yet lead it away: it is told all the same.
        let told = warnings(&scene, cube(2));
        assert!(told.contains(&fault.message), "{told:?}");
    }
}

#[test]
fn a_plane_that_the_steps_lead_to_the_right_side_is_not_refused() {
    let scene = under_a_plate([0.0, 0.0, 0.1], [0.0, 0.0, -1.0]);
    let plan = |steps: &[Step]| Plan::new(&scene, steps, &mesh(cube(2))).map(|_| ());
    assert_eq!(plan(&[push("press", [0.0, 0.0, 0.9])]), Ok(()));
    let behind = under_a_plate([0.0, 0.0, -0.1], [0.0, 0.0, -1.0]);
    let plan = |steps: &[Step]| Plan::new(&behind, steps, &mesh(cube(2))).map(|_| ());
    assert_eq!(plan(&[push("press", [0.0, 0.0, 1.1])]), Ok(()));
    assert!(plan(&[push("press", [0.0, 0.0, 0.1])]).is_err());
}

#[test]
fn a_cavity_beside_the_body_is_doubted_with_its_cure() {
    let mut scene = pressed(elastic(0.3));
    let ball = Shape::Sphere {
        centre: [0.5, 0.5, 3.0],
        radius: 1.0,
    };
    scene.obstacles[0].shape = Shape::Cavity(Arc::new(ball));
    let told = warnings(&scene, cube(2));
    assert!(
        told.iter().any(|one| one.contains("leave it out")),
        "{told:?}"
    );
}

#[test]
fn a_step_in_other_units_is_doubted() {
    let scene = pressed(elastic(0.3));
    let found = |way: f64| {
        let steps = [push("press", [0.0, 0.0, -way])];
        let plan = Plan::new(&scene, &steps, &mesh(cube(2))).expect("a valid scene");
        plan.report().warnings
    };
    let far = found(5000.0);
    assert!(
        far.iter().any(|one| one.contains("units of the mesh")),
        "{far:?}"
    );
    assert_eq!(found(0.1), [""; 0]);
}

/// The plan of a cube under `shape`, which comes down by `way` from its first pose.
fn under(shape: Shape, way: f64) -> Plan {
    let mut scene = pressed(elastic(0.3));
    scene.obstacles = vec![obstacle("tool", "z1", shape)];
    let steps = [push("tool", [0.0, 0.0, -way])];
    Plan::new(&scene, &steps, &mesh(cube(4))).expect("a valid scene")
}

#[test]
fn a_mesh_too_coarse_for_the_contact_that_the_way_leads_to_is_named_with_both_sizes() {
    let ball = |way: f64| {
        let shape = Shape::Sphere {
            centre: [0.5, 0.5, 1.9],
            radius: 0.9,
        };
        under(shape, way).report().warnings
    };
    // The half width of Hertz is 0.3 and 0.4, the longest edge of a face 0.3536.
    let found = ball(0.1);
    assert_eq!(found.len(), 1, "{found:?}");
    let sizes = "end 0.300 from its middle, inside the facets there, the smallest of size 0.354";
    assert!(found[0].contains(sizes), "{found:?}");
    assert_eq!(ball(0.18), [""; 0]);
}

#[test]
fn vertices_beside_the_nodes_of_a_height_field_are_counted() {
    let flat = |width: f64| {
        let lattice = Lattice {
            counts: [9, 9],
            origin: [0.5 - 0.5 * width; 2],
            spacing: [width / 8.0; 2],
        };
        let field = HeightField::new(lattice, &[-2.0; 81]).expect("heights");
        Shape::HeightField(Arc::new(field))
    };
    let count = |width: f64| {
        let all = under(flat(width), 0.0).report().warnings;
        all.into_iter().find(|one| one.contains("beside the nodes"))
    };
    assert_eq!(count(1.0), None);
    let found = count(0.6).expect("a doubt");
    assert!(found.starts_with("16 of 25 vertices"), "{found}");
}

#[test]
fn vertices_beside_the_nodes_of_an_open_distance_grid_are_counted() {
    let flat = |width: f64| {
        let lattice = Lattice {
            counts: [9; 3],
            origin: [0.5 - 0.5 * width, 0.5 - 0.5 * width, -2.9],
            spacing: [width / 8.0, width / 8.0, 0.5],
        };
        let heights = (0..729).map(|node: u32| 0.5 * f64::from(node % 9) - 0.9);
        let grid = DistanceGrid::new(lattice, &heights.collect::<Vec<_>>()).expect("distances");
        Shape::DistanceGrid(Arc::new(grid))
    };
    let count = |shape: Shape| {
        let all = under(shape, 0.0).report().warnings;
        all.into_iter().find(|one| one.contains("beside the nodes"))
    };
    assert_eq!(count(flat(1.0)), None);
    let found = count(flat(0.6)).expect("a doubt");
    assert!(found.starts_with("16 of 25 vertices"), "{found}");
}

/// What the plan doubts of the way of a small ball beside a cube, which begins at its left.
fn on_the_way(steps: &[Step]) -> Vec<String> {
    let mut scene = pressed(elastic(0.3));
    let ball = Shape::Sphere {
        centre: [-1.0, 0.5, 1.9],
        radius: 0.5,
    };
    scene.obstacles = vec![obstacle("ball", "z1", ball)];
    let plan = Plan::new(&scene, steps, &mesh(cube(4))).expect("a valid scene");
    let all = plan.report().warnings.into_iter();
    all.filter(|one| one.contains("on its way")).collect()
}

#[test]
fn a_tool_whose_way_does_not_lead_to_the_body_is_named_with_its_distance() {
    let by = on_the_way(&[push("ball", [3.0, 0.0, 0.0])]);
    assert_eq!(by.len(), 1, "{by:?}");
    assert!(by[0].contains("passes the body by"), "{by:?}");
    assert!(by[0].contains("it is 0.40 lengths away"), "{by:?}");
    let up = on_the_way(&[push("ball", [0.0, 0.0, 2.0])]);
    assert!(up[0].contains("does not come to the body"), "{up:?}");
    // Between the poses that the steps name it touches.
    let down = push("ball", [1.5, 0.0, -0.45]);
    let back = push("ball", [3.0, 0.0, 0.0]);
    assert_eq!(on_the_way(&[down, back]), [""; 0]);
    assert_eq!(on_the_way(&[push("ball", [3.0, 0.0, -0.8])]), [""; 0]);
}

#[test]
fn a_way_beside_a_body_that_supports_move_is_not_doubted() {
    let mut step = push("ball", [3.0, 0.0, 0.0]);
    step.supports = vec![SupportTarget {
        name: pressed(elastic(0.3)).supports[0].name.clone(),
        displacement: [None, None, Some(0.5)],
        ..SupportTarget::default()
    }];
    assert_eq!(on_the_way(&[step]), [""; 0]);
}

#[test]
fn the_plan_says_what_may_touch_a_tool_and_how_far_it_goes() {
    let plan = under(
        Shape::Sphere {
            centre: [0.5, 0.5, 1.9],
            radius: 0.9,
        },
        0.25,
    );
    let decisions = plan.report().decisions;
    let tool = decisions.iter().find(|one| one.what == "obstacle tool");
    let tool = tool.expect("an entry");
    assert!(tool.choice.starts_with("32 faces, "), "{tool:?}");
    assert_eq!(tool.reason, "moves by 0.250 lengths of the body");
}
