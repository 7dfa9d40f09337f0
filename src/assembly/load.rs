//! Load vectors in the hierarchical basis: body forces and surface tractions
//! given as functions of position.
//!
//! Vertex functions are barycentric coordinates, edge functions 4 l_a l_b; cells and facets are those
//! with their curved edges. Cost: one
//! value of the function a point of the rule, in parallel over cells.

use super::cells::CellGeometry;
use crate::element::quadrature::Rule;
use crate::geometry::vector3::normalised;
use crate::mesh::CurvedFacet;
use crate::mesh::Mesh;
use crate::parallel::{self, Pieces};
use crate::space::TaylorHood;

/// Node numbers and P2 hierarchical shape values of a simplex at a point with
/// barycentric coordinates `l`; edges in the order (0,1), (0,2), ..
pub fn shape_values(l: &[f64]) -> Vec<f64> {
    let mut values = Vec::with_capacity(l.len() * (l.len() + 1) / 2);
    push_shape_values(l, &mut values);
    values
}

/// [`shape_values`] after those of other points.
pub fn push_shape_values(l: &[f64], values: &mut Vec<f64>) {
    values.extend_from_slice(l);
    for (i, a) in l.iter().enumerate() {
        for b in &l[i + 1..] {
            values.push(4.0 * a * b);
        }
    }
}

/// The point with barycentric coordinates `l` in the simplex of `vertices`.
pub fn position(mesh: &Mesh, scale: f64, vertices: &[u32], l: &[f64]) -> [f64; 3] {
    let mut point = [0.0; 3];
    for (&vertex, factor) in vertices.iter().zip(l) {
        let corner = mesh.coordinates()[vertex as usize];
        for i in 0..3 {
            point[i] += factor * scale * corner[i];
        }
    }
    point
}

/// A rule with the shape values at its points, for many cells of one kind.
struct Tabulated<'a> {
    rule: &'a Rule,
    corners: usize,
    /// Values of all nodes, point by point.
    shapes: Vec<f64>,
}

impl<'a> Tabulated<'a> {
    fn new(rule: &'a Rule, corners: usize) -> Self {
        let points = rule.points.iter();
        Self {
            rule,
            corners,
            shapes: points
                .flat_map(|point| shape_values(&point[..corners]))
                .collect(),
        }
    }

    /// Nodes of a simplex.
    fn nodes(&self) -> usize {
        self.corners * (self.corners + 1) / 2
    }

    /// Adds `measure * int value . v` of one simplex to `local` `[nodes][3]`.
    fn integrate(&self, measure: f64, value: &dyn Fn(&[f64]) -> [f64; 3], local: &mut [[f64; 3]]) {
        let shapes = self.shapes.chunks_exact(self.nodes());
        let points = self.rule.points.iter().zip(&self.rule.weights);
        for ((point, weight), shapes) in points.zip(shapes) {
            let density = value(&point[..self.corners]).map(|f| measure * weight * f);
            for (sum, shape) in local.iter_mut().zip(shapes) {
                for i in 0..3 {
                    sum[i] += shape * density[i];
                }
            }
        }
    }
}

fn scatter(
    space: &TaylorHood,
    nodes: impl Iterator<Item = u32>,
    local: &[[f64; 3]],
    load: &mut [f64],
) {
    let c = space.components;
    for (node, sum) in nodes.zip(local) {
        let first = node as usize * c;
        for (entry, part) in load[first..first + c].iter_mut().zip(sum) {
            *entry += part;
        }
    }
}

/// Cells whose integrals are held at a time.
const BLOCK: usize = 4096;

/// Loads on a body: where they act and by which rule they are integrated.
#[derive(Clone, Copy, Debug)]
pub struct Integral<'a> {
    /// Mesh.
    pub mesh: &'a Mesh,
    /// Numbering.
    pub space: &'a TaylorHood,
    /// Multiplies the coordinates.
    pub scale: f64,
    /// Rule on the cells or on the facets.
    pub rule: &'a Rule,
}

/// A loaded facet.
#[derive(Clone, Debug)]
pub struct LoadedFacet<'a> {
    /// Its corners.
    pub vertices: &'a [u32],
    /// Area, or length in two dimensions, of the straight facet.
    area: f64,
    /// Its unit normal.
    normal: [f64; 3],
    /// Curved edges.
    curve: Option<CurvedFacet>,
}

impl<'a> LoadedFacet<'a> {
    /// The facet with these vertices of `mesh`, lengths times `scale`.
    pub fn new(mesh: &Mesh, vertices: &'a [u32], scale: f64) -> Self {
        let (area, normal) = facet_measure(mesh, vertices, scale);
        Self {
            vertices,
            area,
            normal,
            curve: CurvedFacet::of(mesh, scale, vertices),
        }
    }

    /// Position at barycentric coordinates.
    pub fn position(&self, on: &Integral<'_>, l: &[f64]) -> [f64; 3] {
        match &self.curve {
            Some(curve) => curve.position(l),
            None => position(on.mesh, on.scale, self.vertices, l),
        }
    }

    /// Unit normal at barycentric coordinates, by the order of the corners.
    fn normal_at(&self, l: &[f64]) -> [f64; 3] {
        let curved = self
            .curve
            .as_ref()
            .and_then(|curve| normalised(curve.area_vector(l)));
        curved.unwrap_or(self.normal)
    }

    /// Its own area over that of the straight facet at barycentric coordinates.
    fn stretch_at(&self, l: &[f64]) -> f64 {
        let curved = self
            .curve
            .as_ref()
            .map(|curve| curve.area_at(l, false) / self.area);
        curved.unwrap_or(1.0)
    }
}

impl Integral<'_> {
    /// Adds `int f . v` over all cells of this `geometry`; `force` takes a cell and a
    /// position. Integrals run in parallel, sums in the order of the cells.
    pub fn add_body_force(
        &self,
        geometry: &CellGeometry,
        force: &(dyn Fn(usize, [f64; 3]) -> [f64; 3] + Sync),
        load: &mut [f64],
    ) {
        let place = |cell: usize, l: &[f64]| self.mesh.position_in(cell, l).map(|x| x * self.scale);
        let at = |cell: usize, l: &[f64]| force(cell, place(cell, l));
        self.add_cell_density(geometry, &at, load);
    }

    /// The same; `force` takes a cell and barycentric coordinates in it.
    pub fn add_cell_density(
        &self,
        geometry: &CellGeometry,
        force: &(dyn Fn(usize, &[f64]) -> [f64; 3] + Sync),
        load: &mut [f64],
    ) {
        let volumes = &geometry.volumes;
        let table = Tabulated::new(self.rule, self.mesh.cell_kind().vertices());
        let mut local = vec![[0.0; 3]; BLOCK.min(volumes.len()) * table.nodes()];
        for first in (0..volumes.len()).step_by(BLOCK) {
            let count = BLOCK.min(volumes.len() - first);
            let block = &mut local[..count * table.nodes()];
            let cells = Pieces::of(block, table.nodes());
            parallel::each(cells, 1, &|index, sums| {
                let cell = first + index;
                sums.fill([0.0; 3]);
                let density = |l: &[f64]| {
                    let measure = geometry.curves.measure(cell, l);
                    force(cell, l).map(|f| f * measure)
                };
                table.integrate(volumes[cell], &density, sums);
            });
            for (index, sums) in block.chunks_exact(table.nodes()).enumerate() {
                scatter(self.space, self.nodes(first + index), sums, load);
            }
        }
    }

    /// Vertices, then edges of a cell.
    pub fn nodes(&self, cell: usize) -> impl Iterator<Item = u32> {
        let edges = self.mesh.cell_kind().edges().len();
        let own_edges = &self.mesh.cell_edges()[cell * edges..(cell + 1) * edges];
        let first = self.space.vertices as u32;
        let own_edges = own_edges.iter().map(move |&edge| edge + first);
        self.mesh.cell(cell).iter().copied().chain(own_edges)
    }

    /// Adds `int t . v` over one facet; `traction` takes a position and the unit normal.
    pub fn add_traction(
        &self,
        facet: &LoadedFacet<'_>,
        traction: &dyn Fn([f64; 3], [f64; 3]) -> [f64; 3],
        load: &mut [f64],
    ) {
        let value = |l: &[f64]| traction(facet.position(self, l), facet.normal_at(l));
        self.add_facet_density(facet, &value, load);
    }

    /// The same; `traction` takes barycentric coordinates.
    pub fn add_facet_density(
        &self,
        facet: &LoadedFacet<'_>,
        traction: &dyn Fn(&[f64]) -> [f64; 3],
        load: &mut [f64],
    ) {
        let vertices = facet.vertices;
        let table = Tabulated::new(self.rule, vertices.len());
        let mut local = [[0.0; 3]; 6];
        let density = |l: &[f64]| {
            let stretch = facet.stretch_at(l);
            traction(l).map(|t| t * stretch)
        };
        table.integrate(facet.area, &density, &mut local);
        let nodes = self.space.facet_nodes(vertices).into_iter();
        scatter(self.space, nodes, &local, load);
    }
}

/// Measure (area, or length in 2D) and unit normal of a facet. The normal
/// follows the order of the vertices; in 2D it points right of the segment.
pub fn facet_measure(mesh: &Mesh, facet: &[u32], scale: f64) -> (f64, [f64; 3]) {
    let point = |i: usize| mesh.coordinates()[facet[i] as usize].map(|x| x * scale);
    let edge = |a: [f64; 3], b: [f64; 3]| [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
    let along = edge(point(0), point(1));
    let (area_vector, measure_factor) = match facet.len() {
        2 => ([along[1], -along[0], 0.0], 1.0),
        _ => {
            let other = edge(point(0), point(2));
            let cross = [
                along[1] * other[2] - along[2] * other[1],
                along[2] * other[0] - along[0] * other[2],
                along[0] * other[1] - along[1] * other[0],
            ];
            (cross, 0.5)
        }
    };
    let length = area_vector.iter().map(|x| x * x).sum::<f64>().sqrt();
    (measure_factor * length, area_vector.map(|x| x / length))
}
