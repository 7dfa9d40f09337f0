//! The surface of a mesh: the facets that one cell alone has.
//!
//! Cost: one sort of the facets of all cells.

use super::raw::{Block, ElementKind};
use super::split::{Simplices, picked};

/// Name of the cells where a file names none.
pub(crate) const BODY: &str = "body";
/// Name of the surface where a file names no part of it.
pub(crate) const BOUNDARY: &str = "boundary";

/// Node numbers of the facets that one cell alone has, flat, as many a facet as
/// `dimension`; in ascending order of their sorted nodes. Cells that are no simplices are split.
pub(crate) fn outer_facets(blocks: &[Block], dimension: usize) -> Vec<u64> {
    let simplex = ElementKind {
        dimension,
        nodes: dimension + 1,
    };
    let mut facets: Vec<[u64; 6]> = Vec::new();
    for block in blocks.iter().filter(|b| b.kind.dimension == dimension) {
        for cell in block.nodes.chunks_exact(block.kind.nodes) {
            for part in Simplices::of(block.kind, cell).iter() {
                let all = simplex.faces().iter();
                facets.extend(all.map(|local| keyed(part, local)));
            }
        }
    }
    facets.sort_unstable();
    let alone = facets
        .chunk_by(|a, b| a.first_chunk::<3>() == b.first_chunk::<3>())
        .filter(|same| same.len() == 1);
    let nodes = alone.flatten().flat_map(|facet| facet.iter().skip(3));
    let kept = nodes.enumerate().filter(|(at, _)| at % 3 < dimension);
    kept.map(|(_, node)| *node).collect()
}

/// The sorted nodes of a facet, then its nodes; a segment fills up with the largest number.
fn keyed(cell: &[u64], local: &[usize]) -> [u64; 6] {
    let [a, b, c, _] = picked(cell, local);
    let mut sorted = [a, b, c];
    sorted.sort_unstable();
    let [low, middle, high] = sorted;
    [low, middle, high, a, b, c]
}

#[cfg(test)]
mod tests {
    use super::super::raw::{ElementKind, Owner};
    use super::*;

    #[test]
    fn the_shared_edge_of_two_triangles_is_inside() {
        let block = Block {
            kind: ElementKind {
                dimension: 2,
                nodes: 3,
            },
            owner: Owner::Physical(0),
            nodes: vec![1, 2, 3, 2, 4, 3],
        };
        let edges = outer_facets(&[block], 2);
        assert_eq!(edges, [1, 2, 3, 1, 2, 4, 4, 3]);
    }
}
