//! Contact, pressure and displacement by a factor of the assembled saddle point:
//!
//! ```text
//! [ A - G  B^T  C^T ] [du]   [f]
//! [ B      -S       ] [dp] = [g]    on a face: rows of C that stick, l_i = 0 elsewhere
//! [ C               ] [dl]   [s]
//! ```
//!
//! Each face is solved to the end by a few Krylov iterations behind its factor; the next
//! one is where pressure outweighs gap (Hintermueller, Ito and Kunisch, SIAM J. Optim. 13,
//! 2002), and from the first face that returns on only its first wrong multiplier changes,
//! which ends (K. Murty, Linear Algebra Appl. 7, 1974). No contrast of moduli and no shape
//! of cells makes it fail, only size: entries of the factor grow as n^1.4 in space, and a
//! face costs one factor. Sets: lines and half lines.

mod body;
mod circulation;
mod face;
mod inertia;
mod rule;
mod step;
mod system;
mod turned;

use std::collections::HashSet;

use super::InequalitySolver;
use super::blocks::Blocks;
use super::qp::{QpIterate, QpOutcome, QpProblem, QpRun, QpStatus};
use crate::krylov::Outcome;
use crate::linalg::Workspace;
use crate::linalg::vector::{add_scaled, norm};
use crate::saddle::Status;
pub use body::BodyFactor;
pub use inertia::{Inertia, inertia};
use rule::Rule;
pub use step::FactorStep;
pub use system::Matrices;
use system::System;

/// Faces that any problem with a solution should come to an end with.
pub const MOST_FACES: u32 = 80;

/// The method on a problem.
pub struct Factorised<'a> {
    /// The quadratic program.
    pub problem: QpProblem<'a>,
    /// The same one, stored.
    pub matrices: Matrices<'a>,
    /// Faces at most.
    pub faces: u32,
}

impl InequalitySolver for Factorised<'_> {
    fn solve(&self, iterate: &mut QpIterate, run: &mut QpRun<'_, '_>) -> QpOutcome {
        let mut outcome = QpOutcome::new(QpStatus::Krylov(Outcome::IterationLimit));
        let solved = Blocks::of(&self.problem, iterate).and_then(|blocks| {
            let faces = Faces {
                problem: &self.problem,
                system: System::new(&self.matrices)?,
                rule: Rule::new(&blocks.contact, &self.matrices)?,
                is_loose: self.matrices.is_loose,
                may_be_indefinite: self.matrices.may_be_indefinite,
                most: self.faces,
                blocks,
            };
            faces.see_gap(iterate, run, &mut outcome);
            faces.solve(iterate, run, &mut outcome)
        });
        outcome.status = solved.unwrap_or_else(|status| status);
        outcome
    }
}

/// A problem on its way from face to face.
struct Faces<'c, 'a> {
    /// The problem with its operators.
    problem: &'c QpProblem<'a>,
    /// Its matrix with all constraints at work.
    system: System,
    /// How the next face follows.
    rule: Rule,
    /// Whether rigid modes are held by contact alone, so that a face may be singular.
    is_loose: bool,
    /// Whether a face may have motions that lower the energy.
    may_be_indefinite: bool,
    /// Faces at most.
    most: u32,
    /// Equalities and contact, told apart.
    blocks: Blocks<'a>,
}

/// Faces seen so far.
#[derive(Default)]
struct History {
    /// Statuses of those since multipliers change one by one, or of all.
    visited: HashSet<Vec<Status>>,
    /// Whether one has come back, from when on multipliers change one by one.
    has_returned: bool,
}

impl Faces<'_, '_> {
    /// Faces until one holds the solution; each starts from where the problem did, so
    /// that what a singular one brought leaves no rounding.
    ///
    /// # Errors
    /// Why the method cannot go on.
    fn solve(
        &self,
        iterate: &mut QpIterate,
        run: &mut QpRun<'_, '_>,
        outcome: &mut QpOutcome,
    ) -> Result<QpStatus, QpStatus> {
        let start = iterate.clone();
        let mut history = History::default();
        let mut face = self.first_face(&start, run)?;
        for _ in 0..self.most {
            history.enter(&face)?;
            iterate.clone_from(&start);
            self.move_to(iterate, face, run.work);
            let solved = self.solve_face(iterate, run)?;
            outcome.iterations += solved.iterations;
            let present = &self.blocks.contact_of(iterate).status;
            let next = match history.has_returned {
                true => self.rule.change_one(self.blocks.contact_of(iterate)),
                false => self.rule.next(self.blocks.contact_of(iterate)),
            };
            let level = run.targets.level;
            let contact = self.blocks.contact_of(iterate);
            let is_right =
                next == *present || self.rule.accepts(contact, level * run.scales.gap, level);
            if !is_right && solved.unstable > 0 && self.may_be_indefinite {
                return Err(QpStatus::ActiveSetCycle);
            }
            match (is_right, solved.failed) {
                (true, None) => return Ok(QpStatus::Solved),
                (true, Some(failed)) => return Err(failed),
                // Contact that is still to come may hold what nothing held here.
                (false, Some(failed)) if !self.is_loose => return Err(failed),
                (false, _) => outcome.set_changes += 1,
            }
            face = next;
        }
        Err(QpStatus::ActiveSetCycle)
    }

    /// Scale of the gap: what is wrong with it at the start, or would be under the load
    /// without contact. Cost: one application of the displacement preconditioner.
    fn see_gap(&self, iterate: &QpIterate, run: &mut QpRun<'_, '_>, outcome: &mut QpOutcome) {
        outcome.predictions += 1;
        let contact = self.blocks.contact_of(iterate);
        let wrong = norm(&self.blocks.contact.set.misfit(contact.point()));
        let mut moved = run.work.zeros(iterate.force.len());
        let displacement = self.problem.displacement;
        displacement.apply(&iterate.force, &mut moved, run.work);
        let mut gap = contact.residual.clone();
        let rows = self.blocks.contact.rows;
        rows.subtract_product(&moved, &mut gap, run.work);
        gap.iter_mut().for_each(|gap| *gap = gap.min(0.0));
        run.scales.see(0.0, norm(&gap).max(wrong));
        run.work.give(moved);
    }

    /// The face that the start asks for; where contact alone holds the body and none is
    /// there, the one that the load asks for in the shifted factor.
    ///
    /// # Errors
    /// Where the shifted matrix has no factor.
    fn first_face(
        &self,
        start: &QpIterate,
        run: &mut QpRun<'_, '_>,
    ) -> Result<Vec<Status>, QpStatus> {
        let contact = self.blocks.contact_of(start);
        let first = self.rule.next(contact);
        if !self.is_loose || first.contains(&Status::Stick) {
            return Ok(first);
        }
        let mut trial = start.clone();
        self.move_to(&mut trial, first, run.work);
        self.predict(&mut trial, run.work)?;
        Ok(self.rule.next(self.blocks.contact_of(&trial)))
    }

    /// Moves from the start to a face: multipliers that are open there become zero.
    fn move_to(&self, iterate: &mut QpIterate, face: Vec<Status>, work: &mut Workspace) {
        let contact = &mut iterate.blocks[self.blocks.place()];
        let mut dropped = work.zeros(face.len());
        for (index, &status) in face.iter().enumerate() {
            if status == Status::Open {
                dropped[index] = -std::mem::take(&mut contact.multiplier[index]);
            }
        }
        contact.status = face;
        if dropped.iter().any(|&value| value != 0.0) {
            let mut force = work.scratch(iterate.force.len());
            let columns = self.blocks.contact.columns;
            columns.apply_transposed(&dropped, &mut force, work);
            add_scaled(&mut iterate.force, -1.0, &force);
            work.give(force);
        }
        work.give(dropped);
    }
}

impl History {
    /// Notes a face.
    ///
    /// # Errors
    /// Where one comes back although multipliers change one by one: the problem has a motion
    /// that lowers its energy, and no face holds it.
    fn enter(&mut self, face: &[Status]) -> Result<(), QpStatus> {
        match (self.visited.insert(face.to_vec()), self.has_returned) {
            (true, _) => {}
            (false, true) => return Err(QpStatus::ActiveSetCycle),
            (false, false) => {
                self.visited = HashSet::from([face.to_vec()]);
                self.has_returned = true;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod body_tests;
#[cfg(test)]
mod tests;
