//! Obstacles and supports that are pushed: the components z of their poses that follow from what
//! they shall exert on the body,
//!
//! ```text
//! f(z) = F,   f(z) = -D^T l(z),   D = dg/dz
//! ```
//!
//! l(z) the contact pressures of the body in equilibrium at the poses z, g the gaps: forces and
//! moments about the reference points, as they are reported; supports exert their reactions, and
//! springs to the ground k z with them. Broyden's method, from the
//! stiffness that the metric of contact says ([`by_metric`]), or with supports differences
//! ([`by_difference`]), taken anew where it says that nothing resists; an obstacle away from the body is
//! first led to it along its force ([`approach`]), and so is one that the body leaves on the way; bodies of
//! supports that nothing holds are led to what they meet ([`meeting`]); a tool that grips the body begins
//! with the least slip ([`least_slip`]).
//! Each solve is as accurate as the misfit that is left makes worthwhile, and goes on from the
//! one before. Non-dimensional; moments are of
//! forces at the body's length. Cost: 7 to 10 solves that together take about as many iterations
//! as 1.2 at known poses, where one component is sought.

mod approach;
mod broyden;
mod by_difference;
mod by_metric;
mod gap_changes;
mod least_slip;
mod meeting;

use crate::linalg::vector::{add_scaled, dot, largest, norm, ratio};
use crate::model::drive::Drive;
use crate::model::ending::{Ending, Site};
use crate::model::push::Control;
use crate::plan::Units;
use crate::report::{Cause, Termination};
use crate::results::exerted::applied;
use crate::sqp::push_stiffness::{LONGEST, PushStep, PushStiffness};
use crate::sqp::run::Run;
use crate::sqp::{accuracy, increment};
use broyden::{BroydenIterate, Progress, Stall};
use by_difference::by_difference;
use by_metric::by_metric;
use gap_changes::gap_changes;
use least_slip::least_slip;
use meeting::lead_bodies;

constants! {
    /// Solves at most.
    const MOST_SOLVES: u32 = 40;
    /// Steps that led away or nowhere, one after the other, after which one more ends the search.
    const MOST_FAILURES: u32 = 6;
    /// Times that obstacles which the body has left are led back to it.
    const MOST_APPROACHES: u32 = 3;
    /// Accuracy of the first solve, and the misfit below which growth is no matter.
    const COARSE: f64 = 1e-3;
    /// Accuracy of the first solve after touch for one component, of whose force the metric is
    /// some tenths wrong; several have directions that hardly show, and a body that nothing else holds
    /// is out of balance by as much: they want a sharper one.
    const ROUGH: f64 = 0.05;
    /// Accuracy of a solve over the misfit before it, for one component and for several, whose
    /// stiffness is learnt.
    const SHARPNESS: [f64; 2] = [0.05, 0.02];
    /// Share of the misfit left by a step after which the stiffness wants to be learnt.
    const SLOW: f64 = 0.3;
    /// Share of the stiffness that the metric says, least and most, that is believed of a body.
    const STIFFER: [f64; 2] = [0.5, 2.0];
    /// Change of forces over what was expected that shows nothing of a step.
    const UNNOTICED: f64 = 0.1;
    /// Share of a push that nothing balances from which on there is no equilibrium.
    const UNBALANCED: f64 = 1e-3;
    /// Steps as long as they may be, one after the other, that take nothing off: the obstacle slides
    /// away.
    const MOST_SLIDES: u32 = 3;
}

/// Moves the state to equilibrium under `drive`, with the poses that its pushes ask for.
pub(crate) fn solve(run: &mut Run<'_>, drive: &Drive) -> Ending {
    let controls = drive.controls();
    if controls.is_empty() {
        return accuracy::solve(run, drive);
    }
    Balance::new(run, drive, controls).reach(run)
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
    /// How much stiffer than the metric says the body has shown to be after touch.
    stiffer: f64,
    /// The largest force that supports have exerted at the start: what one that is released to
    /// nothing is measured by. Zero without pushed supports.
    begun: f64,
    /// Accuracy of the next solve, and that which the pushes shall be met to.
    tolerance: f64,
    floor: f64,
}

impl Balance {
    /// The search from the present poses of the state.
    fn new(run: &mut Run<'_>, drive: &Drive, controls: Vec<Control>) -> Self {
        let units = &run.model.plan.problem.units;
        let goal = |control: &Control| drive.goal(*control) / unit(units, control.axis);
        let known = run.learned.under_pushes.take();
        let floor = run.model.conditions.tolerance;
        Self {
            goal: controls.iter().map(goal).collect(),
            drive: drive.carried_by(&run.state.drive),
            stiffness: known.filter(|known| known.controls == controls),
            begun: begun(run, drive, &controls),
            stiffer: 1.0,
            tolerance: floor,
            floor,
            controls,
        }
    }

    /// Solves at one pose after the other until the pushes are met.
    fn reach(mut self, run: &mut Run<'_>) -> Ending {
        let length = run.model.plan.problem.units.length;
        let (mut iterate, mut solves) = (self.begin(run), 0);
        let mut stall = Stall::default();
        loop {
            let kept = run.state.clone();
            self.go(&iterate.step, length);
            let (ending, after) = self.solved(run, &iterate);
            if ending.is_stopped() {
                return ending;
            }
            solves += 1;
            if iterate.leads_away(&ending, &after) {
                if iterate.failures == MOST_FAILURES || solves == MOST_SOLVES || run.is_spent() {
                    return self.given_up(ending, &after);
                }
                run.state.clone_from(&kept);
                self.go_back(&iterate.step, length);
                iterate.shorten();
                continue;
            }
            self.learn(&iterate, &after);
            let is_there = iterate.is_there(&after, self.tolerance, self.floor);
            if is_there || self.is_unresolved(run, &after) {
                run.learned.under_pushes = self.stiffness;
                return ending;
            }
            stall.note(&iterate.step, &after);
            if stall.is_beyond_the_largest() {
                return unmet(ending, Cause::NoEquilibrium, self.worst(&after.misfit));
            }
            if solves == MOST_SOLVES {
                return self.given_up(ending, &after);
            }
            match self.next(run, iterate, after) {
                Ok(next) => iterate = next,
                Err((cause, control)) => return unmet(ending, cause, Some(control)),
            }
        }
    }

    /// Solves at the present poses, more sharply where the step that led to them does not show.
    fn solved(&mut self, run: &mut Run<'_>, iterate: &BroydenIterate) -> (Ending, Progress) {
        loop {
            let ending = accuracy::solve(&mut run.to(self.tolerance), &self.drive);
            let after = self.progress(run);
            let is_sharp = self.tolerance <= self.floor;
            let is_solved = ending.termination == Termination::Converged;
            if is_sharp || !is_solved || !self.is_unnoticed(iterate, &after) {
                return (ending, after);
            }
            self.tolerance = (SHARPNESS[1] * self.tolerance).max(self.floor);
        }
    }

    /// Whether what is missing is less than gaps as exact as they are asked for can tell: near full
    /// contact of a body that keeps its volume forces change without end on no way at all.
    fn is_unresolved(&mut self, run: &mut Run<'_>, after: &Progress) -> bool {
        if self.tolerance > self.floor || after.relative > COARSE || self.moves_supports() {
            return false;
        }
        let (PushStep { step, .. }, _) = self.step(run, after);
        let mut moved = vec![0.0; run.state.multiplier.len()];
        let changes = gap_changes(&run.model, run.state, &self.controls);
        for (change, part) in changes.iter().zip(step) {
            add_scaled(&mut moved, part, change);
        }
        norm(&moved) <= self.floor * run.state.scales.gap
    }

    /// Whether forces have hardly changed where the stiffness says that they do.
    fn is_unnoticed(&self, iterate: &BroydenIterate, after: &Progress) -> bool {
        let expected = self
            .stiffness
            .as_ref()
            .map_or(0.0, |stiffness| largest(&stiffness.product(&iterate.step)));
        iterate.tells && largest(&iterate.change(after)) < UNNOTICED * expected
    }

    /// The start from the poses of the state, of obstacles that touch; none takes a step
    /// where nothing says how far.
    fn begin(&mut self, run: &mut Run<'_>) -> BroydenIterate {
        if let Some(step) = approach::lead(run, &self.controls, &self.goal) {
            return self.led(run, step);
        }
        let before = self.progress(run);
        let (PushStep { mut step, .. }, _) = self.step(run, &before);
        if let Some(rolling) = least_slip(run, &self.drive, &self.controls) {
            add_scaled(&mut step, 1.0, &rolling);
        }
        self.tolerance = COARSE.max(self.floor);
        let tells = self.is_only_pushed(run) && self.is_balanced(run);
        BroydenIterate::new(step, before, tells)
    }

    /// The start after obstacles that were led to the body and take `step` into it.
    fn led(&mut self, run: &Run<'_>, step: Vec<f64>) -> BroydenIterate {
        self.drive = self.drive.carried_by(&run.state.drive);
        self.stiffness = None;
        self.tolerance = self.roughest(run).max(self.floor);
        BroydenIterate::new(step, self.progress(run), self.is_only_pushed(run))
    }

    /// The least accuracy of a solve.
    fn roughest(&self, run: &Run<'_>) -> f64 {
        if self.controls.len() == 1 && !run.model.plan.is_floating() {
            ROUGH
        } else {
            COARSE
        }
    }

    /// How a search goes on `after` its last step; the push that is not met, and why, where
    /// it does not.
    fn next(
        &mut self,
        run: &mut Run<'_>,
        iterate: BroydenIterate,
        after: Progress,
    ) -> Result<BroydenIterate, (Cause, Control)> {
        let was_known = self.stiffness.is_some();
        let (mut found, mut lost) = self.step(run, &after);
        if was_known && self.moves_supports() && largest(&lost) > 0.0 {
            // Friction and other bodies resist once they press, which they did not where it was taken.
            self.stiffness = None;
            (found, lost) = self.step(run, &after);
        }
        // A body held between supports takes any motion that a search may go, each step by as much as
        // may be.
        let slides = if self.moves_supports() && found.way < f64::from(MOST_SOLVES) * LONGEST {
            0
        } else {
            iterate.slides(&after)
        };
        let slid_away = || self.worst(&after.misfit).filter(|_| slides >= MOST_SLIDES);
        let unbalanced = self.worst(&lost).filter(|_| largest(&lost) > 0.0);
        if let Some(control) = unbalanced.or_else(slid_away) {
            return self.led_on(run, (iterate.approaches, control), &lost);
        }
        let step = if after.relative <= self.floor {
            vec![0.0; self.controls.len()]
        } else {
            found.step
        };
        // A misfit below the error of the solve is small by chance.
        let misfit = after.relative.max(after.tolerance);
        let is_slow = after.relative > SLOW * iterate.before.relative;
        let sharpness = SHARPNESS[usize::from(is_slow || self.controls.len() > 1)];
        let floor = self.floor;
        self.tolerance = (sharpness * misfit).clamp(floor, self.roughest(run).max(floor));
        let stiffness = self.stiffness.as_ref();
        let expected = stiffness.map_or(f64::INFINITY, |known| largest(&known.product(&step)));
        Ok(BroydenIterate {
            slides,
            approaches: iterate.approaches,
            expected,
            ..BroydenIterate::new(step, after, true)
        })
    }

    /// The search from where a tool or body that nothing holds against `control` meets something again,
    /// farther along its force or along the direction `lost` `[controls]`.
    fn led_on(
        &mut self,
        run: &mut Run<'_>,
        (approaches, control): (u32, Control),
        lost: &[f64],
    ) -> Result<BroydenIterate, (Cause, Control)> {
        let step = approach::lead(run, &self.controls, &self.goal)
            .or_else(|| lead_bodies(run, &self.controls, lost));
        let Some(step) = step else {
            return Err((Cause::NoEquilibrium, control));
        };
        if approaches == MOST_APPROACHES {
            return Err((Cause::IterationLimit, control));
        }
        Ok(BroydenIterate {
            approaches: approaches + 1,
            ..self.led(run, step)
        })
    }

    /// The step that takes the misfit off, as far as the stiffness is known, and the direction in which
    /// nothing balances it `[controls]`, zeros where something does.
    fn step(&mut self, run: &mut Run<'_>, at: &Progress) -> (PushStep, Vec<f64>) {
        let misfit = &at.misfit;
        let stiffer = std::mem::replace(&mut self.stiffer, 1.0);
        let by_supports = self.moves_supports();
        let stiffness = self.stiffness.get_or_insert_with(|| {
            if by_supports {
                by_difference(run, &self.drive, &self.controls, misfit)
            } else {
                by_metric(run, &self.controls).times(stiffer)
            }
        });
        let found = stiffness.solve(misfit);
        let lost = found.rest.iter().zip(&found.free).map(|(rest, free)| {
            if rest.abs() > UNBALANCED * at.scale {
                -free
            } else {
                0.0
            }
        });
        let lost = lost.collect();
        (found, lost)
    }

    /// Whether any of what is sought moves a support, whose stiffness is that of the body.
    fn moves_supports(&self) -> bool {
        self.controls.iter().any(|control| control.is_of_support())
    }

    /// Whether the state is driven as it shall be but for its pushes and what follows from them.
    fn is_only_pushed(&self, run: &Run<'_>) -> bool {
        let now = Drive {
            pushes: self.drive.pushes.clone(),
            support_pushes: self.drive.support_pushes.clone(),
            ..run.state.drive.clone()
        };
        let plan = run.model.plan;
        now.felt_by(plan) == self.drive.felt_by(plan)
    }

    /// Whether the state is in equilibrium at its poses, which one that comes from a coarser mesh is not: its
    /// forces then change whatever the step.
    fn is_balanced(&self, run: &mut Run<'_>) -> bool {
        let (now, scales) = (run.evaluate(), run.state.scales);
        let left = increment::residuals(run.state, &now, run.state.force_scale);
        run.state.scales = scales;
        left.largest() <= COARSE.max(self.floor)
    }

    /// Takes over what a step has changed; nothing of one that says nothing of the stiffness,
    /// which is then asked for anew.
    fn learn(&mut self, iterate: &BroydenIterate, after: &Progress) {
        let Some(stiffness) = &mut self.stiffness else {
            // The step after touch came from the metric, which was asked for the whole push.
            if self.controls.len() == 1 {
                self.stiffer = self.share(after).clamp(STIFFER[0], STIFFER[1]);
            }
            return;
        };
        if !iterate.tells {
            // That of a body between supports changes little with other loads.
            if !self.moves_supports() {
                self.stiffness = None;
            }
            return;
        }
        let change = iterate.change(after);
        // Of a step too short to show in solves as inexact as these nothing is learnt.
        let expected = largest(&stiffness.product(&iterate.step));
        let noise = after.noise().max(iterate.before.noise());
        if iterate.is_felt() && largest(&change).max(expected) > noise {
            stiffness.learn(&iterate.step, &change);
        }
    }

    /// What obstacles exert along what they shall, over that: the metric was asked for one.
    fn share(&self, after: &Progress) -> f64 {
        1.0 + ratio(dot(&after.misfit, &self.goal), dot(&self.goal, &self.goal))
    }

    /// f - F at the state.
    fn progress(&self, run: &Run<'_>) -> Progress {
        let units = &run.model.plan.problem.units;
        let found = applied(&run.model, run.state, &self.drive);
        let misfit = self.controls.iter().zip(&self.goal);
        let misfit =
            misfit.map(|(control, goal)| found.at(*control) / unit(units, control.axis) - goal);
        let misfit: Vec<f64> = misfit.collect();
        let forces = found.obstacles.iter().chain(&found.supports);
        let forces = forces.flat_map(|exerted| &exerted[..3]);
        let force = forces.fold(0.0, |most: f64, x| most.max(x.abs())) / units.force();
        let scale = force.max(largest(&self.goal)).max(self.begun);
        let relative = if scale > 0.0 {
            largest(&misfit) / scale
        } else {
            largest(&misfit)
        };
        Progress {
            misfit,
            relative,
            scale,
            tolerance: self.tolerance,
            // That of supports is of the motion of a stiff part, not of what they bear.
            force_scale: if self.moves_supports() {
                scale
            } else {
                run.state.force_scale
            },
        }
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

    /// The end of a search whose steps lead nowhere, or that took too many.
    fn given_up(&self, ending: Ending, at: &Progress) -> Ending {
        if ending.termination == Termination::Converged {
            unmet(ending, Cause::IterationLimit, self.worst(&at.misfit))
        } else {
            ending
        }
    }
}

/// What pushed supports exert at the state along the controls, the largest of it, non-dimensional.
fn begun(run: &Run<'_>, drive: &Drive, controls: &[Control]) -> f64 {
    if drive.support_pushes.is_empty() {
        return 0.0;
    }
    let units = &run.model.plan.problem.units;
    let found = applied(&run.model, run.state, drive);
    let sizes = controls.iter().filter(|control| control.is_of_support());
    let sizes = sizes.map(|control| (found.at(*control) / unit(units, control.axis)).abs());
    sizes.fold(0.0, f64::max)
}

/// The end of a search at an equilibrium that does not meet its pushes.
fn unmet(ending: Ending, cause: Cause, control: Option<Control>) -> Ending {
    Ending {
        termination: Termination::NotConverged,
        cause: Some(cause),
        site: control.map(named),
        ..ending
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

/// The numeric constants of this room.
pub(crate) fn constants() -> Vec<crate::constants::Constant> {
    [
        approach::own_constants(),
        by_difference::own_constants(),
        broyden::own_constants(),
        by_metric::own_constants(),
        own_constants(),
    ]
    .concat()
}
