//! The metric of the contact pressure that the plan chose.
//!
//! The compliance belongs to a linearisation. Mass and fractional metric belong to
//! the surface: made once in a session, scaled at each linearisation by power
//! iteration so that H >= C A^-1 C^T about.

use super::volumes::edge_ends;
use crate::inequality::dense_cone;
use crate::inequality::metric::{POWER_STEPS, largest_ratio};
use crate::linalg::vector::{norm, scale};
use crate::linalg::{
    DenseCholesky, LinearOperator, SparseRows, SparseRowsBuilder, SymmetricMatrix, Workspace,
};
use crate::model::Model;
use crate::model::evaluate::Evaluation;
use crate::model::state::State;
use crate::precond::compliance::{Compliance, ComplianceParts, EVENLY, OF_DISPLACEMENT, OF_MIXED};
use crate::precond::p1::Traces;
use crate::precond::volume_modes::VolumeModes;
use crate::prepare::ApproximateInverse;
use crate::saddle::SharedModes;
use crate::scene::MetricKind;

constants! {
    /// What the power iteration may miss of the compliance's largest ratio: without it
    /// fixed steps diverge on a compressible block.
    const MARGIN: f64 = 1.5;
    /// Share of a volume's mode that contact has to take up for both pressures to be solved
    /// together: that of a volume with other free surfaces is left to the metrics, which counts
    /// say is better.
    const ENCLOSED: f64 = 0.9;
    /// That of a stretch of a thin body, whose volume has neighbours to go to.
    const THIN: f64 = 0.3;
}

/// The metric at one linearisation.
pub(crate) struct ContactMetric {
    /// H; without rows where the method reads the weights alone.
    pub(crate) matrix: Box<dyn SymmetricMatrix>,
    /// Scaled lumped mass; empty where the method does not read it.
    pub(crate) weights: Vec<f64>,
    /// Modes that contact shares with the internal pressure; none where it shares none.
    pub(crate) shared: Option<SharedModes>,
    /// Applications of the displacement preconditioner that it took.
    pub(crate) applications: u32,
}

impl ContactMetric {
    /// The metric that the plan asks for, about the present linearisation; methods that
    /// step in weights have them scaled by a power iteration.
    pub(crate) fn new(
        model: &Model<'_>,
        inverse: &ApproximateInverse,
        volumes: Option<VolumeModes>,
        now: &Evaluation,
        work: &mut Workspace,
    ) -> Self {
        let surface = &model.interfaces.metric;
        let (matrix, shared): (Box<dyn SymmetricMatrix>, _) =
            match model.plan.decisions.contact.metric {
                MetricKind::Compliance => {
                    let matrix = compliance_of(model, (inverse, volumes.as_ref()), &now.coupling);
                    let shared = volumes.map(|volumes| shared(model, volumes, &matrix));
                    (Box::new(matrix), shared)
                }
                MetricKind::Mass | MetricKind::Fractional => {
                    (Box::new(surface.matrix.clone()), None)
                }
            };
        let mut metric = Self {
            matrix,
            shared,
            weights: surface.weights.clone(),
            applications: 0,
        };
        metric.scale_weights(inverse, &now.coupling, work);
        let is_scaled = model.plan.decisions.contact.metric == MetricKind::Compliance
            && !model.plan.decisions.contact.method.has_fixed_steps();
        if !is_scaled {
            metric.scale_matrix(model, inverse, &now.coupling, work);
        }
        metric
    }

    /// Scales the weights so that the largest eigenvalue of the compliance in them is
    /// one. Cost: five applications of the displacement preconditioner.
    fn scale_weights(
        &mut self,
        inverse: &ApproximateInverse,
        coupling: &SparseRows,
        work: &mut Workspace,
    ) {
        if self.weights.is_empty() {
            return;
        }
        let weights = &self.weights;
        let divide = |x: &mut [f64]| x.iter_mut().zip(weights).for_each(|(x, w)| *x /= w);
        let displacement = &*inverse.displacement;
        let ratio = largest_ratio(displacement, coupling, &divide, work);
        self.applications += POWER_STEPS as u32;
        scale(&mut self.weights, ratio);
    }

    /// Leaves a matrix that is not positive definite as it is: the method refuses it.
    fn scale_matrix(
        &mut self,
        model: &Model<'_>,
        inverse: &ApproximateInverse,
        coupling: &SparseRows,
        work: &mut Workspace,
    ) {
        let mut matrix = self.matrix.dense();
        let factor = match DenseCholesky::new(&matrix) {
            Ok(factor) if matrix.rows() > 0 => factor,
            Ok(_) | Err(_) => return,
        };
        let solve = |x: &mut [f64]| factor.solve(x);
        let displacement = &*inverse.displacement;
        let ratio = largest_ratio(displacement, coupling, &solve, work);
        self.applications += POWER_STEPS as u32;
        let margin = match model.plan.decisions.contact.metric {
            // Its worst mode is not the smooth one that the iteration starts from.
            MetricKind::Compliance => MARGIN,
            MetricKind::Mass | MetricKind::Fractional => 1.0,
        };
        matrix.scale(margin * ratio);
        self.matrix = Box::new(matrix);
    }

    /// Norm of the contact load that the metric predicts: the scale of the force residual before
    /// any contact pressure is there.
    pub(crate) fn predicted_load(
        &self,
        now: &Evaluation,
        state: &State,
        work: &mut Workspace,
    ) -> f64 {
        let is_known = now.friction.is_some() && state.multiplier.iter().any(|&l| l != 0.0);
        if is_known {
            // Its own load is the scale, and the dense problem is dear.
            return 0.0;
        }
        if self.matrix.size() == now.gap.len() {
            return predicted_load(&*self.matrix, now, state, work);
        }
        let entries = now.gap.iter().zip(&state.multiplier).zip(&self.weights);
        let mut multiplier: Vec<f64> = entries.map(|((g, l), w)| l - g / w).collect();
        now.contact_set().project(&mut multiplier);
        contact_norm(&multiplier, now, state, work)
    }
}

/// Norm of the contact load that the dense problem in `metric` predicts.
pub(crate) fn predicted_load(
    metric: &dyn SymmetricMatrix,
    now: &Evaluation,
    state: &State,
    work: &mut Workspace,
) -> f64 {
    let mut linear = vec![0.0; now.gap.len()];
    metric.product(&state.multiplier, &mut linear);
    linear
        .iter_mut()
        .zip(&now.gap)
        .for_each(|(q, gap)| *q = gap - *q);
    let near = (&state.status[..], &state.multiplier[..]);
    match dense_cone::solve(metric, &linear, now.contact_set(), near) {
        Ok(solution) => contact_norm(&solution.values, now, state, work),
        Err(_) => 0.0,
    }
}

/// Norm of the force that those multipliers exert on the body, non-dimensional.
fn contact_norm(multiplier: &[f64], now: &Evaluation, state: &State, work: &mut Workspace) -> f64 {
    let mut load = vec![0.0; state.displacement.len()];
    now.coupling.apply_transposed(multiplier, &mut load, work);
    norm(&load)
}

/// The approximate compliance C A^-1 C^T of all multipliers, from the inverse at the
/// contact vertices and the node blocks of the edges.
fn compliance_of(
    model: &Model<'_>,
    (inverse, volumes): (&ApproximateInverse, Option<&VolumeModes>),
    coupling: &SparseRows,
) -> Compliance {
    let parts = ComplianceParts {
        vertex_inverse: &inverse.compliance,
        traces: Traces {
            vertices: &inverse.traces.vertices,
            directions: &inverse.traces.directions,
        },
        node_blocks: &inverse.node_blocks,
        vertex_count: model.prepared.space.vertices,
        edge_ends: edge_ends(model),
        is_held: &model.prepared.is_held,
        volumes,
        scale: scale_of(model),
    };
    Compliance::new(&parts, coupling)
}

/// s of a body.
fn scale_of(model: &Model<'_>) -> f64 {
    match model.prepared.pressure {
        Some(_) => OF_MIXED,
        None => OF_DISPLACEMENT,
    }
}

/// How much a body gives under an even pressure, over what the compliance says; one for other
/// metrics.
pub(crate) fn evenly(model: &Model<'_>) -> f64 {
    match model.plan.decisions.contact.metric {
        MetricKind::Compliance => EVENLY / scale_of(model),
        MetricKind::Mass | MetricKind::Fractional => 1.0,
    }
}

/// The volumes as contact shares them with the internal pressure.
fn shared(model: &Model<'_>, volumes: VolumeModes, matrix: &Compliance) -> SharedModes {
    let block = model.prepared.pressure.as_ref();
    SharedModes {
        alike: on_multipliers(model, &volumes.pressures),
        own: matrix.seen().clone(),
        first: volumes.pressures,
        work: volumes.work,
        least_share: if block.is_some_and(|block| block.coarse.is_thin) {
            THIN
        } else {
            ENCLOSED
        },
    }
}

/// Internal pressures `[modes, pressures]` where the multipliers act `[modes, multipliers]`.
fn on_multipliers(model: &Model<'_>, patterns: &SparseRows) -> SparseRows {
    let mut builder = SparseRowsBuilder::new(model.plan.unknowns().contact as usize);
    let mut pressures = vec![0.0; patterns.columns()];
    for mode in 0..patterns.rows() {
        pressures.fill(0.0);
        patterns.add_row(mode, 1.0, &mut pressures);
        builder.push_dense(&at_multipliers(model, &pressures), 0.0);
    }
    builder.finish()
}

/// Internal pressures `[pressures]` where the multipliers act `[multipliers]`.
fn at_multipliers(model: &Model<'_>, pressures: &[f64]) -> Vec<f64> {
    let space = &model.prepared.space;
    let at = |node: u32| match (node as usize).checked_sub(space.vertices) {
        None => pressures[node as usize],
        Some(edge) => {
            let [a, b] = space.edges[edge].map(|end| pressures[end as usize]);
            0.5 * (a + b)
        }
    };
    let mut all = vec![0.0; model.plan.unknowns().contact as usize];
    for interface in &model.interfaces.list {
        for (function, &node) in (0..).zip(&interface.surface.carriers) {
            for (multiplier, _) in interface.surface.shares.of(function) {
                let place = interface.multipliers[multiplier as usize] as usize;
                if let Some(value) = all.get_mut(place) {
                    *value = at(node);
                }
            }
        }
    }
    all
}
