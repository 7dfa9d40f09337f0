//! Edges, facets and their cells, from the connectivity alone.
//!
//! One walk over the vertices, each with the cells around it, finds both. Cost:
//! n cells take time n log(valence) and, for the walk, 12 or 16 bytes per cell
//! and four per vertex; that is less than the edges of the cells, which come
//! after it, so that nothing is held beyond the results in the end.

use super::buckets::Buckets;
use super::cell::CellKind;
use super::edges::{EdgeCollector, edges_of_cells};
use super::facets::{FacetMatcher, Matched};

/// What the connectivity says.
#[derive(Debug)]
pub(super) struct Topology {
    /// Edges as (low, high) vertex pairs in lexicographic order.
    pub(super) edges: Vec<[u32; 2]>,
    /// Which cells share which facets, and which facets lie on the surface.
    pub(super) facets: Matched,
}

/// Finds edges and facets of `cells`, flat `[cells, 3 | 4]` with entries below
/// `vertex_count`, and the cells behind the uploaded `facets`, flat `[facets, 2 | 3]`.
pub(super) fn connect(
    kind: CellKind,
    cells: &[u32],
    facets: &[u32],
    vertex_count: usize,
) -> Topology {
    match kind {
        CellKind::Triangle => walk(kind, cells.as_chunks::<3>().0, facets, vertex_count),
        CellKind::Tetrahedron => walk(kind, cells.as_chunks::<4>().0, facets, vertex_count),
    }
}

/// Edge of each local edge, flat `[cells, 3 | 6]`; `edges` are those of [`connect`].
pub(super) fn cell_edges(
    kind: CellKind,
    cells: &[u32],
    edges: &[[u32; 2]],
    vertex_count: usize,
) -> Vec<u32> {
    match kind {
        CellKind::Triangle => edges_of_cells(kind, cells.as_chunks::<3>().0, edges, vertex_count),
        CellKind::Tetrahedron => {
            edges_of_cells(kind, cells.as_chunks::<4>().0, edges, vertex_count)
        }
    }
}

/// Walks the vertices in ascending order and matches the edges and facets whose lowest
/// vertex is the present one. Cost: linear but for small sorts around each vertex.
fn walk<const WIDTH: usize>(
    kind: CellKind,
    cells: &[[u32; WIDTH]],
    facets: &[u32],
    vertex_count: usize,
) -> Topology {
    let places = Buckets::new(vertex_count, cells.as_flattened().iter().copied());
    let mut edges = EdgeCollector::new(vertex_count, cells.len());
    let mut facets = FacetMatcher::new(kind, cells, facets);
    for (vertex, number) in (0..vertex_count).zip(0..) {
        let around = places.group(vertex).iter();
        let around = around.map(|place| place / WIDTH as u32);
        facets.add(number, around.clone());
        edges.add(number, around.map(|cell| &cells[cell as usize]));
    }
    Topology {
        edges: edges.finish(),
        facets: facets.finish(),
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::super::facets::FacetParent;
    use super::*;

    /// Two tetrahedra over the common facet (1, 2, 3).
    const PAIR: [u32; 8] = [0, 1, 2, 3, 4, 3, 2, 1];

    fn pair(facets: &[u32]) -> Topology {
        connect(CellKind::Tetrahedron, &PAIR, facets, 5)
    }

    #[test]
    fn edges_are_unique_and_in_lexicographic_order() {
        let expected = [
            [0, 1],
            [0, 2],
            [0, 3],
            [1, 2],
            [1, 3],
            [1, 4],
            [2, 3],
            [2, 4],
            [3, 4],
        ];
        assert_eq!(pair(&[]).edges, expected);
    }

    #[test]
    fn cell_edges_join_the_local_pairs() {
        let kind = CellKind::Tetrahedron;
        let edges = pair(&[]).edges;
        let of_cells = cell_edges(kind, &PAIR, &edges, 5);
        for (cell, of_cell) in PAIR.chunks(4).zip(of_cells.chunks(6)) {
            for (&edge, &(first, second)) in of_cell.iter().zip(kind.edges()) {
                let wanted = BTreeSet::from([cell[first], cell[second]]);
                assert_eq!(BTreeSet::from(edges[edge as usize]), wanted);
            }
        }
    }

    /// `count` triangles that all have vertex 0; each has one edge of its own.
    fn wheel(count: u32) -> Vec<u32> {
        let cell = |spoke| [spoke + 2, 0, spoke + 1];
        (0..count).flat_map(cell).collect()
    }

    #[test]
    fn hubs_have_their_edges_too() {
        let (kind, cells) = (CellKind::Triangle, wheel(200));
        let edges = connect(kind, &cells, &[], 202).edges;
        let expected: BTreeSet<[u32; 2]> = (1..202)
            .map(|end| [0, end])
            .chain((1..201).map(|end| [end, end + 1]))
            .collect();
        assert_eq!(edges, Vec::from_iter(expected));
        let of_cells = cell_edges(kind, &cells, &edges, 202);
        for (cell, of_cell) in cells.chunks(3).zip(of_cells.chunks(3)) {
            assert_eq!(edges[of_cell[0] as usize], [0, cell[0]]);
            assert_eq!(edges[of_cell[1] as usize], [cell[2], cell[0]]);
            assert_eq!(edges[of_cell[2] as usize], [0, cell[2]]);
        }
    }

    #[test]
    fn shared_facet_belongs_to_the_lowest_cell_and_is_interior() {
        let asked = [1, 2, 3, 3, 1, 2, 2, 1, 3, 4, 1, 3, 0, 1, 4];
        let parents = pair(&[&asked[..], &[u32::MAX; 3]].concat()).facets.parents;
        let parent = |cell, opposite, is_boundary| {
            Some(FacetParent {
                cell,
                opposite,
                is_boundary,
            })
        };
        assert_eq!(parents[..3], [parent(0, 0, false); 3]);
        assert_eq!(parents[3..], [parent(1, 2, true), None, None]);
    }

    #[test]
    fn boundary_is_what_one_cell_has() {
        assert_eq!(pair(&[]).facets.boundary.len(), 6);
        let lines = connect(CellKind::Triangle, &[0, 1, 2, 1, 3, 2], &[], 4);
        assert_eq!(lines.facets.boundary.len(), 4);
    }

    #[test]
    fn duplicates_are_found_in_any_vertex_order() {
        let cells = [0, 1, 2, 3, 4, 3, 2, 1, 2, 0, 1, 3];
        let facets = connect(CellKind::Tetrahedron, &cells, &[], 5).facets;
        assert_eq!(Vec::from_iter(facets.duplicates.iter()), [2]);
        assert_eq!(pair(&[]).facets.duplicates.count(), 0);
    }

    #[test]
    fn duplicates_are_found_in_a_crowd() {
        // Five cells at the edge (0, 1); the last two repeat the second and the first.
        let fan = [0, 1, 2, 1, 0, 3, 0, 1, 4, 3, 1, 0, 0, 1, 2];
        let facets = connect(CellKind::Triangle, &fan, &[1, 0], 5).facets;
        assert_eq!(Vec::from_iter(facets.duplicates.iter()), [3, 4]);
        assert_eq!(Vec::from_iter(facets.crowded.iter()), [2, 3, 4]);
        assert!(facets.parents[0].is_some_and(|one| one.cell == 0 && !one.is_boundary));
    }

    #[test]
    fn third_cell_at_a_facet_is_found() {
        let fan = [0, 1, 2, 1, 0, 3, 0, 1, 4];
        let facets = connect(CellKind::Triangle, &fan, &[], 5).facets;
        assert_eq!(Vec::from_iter(facets.crowded.iter()), [2]);
        assert_eq!(facets.duplicates.count(), 0);
    }
}
