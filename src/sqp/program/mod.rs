//! One quadratic program: the body with frozen normals, the curvature of the
//! gap in its stiffness, and the metric of the candidate surface.
//!
//! ```text
//! min 1/2 du.(A - G) du - r.du   with   B du - S dp = b,   g - C du >= 0 on contacts
//! ```
//!
//! A the tangent, G what follower loads and the curvature of contact take off it, r and b the
//! residuals of the state. Where tools have moved on and the body has not, C, G and r leave their
//! way out of the change of the area. One program is one SQP iteration.

mod augmentation;
mod by_factor;
mod contact_edges;
mod dual;
mod dual_contact;
mod dual_start;
mod factorised;
mod geometric;
mod inverse;
mod penalised;
mod rigid_modes;
mod solve;
pub(crate) mod step;
mod stiffness;

use std::sync::Arc;

use super::contact_metric::ContactMetric;
use super::factored_body::FactoredBody;
use super::run::Run;
use super::volumes::volumes;
use crate::inequality::Augmentation;
use crate::linalg::vector::norm;
use crate::linalg::{LinearOperator, SymmetricMatrix, Workspace};
use crate::model::Model;
use crate::model::counters::timed;
use crate::model::evaluate::Evaluation;
use crate::model::prescribed::Motion;
use crate::model::tangent::Tangent;
use crate::precond::coarse_schur::CoarseSchur;
use crate::precond::volume_modes::VolumeModes;
use crate::prepare::{ApproximateInverse, TaylorHoodData};
pub(crate) use dual::{DualFailure, Wanted};
use geometric::GeometricStiffness;
use inverse::inverse;
pub(crate) use step::Step;
pub(crate) use stiffness::Accuracy;

/// One quadratic program.
pub(crate) struct QuadraticProgram<'a> {
    /// The body, its interfaces and the tolerance.
    model: Model<'a>,
    /// A and B about the state; none for a linear body, whose operators are prepared.
    tangent: Option<Tangent>,
    /// The approximate inverse in use.
    inverse: Arc<ApproximateInverse>,
    /// What supports move in this program `[displacement unknowns]`; none where they
    /// stand still.
    motion: Option<Motion>,
    /// Residuals after the prescribed motion of the supports.
    now: Evaluation,
    /// What loads and contacts take off the stiffness.
    geometric: GeometricStiffness,
    /// What contact pressure makes of the stiffness, cancelled where the gaps hold.
    augmentation: Option<Augmentation>,
    /// The body by a factor; none while iterations are cheaper.
    factored: Option<Arc<FactoredBody>>,
    /// Whether it was made for this program.
    has_fresh_factor: bool,
    /// Metric of the multipliers at this linearisation.
    metric: ContactMetric,
    /// Metric of the internal pressure of a thin body; none where its mass is all.
    coarse: Option<CoarseSchur<'a>>,
    /// Norm of the force that counts as one, non-dimensional.
    force_scale: f64,
}

impl<'a> QuadraticProgram<'a> {
    /// The program about the present state, whose residuals are `now`, with `motion` of
    /// its supports; `first_force` grows with what that motion asks for.
    pub(crate) fn new(
        run: &mut Run<'a>,
        now: &Evaluation,
        motion: Option<Motion>,
        first_force: &mut f64,
    ) -> Self {
        let tangent = timed(&mut run.counters.seconds.assemble, || {
            let linearised = &mut run.learned.linearised;
            Tangent::new(&run.model, run.state, linearised, run.work)
        });
        let inverse = inverse(run, tangent.as_ref());
        let geometric = timed(&mut run.counters.seconds.contact, || {
            GeometricStiffness::of(&run.model, run.state, now)
        });
        let now = match (&tangent, &motion) {
            (Some(tangent), Some(motion)) => {
                let rows = geometric.rows.as_ref().unwrap_or(&now.coupling);
                let mut moved = tangent.after(motion, (&run.model, run.state), now, run.work);
                motion.move_gaps(rows, &mut moved.gap, run.work);
                moved
            }
            _ => now.clone(),
        };
        *first_force = first_force.max(norm(&now.force));
        let start = std::time::Instant::now();
        let volumes = volumes_of(run, &inverse, tangent.as_ref());
        let coarse = coarse_schur(run.model.prepared, volumes.as_ref(), run.work);
        let metric = ContactMetric::new(&run.model, &inverse, volumes, &now, run.work);
        run.counters.applications += metric.applications;
        let expected = metric.predicted_load(&now, run.state, run.work);
        let augmentation = augmentation::augmentation(&run.model, run.state);
        run.counters.seconds.contact += start.elapsed().as_secs_f64();
        Self {
            model: run.model.clone(),
            force_scale: now.force_scale(*first_force).max(expected),
            geometric,
            augmentation,
            factored: None,
            has_fresh_factor: false,
            metric,
            coarse,
            tangent,
            inverse,
            motion,
            now,
        }
    }

    /// Norm of the force that counts as one, the contact load that the metric expects among
    /// what is.
    pub(crate) fn force_scale(&self) -> f64 {
        self.force_scale
    }

    /// Metric of the multipliers at this linearisation `[multipliers, multipliers]`; without
    /// rows where the method reads weights alone.
    pub(crate) fn metric(&self) -> &dyn SymmetricMatrix {
        match &self.factored {
            Some(body) => &body.compliance,
            None => &*self.metric.matrix,
        }
    }

    /// Residuals that the program starts from.
    pub(crate) fn start(&self) -> &Evaluation {
        &self.now
    }

    /// A of the program `[displacement, displacement]`, without the curvature of
    /// contact.
    fn stiffness(&self) -> &dyn LinearOperator {
        match &self.tangent {
            Some(tangent) => &tangent.stiffness,
            None => &self.model.prepared.stiffness,
        }
    }
}

/// The metric of the internal pressure of a thin body whose coarse pressures are `volumes`.
fn coarse_schur<'a>(
    prepared: &'a TaylorHoodData,
    volumes: Option<&VolumeModes>,
    work: &mut Workspace,
) -> Option<CoarseSchur<'a>> {
    let (block, volumes) = (prepared.pressure.as_ref()?, volumes?);
    let is_thin = block.coarse.is_thin;
    is_thin.then(|| CoarseSchur::new(&block.metric, volumes, work))
}

/// The volume modes of the metric, of the linearised divergence.
fn volumes_of(
    run: &mut Run<'_>,
    inverse: &ApproximateInverse,
    tangent: Option<&Tangent>,
) -> Option<VolumeModes> {
    let fixed = run.model.prepared.pressure.as_ref();
    let fixed = fixed.map(|block| &block.coupling as &dyn LinearOperator);
    let divergence = tangent.map(|t| &t.coupling as &dyn LinearOperator);
    volumes(&run.model, (inverse, divergence.or(fixed)), run.work)
}

/// The numeric constants of this room.
pub(crate) fn constants() -> Vec<crate::constants::Constant> {
    [
        augmentation::own_constants(),
        by_factor::own_constants(),
        contact_edges::own_constants(),
        dual::own_constants(),
        dual_start::own_constants(),
        factorised::own_constants(),
        penalised::own_constants(),
        rigid_modes::own_constants(),
        solve::own_constants(),
        stiffness::own_constants(),
    ]
    .concat()
}
