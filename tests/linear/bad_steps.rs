//! Every fault of a step is refused with the path of its key.

use crate::common::meshes::{mesh, square};
use crate::common::refusals::{assert_step_refused, sphere, violations, with_ball};
use crate::common::scenes::{HELD, cube_bend, elastic, obstacle, push, support, traction};
use signorini::Step;
use signorini::scene::{SceneKind, Shape, SupportTarget};
#[test]
fn steps_name_what_the_scene_has() {
    let scene = with_ball(sphere(0.5));
    let refused = |step: Step, path: &str, words: &[&str]| {
        assert_step_refused(&scene, &[Step::default(), step], path, words);
    };
    refused(
        push("bal", [0.0; 3]),
        "step[1].obstacle.bal",
        &["did you mean `ball`"],
    );
    refused(
        push("ball", [f64::NAN, 0.0, 0.0]),
        "step[1].obstacle.ball.translation",
        &["finite"],
    );
    let zero = Step {
        increments: 0,
        ..Step::default()
    };
    refused(zero, "step[1].increments", &["between 1"]);
    let endless = Step {
        load: Some(f64::INFINITY),
        ..Step::default()
    };
    refused(endless, "step[1].load", &["finite"]);
}

#[test]
fn steps_move_held_components_only() {
    let mut scene = cube_bend(0.5);
    scene.supports[0].displacement = [Some(0.0), Some(0.0), None];
    scene.supports.push(support("y0", HELD));
    let slide = |name: &str, displacement| Step {
        supports: vec![SupportTarget {
            name: name.to_owned(),
            displacement,
            ..SupportTarget::default()
        }],
        ..Step::default()
    };
    let path = "step[0].support.x0.displacement.z";
    let step = slide("x0", [Some(0.1), None, Some(0.1)]);
    assert_step_refused(&scene, &[step], path, &["does not hold this component"]);
    let step = slide("x9", [Some(0.1), None, None]);
    assert_step_refused(&scene, &[step], "step[0].support.x9", &["did you mean"]);
}

#[test]
fn plane_scenes_stay_in_their_plane() {
    let mesh = mesh(square(2));
    let mut scene = elastic(0.5);
    scene.supports = vec![support("x0", [Some(0.0), Some(0.0), None])];
    scene.tractions = vec![traction("x1", [0.0, 0.0, 1.0])];
    scene.kind = Some(SceneKind::Solid);
    let normal = [0.0, 1.0, 1.0];
    let shape = Shape::HalfSpace {
        point: [0.0; 3],
        normal,
    };
    scene.obstacles = vec![obstacle("floor", "y0", shape)];
    let found = violations(&scene, &[push("floor", [0.0, 0.0, 1.0])], &mesh);
    let paths: Vec<&str> = found
        .iter()
        .map(|violation| violation.path.as_str())
        .collect();
    for path in [
        "kind",
        "traction[0].value",
        "obstacle.floor.shape.normal",
        "step[0].obstacle.floor.translation",
    ] {
        assert!(paths.contains(&path), "{paths:?}");
    }
}
