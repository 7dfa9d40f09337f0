//! One face of the admissible set: operators restricted to the multipliers that
//! stick, their metric, the Krylov solve and its monitor.
//!
//! ```text
//! face:    x_i = 0 where open,   s_i = 0 where it sticks
//! metric:  K on the multipliers that stick, by its Cholesky factor
//! ```
//!
//! A traction of friction that slips follows its pressure, so that its column is added to that
//! of the pressure and the system is not symmetric; across the slip it gives way ([`Slide`]).
//!
//! On a face the problem is linear. Rows and columns of multipliers that do not stick are
//! zero, so that vectors keep their length from face to face and kept directions stay of
//! use. Cost: the factor, m^3 / 3 for m multipliers that stick, and the Krylov iterations.

use super::super::blocks::Blocks;
use super::super::qp::{QpIterate, QpProblem, QpRun, QpStatus};
use super::augmented::Augmented;
use super::face_metric::{FaceMetric, LastFactor};
use super::monitor::{FaceMonitor, Review};
use super::shared::shared_on_the_face;
use super::slides::{Shape, add_along, expand, gather, unknowns};
use super::weights::weigh;
use super::{Faces, GAP_WEIGHT};
use crate::krylov::Outcome;
use crate::krylov::gcr::{self, Gcr};
use crate::linalg::vector::add_scaled;
use crate::linalg::{FactoriseError, LinearOperator, Workspace};
use crate::saddle::{EqualityBlock, JointModes, SaddleOperator, Status};

/// How the work on a face ended.
pub(super) struct Face {
    /// Krylov iterations spent on the face.
    pub(super) iterations: u32,
    /// Whether the targets were reached on the face.
    pub(super) reached: bool,
    /// Why the method cannot go on, where it cannot.
    pub(super) failed: Option<QpStatus>,
}

/// Rows or columns of the constraints that hold on the face, weighted.
struct OnFace<'a> {
    /// The constraints, or the forces transposed, of all multipliers.
    operator: &'a dyn LinearOperator,
    /// Moduli by which their rows are weighted besides; empty where all are one.
    moduli: &'a [f64],
    /// The face; rows of what is no unknown on it count as zero.
    face: &'a Shape<'a>,
    /// Whether tractions that slip follow their pressures, as forces do.
    follows: bool,
}

impl LinearOperator for OnFace<'_> {
    fn rows(&self) -> usize {
        self.operator.rows()
    }

    fn columns(&self) -> usize {
        self.operator.columns()
    }

    fn apply(&self, x: &[f64], y: &mut [f64], work: &mut Workspace) {
        self.operator.apply(x, y, work);
        if self.follows && !self.face.slides.is_empty() {
            let all = y.to_vec();
            add_along(self.face.slides, &all, y);
        }
        gather(self.face.slides, y);
        for (value, &is_unknown) in y.iter_mut().zip(&self.face.unknowns) {
            *value *= if is_unknown { GAP_WEIGHT } else { 0.0 };
        }
        weigh(self.moduli, y);
    }

    /// Of a `y` that is zero off the face.
    fn apply_transposed(&self, y: &[f64], x: &mut [f64], work: &mut Workspace) {
        x.fill(0.0);
        self.add_transposed(1.0, y, x, work);
    }

    /// Of a `y` that is zero off the face.
    fn add_transposed(&self, factor: f64, y: &[f64], x: &mut [f64], work: &mut Workspace) {
        let weight = factor * GAP_WEIGHT;
        if self.moduli.is_empty() && self.face.slides.is_empty() {
            return self.operator.add_transposed(weight, y, x, work);
        }
        let mut weighted = work.copy(y);
        weigh(self.moduli, &mut weighted);
        expand(&self.face.following(self.follows), &mut weighted);
        self.operator.add_transposed(weight, &weighted, x, work);
        work.give(weighted);
    }
}

/// c of the points that slip, in the weights of the face `[multipliers]`.
struct Softness(Vec<f64>);

impl LinearOperator for Softness {
    fn rows(&self) -> usize {
        self.0.len()
    }

    fn columns(&self) -> usize {
        self.0.len()
    }

    fn apply(&self, x: &[f64], y: &mut [f64], _work: &mut Workspace) {
        let pairs = x.iter().zip(&self.0);
        y.iter_mut().zip(pairs).for_each(|(y, (x, c))| *y = c * x);
    }

    fn apply_transposed(&self, y: &[f64], x: &mut [f64], work: &mut Workspace) {
        self.apply(y, x, work);
    }
}

/// c of points that slip in space, in the weights of the face.
fn softness(moduli: &[f64], face: &Shape<'_>) -> Option<Softness> {
    let mut slides = face
        .slides
        .iter()
        .filter(|slide| slide.width > 1)
        .peekable();
    slides.peek()?;
    let mut softness = vec![0.0; face.unknowns.len()];
    for slide in slides {
        let place = slide.first as usize;
        let weight = GAP_WEIGHT * moduli.get(place).unwrap_or(&1.0);
        softness[place] = slide.softness * weight * weight;
    }
    Some(Softness(softness))
}

/// What contact adds to the linear system on a face.
struct Restricted<'a> {
    /// Constraints on the face.
    rows: OnFace<'a>,
    /// Forces on the face, transposed.
    columns: OnFace<'a>,
    /// What gives way to slip; none where nothing does.
    softness: Option<Softness>,
    /// Inverse of the compliance on the face, the metric of the block.
    metric: FaceMetric<'a>,
    /// Modes that contact shares with the first block, on the face; none where it shares none.
    shared: Option<JointModes>,
    /// Terms that vanish where the constraints hold.
    augmented: Option<Augmented<'a>>,
}

impl<'a> Restricted<'a> {
    /// The contact block as an equality on the face that `status` describes; fails
    /// where the compliance has no factor there.
    fn new(
        problem: &QpProblem<'a>,
        blocks: &Blocks<'a>,
        (status, face): (&'a [Status], &'a Shape<'a>),
        last: &LastFactor,
    ) -> Result<Self, FactoriseError> {
        let contact = &blocks.contact;
        let terms = problem.augmentation;
        let on_face = |operator, follows| OnFace {
            operator,
            moduli: contact.moduli,
            face,
            follows,
        };
        Ok(Self {
            rows: on_face(contact.rows, false),
            columns: on_face(contact.columns, true),
            softness: softness(contact.moduli, face),
            metric: FaceMetric::new(contact, face, last)?,
            shared: shared_on_the_face(contact, status),
            augmented: terms.and_then(|terms| {
                let pair = [contact.rows, contact.columns];
                Augmented::new(terms, pair, (status, face.slides), problem.curvature)
            }),
        })
    }

    /// The equalities, then contact where there is any.
    fn system<'s>(&'s self, blocks: &'s Blocks<'a>) -> Vec<EqualityBlock<'s>> {
        let mut system: Vec<EqualityBlock<'s>> = blocks.equalities.clone();
        if self.rows.rows() > 0 {
            system.push(EqualityBlock {
                rows: &self.rows,
                columns: &self.columns,
                stabilisation: self.softness.as_ref().map(|s| s as &dyn LinearOperator),
                metric: &self.metric,
                shared: self.shared.as_ref(),
                joint: None,
            });
        }
        system
    }
}

/// Increments of all unknowns and the residual that they leave.
struct Packed {
    /// Increments of displacement, equality unknowns and multipliers, one after the
    /// other.
    x: Vec<f64>,
    /// The residual that these increments leave, in the same order.
    r: Vec<f64>,
}

/// What the Krylov method may use.
struct Means<'r> {
    /// Krylov directions of earlier faces and solves, which this one may use and adds
    /// to.
    directions: &'r mut gcr::Directions,
    /// Krylov iterations at most.
    iterations: u32,
    /// Scratch vectors.
    work: &'r mut Workspace,
}

impl Faces<'_, '_> {
    /// Solves on the iterate's own face until the targets or a review.
    ///
    /// # Errors
    /// Where the metric on the face is not positive definite.
    pub(super) fn run_face(
        &self,
        iterate: &mut QpIterate,
        run: &mut QpRun<'_, '_>,
        (review, reduction): (Review, f64),
        iterations: u32,
    ) -> Result<Face, QpStatus> {
        let contact = self.blocks.contact_of(iterate);
        let (status, slides) = (contact.status.clone(), contact.slides.clone());
        let face = Shape {
            unknowns: unknowns(&status, &slides),
            slides: &slides,
        };
        let restricted = Restricted::new(self.problem, &self.blocks, (&status, &face), &self.last)
            .map_err(QpStatus::from)?;
        let mut packed = self.pack(iterate, run.work);
        if let Some(augmented) = &restricted.augmented {
            let gap = &self.blocks.contact_of(iterate).residual;
            let force = &mut packed.r[..iterate.force.len()];
            augmented.add_force(1.0, gap, (force, run.work));
        }
        let monitor = FaceMonitor {
            displacement: iterate.force.len(),
            equality: self.blocks.equality_unknowns(),
            moduli: self.blocks.contact.moduli,
            augmented: restricted.augmented.as_ref(),
            targets: run.targets,
            largest: self.largest,
            scales: run.scales,
            review,
            reduction,
            start: 0.0,
            iterations: 0,
            reached: false,
            interrupted: false,
            active: self.blocks.contact_of(iterate).closed(),
            progress: run.progress,
        };
        let means = Means {
            directions: run.directions,
            iterations,
            work: run.work,
        };
        let face = self.descend(&restricted, &mut packed, monitor, means);
        self.unpack(iterate, &packed, run.work);
        if let Some(augmented) = &restricted.augmented {
            let du = &packed.x[..iterate.force.len()];
            let contact = &mut iterate.blocks[self.blocks.place()];
            let state = (&mut contact.multiplier[..], &mut iterate.force[..]);
            augmented.restore((du, &contact.residual), state, run.work);
        }
        run.work.give(packed.x);
        run.work.give(packed.r);
        Ok(face)
    }

    /// Solves on the face where its start does not reach the targets.
    fn descend(
        &self,
        restricted: &Restricted<'_>,
        packed: &mut Packed,
        mut monitor: FaceMonitor<'_, '_>,
        means: Means<'_>,
    ) -> Face {
        monitor.start = monitor.measure(&packed.r).1;
        monitor.reached = monitor.start <= monitor.targets.level;
        let mut failed = None;
        if !monitor.reached {
            let outcome = self.krylov(restricted, packed, &mut monitor, means);
            failed = if monitor.interrupted {
                Some(QpStatus::Interrupted)
            } else {
                QpStatus::failure(outcome)
            };
        }
        Face {
            iterations: monitor.iterations,
            reached: monitor.reached,
            failed,
        }
    }

    /// Runs GCR on the face from where `packed` stands; the directions that it finds
    /// stay for the next face.
    fn krylov(
        &self,
        restricted: &Restricted<'_>,
        packed: &mut Packed,
        monitor: &mut FaceMonitor<'_, '_>,
        means: Means<'_>,
    ) -> Outcome {
        let problem = self.problem;
        let blocks = restricted.system(&self.blocks);
        let preconditioner =
            problem
                .step
                .preconditioner(problem.stiffness, problem.displacement, &blocks);
        let operator = SaddleOperator {
            stiffness: problem.stiffness,
            geometric: match &restricted.augmented {
                Some(augmented) => Some(augmented as &dyn LinearOperator),
                None => problem.curvature.map(|c| c as &dyn LinearOperator),
            },
            blocks: &blocks,
        };
        let method = Gcr {
            operator: &operator,
            preconditioner: &*preconditioner,
            directions: means.directions,
            iterations: means.iterations as usize,
        };
        method.solve((&mut packed.x, &mut packed.r), monitor, means.work)
    }

    /// Residuals in one vector, those of contact weighted and only where they count.
    fn pack(&self, iterate: &QpIterate, work: &mut Workspace) -> Packed {
        let blocks = iterate.blocks.iter();
        let multipliers: usize = blocks.map(|block| block.residual.len()).sum();
        let length = iterate.force.len() + multipliers;
        let x = work.zeros(length);
        let mut r = work.zeros(length);
        let (force, mut rest) = r.split_at_mut(iterate.force.len());
        force.copy_from_slice(&iterate.force);
        for block in &iterate.blocks[..self.blocks.place()] {
            let (part, next) = rest.split_at_mut(block.residual.len());
            part.copy_from_slice(&block.residual);
            rest = next;
        }
        let contact = self.blocks.contact_of(iterate);
        let mut gaps = work.copy(&contact.residual);
        gather(&contact.slides, &mut gaps);
        let is_unknown = unknowns(&contact.status, &contact.slides);
        for ((value, gap), is_unknown) in rest.iter_mut().zip(&gaps).zip(is_unknown) {
            if is_unknown {
                *value = GAP_WEIGHT * gap;
            }
        }
        work.give(gaps);
        weigh(self.blocks.contact.moduli, rest);
        Packed { x, r }
    }

    /// Adds the increments to the iterate, and takes over the residuals that belong to
    /// them.
    fn unpack(&self, iterate: &mut QpIterate, packed: &Packed, work: &mut Workspace) {
        let unknowns = iterate.force.len();
        let (du, mut dx) = packed.x.split_at(unknowns);
        let (force, mut r) = packed.r.split_at(unknowns);
        add_scaled(&mut iterate.displacement, 1.0, du);
        iterate.force.copy_from_slice(force);
        let place = self.blocks.place();
        for block in &mut iterate.blocks[..place] {
            let (step, next) = dx.split_at(block.multiplier.len());
            let (residual, rest) = r.split_at(block.multiplier.len());
            add_scaled(&mut block.multiplier, 1.0, step);
            block.residual.copy_from_slice(residual);
            (dx, r) = (next, rest);
        }
        let contact = &mut iterate.blocks[place];
        let mut step = work.copy(dx);
        weigh(self.blocks.contact.moduli, &mut step);
        expand(&contact.slides, &mut step);
        add_scaled(&mut contact.multiplier, GAP_WEIGHT, &step);
        work.give(step);
        if !contact.residual.is_empty() {
            // The packed residual knows the gaps of the face only.
            let mut closing = work.scratch(contact.residual.len());
            self.blocks.contact.rows.apply(du, &mut closing, work);
            add_scaled(&mut contact.residual, -1.0, &closing);
            work.give(closing);
        }
    }
}
