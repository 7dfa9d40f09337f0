//! The assembled edge block against the matrix-free operator.

use super::edge_blocks;
use crate::precond::symmetric_blocks::SymmetricBlocks;
use crate::sample_body::{Body, bodies};
use signorini::linalg::vector::{largest, reproducible_noise};
use signorini::linalg::{LinearOperator, Workspace};
use signorini::precond::node_pairs::NodePairs;

/// A22 times `x` by the assembled blocks.
fn assembled<const C: usize>(body: &Body, x: &[f64]) -> Vec<f64> {
    let blocks = edge_blocks(&body.mesh, &body.geometry, &body.moduli);
    let pairs = NodePairs {
        diagonal: &blocks.diagonal,
        pairs: &blocks.pairs,
        off: &blocks.off,
    };
    let vertices = (body.space.vertices * C) as u32;
    let held = body.held.entries.iter();
    let held = held.filter_map(|&unknown| unknown.checked_sub(vertices));
    let matrix = SymmetricBlocks::<C>::new(&pairs, held);
    let mut y = vec![f64::NAN; x.len()];
    matrix.apply(x, &mut y, &mut Workspace::new());
    y
}

#[test]
fn the_assembled_edge_block_is_that_of_the_operator() {
    for body in bodies() {
        let vertices = body.space.vertices * body.space.components;
        let mut x = reproducible_noise(body.space.displacement_unknowns());
        x[..vertices].fill(0.0);
        let mut expected = vec![f64::NAN; x.len()];
        body.stiffness()
            .apply(&x, &mut expected, &mut Workspace::new());
        let found = match body.space.components {
            2 => assembled::<2>(&body, &x[vertices..]),
            _ => assembled::<3>(&body, &x[vertices..]),
        };
        let scale = largest(&expected);
        for (a, b) in found.iter().zip(&expected[vertices..]) {
            assert!((a - b).abs() < 1e-13 * scale, "{a} {b}");
        }
    }
}
