//! Obstacles that are pushed: the components z of their poses that follow from what the
//! obstacles shall exert on the body,
//!
//! ```text
//! f(z) = F,   f(z) = -D^T l(z),   D = dg/dz
//! ```
//!
//! l(z) the contact pressures of the body in equilibrium at the poses z, g the gaps: forces and
//! moments about the reference points, as they are reported. Broyden's method, from the
//! stiffness that the metric of contact says ([`metric`]); an obstacle away from the body is
//! first led to it along its force ([`touch`]). Each solve is as accurate as the misfit that is
//! left makes worthwhile, and goes on from the one before. Non-dimensional; moments are of
//! forces at the body's length. Cost: 4 to 8 solves that together take about as many iterations
//! as one and a half at known poses.

mod metric;
mod rigid;
mod touch;

use super::accuracy;
use super::push_stiffness::{LONGEST, PushStiffness};
use super::run::Run;
use crate::linalg::vector::{largest, norm};
use crate::model::drive::Drive;
use crate::model::ending::{Ending, Site};
use crate::model::push::Control;
use crate::model::state::State;
use crate::plan::Units;
use crate::report::{Cause, Termination};
use crate::results::exerted::exerted;
use metric::by_metric;

/// Solves at most.
const MOST_SOLVES: u32 = 40;
/// Steps that led away or nowhere, one after the other, that end the search.
const MOST_FAILURES: u32 = 6;
/// Accuracy of the first solve.
const COARSE: f64 = 1e-3;
/// Accuracy of a solve over the misfit before it.
const SHARPNESS: f64 = 0.02;
/// Growth of the misfit behind which a step is taken back.
const WORSE: f64 = 1.5;
/// Part of a step that led away which is tried next.
const SHORTER: f64 = 0.25;
/// Share of a push that nothing balances from which on there is no equilibrium.
const UNBALANCED: f64 = 1e-3;
/// Steps as long as they may be, one after the other, that take nothing off: the obstacle slides
/// away.
const MOST_SLIDES: u32 = 3;
/// Share of the misfit that a step has to take off.
const PROGRESS: f64 = 0.1;
/// Misfits over the tolerance that count where the search comes no nearer.
const NEAR: f64 = 10.0;

/// Moves the state to equilibrium under `drive`, with the poses that its pushes ask for.
pub(super) fn solve(run: &mut Run<'_>, drive: &Drive) -> Ending {
    let controls = drive.controls();
    if controls.is_empty() {
        return accuracy::solve(run, drive);
    }
    let floor = run.model.tolerance;
    let ending = Balance::new(run, drive, controls).reach(run, floor);
    run.model.tolerance = floor;
    ending
}

/// A search for poses.
struct Balance {
    /// The components that are sought.
    controls: Vec<Control>,
    /// F, non-dimensional `[controls]`.
    goal: Vec<f64>,
    /// What drives the body, at the poses found so far.
    drive: Drive,
    /// df/dz as it is known; none before it is asked for.
    stiffness: Option<PushStiffness>,
}

/// How far a search has come.
struct Progress {
    /// f - F `[controls]`.
    misfit: Vec<f64>,
    /// Its largest entry over the largest force.
    relative: f64,
}

impl Balance {
    /// The search from the present poses of the state.
    fn new(run: &mut Run<'_>, drive: &Drive, controls: Vec<Control>) -> Self {
        let units = &run.model.plan.units;
        let goal = |control: &Control| {
            let push = drive.pushes[control.obstacle].components[control.axis];
            push.unwrap_or_default() / unit(units, control.axis)
        };
        let known = run.learned.under_pushes.take();
        Self {
            goal: controls.iter().map(goal).collect(),
            drive: drive.carried_by(&run.state.drive),
            stiffness: known.filter(|known| known.controls == controls),
            controls,
        }
    }

    /// Solves at one pose after the other until the pushes are met to `floor`.
    fn reach(mut self, run: &mut Run<'_>, floor: f64) -> Ending {
        let mut step = match touch::lead(run, &self.controls, &self.goal) {
            Some(first) => {
                self.drive = self.drive.carried_by(&run.state.drive);
                self.stiffness = None;
                first
            }
            None => self.first_step(run),
        };
        let mut before = self.progress(run);
        // Other loads change forces, too.
        let mut tells = self.is_only_pushed(run);
        let (mut failures, mut slides) = (0, 0);
        run.model.tolerance = COARSE.max(floor);
        for _ in 0..MOST_SOLVES {
            let kept = run.state.clone();
            self.go(&step, run.model.plan.units.length);
            let mut ending = accuracy::solve(run, &self.drive);
            if ending.is_stopped() {
                return ending;
            }
            let is_solved = ending.termination == Termination::Converged;
            let after = self.progress(run);
            let is_worse = after.relative > WORSE * before.relative.max(COARSE);
            // What other loads have changed is no fault of the step.
            if !is_solved || (tells && is_worse) {
                failures += 1;
                if failures > MOST_FAILURES {
                    return self.failed(ending, &after);
                }
                run.state.clone_from(&kept);
                self.go_back(&step, run.model.plan.units.length);
                step.iter_mut().for_each(|part| *part *= SHORTER);
                continue;
            }
            self.learn(&step, tells.then_some((&before, &after)));
            tells = true;
            let is_sharp = run.model.tolerance <= floor;
            let is_idle = after.relative > 0.5 * before.relative && is_sharp;
            let bound = if is_idle { NEAR * floor } else { floor };
            if after.relative <= bound && is_sharp {
                run.learned.under_pushes = self.stiffness;
                return ending;
            }
            let (next, rest) = self.step(run, &after.misfit);
            let takes_off = after.relative < (1.0 - PROGRESS) * before.relative;
            slides = match takes_off || norm(&step) < 0.5 * LONGEST {
                true => 0,
                false => slides + 1,
            };
            let lost = self.unbalanced(&rest, &after);
            let gone = || self.worst(&after.misfit).filter(|_| slides >= MOST_SLIDES);
            if let Some(control) = lost.or_else(gone) {
                ending.termination = Termination::NotConverged;
                // A tool that the body has left may meet it again farther along its force.
                ending.cause = Some(match touch::lead(run, &self.controls, &self.goal) {
                    Some(_) => Cause::IterationLimit,
                    None => Cause::NoEquilibrium,
                });
                ending.site = Some(named(control));
                return ending;
            }
            step = match after.relative <= floor {
                true => vec![0.0; self.controls.len()],
                false => next,
            };
            run.model.tolerance = (SHARPNESS * after.relative).clamp(floor, COARSE.max(floor));
            (before, failures) = (after, 0);
        }
        let mut ending = self.failed_ending(run);
        ending.site = self.worst(&before.misfit).map(named);
        ending
    }

    /// The first step of obstacles that touch: none where nothing says how far.
    fn first_step(&mut self, run: &mut Run<'_>) -> Vec<f64> {
        let misfit = self.progress(run).misfit;
        self.step(run, &misfit).0
    }

    /// The step that takes `misfit` off, as far as the stiffness is known, and what it leaves.
    fn step(&mut self, run: &mut Run<'_>, misfit: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let stiffness = match self.stiffness.take() {
            Some(known) => known,
            None => by_metric(run, &self.controls),
        };
        let solved = stiffness.solve(misfit);
        self.stiffness = Some(stiffness);
        solved
    }

    /// Whether the state is driven as it shall be but for its pushes and what follows from them.
    fn is_only_pushed(&self, run: &Run<'_>) -> bool {
        let now = Drive {
            pushes: self.drive.pushes.clone(),
            ..run.state.drive.clone()
        };
        now == self.drive
    }

    /// Takes over what a step has changed, before and after it; nothing of one that says nothing
    /// of the stiffness, which is then asked for anew.
    fn learn(&mut self, step: &[f64], ends: Option<(&Progress, &Progress)>) {
        let (Some(stiffness), Some((before, after))) = (&mut self.stiffness, ends) else {
            self.stiffness = None;
            return;
        };
        let change = after.misfit.iter().zip(&before.misfit);
        let change: Vec<f64> = change.map(|(after, before)| after - before).collect();
        stiffness.learn(step, &change);
    }

    /// f - F at the state.
    fn progress(&self, run: &Run<'_>) -> Progress {
        let found = exerted_at(run, run.state, &self.controls);
        let scale = self.scale(run);
        let misfit = found.iter().zip(&self.goal);
        let misfit: Vec<f64> = misfit.map(|(found, goal)| found - goal).collect();
        let relative = match scale > 0.0 {
            true => largest(&misfit) / scale,
            false => largest(&misfit),
        };
        Progress { misfit, relative }
    }

    /// The largest force that an obstacle exerts or shall exert, non-dimensional.
    fn scale(&self, run: &Run<'_>) -> f64 {
        let units = &run.model.plan.units;
        let forces = exerted(&run.model, run.state).into_iter();
        let forces = forces.flat_map(|exerted| [exerted[0], exerted[1], exerted[2]]);
        let force = forces.fold(0.0, |most: f64, x| most.max(x.abs())) / units.force();
        force.max(largest(&self.goal))
    }

    /// The control whose share of `rest`, which no motion takes off, is too large.
    fn unbalanced(&self, rest: &[f64], at: &Progress) -> Option<Control> {
        let scale = largest(&at.misfit) / at.relative.max(f64::MIN_POSITIVE);
        let is_lost = largest(rest) > UNBALANCED * scale;
        is_lost.then(|| self.worst(rest)).flatten()
    }

    /// The control with the largest of `values` `[controls]`.
    fn worst(&self, values: &[f64]) -> Option<Control> {
        let pairs = self.controls.iter().zip(values);
        let worst = pairs.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        worst.map(|(control, _)| *control)
    }

    /// Moves the poses by `step`, non-dimensional; the body's length is `length`.
    fn go(&mut self, step: &[f64], length: f64) {
        for (control, part) in self.controls.iter().zip(step) {
            let unit = if control.axis < 3 { length } else { 1.0 };
            *self.drive.component(*control) += part * unit;
        }
    }

    /// Moves the poses back by `step`.
    fn go_back(&mut self, step: &[f64], length: f64) {
        let back: Vec<f64> = step.iter().map(|part| -part).collect();
        self.go(&back, length);
    }

    /// The end of a search whose steps lead nowhere.
    fn failed(&self, mut ending: Ending, at: &Progress) -> Ending {
        if ending.termination == Termination::Converged {
            ending.termination = Termination::NotConverged;
            ending.cause = Some(Cause::IterationLimit);
            ending.site = self.worst(&at.misfit).map(named);
        }
        ending
    }

    /// The end of a search that took too many solves.
    fn failed_ending(&self, run: &mut Run<'_>) -> Ending {
        let mut ending = accuracy::solve(run, &self.drive);
        if ending.termination == Termination::Converged {
            ending.termination = Termination::NotConverged;
            ending.cause = Some(Cause::IterationLimit);
        }
        ending
    }
}

/// Where a push is not met.
fn named(control: Control) -> Site {
    Site {
        unbalanced: Some(control),
        ..Site::default()
    }
}

/// Unit of a force or a moment, in the caller's.
fn unit(units: &Units, axis: usize) -> f64 {
    match axis {
        0..3 => units.force(),
        _ => units.energy(),
    }
}

/// What the obstacles exert along `controls`, non-dimensional `[controls]`.
fn exerted_at(run: &Run<'_>, state: &State, controls: &[Control]) -> Vec<f64> {
    let units = &run.model.plan.units;
    let exerted = exerted(&run.model, state);
    let of_one =
        |control: &Control| exerted[control.obstacle][control.axis] / unit(units, control.axis);
    controls.iter().map(of_one).collect()
}
