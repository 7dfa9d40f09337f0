//! Refinement of a mesh by bisection of marked cells, and what the refined mesh inherits.
//!
//! ```text
//! cell of edge (a, b)  ->  two cells over m = (x_a + x_b) / 2 + o_ab        until no vertex hangs
//! ```
//!
//! Meshes are nested: P2 displacements, P1 pressures, quadratic contact pressures and curved cells
//! are those of the earlier mesh, on more cells ([`Lineage`]). Groups keep their members' halves.
//! Cells of one ancestor fall into a bounded number of similarity classes, so that their quality
//! does not fall with the number of refinements as long as one [`Hierarchy`] is refined: it knows
//! the next bisections of its cells. Vertices keep their numbers, new ones
//! follow; cells are in the order of their ancestors. Nothing depends on the number of threads.
//!
//! Units: lengths of the mesh. Reference: D. N. Arnold, A. Mukherjee, L. Pouly, SIAM J. Sci.
//! Comput. 22 (2000); decision 69. Cost: a pass over the cells a generation of the closure, then a
//! new [`Mesh`], which costs more.
//!
//! | file | what it does |
//! |---|---|
//! | `marks` | which edge is halved next |
//! | `edges`, `closure`, `surface` | edges, cells and facets under bisection |
//! | `lineage` | fields on the refined mesh |
//! | `carried` | the state of a session on the refined mesh |

pub(crate) mod carried;
mod closure;
mod edges;
mod error;
mod lineage;
mod marks;
mod surface;

use std::sync::Arc;

pub use error::RefinementError;
pub use lineage::Lineage;
pub use surface::FacetOrigin;

use crate::mesh::{CellKind, EdgeOffset, Group, GroupKind, Mesh, MeshParts};
use closure::{Closure, Leaf};
use edges::Edges;
use marks::{Longest, Marks};
use surface::{Piece, pieces};

/// Most cells of a mesh: what the numbers of its edges leave room for.
const MOST_CELLS: usize = i32::MAX as usize / 6;

/// How far a refinement may go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Most cells of the refined mesh.
    pub cells: usize,
    /// Most bytes of the refined mesh, with what its making takes.
    pub bytes: u64,
}

impl Default for Limits {
    /// What indices can name.
    fn default() -> Self {
        Self {
            cells: MOST_CELLS,
            bytes: u64::MAX,
        }
    }
}

/// A mesh that knows the next bisections of its cells.
#[derive(Clone, Debug)]
pub struct Hierarchy {
    mesh: Arc<Mesh>,
    /// Next bisections of the cells `[cells]`.
    cells: Vec<Marks>,
    /// Ends of the edge that each facet is halved over first `[facets]`.
    facets: Vec<[u32; 2]>,
}

/// A refined mesh and where it comes from.
#[derive(Clone, Debug)]
pub struct Refined {
    /// The refined mesh, to be refined again.
    pub hierarchy: Hierarchy,
    /// What fields need to continue on it.
    pub lineage: Lineage,
}

impl Hierarchy {
    /// Of a mesh that has not been refined: cells are halved over their longest edges.
    pub fn new(mesh: Arc<Mesh>) -> Self {
        let longest = Longest(&mesh);
        let cells = (0..mesh.cell_count()).map(|cell| longest.of_cell(mesh.cell(cell)));
        let cells: Vec<Marks> = cells.collect();
        let facets = (0..mesh.facet_count()).map(|facet| facet_edge(&mesh, &cells, facet));
        Self {
            facets: facets.collect(),
            cells,
            mesh,
        }
    }

    /// The mesh.
    pub fn mesh(&self) -> &Arc<Mesh> {
        &self.mesh
    }

    /// Bisects each marked cell once, and others until no vertex hangs on an edge. In space the
    /// closure of marks that were not made for each other takes neighbours up to three generations:
    /// [`Hierarchy::halve`] makes more of that.
    ///
    /// # Errors
    /// [`RefinementError`]; the mesh stays as it is.
    pub fn refine(&self, marked: &[u32], limits: Limits) -> Result<Refined, RefinementError> {
        self.bisect(marked, 1, limits)
    }

    /// Halves the edges of each marked cell, by two bisections of triangles or three of tetrahedra,
    /// and bisects others until no vertex hangs on an edge. What is refined by whole halvings alone
    /// is nowhere finer than it is asked to be.
    ///
    /// # Errors
    /// As [`Hierarchy::refine`].
    pub fn halve(&self, marked: &[u32], limits: Limits) -> Result<Refined, RefinementError> {
        self.bisect(marked, self.mesh.cell_kind().dimension() as u16, limits)
    }

    fn bisect(
        &self,
        marked: &[u32],
        times: u16,
        limits: Limits,
    ) -> Result<Refined, RefinementError> {
        let count = self.mesh.cell_count();
        if let Some(&cell) = marked.iter().find(|&&cell| cell as usize >= count) {
            return Err(RefinementError::NoSuchCell { cell, count });
        }
        let limits = Limits {
            cells: limits.cells.min(MOST_CELLS),
            ..limits
        };
        let mut closure = Closure::new(&self.mesh, &self.cells, limits);
        closure.run(marked, times)?;
        let Closure {
            mut leaves, edges, ..
        } = closure;
        leaves.sort_by_key(|leaf| leaf.origin);
        self.finish(&leaves, edges)
    }

    /// The mesh of these cells, in the order of their ancestors.
    fn finish(&self, leaves: &[Leaf], edges: Edges<'_>) -> Result<Refined, RefinementError> {
        let whole = (0..self.mesh.facet_count()).map(|facet| {
            let vertices = self.mesh.facet(facet);
            Piece::whole(facet, vertices, self.facets[facet])
        });
        let facets = pieces(&self.mesh, whole.collect(), &edges);
        let (parts, offsets) = self.parts(leaves, &facets, &edges);
        let mesh = Mesh::nested(parts, offsets)?;
        let origins = facets.iter().enumerate();
        let origins = origins.map(|(facet, piece)| aligned(&mesh, facet, piece));
        let cells = leaves.iter().map(|leaf| leaf.origin).collect();
        let lineage = Lineage::new([&self.mesh, &mesh], edges, cells, origins.collect());
        let hierarchy = Self {
            cells: leaves.iter().map(|leaf| leaf.marks).collect(),
            facets: facets.iter().map(Piece::edge).collect(),
            mesh: Arc::new(mesh),
        };
        Ok(Refined { hierarchy, lineage })
    }

    /// The arrays of the refined mesh, and the offsets of its curved edges.
    fn parts(
        &self,
        leaves: &[Leaf],
        facets: &[Piece],
        edges: &Edges<'_>,
    ) -> (MeshParts, Vec<EdgeOffset>) {
        let kind = self.mesh.cell_kind();
        let [cell, facet] = [kind.vertices(), kind.facet_vertices()];
        let cells = leaves.iter().flat_map(|leaf| &leaf.vertices[..cell]);
        let lines = facets.iter().flat_map(|piece| &piece.vertices[..facet]);
        let offsets = Offsets::of(&self.mesh, edges);
        let of_cells: Vec<u32> = leaves.iter().map(|leaf| leaf.origin).collect();
        let of_facets: Vec<u32> = facets.iter().map(|piece| piece.origin.facet).collect();
        let group = |group: &Group| Group {
            members: match group.kind {
                GroupKind::Cells => descendants(&group.members, &of_cells),
                GroupKind::Facets => descendants(&group.members, &of_facets),
            },
            ..group.clone()
        };
        let parts = MeshParts {
            cell_kind: kind,
            coordinates: offsets.coordinates(&self.mesh, edges),
            cells: cells.copied().collect(),
            facets: lines.copied().collect(),
            groups: self.mesh.groups().iter().map(group).collect(),
        };
        (parts, offsets.list(&self.mesh, edges))
    }
}

/// The edge over which a facet is halved first, as the cell behind it says.
fn facet_edge(mesh: &Mesh, cells: &[Marks], facet: usize) -> [u32; 2] {
    let own = mesh.facet(facet);
    match mesh.cell_kind() {
        CellKind::Triangle => [own[0], own[1]],
        CellKind::Tetrahedron => {
            let (cell, opposite) = mesh.facet_cell(facet);
            let vertices = mesh.cell(cell);
            cells[cell].facets[opposite].map(|local| vertices[usize::from(local)])
        }
    }
}

/// Members whose ancestors are among `members`, each ancestor's in the place of that; `origins`
/// ascend.
fn descendants(members: &[u32], origins: &[u32]) -> Vec<u32> {
    let of_one = |&member: &u32| {
        let first = origins.partition_point(|&origin| origin < member);
        let last = origins.partition_point(|&origin| origin <= member);
        first as u32..last as u32
    };
    members.iter().flat_map(of_one).collect()
}

/// Where a facet of the refined mesh lies, its rows in the order in which the mesh has it.
fn aligned(mesh: &Mesh, facet: usize, piece: &Piece) -> FacetOrigin {
    let own = mesh.facet(facet);
    let mut origin = piece.origin;
    for (row, vertex) in origin.corners.iter_mut().zip(own) {
        let place = piece.vertices.iter().position(|other| other == vertex);
        *row = piece.origin.corners[place.unwrap_or(0)];
    }
    origin
}

/// Offsets of edges under bisection, flat `[edges][3]`; empty where all are lines.
struct Offsets(Vec<f64>);

impl Offsets {
    /// Those of a mesh and of its new edges.
    fn of(mesh: &Mesh, edges: &Edges<'_>) -> Self {
        if mesh.edge_offsets().is_empty() {
            return Self(Vec::new());
        }
        let own = (0..mesh.edges().len()).flat_map(|edge| mesh.offset_of(edge));
        Self(lineage::continued(&edges.recipes, own.collect(), 3))
    }

    /// That of an edge, by its number.
    fn at(&self, edge: u32) -> [f64; 3] {
        let own = self.0.get(3 * edge as usize..);
        own.and_then(|own| own.first_chunk())
            .copied()
            .unwrap_or_default()
    }

    /// Coordinates of the vertices, new ones last.
    fn coordinates(&self, mesh: &Mesh, edges: &Edges<'_>) -> Vec<[f64; 3]> {
        let mut points = mesh.coordinates().to_vec();
        for middle in &edges.middles {
            let [a, b] = middle.ends.map(|end| points[end as usize]);
            let offset = self.at(middle.edge);
            points.push(std::array::from_fn(|i| 0.5 * (a[i] + b[i]) + offset[i]));
        }
        points
    }

    /// Those of whole edges that are no lines, ascending by their ends.
    fn list(&self, mesh: &Mesh, edges: &Edges<'_>) -> Vec<EdgeOffset> {
        if self.0.is_empty() {
            return Vec::new();
        }
        let all = mesh.edges().iter().chain(&edges.ends).zip(0..);
        let whole = all.filter(|(_, number)| edges.is_whole(*number));
        let curved = whole.map(|(&ends, number)| EdgeOffset {
            ends,
            offset: self.at(number),
        });
        let mut list: Vec<EdgeOffset> = curved
            .filter(|one| one.offset.iter().any(|o| *o != 0.0))
            .collect();
        list.sort_unstable_by_key(|one| one.ends);
        list
    }
}

#[cfg(test)]
mod tests;
