//! Along which axis the steps of a scene move an obstacle.

use crate::v1;

/// The axis, 0 to 2, along which all steps move or push the obstacle of that name; none where there
/// is no single one.
pub fn axis_of_travel(scene: &v1::Scene, obstacle: &str) -> Option<usize> {
    let targets = scene.steps.iter().flat_map(|step| &step.obstacles);
    let mut axes = targets.filter(|one| one.name == obstacle).flat_map(axes);
    let first = axes.next()?;
    axes.all(|axis| axis == first).then_some(first)
}

/// A goal with its axis: of the force of an obstacle without one, such as `force.lid`, that along its motion; none
/// where there is no single one. Other goals stay as they are.
pub fn with_axis(scene: &v1::Scene, goal: &str) -> Option<String> {
    let name = goal.strip_prefix("force.").unwrap_or_default();
    if !scene.obstacles.iter().any(|one| one.name == name) {
        return Some(goal.to_owned());
    }
    let axis = ["x", "y", "z"].get(axis_of_travel(scene, name)?)?;
    Some(format!("{goal}.{axis}"))
}

/// Axes along which a target moves or pushes.
fn axes(target: &v1::ObstacleTarget) -> impl Iterator<Item = usize> + use<> {
    let force = target.force.unwrap_or_default();
    let pushed = [force.x, force.y, force.z].map(|part| part.unwrap_or(0.0));
    let moved = target.translation.clone().into_iter().enumerate();
    let all = moved.chain(pushed.into_iter().enumerate());
    all.filter_map(|(axis, size)| (size != 0.0).then_some(axis))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(steps: &[(&str, [f64; 3])]) -> v1::Scene {
        let step = |(name, translation): &(&str, [f64; 3])| v1::LoadStep {
            obstacles: vec![v1::ObstacleTarget {
                name: (*name).to_owned(),
                translation: translation.to_vec(),
                ..Default::default()
            }],
            ..Default::default()
        };
        v1::Scene {
            steps: steps.iter().map(step).collect(),
            ..Default::default()
        }
    }

    #[test]
    fn an_axis_is_that_of_all_steps_of_the_obstacle() {
        let straight = [
            ("lid", [0.0, -0.1, 0.0]),
            ("wall", [0.1, 0.0, 0.0]),
            ("lid", [0.0, -0.3, 0.0]),
        ];
        assert_eq!(axis_of_travel(&scene(&straight), "lid"), Some(1));
        assert_eq!(axis_of_travel(&scene(&straight), "wall"), Some(0));
        assert_eq!(axis_of_travel(&scene(&straight), "floor"), None);
        let bent = [("lid", [0.0, -0.1, 0.0]), ("lid", [0.2, -0.1, 0.0])];
        assert_eq!(axis_of_travel(&scene(&bent), "lid"), None);
        let mut pushed = scene(&straight[..1]);
        let force = v1::Components {
            x: Some(1.0),
            ..Default::default()
        };
        pushed.steps[0].obstacles[0].force = Some(force);
        assert_eq!(axis_of_travel(&pushed, "lid"), None);
        pushed.obstacles.push(v1::Obstacle {
            name: "lid".to_owned(),
            ..Default::default()
        });
        assert_eq!(with_axis(&pushed, "force.lid"), None);
        assert_eq!(
            with_axis(&pushed, "force.lid.y").as_deref(),
            Some("force.lid.y")
        );
        pushed.steps[0].obstacles[0].force = None;
        assert_eq!(
            with_axis(&pushed, "force.lid").as_deref(),
            Some("force.lid.y")
        );
    }
}
