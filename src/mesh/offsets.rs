//! Edges of the surface that are no straight lines: a second-order mesh says where the
//! middle of an edge is,
//!
//! ```text
//! x = sum L_v x_v + sum 4 L_a L_b o_e,   o_e = middle - (x_a + x_b) / 2
//! ```
//!
//! Only edges of the surface keep an offset, and only one that is more than rounding;
//! edges inside the body are lines, but for halves of curved cells ([`Mesh::nested`]). Cost: nothing on a mesh
//! without offsets, else one look-up a surface edge.

use super::bits::Bits;
use super::cell::CellKind;
use super::check::{OFF_PLANE, extent, first_and_count};
use super::error::{EdgeFault, MeshError};
use super::numbering::Numbering;
use super::topology::Topology;
use crate::element::curved_cell::MOST_EDGES;
use crate::geometry::vector3::{is_finite, norm, sub};
#[cfg(doc)]
use crate::mesh::Mesh;

/// Offset over the length of its edge below which the edge is a line.
const STRAIGHT: f64 = 1e-9;
/// Offset over the length of its edge at most: that of a half circle, and twice that of
/// a middle at a quarter of the edge.
const FARTHEST: f64 = 0.5;

/// The middle of an edge, relative to the mean of its ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeOffset {
    /// End vertices, the lower one first.
    pub ends: [u32; 2],
    /// Middle less the mean of the ends `[3]`, length.
    pub offset: [f64; 3],
}

/// Offsets of the edges of a cell with these `vertices` `[6][3]`, zero beyond those that it has;
/// `None` where all are lines. `offsets` ascend by their ends.
pub(super) fn of_cell(
    kind: CellKind,
    vertices: &[u32],
    offsets: &[EdgeOffset],
) -> Option<[[f64; 3]; MOST_EDGES]> {
    let mut own = [[0.0; 3]; MOST_EDGES];
    let mut is_curved = false;
    for (slot, &(a, b)) in own.iter_mut().zip(kind.edges()) {
        let (a, b) = (vertices[a], vertices[b]);
        let ends = [a.min(b), a.max(b)];
        if let Ok(place) = offsets.binary_search_by_key(&ends, |one| one.ends) {
            *slot = offsets[place].offset;
            is_curved = true;
        }
    }
    is_curved.then_some(own)
}

/// Refuses offsets that are not finite or not in the order of their edges.
pub(super) fn check_list(offsets: &[EdgeOffset], vertices: usize) -> Result<(), MeshError> {
    let ends = |one: &EdgeOffset| one.ends[0] < one.ends[1] && (one.ends[1] as usize) < vertices;
    let outside = offsets.iter().map(|one| !ends(one));
    refuse(EdgeFault::Detached, outside)?;
    let unordered = offsets.windows(2).map(|two| two[0].ends >= two[1].ends);
    refuse(
        EdgeFault::Unordered,
        std::iter::once(false).chain(unordered),
    )?;
    let infinite = offsets.iter().map(|one| !is_finite(one.offset));
    refuse(EdgeFault::NotFinite, infinite)
}

/// What becomes of offsets of edges inside the body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Inside {
    /// The edges are lines.
    LeftOut,
    /// They bend the cells as those of the surface do.
    Kept,
}

/// A mesh on its way, as far as offsets depend on it.
pub(super) struct Lines<'a> {
    /// Coordinates of the used vertices.
    pub(super) coordinates: &'a [[f64; 3]],
    /// Used vertices.
    pub(super) numbering: &'a Numbering,
    /// Edges and surface.
    pub(super) topology: &'a Topology,
    /// Whether the mesh lies in the plane z = 0.
    pub(super) is_plane: bool,
    /// What becomes of offsets inside the body.
    pub(super) inside: Inside,
}

impl Lines<'_> {
    /// The offsets that count, by used vertices, and a sentence about others.
    ///
    /// # Errors
    /// For an offset of no edge, out of the plane, or too long for its edge.
    pub(super) fn keep(
        &self,
        mut offsets: Vec<EdgeOffset>,
    ) -> Result<(Vec<EdgeOffset>, Option<String>), MeshError> {
        if offsets.is_empty() {
            return Ok((offsets, None));
        }
        for one in &mut offsets {
            one.ends = self.numbering.renumbered(one.ends);
        }
        let edges = offsets.iter().map(|one| self.edge(one.ends));
        let edges: Vec<Option<usize>> = edges.collect();
        refuse(EdgeFault::Detached, edges.iter().map(Option::is_none))?;
        self.check_size(&offsets)?;
        let all = offsets.len();
        if self.inside == Inside::LeftOut {
            let surface = self.surface();
            let mut on_surface = edges.iter().flatten().map(|&edge| surface.contains(edge));
            offsets.retain(|_| on_surface.next().unwrap_or(false));
        }
        let inside = all - offsets.len();
        let about = format!("{inside} offsets of edges inside the body are left out");
        offsets.retain(|one| norm(one.offset) > STRAIGHT * self.length(one.ends));
        Ok((offsets, (inside > 0).then_some(about)))
    }

    /// Refuses offsets that leave the plane or belong to another edge.
    fn check_size(&self, offsets: &[EdgeOffset]) -> Result<(), MeshError> {
        if self.is_plane {
            let allowed = OFF_PLANE * extent(self.coordinates);
            let leaves = |one: &EdgeOffset| one.offset[2].abs() > allowed;
            refuse(EdgeFault::OffPlane, offsets.iter().map(leaves))?;
        }
        let is_far = |one: &EdgeOffset| norm(one.offset) > FARTHEST * self.length(one.ends);
        refuse(EdgeFault::TooFar, offsets.iter().map(is_far))
    }

    /// The edge between two used vertices.
    fn edge(&self, ends: [u32; 2]) -> Option<usize> {
        self.topology.edges.binary_search(&ends).ok()
    }

    /// Distance of two used vertices.
    fn length(&self, [a, b]: [u32; 2]) -> f64 {
        norm(sub(
            self.coordinates[b as usize],
            self.coordinates[a as usize],
        ))
    }

    /// The edges of facets that one cell alone has.
    fn surface(&self) -> Bits {
        let mut surface = Bits::new(self.topology.edges.len());
        for facet in &self.topology.facets.boundary {
            let [a, b, c] = facet.vertices;
            for (a, b) in [(a, b), (b, c), (a, c)] {
                if let Some(edge) = self.edge([a.min(b), a.max(b)]) {
                    surface.insert(edge);
                }
            }
        }
        surface
    }
}

/// Refuses the offsets that the iterator calls faulty.
fn refuse(fault: EdgeFault, faulty: impl Iterator<Item = bool>) -> Result<(), MeshError> {
    match first_and_count(faulty) {
        Some((first, count)) => Err(MeshError::Edges {
            fault,
            first,
            count,
        }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Mesh, samples};

    fn offset(ends: [u32; 2], offset: [f64; 3]) -> EdgeOffset {
        EdgeOffset { ends, offset }
    }

    /// Two triangles; the edge (0, 3) is inside.
    fn square(offsets: Vec<EdgeOffset>) -> Result<Mesh, MeshError> {
        Mesh::second_order(samples::rectangle_parts(1, 1), offsets)
    }

    fn fault(offsets: Vec<EdgeOffset>) -> (EdgeFault, usize) {
        match square(offsets) {
            Err(MeshError::Edges { fault, first, .. }) => (fault, first),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn edges_of_the_surface_keep_what_is_more_than_rounding() {
        let low = offset([0, 1], [0.0, -0.1, 0.0]);
        let mesh = square(vec![
            low,
            offset([0, 2], [1e-10, 0.0, 0.0]),
            offset([0, 3], [0.1, 0.0, 0.0]),
        ]);
        let mesh = mesh.expect("a valid mesh");
        assert_eq!(mesh.edge_offsets(), [low]);
        assert_eq!(mesh.offset_between(1, 0), Some(low.offset));
        assert_eq!(mesh.offset_between(0, 3), None);
        assert!(mesh.warnings()[0].starts_with("1 offsets of edges inside"));
    }

    #[test]
    fn a_middle_at_a_quarter_of_its_edge_is_allowed() {
        let mesh = square(vec![offset([0, 1], [-0.25, 0.0, 0.0])]);
        assert_eq!(mesh.expect("a valid mesh").edge_offsets().len(), 1);
    }

    #[test]
    fn vertices_of_no_cell_do_not_move_the_edges() {
        let mut parts = samples::rectangle_parts(1, 1);
        parts.coordinates.insert(0, [9.0; 3]);
        parts.cells.iter_mut().for_each(|vertex| *vertex += 1);
        parts.facets.iter_mut().for_each(|vertex| *vertex += 1);
        let bent = vec![offset([1, 2], [0.0, -0.1, 0.0])];
        let mesh = Mesh::second_order(parts, bent).expect("a valid mesh");
        assert_eq!(mesh.edge_offsets()[0].ends, [0, 1]);
    }

    #[test]
    fn faulty_offsets_are_refused_by_name() {
        let good = offset([0, 1], [0.0, -0.1, 0.0]);
        let with = |other: EdgeOffset| fault(vec![good, other]);
        assert_eq!(with(good), (EdgeFault::Unordered, 1));
        assert_eq!(with(offset([1, 2], [0.1; 3])), (EdgeFault::Detached, 1));
        assert_eq!(with(offset([3, 1], [0.1; 3])), (EdgeFault::Detached, 1));
        assert_eq!(with(offset([1, 9], [0.1; 3])), (EdgeFault::Detached, 1));
        let infinite = offset([0, 2], [f64::NAN, 0.0, 0.0]);
        assert_eq!(with(infinite), (EdgeFault::NotFinite, 1));
        let high = offset([0, 2], [0.0, 0.0, 0.1]);
        assert_eq!(with(high), (EdgeFault::OffPlane, 1));
        let far = offset([0, 2], [0.6, 0.0, 0.0]);
        assert_eq!(with(far), (EdgeFault::TooFar, 1));
    }
}
