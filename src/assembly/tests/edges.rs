//! The assembled edge block against the matrix-free operator.

use super::*;
use crate::compare::assembly::edge_stiffness::edge_blocks;
use crate::compare::precond::symmetric_blocks::SymmetricBlocks;
use crate::precond::node_pairs::NodePairs;

/// A22 times `x` by the assembled blocks.
fn assembled<const C: usize>(sample: &Sample, x: &[f64]) -> Vec<f64> {
    let blocks = edge_blocks(&sample.mesh, &sample.geometry, &sample.moduli);
    let pairs = NodePairs {
        diagonal: &blocks.diagonal,
        pairs: &blocks.pairs,
        off: &blocks.off,
    };
    let vertices = (sample.space.vertices * C) as u32;
    let held = sample.held.iter();
    let held = held.filter_map(|&unknown| unknown.checked_sub(vertices));
    let matrix = SymmetricBlocks::<C>::new(&pairs, held);
    let mut y = vec![f64::NAN; x.len()];
    matrix.apply(x, &mut y, &mut Workspace::new());
    y
}

#[test]
fn the_assembled_edge_block_is_that_of_the_operator() {
    for sample in samples() {
        let vertices = sample.space.vertices * sample.space.components;
        let mut x = reproducible_noise(sample.unknowns());
        x[..vertices].fill(0.0);
        let mut expected = sample.stiffness(Basis::Hierarchical, Rows::Free, &x);
        // Held rows are the identity in the assembled block.
        for &index in &sample.held {
            expected[index as usize] = x[index as usize];
        }
        let found = match sample.space.components {
            2 => assembled::<2>(&sample, &x[vertices..]),
            _ => assembled::<3>(&sample, &x[vertices..]),
        };
        let scale = largest(&expected);
        for (a, b) in found.iter().zip(&expected[vertices..]) {
            assert!((a - b).abs() < 1e-13 * scale, "{a} {b}");
        }
    }
}
