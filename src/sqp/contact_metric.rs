//! The metric of the contact pressure that the plan chose.
//!
//! The compliance belongs to a linearisation. Mass and fractional metric belong to
//! the surface: made once in a session, scaled at each linearisation by power
//! iteration so that H >= C A^-1 C^T about.

use super::constraints::Interface;
use super::evaluate::{Context, Evaluation};
use super::state::State;
use crate::contact::surface_metric::{add_laplacian, add_mass};
use crate::inequality::metric::{POWER_STEPS, largest_ratio};
use crate::inequality::{MetricKind, dense_qp};
use crate::linalg::vector::{norm, scale};
use crate::linalg::{DenseCholesky, DenseMatrix, LinearOperator, SparseRows, Workspace};
use crate::mesh::Mesh;
use crate::plan::{Approximation, Plan};
use crate::precond::compliance::{ComplianceParts, compliance};
use crate::precond::fractional::fractional;
use crate::precond::p1::Traces;

/// What the power iteration may miss of the compliance's largest ratio: without it
/// fixed steps diverge on a compressible block.
const MARGIN: f64 = 1.5;

/// What a metric takes from the undeformed surfaces; empty where the plan needs
/// none of it.
#[derive(Debug, Default)]
pub(crate) struct SurfaceMetric {
    /// Block by block, up to a factor.
    matrix: DenseMatrix,
    /// int phi_i dS.
    weights: Vec<f64>,
}

impl SurfaceMetric {
    pub(crate) fn new(plan: &Plan, mesh: &Mesh, list: &[Interface]) -> Self {
        let (method, kind) = (plan.contact.method, plan.contact.metric);
        let mut surface = Self::default();
        if method.reads_weights() {
            let weights = list.iter().flat_map(|interface| &interface.surface.weights);
            surface.weights = weights.copied().collect();
        }
        let size: usize = list.iter().map(|i| i.surface.multipliers()).sum();
        match kind {
            MetricKind::Mass if method.needs_dense(kind) => {
                surface.matrix = DenseMatrix::zeros(size, size);
                for interface in list {
                    add_mass(&interface.surface, interface.offset, &mut surface.matrix);
                }
            }
            MetricKind::Fractional => {
                surface.matrix = DenseMatrix::zeros(size, size);
                for interface in list {
                    surface.add_fractional(plan, mesh, interface);
                }
            }
            MetricKind::Compliance | MetricKind::Mass => (),
        }
        surface
    }

    /// The block of one surface. It stays zero, which no factor accepts, where the
    /// surface has no area.
    fn add_fractional(&mut self, plan: &Plan, mesh: &Mesh, interface: &Interface) {
        let surface = &interface.surface;
        let size = surface.multipliers();
        let mut mass = DenseMatrix::zeros(size, size);
        add_mass(surface, 0, &mut mass);
        let mut laplacian = DenseMatrix::zeros(size, size);
        let coordinates = plan.units.coordinate_scale;
        add_laplacian(surface, mesh, coordinates, 0, &mut laplacian);
        let area: f64 = surface.weights.iter().sum();
        let extent = match plan.units.extents {
            2 => area * area,
            _ => area,
        };
        let Ok(block) = fractional(&mass, laplacian, extent) else {
            return;
        };
        for j in 0..size {
            let column = self.matrix.column_mut(interface.offset + j);
            column[interface.range()].copy_from_slice(block.column(j));
        }
    }
}

/// The metric at one linearisation.
pub(super) struct ContactMetric {
    /// H; without rows where the method reads the weights alone.
    pub(super) matrix: DenseMatrix,
    /// Scaled lumped mass; empty where the method does not read it.
    pub(super) weights: Vec<f64>,
    /// Applications of the displacement preconditioner that it took.
    pub(super) applications: u32,
}

impl ContactMetric {
    pub(super) fn new(
        context: &Context<'_>,
        inverse: &Approximation,
        now: &Evaluation,
        work: &mut Workspace,
    ) -> Self {
        let surface = &context.interfaces.metric;
        let mut metric = Self {
            matrix: match context.plan.contact.metric {
                MetricKind::Compliance => compliance_of(context, inverse, &now.coupling),
                MetricKind::Mass | MetricKind::Fractional => surface.matrix.clone(),
            },
            weights: surface.weights.clone(),
            applications: 0,
        };
        metric.scale_weights(inverse, &now.coupling, work);
        let is_scaled = context.plan.contact.metric == MetricKind::Compliance
            && !context.plan.contact.method.has_fixed_steps();
        if !is_scaled {
            metric.scale_matrix(context, inverse, &now.coupling, work);
        }
        metric
    }

    fn scale_weights(
        &mut self,
        inverse: &Approximation,
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
        context: &Context<'_>,
        inverse: &Approximation,
        coupling: &SparseRows,
        work: &mut Workspace,
    ) {
        let factor = match DenseCholesky::new(&self.matrix) {
            Ok(factor) if self.matrix.rows() > 0 => factor,
            Ok(_) | Err(_) => return,
        };
        let solve = |x: &mut [f64]| factor.solve(x);
        let displacement = &*inverse.displacement;
        let ratio = largest_ratio(displacement, coupling, &solve, work);
        self.applications += POWER_STEPS as u32;
        let margin = match context.plan.contact.metric {
            // Its worst mode is not the smooth one that the iteration starts from.
            MetricKind::Compliance => MARGIN,
            MetricKind::Mass | MetricKind::Fractional => 1.0,
        };
        self.matrix.scale(margin * ratio);
    }

    /// Norm of the contact load that the metric predicts; the scale of the force
    /// residual before any contact pressure is there.
    pub(super) fn expected_contact_norm(
        &self,
        now: &Evaluation,
        state: &State,
        work: &mut Workspace,
    ) -> f64 {
        if self.matrix.rows() == now.gap.len() {
            return expected_contact_norm(&self.matrix, now, state, work);
        }
        let entries = now.gap.iter().zip(&state.multiplier).zip(&self.weights);
        let multiplier: Vec<f64> = entries.map(|((g, l), w)| (l - g / w).max(0.0)).collect();
        contact_norm(&multiplier, now, state, work)
    }
}

/// Norm of the contact load that the dense problem in `metric` predicts.
pub(super) fn expected_contact_norm(
    metric: &DenseMatrix,
    now: &Evaluation,
    state: &State,
    work: &mut Workspace,
) -> f64 {
    let mut linear = vec![0.0; now.gap.len()];
    metric.multiply(&state.multiplier, &mut linear);
    linear
        .iter_mut()
        .zip(&now.gap)
        .for_each(|(q, gap)| *q = gap - *q);
    match dense_qp::solve(metric, &linear, &state.active) {
        Ok(solution) => contact_norm(&solution.values, now, state, work),
        Err(_) => 0.0,
    }
}

fn contact_norm(multiplier: &[f64], now: &Evaluation, state: &State, work: &mut Workspace) -> f64 {
    let mut load = vec![0.0; state.displacement.len()];
    now.coupling.apply_transposed(multiplier, &mut load, work);
    norm(&load)
}

fn compliance_of(
    context: &Context<'_>,
    inverse: &Approximation,
    coupling: &SparseRows,
) -> DenseMatrix {
    let parts = ComplianceParts {
        vertex_inverse: &inverse.compliance,
        traces: Traces {
            vertices: &context.plan.contact_vertices,
            directions: &inverse.contact_normals,
        },
        node_blocks: &inverse.node_blocks,
        vertex_count: context.prepared.space.vertices,
    };
    compliance(&parts, coupling)
}
