//! The hierarchical preconditioners of the displacement block, which hold the
//! assembled edge block. Cost: its assembly.

use std::sync::Arc;

use crate::edge_stiffness::edge_blocks;
use crate::precond::hierarchical::{Additive, Multiplicative, Splitting, Symmetric, edge_sweep};
use signorini::comparisons::{SplitBody, WithBytes};
use signorini::linalg::Preconditioner;
use signorini::precond::node_pairs::NodePairs;
use signorini::scene::DisplacementMethod;

/// The preconditioner of `method` and its bytes without the P1 solver; none for the
/// solver's own.
pub(crate) fn displacement(method: DisplacementMethod, body: &SplitBody<'_>) -> Option<WithBytes> {
    let around: fn(Splitting) -> Arc<dyn Preconditioner> = match method {
        DisplacementMethod::PMultigrid => return None,
        DisplacementMethod::HierarchicalSsor => |parts| Arc::new(Symmetric(parts)),
        DisplacementMethod::HierarchicalMultiplicative => |parts| Arc::new(Multiplicative(parts)),
        DisplacementMethod::HierarchicalAdditive => |parts| Arc::new(Additive(parts)),
    };
    let (splitting, bytes) = splitting(body);
    Some((around(splitting), bytes))
}

/// A split into its vertex and edge parts with a preconditioner of each, and the bytes
/// that they hold.
fn splitting(body: &SplitBody<'_>) -> (Splitting, u64) {
    let vertex_unknowns = body.vertices * body.components;
    let blocks = edge_blocks(body.mesh, body.geometry, body.moduli);
    let pairs = NodePairs {
        diagonal: &blocks.diagonal,
        pairs: &blocks.pairs,
        off: &blocks.off,
    };
    let held = body.held.entries.iter();
    let held_edges = held.filter_map(|&unknown| unknown.checked_sub(vertex_unknowns as u32));
    let (edges, bytes) = edge_sweep(body.components, &pairs, held_edges);
    let splitting = Splitting {
        operator: body.stiffness.clone(),
        vertices: body.p1.clone(),
        edges,
        vertex_unknowns,
    };
    (splitting, bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample_body::bodies;
    use signorini::linalg::Workspace;
    use signorini::linalg::vector::{dot, reproducible_noise};

    #[test]
    fn preconditioners_for_conjugate_gradients_are_symmetric_and_positive() {
        for method in [
            DisplacementMethod::HierarchicalSsor,
            DisplacementMethod::HierarchicalAdditive,
        ] {
            for body in bodies() {
                let (preconditioner, _) = displacement(method, &body.split()).expect("a method");
                let mut x = reproducible_noise(body.space.displacement_unknowns());
                let mut y: Vec<f64> = x.iter().rev().copied().collect();
                for &index in body.held.entries.iter() {
                    (x[index as usize], y[index as usize]) = (0.0, 0.0);
                }
                let apply = |r: &[f64]| {
                    let mut z = vec![f64::NAN; r.len()];
                    preconditioner.apply(r, &mut z, &mut Workspace::new());
                    z
                };
                let (ax, ay) = (apply(&x), apply(&y));
                let (left, right) = (dot(&ax, &y), dot(&ay, &x));
                let size = dot(&ax, &x);
                assert!((left - right).abs() < 1e-11 * size, "{left} {right}");
                assert!(size > 0.0 && dot(&ay, &y) > 0.0);
            }
        }
    }
}
