//! `--accuracy`: the error of the force of every obstacle.

use signorini_proto::travel::axis_of_travel;
use signorini_proto::v1;

use crate::terminal::exit::{Exit, Failure};

const AXES: [&str; 3] = ["x", "y", "z"];

/// Asks for bounds of the forces of all obstacles, beside what the scene asks for: along the motion
/// where that is along one axis, of all components else.
pub(super) fn bound_forces(scene: &mut v1::Scene, dimension: usize) -> Result<(), Failure> {
    if scene.obstacles.is_empty() {
        let message = "--accuracy bounds forces of obstacles, and the scene has none: name what \
                       shall be bounded under [accuracy], such as bound = \"reaction.base.y\"";
        return Err(Failure::new(Exit::Usage, message));
    }
    let names: Vec<String> = scene.obstacles.iter().map(|one| one.name.clone()).collect();
    for name in names {
        let along = axis_of_travel(scene, &name).filter(|axis| (0..dimension).contains(axis));
        let axes = along.map_or(0..dimension, |axis| axis..axis + 1);
        let goals = axes.filter_map(|axis| Some(format!("force.{name}.{}", AXES.get(axis)?)));
        let goals: Vec<String> = goals.collect();
        let bound = &mut scene.accuracy.get_or_insert_default().bound;
        for goal in goals {
            if !bound.contains(&goal) {
                bound.push(goal);
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(steps: &[(&str, [f64; 3])]) -> v1::Scene {
        let obstacle = |name: &str| v1::Obstacle {
            name: name.to_owned(),
            ..Default::default()
        };
        let step = |(name, translation): &(&str, [f64; 3])| v1::LoadStep {
            obstacles: vec![v1::ObstacleTarget {
                name: (*name).to_owned(),
                translation: translation.to_vec(),
                ..Default::default()
            }],
            ..Default::default()
        };
        v1::Scene {
            obstacles: vec![obstacle("lid"), obstacle("wall")],
            steps: steps.iter().map(step).collect(),
            ..Default::default()
        }
    }

    fn asked(mut scene: v1::Scene, dimension: usize) -> Vec<String> {
        bound_forces(&mut scene, dimension).unwrap();
        scene.accuracy.unwrap().bound
    }

    #[test]
    fn forces_are_bounded_along_the_motion_or_by_all_components() {
        let straight = [("lid", [0.0, -0.1, 0.0]), ("lid", [0.0, -0.3, 0.0])];
        assert_eq!(
            asked(scene(&straight), 2),
            ["force.lid.y", "force.wall.x", "force.wall.y"]
        );
        let bent = [("lid", [0.0, -0.1, 0.0]), ("lid", [0.2, -0.1, 0.0])];
        assert_eq!(asked(scene(&bent), 2).len(), 4);
        assert_eq!(asked(scene(&straight), 3).len(), 4);
        let mut ring = scene(&straight);
        ring.kind = v1::SceneKind::Axisymmetric.into();
        ring.accuracy = Some(v1::Accuracy {
            bound: vec!["force.lid.y".to_owned()],
            ..Default::default()
        });
        // Those across the axis are radial.
        let expected = ["force.lid.y", "force.wall.x", "force.wall.y"];
        assert_eq!(asked(ring, 2), expected);
    }

    #[test]
    fn a_scene_without_obstacles_says_what_to_name() {
        let failure = bound_forces(&mut v1::Scene::default(), 2).unwrap_err();
        assert!(format!("{failure:?}").contains("[accuracy]"));
    }
}
