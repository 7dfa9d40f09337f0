//! The tangent of each cell at its centroid, for preconditioners:
//!
//! ```text
//! C = d2W/dF2 - p d(cof F)/dF + volumetric mu cof F (x) cof F
//! ```
//!
//! About an axis a displacement u along the radius x changes F_33 by u / x, with the
//! mean of a vertex function, 1/3, over the mean radius on the whole cell.
//!
//! One point a cell is enough there: the tangent varies over a cell by what its
//! size leaves. 360 bytes and nine tangent products a cell; cells in parallel.

use super::cells::CellLaws;
use crate::assembly::CellGeometry;
use crate::assembly::kernel::SYMMETRIC_ENTRIES;
use crate::assembly::p1_stiffness::{Block, CellStiffness};
use crate::geometry::tensor::{Tensor, cross, product, volume_change};
use crate::material::{Deformation, Rubber};
use crate::mesh::Mesh;
use crate::parallel;
use crate::space::TaylorHood;

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
    /// Upper triangles, row by row, row 3 i + j being component ij `[cells]`.
    pub(super) tensors: Vec<[f64; SYMMETRIC_ENTRIES]>,
    shear: Vec<f64>,
    /// Change of F_33 with a vertex's displacement along the radius `[cells]`;
    /// empty where the body is not one of revolution.
    hoops: Vec<f64>,
}

/// Place of C_ij33 in [`SYMMETRIC_ENTRIES`], `row` being 3 i + j.
fn around(row: usize) -> usize {
    row * (17 - row) / 2 + 8
}

impl CellTangents {
    /// Tangents at `states`.
    pub fn new(states: &CellStates<'_>, volumetric: f64) -> Self {
        let cells = 0..states.mesh.cell_count();
        let law = |cell: usize| &states.laws.laws[usize::from(states.laws.of_cell[cell])];
        Self {
            tensors: parallel::map(cells.len(), 1, &|cell| {
                states.tangent(cell, law(cell), volumetric)
            }),
            shear: cells.map(|cell| law(cell).shear_modulus()).collect(),
            hoops: (states.geometry.radii.iter())
                .map(|radius| 1.0 / (3.0 * radius))
                .collect(),
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
        let centroid = [1.0 / g.len() as f64; 4];
        if let Some(map) = self.geometry.curves.map(cell, &centroid[..g.len()]) {
            out = product(&out, &map.inverse);
        }
        if let Some(radius) = self.geometry.radii.get(cell) {
            let at = |node: usize| self.displacement[node * c];
            let corners = self.mesh.cell(cell).iter().map(|&v| at(v as usize));
            let middles = edges.iter().map(|&e| at(self.space.vertices + e as usize));
            let moved = hat * corners.sum::<f64>() + 4.0 * hat * hat * middles.sum::<f64>();
            out[2][2] = moved / radius;
        }
        out
    }

    fn tangent(&self, cell: usize, law: &Rubber, volumetric: f64) -> [f64; SYMMETRIC_ENTRIES] {
        let mut h = self.gradient(cell);
        if volume_change(&h) < LEAST_CHANGE {
            // A centroid that is turned inside out has no tangent of its own.
            h = [[0.0; 3]; 3];
        }
        let at = Deformation::new(h, (1.0 + volume_change(&h)).cbrt().recip());
        let corners = self.mesh.cell(cell);
        let sum: f64 = corners.iter().map(|&v| self.pressure[v as usize]).sum();
        let pressure = sum / corners.len() as f64;
        let matrix = law.isochoric.tangent(&h);
        let mut out = [0.0; SYMMETRIC_ENTRIES];
        let mut entry = 0;
        for row in 0..9 {
            let mut unit = [[0.0; 3]; 3];
            unit[row / 3][row % 3] = 1.0;
            let turned = cross(&at.gradient, &unit);
            let volume = volumetric * law.shear_modulus() * at.cofactor[row / 3][row % 3];
            for column in row..9 {
                let (k, n) = (column / 3, column % 3);
                let pushed = volume * at.cofactor[k][n] - pressure * turned[k][n];
                out[entry] = matrix[row][column] + pushed;
                entry += 1;
            }
        }
        out
    }
}

/// Adds what the stretch around the axis contributes, `hoop` for both nodes.
fn add_hoops(
    tensor: &[f64; SYMMETRIC_ENTRIES],
    hoop: f64,
    [a, b]: [&[f64; 3]; 2],
    block: &mut Block,
) {
    for row in 0..6 {
        let (i, m) = (row / 3, row % 3);
        let value = hoop * tensor[around(row)];
        block[i][0] += value * a[m];
        block[0][i] += value * b[m];
    }
    block[0][0] += hoop * hoop * tensor[around(8)];
}

/// Change of volume below which the tangent at rest takes the place of a cell's own.
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
        if let Some(&hoop) = self.hoops.get(cell) {
            add_hoops(tensor, hoop, [a, b], &mut block);
        }
        block
    }

    fn shear(&self, cell: usize) -> f64 {
        self.shear[cell]
    }
}
