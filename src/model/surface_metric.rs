//! What metrics of the contact pressure take from the undeformed surfaces: mass and
//! fractional Laplacian, made once in a session.
//!
//! Shapes `[multipliers, multipliers]`, block by block. Cost: a dense eigenproblem for
//! the fractional metric, the entries for the mass.

use crate::contact::ContactSurface;
use crate::contact::surface_metric::{add_laplacian, add_mass};
use crate::linalg::DenseMatrix;
use crate::mesh::Mesh;
use crate::plan::Plan;
use crate::precond::fractional::fractional;
use crate::scene::MetricKind;

/// What a metric takes from the undeformed surfaces; empty where the plan needs
/// none of it.
#[derive(Clone, Debug, Default)]
pub(crate) struct SurfaceMetric {
    /// Surface matrix of all interfaces block by block `[multipliers, multipliers]`, up
    /// to a factor that the linearisation finds.
    pub(crate) matrix: DenseMatrix,
    /// Integral of each multiplier function over its undeformed surface
    /// `[multipliers]`, area of the scaled body.
    pub(crate) weights: Vec<f64>,
}

impl SurfaceMetric {
    /// Of surfaces with their multipliers among all.
    pub(crate) fn new(plan: &Plan, mesh: &Mesh, list: &[(&[u32], &ContactSurface)]) -> Self {
        let (method, kind) = (plan.decisions.contact.method, plan.decisions.contact.metric);
        let mut surface = Self::default();
        let size = plan.unknowns().contact as usize;
        if method.reads_weights() {
            surface.weights = vec![0.0; size];
            for &(places, one) in list {
                for (&place, weight) in places.iter().zip(&one.weights) {
                    surface.weights[place as usize] += weight;
                }
            }
        }
        match kind {
            MetricKind::Mass if method.needs_dense(kind) => {
                surface.matrix = DenseMatrix::zeros(size, size);
                for &(places, one) in list {
                    let size = one.multipliers();
                    let mut block = DenseMatrix::zeros(size, size);
                    add_mass(one, &mut block);
                    surface.add_block(places, &block);
                }
            }
            MetricKind::Fractional => {
                surface.matrix = DenseMatrix::zeros(size, size);
                for &one in list {
                    surface.add_fractional(plan, mesh, one);
                }
            }
            MetricKind::Compliance | MetricKind::Mass => (),
        }
        surface
    }

    /// The block of one surface. It stays zero, which no factor accepts, where the
    /// surface has no area.
    fn add_fractional(
        &mut self,
        plan: &Plan,
        mesh: &Mesh,
        (places, surface): (&[u32], &ContactSurface),
    ) {
        let size = surface.multipliers();
        let mut mass = DenseMatrix::zeros(size, size);
        add_mass(surface, &mut mass);
        let mut laplacian = DenseMatrix::zeros(size, size);
        let coordinates = plan.problem.units.coordinate_scale;
        add_laplacian(surface, mesh, coordinates, &mut laplacian);
        let area: f64 = surface.weights.iter().sum();
        let extent = match plan.problem.units.extents {
            2 => area * area,
            _ => area,
        };
        let Ok(block) = fractional(&mass, laplacian, extent) else {
            return;
        };
        self.add_block(places, &block);
    }

    /// Adds the block of the multipliers at those places.
    fn add_block(&mut self, places: &[u32], block: &DenseMatrix) {
        for (j, &column) in places.iter().enumerate() {
            let whole = self.matrix.column_mut(column as usize);
            for (&row, entry) in places.iter().zip(block.column(j)) {
                whole[row as usize] += entry;
            }
        }
    }
}
