//! Edges, facets and their cells, from the connectivity alone.
//!
//! Entities are sorted by vertices: a counting sort by the lowest vertex, then
//! a small sort in each bucket, so n cells cost about n log(valence) and no
//! hashing. The order of the results depends on the connectivity only.

use super::cell::CellKind;

/// Entries grouped by their lowest vertex, each group sorted.
struct Buckets<Entry> {
    /// Start of each vertex's group in `entries` `[vertices + 1]`.
    starts: Vec<usize>,
    entries: Vec<Entry>,
}

impl<Entry: Copy + Ord + Default> Buckets<Entry> {
    /// Sorts what `entries()` yields as (lowest vertex, entry); it is run twice.
    fn new<Source, Items>(vertex_count: usize, source: Source) -> Self
    where
        Source: Fn() -> Items,
        Items: Iterator<Item = (u32, Entry)>,
    {
        let mut starts = vec![0_usize; vertex_count + 1];
        for (vertex, _) in source() {
            starts[vertex as usize + 1] += 1;
        }
        for vertex in 0..vertex_count {
            starts[vertex + 1] += starts[vertex];
        }
        let mut next = starts.clone();
        let mut entries = vec![Entry::default(); starts[vertex_count]];
        for (vertex, entry) in source() {
            entries[next[vertex as usize]] = entry;
            next[vertex as usize] += 1;
        }
        for vertex in 0..vertex_count {
            entries[starts[vertex]..starts[vertex + 1]].sort_unstable();
        }
        Self { starts, entries }
    }

    fn group(&self, vertex: u32) -> &[Entry] {
        &self.entries[self.starts[vertex as usize]..self.starts[vertex as usize + 1]]
    }

    fn vertex_count(&self) -> u32 {
        (self.starts.len() - 1) as u32
    }
}

/// The unique edges of all cells.
#[derive(Debug)]
pub(crate) struct Edges {
    /// (low, high) vertex pairs in lexicographic order.
    pub(crate) pairs: Vec<[u32; 2]>,
    /// Edge of each local edge, flat `[cells, 3 | 6]`.
    pub(crate) of_cells: Vec<u32>,
}

/// Finds the edges of `cells`, flat `[cells, 3 | 4]` with entries below `vertex_count`.
pub(crate) fn edges(kind: CellKind, cells: &[u32], vertex_count: usize) -> Edges {
    let local = kind.edges();
    let source = || {
        let numbered = cells.chunks_exact(kind.vertices()).zip(0_u32..);
        numbered.flat_map(move |(cell, index)| {
            local
                .iter()
                .zip(0_u32..)
                .map(move |(&(first, second), slot)| {
                    let (low, high) = sorted_pair(cell[first], cell[second]);
                    // The slot rides below the vertex, so that sorting needs no second key.
                    (
                        low,
                        (
                            high,
                            u64::from(index) * local.len() as u64 + u64::from(slot),
                        ),
                    )
                })
        })
    };
    let buckets = Buckets::new(vertex_count, source);
    let mut pairs = Vec::new();
    let mut of_cells = vec![0; buckets.entries.len()];
    for low in 0..buckets.vertex_count() {
        let mut last = None;
        for &(high, slot) in buckets.group(low) {
            if last != Some(high) {
                pairs.push([low, high]);
                last = Some(high);
            }
            of_cells[slot as usize] = (pairs.len() - 1) as u32;
        }
    }
    pairs.shrink_to_fit();
    Edges { pairs, of_cells }
}

/// One facet of one cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
struct FacetEntry {
    /// The two higher vertices in ascending order; the first is 0 for lines.
    rest: [u32; 2],
    cell: u32,
    opposite: u8,
}

/// A facet of a cell, named by its opposite vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct FacetParent {
    /// The cell; the one with the lowest index where there are two.
    pub(crate) cell: u32,
    /// Local number of the cell's vertex that is not on the facet.
    pub(crate) opposite: u8,
    /// Whether the facet belongs to this cell only.
    pub(crate) is_boundary: bool,
}

/// All facets of all cells, sorted; dropped once a mesh is built.
pub(crate) struct FacetTable {
    kind: CellKind,
    buckets: Buckets<FacetEntry>,
}

impl FacetTable {
    /// From `cells`, flat `[cells, 3 | 4]` with entries below `vertex_count`.
    pub(crate) fn new(kind: CellKind, cells: &[u32], vertex_count: usize) -> Self {
        let source = || {
            let numbered = cells.chunks_exact(kind.vertices()).zip(0_u32..);
            numbered.flat_map(move |(vertices, cell)| {
                kind.facets()
                    .iter()
                    .zip(0_u8..)
                    .map(move |(facet, opposite)| {
                        let (lowest, rest) = facet_key(facet.iter().map(|&local| vertices[local]));
                        (
                            lowest,
                            FacetEntry {
                                rest,
                                cell,
                                opposite,
                            },
                        )
                    })
            })
        };
        Self {
            kind,
            buckets: Buckets::new(vertex_count, source),
        }
    }

    /// The cell at the facet with these vertices, in any order.
    pub(crate) fn parent(&self, vertices: &[u32]) -> Option<FacetParent> {
        let (lowest, rest) = facet_key(vertices.iter().copied());
        if lowest >= self.buckets.vertex_count() {
            return None;
        }
        let group = self.buckets.group(lowest);
        let first = group.partition_point(|entry| entry.rest < rest);
        let entry = group.get(first).filter(|entry| entry.rest == rest)?;
        let next = group.get(first + 1);
        Some(FacetParent {
            cell: entry.cell,
            opposite: entry.opposite,
            is_boundary: next.is_none_or(|next| next.rest != rest),
        })
    }

    /// Facets of exactly one cell as (lowest cell, opposite), sorted by vertices.
    pub(crate) fn boundary(&self) -> Vec<FacetParent> {
        let alone = self.facets().filter(|sharing| sharing.len() == 1);
        let parent = |sharing: &[FacetEntry]| FacetParent {
            cell: sharing[0].cell,
            opposite: sharing[0].opposite,
            is_boundary: true,
        };
        alone.map(parent).collect()
    }

    /// Cells with the vertices of a cell of lower index, ascending.
    pub(crate) fn duplicate_cells(&self, cells: &[u32]) -> Vec<u32> {
        let width = self.kind.vertices();
        let apex =
            |entry: &FacetEntry| cells[entry.cell as usize * width + usize::from(entry.opposite)];
        let mut found = Vec::new();
        for sharing in self.facets() {
            for (position, entry) in sharing.iter().enumerate().skip(1) {
                let earlier = &sharing[..position];
                if earlier.iter().any(|other| apex(other) == apex(entry)) {
                    found.push(entry.cell);
                }
            }
        }
        found.sort_unstable();
        found.dedup();
        found
    }

    /// Cells at facets of which two cells of lower index have a share, ascending.
    pub(crate) fn crowding_cells(&self) -> Vec<u32> {
        let crowds = self.facets().flat_map(|sharing| sharing.iter().skip(2));
        let mut found: Vec<u32> = crowds.map(|entry| entry.cell).collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    /// The cells' shares in each facet, facets sorted by vertices, shares by cell.
    fn facets(&self) -> impl Iterator<Item = &[FacetEntry]> {
        let groups = (0..self.buckets.vertex_count()).map(|vertex| self.buckets.group(vertex));
        groups.flat_map(|group| group.chunk_by(|first, second| first.rest == second.rest))
    }
}

/// Lowest vertex and the others in ascending order.
fn facet_key(mut vertices: impl Iterator<Item = u32>) -> (u32, [u32; 2]) {
    let mut next = || vertices.next().unwrap_or(0);
    let (first, second) = (next(), next());
    let (low, high) = sorted_pair(first, second);
    match vertices.next() {
        None => (low, [0, high]),
        Some(third) if third < low => (third, [low, high]),
        Some(third) => {
            let (middle, highest) = sorted_pair(high, third);
            (low, [middle, highest])
        }
    }
}

fn sorted_pair(first: u32, second: u32) -> (u32, u32) {
    (first.min(second), first.max(second))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// Two tetrahedra over the common facet (1, 2, 3).
    const PAIR: [u32; 8] = [0, 1, 2, 3, 4, 3, 2, 1];

    #[test]
    fn edges_are_unique_and_in_lexicographic_order() {
        let edges = edges(CellKind::Tetrahedron, &PAIR, 5);
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
        assert_eq!(edges.pairs, expected);
    }

    #[test]
    fn cell_edges_join_the_local_pairs() {
        let kind = CellKind::Tetrahedron;
        let edges = edges(kind, &PAIR, 5);
        for (cell, of_cell) in PAIR.chunks(4).zip(edges.of_cells.chunks(6)) {
            for (&edge, &(first, second)) in of_cell.iter().zip(kind.edges()) {
                let wanted = BTreeSet::from([cell[first], cell[second]]);
                assert_eq!(BTreeSet::from(edges.pairs[edge as usize]), wanted);
            }
        }
    }

    #[test]
    fn shared_facet_belongs_to_the_lowest_cell_and_is_interior() {
        let table = FacetTable::new(CellKind::Tetrahedron, &PAIR, 5);
        for order in [[1, 2, 3], [3, 1, 2], [2, 1, 3]] {
            let parent = table.parent(&order).expect("a facet of both cells");
            assert_eq!(
                (parent.cell, parent.opposite, parent.is_boundary),
                (0, 0, false)
            );
        }
        let outer = table
            .parent(&[4, 1, 3])
            .expect("a facet of the second cell");
        assert_eq!(
            (outer.cell, outer.opposite, outer.is_boundary),
            (1, 2, true)
        );
        assert!(table.parent(&[0, 1, 4]).is_none());
        assert!(table.parent(&[7, 8, 9]).is_none());
    }

    #[test]
    fn boundary_is_what_one_cell_has() {
        let table = FacetTable::new(CellKind::Tetrahedron, &PAIR, 5);
        assert_eq!(table.boundary().len(), 6);
        let lines = FacetTable::new(CellKind::Triangle, &[0, 1, 2, 1, 3, 2], 4);
        assert_eq!(lines.boundary().len(), 4);
    }

    #[test]
    fn duplicates_are_found_in_any_vertex_order() {
        let cells = [0, 1, 2, 3, 4, 3, 2, 1, 2, 0, 1, 3];
        let table = FacetTable::new(CellKind::Tetrahedron, &cells, 5);
        assert_eq!(table.duplicate_cells(&cells), [2]);
        let table = FacetTable::new(CellKind::Tetrahedron, &PAIR, 5);
        assert!(table.duplicate_cells(&PAIR).is_empty());
    }

    #[test]
    fn third_cell_at_a_facet_is_found() {
        let fan = [0, 1, 2, 1, 0, 3, 0, 1, 4];
        let table = FacetTable::new(CellKind::Triangle, &fan, 5);
        assert_eq!(table.crowding_cells(), [2]);
        assert!(table.duplicate_cells(&fan).is_empty());
    }
}
