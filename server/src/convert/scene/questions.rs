//! What is asked of increments: derivatives and errors of goals.

use std::str::FromStr;

use signorini::scene::{AskedAt, GoalErrors, GoalQuestions, Malformed};
use signorini_proto::v1 as wire;

use super::super::Faults;

/// Longest text of a goal or a parameter, bytes: two names and words.
const MAXIMUM_BYTES: usize = 600;

pub(super) fn questions(
    gradients: Vec<wire::Gradient>,
    accuracy: Option<wire::Accuracy>,
    faults: &mut Faults,
) -> Vec<GoalQuestions> {
    let mut all = Vec::new();
    for (index, gradient) in gradients.into_iter().enumerate() {
        all.push(of_gradient(&gradient, index, faults));
    }
    let accuracy = accuracy.unwrap_or_default();
    let (bounded, at) = (accuracy.bound, asked_at(accuracy.at, "accuracy.at", faults));
    if !bounded.is_empty() {
        all.push(GoalQuestions {
            goals: read(&bounded, "accuracy.bound", faults),
            parameters: Vec::new(),
            errors: GoalErrors::Bounded,
            at,
        });
    }
    all
}

fn of_gradient(gradient: &wire::Gradient, index: usize, faults: &mut Faults) -> GoalQuestions {
    let at = |key: &str| format!("gradient[{index}].{key}");
    for (key, list) in [("of", &gradient.of), ("to", &gradient.to)] {
        if list.is_empty() {
            faults.add(at(key), "is required");
        }
    }
    GoalQuestions {
        goals: read(&gradient.of, &at("of"), faults),
        parameters: read(&gradient.to, &at("to"), faults),
        errors: GoalErrors::Left,
        at: asked_at(gradient.at, &at("at"), faults),
    }
}

fn asked_at(number: i32, path: &str, faults: &mut Faults) -> AskedAt {
    match wire::AskedAt::try_from(number) {
        Ok(wire::AskedAt::Unspecified | wire::AskedAt::Steps) => AskedAt::Steps,
        Ok(wire::AskedAt::Increments) => AskedAt::Increments,
        Err(_) => {
            faults.add(path, format!("{number} is no such value"));
            AskedAt::Steps
        }
    }
}

/// Those of the texts that are well formed; the others are faults.
pub(super) fn read<T: FromStr<Err = Malformed>>(
    texts: &[String],
    path: &str,
    faults: &mut Faults,
) -> Vec<T> {
    let mut all = Vec::new();
    for text in texts {
        if text.len() > MAXIMUM_BYTES {
            faults.add(path, format!("is longer than {MAXIMUM_BYTES} bytes"));
            continue;
        }
        if text.chars().any(char::is_control) {
            faults.add(path, "has a control character");
            continue;
        }
        match text.parse::<T>() {
            Ok(one) => all.push(one),
            Err(malformed) => faults.add(path, malformed.to_string()),
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fault::Fault;

    fn texts(all: &[&str]) -> Vec<String> {
        all.iter().map(|&text| text.to_owned()).collect()
    }

    #[test]
    fn derivatives_and_errors_reach_the_library() {
        let mut faults = Faults::default();
        let gradient = wire::Gradient {
            of: texts(&["force.ball.y", "displacement.tip.x"]),
            to: texts(&["material.body.c10", "obstacle.ball.radius"]),
            at: wire::AskedAt::Increments.into(),
        };
        let accuracy = wire::Accuracy {
            bound: texts(&["force.ball.y"]),
            ..Default::default()
        };
        let read = questions(vec![gradient], Some(accuracy), &mut faults);
        assert_eq!(faults.outcome(), Ok(()));
        assert_eq!(read[0].goals[1].to_string(), "displacement.tip.x");
        assert_eq!(read[0].parameters[1].to_string(), "obstacle.ball.radius");
        assert_eq!(
            (read[0].errors, read[1].errors),
            (GoalErrors::Left, GoalErrors::Bounded)
        );
        assert_eq!(read[1].goals, read[0].goals[..1]);
        assert_eq!(
            [&read[0], &read[1]].map(|one| one.at),
            [AskedAt::Increments, AskedAt::Steps]
        );
        let mut faults = Faults::default();
        assert_eq!(
            questions(Vec::new(), Some(wire::Accuracy::default()), &mut faults),
            []
        );
    }

    #[test]
    fn what_is_no_goal_or_parameter_is_told_with_its_key() {
        let mut faults = Faults::default();
        let gradient = wire::Gradient {
            of: texts(&["force.ball"]),
            to: texts(&["c10", &"x".repeat(601), "load\n"]),
            at: 0,
        };
        let empty = wire::Gradient {
            at: 9,
            ..Default::default()
        };
        questions(vec![gradient, empty], None, &mut faults);
        let Err(Fault::SceneInvalid(all)) = faults.outcome() else {
            unreachable!("seven faults");
        };
        let paths: Vec<&str> = all.iter().map(|one| one.path.as_str()).collect();
        let expected = [
            "gradient[0].of",
            "gradient[0].to",
            "gradient[0].to",
            "gradient[0].to",
            "gradient[1].of",
            "gradient[1].to",
            "gradient[1].at",
        ];
        assert_eq!(paths, expected);
        assert!(
            all[0]
                .message
                .contains("`force.ball` is not of the form KIND.NAME.AXIS")
        );
    }
}
