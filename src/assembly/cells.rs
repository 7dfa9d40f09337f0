//! Geometry and moduli of cells: barycentric gradients and volume of the straight ones,
//! constant on a cell, and what bends those whose edges are curved.

use std::f64::consts::TAU;

use crate::element::curved_cell::{CellMap, CurvedCell};
use crate::mesh::Mesh;

/// Per cell: gradients of the barycentric coordinates and the volume.
#[derive(Clone, Debug)]
pub struct CellGeometry {
    /// Vertices per cell.
    pub vertices: usize,
    /// `[cells * vertices]`, each `[3]`; the third component is zero in 2D.
    pub gradients: Vec<[f64; 3]>,
    /// Volume (area in 2D, that of the full turn about an axis) `[cells]`.
    pub volumes: Vec<f64>,
    /// Mean radius `[cells]`; empty where the body is not one of revolution.
    pub radii: Vec<f64>,
    /// Radius of each vertex `[cells * vertices]`; empty where the body is not one of revolution.
    pub corner_radii: Vec<f64>,
    /// Cells with curved edges.
    pub curves: CellCurves,
}

/// The cells of a mesh whose edges are curved.
#[derive(Clone, Debug, Default)]
pub struct CellCurves {
    /// Place of each cell in `curved`, [`CellCurves::STRAIGHT`] of straight ones `[cells]`; empty
    /// where all are.
    places: Vec<u32>,
    curved: Vec<CurvedCell>,
}

impl CellCurves {
    /// The place of a straight cell.
    const STRAIGHT: u32 = u32::MAX;

    /// Those of `mesh`, whose cells have these barycentric `gradients`, lengths times `scale`.
    fn new(mesh: &Mesh, scale: f64, gradients: &[[f64; 3]]) -> Self {
        let mut curves = Self::default();
        if mesh.edge_offsets().is_empty() {
            return curves;
        }
        let own = gradients.chunks_exact(mesh.cell_kind().vertices());
        for (cell, gradients) in own.enumerate() {
            let offsets = mesh.offsets_of_cell(cell);
            curves.places.push(match offsets {
                Some(_) => curves.curved.len() as u32,
                None => Self::STRAIGHT,
            });
            curves.curved.extend(offsets.map(|offsets| {
                let scaled = offsets.map(|offset| offset.map(|o| o * scale));
                CurvedCell::new(gradients, mesh.cell_kind().edges(), scaled)
            }));
        }
        curves
    }

    /// The curved edges of a cell; none of a straight one.
    pub fn of(&self, cell: usize) -> Option<&CurvedCell> {
        self.curved.get(*self.places.get(cell)? as usize)
    }

    /// F0 of a cell at barycentric coordinates; none of a straight one.
    pub fn map(&self, cell: usize, l: &[f64]) -> Option<CellMap> {
        self.of(cell).map(|curved| curved.map(l))
    }

    /// det F0 of a cell at barycentric coordinates.
    pub fn measure(&self, cell: usize, l: &[f64]) -> f64 {
        self.map(cell, l).map_or(1.0, |map| map.measure)
    }
}

/// Per cell: the moduli that enter the operators, non-dimensional.
#[derive(Clone, Debug, Default)]
pub struct CellModuli {
    /// mu `[cells]`.
    pub shear: Vec<f64>,
    /// lambda of the displacement form, zero where a pressure unknown serves `[cells]`.
    pub lame: Vec<f64>,
    /// What the approximate inverse of the displacement block holds in its place `[cells]`.
    pub augmented: Vec<f64>,
    /// 1 / lambda of the mixed form `[cells]`.
    pub inverse_lame: Vec<f64>,
}

impl CellGeometry {
    /// Geometry of `mesh` with coordinates multiplied by `scale`.
    pub fn new(mesh: &Mesh, scale: f64) -> Self {
        let vertices = mesh.cell_kind().vertices();
        let cells = mesh.cells().chunks_exact(vertices);
        let mut geometry = Self {
            vertices,
            gradients: Vec::with_capacity(mesh.cells().len()),
            volumes: Vec::with_capacity(cells.len()),
            radii: Vec::new(),
            corner_radii: Vec::new(),
            curves: CellCurves::default(),
        };
        for cell in cells {
            let mut points = [[0.0; 3]; 4];
            for (point, &vertex) in points.iter_mut().zip(cell) {
                *point = mesh.coordinates()[vertex as usize].map(|x| x * scale);
            }
            let volume = match vertices {
                3 => triangle(&points, &mut geometry.gradients),
                _ => tetrahedron(&points, &mut geometry.gradients),
            };
            geometry.volumes.push(volume);
        }
        geometry.curves = CellCurves::new(mesh, scale, &geometry.gradients);
        geometry
    }

    /// Geometry of `mesh` as the section of a body of revolution about x = 0: the
    /// volume of a cell is its area times the way of its centroid around the axis.
    pub fn about_axis(mesh: &Mesh, scale: f64) -> Self {
        let mut geometry = Self::new(mesh, scale);
        let cells = mesh.cells().chunks_exact(geometry.vertices);
        let radius_of = |v: &u32| scale * mesh.coordinates()[*v as usize][0];
        let mean = |cell: &[u32]| cell.iter().map(radius_of).sum::<f64>() / cell.len() as f64;
        geometry.radii = cells.map(mean).collect();
        let corners = mesh.cells().iter();
        geometry.corner_radii = corners.map(|v| radius_of(v).max(0.0)).collect();
        for (volume, radius) in geometry.volumes.iter_mut().zip(&geometry.radii) {
            *volume *= TAU * radius;
        }
        geometry
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.volumes.len()
    }

    /// Gradients of one cell `[vertices]`.
    pub fn gradients_of(&self, cell: usize) -> &[[f64; 3]] {
        &self.gradients[cell * self.vertices..(cell + 1) * self.vertices]
    }

    /// Bytes held.
    pub fn bytes(&self) -> u64 {
        let curves =
            4 * self.curves.places.len() + self.curves.curved.len() * size_of::<CurvedCell>();
        let radii = self.radii.len() + self.corner_radii.len();
        (24 * self.gradients.len() + 8 * (self.volumes.len() + radii) + curves) as u64
    }
}

fn triangle(p: &[[f64; 3]; 4], gradients: &mut Vec<[f64; 3]>) -> f64 {
    let double =
        (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[1][1] - p[0][1]) * (p[2][0] - p[0][0]);
    for i in 0..3 {
        let (a, b) = (p[(i + 1) % 3], p[(i + 2) % 3]);
        gradients.push([(a[1] - b[1]) / double, (b[0] - a[0]) / double, 0.0]);
    }
    0.5 * double
}

fn tetrahedron(p: &[[f64; 3]; 4], gradients: &mut Vec<[f64; 3]>) -> f64 {
    let edge = |i: usize| [p[i][0] - p[0][0], p[i][1] - p[0][1], p[i][2] - p[0][2]];
    let (a, b, c) = (edge(1), edge(2), edge(3));
    let cross = |u: [f64; 3], v: [f64; 3]| {
        [
            u[1] * v[2] - u[2] * v[1],
            u[2] * v[0] - u[0] * v[2],
            u[0] * v[1] - u[1] * v[0],
        ]
    };
    let (bc, ca, ab) = (cross(b, c), cross(c, a), cross(a, b));
    let six = a[0] * bc[0] + a[1] * bc[1] + a[2] * bc[2];
    let rows = [bc, ca, ab].map(|row| row.map(|x| x / six));
    let first = [0, 1, 2].map(|i| -(rows[0][i] + rows[1][i] + rows[2][i]));
    gradients.push(first);
    gradients.extend(rows);
    six / 6.0
}
