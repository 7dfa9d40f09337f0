//! Moves vectors between the hierarchical basis, Lagrange node values and P1:
//! with edge e between vertices a and b,
//!
//! ```text
//! values      u_e = c_e + (u_a + u_b) / 2        (hierarchical c to Lagrange u)
//! residuals   r_a = h_a - sum_e h_e / 2          (hierarchical h to Lagrange r)
//! restriction q_a = r_a + sum_e r_e / 2          (Lagrange r to P1 q)
//! ```
//!
//! Vectors hold vertices, then edges, `components` numbers each. Vertices gather
//! from their edges in ascending order, edges from their ends: parallel, with
//! bits that do not depend on the number of threads. Cost: one sweep each.

use std::sync::Arc;

use rayon::prelude::*;

/// Nodes per parallel piece.
const PIECE: usize = 2048;

/// The edges of a mesh with their incidence.
#[derive(Clone, Debug)]
pub struct Transfer {
    /// Number of vertices, whose unknowns come first.
    vertices: usize,
    /// Components of a node: 2 or 3.
    components: usize,
    /// End vertices of each edge `[edges]`, in the order of the unknowns.
    edges: Arc<[[u32; 2]]>,
    /// Where the edges of each vertex begin in `incident` `[vertices + 1]`.
    offsets: Vec<u32>,
    /// Edges at each vertex, ascending for each, so that sums keep one order.
    incident: Vec<u32>,
    /// Indices of held entries, ascending; they stay zero on every level.
    held: Arc<[u32]>,
}

impl Transfer {
    /// `edges` are the ends of each edge, `held` the ascending indices of held
    /// entries.
    pub fn new(
        vertices: usize,
        components: usize,
        edges: Arc<[[u32; 2]]>,
        held: Arc<[u32]>,
    ) -> Self {
        let mut offsets = vec![0_u32; vertices + 1];
        for end in edges.as_flattened() {
            offsets[*end as usize + 1] += 1;
        }
        for vertex in 0..vertices {
            offsets[vertex + 1] += offsets[vertex];
        }
        let mut next = offsets.clone();
        let mut incident = vec![0; 2 * edges.len()];
        for (edge, ends) in edges.iter().enumerate() {
            for &end in ends {
                let slot = &mut next[end as usize];
                incident[*slot as usize] = edge as u32;
                *slot += 1;
            }
        }
        Self {
            vertices,
            components,
            edges,
            offsets,
            incident,
            held,
        }
    }

    /// Length of a P1 vector.
    pub fn coarse_size(&self) -> usize {
        self.vertices * self.components
    }

    /// Indices of held entries, ascending.
    pub fn held(&self) -> &[u32] {
        &self.held
    }

    /// Bytes held, those shared with the space left out.
    pub fn bytes(&self) -> u64 {
        4 * (self.offsets.len() + self.incident.len()) as u64
    }

    /// Sets the held entries of `x` to zero; `x` may be shorter, for the vertices
    /// alone.
    fn mask(&self, x: &mut [f64]) {
        let inside = self
            .held
            .partition_point(|&index| (index as usize) < x.len());
        for &index in &self.held[..inside] {
            x[index as usize] = 0.0;
        }
    }

    /// Hierarchical residual to Lagrange residual, in place.
    pub fn residual_to_lagrange(&self, r: &mut [f64]) {
        let (vertices, edges) = r.split_at_mut(self.coarse_size());
        match self.components {
            2 => self.gather_edges::<2>(edges, vertices, -0.5),
            _ => self.gather_edges::<3>(edges, vertices, -0.5),
        }
        self.mask(r);
    }

    /// Lagrange values to hierarchical values, in place.
    pub fn values_to_hierarchical(&self, x: &mut [f64]) {
        let (vertices, edges) = x.split_at_mut(self.coarse_size());
        match self.components {
            2 => self.visit_edges::<2>(vertices, edges, |c, mean| *c -= mean),
            _ => self.visit_edges::<3>(vertices, edges, |c, mean| *c -= mean),
        }
    }

    /// Lagrange residual to P1 residual.
    pub fn restrict(&self, r: &[f64], coarse: &mut [f64]) {
        let (vertices, edges) = r.split_at(self.coarse_size());
        coarse.copy_from_slice(vertices);
        match self.components {
            2 => self.gather_edges::<2>(edges, coarse, 0.5),
            _ => self.gather_edges::<3>(edges, coarse, 0.5),
        }
        self.mask(coarse);
    }

    /// P1 values to Lagrange values.
    pub fn prolong(&self, coarse: &[f64], x: &mut [f64]) {
        let (vertices, edges) = x.split_at_mut(self.coarse_size());
        vertices.copy_from_slice(coarse);
        match self.components {
            2 => self.visit_edges::<2>(vertices, edges, |u, mean| *u = mean),
            _ => self.visit_edges::<3>(vertices, edges, |u, mean| *u = mean),
        }
        self.mask(x);
    }

    /// Adds `factor` times the values of its edges to each vertex.
    fn gather_edges<const C: usize>(&self, edges: &[f64], vertices: &mut [f64], factor: f64) {
        let (edges, _) = edges.as_chunks::<C>();
        let pieces = vertices.par_chunks_mut(PIECE * C).enumerate();
        pieces.for_each(|(piece, part)| {
            let (targets, _) = part.as_chunks_mut::<C>();
            let offsets = &self.offsets[piece * PIECE..];
            for (target, range) in targets.iter_mut().zip(offsets.windows(2)) {
                let mut sum = [0.0; C];
                for &edge in &self.incident[range[0] as usize..range[1] as usize] {
                    for i in 0..C {
                        sum[i] += edges[edge as usize][i];
                    }
                }
                for i in 0..C {
                    target[i] += factor * sum[i];
                }
            }
        });
    }

    /// Shows each edge value the mean of its ends.
    fn visit_edges<const C: usize>(
        &self,
        vertices: &[f64],
        edges: &mut [f64],
        visit: impl Fn(&mut f64, f64) + Sync,
    ) {
        let (vertices, _) = vertices.as_chunks::<C>();
        let pieces = edges
            .par_chunks_mut(PIECE * C)
            .zip(self.edges.par_chunks(PIECE));
        pieces.for_each(|(part, ends)| {
            let (targets, _) = part.as_chunks_mut::<C>();
            for (target, [a, b]) in targets.iter_mut().zip(ends) {
                let (a, b) = (&vertices[*a as usize], &vertices[*b as usize]);
                for i in 0..C {
                    visit(&mut target[i], 0.5 * (a[i] + b[i]));
                }
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::vector::{dot, reproducible_noise};

    /// A square with one diagonal; nothing, or two entries, held.
    fn square(held: &[u32]) -> Transfer {
        let edges = [[0, 1], [0, 2], [0, 3], [1, 3], [2, 3]];
        Transfer::new(4, 2, edges.into(), held.into())
    }

    #[test]
    fn restriction_is_the_adjoint_of_prolongation() {
        for transfer in [square(&[]), square(&[1, 6])] {
            let (coarse, fine) = (reproducible_noise(8), reproducible_noise(18));
            let mut masked = coarse.clone();
            transfer.mask(&mut masked);
            let (mut up, mut down) = (vec![0.0; 18], vec![0.0; 8]);
            transfer.prolong(&masked, &mut up);
            transfer.restrict(&fine, &mut down);
            assert!((dot(&up, &fine) - dot(&masked, &down)).abs() < 1e-14);
        }
    }

    #[test]
    fn a_residual_does_on_values_the_same_work_in_both_bases() {
        let transfer = square(&[]);
        let (values, residual) = (reproducible_noise(18), reproducible_noise(18));
        let (mut hierarchical, mut lagrange) = (values.clone(), residual.clone());
        transfer.values_to_hierarchical(&mut hierarchical);
        transfer.residual_to_lagrange(&mut lagrange);
        assert!((dot(&lagrange, &values) - dot(&residual, &hierarchical)).abs() < 1e-14);
    }

    #[test]
    fn held_entries_are_cleared() {
        let transfer = square(&[1, 12]);
        let mut r = vec![1.0; 18];
        transfer.residual_to_lagrange(&mut r);
        assert!(r[1].abs() + r[12].abs() < f64::MIN_POSITIVE);
    }
}
