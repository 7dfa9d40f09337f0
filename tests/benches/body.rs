//! The body that benches measure.

use std::sync::Arc;

#[path = "../common/meshes.rs"]
#[allow(dead_code)]
mod meshes;

use signorini::assembly::grid::{Grid, GridSource};
use signorini::assembly::p1_stiffness::{P1Blocks, StiffCells};
use signorini::assembly::{CellGeometry, CellModuli};
use signorini::linalg::Held;
use signorini::scene::{Formulation, Material, MaterialModel, Modulus, Profile, Support, Traction};
use signorini::space::TaylorHood;
use signorini::{GroupKind, Mesh, Scene};

/// The cube, incompressible, held at x0.
pub(crate) struct Body {
    /// N^3 cells of six tetrahedra.
    pub(crate) mesh: Arc<Mesh>,
    /// P2 displacement, P1 pressure.
    pub(crate) space: TaylorHood,
    /// Volumes and gradients.
    pub(crate) geometry: CellGeometry,
    /// A shear modulus of one.
    pub(crate) moduli: CellModuli,
    /// Unknowns on x0, ascending.
    pub(crate) held: Held,
}

impl Body {
    /// That of `cells`^3 cells.
    pub(crate) fn new(cells: usize) -> Self {
        let mesh = meshes::mesh(meshes::cube(cells));
        let (space, geometry) = (TaylorHood::new(&mesh), CellGeometry::new(&mesh, 1.0));
        let count = geometry.cells();
        let moduli = CellModuli {
            shear: vec![1.0; count],
            lame: vec![0.0; count],
            augmented: vec![0.0; count],
            inverse_lame: vec![0.0; count],
        };
        let held = held_at_x0(&mesh, &space);
        Self {
            mesh,
            space,
            geometry,
            moduli,
            held,
        }
    }

    /// Its cells for products.
    pub(crate) fn grid(&self) -> Grid {
        Grid::new(GridSource {
            mesh: &self.mesh,
            space: &self.space,
            geometry: &self.geometry,
            moduli: &self.moduli,
            held: &self.held,
        })
    }

    /// Its cells for matrices.
    pub(crate) fn cells(&self) -> StiffCells<'_> {
        StiffCells {
            mesh: &self.mesh,
            space: &self.space,
            geometry: &self.geometry,
            stiffness: &self.moduli,
        }
    }

    /// A on P1.
    pub(crate) fn p1(&self) -> P1Blocks {
        self.cells().p1_blocks(0.0)
    }
}

/// Unknowns of the nodes on x0, ascending.
fn held_at_x0(mesh: &Mesh, space: &TaylorHood) -> Held {
    let members = mesh
        .group("x0", GroupKind::Facets)
        .map(|group| group.members.clone());
    let facets = members.unwrap_or_default();
    let nodes = facets
        .iter()
        .flat_map(|&facet| space.facet_nodes(mesh.facet(facet as usize)));
    let mut held: Vec<u32> = nodes
        .flat_map(|node| (0..3).map(move |i| 3 * node + i))
        .collect();
    held.sort_unstable();
    held.dedup();
    Held::of_entries(3, held)
}

/// Held at x0, pulled down at x1.
pub(crate) fn bent_cube() -> Scene {
    let model = MaterialModel::LinearElastic {
        modulus: Modulus::Shear(1.0),
        poisson_ratio: 0.5,
        formulation: Formulation::Auto,
    };
    let group = "body".to_owned();
    Scene {
        materials: vec![Material { group, model }],
        supports: vec![Support {
            name: "wall".to_owned(),
            on: vec!["x0".to_owned()],
            normal: None,
            displacement: [Some(0.0); 3],
            profile: Profile::Constant,
            values: None,
            load: Default::default(),
        }],
        tractions: vec![Traction {
            on: vec!["x1".to_owned()],
            value: [0.0, 0.0, -1.0],
            ..Traction::default()
        }],
        ..Scene::default()
    }
}
