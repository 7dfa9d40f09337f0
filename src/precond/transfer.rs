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

use crate::parallel::{self, Pieces};
use std::sync::Arc;

use crate::linalg::{Held, Scalar};

/// Nodes per parallel piece.
const PIECE: usize = 2048;
/// Pieces that a thread takes at least: waking another costs as much as they do.
const FEWEST: usize = 3;

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
    /// What is held; it stays zero on every level.
    held: Held,
}

impl Transfer {
    /// `edges` are the ends of each edge.
    pub fn new(vertices: usize, components: usize, edges: Arc<[[u32; 2]]>, held: Held) -> Self {
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

    /// What is held.
    pub fn held(&self) -> &Held {
        &self.held
    }

    /// Bytes held, those shared with the space left out.
    pub fn bytes(&self) -> u64 {
        4 * (self.offsets.len() + self.incident.len()) as u64
    }

    /// `unit` times the hierarchical residual `h` to Lagrange residual.
    pub fn residual_to_lagrange<R: Scalar>(&self, unit: f64, h: &[f64], r: &mut [R]) {
        match self.components {
            2 => self.gather_edges::<2, f64, R>(h, r, (unit, -0.5 * unit)),
            _ => self.gather_edges::<3, f64, R>(h, r, (unit, -0.5 * unit)),
        }
        let first = self.coarse_size();
        let piece = PIECE * self.components;
        let h = &h[first..];
        parallel::each(Pieces::of(&mut r[first..], piece), FEWEST, &|k, r| {
            for (r, h) in r.iter_mut().zip(&h[k * piece..]) {
                *r = R::narrow(unit * h);
            }
        });
        self.held.mask(r);
    }

    /// `unit` times Lagrange values `u` to hierarchical values.
    pub fn values_to_hierarchical<R: Scalar>(&self, unit: f64, u: &[R], c: &mut [f64]) {
        let (vertices, edges) = c.split_at_mut(self.coarse_size());
        let (ends, middles) = u.split_at(self.coarse_size());
        let piece = PIECE * self.components;
        parallel::each(Pieces::of(vertices, piece), FEWEST, &|k, c| {
            for (c, u) in c.iter_mut().zip(&ends[k * piece..]) {
                *c = unit * u.widen();
            }
        });
        match self.components {
            2 => self.visit_edges::<2, R>(unit, ends, (middles, edges)),
            _ => self.visit_edges::<3, R>(unit, ends, (middles, edges)),
        }
        // What rounding leaves in held directions no later step takes off.
        self.held.mask_nodes(c);
    }

    /// Lagrange residual to P1 residual.
    pub fn restrict<R: Scalar>(&self, r: &[R], coarse: &mut [f64]) {
        match self.components {
            2 => self.gather_edges::<2, R, f64>(r, coarse, (1.0, 0.5)),
            _ => self.gather_edges::<3, R, f64>(r, coarse, (1.0, 0.5)),
        }
        self.held.mask(coarse);
    }

    /// P1 values to Lagrange values.
    pub fn prolong<R: Scalar>(&self, coarse: &[f64], x: &mut [R]) {
        match self.components {
            2 => self.interpolate::<2, R>(coarse, x),
            _ => self.interpolate::<3, R>(coarse, x),
        }
        self.held.mask(x);
    }

    /// `unit` times the vertices of `r` and `factor` times the values of their edges.
    fn gather_edges<const C: usize, R: Scalar, T: Scalar>(
        &self,
        r: &[R],
        vertices: &mut [T],
        (unit, factor): (f64, f64),
    ) {
        let (own, edges) = r.split_at(self.coarse_size());
        let (own, edges) = (own.as_chunks::<C>().0, edges.as_chunks::<C>().0);
        let pieces = Pieces::of(&mut vertices[..self.coarse_size()], PIECE * C);
        parallel::each(pieces, FEWEST, &|piece, part| {
            let (targets, _) = part.as_chunks_mut::<C>();
            let nodes = own[piece * PIECE..]
                .iter()
                .zip(&self.offsets[piece * PIECE..]);
            let ends = &self.offsets[piece * PIECE + 1..];
            for ((target, (own, &first)), &end) in targets.iter_mut().zip(nodes).zip(ends) {
                let mut sum = [0.0; C];
                for &edge in &self.incident[first as usize..end as usize] {
                    for i in 0..C {
                        sum[i] += edges[edge as usize][i].widen();
                    }
                }
                for i in 0..C {
                    target[i] = T::narrow(unit * own[i].widen() + factor * sum[i]);
                }
            }
        });
    }

    /// `unit` times the corrections `c` of edges between `ends` whose values are `middles`.
    fn visit_edges<const C: usize, R: Scalar>(
        &self,
        unit: f64,
        ends: &[R],
        (middles, c): (&[R], &mut [f64]),
    ) {
        let (vertices, _) = ends.as_chunks::<C>();
        let (middles, _) = middles.as_chunks::<C>();
        parallel::each(Pieces::of(c, PIECE * C), FEWEST, &|piece, part| {
            let (targets, _) = part.as_chunks_mut::<C>();
            let (middles, ends) = (&middles[piece * PIECE..], &self.edges[piece * PIECE..]);
            for ((target, middle), [a, b]) in targets.iter_mut().zip(middles).zip(ends) {
                let (a, b) = (&vertices[*a as usize], &vertices[*b as usize]);
                for i in 0..C {
                    let mean = 0.5 * (a[i].widen() + b[i].widen());
                    target[i] = unit * (middle[i].widen() - mean);
                }
            }
        });
    }

    /// P1 values at all nodes.
    fn interpolate<const C: usize, R: Scalar>(&self, coarse: &[f64], x: &mut [R]) {
        let (vertices, edges) = x.split_at_mut(self.coarse_size());
        for (x, coarse) in vertices.iter_mut().zip(coarse) {
            *x = R::narrow(*coarse);
        }
        let (coarse, _) = coarse.as_chunks::<C>();
        parallel::each(Pieces::of(edges, PIECE * C), FEWEST, &|piece, part| {
            let (targets, _) = part.as_chunks_mut::<C>();
            let ends = &self.edges[piece * PIECE..];
            for (target, [a, b]) in targets.iter_mut().zip(ends) {
                let (a, b) = (&coarse[*a as usize], &coarse[*b as usize]);
                for i in 0..C {
                    target[i] = R::narrow(0.5 * (a[i] + b[i]));
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
        Transfer::new(4, 2, edges.into(), Held::of_entries(2, held))
    }

    #[test]
    fn restriction_is_the_adjoint_of_prolongation() {
        for transfer in [square(&[]), square(&[1, 6])] {
            let (coarse, fine) = (reproducible_noise(8), reproducible_noise(18));
            let mut masked = coarse.clone();
            transfer.held.mask(&mut masked);
            let (mut up, mut down) = (vec![0.0_f64; 18], vec![0.0; 8]);
            transfer.prolong(&masked, &mut up);
            transfer.restrict(&fine, &mut down);
            assert!((dot(&up, &fine) - dot(&masked, &down)).abs() < 1e-14);
        }
    }

    #[test]
    fn a_residual_does_on_values_the_same_work_in_both_bases() {
        let transfer = square(&[]);
        let (values, residual) = (reproducible_noise(18), reproducible_noise(18));
        let (mut hierarchical, mut lagrange) = (vec![0.0; 18], vec![0.0_f64; 18]);
        transfer.values_to_hierarchical(1.0, &values, &mut hierarchical);
        transfer.residual_to_lagrange(1.0, &residual, &mut lagrange);
        assert!((dot(&lagrange, &values) - dot(&residual, &hierarchical)).abs() < 1e-14);
    }

    #[test]
    fn held_entries_are_cleared() {
        let transfer = square(&[1, 12]);
        let mut r = vec![0.0_f64; 18];
        transfer.residual_to_lagrange(1.0, &[1.0; 18], &mut r);
        assert!(r[1].abs() + r[12].abs() < f64::MIN_POSITIVE);
    }
}
