//! Faces: the first one, the one that an iterate asks for next, and the move from
//! one to another.
//!
//! A choice costs one small dense problem, the first one of a body that nothing
//! touches an application of the displacement preconditioner besides.

use super::super::dense_cone::{self, DenseSolution};
use super::super::qp::{BlockIterate, QpIterate, QpOutcome, QpStatus, Slide};
use super::Faces;
use crate::linalg::Workspace;
use crate::linalg::vector::{add_scaled, largest, norm};
use crate::saddle::{Cones, ProductSet, Status};

/// Change of a traction, over the largest multiplier, that is rounding.
const TURNED: f64 = 1e-12;

impl Faces<'_, '_> {
    /// Moves to the face that the gaps ask for or, where they ask for none, that
    /// the load does: a body that only contact holds has no solution without.
    ///
    /// # Errors
    /// Where the metric is not positive definite or the set has no such faces.
    pub(super) fn choose_first_face(
        &self,
        iterate: &mut QpIterate,
        outcome: &mut QpOutcome,
        work: &mut Workspace,
    ) -> Result<(), QpStatus> {
        let first = self.next_face(iterate)?;
        outcome.newton_steps += first.steps;
        self.change_face(iterate, first, work);
        let contact = self.blocks.contact_of(iterate);
        if contact.residual.is_empty() || contact.closed() > 0 {
            return Ok(());
        }
        outcome.predictions += 1;
        let linear = self.gap_under_load(iterate, work);
        let block = &self.blocks.contact;
        let near = (&contact.status[..], &contact.multiplier[..]);
        let solution = dense_cone::solve(block.matrix, &linear, block.set, near);
        let by_residuals = self.newton_face(iterate);
        let next = solution.ok().or(by_residuals);
        let next = next.ok_or(QpStatus::IndefiniteMetric)?;
        outcome.newton_steps += next.steps;
        self.change_face(iterate, next, work);
        Ok(())
    }

    /// The gap that the load would leave without contact, about.
    fn gap_under_load(&self, iterate: &QpIterate, work: &mut Workspace) -> Vec<f64> {
        let contact = self.blocks.contact_of(iterate);
        let mut move_by_load = work.zeros(iterate.force.len());
        let mut closing = work.zeros(contact.residual.len());
        self.problem
            .displacement
            .apply(&iterate.force, &mut move_by_load, work);
        let rows = self.blocks.contact.rows;
        rows.apply(&move_by_load, &mut closing, work);
        let mut linear = contact.residual.clone();
        add_scaled(&mut linear, -1.0, &closing);
        work.give(move_by_load);
        work.give(closing);
        linear
    }

    /// The face that the rule asks for at the current iterate, with the values of
    /// the multipliers that are no unknowns on it.
    ///
    /// # Errors
    /// Where the metric is not positive definite or the set has no such faces.
    pub(super) fn next_face(&self, iterate: &QpIterate) -> Result<DenseSolution, QpStatus> {
        let (block, contact) = (&self.blocks.contact, self.blocks.contact_of(iterate));
        if contact.residual.is_empty() {
            return Ok(DenseSolution::default());
        }
        let next = self.rule.next(block, contact);
        match self.newton_face(iterate) {
            // The metric's own problem may have no solution where the true one has.
            Some(by_residuals) if next.is_err() => Ok(by_residuals),
            _ => next,
        }
    }

    /// The face beside the present one, solved to its end, on which the last multiplier
    /// that is wrong changes sides; none where none is wrong by more than `bound` says.
    /// One index alone, always the last one, cannot cycle where the Schur complement is
    /// positive definite (Murty 1974).
    pub(super) fn neighbour(&self, iterate: &QpIterate, bound: f64) -> Option<DenseSolution> {
        let (block, contact) = (&self.blocks.contact, self.blocks.contact_of(iterate));
        let violation = block.set.violation(&contact.multiplier);
        let misfit = block.set.misfit(contact.point());
        let is_wrong = |&index: &usize| match contact.status[index] {
            Status::Stick => violation[index].abs() * block.matrix.entry(index, index) > bound,
            Status::Open | Status::Slip => misfit[index].abs() > bound,
        };
        let last = (0..contact.status.len()).rev().find(is_wrong)?;
        let mut next = DenseSolution {
            values: contact.multiplier.clone(),
            status: contact.status.clone(),
            ..DenseSolution::default()
        };
        next.status[last] = match contact.status[last] {
            Status::Stick => Status::Open,
            Status::Open | Status::Slip => Status::Stick,
        };
        if next.status[last] == Status::Open {
            next.values[last] = 0.0;
        }
        Some(next)
    }

    /// Whether thresholds of friction follow from pressures.
    pub(super) fn is_frictional(&self) -> bool {
        dense_cone::cones(&self.blocks.contact.set).is_some()
    }

    /// The face that the residuals at the iterate ask for by Newton's method; none without
    /// friction.
    pub(super) fn newton_face(&self, iterate: &QpIterate) -> Option<DenseSolution> {
        let (block, contact) = (&self.blocks.contact, self.blocks.contact_of(iterate));
        let cones = dense_cone::cones(&block.set)?;
        let at = (&contact.multiplier[..], &contact.residual[..]);
        Some(dense_cone::newton_face(block.matrix, block.set, cones, at))
    }

    /// Whether `next` is where the iterate is already. Tractions that slip are, where they
    /// are tied to their pressures in the same direction; those on discs of given radii are to
    /// follow the dense problem each time.
    pub(super) fn is_present(&self, iterate: &QpIterate, next: &DenseSolution) -> bool {
        let contact = self.blocks.contact_of(iterate);
        if next.status != contact.status {
            return false;
        }
        let Some(cones) = dense_cone::cones(&self.blocks.contact.set) else {
            return !next.status.contains(&Status::Slip);
        };
        let mut next = next.clone();
        slipping(cones, &mut next, contact);
        let tractions = next.values.iter().zip(&contact.multiplier);
        let mut slipping = tractions.zip(&next.status);
        let size = largest(&contact.multiplier);
        slipping.all(|((a, b), &status)| status != Status::Slip || (a - b).abs() <= TURNED * size)
    }

    /// Moves to another face: multipliers that are no unknowns there take its values,
    /// which of open ones are zero. Tractions that slip take its directions, and the size
    /// that their pressures allow.
    pub(super) fn change_face(
        &self,
        iterate: &mut QpIterate,
        mut next: DenseSolution,
        work: &mut Workspace,
    ) {
        let contact = &mut iterate.blocks[self.blocks.place()];
        let mut dropped = work.zeros(next.status.len());
        let (slides, begins) = match dense_cone::cones(&self.blocks.contact.set) {
            Some(cones) => slipping(cones, &mut next, contact),
            None => (Vec::new(), Vec::new()),
        };
        for (index, &status) in next.status.iter().enumerate() {
            if status != Status::Stick || begins.get(index) == Some(&true) {
                let value = next.values[index];
                dropped[index] = std::mem::replace(&mut contact.multiplier[index], value) - value;
            }
        }
        if dropped.iter().any(|&value| value != 0.0) {
            let mut force = work.scratch(iterate.force.len());
            let columns = self.blocks.contact.columns;
            columns.apply_transposed(&dropped, &mut force, work);
            add_scaled(&mut iterate.force, 1.0, &force);
            work.give(force);
        }
        work.give(dropped);
        (contact.status, contact.slides) = (next.status, slides);
    }

    /// Whether what speaks against the current face is below the targets: gaps below
    /// `bound`, multipliers outside of their sets below `share` of all.
    pub(super) fn is_acceptable(&self, iterate: &QpIterate, bound: f64, share: f64) -> bool {
        let (block, contact) = (&self.blocks.contact, self.blocks.contact_of(iterate));
        let outside = norm(&block.set.violation(&contact.multiplier));
        self.wrong(iterate) <= bound && outside <= share * norm(&contact.multiplier)
    }

    /// What speaks against the current face: norm of gaps, and of multipliers outside of their
    /// sets as gaps.
    pub(super) fn wrong(&self, iterate: &QpIterate) -> f64 {
        let (block, contact) = (&self.blocks.contact, self.blocks.contact_of(iterate));
        let violation = block.set.violation(&contact.multiplier);
        let misfit = block.set.misfit(contact.point());
        let mut square = 0.0;
        for (index, &status) in contact.status.iter().enumerate() {
            let wrong = match status {
                Status::Stick => violation[index] * block.matrix.entry(index, index),
                Status::Open => misfit[index],
                Status::Slip if violation[index] == 0.0 => misfit[index],
                Status::Slip => {
                    misfit[index].hypot(violation[index] * block.matrix.entry(index, index))
                }
            };
            square += wrong * wrong;
        }
        square.sqrt()
    }
}

/// The points of `contact` that slip on the face of `solution`, whose tractions go to their discs.
pub(crate) fn slides_of(
    set: &ProductSet<'_>,
    solution: &mut DenseSolution,
    contact: &BlockIterate,
) -> Vec<Slide> {
    match dense_cone::cones(set) {
        Some(cones) => slipping(cones, solution, contact).0,
        None => Vec::new(),
    }
}

/// What friction makes of the next face: tractions that slip take the directions of `next`
/// and the size that their pressures allow; returns their points, and which pressures begin
/// and take the values of `next`.
fn slipping(
    (cones, first): (Cones<'_>, usize),
    next: &mut DenseSolution,
    contact: &BlockIterate,
) -> (Vec<Slide>, Vec<bool>) {
    let width = cones.components.count();
    let mut begins = vec![false; next.status.len()];
    for index in first..first + cones.normals {
        begins[index] = contact.multiplier[index] <= 0.0;
    }
    let mut slides = Vec::new();
    for (partner, bound, place) in cones.points() {
        let (partner, place) = (first + partner, first + place);
        if next.status[place] != Status::Slip {
            continue;
        }
        let [now, then] = [&contact.multiplier, &next.values].map(|x| bound.is_between(x[partner]));
        begins[partner] |= now != then;
        let pressure = if begins[partner] {
            next.values[partner]
        } else {
            contact.multiplier[partner]
        };
        let own = place..place + width;
        let (size, slip) = (
            norm(&next.values[own.clone()]),
            norm(&next.slip[own.clone()]),
        );
        let radius = bound.radius(pressure);
        let mut direction = [0.0; 2];
        for (direction, value) in direction.iter_mut().zip(&mut next.values[own]) {
            *direction = *value / size;
            *value = radius * *direction;
        }
        slides.push(Slide {
            leader: partner as u32,
            first: place as u32,
            width: width as u8,
            along: direction.map(|e| bound.slope(pressure) * e),
            across: match width {
                1 => [0.0; 2],
                _ => [-direction[1], direction[0]],
            },
            softness: slip / radius,
        });
    }
    (slides, begins)
}
