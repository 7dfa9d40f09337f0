//! How soft a cell is for a volume constraint: the mean over its displacement
//! nodes of 1 / mu, mu at a node the mean of its cells by volume.
//!
//! The nodes of a soft cell between stiff ones move as little as theirs: in the
//! Schur complement B A^-1 B^T it counts as stiff, though its own 1 / mu is large.
//! On a homogeneous body this is 1 / mu. One pass over the cells.

use super::cells::{CellGeometry, CellModuli};
use crate::mesh::Mesh;
use crate::space::TaylorHood;

/// Mean of 1 / mu over the nodes of each cell `[cells]`.
pub fn softness(
    mesh: &Mesh,
    space: &TaylorHood,
    geometry: &CellGeometry,
    moduli: &CellModuli,
) -> Vec<f64> {
    let (vertices, edges) = (geometry.vertices, mesh.cell_kind().edges().len());
    let nodes_of = |cell: usize| {
        let corners = mesh.cells()[cell * vertices..(cell + 1) * vertices].iter();
        let middles = mesh.cell_edges()[cell * edges..(cell + 1) * edges].iter();
        corners
            .map(|&vertex| vertex as usize)
            .chain(middles.map(|&edge| space.vertices + edge as usize))
    };
    // Integral of mu and volume around each node.
    let mut around = vec![[0.0; 2]; space.nodes()];
    for cell in 0..geometry.cells() {
        let volume = geometry.volumes[cell];
        for node in nodes_of(cell) {
            around[node][0] += volume * moduli.shear[cell];
            around[node][1] += volume;
        }
    }
    let mean = |cell: usize| {
        let sum: f64 = nodes_of(cell)
            .map(|node| around[node][1] / around[node][0])
            .sum();
        sum / (vertices + edges) as f64
    };
    (0..geometry.cells()).map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::samples;

    fn softness_of(shear: impl Fn(usize) -> f64) -> Vec<f64> {
        let mesh = samples::cube(4);
        let space = TaylorHood::new(&mesh);
        let geometry = CellGeometry::new(&mesh, 1.0);
        let moduli = CellModuli {
            shear: (0..mesh.cell_count()).map(shear).collect(),
            ..CellModuli::default()
        };
        softness(&mesh, &space, &geometry, &moduli)
    }

    #[test]
    fn a_homogeneous_body_is_as_soft_as_its_material() {
        let found = softness_of(|_| 4.0);
        assert!(found.iter().all(|value| (value - 0.25).abs() < 1e-15));
    }

    #[test]
    fn a_soft_cell_among_stiff_ones_counts_as_stiff() {
        let found = softness_of(|cell| if cell == 150 { 1e-6 } else { 1.0 });
        assert!(found.iter().all(|&value| value < 2.0), "{}", found[150]);
        let half = softness_of(|cell| if cell < 192 { 1e-6 } else { 1.0 });
        let softest = half.iter().fold(0.0, |a: f64, &b| a.max(b));
        assert!((softest - 1e6).abs() < 1.0, "{softest}");
    }
}
