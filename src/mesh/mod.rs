//! Meshes of tetrahedra or triangles: what a caller uploads, checked and numbered.
//!
//! A [`Mesh`] is immutable and addressed by its content ([`MeshId`]). Cells have
//! positive measure and straight sides but for edges of the surface, which may have an offset
//! ([`EdgeOffset`]). Two numberings of vertices live here:
//! the *uploaded* one, and the *used* one, which leaves out vertices that no
//! cell has and keeps the order of the others; `used_vertices` joins them.
//! Everything below but the counts and groups speaks the used numbering. Edges
//! are (low, high) pairs in lexicographic order, the same order in both.
//!
//! Shapes: coordinates `[vertices, 3]`; cells flat `[cells, 3 | 4]`; facets flat
//! `[facets, 2 | 3]`; cell edges flat `[cells, 3 | 6]`. Cost: n cells take
//! O(n log(valence)) time; building holds little more than the mesh itself, since
//! uploaded arrays are renumbered in place and temporaries make way for results.

mod anew;
mod bits;
mod buckets;
pub mod cell;
mod check;
mod curved_facet;
mod curving;
mod digest;
mod edges;
mod error;
mod facets;
pub mod locate;
mod numbering;
mod offsets;
pub mod quality;
mod topology;
mod turn;

use std::fmt;

pub use cell::{CellKind, barycentric_gradients};
pub use curved_facet::CurvedFacet;
pub use digest::MeshId;
pub use error::{CellFault, EdgeFault, FacetFault, GroupFault, MeshError};
pub use locate::{Located, Locator};
pub use offsets::EdgeOffset;
pub use quality::Quality;

use crate::element::curved_cell::MOST_EDGES;
use curving::Bent;
use facets::FacetParent;
use numbering::Numbering;
use offsets::{Inside, Lines};

/// What the members of a group are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum GroupKind {
    /// Triangles of a plane mesh, tetrahedra of a solid one.
    Cells,
    /// Lines of a plane mesh, surface triangles of a solid one.
    Facets,
}

impl fmt::Display for GroupKind {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Cells => "cell",
            Self::Facets => "facet",
        })
    }
}

/// A named set of cells or facets.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Group {
    /// Name of the group: not empty, unique among groups of its kind.
    pub name: String,
    /// What the members are: cells or facets.
    pub kind: GroupKind,
    /// 0-based indices of cells or of facets, each once.
    pub members: Vec<u32>,
}

/// The uploaded arrays, not yet checked.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshParts {
    /// Shape of all cells.
    pub cell_kind: CellKind,
    /// Coordinates `[vertices, 3]` in the caller's unit of length; z = 0 for triangles.
    pub coordinates: Vec<[f64; 3]>,
    /// Vertices of the cells, flat `[cells, 3 | 4]`, 0-based.
    pub cells: Vec<u32>,
    /// Vertices of tagged boundary lines or surface triangles, flat `[facets, 2 | 3]`.
    pub facets: Vec<u32>,
    /// Named sets of cells or facets, which scenes refer to.
    pub groups: Vec<Group>,
}

/// A facet of exactly one cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BoundaryFacet {
    /// Used vertices, oriented outwards; the third repeats the second in two dimensions.
    pub vertices: [u32; 3],
    /// The cell that the facet belongs to, 0-based.
    pub cell: u32,
    /// Local number of the cell's vertex that is not on the facet.
    pub opposite: u8,
}

/// A checked mesh.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// Digest of the uploaded arrays, which names the mesh.
    id: MeshId,
    /// Shape of all cells.
    kind: CellKind,
    /// Mean-ratio quality of the cells, minimum and mean.
    quality: Quality,
    /// Number of vertices as uploaded, used or not.
    uploaded_vertex_count: usize,
    /// Uploaded number of each used vertex, ascending `[vertices]`.
    used: Vec<u32>,
    /// Coordinates of the used vertices `[vertices][3]`, in the caller's unit of
    /// length.
    coordinates: Vec<[f64; 3]>,
    /// Vertices of the cells by their own numbers, flat `[cells, vertices of a cell]`.
    cells: Vec<u32>,
    /// End vertices of each edge, ascending and in lexicographic order `[edges]`.
    edges: Vec<[u32; 2]>,
    /// Edges of the cells, flat `[cells, edges of a cell]`.
    cell_edges: Vec<u32>,
    /// Vertices of the uploaded facets, flat `[facets, vertices of a facet]`.
    facets: Vec<u32>,
    /// Cell of each uploaded facet `[facets]`.
    facet_parents: Vec<FacetParent>,
    /// Facets that belong to one cell only, in the order of their lowest vertices.
    boundary: Vec<BoundaryFacet>,
    /// Offsets of the edges of the surface that are no lines, by their own numbers and
    /// in the order of the edges.
    offsets: Vec<EdgeOffset>,
    /// Named sets of cells or facets.
    groups: Vec<Group>,
    /// Sentences about what was dropped or looks doubtful, for the plan to show.
    warnings: Vec<String>,
}

impl Mesh {
    /// Checks and numbers the arrays.
    ///
    /// # Errors
    /// The first fault found, see [`MeshError`]; arrays of any content are safe.
    pub fn new(parts: MeshParts) -> Result<Self, MeshError> {
        Self::second_order(parts, Vec::new())
    }

    /// [`Mesh::new`] with the offsets of edges (uploaded vertices), ascending by their
    /// ends; those inside the body are left out.
    ///
    /// # Errors
    /// As [`Mesh::new`], and for offsets of no edge or longer than half their edge.
    pub fn second_order(parts: MeshParts, offsets: Vec<EdgeOffset>) -> Result<Self, MeshError> {
        Self::build(parts, offsets, Inside::LeftOut)
    }

    /// [`Mesh::second_order`] with all offsets: the halves of a curved cell have curved edges
    /// inside the body.
    ///
    /// # Errors
    /// As [`Mesh::second_order`].
    pub fn nested(parts: MeshParts, offsets: Vec<EdgeOffset>) -> Result<Self, MeshError> {
        Self::build(parts, offsets, Inside::Kept)
    }

    fn build(
        parts: MeshParts,
        offsets: Vec<EdgeOffset>,
        inside: Inside,
    ) -> Result<Self, MeshError> {
        check::check_arrays(&parts)?;
        offsets::check_list(&offsets, parts.coordinates.len())?;
        let id = digest::digest(&parts, &offsets, inside);
        let kind = parts.cell_kind;
        let uploaded_vertex_count = parts.coordinates.len();
        let numbering = Numbering::new(&parts.cells, uploaded_vertex_count);
        let coordinates = numbering.select(parts.coordinates);
        let mut cells = numbering.renumber(parts.cells);
        let facets = numbering.renumber(parts.facets);
        let turned = turn::turn(kind, &coordinates, &mut cells);
        let quality = check::check_shapes(kind, &coordinates, &cells, &numbering)?;
        let topology = topology::connect(kind, &cells, &facets, coordinates.len());
        check::refuse_listed(CellFault::Duplicate, &topology.facets.duplicates)?;
        check::refuse_listed(CellFault::CrowdedFacet, &topology.facets.crowded)?;
        turn::refuse_folds(kind, &cells, &turned)?;
        let lines = Lines {
            coordinates: &coordinates,
            numbering: &numbering,
            topology: &topology,
            is_plane: kind == CellKind::Triangle,
            inside,
        };
        let (mut offsets, about_offsets) = lines.keep(offsets)?;
        let bent = Bent {
            kind,
            coordinates: &coordinates,
            cells: &cells,
        };
        let about_folds = bent.limit(&mut offsets);
        let facet_parents = check::attached(topology.facets.parents)?;
        check::check_repeated_facets(kind, &parts.groups, &facet_parents, cells.len())?;
        Ok(Self {
            id,
            kind,
            quality,
            uploaded_vertex_count,
            cell_edges: topology::cell_edges(kind, &cells, &topology.edges, coordinates.len()),
            edges: topology.edges,
            facets: oriented(kind, &cells, &facet_parents, facets),
            boundary: topology.facets.boundary,
            warnings: numbering
                .warnings()
                .into_iter()
                .chain(about_offsets)
                .chain(about_folds)
                .chain(turn::warning(&turned))
                .collect(),
            offsets,
            used: numbering.into_used(),
            coordinates,
            cells,
            facet_parents,
            groups: parts.groups,
        })
    }

    /// Digest of the uploaded arrays.
    pub fn id(&self) -> MeshId {
        self.id
    }

    /// Shape of all cells.
    pub fn cell_kind(&self) -> CellKind {
        self.kind
    }

    /// Number of uploaded vertices, those that no cell uses included.
    pub fn vertex_count(&self) -> usize {
        self.uploaded_vertex_count
    }

    /// Number of cells.
    pub fn cell_count(&self) -> usize {
        self.cells.len() / self.kind.vertices()
    }

    /// Number of uploaded facets.
    pub fn facet_count(&self) -> usize {
        self.facet_parents.len()
    }

    /// All groups in upload order.
    pub fn groups(&self) -> &[Group] {
        &self.groups
    }

    /// The group of this name and kind.
    pub fn group(&self, name: &str, kind: GroupKind) -> Option<&Group> {
        let mut groups = self.groups.iter();
        groups.find(|group| group.kind == kind && group.name == name)
    }

    /// What a caller should know, such as vertices left out.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Coordinates of the used vertices `[used, 3]`, length.
    pub fn coordinates(&self) -> &[[f64; 3]] {
        &self.coordinates
    }

    /// Used vertices of the cells, flat `[cells, 3 | 4]`.
    pub fn cells(&self) -> &[u32] {
        &self.cells
    }

    /// Used vertices of one cell `[3 | 4]`.
    pub fn cell(&self, cell: usize) -> &[u32] {
        let width = self.kind.vertices();
        &self.cells[cell * width..(cell + 1) * width]
    }

    /// Corners of one cell; the fourth of a triangle is zero.
    pub fn corners(&self, cell: usize) -> [[f64; 3]; 4] {
        corners_of(&self.coordinates, self.cell(cell))
    }

    /// Edges as (low, high) used vertices in lexicographic order.
    pub fn edges(&self) -> &[[u32; 2]] {
        &self.edges
    }

    /// Edge of each local edge of [`CellKind::edges`], flat `[cells, 3 | 6]`.
    pub fn cell_edges(&self) -> &[u32] {
        &self.cell_edges
    }

    /// The edge between two used vertices, in either order.
    pub fn edge_between(&self, first: u32, second: u32) -> Option<u32> {
        let pair = [first.min(second), first.max(second)];
        let found = self.edges.binary_search(&pair);
        found.ok().map(|edge| edge as u32)
    }

    /// Offsets of the edges of the surface that are no lines, by used vertices,
    /// ascending.
    pub fn edge_offsets(&self) -> &[EdgeOffset] {
        &self.offsets
    }

    /// Offset of the middle of the edge between two used vertices, in either order;
    /// `None` where the edge is a line.
    pub fn offset_between(&self, first: u32, second: u32) -> Option<[f64; 3]> {
        let ends = [first.min(second), first.max(second)];
        let found = self.offsets.binary_search_by_key(&ends, |one| one.ends);
        found.ok().map(|place| self.offsets[place].offset)
    }

    /// Undeformed point of a cell at barycentric coordinates `[4]`, length.
    pub fn position_in(&self, cell: usize, barycentric: &[f64]) -> [f64; 3] {
        let corners = self.corners(cell);
        let mut point = [0.0; 3];
        for (corner, l) in corners.iter().zip(barycentric) {
            (0..3).for_each(|i| point[i] += l * corner[i]);
        }
        let edges = self.kind.edges().iter();
        let offsets = self.offsets_of_cell(cell).unwrap_or_default();
        for (&(a, b), offset) in edges.zip(offsets) {
            let share = 4.0 * barycentric[a] * barycentric[b];
            (0..3).for_each(|i| point[i] += share * offset[i]);
        }
        point
    }

    /// Offset of an edge by its number; zero where it is a line.
    pub fn offset_of(&self, edge: usize) -> [f64; 3] {
        match (self.offsets.is_empty(), self.edges.get(edge)) {
            (false, Some(&[a, b])) => self.offset_between(a, b).unwrap_or_default(),
            _ => [0.0; 3],
        }
    }

    /// Offsets of the edges of a cell `[6][3]`, zero beyond those that it has; `None` where all
    /// are lines.
    pub fn offsets_of_cell(&self, cell: usize) -> Option<[[f64; 3]; MOST_EDGES]> {
        offsets::of_cell(self.kind, self.cell(cell), &self.offsets)
    }

    /// Used vertices of the uploaded facets, flat `[facets, 2 | 3]`, oriented
    /// outwards from the facet's cell.
    pub fn facets(&self) -> &[u32] {
        &self.facets
    }

    /// Used vertices of one uploaded facet `[2 | 3]`.
    pub fn facet(&self, facet: usize) -> &[u32] {
        let width = self.kind.facet_vertices();
        &self.facets[facet * width..(facet + 1) * width]
    }

    /// The cell behind an uploaded facet, the lowest where there are two, and
    /// the local number of its vertex opposite the facet.
    pub fn facet_cell(&self, facet: usize) -> (usize, usize) {
        let parent = self.facet_parents[facet];
        (parent.cell as usize, usize::from(parent.opposite))
    }

    /// Whether an uploaded facet belongs to one cell only.
    pub fn facet_is_boundary(&self, facet: usize) -> bool {
        self.facet_parents[facet].is_boundary
    }

    /// The facets of exactly one cell, uploaded or not, sorted by vertices.
    pub fn boundary_facets(&self) -> &[BoundaryFacet] {
        &self.boundary
    }

    /// Uploaded number of each used vertex, ascending.
    pub fn used_vertices(&self) -> &[u32] {
        &self.used
    }

    /// Used number of an uploaded vertex; `None` if no cell uses it.
    pub fn used_vertex(&self, uploaded: u32) -> Option<u32> {
        let found = self.used.binary_search(&uploaded);
        found.ok().map(|used| used as u32)
    }

    /// Smallest and mean shape quality of the cells.
    pub fn quality(&self) -> Quality {
        self.quality
    }

    /// Longest side of the bounding box of the used vertices, length.
    pub fn extent(&self) -> f64 {
        check::extent(&self.coordinates)
    }

    /// Bytes held by the arrays.
    pub fn bytes(&self) -> u64 {
        let members = self
            .groups
            .iter()
            .map(|group| array_bytes(&group.members))
            .sum::<u64>();
        array_bytes(&self.used)
            + array_bytes(&self.coordinates)
            + array_bytes(&self.cells)
            + array_bytes(&self.edges)
            + array_bytes(&self.cell_edges)
            + array_bytes(&self.facets)
            + array_bytes(&self.facet_parents)
            + array_bytes(&self.boundary)
            + array_bytes(&self.offsets)
            + members
    }
}

/// Corners of one cell, padded to four with zeros, length.
fn corners_of(coordinates: &[[f64; 3]], cell: &[u32]) -> [[f64; 3]; 4] {
    let mut corners = [[0.0; 3]; 4];
    for (corner, &vertex) in corners.iter_mut().zip(cell) {
        *corner = coordinates[vertex as usize];
    }
    corners
}

/// The facets as their parents have them, oriented outwards, in the place of `facets`.
fn oriented(
    kind: CellKind,
    cells: &[u32],
    parents: &[FacetParent],
    mut facets: Vec<u32>,
) -> Vec<u32> {
    let rows = facets.chunks_exact_mut(kind.facet_vertices());
    for (facet, parent) in rows.zip(parents) {
        let cell = &cells[parent.cell as usize * kind.vertices()..];
        let local = kind.facets()[usize::from(parent.opposite)];
        for (vertex, &place) in facet.iter_mut().zip(local) {
            *vertex = cell[place];
        }
    }
    facets
}

/// Bytes that the entries of an array take.
fn array_bytes<T>(array: &[T]) -> u64 {
    size_of_val(array) as u64
}

#[cfg(test)]
pub(crate) mod samples;
#[cfg(test)]
mod tests;
