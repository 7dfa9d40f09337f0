//! The dual problem of a program: the transposed system on the contacts that hold,
//!
//! ```text
//! [ (A - G)^T  B^T  C^T ] [y_u]   [J_u]
//! [ B          -S       ] [y_p] = [J_p]     rows and columns of open contacts left out
//! [ C                   ] [y_l]   [J_l]
//! ```
//!
//! with friction C^T and C of what slips as [`super::dual_contact`] has them, other matrices.
//! `[displacement]`, `[pressures]`, `[multipliers]`, non-dimensional. y are the sensitivities of a
//! functional J to the residuals of the state (R. Becker and R. Rannacher, Acta Numerica 10, 2001).
//! Passes of GCR with the approximate inverse or the factor in use, each from the residual
//! computed anew and with the directions of those before, of other functionals too; where they stagnate,
//! with a factor of the body.
//! Cost: that of a program on a fixed set of contacts.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use super::QuadraticProgram;
use super::dual_contact::DualContact;
use super::step::blocks;
use crate::inequality::{
    BlockIterate, OneLevel, QpIterate, QpNorms, QpRun, QpScales, QpStatus, QpTargets,
};
use crate::krylov::Verdict;
use crate::linalg::vector::{add_scaled, norm};
use crate::linalg::{LinearOperator, SparseRows, Workspace};
use crate::precond::Counted;
use crate::saddle::{EqualityBlock, SaddleOperator};
use crate::sqp::fields::Fields;
use crate::sqp::run::Run;

constants! {
    /// Reduction of the residual in one pass, beyond which that which GCR carries along parts from
    /// the true one.
    const REDUCTION: f64 = 3e-7;
    /// Reduction in the pass that shows how large y is, which residuals are measured beside: by less its
    /// size is not known to a tenth, and what a pass asks for without it is a hundred times too much
    /// where a tool's force moves nothing but gaps (Hertz, 25 applications in the place of 20).
    const FIRST: f64 = 0.1;
    /// What a pass is asked for, over what a solution may leave: the true residual is a little larger.
    const MARGIN: f64 = 0.5;
    /// Passes at most.
    const MOST_PASSES: u32 = 8;
    /// Krylov iterations of one pass, at most.
    const MOST_PER_PASS: u32 = 600;
}

/// A dual solution.
#[derive(Clone, Debug)]
pub(crate) struct DualSolution {
    /// y.
    pub(crate) fields: Fields,
    /// What it is to the law of friction, where points slip `[multipliers]`; empty without.
    pub(crate) law: Vec<f64>,
    /// Its true residual over its scale.
    pub(crate) residual: f64,
}

/// Why there is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum DualFailure {
    /// The caller asked to stop.
    Stopped,
    /// Passes end at this residual.
    Residual(f64),
}

/// A dual problem: the transposed matrix and its right side.
#[derive(Clone, Copy)]
pub(super) struct DualProblem<'p> {
    /// G^T.
    pub(super) curvature: Option<&'p SparseRows>,
    /// J_u, J_p, J_l, those of open contacts zero.
    pub(super) right: &'p Fields,
    /// Rows and columns of what holds.
    pub(super) contact: &'p DualContact,
    /// True residual over its scale that a solution may leave.
    pub(super) target: f64,
}

/// What a dual solution is asked for, and what is known of it.
#[derive(Clone, Copy)]
pub(crate) struct Wanted<'w> {
    /// J_x.
    pub(crate) right: &'w Fields,
    /// True residual over its scale that a solution may leave.
    pub(crate) target: f64,
    /// Solutions at earlier states, to begin from.
    pub(crate) known: &'w [Arc<Fields>],
}

/// Where the passes have come to.
pub(super) struct Passes {
    pub(super) solution: Fields,
    left: Fields,
    scales: QpScales,
    /// Norm of the force that counts as one.
    force_scale: f64,
    /// What the scales are of.
    scaled: Scaled,
}

/// What residuals are measured beside.
#[derive(Clone, Copy, PartialEq)]
enum Scaled {
    /// The right side alone.
    ByLoad,
    /// What y makes of forces, volumes and gaps.
    BySolution,
}

impl Passes {
    fn relative(&self) -> f64 {
        self.left.norms().relative(self.force_scale, &self.scales)
    }

    /// What the next pass is asked for.
    fn level(&self, target: f64) -> f64 {
        let least = match self.scaled {
            Scaled::ByLoad => FIRST,
            Scaled::BySolution => REDUCTION * self.relative(),
        };
        least.max(MARGIN * target)
    }
}

impl QuadraticProgram<'_> {
    /// y of a functional; what belongs to held unknowns and open contacts is not read. The directions
    /// of `run` are those of dual problems of this program, or none.
    ///
    /// # Errors
    /// [`DualFailure`].
    pub(crate) fn solve_dual(
        &mut self,
        run: &mut Run<'_>,
        wanted: Wanted<'_>,
    ) -> Result<DualSolution, DualFailure> {
        if run.learned.factored.is_some() {
            self.take_kept_factor(run);
        }
        let contact = DualContact::new(self, run.state);
        let (whole, target) = (wanted.right, wanted.target);
        let right = self.on_contacts(whole, &contact);
        let curvature = self.geometric.all().map(SparseRows::transposed);
        let problem = DualProblem {
            curvature: curvature.as_ref(),
            right: &right,
            contact: &contact,
            target,
        };
        let mut at = self.first_pass(&problem);
        if self.now.friction.is_none()
            && self.begin(&problem, wanted.known, &mut at.solution, run.work)
        {
            self.measure(&problem, &mut at, run.work);
        }
        for _ in 0..MOST_PASSES {
            let (before, scaled) = (at.relative(), at.scaled);
            if before <= target {
                break;
            }
            let failed = self.pass(run, &problem, &mut at);
            if failed == Some(QpStatus::Interrupted) {
                return Err(DualFailure::Stopped);
            }
            let is_no_better = scaled == Scaled::BySolution && at.relative() > 0.5 * before;
            let stagnates = failed.is_some() || is_no_better;
            let may_take_factor = !self.has_fresh_factor && self.factor_cost(run).is_some();
            if stagnates && !(may_take_factor && self.take_factor(run)) && failed.is_some() {
                break;
            }
        }
        let residual = at.relative();
        if residual <= target {
            Ok(DualSolution {
                law: contact.of_law(
                    &self.now.coupling,
                    (&whole.multiplier, &at.solution.displacement),
                ),
                fields: at.solution,
                residual,
            })
        } else {
            Err(DualFailure::Residual(residual))
        }
    }

    /// `right` without what is held or open.
    fn on_contacts(&self, right: &Fields, contact: &DualContact) -> Fields {
        let mut right = right.clone();
        self.model.prepared.held.mask(&mut right.displacement);
        contact.gather(&mut right.multiplier);
        right
    }

    /// Nothing solved yet.
    fn first_pass(&self, problem: &DualProblem<'_>) -> Passes {
        let norms = problem.right.norms();
        Passes {
            solution: Fields::zeros_like(problem.right),
            left: problem.right.clone(),
            scales: QpScales {
                constraint: norms.constraint,
                gap: norms.gap,
            },
            // What contact answers is not known yet.
            force_scale: if norms.force > 0.0 {
                norms.force
            } else {
                f64::INFINITY
            },
            scaled: Scaled::ByLoad,
        }
    }

    /// One pass of GCR from the residual; why it ended early.
    fn pass(
        &self,
        run: &mut Run<'_>,
        problem: &DualProblem<'_>,
        at: &mut Passes,
    ) -> Option<QpStatus> {
        let (step, failed) = self.correction(run, problem, at);
        at.solution.add(&step);
        self.measure(problem, at, run.work);
        failed
    }

    /// The residual of where the passes have come to, and its scales.
    fn measure(&self, problem: &DualProblem<'_>, at: &mut Passes, work: &mut Workspace) {
        at.left = self.residual(problem, &at.solution, work);
        let mut contact = vec![0.0; at.left.displacement.len()];
        let columns = self.contact_rows();
        columns.add_transposed(1.0, &at.solution.multiplier, &mut contact, work);
        let scale = norm(&problem.right.displacement).max(norm(&contact));
        at.force_scale = if scale > 0.0 { scale } else { f64::INFINITY };
        let QpScales { constraint, gap } = self.unsolved_norms(problem, &at.solution, work);
        at.scales.see(constraint, gap);
        at.scaled = Scaled::BySolution;
    }

    /// Norms of the volumes and gaps of a motion as large as y whose nodes go to and fro: beside
    /// them is seen what y leaves. What a good preconditioner has shown on the way is rounding.
    fn unsolved_norms(
        &self,
        problem: &DualProblem<'_>,
        y: &Fields,
        work: &mut Workspace,
    ) -> QpScales {
        let components = self.model.prepared.space.components;
        let mut motion = y.displacement.clone();
        for (node, row) in motion.chunks_exact_mut(components).enumerate() {
            if node % 2 == 1 {
                row.iter_mut().for_each(|x| *x = -*x);
            }
        }
        let mut volumes = vec![0.0; y.pressure.len()];
        if let Some(pressure) = self.pressure() {
            pressure.rows.apply(&motion, &mut volumes, work);
        }
        let mut gaps = vec![0.0; y.multiplier.len()];
        let rows = problem.contact.rows(self);
        rows.apply(&motion, &mut gaps, work);
        QpScales {
            constraint: norm(&volumes),
            gap: norm(&gaps),
        }
    }

    /// What GCR makes of the residual.
    fn correction(
        &self,
        run: &mut Run<'_>,
        problem: &DualProblem<'_>,
        at: &mut Passes,
    ) -> (Fields, Option<QpStatus>) {
        let mut iterate = at_residual(&at.left, problem.contact);
        let targets = QpTargets {
            force_scale: at.force_scale,
            level: at.level(problem.target),
            multiplier_error: None,
        };
        let displacement = Counted::new(&*self.inverse.displacement);
        if let Some(body) = &self.factored {
            body.begin();
        }
        let mut blocks = self.blocks();
        let contact = blocks.pop();
        blocks.extend(contact.map(|block| problem.contact.take_part(self, block)));
        let step = self.block_step(&displacement, run.work);
        let face = self.problem(problem.curvature, &displacement, &blocks, &*step);
        let Run {
            learned,
            watch,
            counters,
            work,
            ..
        } = run;
        let mut progress = |_: &QpNorms, _: &QpScales, _: usize| match watch.stopped(counters) {
            Some(_) => Verdict::Stop,
            None => Verdict::Continue,
        };
        let mut solve = QpRun {
            targets,
            scales: &mut at.scales,
            iterations: MOST_PER_PASS,
            directions: &mut learned.directions,
            progress: &mut progress,
            work,
        };
        let failed = OneLevel::new(face).solve_on_face(&mut iterate, &mut solve);
        counters.applications += displacement.applications();
        if let Some(body) = &self.factored {
            counters.applications += body.solutions.load(Ordering::Relaxed);
        }
        (fields_of(iterate, at), failed)
    }

    /// What y leaves of the right side.
    pub(super) fn residual(
        &self,
        problem: &DualProblem<'_>,
        y: &Fields,
        work: &mut Workspace,
    ) -> Fields {
        let blocks: Vec<EqualityBlock<'_>> = self.pressure().into_iter().collect();
        let operator = SaddleOperator {
            stiffness: self.stiffness(),
            geometric: problem.curvature.map(|all| all as &dyn LinearOperator),
            blocks: &blocks,
        };
        let body = [&y.displacement[..], &y.pressure].concat();
        let mut product = vec![0.0; body.len()];
        operator.apply(&body, &mut product, work);
        let (force, volumes) = product.split_at(y.displacement.len());
        let mut left = problem.right.clone();
        add_scaled(&mut left.displacement, -1.0, force);
        add_scaled(&mut left.pressure, -1.0, volumes);
        let columns = self.contact_rows();
        columns.add_transposed(-1.0, &y.multiplier, &mut left.displacement, work);
        let rows = problem.contact.rows(self);
        rows.subtract_product(&y.displacement, &mut left.multiplier, work);
        problem
            .contact
            .keep_across(&mut left.multiplier, &y.multiplier);
        left
    }
}

/// Nothing solved yet of the residual `left`.
fn at_residual(left: &Fields, contact: &DualContact) -> QpIterate {
    QpIterate {
        displacement: vec![0.0; left.displacement.len()],
        force: left.displacement.clone(),
        blocks: blocks(
            left.pressure.clone(),
            BlockIterate {
                multiplier: vec![0.0; left.multiplier.len()],
                residual: left.multiplier.clone(),
                status: contact.status.clone(),
                slides: contact.across(),
            },
        ),
    }
}

/// The increments of a solved iterate.
fn fields_of(mut iterate: QpIterate, at: &Passes) -> Fields {
    let contact = iterate.blocks.pop().unwrap_or_default();
    let pressure = iterate.blocks.pop().unwrap_or_default();
    Fields {
        displacement: iterate.displacement,
        pressure: if at.solution.pressure.is_empty() {
            Vec::new()
        } else {
            pressure.multiplier
        },
        multiplier: contact.multiplier,
    }
}
