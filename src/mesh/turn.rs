//! Cells whose vertices are numbered the other way round: turned where the mesh is whole,
//! refused where they lie over their neighbours.
//!
//! Two cells of a whole mesh see their common facet from opposite sides. With measures that
//! are all positive the sides follow from the numbering, so that a fold needs no geometry.
//! Cost: one pass over the cells; where some were turned one hash a facet besides.

use std::collections::HashMap;

use super::cell::CellKind;
use super::check::refuse_cells;
use super::corners_of;
use super::error::{CellFault, MeshError};

/// Gives all cells a positive measure; which ones were turned, empty where none was.
pub(super) fn turn(kind: CellKind, coordinates: &[[f64; 3]], cells: &mut [u32]) -> Vec<bool> {
    let width = kind.vertices();
    let mut turned = Vec::new();
    let count = cells.len() / width;
    for (index, cell) in cells.chunks_exact_mut(width).enumerate() {
        if kind.signed_measure(&corners_of(coordinates, cell)) < 0.0 {
            cell.swap(width - 2, width - 1);
            turned.resize(count, false);
            turned[index] = true;
        }
    }
    turned
}

/// Refuses turned cells that lie over a neighbour: their vertices are where they should not
/// be. Facets belong to two cells at most.
///
/// # Errors
/// [`CellFault::Inverted`] with the cells that were turned beside a fold.
pub(super) fn refuse_folds(
    kind: CellKind,
    cells: &[u32],
    turned: &[bool],
) -> Result<(), MeshError> {
    if turned.is_empty() {
        return Ok(());
    }
    let width = kind.vertices();
    let mut seen: HashMap<Vec<u32>, (bool, usize)> = HashMap::new();
    let mut folded = vec![false; turned.len()];
    for (index, cell) in cells.chunks_exact(width).enumerate() {
        for opposite in 0..width {
            let (facet, side) = facet(cell, opposite);
            if let Some((other, neighbour)) = seen.insert(facet, (side, index))
                && other == side
            {
                folded[index] |= turned[index] || !turned[neighbour];
                folded[neighbour] |= turned[neighbour];
            }
        }
    }
    refuse_cells(CellFault::Inverted, folded.into_iter())
}

/// The facet opposite to a vertex, ascending, and the side from which the cell sees it.
fn facet(cell: &[u32], opposite: usize) -> (Vec<u32>, bool) {
    let mut facet: Vec<u32> = cell.to_vec();
    facet.remove(opposite);
    let mut side = opposite.is_multiple_of(2);
    for i in 0..facet.len() {
        for j in i + 1..facet.len() {
            side ^= facet[i] > facet[j];
        }
    }
    facet.sort_unstable();
    (facet, side)
}

/// A sentence about cells that were turned.
pub(super) fn warning(turned: &[bool]) -> Option<String> {
    match turned.iter().filter(|&&turned| turned).count() {
        0 => None,
        1 => Some("1 cell is numbered the other way round and is turned".to_owned()),
        count => Some(format!(
            "{count} cells are numbered the other way round and are turned"
        )),
    }
}
