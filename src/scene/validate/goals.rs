//! Names that questions ask about, and scenes whose state depends on its way.

use super::Faults;
use crate::scene::{
    Goal, GoalErrors, GoalKind, GoalQuestions, Material, Parameter, Scene, SceneKind, numbers,
};

/// Most goals, and most parameters, of one question.
const MOST: usize = 1000;

/// Refuses questions about what is not there.
pub(crate) fn check(scene: &Scene, kind: SceneKind, faults: &mut Faults) {
    let mut gradients = 0..;
    for questions in &scene.questions {
        let (path, key) = match questions.errors {
            GoalErrors::Bounded => ("accuracy".to_owned(), "bound"),
            GoalErrors::Left => {
                let index = gradients.next().unwrap_or(0);
                (format!("gradient[{index}]"), "of")
            }
        };
        check_one(scene, questions, (&path, key), faults);
        for goal in &questions.goals {
            if let Some(cause) = goal.absent(kind) {
                faults.add(format!("{path}.{key}"), format!("`{goal}`: {cause}"));
            }
        }
    }
}

/// `key` names the goals.
fn check_one(
    scene: &Scene,
    questions: &GoalQuestions,
    (path, key): (&str, &str),
    faults: &mut Faults,
) {
    let goals = format!("{path}.{key}");
    if questions.goals.is_empty() {
        faults.add(goals.clone(), "names no goal");
    }
    for (key, count) in [
        (key, questions.goals.len()),
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
        faults.add(goals.clone(), message);
    }
    for parameter in &questions.parameters {
        if let Some(lacking) = lacking(scene, parameter) {
            faults.add(format!("{path}.to"), format!("`{parameter}`: {lacking}"));
        }
    }
}

fn has_goal(scene: &Scene, goal: &Goal) -> bool {
    match goal.kind {
        GoalKind::Force => {
            let mut contacts = scene.contacts.iter();
            has_obstacle(scene, &goal.name) || contacts.any(|one| one.name == goal.name)
        }
        GoalKind::Moment | GoalKind::MaxPressure => has_obstacle(scene, &goal.name),
        GoalKind::StrainEnergy => true,
        GoalKind::Reaction => scene.supports.iter().any(|one| one.name == goal.name),
        GoalKind::Displacement => scene.probes.iter().any(|one| one.name == goal.name),
    }
}

fn has_obstacle(scene: &Scene, name: &str) -> bool {
    scene.obstacles.iter().any(|one| one.name == name)
}

/// The same of a constant of a law.
fn lacking_of_law(scene: &Scene, group: &str, constant: &str) -> Option<&'static str> {
    let mut all = scene.materials.iter();
    let Some(law) = all.find(|one| one.group == group) else {
        return Some("the scene has no material of that group");
    };
    if is_at_the_end(law, constant) {
        return Some("one half is the end of its range: it has no derivative from both sides");
    }
    let is_there = numbers::constant(&mut law.model.clone(), constant).is_some();
    (!is_there).then_some("the law has no such finite constant")
}

/// Whether a constant is a Poisson ratio of one half.
fn is_at_the_end(law: &Material, name: &str) -> bool {
    let value = numbers::constant(&mut law.model.clone(), name).map(|value| *value);
    name == "poisson_ratio" && value == Some(0.5)
}

/// What the scene lacks of a parameter; none where it has it.
fn lacking(scene: &Scene, parameter: &Parameter) -> Option<&'static str> {
    let unless = |is_there: bool, lacking| (!is_there).then_some(lacking);
    match parameter {
        Parameter::Material { group, constant } => lacking_of_law(scene, group, constant),
        Parameter::Pose { obstacle, .. } | Parameter::Push { obstacle, .. } => unless(
            has_obstacle(scene, obstacle),
            "the scene has no obstacle of that name",
        ),
        Parameter::Friction { obstacle } => unless(
            has_obstacle(scene, obstacle),
            "the scene has no obstacle of that name",
        ),
        Parameter::Tresca { obstacle } => {
            let mut all = scene.obstacles.iter();
            match all.find(|one| one.name == *obstacle) {
                None => Some("the scene has no obstacle of that name"),
                Some(one) => unless(
                    one.tresca.is_some(),
                    "the obstacle has no bound on its tractions",
                ),
            }
        }
        Parameter::ContactFriction { contact } | Parameter::ContactTresca { contact } => unless(
            scene.contacts.iter().any(|one| one.name == *contact),
            "the scene has no contact between bodies of that name",
        ),
        Parameter::Shape { obstacle, key } => {
            let mut all = scene.obstacles.iter();
            match all.find(|one| one.name == *obstacle) {
                None => Some("the scene has no obstacle of that name"),
                Some(tool) => unless(
                    numbers::number(&mut tool.shape.clone(), key).is_some(),
                    "the shape has no such number",
                ),
            }
        }
        Parameter::Load | Parameter::Mesh | Parameter::BodyForce { .. } => None,
        Parameter::Pressure { index } => unless(
            *index < scene.pressures.len(),
            "the scene has no such pressure; they are counted from 0",
        ),
        Parameter::Fluid { fluid } => unless(
            scene.fluids.iter().any(|one| one.name == *fluid),
            "the scene has no fluid of that name",
        ),
        Parameter::Traction { item, .. } => {
            let mut all = scene.tractions.iter();
            let place = item.parse::<usize>().ok();
            let is_place = place.is_some_and(|place| place < all.len());
            let is_there = is_place || all.any(|one| one.name.as_ref() == Some(item));
            unless(is_there, "the scene has no traction of that name or place")
        }
        Parameter::Support { support, .. } | Parameter::SupportPush { support, .. } => unless(
            scene.supports.iter().any(|one| one.name == *support),
            "the scene has no support of that name",
        ),
    }
}
