//! The tangent of each cell at its centroid, for assembled preconditioners:
//!
//! ```text
//! C = d2W/dF2 - p d(cof F)/dF + volumetric mu cof F (x) cof F
//! ```
//!
//! One point a cell is enough there: the tangent varies over a cell by what its
//! size leaves. 360 bytes and nine tangent products a cell; cells in parallel.

use rayon::prelude::*;

use super::cells::CellLaws;
use crate::assembly::CellGeometry;
use crate::assembly::p1_stiffness::{Block, CellStiffness};
use crate::geometry::tensor::{Tensor, cofactor, cross, plus_unit, volume_change};
use crate::material::Isochoric;
use crate::mesh::Mesh;
use crate::space::TaylorHood;

/// Entries of a symmetric matrix of nine rows.
const ENTRIES: usize = 45;

/// A state of the body.
#[derive(Clone, Copy, Debug)]
pub struct CellStates<'a> {
    /// Mesh.
    pub mesh: &'a Mesh,
    /// Numbering.
    pub space: &'a TaylorHood,
    /// Gradients.
    pub geometry: &'a CellGeometry,
    /// Laws.
    pub laws: CellLaws<'a>,
    /// Hierarchical displacement.
    pub displacement: &'a [f64],
    /// Vertex pressures.
    pub pressure: &'a [f64],
}

/// Tangents of all cells.
#[derive(Clone, Debug)]
pub struct CellTangents {
    tensors: Vec<[f64; ENTRIES]>,
    shear: Vec<f64>,
}

impl CellTangents {
    /// Tangents at `states`.
    pub fn new(states: &CellStates<'_>, volumetric: f64) -> Self {
        let cells = 0..states.mesh.cell_count();
        let law = |cell: usize| &states.laws.laws[usize::from(states.laws.of_cell[cell])];
        Self {
            tensors: (cells.clone().into_par_iter())
                .map(|cell| states.tangent(cell, law(cell), volumetric))
                .collect(),
            shear: cells.map(|cell| law(cell).shear_modulus()).collect(),
        }
    }
}

impl CellStates<'_> {
    /// Displacement gradient at the centroid.
    fn gradient(&self, cell: usize) -> Tensor<f64> {
        let g = self.geometry.gradients_of(cell);
        let c = self.space.components;
        let mut out = [[0.0; 3]; 3];
        let mut add = |node: usize, factor: f64, slope: &[f64; 3]| {
            for i in 0..c {
                for j in 0..3 {
                    out[i][j] += factor * self.displacement[node * c + i] * slope[j];
                }
            }
        };
        for (&vertex, slope) in self.mesh.cell(cell).iter().zip(g) {
            add(vertex as usize, 1.0, slope);
        }
        let pairs = self.mesh.cell_kind().edges();
        let edges = &self.mesh.cell_edges()[cell * pairs.len()..(cell + 1) * pairs.len()];
        let hat = 1.0 / g.len() as f64;
        for (&edge, &(a, b)) in edges.iter().zip(pairs) {
            let node = self.space.vertices + edge as usize;
            add(node, 4.0 * hat, &g[a]);
            add(node, 4.0 * hat, &g[b]);
        }
        out
    }

    fn pressure(&self, cell: usize) -> f64 {
        let corners = self.mesh.cell(cell);
        let sum: f64 = corners.iter().map(|&v| self.pressure[v as usize]).sum();
        sum / corners.len() as f64
    }

    fn tangent(&self, cell: usize, law: &Isochoric, volumetric: f64) -> [f64; ENTRIES] {
        let mut h = self.gradient(cell);
        if volume_change(&h) < LEAST_CHANGE {
            h = [[0.0; 3]; 3];
        }
        let f = plus_unit(&h);
        let volume = cofactor(&f);
        let pressure = self.pressure(cell);
        let factor = volumetric * law.shear_modulus();
        let isochoric = law.tangent(&h);
        let mut out = [0.0; ENTRIES];
        let mut entry = 0;
        for row in 0..9 {
            let mut unit = [[0.0; 3]; 3];
            unit[row / 3][row % 3] = 1.0;
            let turned = cross(&f, &unit);
            let across = factor * volume[row / 3][row % 3];
            for column in row..9 {
                let (k, l) = (column / 3, column % 3);
                out[entry] =
                    isochoric[row][column] - pressure * turned[k][l] + across * volume[k][l];
                entry += 1;
            }
        }
        out
    }
}

/// A centroid that is turned inside out, or nearly, has no tangent of its own: it
/// takes the one at rest.
const LEAST_CHANGE: f64 = -0.9;

impl CellStiffness for CellTangents {
    fn coupling(&self, cell: usize, a: &[f64; 3], b: &[f64; 3]) -> Block {
        let tensor = &self.tensors[cell];
        let mut block = [[0.0; 3]; 3];
        let mut entry = 0;
        for row in 0..9 {
            let (i, m) = (row / 3, row % 3);
            for column in row..9 {
                let (k, n) = (column / 3, column % 3);
                let value = tensor[entry];
                entry += 1;
                block[i][k] += value * a[m] * b[n];
                if column > row {
                    block[k][i] += value * a[n] * b[m];
                }
            }
        }
        block
    }

    fn shear(&self, cell: usize) -> f64 {
        self.shear[cell]
    }
}
