//! Whether goals are known well enough, and which cells are halved where they are not.

use super::accuracy::{Accuracy, Target};
use super::round::{End, GoalRound};
use crate::report::GoalReport;

/// Largest share of the errors that marked cells hold, without unit (W. Doerfler 1996); measured: with .7, .8
/// and .9 four examples at 1 % and .2 % take .9 to 2 times the time, and up to 1.4 times the unknowns.
const SHARE: f64 = 0.5;
/// Least share, where little is too much, without unit; chosen.
const LEAST_SHARE: f64 = 0.1;
/// Errors to be marked over errors to be rid of: halving leaves about a third of them. Without
/// unit; chosen from that, not measured.
const MARKED: f64 = 1.5;
/// Bound over the value from which on a goal is zero to rounding, without unit: a round leaves about
/// a third of the errors, so that no number of them that is allowed would tell it from zero; chosen.
const ROUNDING: f64 = 1e8;

/// What is kept from mesh to mesh.
pub(super) struct Judge<'a> {
    accuracy: &'a Accuracy,
    /// Of each goal what flat facets make of it over its value, as on the first mesh.
    geometry: Vec<f64>,
}

impl<'a> Judge<'a> {
    pub(super) fn new(accuracy: &'a Accuracy) -> Self {
        Self {
            accuracy,
            geometry: Vec::new(),
        }
    }

    /// The answers of a mesh with what was asked for.
    pub(super) fn goals(&mut self, answers: &[GoalReport]) -> Vec<GoalRound> {
        if self.geometry.is_empty() {
            self.geometry = answers.iter().map(facets).collect();
        }
        let asked = self.accuracy.targets.iter().zip(&self.geometry);
        let one = |(answer, (target, geometry)): (&GoalReport, (&Target, &f64))| {
            let bound = answer.bound.clone().unwrap_or_default();
            let geometry = geometry * answer.value.abs();
            GoalRound {
                goal: answer.goal.clone(),
                value: answer.value,
                estimate: bound.estimate,
                bound: bound.discretisation + bound.solver + geometry,
                geometry,
                tolerance: target.tolerance,
            }
        };
        answers.iter().zip(asked).map(one).collect()
    }
}

/// What flat facets make of a goal over its value.
fn facets(answer: &GoalReport) -> f64 {
    let own = answer.bound.as_ref().map_or(0.0, |bound| bound.geometry);
    let relative = own / answer.value.abs();
    if relative.is_nan() { 0.0 } else { relative }
}

/// Why the loop ends with these goals; none where finer cells help.
pub(super) fn end(goals: &[GoalRound], answers: &[GoalReport]) -> Option<End> {
    if goals.iter().all(GoalRound::is_reached) {
        return Some(End::Reached);
    }
    if let Some(goal) = goals.iter().find(|goal| goal.relative() > ROUNDING) {
        return Some(End::Zero(goal.goal.clone()));
    }
    let rest = |(goal, answer): (&GoalRound, &GoalReport)| {
        let solver = answer.bound.as_ref().map_or(0.0, |bound| bound.solver);
        let size = goal.value.abs();
        let named = goal.goal.clone();
        if solver / size > goal.tolerance {
            let relative = solver / size;
            return Some(End::Solver {
                goal: named,
                relative,
            });
        }
        let relative = (goal.geometry + solver) / size;
        (goal.geometry > 0.0 && relative > goal.tolerance).then_some(End::Facets {
            goal: named,
            relative,
        })
    };
    goals.iter().zip(answers).find_map(rest)
}

/// The fewest cells that hold their share of what is too much, ascending; the first of equal ones.
pub(super) fn marks(goals: &[GoalRound], answers: &[GoalReport]) -> Vec<u32> {
    let mut sums: Vec<f64> = Vec::new();
    let open = goals.iter().zip(answers);
    for (goal, answer) in open.filter(|(goal, _)| !goal.is_reached()) {
        let parts = answer.bound.iter().flat_map(|bound| &bound.cells);
        let weight = weight(goal);
        let parts = parts.map(|part| weight * part);
        if sums.is_empty() {
            sums = parts.collect();
        } else {
            sums.iter_mut()
                .zip(parts)
                .for_each(|(sum, part)| *sum += part);
        }
    }
    worst(&sums, share(goals))
}

/// What brings errors of a goal to one scale with those of others.
fn weight(goal: &GoalRound) -> f64 {
    1.0 / (goal.tolerance * goal.value.abs())
}

/// The share of the errors that are halved: half of them far from the end, near it those that have
/// to go.
fn share(goals: &[GoalRound]) -> f64 {
    let excess = goals
        .iter()
        .map(|goal| 1.0 - goal.tolerance / goal.relative());
    let excess = excess.fold(0.0, f64::max);
    (MARKED * excess).clamp(LEAST_SHARE, SHARE)
}

fn worst(parts: &[f64], share: f64) -> Vec<u32> {
    let mut order: Vec<(u32, f64)> = (0..).zip(parts.iter().copied()).collect();
    order.sort_by(|one, other| other.1.total_cmp(&one.1).then(one.0.cmp(&other.0)));
    let goal = share * parts.iter().sum::<f64>();
    let mut sum = 0.0;
    let enough = |&&(_, part): &&(u32, f64)| {
        let goes_on = sum < goal;
        sum += part;
        goes_on
    };
    let mut marked: Vec<u32> = order.iter().take_while(enough).map(|one| one.0).collect();
    marked.sort_unstable();
    marked
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::GoalBound;

    fn goal(value: f64, bound: f64) -> GoalRound {
        GoalRound {
            goal: "force.lid.y".to_owned(),
            value,
            estimate: 0.0,
            bound,
            geometry: 0.0,
            tolerance: 0.1,
        }
    }

    fn answer(cells: &[f64]) -> GoalReport {
        GoalReport {
            by_nodes: None,
            value: 1.0,
            bound: Some(GoalBound {
                cells: cells.to_vec(),
                ..GoalBound::default()
            }),
            ..GoalReport::default()
        }
    }

    #[test]
    fn the_fewest_cells_that_hold_half_of_the_errors_are_marked() {
        let marked = |cells: &[f64]| marks(&[goal(1.0, 10.0)], &[answer(cells)]);
        assert_eq!(marked(&[1.0, 4.0, 2.0, 1.0]), [1]);
        assert_eq!(marked(&[1.0, 1.0, 1.0, 1.0]), [0, 1]);
        assert_eq!(marked(&[0.5, 0.1, 3.0, 3.0]), [2, 3]);
        assert!(marked(&[0.0, 0.0]).is_empty());
    }

    #[test]
    fn near_the_end_only_what_is_too_much_is_marked() {
        let cells = [1.0; 20];
        let [far, near, nearest] =
            [1.0, 0.12, 0.101].map(|bound| marks(&[goal(1.0, bound)], &[answer(&cells)]).len());
        assert_eq!([far, near, nearest], [10, 5, 2]);
    }

    #[test]
    fn goals_that_are_known_do_not_mark_cells_and_others_count_by_what_they_lack() {
        let answers = [answer(&[9.0, 0.0, 0.0]), answer(&[0.0, 1.0, 2.0])];
        let goals = [goal(1.0, 0.05), goal(1.0, 10.0)];
        assert_eq!(marks(&goals, &answers), [2]);
    }

    #[test]
    fn a_goal_of_value_zero_has_no_relative_error() {
        let goals = [goal(0.0, 0.0)];
        assert!(!goals[0].is_reached() && goals[0].relative().is_infinite());
        let zero = Some(End::Zero("force.lid.y".to_owned()));
        assert_eq!(end(&goals, &[answer(&[0.0])]), zero);
        // By symmetry, to rounding.
        assert_eq!(end(&[goal(1e-15, 1e-3)], &[answer(&[0.0])]), zero);
        assert_eq!(end(&[goal(1e-6, 1e-3)], &[answer(&[0.0])]), None);
    }

    #[test]
    fn what_the_solver_left_ends_the_loop_where_it_is_too_much() {
        let answer = GoalReport {
            bound: Some(GoalBound {
                solver: 0.4,
                ..GoalBound::default()
            }),
            ..GoalReport::default()
        };
        let found = end(&[goal(2.0, 1.0)], &[answer]);
        let expected = End::Solver {
            goal: "force.lid.y".to_owned(),
            relative: 0.2,
        };
        assert_eq!(found, Some(expected));
    }

    #[test]
    fn facets_that_make_too_much_end_the_loop() {
        let mut goal = goal(2.0, 1.0);
        goal.geometry = 0.3;
        let relative = 0.15;
        let goal_name = goal.goal.clone();
        let found = end(&[goal], &[answer(&[1.0])]);
        let expected = End::Facets {
            goal: goal_name,
            relative,
        };
        assert_eq!(found, Some(expected));
    }
}
