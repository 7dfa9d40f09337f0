//! Goals with their errors and derivatives, in words.

use signorini_proto::v1;

use super::Lines;
use crate::terminal::text::{number, one_line, with_error};

/// Each goal, its bound by parts, and what it depends on.
pub(super) fn goals(lines: &mut Lines, report: &v1::StepReport) {
    for (name, goal) in &report.goals {
        let bound = goal.bound.as_ref();
        let value = with_error(goal.value, bound.map(|bound| bound.total));
        lines.add("goal", &format!("{name} {value}"));
        if let Some(bound) = bound {
            lines.add("", &parts(bound));
        }
        for (parameter, value) in &goal.derivatives {
            let parameter = one_line(parameter);
            lines.add("", &format!("{} by {parameter}", number(*value)));
        }
    }
    if let Some(cause) = &report.goals_refused {
        lines.add("goals", &format!("no answer: {cause}"));
    }
}

/// What a bound is the sum of.
fn parts(bound: &v1::GoalBound) -> String {
    let others = [
        (bound.solver, "solver"),
        (bound.geometry, "flat facets of a curved surface"),
    ];
    let others = others.into_iter().filter(|(value, _)| *value > 0.0);
    let others: String = others
        .map(|(value, what)| format!(", {what} {}", number(value)))
        .collect();
    let (mesh, estimate) = (number(bound.mesh), number(bound.estimate));
    format!("error at most about: mesh {mesh}{others}; estimated {estimate}")
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    #[test]
    fn a_goal_is_told_with_its_bound_its_parts_and_its_derivatives() {
        let bound = v1::GoalBound {
            total: 0.03,
            mesh: 0.02,
            solver: 0.0,
            geometry: 0.01,
            estimate: -0.015,
        };
        let goal = v1::GoalResult {
            value: -2.0,
            derivatives: BTreeMap::from([("material.body.c10".to_owned(), -4.5)]),
            bound: Some(bound),
            ..Default::default()
        };
        let report = v1::StepReport {
            goals: BTreeMap::from([("force.lid.y".to_owned(), goal)]),
            goals_refused: Some("`force.lid.z`: no such".to_owned()),
            ..Default::default()
        };
        let mut lines = Lines::default();
        goals(&mut lines, &report);
        for part in [
            "force.lid.y -2",
            "± 0.03",
            "mesh 0.02, flat facets of a curved surface 0.01; estimated -0.015",
            "-4.5 by material.body.c10",
            "no answer: `force.lid.z`: no such",
        ] {
            assert!(lines.0.contains(part), "{part}: {}", lines.0);
        }
        assert!(!lines.0.contains("solver"), "{}", lines.0);
    }
}
