//! A body of revolution at rest. Its stiffness has a part in the stretch around the
//! axis that no plane section has, so that its preconditioner is made from the tangent
//! at rest, as that of a deformed body is from its own.

use std::sync::Arc;

use crate::assembly::CellGeometry;
use crate::assembly::grid::Rows;
use crate::assembly::strain::{CellLaws, CellStates, CellTangents, Linearised, Mixed, StrainGrid};
use crate::linalg::vector::norm;
use crate::linalg::{Held, Workspace};
use crate::mesh::Mesh;
use crate::plan::Plan;
use crate::plan::augmentation::VOLUMETRIC;
use crate::prepare::Deformed;
use crate::space::TaylorHood;

/// Tangents of all cells at rest.
pub(crate) fn rings_at_rest(
    plan: &Plan,
    mesh: &Mesh,
    space: &TaylorHood,
    geometry: &CellGeometry,
) -> CellTangents {
    let laws = plan.laws_at_rest();
    let states = CellStates {
        mesh,
        space,
        geometry,
        laws: CellLaws {
            laws: &laws,
            of_cell: &plan.problem.resolved.cell_material,
        },
        displacement: &vec![0.0; space.displacement_unknowns()],
        pressure: &vec![0.0; space.vertices],
    };
    CellTangents::new(&states, VOLUMETRIC)
}

/// The cells about the undeformed state.
pub(crate) struct Rest {
    cells: Arc<StrainGrid>,
    at: Arc<Linearised>,
    displacement: Vec<f64>,
    pressure: Vec<f64>,
}

impl Rest {
    pub(crate) fn new(cells: Arc<StrainGrid>, space: &TaylorHood) -> Self {
        let displacement = vec![0.0; space.displacement_unknowns()];
        let pressure = vec![0.0; space.vertices];
        let mut at = Linearised::default();
        cells.linearise((&displacement, &pressure), &mut at, &mut Workspace::new());
        Self {
            cells,
            at: Arc::new(at),
            displacement,
            pressure,
        }
    }

    pub(crate) fn state(&self) -> Deformed<'_> {
        Deformed {
            cells: &self.cells,
            at: &self.at,
            displacement: &self.displacement,
            pressure: &self.pressure,
        }
    }

    /// Whether a constant pressure does no work on free entries.
    pub(crate) fn is_enclosed(&self, held: &Held) -> bool {
        let ones = vec![1.0; self.pressure.len()];
        let mut force = vec![0.0; self.displacement.len()];
        let mut volume = vec![0.0; ones.len()];
        self.cells.about(&self.at).apply(
            Rows::All,
            (&self.displacement, &ones),
            Mixed {
                displacement: &mut force,
                pressure: &mut volume,
            },
            &mut Workspace::new(),
        );
        let all = norm(&force);
        held.mask(&mut force);
        norm(&force) <= 1e-12 * all
    }
}
