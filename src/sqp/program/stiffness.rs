//! The stiffness that a program leaves to small motions, and its inverse:
//!
//! ```text
//! K = A - (what loads and the curvature of the gaps take off),   B x = 0,   C_active x = 0
//! ```
//!
//! One inversion costs what one program on a fixed active set costs.

use super::QuadraticProgram;
use super::step::blocks;
use crate::inequality::{
    Augmentation, BlockIterate, OneLevel, QpIterate, QpNorms, QpProblem, QpRun, QpScales, QpStatus,
    QpTargets,
};
use crate::krylov::Verdict;
use crate::linalg::vector::{dot, norm};
use crate::linalg::{LinearOperator, Preconditioner, SparseRows, Workspace};
use crate::model::held::mask;
use crate::model::state::State;
use crate::precond::Counted;
use crate::sqp::run::Run;

constants! {
    /// Bulk over shear modulus, about, above which what is left of a change of volume is no energy
    /// but the error of a motion that has none.
    const STIFFEST: f64 = 1e4;
    /// Chebyshev steps whose error is rounding.
    const EXACT: usize = 32;
}

/// What stands for the body in a solve on the present face.
struct Terms<'a> {
    stiffness: &'a dyn LinearOperator,
    /// What is taken off it.
    curvature: Option<&'a SparseRows>,
    /// It and the pressures in one product, where there is one.
    joint: Option<&'a dyn LinearOperator>,
    /// What contact pressure makes of it.
    augmentation: Option<&'a Augmentation>,
}

/// How far one step of inverse iteration is solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Accuracy {
    /// Residual over its first value that is enough.
    pub(crate) level: f64,
    /// Number of Krylov iterations at most.
    pub(crate) iterations: u32,
}

impl QuadraticProgram<'_> {
    /// K^-1 `force` among the motions that volume and the present contacts admit; none
    /// where it was stopped.
    pub(crate) fn invert(
        &self,
        run: &mut Run<'_>,
        force: Vec<f64>,
        accuracy: Accuracy,
    ) -> Option<Vec<f64>> {
        let pressure = self.pressure();
        let terms = Terms {
            stiffness: self.stiffness(),
            curvature: self.geometric.all(),
            joint: pressure.as_ref().and_then(|pressure| pressure.joint),
            augmentation: self.augmentation.as_ref(),
        };
        let (motion, status) = self.solve_on_face(run, (terms, force), accuracy);
        match status {
            Some(QpStatus::Interrupted | QpStatus::IndefiniteMetric | QpStatus::Unsupported) => {
                None
            }
            _ => Some(motion),
        }
    }

    /// The motion nearest to `motion`, in the stiffness at rest, among those that volume and
    /// the present contacts admit; none where it is not found.
    pub(crate) fn admitted(
        &self,
        run: &mut Run<'_>,
        motion: &[f64],
        accuracy: Accuracy,
    ) -> Option<Vec<f64>> {
        let stiffness = &self.model.prepared.stiffness;
        let mut force = vec![0.0; motion.len()];
        stiffness.apply(motion, &mut force, run.work);
        mask(&self.model.prepared.held, &mut force);
        let terms = Terms {
            stiffness: &self.model.prepared.stiffness,
            curvature: None,
            joint: None,
            augmentation: None,
        };
        let (motion, status) = self.solve_on_face(run, (terms, force), accuracy);
        status.is_none().then_some(motion)
    }

    /// The motion under `force` of a body with the stiffness of `terms`, and why it is not
    /// accurate where it is not.
    fn solve_on_face(
        &self,
        run: &mut Run<'_>,
        (terms, force): (Terms<'_>, Vec<f64>),
        accuracy: Accuracy,
    ) -> (Vec<f64>, Option<QpStatus>) {
        let mut iterate = at_rest(run.state, force);
        let targets = QpTargets {
            force_scale: norm(&iterate.force),
            level: accuracy.level,
            multiplier_error: None,
        };
        let displacement = Counted::new(&*self.inverse.displacement);
        let mut blocks = self.blocks();
        blocks[0].joint = terms.joint;
        let step = self.block_step(&displacement, run.work);
        let problem = QpProblem {
            stiffness: terms.stiffness,
            augmentation: terms.augmentation,
            ..self.problem(terms.curvature, &displacement, &blocks, &*step)
        };
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
        learned.directions.clear(work);
        let mut solve = QpRun {
            targets,
            scales: &mut QpScales::default(),
            iterations: accuracy.iterations,
            directions: &mut learned.directions,
            progress: &mut progress,
            work,
        };
        let status = OneLevel::new(problem).solve_on_face(&mut iterate, &mut solve);
        counters.eigenvalue_applications += displacement.applications();
        (iterate.displacement, status)
    }

    /// x.(A - what is taken off) x, and what the volume resists where it can change.
    pub(crate) fn curvature_along(&self, x: &[f64], work: &mut Workspace) -> f64 {
        let stiff = along(self.stiffness(), x, work) + self.volume_along(x, work);
        match self.geometric.all() {
            Some(geometric) => stiff - along(geometric, x, work),
            None => stiff,
        }
    }

    /// B x . S^-1 B x; zero where no volume can change.
    fn volume_along(&self, x: &[f64], work: &mut Workspace) -> f64 {
        let block = self.model.prepared.pressure.as_ref();
        let block = block.filter(|block| block.stabilisation.is_some());
        let (Some(block), Some(pressure)) = (block, self.pressure()) else {
            return 0.0;
        };
        let metric = block.softened(STIFFEST, EXACT, self.model.plan.problem.units.dimension);
        let mut change = vec![0.0; pressure.rows.rows()];
        pressure.rows.apply(x, &mut change, work);
        let mut resisting = vec![0.0; change.len()];
        metric.apply(&change, &mut resisting, work);
        dot(&change, &resisting)
    }

    /// Whether the stiffness with the curvature of contact taken off is positive along
    /// `step`.
    pub(crate) fn has_positive_stiffness(
        &self,
        curvature: &SparseRows,
        step: &[f64],
        work: &mut Workspace,
    ) -> bool {
        along(self.stiffness(), step, work) >= along(curvature, step, work)
    }
}

/// x.M x.
fn along(matrix: &dyn LinearOperator, x: &[f64], work: &mut Workspace) -> f64 {
    let mut product = work.scratch(x.len());
    matrix.apply(x, &mut product, work);
    let sum = dot(x, &product);
    work.give(product);
    sum
}

/// Nothing moved yet under `force`, on the contacts of `state`.
fn at_rest(state: &State, force: Vec<f64>) -> QpIterate {
    QpIterate {
        displacement: vec![0.0; force.len()],
        blocks: blocks(
            vec![0.0; state.pressure.len()],
            BlockIterate {
                multiplier: vec![0.0; state.multiplier.len()],
                residual: vec![0.0; state.multiplier.len()],
                status: state.status.clone(),
                slides: Vec::new(),
            },
        ),
        force,
    }
}
