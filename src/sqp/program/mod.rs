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
mod factorised;
mod inverse;
mod loose;
mod penalised;
mod seams;
mod solve;
pub(crate) mod step;
mod stiffness;

use std::sync::Arc;

use super::contact_metric::ContactMetric;
use super::factored_body::FactoredBody;
use super::run::Run;
use super::volumes::volumes;
use crate::contact::{Advancing, Counterpart, curvature};
use crate::inequality::Augmentation;
use crate::linalg::vector::norm;
use crate::linalg::{LinearOperator, SparseRows, SymmetricMatrix, Workspace};
use crate::model::Model;
use crate::model::counters::timed;
use crate::model::drive::Drive;
use crate::model::evaluate::Evaluation;
use crate::model::interfaces::Interface;
use crate::model::pressures::pressure_tangent;
use crate::model::state::State;
use crate::model::tangent::Tangent;
use crate::precond::coarse_schur::CoarseSchur;
use crate::precond::volume_modes::VolumeModes;
use crate::prepare::{ApproximateInverse, TaylorHoodData};
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
    motion: Option<Vec<f64>>,
    /// Residuals behind the prescribed motion of the supports.
    now: Evaluation,
    /// What pressures that follow the body take off its stiffness.
    released: Option<SparseRows>,
    /// What the curvature of the gaps takes off, with `released`.
    curvature: Option<SparseRows>,
    /// Rows of the gaps and slips with the turning of tangents; none where none turn.
    turned: Option<SparseRows>,
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
        motion: Option<Vec<f64>>,
        first_force: &mut f64,
    ) -> Self {
        let tangent = timed(&mut run.counters.seconds.assemble, || {
            let linearised = &mut run.learned.linearised;
            Tangent::new(&run.model, run.state, linearised, run.work)
        });
        let inverse = inverse(run, tangent.as_ref());
        let now = match (&tangent, &motion) {
            (Some(tangent), Some(motion)) => {
                tangent.after(motion, (&run.model, run.state), now, run.work)
            }
            _ => now.clone(),
        };
        *first_force = first_force.max(norm(&now.force));
        let start = std::time::Instant::now();
        let prepared = run.model.prepared;
        let fixed = prepared
            .pressure
            .as_ref()
            .map(|block| &block.coupling as &dyn LinearOperator);
        let divergence = tangent
            .as_ref()
            .map(|t| &t.coupling as &dyn LinearOperator)
            .or(fixed);
        let volumes = volumes(&run.model, (&inverse, divergence), run.work);
        let coarse = coarse_schur(prepared, volumes.as_ref(), run.work);
        let metric = ContactMetric::new(&run.model, &inverse, volumes, &now, run.work);
        run.counters.applications += metric.applications;
        let expected = metric.predicted_load(&now, run.state, run.work);
        let released = released_of(&run.model, run.state);
        let turning = (run.model.interfaces.friction.as_ref())
            .and_then(|friction| friction.turning(&run.model, run.state))
            .map(|mut turning| {
                turning.rows = prepared.held.project_columns(turning.rows);
                turning.released = prepared.held.project_matrix(turning.released);
                turning
            });
        let terms = turning.as_ref().map(|turning| &turning.released);
        let terms = [released.as_ref(), terms];
        let curvature = curvature_of(&run.model, run.state, now.last_drive()).map(|own| {
            terms
                .into_iter()
                .flatten()
                .fold(own, |sum, term| sum.plus(term))
        });
        let turned = turning.map(|turning| now.coupling.plus(&turning.rows));
        let augmentation = augmentation::augmentation(&run.model, run.state);
        run.counters.seconds.contact += start.elapsed().as_secs_f64();
        Self {
            model: run.model.clone(),
            force_scale: now.force_scale(*first_force).max(expected),
            released,
            curvature,
            turned,
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

    /// All that loads and contacts take off the stiffness.
    fn released_by_all(&self) -> Option<&SparseRows> {
        self.curvature.as_ref().or(self.released.as_ref())
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

/// What pressures that follow the body and a pull to an earlier state take off the
/// stiffness; none where there is neither.
fn released_of(model: &Model<'_>, state: &State) -> Option<SparseRows> {
    let pressed = pressure_tangent(model, state);
    match (&model.conditions.proximal, pressed) {
        (Some(proximal), Some(pressed)) => Some(pressed.plus(&proximal.released())),
        (Some(proximal), None) => Some(proximal.released()),
        (None, pressed) => pressed,
    }
}

/// Curvature of the gaps of surfaces on what they meet, under the present contact pressure.
fn curvature_under<C: Counterpart>(
    model: &Model<'_>,
    state: &State,
    met: &[(&Interface, C)],
) -> SparseRows {
    let pressures = met.iter();
    let pressures = pressures.map(|(interface, _)| interface.own(&state.multiplier));
    let pressures: Vec<_> = pressures.collect();
    let surfaces = met.iter().zip(&pressures);
    let surfaces = surfaces.map(|((interface, met), own)| (&interface.surface, met, &own[..]));
    let surfaces: Vec<_> = surfaces.collect();
    let body = model.deformed(&state.displacement);
    curvature(&body, &surfaces, &model.prepared.is_held)
}

/// Curvature of the gaps under the present contact pressure, of tools that have moved on from
/// `last`; none where it vanishes.
fn curvature_of(model: &Model<'_>, state: &State, last: Option<&Drive>) -> Option<SparseRows> {
    let under_pressure = state.multiplier.iter().any(|&l| l != 0.0);
    if model.is_linear() || !under_pressure {
        return None;
    }
    let own = match last {
        None => {
            let placed: Vec<_> = model.placed(&state.drive).collect();
            curvature_under(model, state, &placed)
        }
        Some(last) => {
            let placed = model.placed_from(state, last);
            let tools = placed.iter().map(|(interface, now, before)| {
                let before = before.as_ref();
                (*interface, Advancing { now, before })
            });
            curvature_under(model, state, &tools.collect::<Vec<_>>())
        }
    };
    Some(model.prepared.held.project_matrix(own))
}
