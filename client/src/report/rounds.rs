//! Meshes that are refined until goals are known well enough, as people read them.

use signorini_client::result_line::{Round, RoundGoal};

use crate::terminal::text::number;

/// One line of a mesh: its size, and each goal with its bound and what was asked for.
pub(crate) fn told(round: &Round) -> String {
    let goals = round.goals.iter().map(|(name, goal)| of_goal(name, goal));
    let goals: Vec<String> = goals.collect();
    format!(
        "mesh {}: {} cells, {} unknowns, {} s: {}",
        round.round,
        round.cells,
        round.unknowns,
        number(round.seconds),
        goals.join("; ")
    )
}

fn of_goal(name: &str, goal: &RoundGoal) -> String {
    if goal.value == 0.0 {
        return format!("{name} = 0 +- {}", number(goal.bound));
    }
    let [bound, asked] = [goal.bound / goal.value.abs(), goal.tolerance].map(|share| 100.0 * share);
    format!(
        "{name} = {} +- {} % of {} %",
        number(goal.value),
        number(bound),
        number(asked)
    )
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    #[test]
    fn a_mesh_is_told_with_what_is_known_and_what_was_asked() {
        let goal = RoundGoal {
            value: -2.0,
            bound: 0.5,
            estimate: -0.1,
            geometry: 0.0,
            tolerance: 0.01,
        };
        let round = Round {
            round: 2,
            cells: 41,
            unknowns: 248,
            seconds: 0.25,
            dual_seconds: 0.0,
            goals: BTreeMap::from([("force.lid.y".to_owned(), goal)]),
            end: None,
            why: None,
        };
        let line = "mesh 2: 41 cells, 248 unknowns, 0.25 s: force.lid.y = -2 +- 25 % of 1 %";
        assert_eq!(told(&round), line);
    }
}
