//! Contact, pressure and displacement on one level: truncated GCR on a face of
//! the admissible set, the face chosen by the dense problem in the compliance
//! metric and reviewed whenever the residual has fallen tenfold.
//!
//! Solves for increments (du, dx) and the multiplier l in its set; of contact
//! l >= 0, and then
//!
//! ```text
//! A du + B^T dx + C^T l = f,   B du - S dx = g,   gap - C du >= 0,   l (gap - C du) = 0
//! ```
//!
//! A face is what each multiplier does: those that stick are unknowns, their
//! residuals zero; the others keep the value that the dense problem gives them.
//! Costs about what the same problem costs without contact; a review costs one
//! small dense solve and no application of the displacement preconditioner.

pub(crate) mod augmented;
mod face;
mod face_metric;
mod history;
mod kept;
mod monitor;
mod sets;
mod shared;
mod slides;
mod weights;

pub(crate) use sets::slides_of;

use std::collections::HashSet;
use std::ops::ControlFlow;

use super::InequalitySolver;
use super::blocks::{Blocks, ContactBlock};
use super::dense_cone::{self, DenseSolution};
use super::metric::nearest;
use super::qp::{BlockIterate, QpIterate, QpOutcome, QpProblem, QpRun, QpScales, QpStatus};
use crate::krylov::Outcome;
use crate::linalg::vector::largest;
use face_metric::LastFactor;
use history::{By, Friction, History};
use monitor::Review;

/// Reduction of the face residual between reviews of the set.
const REVIEW: f64 = 0.1;
/// Weight of the gap residual beside the force residual in the norm that GCR
/// minimises, non-dimensional: the unknown is the multiplier over the weight. Where the
/// body is stiffer than elsewhere gaps weigh as many times more: the same gap is that much
/// force there.
/// Between 5 and 30 the counts stay within two of their least on all meshes; at
/// 1 contact costs 1.5 times the same problem under traction, above 60 it stalls.
const GAP_WEIGHT: f64 = 10.0;

/// Share of what is closed that may change sides by the residuals at first: where more does
/// they are far from those of the face, and the dense problem in the metric is asked.
const NEAR: f64 = 0.1;
/// How the next face follows from an iterate that the present one has led to.
pub trait FaceRule {
    /// The next face, with the values of the multipliers that are no unknowns on it.
    ///
    /// # Errors
    /// Where the metric is not positive definite or the set has no such faces.
    fn next(
        &self,
        block: &ContactBlock<'_>,
        contact: &BlockIterate,
    ) -> Result<DenseSolution, QpStatus>;

    /// Whether the present face is solved to the end before the next one is asked for;
    /// else it is as soon as the residual is reduced.
    fn solves_to_the_end(&self) -> bool;
}

/// The face of the dense problem in the metric, asked for early.
struct DenseProblem;

impl FaceRule for DenseProblem {
    fn next(
        &self,
        block: &ContactBlock<'_>,
        contact: &BlockIterate,
    ) -> Result<DenseSolution, QpStatus> {
        nearest(block.matrix, block.set, contact)
    }

    fn solves_to_the_end(&self) -> bool {
        false
    }
}

/// The method on a problem.
pub struct OneLevel<'a> {
    /// The quadratic program; its contact block has a dense metric.
    pub problem: QpProblem<'a>,
    /// The rule by which the next face follows from an iterate.
    pub rule: &'static dyn FaceRule,
}

impl<'a> OneLevel<'a> {
    /// The method of this module on `problem`, in its metric.
    pub fn new(problem: QpProblem<'a>) -> Self {
        Self {
            problem,
            rule: &DenseProblem,
        }
    }

    /// Solves on the face of the iterate's own set, whatever the signs say; returns
    /// why it ended early.
    pub fn solve_on_face(
        &self,
        iterate: &mut QpIterate,
        run: &mut QpRun<'_, '_>,
    ) -> Option<QpStatus> {
        let blocks = match Blocks::of(&self.problem, iterate) {
            Ok(blocks) => blocks,
            Err(status) => return Some(status),
        };
        let faces = Faces {
            problem: &self.problem,
            rule: self.rule,
            largest: largest_scales(&blocks, run),
            blocks,
            last: LastFactor::default(),
        };
        let iterations = run.iterations;
        let face = faces.run_face(iterate, run, (Review::AtTheEnd, REVIEW), iterations);
        face.map_or_else(Some, |face| face.failed)
    }
}

impl InequalitySolver for OneLevel<'_> {
    fn solve(&self, iterate: &mut QpIterate, run: &mut QpRun<'_, '_>) -> QpOutcome {
        let mut outcome = QpOutcome::new(QpStatus::Krylov(Outcome::IterationLimit));
        let solved = Blocks::of(&self.problem, iterate).and_then(|blocks| {
            let faces = Faces {
                problem: &self.problem,
                rule: self.rule,
                largest: largest_scales(&blocks, run),
                blocks,
                last: LastFactor::default(),
            };
            faces.solve(iterate, run, &mut outcome)
        });
        outcome.status = solved.unwrap_or_else(|status| status);
        outcome
    }
}

/// How far the scales may grow: faces with friction are not symmetric and may diverge; on all
/// others a norm grows only towards what the load makes of it, from rounding even.
fn largest_scales(blocks: &Blocks<'_>, run: &QpRun<'_, '_>) -> QpScales {
    match dense_cone::cones(&blocks.contact.set) {
        Some(_) => run.scales.largest_to_come(),
        None => QpScales {
            constraint: f64::INFINITY,
            gap: f64::INFINITY,
        },
    }
}

/// A problem on its way from face to face.
struct Faces<'c, 'a> {
    /// The whole problem with all its blocks.
    problem: &'c QpProblem<'a>,
    /// The rule by which the next face follows from an iterate.
    rule: &'static dyn FaceRule,
    /// How far the scales may grow on all faces.
    largest: QpScales,
    /// Equalities and contact of the problem, told apart.
    blocks: Blocks<'a>,
    /// The factor of the last face where points slip.
    last: LastFactor,
}

impl Faces<'_, '_> {
    /// Faces until one holds the solution.
    ///
    /// # Errors
    /// Where there is no first face.
    fn solve(
        &self,
        iterate: &mut QpIterate,
        run: &mut QpRun<'_, '_>,
        outcome: &mut QpOutcome,
    ) -> Result<QpStatus, QpStatus> {
        self.choose_first_face(iterate, outcome, run.work)?;
        let first = self.blocks.contact_of(iterate);
        let mut history = History {
            visited: HashSet::from([first.status.clone()]),
            idle: 0,
            review: if first.status.is_empty() || self.rule.solves_to_the_end() {
                Review::AtTheEnd
            } else {
                Review::WhenReduced
            },
            one_by_one: false,
            reduction: REVIEW,
            friction: self.is_frictional().then(Friction::new),
        };
        // Kept directions carry the products of the body alone; those of contact on this
        // face are put on, and taken off after the last face.
        self.attach(run, first);
        let mut status = outcome.status;
        while outcome.iterations < run.iterations {
            if let ControlFlow::Break(end) = self.turn(iterate, run, outcome, &mut history) {
                status = end;
                break;
            }
        }
        self.detach(run, self.blocks.contact_of(iterate));
        Ok(status)
    }

    /// Works on the present face, reviews it and moves to the next.
    fn turn(
        &self,
        iterate: &mut QpIterate,
        run: &mut QpRun<'_, '_>,
        outcome: &mut QpOutcome,
        history: &mut History,
    ) -> ControlFlow<QpStatus> {
        let left = run.iterations - outcome.iterations;
        let level = run.targets.level;
        run.targets.level *= history.sharpness();
        let face = self.run_face(iterate, run, (history.review, history.reduction), left);
        run.targets.level = level;
        let face = match face {
            Ok(face) => face,
            Err(status) => return ControlFlow::Break(status),
        };
        outcome.iterations += face.iterations;
        history.rest(face.iterations)?;
        if let Some(status) = face.failed {
            return ControlFlow::Break(status);
        }
        // Solved, or reduced enough for a look at the signs: the dense problem in the
        // metric says which face the solution lies on.
        let bound = run.targets.level * run.scales.gap;
        let next = self.following(iterate, history, bound);
        if let Ok(Some(next)) = &next {
            outcome.newton_steps += next.steps;
        }
        let next = match next {
            Ok(next) => next.filter(|next| !self.is_present(iterate, next)),
            Err(status) => return ControlFlow::Break(status),
        };
        // The same face again: it is solved to its end, or is already the solution.
        let is_end = face.reached && self.is_acceptable(iterate, bound, run.targets.level);
        let Some(next) = next.filter(|_| !is_end) else {
            let level = run
                .targets
                .level_for(largest(&self.blocks.contact_of(iterate).multiplier));
            let is_sharp = level >= run.targets.level;
            run.targets.level = level;
            let goes_on = !face.reached || !is_sharp || (!is_end && history.sharpens());
            return if goes_on {
                ControlFlow::Continue(())
            } else {
                ControlFlow::Break(QpStatus::Solved)
            };
        };
        if next.status != self.blocks.contact_of(iterate).status {
            outcome.set_changes += 1;
            history.enter(&next, &face)?;
        } else {
            history.turn();
        }
        self.move_to(iterate, next, run);
        ControlFlow::Continue(())
    }

    /// The next face: of the dense problem, or the neighbour where such faces have come
    /// back; none where the present one stays.
    fn following(
        &self,
        iterate: &QpIterate,
        history: &mut History,
        bound: f64,
    ) -> Result<Option<DenseSolution>, QpStatus> {
        if let Some(friction) = &mut history.friction {
            return self.frictional_face(iterate, friction);
        }
        let count = self.blocks.contact_of(iterate).status.len();
        let neighbour = if history.one_by_one {
            self.neighbour(iterate, bound / (count as f64).sqrt())
        } else {
            None
        };
        match neighbour {
            Some(next) => Ok(Some(next)),
            None => self.next_face(iterate).map(Some),
        }
    }

    /// The next face with friction, by the rule that brings the iterate nearer to the law.
    fn frictional_face(
        &self,
        iterate: &QpIterate,
        friction: &mut Friction,
    ) -> Result<Option<DenseSolution>, QpStatus> {
        let present = &self.blocks.contact_of(iterate).status;
        let by_residuals = self.newton_face(iterate);
        let is_near = by_residuals
            .as_ref()
            .is_some_and(|next| self.is_near(iterate, next));
        match friction.rule(self.wrong(iterate), is_near) {
            By::Residuals => Ok(by_residuals),
            By::Metric => {
                let next = self.next_face(iterate)?;
                // Where the metric leaves all sides the residuals are not yet those of the face.
                Ok((next.status != *present).then_some(next))
            }
        }
    }

    /// Whether few points change sides on the way to `next`.
    fn is_near(&self, iterate: &QpIterate, next: &DenseSolution) -> bool {
        let contact = self.blocks.contact_of(iterate);
        let sides = contact.status.iter().zip(&next.status);
        let changed = sides.filter(|(now, next)| now != next).count();
        changed as f64 <= NEAR * contact.closed() as f64
    }

    /// Moves to the next face, the kept directions with it.
    fn move_to(&self, iterate: &mut QpIterate, next: DenseSolution, run: &mut QpRun<'_, '_>) {
        let last = self.blocks.contact_of(iterate).clone();
        if self.rule.solves_to_the_end() {
            // A set solved to the end leaves directions of rounding.
            run.directions.clear(run.work);
        }
        self.change_face(iterate, next, run.work);
        self.exchange(run, (&last, self.blocks.contact_of(iterate)));
    }
}

#[cfg(test)]
mod tests;
