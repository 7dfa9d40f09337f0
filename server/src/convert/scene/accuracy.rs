//! What a scene asks of meshes that are refined.

use std::collections::HashSet;

use signorini::adapted::{Accuracy, AccuracyLimits, Target};
use signorini::scene::Goal;
use signorini_proto::travel::with_axis;
use signorini_proto::v1 as wire;

use super::super::Faults;
use super::MAXIMUM_GOALS;
use super::questions::read;
use crate::fault::Fault;

/// Takes what is asked of the mesh out of a scene. Its goals get their axes and are bounded where
/// the scene asks for errors, so that the scene is one for a session on the refined mesh.
///
/// # Errors
/// `SceneInvalid` with the keys of goals that are none, tolerances, limits, and where no goal has a
/// tolerance.
pub(crate) fn take_accuracy(scene: &mut wire::Scene) -> Result<Accuracy, Fault> {
    let mut faults = Faults::default();
    let asked = scene.accuracy.take().unwrap_or_default();
    faults.at_most(&asked.targets, MAXIMUM_GOALS, "accuracy");
    faults.at_most(&asked.bound, MAXIMUM_GOALS, "accuracy.bound");
    faults.refuse()?;
    if asked.targets.is_empty() {
        faults.add("accuracy", "names no goal with a tolerance");
    }
    let targets = asked.targets.iter();
    let goals = targets.map(|one| (named(scene, &one.goal, &mut faults), one.tolerance));
    let goals: Vec<(String, f64)> = goals.collect();
    let targets = goals
        .iter()
        .flat_map(|one| target(one, &mut faults))
        .collect();
    let mut named = HashSet::new();
    for (goal, _) in goals
        .iter()
        .filter(|(goal, _)| !named.insert(goal.as_str()))
    {
        faults.add(format!("accuracy.{goal}"), "is named twice");
    }
    let limits = limits(&asked, &mut faults);
    faults.outcome()?;
    let mut bound = asked.bound;
    for (goal, _) in goals {
        if !bound.contains(&goal) {
            bound.push(goal);
        }
    }
    scene.accuracy = Some(wire::Accuracy {
        bound,
        at: asked.at,
        ..Default::default()
    });
    Ok(Accuracy { targets, limits })
}

/// Refuses what a session does not do: it has one mesh.
pub(super) fn of_session(accuracy: &wire::Accuracy, faults: &mut Faults) {
    if let Some(target) = accuracy.targets.first() {
        faults.later(
            format!("accuracy.{}", target.goal),
            "a session has one mesh: `RefineMesh`, as `signorini solve` calls it, makes one that \
             is fine enough and answers with the scene for it; name the goal in accuracy.bound \
             to have its error only",
        );
        return;
    }
    let given = [
        ("max_unknowns", accuracy.max_unknowns.is_some()),
        ("max_memory", accuracy.max_memory.is_some()),
        ("max_time", accuracy.max_time.is_some()),
        ("max_rounds", accuracy.max_rounds.is_some()),
    ];
    for (key, _) in given.into_iter().filter(|(_, is_given)| *is_given) {
        let message = "limits meshes that are refined, and no goal has a tolerance: add one, such \
                       as force.lid.y = 0.01";
        faults.add(format!("accuracy.{key}"), message);
    }
}

/// A goal with its axis; a fault where the steps move its obstacle along none.
fn named(scene: &wire::Scene, goal: &str, faults: &mut Faults) -> String {
    with_axis(scene, goal).unwrap_or_else(|| {
        let name = goal.split_once('.').map_or("", |(_, name)| name);
        let message = if scene.obstacles.iter().any(|one| one.name == name) {
            format!("the steps move the obstacle along no single axis: name one, such as {goal}.y")
        } else {
            format!(
                "the scene has no obstacle \"{name}\"; other forces need their axis, such as {goal}.y"
            )
        };
        faults.add(format!("accuracy.{goal}"), message);
        format!("{goal}.y")
    })
}

fn target((text, tolerance): &(String, f64), faults: &mut Faults) -> Option<Target> {
    if !(*tolerance > 0.0 && tolerance.is_finite()) {
        let message = format!("must be above zero, the error over the value, not {tolerance}");
        faults.add(format!("accuracy.{text}"), message);
    }
    let goals: Vec<Goal> = read(std::slice::from_ref(text), "accuracy", faults);
    let goal = goals.into_iter().next()?;
    Some(Target {
        goal,
        tolerance: *tolerance,
    })
}

/// How far the meshes may go.
fn limits(asked: &wire::Accuracy, faults: &mut Faults) -> AccuracyLimits {
    let mut count = |key: &str, given: Option<i64>| {
        if let Some(number) = given.filter(|number| *number < 1) {
            faults.add(
                format!("accuracy.{key}"),
                format!("must be at least 1, not {number}"),
            );
        }
        given.map(i64::unsigned_abs)
    };
    let unknowns = count("max_unknowns", asked.max_unknowns);
    let bytes = count("max_memory", asked.max_memory);
    let rounds = count("max_rounds", asked.max_rounds.map(i64::from));
    let seconds = asked.max_time;
    if let Some(number) = seconds.filter(|number| !(number.is_finite() && *number > 0.0)) {
        let message = format!("must be above zero and finite, not {number}");
        faults.add("accuracy.max_time", message);
    }
    let own = AccuracyLimits::default();
    AccuracyLimits {
        unknowns,
        bytes,
        seconds,
        rounds: rounds.map_or(own.rounds, |rounds| rounds as u32),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(accuracy: wire::Accuracy) -> wire::Scene {
        let lid = wire::Obstacle {
            name: "lid".to_owned(),
            ..Default::default()
        };
        let down = wire::ObstacleTarget {
            name: "lid".to_owned(),
            translation: vec![0.0, -0.1, 0.0],
            ..Default::default()
        };
        wire::Scene {
            obstacles: vec![lid],
            steps: vec![wire::LoadStep {
                obstacles: vec![down],
                ..Default::default()
            }],
            accuracy: Some(accuracy),
            ..Default::default()
        }
    }

    fn asked(goal: &str, tolerance: f64) -> wire::Accuracy {
        let target = wire::AccuracyTarget {
            goal: goal.to_owned(),
            tolerance,
        };
        wire::Accuracy {
            targets: vec![target],
            ..Default::default()
        }
    }

    fn faults(accuracy: wire::Accuracy) -> Vec<String> {
        let mut scene = scene(accuracy);
        let Err(Fault::SceneInvalid(all)) = take_accuracy(&mut scene) else {
            return Vec::new();
        };
        all.into_iter().map(|one| one.path).collect()
    }

    #[test]
    fn goals_get_the_axis_of_the_motion_and_are_bounded_in_the_session() {
        let mut scene = scene(wire::Accuracy {
            max_rounds: Some(3),
            bound: vec!["force.lid.x".to_owned()],
            ..asked("force.lid", 0.01)
        });
        let found = take_accuracy(&mut scene).unwrap();
        assert_eq!(found.targets[0].goal.to_string(), "force.lid.y");
        assert_eq!(found.limits.rounds, 3);
        let left = scene.accuracy.unwrap();
        assert_eq!(left.bound, ["force.lid.x", "force.lid.y"]);
        assert_eq!((left.targets.len(), left.max_rounds), (0, None));
    }

    #[test]
    fn what_cannot_be_refined_for_is_told_with_its_key() {
        assert_eq!(faults(wire::Accuracy::default()), ["accuracy"]);
        assert_eq!(faults(asked("force.lid", 0.0)), ["accuracy.force.lid.y"]);
        assert_eq!(faults(asked("area.lid.y", 0.1)), ["accuracy"]);
        let limits = wire::Accuracy {
            max_unknowns: Some(0),
            max_memory: Some(-1),
            max_time: Some(0.0),
            max_rounds: Some(-1),
            ..asked("force.lid", 0.01)
        };
        let keys = ["max_unknowns", "max_memory", "max_rounds", "max_time"];
        assert_eq!(faults(limits), keys.map(|key| format!("accuracy.{key}")));
        let mut still = scene(asked("force.lid", 0.1));
        still.steps.clear();
        let error = take_accuracy(&mut still).unwrap_err().to_string();
        assert!(error.contains("along no single axis"), "{error}");
    }

    #[test]
    fn a_session_refuses_tolerances_with_what_reaches_them() {
        let mut faults = Faults::default();
        of_session(&asked("force.ball.y", 0.01), &mut faults);
        let Err(Fault::Unsupported(one)) = faults.outcome() else {
            unreachable!("a later key");
        };
        assert_eq!(one.path, "accuracy.force.ball.y");
        assert!(one.message.contains("`RefineMesh`"));
    }

    #[test]
    fn limits_without_a_tolerance_limit_nothing_and_are_refused() {
        let mut faults = Faults::default();
        let accuracy = wire::Accuracy {
            max_unknowns: Some(1000),
            ..Default::default()
        };
        of_session(&accuracy, &mut faults);
        let error = faults.outcome().unwrap_err().to_string();
        assert!(error.contains("accuracy.max_unknowns"), "{error}");
    }
}
