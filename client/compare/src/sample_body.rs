//! Small bodies of several materials with scattered held unknowns, for the tests.

use std::sync::Arc;

use crate::meshes::{cube, irregular, mesh, square};
use signorini::Mesh;
use signorini::assembly::grid::{Basis, GridSource, VolumeTerm};
use signorini::assembly::p1_stiffness::StiffCells;
use signorini::assembly::{CellGeometry, CellModuli, Constrained, Grid, Stiffness};
use signorini::comparisons::SplitBody;
use signorini::linalg::cholesky::Precision;
use signorini::linalg::{Held, LinearOperator};
use signorini::precond::p1::{DirectP1, vertex_order};
use signorini::space::TaylorHood;

/// A body with everything that its operators are made of.
pub(crate) struct Body {
    pub(crate) mesh: Arc<Mesh>,
    pub(crate) space: TaylorHood,
    pub(crate) geometry: CellGeometry,
    pub(crate) moduli: CellModuli,
    pub(crate) held: Held,
    grid: Arc<Grid>,
}

/// One in space, larger than one block of the operator, and one in the plane.
pub(crate) fn bodies() -> [Body; 2] {
    [irregular(cube(7), 7), irregular(square(5), 5)].map(|parts| Body::of(mesh(parts)))
}

impl Body {
    fn of(mesh: Arc<Mesh>) -> Self {
        let space = TaylorHood::new(&mesh);
        let geometry = CellGeometry::new(&mesh, 0.5);
        let cells = 0..mesh.cell_count();
        let lame: Vec<f64> = cells.clone().map(|cell| 0.5 * (cell % 4) as f64).collect();
        let moduli = CellModuli {
            shear: cells.map(|cell| 1.0 + (cell % 3) as f64).collect(),
            augmented: lame.clone(),
            lame,
            inverse_lame: Vec::new(),
        };
        let unknowns = space.displacement_unknowns() as u32;
        let held: Vec<u32> = (0..unknowns).step_by(7).collect();
        let held = Held::of_entries(space.components, held);
        let grid = Arc::new(Grid::new(GridSource {
            mesh: &mesh,
            space: &space,
            geometry: &geometry,
            moduli: &moduli,
            held: &held,
        }));
        Self {
            mesh,
            space,
            geometry,
            moduli,
            held,
            grid,
        }
    }

    /// A in the hierarchical basis.
    pub(crate) fn stiffness(&self) -> Arc<dyn LinearOperator> {
        Arc::new(Constrained {
            free: Stiffness {
                grid: self.grid.clone(),
                basis: Basis::Hierarchical,
                volume: VolumeTerm::Own,
                size: self.space.displacement_unknowns(),
            },
            held: self.held.clone(),
        })
    }

    /// The body with the factor of its P1 block.
    pub(crate) fn split(&self) -> SplitBody<'_> {
        let cells = StiffCells {
            mesh: &self.mesh,
            space: &self.space,
            geometry: &self.geometry,
            stiffness: &self.moduli,
        };
        let blocks = cells.p1_blocks(0.0);
        let matrix = blocks.lower_columns(&self.space, &self.held.entries);
        let order = vertex_order(self.mesh.coordinates(), &self.space.edges, &[]);
        let components = self.space.components;
        let factor = DirectP1::new(&matrix, &order, components, Precision::Double);
        SplitBody {
            mesh: &self.mesh,
            geometry: &self.geometry,
            moduli: &self.moduli,
            held: &self.held,
            components,
            vertices: self.space.vertices,
            stiffness: self.stiffness(),
            p1: Arc::new(factor.expect("a positive definite block")),
        }
    }
}
