//! Names that questions ask about, and scenes whose state depends on its way.

use super::Faults;
use crate::scene::{Goal, GoalErrors, GoalKind, GoalQuestions, Parameter, Scene};

/// Most goals, and most parameters, of one question.
const MOST: usize = 1000;

/// Refuses questions about what is not there.
pub(crate) fn check(scene: &Scene, faults: &mut Faults) {
    let mut gradients = 0..;
    for questions in &scene.questions {
        let path = match questions.errors {
            GoalErrors::Bounded => "accuracy".to_owned(),
            GoalErrors::Left => format!("gradient[{}]", gradients.next().unwrap_or(0)),
        };
        check_one(scene, questions, (&path, faults));
    }
}

fn check_one(scene: &Scene, questions: &GoalQuestions, (path, faults): (&str, &mut Faults)) {
    if questions.goals.is_empty() {
        faults.add(format!("{path}.of"), "names no goal");
    }
    for (key, count) in [
        ("of", questions.goals.len()),
        ("to", questions.parameters.len()),
    ] {
        if count > MOST {
            faults.add(
                format!("{path}.{key}"),
                format!("has more than {MOST} entries"),
            );
        }
    }
    for goal in questions.goals.iter().filter(|goal| !has_goal(scene, goal)) {
        let message = format!(
            "`{goal}`: the scene has no {} of that name",
            goal.kind.owner()
        );
        faults.add(format!("{path}.of"), message);
    }
    let all = questions.parameters.iter();
    for parameter in all.filter(|parameter| !has_parameter(scene, parameter)) {
        let message = format!("`{parameter}`: the scene has nothing of that name");
        faults.add(format!("{path}.to"), message);
    }
    if let Some(cause) = history(scene) {
        let message = format!(
            "the scene has {cause}: its state depends on its way, and derivatives of the last \
             increment alone would be wrong"
        );
        faults.unsupported(path, message);
    }
}

/// What makes a state depend on its way; none where nothing does.
fn history(scene: &Scene) -> Option<&'static str> {
    let mut obstacles = scene.obstacles.iter();
    if obstacles.any(|one| one.friction != 0.0 || one.tresca.is_some()) {
        Some("friction")
    } else if scene.fluids.is_empty() {
        None
    } else {
        Some("fluids")
    }
}

fn has_goal(scene: &Scene, goal: &Goal) -> bool {
    match goal.kind {
        GoalKind::Force | GoalKind::Moment => has_obstacle(scene, &goal.name),
        GoalKind::Reaction => scene.supports.iter().any(|one| one.name == goal.name),
        GoalKind::Displacement => scene.probes.iter().any(|one| one.name == goal.name),
    }
}

fn has_obstacle(scene: &Scene, name: &str) -> bool {
    scene.obstacles.iter().any(|one| one.name == name)
}

fn has_parameter(scene: &Scene, parameter: &Parameter) -> bool {
    match parameter {
        Parameter::Material { group, .. } => scene.materials.iter().any(|one| one.group == *group),
        Parameter::Pose { obstacle, .. }
        | Parameter::Push { obstacle, .. }
        | Parameter::Shape { obstacle, .. } => has_obstacle(scene, obstacle),
        Parameter::Load | Parameter::BodyForce { .. } => true,
        Parameter::Pressure { index } => *index < scene.pressures.len(),
        Parameter::Traction { item, .. } => {
            let mut all = scene.tractions.iter();
            let place = item.parse::<usize>().ok();
            place.is_some_and(|place| place < all.len())
                || all.any(|one| one.name.as_ref() == Some(item))
        }
        Parameter::Support { support, .. } => scene.supports.iter().any(|one| one.name == *support),
    }
}
