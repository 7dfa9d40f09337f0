//! Curved edges that cells can bear: where offsets turn a cell inside out they are halved, cell
//! by cell, until its Jacobian is above a bound everywhere,
//!
//! ```text
//! det(I + grad o) >= LEAST   by its Bernstein coefficients
//! ```
//!
//! Boundary layers at concave walls are where it happens: a right-angled cell as long as A times
//! its height h turns over at an offset of h / A. A halved edge is that of both its cells. Cost:
//! nothing on straight meshes, else some 1000 flops a curved cell.

use super::cell::{CellKind, barycentric_gradients};
use super::offsets::{EdgeOffset, of_cell};
use super::{Mesh, corners_of};
use crate::element::curved_cell::CurvedCell;

/// Least Jacobian of a curved cell over that of the straight one; chosen, no scene measures it.
const LEAST: f64 = 0.05;
/// Halvings after which an edge counts as a line, its offset being 1/256 of the given one.
const HALVINGS: u32 = 8;

/// What the curved edges of a mesh bend.
pub(super) struct Bent<'a> {
    pub(super) kind: CellKind,
    pub(super) coordinates: &'a [[f64; 3]],
    /// Vertices of the cells, flat.
    pub(super) cells: &'a [u32],
}

impl Bent<'_> {
    /// Halves offsets until no cell is turned inside out; a sentence about it.
    pub(super) fn limit(&self, offsets: &mut [EdgeOffset]) -> Option<String> {
        if offsets.is_empty() {
            return None;
        }
        let mut halved = vec![false; offsets.len()];
        for _ in 0..HALVINGS {
            let folded = self.folded(offsets);
            if folded.is_empty() {
                break;
            }
            for &place in &folded {
                halved[place] = true;
                offsets[place].offset = offsets[place].offset.map(|o| 0.5 * o);
            }
        }
        for place in self.folded(offsets) {
            offsets[place].offset = [0.0; 3];
        }
        let count = halved.iter().filter(|one| **one).count();
        (count > 0).then(|| {
            format!("{count} curved edges would turn cells inside out and are straightened in part")
        })
    }

    /// Places of the offsets of cells whose Jacobian falls below the bound, each once.
    fn folded(&self, offsets: &[EdgeOffset]) -> Vec<usize> {
        let mut found = Vec::new();
        for cell in self.cells.chunks_exact(self.kind.vertices()) {
            let Some(own) = of_cell(self.kind, cell, offsets) else {
                continue;
            };
            let corners = corners_of(self.coordinates, cell);
            let gradients = barycentric_gradients(self.kind, &corners);
            let pairs = self.kind.edges();
            let curved = CurvedCell::new(&gradients[..cell.len()], pairs, own);
            // A bound that is no number counts as below.
            let is_fine = curved.least_measure() >= LEAST;
            if !is_fine {
                let ends = pairs
                    .iter()
                    .map(|&(a, b)| [cell[a].min(cell[b]), cell[a].max(cell[b])]);
                let places = ends.map(|ends| offsets.binary_search_by_key(&ends, |one| one.ends));
                found.extend(places.flatten());
            }
        }
        found.sort_unstable();
        found.dedup();
        found
    }
}

impl Mesh {
    /// The same mesh, under the same name, with other `offsets` of its edges: by used vertices,
    /// ascending. Those that turn cells inside out are halved.
    pub(crate) fn with_offsets(&self, mut offsets: Vec<EdgeOffset>) -> Self {
        let bent = Bent {
            kind: self.kind,
            coordinates: &self.coordinates,
            cells: &self.cells,
        };
        let about = bent.limit(&mut offsets);
        Self {
            offsets,
            warnings: self.warnings.iter().cloned().chain(about).collect(),
            ..self.clone()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::samples;

    fn offsets_of(mesh: &Mesh, size: f64) -> Vec<EdgeOffset> {
        let on_side = |ends: &&[u32; 2]| {
            ends.iter()
                .all(|&v| mesh.coordinates()[v as usize][1] < 1e-9)
        };
        let bend = |&ends: &[u32; 2]| EdgeOffset {
            ends,
            offset: [0.0, size, 0.0],
        };
        mesh.edges().iter().filter(on_side).map(bend).collect()
    }

    #[test]
    fn offsets_that_fit_stay_and_others_are_halved_until_they_do() {
        let mesh = Mesh::new(samples::rectangle_parts(4, 4)).expect("a valid mesh");
        let fine = mesh.with_offsets(offsets_of(&mesh, 0.03));
        assert_eq!(fine.edge_offsets(), offsets_of(&mesh, 0.03));
        let folded = mesh.with_offsets(offsets_of(&mesh, 0.12));
        assert!(
            folded
                .warnings()
                .iter()
                .any(|one| one.contains("inside out"))
        );
        for one in folded.edge_offsets() {
            assert!(one.offset[1] > 0.02 && one.offset[1] < 0.07, "{one:?}");
        }
    }
}
