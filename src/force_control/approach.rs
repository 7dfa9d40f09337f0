//! Pushed obstacles that do not touch the body: each is led along its force to where it
//! touches, and further to where the dense problem in the metric says that it exerts its force,
//!
//! ```text
//! min 1/2 l.H l + (g + s D e).l   with l >= 0,   -(D e).l = F.e
//! ```
//!
//! e the direction of the pushes, s how far beyond touch. Cost: some distances of all faces,
//! and a few dense problems.

use super::gap_changes::gap_changes;
use crate::inequality::dense_cone;
use crate::linalg::vector::{add_scaled, dot, norm};
use crate::model::push::{Control, Part};
use crate::proximity::faces;
use crate::saddle::Status;
use crate::sqp::contact_metric::evenly;
use crate::sqp::program::QuadraticProgram;
use crate::sqp::run::Run;

constants! {
    /// Distance over the body's length that counts as touch.
    pub(super) const TOUCH: f64 = 1e-9;
    /// Distances that are looked at on the way.
    pub(super) const MOST_DISTANCES: u32 = 200;
    /// Way over the body's length after which nothing comes any more.
    pub(super) const FARTHEST: f64 = 1e3;
    /// First advance beyond touch, and the longest one.
    pub(super) const ADVANCES: [f64; 2] = [1e-3, 0.3];
    /// Dense problems at most.
    const MOST_PROBLEMS: u32 = 48;
    /// Width of what is left to search over its upper end at which the search ends.
    const NARROW: f64 = 1e-12;
    /// Share of the force that is near enough.
    const NEAR: f64 = 0.02;
}

/// Leads the obstacles of `controls` that exert nothing and shall exert `goal` `[controls]` to
/// touch, in the state; the step that goes on from there, none where all touch already or one
/// meets nothing, and the state is as it was.
pub(super) fn lead(run: &mut Run<'_>, controls: &[Control], goal: &[f64]) -> Option<Vec<f64>> {
    let poses = run.state.drive.poses.clone();
    let step = step_after_touch(run, controls, goal);
    if step.is_none() {
        run.state.drive.poses = poses;
    }
    step
}

/// The same, with the poses of an obstacle that meets nothing as far as it went.
fn step_after_touch(run: &mut Run<'_>, controls: &[Control], goal: &[f64]) -> Option<Vec<f64>> {
    let mut push = vec![0.0; controls.len()];
    for (obstacle, force) in forces(controls, goal) {
        if !touches(run, obstacle) {
            advance(run, obstacle, force)?;
            let own = controls.iter().zip(goal).zip(&mut push);
            let own = own.filter(|((control, _), _)| is_force_of(control, obstacle));
            own.for_each(|((_, goal), push)| *push = *goal);
        }
    }
    let size = norm(&push);
    (size > 0.0).then(|| {
        let direction: Vec<f64> = push.iter().map(|part| part / size).collect();
        let way = slack(run, controls, &push) + beyond(run, controls, (&direction, size));
        direction.iter().map(|part| way * part).collect()
    })
}

/// How far a body that only obstacles hold is pushed as a whole, along the `push`
/// `[controls]`, until it meets another obstacle.
fn slack(run: &mut Run<'_>, controls: &[Control], push: &[f64]) -> f64 {
    if !run.model.plan.is_floating() {
        return 0.0;
    }
    let pushed = forces(controls, push);
    let mut longest = 0.0_f64;
    for &(obstacle, force) in &pushed {
        let back = force.map(|part| -part);
        let others = (0..run.state.drive.poses.len()).filter(|&other| other != obstacle);
        let way = nearest(run, others, back);
        longest = longest.max(way.unwrap_or(0.0));
    }
    longest
}

/// How far the nearest of `obstacles` is along `way`; none where no one is met.
fn nearest(
    run: &mut Run<'_>,
    obstacles: impl Iterator<Item = usize>,
    way: [f64; 3],
) -> Option<f64> {
    let ways = obstacles.filter_map(|other| {
        let pose = run.state.drive.poses[other].clone();
        let way = advance(run, other, way);
        run.state.drive.poses[other] = pose;
        way
    });
    ways.min_by(f64::total_cmp)
}

/// Obstacles that shall exert a force, with what is named of it.
fn forces(controls: &[Control], goal: &[f64]) -> Vec<(usize, [f64; 3])> {
    let mut forces: Vec<(usize, [f64; 3])> = Vec::new();
    for (control, &goal) in controls.iter().zip(goal) {
        let Part::Obstacle(number) = control.part else {
            continue;
        };
        if control.axis >= 3 || goal == 0.0 {
            continue;
        }
        match forces.last_mut() {
            Some((obstacle, force)) if *obstacle == number => force[control.axis] = goal,
            _ => {
                let mut force = [0.0; 3];
                force[control.axis] = goal;
                forces.push((number, force));
            }
        }
    }
    forces
}

fn is_force_of(control: &Control, obstacle: usize) -> bool {
    control.part == Part::Obstacle(obstacle) && control.axis < 3
}

/// Whether an obstacle presses on the body anywhere.
fn touches(run: &Run<'_>, number: usize) -> bool {
    let interface = &run.model.interfaces.list[number];
    let pressures = interface.own(&run.state.multiplier);
    pressures.iter().any(|&pressure| pressure != 0.0)
}

/// Moves an obstacle along `force` by its distance from the body until it touches, and says how
/// far; none where it passes by.
fn advance(run: &mut Run<'_>, obstacle: usize, force: [f64; 3]) -> Option<f64> {
    let size = norm(&force);
    let length = run.model.plan.problem.units.length;
    let mut way = 0.0;
    for _ in 0..MOST_DISTANCES {
        let body = run.model.deformed(&run.state.displacement);
        let (interface, met) = run.model.placed(&run.state.drive).nth(obstacle)?;
        let distances = faces::distances(&body, &interface.surface, met.obstacle()?);
        let distance = distances.into_iter().fold(f64::INFINITY, f64::min);
        if distance <= TOUCH {
            return Some(way);
        }
        way += distance;
        if way.is_nan() || way >= FARTHEST {
            return None;
        }
        let pose = &mut run.state.drive.poses[obstacle];
        let parts = pose.translation.iter_mut().zip(force);
        parts.for_each(|(x, part)| *x += distance * length * part / size);
    }
    None
}

/// How far beyond touch, along `direction` `[controls]`, the metric says that the obstacles
/// exert `force` along it.
fn beyond(run: &mut Run<'_>, controls: &[Control], (direction, force): (&[f64], f64)) -> f64 {
    let now = run.evaluate();
    let program = QuadraticProgram::new(run, &now, None, &mut 0.0);
    let mut along = vec![0.0; now.gap.len()];
    let changes = gap_changes(&run.model, run.state, controls);
    for (change, part) in changes.iter().zip(direction) {
        add_scaled(&mut along, *part, change);
    }
    let resisting = resisting(run, controls, direction);
    let open: Vec<Status> = run.state.status.clone();
    let none = vec![0.0; now.gap.len()];
    let exerted = |way: f64| {
        let mut gap = now.gap.clone();
        add_scaled(&mut gap, way, &along);
        let solved = dense_cone::solve(program.metric(), &gap, now.contact_set(), (&open, &none));
        solved.map_or(0.0, |solution| {
            let pushing = -dot(&along, &solution.values);
            let resisting = resisting.as_ref();
            resisting.map_or(pushing, |other| pushing.min(dot(other, &solution.values)))
        })
    };
    if program.metric().size() != now.gap.len() {
        return ADVANCES[0];
    }
    secant_of_powers(exerted, force * evenly(&run.model))
}

/// What other obstacles exert against `direction` `[controls]` for each unit of their pressures
/// `[multipliers]`, on a body that only they hold: the metric has rigid motions resist a little,
/// which nothing does. None where supports hold the body.
fn resisting(run: &Run<'_>, controls: &[Control], direction: &[f64]) -> Option<Vec<f64>> {
    if !run.model.plan.is_floating() {
        return None;
    }
    let mut sums = [0.0; 3];
    let forces = controls.iter().zip(direction);
    for (control, part) in forces.filter(|(control, _)| control.axis < 3) {
        sums[control.axis] += part;
    }
    let is_pushed = |obstacle: usize| {
        let mut own = controls.iter().zip(direction);
        own.any(|(control, part)| is_force_of(control, obstacle) && *part != 0.0)
    };
    let others = (0..run.state.drive.poses.len()).filter(|&other| !is_pushed(other));
    let axes = |obstacle| {
        (0..3).map(move |axis| Control {
            part: Part::Obstacle(obstacle),
            axis,
        })
    };
    let others = others.flat_map(axes);
    let others: Vec<Control> = others.collect();
    // Pushes that balance each other need no one else.
    if others.is_empty() || norm(&sums) < 0.5 * norm(direction) {
        return None;
    }
    let mut all = vec![0.0; run.state.multiplier.len()];
    let changes = gap_changes(&run.model, run.state, &others);
    for (control, change) in others.iter().zip(&changes) {
        add_scaled(&mut all, sums[control.axis], change);
    }
    Some(all)
}

/// Way s at which f(s), which rises about as a power of s, is `force`.
fn secant_of_powers(exerted: impl Fn(f64) -> f64, force: f64) -> f64 {
    let [mut way, longest] = ADVANCES;
    let mut last: Option<(f64, f64)> = None;
    // Ways with too little and too much of the force.
    let mut within = [0.0, longest];
    for _ in 0..MOST_PROBLEMS {
        let found = exerted(way);
        if (found - force).abs() <= NEAR * force || within[1] - within[0] <= NARROW * within[1] {
            break;
        }
        within[usize::from(found > force)] = way;
        let next = match last {
            _ if found <= 0.0 => 4.0 * way,
            // Of a half space under a ball; steeper where edges or walls are met.
            None => way * (force / found).powf(1.0 / 1.5),
            Some((before, earlier)) => {
                let power = ((found / earlier).ln() / (way / before).ln()).clamp(1.0, 3.0);
                way * (force / found).powf(1.0 / power)
            }
        };
        if found > 0.0 {
            last = Some((way, found));
        }
        let is_within = next > within[0] && next < within[1];
        way = if is_within { next } else { middle(within) };
    }
    way
}

/// Between two ways: in the middle of their powers, or far down where the lower one is none.
fn middle([low, high]: [f64; 2]) -> f64 {
    if low > 0.0 {
        (low * high).sqrt()
    } else {
        0.1 * high
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_is_met_in_a_few_problems() {
        for (factor, power, force) in [(2.0, 1.5, 0.01), (30.0, 1.0, 1e-4), (1.0, 2.0, 0.05)] {
            let way = secant_of_powers(|way| factor * way.powf(power), force);
            let found = factor * way.powf(power);
            assert!((found / force - 1.0).abs() <= NEAR, "{found} {force}");
        }
    }

    #[test]
    fn a_force_that_begins_after_a_gap_is_met_however_small_it_is() {
        for (gap, force) in [(0.01, 1e-3), (0.01, 1e-9), (0.25, 1e-7), (1e-6, 1e-12)] {
            let exerted = |way: f64| 20.0 * (way - gap).max(0.0).powf(1.2);
            let found = exerted(secant_of_powers(exerted, force));
            assert!((found / force - 1.0).abs() <= 0.5, "{found} {force}");
        }
    }

    #[test]
    fn forces_are_those_of_each_obstacle() {
        let controls = [(0, 2), (1, 0), (1, 1), (1, 5), (2, 3)];
        let controls = controls.map(|(obstacle, axis)| Control {
            part: Part::Obstacle(obstacle),
            axis,
        });
        let found = forces(&controls, &[-1.0, 0.0, 3.0, 7.0, 9.0]);
        assert_eq!(found, [(0, [0.0, 0.0, -1.0]), (1, [0.0, 3.0, 0.0])]);
    }
}
