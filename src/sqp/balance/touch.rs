//! Pushed obstacles that do not touch the body: each is led along its force to where it
//! touches, and further to where the dense problem in the metric says that it exerts its force,
//!
//! ```text
//! min 1/2 l.H l + (g + s D e).l   with l >= 0,   -(D e).l = F.e
//! ```
//!
//! e the direction of the pushes, s how far beyond touch. Cost: some distances of all faces,
//! and a few dense problems.

use super::rigid::gap_changes;
use crate::contact::nearest::nearest;
use crate::inequality::dense_cone;
use crate::linalg::vector::{add_scaled, dot, norm};
use crate::model::push::Control;
use crate::saddle::Status;
use crate::sqp::program::QuadraticProgram;
use crate::sqp::run::Run;

/// Distance over the body's length that counts as touch.
const TOUCH: f64 = 1e-9;
/// Distances that are looked at on the way.
const MOST_DISTANCES: u32 = 200;
/// Way over the body's length behind which nothing comes any more.
const FARTHEST: f64 = 1e3;
/// First advance beyond touch, and the longest one.
const ADVANCES: [f64; 2] = [1e-3, 0.3];
/// Dense problems at most.
const MOST_PROBLEMS: u32 = 8;
/// Share of the force that is near enough.
const NEAR: f64 = 0.02;

/// Leads the obstacles of `controls` that exert nothing and shall exert `goal` `[controls]` to
/// touch, in the state; the step that goes on from there, none where all touch already or one
/// meets nothing, and the state is as it was.
pub(super) fn lead(run: &mut Run<'_>, controls: &[Control], goal: &[f64]) -> Option<Vec<f64>> {
    let poses = run.state.drive.poses.clone();
    let step = step_behind_touch(run, controls, goal);
    if step.is_none() {
        run.state.drive.poses = poses;
    }
    step
}

/// The same, with the poses of an obstacle that meets nothing as far as it went.
fn step_behind_touch(run: &mut Run<'_>, controls: &[Control], goal: &[f64]) -> Option<Vec<f64>> {
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
        let way = beyond(run, controls, (&direction, size));
        direction.iter().map(|part| way * part).collect()
    })
}

/// Obstacles that shall exert a force, with what is named of it.
fn forces(controls: &[Control], goal: &[f64]) -> Vec<(usize, [f64; 3])> {
    let mut forces: Vec<(usize, [f64; 3])> = Vec::new();
    for (control, &goal) in controls.iter().zip(goal) {
        if control.axis >= 3 || goal == 0.0 {
            continue;
        }
        match forces.last_mut() {
            Some((obstacle, force)) if *obstacle == control.obstacle => force[control.axis] = goal,
            _ => {
                let mut force = [0.0; 3];
                force[control.axis] = goal;
                forces.push((control.obstacle, force));
            }
        }
    }
    forces
}

fn is_force_of(control: &Control, obstacle: usize) -> bool {
    control.obstacle == obstacle && control.axis < 3
}

/// Whether an obstacle presses on the body anywhere.
fn touches(run: &Run<'_>, obstacle: usize) -> bool {
    let interface = &run.model.interfaces.list[obstacle];
    let pressures = interface.own(&run.state.multiplier);
    pressures.iter().any(|&pressure| pressure != 0.0)
}

/// Moves an obstacle along `force` by its distance from the body until it touches; none where
/// it passes by.
fn advance(run: &mut Run<'_>, obstacle: usize, force: [f64; 3]) -> Option<()> {
    let size = norm(&force);
    let length = run.model.plan.units.length;
    let mut way = 0.0;
    for _ in 0..MOST_DISTANCES {
        let body = run.model.deformed(&run.state.displacement);
        let (interface, met) = run.model.placed(&run.state.drive).nth(obstacle)?;
        met.obstacle()?;
        let distances = nearest(&body, &interface.surface, &met);
        let distance = distances.into_iter().fold(f64::INFINITY, f64::min);
        if distance <= TOUCH {
            return Some(());
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
    let open: Vec<Status> = run.state.status.clone();
    let none = vec![0.0; now.gap.len()];
    let exerted = |way: f64| {
        let mut gap = now.gap.clone();
        add_scaled(&mut gap, way, &along);
        let solved = dense_cone::solve(program.metric(), &gap, now.contact_set(), (&open, &none));
        solved.map_or(0.0, |solution| -dot(&along, &solution.values))
    };
    if program.metric().size() != now.gap.len() {
        return ADVANCES[0];
    }
    secant_of_powers(exerted, force)
}

/// Way s at which f(s), about a power of s, is `force`.
fn secant_of_powers(exerted: impl Fn(f64) -> f64, force: f64) -> f64 {
    let [mut way, longest] = ADVANCES;
    let mut last: Option<(f64, f64)> = None;
    for _ in 0..MOST_PROBLEMS {
        let found = exerted(way);
        if found <= 0.0 {
            way = (4.0 * way).min(longest);
            continue;
        }
        if (found - force).abs() <= NEAR * force {
            break;
        }
        // Of a half space under a ball; steeper where edges or walls are met.
        let power = match last {
            Some((before, earlier)) if (before - way).abs() > 0.0 => {
                ((found / earlier).ln() / (way / before).ln()).clamp(1.0, 3.0)
            }
            _ => 1.5,
        };
        last = Some((way, found));
        way = (way * (force / found).powf(1.0 / power)).clamp(1e-12, longest);
    }
    way
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
    fn forces_are_those_of_each_obstacle() {
        let controls = [(0, 2), (1, 0), (1, 1), (1, 5), (2, 3)];
        let controls = controls.map(|(obstacle, axis)| Control { obstacle, axis });
        let found = forces(&controls, &[-1.0, 0.0, 3.0, 7.0, 9.0]);
        assert_eq!(found, [(0, [0.0, 0.0, -1.0]), (1, [0.0, 3.0, 0.0])]);
    }
}
