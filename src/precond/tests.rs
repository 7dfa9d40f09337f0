//! The contact compliance against dense inverses of the P1 block.

use std::sync::Arc;

use super::NodeBlocks;
use super::compliance::{Compliance, ComplianceParts, OF_MIXED};
use super::p1::{DirectP1, Traces, vertex_order};
use super::volume_modes::{Flexibility, VolumeModes};
use crate::assembly::p1_stiffness::StiffCells;
use crate::assembly::{CellGeometry, CellModuli};
use crate::linalg::cholesky::Precision;
use crate::linalg::vector::reproducible_noise;
use crate::linalg::{
    DenseCholesky, DenseMatrix, Held, Preconditioner, SparseRows, SparseRowsBuilder,
    SymmetricMatrix, Workspace,
};
use crate::mesh::{GroupKind, Mesh, samples};
use crate::space::TaylorHood;

struct Sample {
    space: TaylorHood,
    /// Vertices of the side z1 or y1, ascending.
    contact: Vec<u32>,
    factor: DirectP1,
    /// A11, dense.
    matrix: DenseMatrix,
    blocks: NodeBlocks,
}

fn sample(mesh: &Mesh, side: &str) -> Sample {
    let space = TaylorHood::new(mesh);
    let geometry = CellGeometry::new(mesh, 1.0);
    let cells = 0..mesh.cell_count();
    let moduli = CellModuli {
        shear: cells.map(|cell| 1.0 + (cell % 2) as f64).collect(),
        lame: vec![0.3; mesh.cell_count()],
        augmented: vec![0.3; mesh.cell_count()],
        inverse_lame: Vec::new(),
    };
    // The first vertices are held, and one component on the contact side.
    let mut held: Vec<u32> = (0..3 * space.components as u32).collect();
    held.push((space.vertices * space.components - 2) as u32);
    let cells = StiffCells {
        mesh,
        space: &space,
        geometry: &geometry,
        stiffness: &moduli,
    };
    let lower = cells.p1_blocks(0.0).lower_columns(&space, &held);
    let mut matrix = DenseMatrix::zeros(lower.size(), lower.size());
    for column in 0..lower.size() {
        for entry in lower.offsets[column] as usize..lower.offsets[column + 1] as usize {
            let row = lower.rows[entry] as usize;
            *matrix.at_mut(row, column) = lower.values[entry];
            *matrix.at_mut(column, row) = lower.values[entry];
        }
    }
    let group = mesh.group(side, GroupKind::Facets).expect("a side");
    let facets = group
        .members
        .iter()
        .flat_map(|&facet| mesh.facet(facet as usize));
    let mut contact: Vec<u32> = facets.copied().collect();
    contact.sort_unstable();
    contact.dedup();
    let order = vertex_order(mesh.coordinates(), &space.edges, &contact);
    let blocks = cells.node_blocks(&Held::of_entries(space.components, held.clone()));
    Sample {
        factor: DirectP1::new(&lower, &order, space.components, Precision::Double)
            .expect("positive definite"),
        blocks: NodeBlocks::invert(space.components, blocks),
        space,
        contact,
        matrix,
    }
}

fn samples() -> [Sample; 2] {
    [
        sample(&samples::cube(3), "z1"),
        sample(&samples::rectangle(4, 3), "y1"),
    ]
}

impl Sample {
    /// A11^-1, dense.
    fn inverse(&self) -> DenseMatrix {
        let factor = DenseCholesky::new(&self.matrix).expect("positive definite");
        let mut inverse = DenseMatrix::zeros(self.matrix.rows(), self.matrix.rows());
        for column in 0..inverse.columns() {
            let target = inverse.column_mut(column);
            target[column] = 1.0;
            factor.solve(target);
        }
        inverse
    }

    /// Random rows on contact vertices and some edges.
    fn coupling(&self) -> SparseRows {
        let c = self.space.components as u32;
        let size = self.space.displacement_unknowns();
        let mut builder = SparseRowsBuilder::new(size);
        for row in 0..4_u32 {
            let near = self.contact.iter().skip(row as usize).take(3).copied();
            let edges = (0..3).map(|k| self.space.vertices as u32 + 2 * row + k);
            let unknowns = near
                .chain(edges)
                .flat_map(|node| (0..c).map(move |i| node * c + i));
            let unknowns: Vec<u32> = unknowns.collect();
            let values = reproducible_noise(unknowns.len() + row as usize);
            let entries = unknowns
                .into_iter()
                .zip(values.into_iter().skip(row as usize));
            builder.push_row(&mut entries.collect::<Vec<_>>());
        }
        builder.finish()
    }
}

#[test]
fn the_factor_solves_the_p1_block() {
    for sample in samples() {
        let exact = reproducible_noise(sample.matrix.rows());
        let (mut r, mut z) = (vec![0.0; exact.len()], vec![0.0; exact.len()]);
        sample.matrix.multiply(&exact, &mut r);
        sample.factor.apply(&r, &mut z, &mut Workspace::new());
        assert!(z.iter().zip(&exact).all(|(a, b)| (a - b).abs() < 1e-11));
    }
}

/// A unit vector for each contact vertex.
fn directions(sample: &Sample) -> Vec<[f64; 3]> {
    let noise = reproducible_noise(2 * sample.contact.len());
    let pairs = noise.chunks(2);
    let unit = |pair: &[f64]| {
        let length = (pair[0] * pair[0] + pair[1] * pair[1]).sqrt();
        match sample.space.components {
            2 => [pair[0] / length, pair[1] / length, 0.0],
            _ => [0.6 * pair[0] / length, 0.8, 0.6 * pair[1] / length],
        }
    };
    pairs.map(unit).collect()
}

#[test]
fn the_last_block_of_the_factor_gives_the_inverse_along_directions() {
    for sample in samples() {
        let c = sample.space.components;
        let directions = directions(&sample);
        let traces = Traces {
            vertices: &sample.contact,
            directions: &directions,
        };
        let found = sample.factor.compliance(&traces, c);
        let inverse = sample.inverse();
        for i in 0..found.rows() {
            for j in 0..found.columns() {
                let exact = along(&sample, &inverse, &directions, i, j);
                assert!((found.at(i, j) - exact).abs() < 1e-12, "{i} {j}");
            }
        }
    }
}

/// The inverse between two contact vertices along their directions.
fn along(
    sample: &Sample,
    inverse: &DenseMatrix,
    directions: &[[f64; 3]],
    i: usize,
    j: usize,
) -> f64 {
    let c = sample.space.components;
    let index = |trace: usize, k: usize| sample.contact[trace] as usize * c + k;
    let mut sum = 0.0;
    for k in 0..c {
        for l in 0..c {
            sum += directions[i][k] * inverse.at(index(i, k), index(j, l)) * directions[j][l];
        }
    }
    sum
}

#[test]
fn the_compliance_is_that_of_vertices_and_edges_apart() {
    for sample in samples() {
        let c = sample.space.components;
        let coupling = sample.coupling();
        let directions = directions(&sample);
        let traces = Traces {
            vertices: &sample.contact,
            directions: &directions,
        };
        let vertex_inverse = Arc::new(sample.factor.compliance(&traces, c));
        let parts = ComplianceParts {
            vertex_inverse: &vertex_inverse,
            traces,
            node_blocks: &sample.blocks,
            vertex_count: sample.space.vertices,
            edge_ends: None,
            is_held: &[],
            volumes: None,
            scale: OF_MIXED,
        };
        let found = Compliance::new(&parts, &coupling).dense();
        let inverse = sample.inverse();
        let entry = |a: u32, b: u32| {
            let (node, other) = (a as usize / c, b as usize / c);
            if node < sample.space.vertices && other < sample.space.vertices {
                // Only the parts along the directions, seen from both sides.
                let trace = |node: usize| {
                    let found = sample.contact.binary_search(&(node as u32));
                    found.expect("couplings reach contact vertices only")
                };
                let (i, j) = (trace(node), trace(other));
                let parts = directions[i][a as usize % c] * directions[j][b as usize % c];
                parts * along(&sample, &inverse, &directions, i, j)
            } else if node == other {
                sample.blocks.block(node)[a as usize % c * c + b as usize % c]
            } else {
                0.0
            }
        };
        let trace: f64 = (0..found.rows()).map(|i| found.at(i, i)).sum();
        for i in 0..found.rows() {
            for j in 0..found.rows() {
                let (rows, columns) = (coupling.row(i), coupling.row(j));
                let mut exact = 0.0;
                for (&a, x) in rows.0.iter().zip(rows.1) {
                    for (&b, y) in columns.0.iter().zip(columns.1) {
                        exact += OF_MIXED * x * entry(a, b) * y;
                    }
                }
                // The regularisation lifts the diagonal by 1e-10 of its mean.
                assert!((found.at(i, j) - exact).abs() < 1e-10 * trace, "{i} {j}");
                assert_eq!(found.at(i, j).to_bits(), found.at(j, i).to_bits());
            }
        }
    }
}

impl Sample {
    /// The volume mode of an arbitrary change of volume, edges alone.
    fn volume(&self, change: &[f64], slack: f64) -> VolumeModes {
        let directions = directions(self);
        let flexibility = Flexibility {
            p1: &self.factor,
            traces: Traces {
                vertices: &self.contact,
                directions: &directions,
            },
            node_blocks: &self.blocks,
            vertex_count: self.space.vertices,
            edge_ends: None,
            is_held: &vec![false; change.len()],
        };
        let row = |values: &[f64]| {
            let mut builder = SparseRowsBuilder::new(values.len());
            builder.push_dense(values, 0.0);
            builder.finish()
        };
        let parts = (&row(change), Some(&row(&[slack])));
        VolumeModes::new(&flexibility, row(&[1.0]), parts)
    }

    /// The compliance of [`Self::coupling`] with those volumes.
    fn metric(&self, volumes: Option<&VolumeModes>) -> Compliance {
        let directions = directions(self);
        let traces = Traces {
            vertices: &self.contact,
            directions: &directions,
        };
        let inverse = Arc::new(self.factor.compliance(&traces, self.space.components));
        let parts = ComplianceParts {
            vertex_inverse: &inverse,
            traces,
            node_blocks: &self.blocks,
            vertex_count: self.space.vertices,
            edge_ends: None,
            is_held: &[],
            volumes,
            scale: OF_MIXED,
        };
        Compliance::new(&parts, &self.coupling())
    }
}

#[test]
fn products_parts_and_entries_are_those_of_one_matrix() {
    for sample in samples() {
        let change = reproducible_noise(sample.space.displacement_unknowns());
        let metric = sample.metric(Some(&sample.volume(&change, 0.1)));
        let dense = metric.dense();
        let x = [0.3, -1.0, 0.5, 2.0];
        let (mut found, mut expected) = ([0.0; 4], [0.0; 4]);
        metric.product(&x, &mut found);
        dense.multiply(&x, &mut expected);
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-13 * dense.at(0, 0));
        }
        let part = metric.principal_part(&[1, 3]);
        assert!((part.at(0, 1) - dense.at(1, 3)).abs() < 1e-15 * dense.at(0, 0));
        assert!((metric.entry(3, 1) - dense.at(1, 3)).abs() < 1e-15 * dense.at(0, 0));
        for selected in [&[0, 2][..], &[2, 3], &[0, 1, 3], &[0, 2]] {
            assert_eq!(metric.part_again(selected), metric.principal_part(selected));
        }
        let factor = metric.factor_of_part(&[0, 2]).expect("positive definite");
        let again = metric.factor_of_part(&[0, 2]).expect("positive definite");
        assert!(Arc::ptr_eq(&factor, &again));
    }
}

#[test]
fn a_volume_takes_one_rank_off_and_leaves_the_metric_positive() {
    for sample in samples() {
        let (c, vertices) = (sample.space.components, sample.space.vertices);
        let change = reproducible_noise(sample.space.displacement_unknowns());
        let mode = sample.volume(&change, 0.0);
        // b^T Y b by the dense inverse and the blocks of the edges.
        let inverse = sample.inverse();
        let mut smooth = vec![0.0; vertices * c];
        inverse.multiply(&change[..vertices * c], &mut smooth);
        let mut exact: f64 = change.iter().zip(&smooth).map(|(b, y)| b * y).sum();
        for node in vertices..sample.space.nodes() {
            let (b, block) = (&change[node * c..(node + 1) * c], sample.blocks.block(node));
            let pairs = (0..c).flat_map(|i| (0..c).map(move |j| (i, j)));
            exact += pairs
                .map(|(i, j)| b[i] * block[i * c + j] * b[j])
                .sum::<f64>();
        }
        assert!(
            (mode.work.at(0, 0) / exact - 1.0).abs() < 1.1e-5,
            "{:?} {exact}",
            mode.work
        );
        let with = sample.metric(Some(&mode)).dense();
        let without = sample.metric(None).dense();
        assert!(DenseCholesky::new(&with).is_ok());
        // Every minor of order two of a matrix of rank one vanishes.
        let taken = |i: usize, j: usize| without.at(i, j) - with.at(i, j);
        let minor = taken(0, 0) * taken(1, 1) - taken(0, 1) * taken(1, 0);
        assert!(taken(0, 0) > 0.0);
        assert!(minor.abs() < 1e-8 * taken(0, 0) * taken(1, 1).max(taken(0, 0)));
    }
}
