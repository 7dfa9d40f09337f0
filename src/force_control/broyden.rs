//! How a search for poses goes: whether a step `dz` led nearer to `f(z) = F`, and what of it
//! counts for the next.
//!
//! A step is taken back where it is not solved or where the misfit `f - F` grows; a step as
//! long as they may be that takes nothing off is a slide. Cost: nothing.

use super::COARSE;
use crate::linalg::vector::{add_scaled, dot, norm};
use crate::model::ending::Ending;
use crate::report::Termination;
use crate::sqp::push_stiffness::LONGEST;

constants! {
    /// Growth of the misfit after which a step is taken back.
    const WORSE: f64 = 1.5;
    /// Part of a step that led away which is tried next.
    const SHORTER: f64 = 0.25;
    /// Share of the misfit that a step has to take off.
    const PROGRESS: f64 = 0.1;
    /// Error of forces over the largest one and the accuracy of the solve.
    const NOISE: f64 = 10.0;
    /// Steps without a halved misfit after which its side is asked for: a ball dragged over a slab
    /// beyond what friction bears takes 593 applications by 8, 616 by 12.
    const MOST_STALLED: u32 = 8;
    /// Steps against the one before among them: a wave on a slab, met slowly, has none that count.
    const MOST_REVERSALS: u32 = 2;
    /// Rises of the misfit, one after the other, after which the largest force is passed; that of a
    /// cylinder that slides to where it is in balance goes up and down.
    const MOST_RISES: u32 = 6;
    /// Ratio of a rise: beyond the largest force a roller's misfit rises by 5 %, a ball's by 7 % a step.
    const RISE: f64 = 1.01;
    /// Mean of misfits, each over its norm, from which on they lie on one side.
    const ONE_SIDED: f64 = 0.5;
    /// Misfits over the tolerance that count where the search comes no nearer.
    const NEAR: f64 = 10.0;
}

/// How far a search has come.
pub(super) struct Progress {
    /// f - F `[controls]`.
    pub(super) misfit: Vec<f64>,
    /// Its largest entry over `scale`.
    pub(super) relative: f64,
    /// The largest force.
    pub(super) scale: f64,
    /// Accuracy of the solve.
    pub(super) tolerance: f64,
    /// The force that its equilibrium was measured by.
    pub(super) force_scale: f64,
}

impl Progress {
    /// Error of the forces.
    pub(super) fn noise(&self) -> f64 {
        NOISE * self.tolerance * self.scale
    }
}

/// Where a search is.
pub(super) struct BroydenIterate {
    /// The step that is tried next `[controls]`.
    pub(super) step: Vec<f64>,
    /// How far it was before.
    pub(super) before: Progress,
    /// Whether what follows is the doing of the step: other loads change forces, too.
    pub(super) tells: bool,
    /// What the step should change of the forces; infinite where nothing says so.
    pub(super) expected: f64,
    /// Steps that led away, one after the other.
    pub(super) failures: u32,
    /// Slides, one after the other.
    pub(super) slides: u32,
    /// Times that obstacles were led back to the body.
    pub(super) approaches: u32,
}

impl BroydenIterate {
    /// A search that tries `step`.
    pub(super) fn new(step: Vec<f64>, before: Progress, tells: bool) -> Self {
        Self {
            step,
            before,
            tells,
            expected: f64::INFINITY,
            failures: 0,
            slides: 0,
            approaches: 0,
        }
    }

    /// Whether the step has to be taken back.
    pub(super) fn leads_away(&self, ending: &Ending, after: &Progress) -> bool {
        let before = self.before.relative.max(self.before.tolerance);
        let is_worse = after.relative > WORSE * before.max(COARSE);
        ending.termination != Termination::Converged || (self.is_felt() && is_worse)
    }

    /// Whether forces say anything of the step, which should change them by more than the error of
    /// the solve before: a misfit below that is small by chance, and grows with a sharper solve.
    pub(super) fn is_felt(&self) -> bool {
        self.tells && self.expected > self.before.tolerance * self.before.scale
    }

    /// How forces have changed since `before` `[controls]`.
    pub(super) fn change(&self, after: &Progress) -> Vec<f64> {
        let ends = after.misfit.iter().zip(&self.before.misfit);
        ends.map(|(after, before)| after - before).collect()
    }

    /// Tries a part of the step.
    pub(super) fn shorten(&mut self) {
        self.failures += 1;
        self.step.iter_mut().for_each(|part| *part *= SHORTER);
    }

    /// Whether the pushes are met, by a solve to `tolerance`, to `floor`.
    pub(super) fn is_there(&self, after: &Progress, tolerance: f64, floor: f64) -> bool {
        let is_sharp = tolerance <= floor;
        let is_idle = after.relative > 0.5 * self.before.relative;
        let bound = if is_idle { NEAR * floor } else { floor };
        // Forces beside which the body's own are large are not known better than these.
        let is_rounding = after.relative * after.scale <= floor * after.force_scale;
        is_sharp && (after.relative <= bound || (is_rounding && after.relative <= COARSE))
    }

    /// Slides with the step, one after the other.
    pub(super) fn slides(&self, after: &Progress) -> u32 {
        let takes_off = after.relative < (1.0 - PROGRESS) * self.before.relative;
        if takes_off || norm(&self.step) < 0.5 * LONGEST {
            0
        } else {
            self.slides + 1
        }
    }
}

/// Misfits since the least one was last halved.
#[derive(Default)]
pub(super) struct Stall {
    /// The least misfit that counts, over the scale of forces; none at the start.
    least: Option<f64>,
    /// The last one, and how many before it were each less than the next.
    last: f64,
    rises: u32,
    /// Sum of the misfits since, each over its norm `[controls]`.
    sum: Vec<f64>,
    /// Their number.
    count: u32,
    /// The last step `[controls]`, and steps since that went against the one before them.
    step: Vec<f64>,
    reversals: u32,
}

impl Stall {
    /// Notes the misfit `after` a step that was not taken back.
    pub(super) fn note(&mut self, step: &[f64], after: &Progress) {
        let is_against = self.step.len() == step.len() && dot(&self.step, step) < 0.0;
        self.step = step.to_vec();
        // A misfit below the error of the solve is small by chance.
        let misfit = after.relative.max(after.tolerance);
        self.rises = if misfit > RISE * self.last {
            self.rises + 1
        } else {
            0
        };
        self.last = misfit;
        if self.least.is_none_or(|least| misfit <= 0.5 * least) {
            self.least = Some(misfit);
            self.sum = vec![0.0; after.misfit.len()];
            (self.count, self.reversals) = (0, 0);
        }
        let size = norm(&after.misfit).max(f64::MIN_POSITIVE);
        add_scaled(&mut self.sum, size.recip(), &after.misfit);
        self.count += 1;
        self.reversals += u32::from(is_against);
    }

    /// Whether the search has found the largest force along a way, which is less than the push:
    /// the same is missing after steps to and fro, or more and more of it after steps ahead.
    pub(super) fn is_beyond_the_largest(&self) -> bool {
        let is_one_sided = norm(&self.sum) >= ONE_SIDED * f64::from(self.count);
        let has_passed = self.reversals >= MOST_REVERSALS || self.rises >= MOST_RISES;
        self.count >= MOST_STALLED && has_passed && is_one_sided
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_force_that_falls_along_a_way_has_had_its_largest_value() {
        let mut ahead = Stall::default();
        for place in 0..MOST_STALLED {
            let part = 1.0 + 0.05 * f64::from(place);
            ahead.note(&[0.01], &progress(1e-3 * part));
        }
        assert!(ahead.is_beyond_the_largest());
    }

    #[test]
    fn what_is_missing_on_both_sides_of_a_way_is_beyond_the_largest_force() {
        let misfit = |way: f64| vec![-1e-4 - 0.1 * way * way, 0.3 * way];
        let [mut one, mut other, mut slow] = [(); 3].map(|()| Stall::default());
        for place in 0..MOST_STALLED {
            let way = if place % 2 == 0 { 0.01 } else { -0.01 };
            let at = |misfit: Vec<f64>| Progress {
                misfit,
                ..progress(1e-4)
            };
            one.note(&[way], &at(vec![-1e-4 - 0.1 * way * way, 0.3 * way * way]));
            other.note(&[way], &at(misfit(way)));
            slow.note(&[0.01], &at(vec![-1e-4, 0.0]));
        }
        assert!(one.is_beyond_the_largest());
        assert!(!other.is_beyond_the_largest());
        assert!(!slow.is_beyond_the_largest());
        one.note(&[0.01], &progress(1e-5));
        assert!(!one.is_beyond_the_largest());
    }

    #[test]
    fn a_step_below_the_error_of_the_solve_before_is_not_taken_back() {
        let converged = Ending::converged();
        let inexact = Progress {
            tolerance: 1e-3,
            ..progress(1e-8)
        };
        let grown = progress(2e-3);
        let mut iterate = BroydenIterate {
            expected: 1e-2,
            ..BroydenIterate::new(vec![1e-11], inexact, true)
        };
        assert!(iterate.leads_away(&converged, &grown));
        iterate.expected = 1e-8;
        assert!(!iterate.leads_away(&converged, &grown));
    }

    fn iterate(step: f64, relative: f64) -> BroydenIterate {
        BroydenIterate::new(vec![step], progress(relative), true)
    }

    fn progress(relative: f64) -> Progress {
        Progress {
            misfit: vec![relative],
            relative,
            scale: 1.0,
            tolerance: 1e-8,
            force_scale: 1.0,
        }
    }

    #[test]
    fn long_steps_that_take_nothing_off_are_slides() {
        assert_eq!(iterate(LONGEST, 0.5).slides(&progress(0.49)), 1);
        assert_eq!(iterate(LONGEST, 0.5).slides(&progress(0.4)), 0);
        assert_eq!(iterate(0.1 * LONGEST, 0.5).slides(&progress(0.5)), 0);
    }

    #[test]
    fn a_push_is_met_by_a_sharp_solve_only() {
        let floor = 1e-8;
        assert!(iterate(0.0, 1e-3).is_there(&progress(1e-9), floor, floor));
        assert!(!iterate(0.0, 1e-3).is_there(&progress(1e-9), 1e-3, floor));
        assert!(!iterate(0.0, 1e-3).is_there(&progress(5e-8), floor, floor));
        assert!(iterate(0.0, 6e-8).is_there(&progress(5e-8), floor, floor));
        let beside_others = Progress {
            force_scale: 100.0,
            ..progress(5e-7)
        };
        assert!(iterate(0.0, 1.0).is_there(&beside_others, floor, floor));
    }
}
