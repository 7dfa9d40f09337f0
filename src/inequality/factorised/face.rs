//! One face solved to the end: GCR behind the factor of its matrix, on the operators of
//! the problem and in the scale of the matrix, so that no block hides another's residual.

use super::super::blocks::ContactBlock;
use super::super::qp::{Progress, QpIterate, QpNorms, QpRun, QpScales, QpStatus, QpTargets};
use super::Faces;
use crate::krylov::gcr::{Directions, Gcr};
use crate::krylov::{Monitor, Verdict};
use crate::linalg::indefinite::SparseIndefinite;
use crate::linalg::vector::{add_scaled, norm};
use crate::linalg::{LinearOperator, Preconditioner, Workspace};
use crate::saddle::{SaddleOperator, Status};

/// Krylov iterations on a face at most. An exact factor takes two or three, each rigid
/// mode that contact holds one more.
const MOST_ITERATIONS: usize = 40;

/// How the work on a face ended.
pub(super) struct Solved {
    /// Krylov iterations.
    pub(super) iterations: u32,
    /// Why the targets were not reached; none where they were.
    pub(super) failed: Option<QpStatus>,
    /// Number of motions on the face that lower the energy.
    pub(super) unstable: usize,
}

/// The matrix of a face as its operators apply it, scaled.
struct FaceOperator<'f> {
    /// A, B and S of the problem.
    body: SaddleOperator<'f>,
    /// C and its columns.
    contact: ContactBlock<'f>,
    scale: &'f [f64],
    status: &'f [Status],
}

impl FaceOperator<'_> {
    /// D x.
    fn scaled(&self, x: &[f64], work: &mut Workspace) -> Vec<f64> {
        let mut scaled = work.copy(x);
        self.rescale(&mut scaled);
        scaled
    }

    fn rescale(&self, x: &mut [f64]) {
        x.iter_mut().zip(self.scale).for_each(|(x, d)| *x *= d);
    }
}

impl LinearOperator for FaceOperator<'_> {
    fn rows(&self) -> usize {
        self.scale.len()
    }

    fn columns(&self) -> usize {
        self.rows()
    }

    fn apply(&self, x: &[f64], y: &mut [f64], work: &mut Workspace) {
        let mut scaled = self.scaled(x, work);
        let body = self.body.rows();
        let (known, multiplier) = scaled.split_at_mut(body);
        let (force, closing) = y.split_at_mut(body);
        self.body.apply(known, force, work);
        let unknowns = self.body.stiffness.rows();
        self.contact.rows.apply(&known[..unknowns], closing, work);
        for (index, &status) in self.status.iter().enumerate() {
            if status != Status::Stick {
                (multiplier[index], closing[index]) = (0.0, 0.0);
            }
        }
        let columns = self.contact.columns;
        columns.add_transposed(1.0, multiplier, &mut force[..unknowns], work);
        self.rescale(y);
        // Identities off the face.
        for (index, &status) in self.status.iter().enumerate() {
            if status != Status::Stick {
                y[body + index] = -x[body + index];
            }
        }
        work.give(scaled);
    }

    /// The operator is symmetric.
    fn apply_transposed(&self, y: &[f64], x: &mut [f64], work: &mut Workspace) {
        self.apply(y, x, work);
    }
}

impl Preconditioner for SparseIndefinite {
    fn apply(&self, r: &[f64], z: &mut [f64], work: &mut Workspace) {
        z.copy_from_slice(r);
        self.solve(z, work);
    }
}

impl Faces<'_, '_> {
    /// Solves on the face where `iterate` is, from where the problem starts.
    ///
    /// # Errors
    /// Where the face has no factor, or somebody stopped.
    pub(super) fn solve_face(
        &self,
        iterate: &mut QpIterate,
        run: &mut QpRun<'_, '_>,
    ) -> Result<Solved, QpStatus> {
        let status = self.blocks.contact_of(iterate).status.clone();
        let operator = self.operator(&status);
        let mut r = self.pack(iterate, &operator, run.work);
        let mut x = run.work.zeros(r.len());
        if run.scales.gap == 0.0 {
            let contact = self.blocks.contact_of(iterate);
            let gap = self.blocks.contact.set.misfit(contact.point());
            run.scales.see(0.0, norm(&gap));
        }
        let mut monitor = FaceMonitor {
            faces: self,
            targets: run.targets,
            scales: *run.scales,
            active: self.blocks.contact_of(iterate).closed(),
            progress: run.progress,
            plain: vec![0.0; r.len()],
            iterations: 0,
            ended: None,
        };
        let mut unstable = 0;
        if monitor.judge(&r) == Verdict::Continue {
            let factor = self.system.factor(&status)?;
            unstable = self.system.unstable(&factor);
            self.see_constraint((&factor, &r), iterate, (run.scales, run.work));
            monitor.scales = *run.scales;
            let method = Gcr {
                operator: &operator,
                preconditioner: &factor,
                directions: &mut Directions::keeping(MOST_ITERATIONS),
                iterations: MOST_ITERATIONS,
            };
            let outcome = method.solve((&mut x, &mut r), &mut monitor, run.work);
            if monitor.ended.is_none() {
                monitor.ended = QpStatus::failure(outcome);
            }
        }
        let (iterations, ended) = (monitor.iterations, monitor.ended);
        operator.rescale(&mut x);
        self.unpack(iterate, (&x, &r), run.work);
        run.work.give(x);
        run.work.give(r);
        match ended {
            Some(QpStatus::Interrupted) => Err(QpStatus::Interrupted),
            Some(QpStatus::Solved) => Ok(Solved {
                iterations,
                failed: None,
                unstable,
            }),
            failed => Ok(Solved {
                iterations,
                failed,
                unstable,
            }),
        }
    }

    /// The operator of a face.
    fn operator<'f>(&'f self, status: &'f [Status]) -> FaceOperator<'f> {
        FaceOperator {
            body: SaddleOperator {
                stiffness: self.problem.stiffness,
                released: self.problem.curvature.map(|c| c as &dyn LinearOperator),
                blocks: &self.blocks.equalities,
            },
            contact: self.blocks.contact,
            scale: &self.system.scale,
            status,
        }
    }

    /// One application of the shifted factor on the face of `iterate`.
    ///
    /// # Errors
    /// Where the face has no factor.
    pub(super) fn predict(
        &self,
        iterate: &mut QpIterate,
        work: &mut Workspace,
    ) -> Result<(), QpStatus> {
        let status = self.blocks.contact_of(iterate).status.clone();
        let operator = self.operator(&status);
        let r = self.pack(iterate, &operator, work);
        let mut x = work.copy(&r);
        self.system.factor(&status)?.solve(&mut x, work);
        operator.rescale(&mut x);
        self.unpack(iterate, (&x, &r), work);
        Ok(())
    }

    /// Scale of the constraint on a face: what load and contact pressure would make of it
    /// without the equalities' multipliers. Cost: one solve with the factor and one
    /// application of the displacement preconditioner.
    fn see_constraint(
        &self,
        (factor, r): (&SparseIndefinite, &[f64]),
        iterate: &QpIterate,
        (scales, work): (&mut QpScales, &mut Workspace),
    ) {
        if self.blocks.equalities.is_empty() {
            return;
        }
        let mut x = work.copy(r);
        factor.solve(&mut x, work);
        x.iter_mut()
            .zip(&self.system.scale)
            .for_each(|(x, d)| *x *= d);
        let pressure = &x[x.len() - self.blocks.contact.rows.rows()..];
        let mut force = work.copy(&iterate.force);
        let columns = self.blocks.contact.columns;
        columns.add_transposed(-1.0, pressure, &mut force, work);
        let mut moved = work.zeros(force.len());
        self.problem.displacement.apply(&force, &mut moved, work);
        let mut constraint = 0.0_f64;
        for (equality, block) in self.blocks.equalities.iter().zip(&iterate.blocks) {
            let mut left = block.residual.clone();
            equality.rows.subtract_product(&moved, &mut left, work);
            constraint = constraint.hypot(norm(&left));
        }
        scales.see(constraint, 0.0);
        [x, force, moved]
            .into_iter()
            .for_each(|vector| work.give(vector));
    }

    /// The scaled residual of the face.
    fn pack(
        &self,
        iterate: &QpIterate,
        operator: &FaceOperator<'_>,
        work: &mut Workspace,
    ) -> Vec<f64> {
        let mut r = work.copy(&iterate.force);
        for block in &iterate.blocks[..self.blocks.place()] {
            r.extend_from_slice(&block.residual);
        }
        let contact = self.blocks.contact_of(iterate);
        let on_face = contact.residual.iter().zip(&contact.status);
        r.extend(on_face.map(|(gap, &status)| match status {
            Status::Stick => *gap,
            Status::Open | Status::Slip => 0.0,
        }));
        operator.rescale(&mut r);
        r
    }

    /// Adds increments to the iterate and takes the residuals over that they leave.
    fn unpack(&self, iterate: &mut QpIterate, (x, r): (&[f64], &[f64]), work: &mut Workspace) {
        let unknowns = iterate.force.len();
        let plain = r.iter().zip(&self.system.scale).map(|(r, d)| r / d);
        let plain: Vec<f64> = plain.collect();
        add_scaled(&mut iterate.displacement, 1.0, &x[..unknowns]);
        iterate.force.copy_from_slice(&plain[..unknowns]);
        let mut first = unknowns;
        for block in &mut iterate.blocks[..self.blocks.place()] {
            let range = first..first + block.residual.len();
            add_scaled(&mut block.multiplier, 1.0, &x[range.clone()]);
            block.residual.copy_from_slice(&plain[range.clone()]);
            first = range.end;
        }
        let contact = &mut iterate.blocks[self.blocks.place()];
        add_scaled(&mut contact.multiplier, 1.0, &x[first..]);
        let rows = self.blocks.contact.rows;
        rows.subtract_product(&x[..unknowns], &mut contact.residual, work);
    }
}

/// Follows the iterations on a face.
struct FaceMonitor<'f, 'c, 'a, 'b> {
    faces: &'f Faces<'c, 'a>,
    targets: QpTargets,
    scales: QpScales,
    /// Number of closed multipliers, for reports.
    active: usize,
    progress: &'f mut Progress<'b>,
    /// The residual without its scale.
    plain: Vec<f64>,
    iterations: u32,
    /// How the face ended; none while it runs.
    ended: Option<QpStatus>,
}

impl Monitor for FaceMonitor<'_, '_, '_, '_> {
    fn judge(&mut self, residual: &[f64]) -> Verdict {
        self.iterations += 1;
        let scaled = residual.iter().zip(&self.faces.system.scale);
        let plain = self.plain.iter_mut().zip(scaled);
        plain.for_each(|(plain, (r, d))| *plain = r / d);
        let (force, rest) = self.plain.split_at(self.faces.problem.stiffness.rows());
        let (constraint, gap) = rest.split_at(self.faces.blocks.equality_unknowns());
        let norms = QpNorms {
            force: norm(force),
            constraint: norm(constraint),
            gap: norm(gap),
        };
        let relative = norms.relative(self.targets.force_scale, &self.scales);
        if (self.progress)(&norms, &self.scales, self.active) == Verdict::Stop {
            self.ended = Some(QpStatus::Interrupted);
        } else if relative <= self.targets.level {
            self.ended = Some(QpStatus::Solved);
        }
        match self.ended {
            Some(_) => Verdict::Stop,
            None => Verdict::Continue,
        }
    }
}
