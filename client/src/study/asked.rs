//! What a scene asks of goals, in the form of its answers without numbers.

use std::collections::BTreeMap;

use signorini_proto::travel::with_axis;
use signorini_proto::v1;

/// Goals of a scene with what is asked of them, and no numbers.
pub fn goals(scene: &v1::Scene) -> BTreeMap<String, v1::GoalResult> {
    let mut goals = BTreeMap::<String, v1::GoalResult>::new();
    for gradient in &scene.gradients {
        for goal in &gradient.of {
            let derivatives = &mut goals.entry(goal.clone()).or_default().derivatives;
            derivatives.extend(gradient.to.iter().map(|one| (one.clone(), 0.0)));
        }
    }
    for goal in bounded(scene) {
        goals.entry(goal).or_default().bound = Some(v1::GoalBound::default());
    }
    goals
}

/// Goals whose errors are asked for.
pub fn bounded(scene: &v1::Scene) -> Vec<String> {
    let bounded = scene.accuracy.iter().flat_map(|accuracy| &accuracy.bound);
    let targets = scene.accuracy.iter().flat_map(|accuracy| &accuracy.targets);
    let targets = targets.filter_map(|target| with_axis(scene, &target.goal));
    bounded.cloned().chain(targets).collect()
}
