//! The stiffness under pushed supports, by differences of equilibria,
//!
//! ```text
//! J_ij = (f_i(z + h e_j) - f_i(z)) / h
//! ```
//!
//! about the state, whose drive it is in equilibrium with; the metric of contact knows nothing of the
//! body between two supports. h goes the way that the push wants. Cost: a solve a component, most of
//! them of two or three programs; Broyden's rule keeps the stiffness from there on, over increments.

use super::unit;
use crate::model::drive::Drive;
use crate::model::push::{Applied, Control};
use crate::report::Termination;
use crate::results::exerted::applied;
use crate::sqp::accuracy;
use crate::sqp::push_stiffness::PushStiffness;
use crate::sqp::run::Run;

constants! {
    /// Motion of the difference, over the body's length and in radians; chosen, no scene measures
    /// it. A fifth of the thickness of a layer of .005.
    pub(super) const MOTION: f64 = 1e-3;
    /// Accuracy of its solves, relative residual: a thousandth of the motion; chosen.
    const SHARP: f64 = 1e-6;
    /// Stiffness, over the body's length and shear modulus, that solves as accurate show of a body
    /// which moves freely; chosen. A softer spring counts as none.
    const ROUNDING: f64 = 1e-6;
    /// Stiffness, in the same unit, in the place of that which no solve shows; chosen, no test needs
    /// it.
    const UNKNOWN: f64 = 1.0;
}

/// J at the state for `controls`, which miss the goals of `drive` by `misfit` `[controls]`.
pub(super) fn by_difference(
    run: &mut Run<'_>,
    drive: &Drive,
    controls: &[Control],
    misfit: &[f64],
) -> PushStiffness {
    // About the points that the forces belong to, as exactly as the differences want it.
    let base = run.state.drive.about_like(drive);
    let sharp = run.model.conditions.tolerance.max(SHARP);
    accuracy::solve(&mut run.to(sharp), &base);
    let kept = run.state.clone();
    let before = applied(&run.model, run.state, drive);
    let mut columns = Vec::new();
    for (place, control) in controls.iter().enumerate() {
        let motion = if misfit[place] > 0.0 { -MOTION } else { MOTION };
        let column = moved(run, drive, *control, motion).map_or_else(
            || unknown(controls.len(), place),
            |after| differences(run, controls, [&before, &after], motion),
        );
        columns.push(column);
        run.state.clone_from(&kept);
    }
    PushStiffness {
        controls: controls.to_vec(),
        columns,
    }
}

/// What is exerted after a motion of one component; none where no equilibrium was found there.
fn moved(run: &mut Run<'_>, drive: &Drive, control: Control, motion: f64) -> Option<Applied> {
    let length = run.model.plan.problem.units.length;
    let mut goal = run.state.drive.clone();
    *goal.component(control) += motion * if control.axis < 3 { length } else { 1.0 };
    let sharp = run.model.conditions.tolerance.max(SHARP);
    let ending = accuracy::solve(&mut run.to(sharp), &goal);
    let is_solved = ending.termination == Termination::Converged;
    is_solved.then(|| applied(&run.model, run.state, drive))
}

/// One column of J.
fn differences(
    run: &Run<'_>,
    controls: &[Control],
    [before, after]: [&Applied; 2],
    motion: f64,
) -> Vec<f64> {
    let units = &run.model.plan.problem.units;
    let change = |control: &Control| {
        let change = after.at(*control) - before.at(*control);
        let stiffness = change / (motion * unit(units, control.axis));
        if stiffness.abs() < ROUNDING {
            0.0
        } else {
            stiffness
        }
    };
    controls.iter().map(change).collect()
}

/// A column that says nothing of other components.
fn unknown(size: usize, place: usize) -> Vec<f64> {
    let mut column = vec![0.0; size];
    column[place] = UNKNOWN;
    column
}
