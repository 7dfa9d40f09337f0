//! Contact, pressure and displacement on one level: truncated GCR on a face of
//! the admissible set, the face chosen by the dense problem in the compliance
//! metric and reviewed whenever the residual has fallen tenfold.
//!
//! Solves for increments (du, dx) and the multiplier l >= 0:
//!
//! ```text
//! A du + B^T dx + C^T l = f,   B du - S dx = g,   gap - C du >= 0,   l (gap - C du) = 0
//! ```
//!
//! Costs about what the same problem costs without contact; a review costs one
//! small dense solve and no application of the displacement preconditioner.

mod face;
mod sets;

use std::collections::HashSet;

use super::InequalitySolver;
use super::qp::{Progress, QpIterate, QpOutcome, QpProblem, QpRun, QpScales, QpStatus, QpTargets};
use crate::krylov::{Outcome, gcr};
use crate::linalg::vector::{add_scaled, scale};
use crate::linalg::{LinearOperator, Workspace};
use crate::saddle::{MultiplierBlock, SaddleOperator};
use face::{ActiveCoupling, ActiveMetric, Face, FaceMonitor, Review};

/// Reduction of the face residual between reviews of the set.
const REVIEW: f64 = 0.1;
/// Weight of the gap residual beside the force residual in the norm that GCR
/// minimises, non-dimensional: the unknown is the multiplier over the weight.
/// Between 5 and 30 the counts stay within two of their least on all meshes; at
/// 1 contact costs 1.5 times the same problem under traction, above 60 it stalls.
const GAP_WEIGHT: f64 = 10.0;

/// How the next set follows from an iterate that the present one has led to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SetRule {
    /// The free set of the dense problem in the metric, asked for early.
    DenseProblem,
    /// Where pressure over the metric's diagonal outweighs the gap, asked for
    /// when the present face is solved.
    PrimalDual,
}

/// The method on a problem.
pub struct OneLevel<'a> {
    pub(super) problem: QpProblem<'a>,
    pub(super) rule: SetRule,
}

impl<'a> OneLevel<'a> {
    /// The method of this module on `problem`, in its metric.
    pub fn new(problem: QpProblem<'a>) -> Self {
        Self {
            problem,
            rule: SetRule::DenseProblem,
        }
    }
}

impl InequalitySolver for OneLevel<'_> {
    fn solve(&self, iterate: &mut QpIterate, run: &mut QpRun<'_, '_>) -> QpOutcome {
        let targets = &run.targets;
        let iterations = run.iterations;
        let scales = &mut *run.scales;
        let directions = &mut *run.directions;
        let progress = &mut *run.progress;
        let work = &mut *run.work;
        let mut outcome = QpOutcome::new(QpStatus::Krylov(Outcome::IterationLimit));
        if !self.choose_first_set(iterate, &mut outcome, work) {
            outcome.status = QpStatus::IndefiniteMetric;
            return outcome;
        }
        let mut visited = HashSet::from([iterate.active.clone()]);
        self.attach(directions, &iterate.active, work);
        let mut review = match (self.rule, iterate.gap.is_empty()) {
            (SetRule::DenseProblem, false) => Review::WhenReduced,
            (SetRule::DenseProblem, true) | (SetRule::PrimalDual, _) => Review::AtTheEnd,
        };
        while outcome.iterations < iterations {
            let active = iterate.active.clone();
            let Ok(metric) = ActiveMetric::new(self.problem.metric, &active) else {
                outcome.status = QpStatus::IndefiniteMetric;
                break;
            };
            let face = self.run_face(
                &metric,
                &active,
                iterate,
                targets,
                scales,
                review,
                iterations - outcome.iterations,
                directions,
                progress,
                work,
            );
            outcome.iterations += face.iterations;
            if let Some(status) = face.failed {
                outcome.status = status;
                break;
            }
            let Some(next) = self.next_set(iterate) else {
                outcome.status = QpStatus::IndefiniteMetric;
                break;
            };
            if next == iterate.active
                || (face.reached && self.acceptable(iterate, targets.level * scales.gap))
            {
                if face.reached {
                    outcome.status = QpStatus::Solved;
                    break;
                }
                continue;
            }
            outcome.set_changes += 1;
            if !visited.insert(next.clone()) {
                if matches!(review, Review::AtTheEnd) && face.reached {
                    outcome.status = QpStatus::ActiveSetCycle;
                    break;
                }
                review = Review::AtTheEnd;
            }
            self.detach(directions, work);
            if self.rule == SetRule::PrimalDual {
                // A set solved to the end leaves directions of rounding.
                directions.clear(work);
            }
            self.change_set(iterate, next, work);
            self.attach(directions, &iterate.active, work);
        }
        self.detach(directions, work);
        outcome
    }
}

impl OneLevel<'_> {
    /// Solves on the face of the iterate's own set, whatever the signs say; returns
    /// why it ended early.
    pub fn solve_on_face(
        &self,
        iterate: &mut QpIterate,
        run: &mut QpRun<'_, '_>,
    ) -> Option<QpStatus> {
        let active = iterate.active.clone();
        let Ok(metric) = ActiveMetric::new(self.problem.metric, &active) else {
            return Some(QpStatus::IndefiniteMetric);
        };
        let face = self.run_face(
            &metric,
            &active,
            iterate,
            &run.targets,
            run.scales,
            Review::AtTheEnd,
            run.iterations,
            run.directions,
            run.progress,
            run.work,
        );
        face.failed
    }

    /// Adds this program's coupling on the face `active` to the products of
    /// kept directions: what they learned about A and B stays of use.
    fn attach(&self, directions: &mut gcr::Directions, active: &[bool], work: &mut Workspace) {
        self.adapt(directions, 1.0, work, |multiplier, closing| {
            for ((l, g), &active) in multiplier.iter_mut().zip(closing).zip(active) {
                if !active {
                    (*l, *g) = (0.0, 0.0);
                }
            }
        });
    }

    /// Takes the coupling off again.
    fn detach(&self, directions: &mut gcr::Directions, work: &mut Workspace) {
        self.adapt(directions, -1.0, work, |_, closing| closing.fill(0.0));
    }

    fn adapt(
        &self,
        directions: &mut gcr::Directions,
        sign: f64,
        work: &mut Workspace,
        restrict: impl Fn(&mut [f64], &mut [f64]),
    ) {
        let unknowns = self.problem.stiffness.rows();
        let mut part = work.scratch(unknowns);
        let mut inner = Workspace::new();
        directions.adapt(work, |direction, product| {
            let multipliers = direction.len() - self.problem.coupling.rows();
            let (known, multiplier) = direction.split_at_mut(multipliers);
            let (force, closing) = product.split_at_mut(multipliers);
            let (force, u) = (&mut force[..unknowns], &known[..unknowns]);
            self.problem.coupling.apply(u, closing, &mut inner);
            scale(closing, GAP_WEIGHT);
            restrict(multiplier, closing);
            self.problem
                .coupling
                .apply_transposed(multiplier, &mut part, &mut inner);
            add_scaled(force, sign * GAP_WEIGHT, &part);
            if let Some(curvature) = self.problem.curvature {
                curvature.apply(u, &mut part, &mut inner);
                add_scaled(force, -sign, &part);
            }
        });
        work.give(part);
    }

    #[allow(clippy::too_many_arguments)]
    fn run_face(
        &self,
        metric: &ActiveMetric,
        active: &[bool],
        iterate: &mut QpIterate,
        targets: &QpTargets,
        scales: &mut QpScales,
        review: Review,
        iterations: u32,
        directions: &mut gcr::Directions,
        progress: &mut Progress<'_>,
        work: &mut Workspace,
    ) -> Face {
        let coupling = ActiveCoupling {
            coupling: self.problem.coupling,
            active,
        };
        let mut blocks = self.problem.equality.to_vec();
        if !active.is_empty() {
            blocks.push(MultiplierBlock {
                coupling: &coupling,
                stabilisation: None,
                metric,
                joint: None,
            });
        }
        let (mut x, mut r) = self.pack(iterate, active, work);
        let mut monitor = FaceMonitor {
            displacement: iterate.force.len(),
            equality: iterate.constraint.len(),
            targets: *targets,
            scales,
            review,
            start: 0.0,
            iterations: 0,
            reached: false,
            interrupted: false,
            active: active.iter().filter(|&&a| a).count(),
            progress,
        };
        monitor.start = monitor.measure(&r).1;
        let mut failed = None;
        if monitor.start <= targets.level {
            monitor.reached = true;
        } else {
            let outcome = gcr::solve(
                &SaddleOperator {
                    stiffness: self.problem.stiffness,
                    released: self
                        .problem
                        .curvature
                        .map(|curvature| curvature as &dyn LinearOperator),
                    blocks: &blocks,
                },
                &*self.problem.step.preconditioner(
                    self.problem.stiffness,
                    self.problem.displacement,
                    &blocks,
                ),
                &mut x,
                &mut r,
                iterations as usize,
                directions,
                &mut monitor,
                work,
            );
            failed = match monitor.interrupted {
                true => Some(QpStatus::Interrupted),
                false => QpStatus::failure(outcome),
            };
        }
        let face = Face {
            iterations: monitor.iterations,
            reached: monitor.reached,
            failed,
        };
        self.unpack(iterate, &x, &r, work);
        work.give(x);
        work.give(r);
        face
    }

    fn pack(
        &self,
        iterate: &QpIterate,
        active: &[bool],
        work: &mut Workspace,
    ) -> (Vec<f64>, Vec<f64>) {
        let length = iterate.force.len() + iterate.constraint.len() + active.len();
        let x = work.zeros(length);
        let mut r = work.zeros(length);
        let (force, rest) = r.split_at_mut(iterate.force.len());
        let (constraint, gap) = rest.split_at_mut(iterate.constraint.len());
        force.copy_from_slice(&iterate.force);
        constraint.copy_from_slice(&iterate.constraint);
        for (index, value) in gap.iter_mut().enumerate() {
            if active[index] {
                *value = GAP_WEIGHT * iterate.gap[index];
            }
        }
        (x, r)
    }

    fn unpack(&self, iterate: &mut QpIterate, x: &[f64], r: &[f64], work: &mut Workspace) {
        let (du, rest) = x.split_at(iterate.force.len());
        let (dx, dl) = rest.split_at(iterate.constraint.len());
        add_scaled(&mut iterate.displacement, 1.0, du);
        add_scaled(&mut iterate.equality, 1.0, dx);
        add_scaled(&mut iterate.multiplier, GAP_WEIGHT, dl);
        let (force, rest) = r.split_at(iterate.force.len());
        iterate.force.copy_from_slice(force);
        iterate.constraint.copy_from_slice(&rest[..dx.len()]);
        if !iterate.gap.is_empty() {
            let mut closing = work.scratch(iterate.gap.len());
            self.problem.coupling.apply(du, &mut closing, work);
            add_scaled(&mut iterate.gap, -1.0, &closing);
            work.give(closing);
        }
    }
}

#[cfg(test)]
mod tests;
