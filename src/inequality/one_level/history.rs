//! Faces seen on the way to the one that holds the solution: when the present one is reviewed,
//! what a return means, and by which rule faces with friction follow each other.

use std::collections::HashSet;
use std::ops::ControlFlow;

use super::super::dense_cone::DenseSolution;
use super::super::qp::QpStatus;
use super::REVIEW;
use super::face::Face;
use super::monitor::Review;
use crate::saddle::Status;

/// Faces in a row that may be solved already; some are usual where tractions turn.
const MOST_IDLE: u32 = 200;

/// Changes of sides with friction after which faces are solved to their end; more of those
/// that are not lead about without end, where many points carry little.
const STRAY: u32 = 8;
/// Changes of sides at first that follow from the metric where the residuals would change many:
/// with eight a belt on a drum, whose points carry little, does not come to an end.
const EARLY: u32 = 3;
/// Reduction of the face residual between reviews where points only turn.
const TURNING: f64 = 0.01;
/// Share of what is wrong that a face with friction is to leave; where it leaves more the next
/// one follows by the other rule.
const WORTHWHILE: f64 = 0.5;
/// Faces with friction that come back, solved to their end, after which it is a cycle.
const MOST_RETURNS: u32 = 3;
/// Share of the targets to which faces are solved after those: what a solve leaves turns and
/// opens points that carry no more.
const SHARP: f64 = 0.03;
/// Least such share where a face is solved further because its sides are right.
const LEAST_SHARE: f64 = 1e-4;

/// What the next face with friction follows from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum By {
    /// The true residuals, by the sides of Newton's method.
    Residuals,
    /// The dense problem in the metric.
    Metric,
}

/// Faces seen, and when the present one is reviewed.
pub(super) struct History {
    /// Statuses of all faces so far, by which a cycle is seen.
    pub(super) visited: HashSet<Vec<Status>>,
    /// When the present face is reviewed; at the end once a face has come back.
    pub(super) review: Review,
    /// Reduction of the face residual until the next review.
    pub(super) reduction: f64,
    /// Faces one after the other that took no iteration.
    pub(super) idle: u32,
    /// Whether one multiplier changes sides at a time, since blocks of them have cycled.
    pub(super) one_by_one: bool,
    /// How faces with friction follow each other; none without.
    pub(super) friction: Option<Friction>,
}

/// How faces with friction follow each other.
pub(super) struct Friction {
    /// The rule of the next one; none before the first.
    pub(super) by: Option<By>,
    /// What was wrong with the last one.
    pub(super) wrong: f64,
    /// Changes of sides so far.
    pub(super) changes: u32,
    /// Faces solved to their end that have come back.
    pub(super) returns: u32,
    /// Share of the targets to which faces are solved.
    pub(super) share: f64,
}

impl History {
    /// Share of the targets to which the face is solved.
    pub(super) fn sharpness(&self) -> f64 {
        self.friction
            .as_ref()
            .map_or(1.0, |friction| friction.share)
    }

    /// Whether a face with friction that is solved, its sides right by the rule that chose it,
    /// is to be solved further; as far as that goes.
    pub(super) fn sharpens(&mut self) -> bool {
        self.friction.as_mut().is_some_and(|friction| {
            friction.share *= REVIEW;
            friction.share > LEAST_SHARE
        })
    }

    /// Notes the iterations of a face; ends where tractions turn on and on.
    pub(super) fn rest(&mut self, iterations: u32) -> ControlFlow<QpStatus> {
        self.idle = if iterations > 0 { 0 } else { self.idle + 1 };
        if self.idle > MOST_IDLE {
            ControlFlow::Break(QpStatus::ActiveSetCycle)
        } else {
            ControlFlow::Continue(())
        }
    }

    /// Notes that the next face has the sides of the present one: where points only turn,
    /// faces are steps of Newton's method on smooth equations, worth more digits each.
    pub(super) fn turn(&mut self) {
        if self.friction.is_some() {
            self.reduction = TURNING;
        }
    }

    /// Notes the next face; one that returns is solved to the end, once that was done
    /// already faces change by one multiplier at a time, and one that returns still
    /// ends the solve.
    pub(super) fn enter(&mut self, next: &DenseSolution, face: &Face) -> ControlFlow<QpStatus> {
        self.reduction = REVIEW;
        if self.friction.as_mut().is_some_and(Friction::strays) {
            self.review = Review::AtTheEnd;
        }
        if !self.visited.insert(next.status.clone()) {
            if let Some(friction) = &mut self.friction {
                self.visited.clear();
                if self.review == Review::AtTheEnd {
                    friction.returns += 1;
                }
                self.review = Review::AtTheEnd;
                return if friction.returns > MOST_RETURNS {
                    ControlFlow::Break(QpStatus::ActiveSetCycle)
                } else {
                    ControlFlow::Continue(())
                };
            }
            if self.review == Review::AtTheEnd && face.reached {
                if self.one_by_one || !next.is_of_contact() {
                    return ControlFlow::Break(QpStatus::ActiveSetCycle);
                }
                self.one_by_one = true;
                self.visited.clear();
            }
            self.review = Review::AtTheEnd;
        }
        ControlFlow::Continue(())
    }
}

impl Friction {
    /// Before the first face.
    pub(super) fn new() -> Self {
        Self {
            by: None,
            wrong: f64::INFINITY,
            changes: 0,
            returns: 0,
            share: 1.0,
        }
    }

    /// The rule by which the next face follows from an iterate of which `wrong` speaks against
    /// the present one; `is_near` says whether residuals change little.
    pub(super) fn rule(&mut self, wrong: f64, is_near: bool) -> By {
        let by = match (self.by, wrong <= WORTHWHILE * self.wrong) {
            // At first the residuals of many points are not yet those of their faces.
            _ if !is_near && self.changes < EARLY => By::Metric,
            (Some(by), true) => by,
            (Some(By::Residuals), false) => By::Metric,
            _ => By::Residuals,
        };
        self.by = Some(by);
        self.wrong = wrong;
        by
    }

    /// Counts a change of sides; whether they are so many that faces are to be solved to
    /// their end.
    pub(super) fn strays(&mut self) -> bool {
        self.changes += 1;
        if self.changes == STRAY {
            self.share = self.share.min(SHARP);
        }
        self.changes >= STRAY
    }
}
