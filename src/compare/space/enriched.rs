//! Numbering and shapes of the elements that Taylor-Hood is compared with: P1
//! displacement enriched by bubbles, on simplices.
//!
//! MINI (D. Arnold, F. Brezzi, M. Fortin, Calcolo 21, 1984): one bubble per cell
//! and component, pressure P1. Bernardi-Raugel (C. Bernardi, G. Raugel, Math.
//! Comp. 44, 1985; also called SMALL): one bubble per facet along its normal,
//! pressure constant on cells.
//!
//! Every scalar shape is a product of barycentric coordinates, every function a
//! shape times a direction. Unknown `n * components + i` is component i at
//! vertex n, as in Taylor-Hood; bubbles follow, cell by cell or facet by facet.

use crate::geometry::vector3::{cross, norm, scale, sub};
use crate::mesh::Mesh;

/// Stands for the third vertex of a segment.
const NO_VERTEX: u32 = u32::MAX;

/// What is added to P1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Enrichment {
    /// MINI: one bubble a cell and component, continuous P1 pressure.
    CellBubbles,
    /// Bernardi-Raugel: one bubble a facet along its normal, pressure constant on
    /// cells.
    FacetBubbles,
}

/// A product of barycentric coordinates with largest value one.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Shape {
    /// Local vertices of the cell; each is one factor of the product.
    pub(crate) vertices: Vec<usize>,
    /// Factor that makes the largest value one: 1, 4 (edge bubble), 27 (triangle) or
    /// 256 (tetrahedron).
    pub(crate) scale: f64,
}

impl Shape {
    /// The product of these vertices' coordinates.
    pub(crate) fn bubble(vertices: Vec<usize>) -> Self {
        let count = vertices.len();
        Self {
            scale: (count as f64).powi(count as i32),
            vertices,
        }
    }

    /// Value at barycentric coordinates.
    pub(crate) fn value(&self, l: &[f64]) -> f64 {
        self.scale * self.vertices.iter().map(|&v| l[v]).product::<f64>()
    }

    /// Gradient at barycentric coordinates `l` with their gradients `g`.
    pub(crate) fn gradient(&self, l: &[f64], g: &[[f64; 3]]) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for &v in &self.vertices {
            let others = self.vertices.iter().filter(|&&w| w != v);
            let factor = self.scale * others.map(|&w| l[w]).product::<f64>();
            (0..3).for_each(|i| sum[i] += factor * g[v][i]);
        }
        sum
    }
}

/// One function of a cell: a shape along a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Function {
    /// Displacement unknown that the function belongs to, 0-based.
    pub(crate) unknown: u32,
    /// Position of its shape among the shapes of the space.
    pub(crate) shape: usize,
    /// Unit vector along which the function displaces `[3]`.
    pub(crate) direction: [f64; 3],
}

/// Sizes, facets and shapes of an enriched space.
#[derive(Clone, Debug)]
pub(crate) struct Enriched {
    /// What is added to P1: bubbles on cells or on facets.
    pub(crate) enrichment: Enrichment,
    /// Components of the displacement: 3 in space, 2 in the plane.
    pub(crate) components: usize,
    /// Number of mesh vertices, each with all components of a P1 function.
    pub(crate) vertices: usize,
    /// Number of mesh cells.
    pub(crate) cells: usize,
    /// Scalar shapes of a cell: its vertices, then its bubbles.
    pub(crate) shapes: Vec<Shape>,
    /// Facets by ascending vertices, lexicographic; none without facet bubbles.
    facets: Vec<[u32; 3]>,
    /// Unit normal of each facet, oriented by the order of its vertices.
    normals: Vec<[f64; 3]>,
    /// Facet opposite each local vertex `[cells * (components + 1)]`.
    cell_facets: Vec<u32>,
}

impl Enriched {
    /// The space of `mesh`.
    pub(crate) fn new(mesh: &Mesh, enrichment: Enrichment) -> Self {
        let components = mesh.cell_kind().dimension();
        let corners = mesh.cell_kind().vertices();
        let mut space = Self {
            enrichment,
            components,
            vertices: mesh.coordinates().len(),
            cells: mesh.cell_count(),
            shapes: shapes(corners, enrichment),
            facets: Vec::new(),
            normals: Vec::new(),
            cell_facets: Vec::new(),
        };
        if enrichment == Enrichment::FacetBubbles {
            space.number_facets(mesh);
        }
        space
    }

    /// Numbers the facets of all cells: sorted by their vertices, so that the numbering
    /// does not depend on the order of cells. Cost: one sort of the facets.
    fn number_facets(&mut self, mesh: &Mesh) {
        let local = mesh.cell_kind().facets();
        let cells = (0..self.cells).map(|cell| mesh.cell(cell));
        let keys: Vec<[u32; 3]> = cells
            .flat_map(|cell| {
                local
                    .iter()
                    .map(|facet| key(facet.iter().map(|&v| cell[v])))
            })
            .collect();
        self.facets = keys.clone();
        self.facets.sort_unstable();
        self.facets.dedup();
        self.cell_facets = keys.iter().map(|facet| self.position(facet)).collect();
        self.normals = self.facets.iter().map(|f| normal(mesh, f)).collect();
    }

    /// Number of the facet with that key, 0-based.
    fn position(&self, key: &[u32; 3]) -> u32 {
        self.facets.partition_point(|other| other < key) as u32
    }

    /// The facet of these vertices, which a cell must have.
    pub(crate) fn facet(&self, vertices: &[u32]) -> usize {
        self.position(&key(vertices.iter().copied())) as usize
    }

    /// Unit normal that the bubble of a facet is directed along.
    pub(crate) fn normal(&self, facet: usize) -> [f64; 3] {
        self.normals[facet]
    }

    /// Displacement unknowns of the P1 part.
    pub(crate) fn p1_unknowns(&self) -> usize {
        self.vertices * self.components
    }

    /// Displacement unknowns, held ones included.
    pub(crate) fn displacement_unknowns(&self) -> usize {
        self.p1_unknowns()
            + match self.enrichment {
                Enrichment::CellBubbles => self.cells * self.components,
                Enrichment::FacetBubbles => self.facets.len(),
            }
    }

    /// Pressure unknowns.
    pub(crate) fn pressure_unknowns(&self) -> usize {
        match self.enrichment {
            Enrichment::CellBubbles => self.vertices,
            Enrichment::FacetBubbles => self.cells,
        }
    }

    /// Unknowns that form one diagonal block of the bubbles.
    pub(crate) fn bubble_block(&self) -> usize {
        match self.enrichment {
            Enrichment::CellBubbles => self.components,
            Enrichment::FacetBubbles => 1,
        }
    }

    /// Unknown of the bubble of a facet.
    pub(crate) fn facet_unknown(&self, facet: usize) -> usize {
        self.p1_unknowns() + facet
    }

    /// Displacement functions of one cell, vertices first.
    pub(crate) fn functions(&self, mesh: &Mesh, cell: usize) -> Vec<Function> {
        let c = self.components;
        let axis = |i: usize| std::array::from_fn(|j| f64::from(u8::from(i == j)));
        let mut functions = Vec::with_capacity((c + 1) * (c + 1));
        let mut push = |unknown: usize, shape: usize, direction: [f64; 3]| {
            functions.push(Function {
                unknown: unknown as u32,
                shape,
                direction,
            });
        };
        for (shape, &vertex) in mesh.cell(cell).iter().enumerate() {
            (0..c).for_each(|i| push(vertex as usize * c + i, shape, axis(i)));
        }
        match self.enrichment {
            Enrichment::CellBubbles => {
                let first = self.p1_unknowns() + cell * c;
                (0..c).for_each(|i| push(first + i, c + 1, axis(i)));
            }
            Enrichment::FacetBubbles => {
                for local in 0..=c {
                    let facet = self.cell_facets[cell * (c + 1) + local] as usize;
                    push(self.facet_unknown(facet), c + 1 + local, self.normal(facet));
                }
            }
        }
        functions
    }

    /// Pressure unknowns of one cell: those of its corners, or its own.
    pub(crate) fn pressures<'a>(&self, mesh: &'a Mesh, cell: usize) -> Pressures<'a> {
        match self.enrichment {
            Enrichment::CellBubbles => Pressures::Linear(mesh.cell(cell)),
            Enrichment::FacetBubbles => Pressures::Constant(cell as u32),
        }
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> u64 {
        (12 * self.facets.len() + 24 * self.normals.len() + 4 * self.cell_facets.len()) as u64
    }
}

/// Pressure functions of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Pressures<'a> {
    /// Continuous P1: the barycentric coordinate of each corner, with the mesh vertices
    /// as unknowns.
    Linear(&'a [u32]),
    /// Constant on the cell; the number is that of the cell.
    Constant(u32),
}

impl Pressures<'_> {
    /// Pressure at barycentric coordinates.
    pub(crate) fn at(self, l: &[f64], pressure: &[f64]) -> f64 {
        match self {
            Self::Linear(corners) => corners
                .iter()
                .zip(l)
                .map(|(&v, l)| l * pressure[v as usize])
                .sum(),
            Self::Constant(cell) => pressure[cell as usize],
        }
    }
}

/// The shapes of a cell: its barycentric coordinates, then its bubbles.
fn shapes(corners: usize, enrichment: Enrichment) -> Vec<Shape> {
    let vertex = |v| Shape {
        vertices: vec![v],
        scale: 1.0,
    };
    let mut shapes: Vec<Shape> = (0..corners).map(vertex).collect();
    match enrichment {
        Enrichment::CellBubbles => shapes.push(Shape::bubble((0..corners).collect())),
        Enrichment::FacetBubbles => {
            let opposite = |v| Shape::bubble((0..corners).filter(|&w| w != v).collect());
            shapes.extend((0..corners).map(opposite));
        }
    }
    shapes
}

/// The vertices of a facet in ascending order, the third a stand-in where there are
/// two.
fn key(vertices: impl Iterator<Item = u32>) -> [u32; 3] {
    let mut key = [NO_VERTEX; 3];
    key.iter_mut().zip(vertices).for_each(|(slot, v)| *slot = v);
    key.sort_unstable();
    key
}

/// Unit normal of a facet in the order of its key; the same from both cells, so that
/// the bubbles of both agree.
fn normal(mesh: &Mesh, facet: &[u32; 3]) -> [f64; 3] {
    let point = |i: usize| mesh.coordinates()[facet[i] as usize];
    let along = sub(point(1), point(0));
    let area = match facet[2] {
        NO_VERTEX => [along[1], -along[0], 0.0],
        _ => cross(along, sub(point(2), point(0))),
    };
    scale(1.0 / norm(area), area)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::samples;

    #[test]
    fn every_shape_has_largest_value_one_and_the_slope_of_its_values() {
        for mesh in [samples::cube(1), samples::rectangle(1, 1)] {
            for enrichment in [Enrichment::CellBubbles, Enrichment::FacetBubbles] {
                let space = Enriched::new(&mesh, enrichment);
                let corners = space.components + 1;
                let l: Vec<f64> = (0..corners).map(|i| 0.1 + 0.07 * i as f64).collect();
                for shape in &space.shapes {
                    let share = 1.0 / shape.vertices.len() as f64;
                    let mut top = vec![0.0; corners];
                    shape.vertices.iter().for_each(|&v| top[v] = share);
                    assert!((shape.value(&top) - 1.0).abs() < 1e-14);
                    for v in 0..corners {
                        let mut g = vec![[0.0; 3]; corners];
                        g[v] = [1.0, 0.0, 0.0];
                        let moved = |h: f64| {
                            let mut l = l.clone();
                            l[v] += h;
                            shape.value(&l)
                        };
                        let slope = (moved(1e-6) - moved(-1e-6)) / 2e-6;
                        assert!((slope - shape.gradient(&l, &g)[0]).abs() < 1e-8);
                    }
                }
            }
        }
    }

    #[test]
    fn both_cells_at_a_facet_know_it_by_one_number() {
        // A cube of n^3 cells has 12 n^3 + 6 n^2 facets.
        let mesh = samples::cube(2);
        let space = Enriched::new(&mesh, Enrichment::FacetBubbles);
        assert_eq!(space.facets.len(), 12 * 8 + 6 * 4);
        assert_eq!(space.displacement_unknowns(), 3 * 27 + 120);
        let boundary = &mesh.boundary_facets()[0];
        let facet = space.facet(&boundary.vertices) as u32;
        let own = space.cell_facets[4 * boundary.cell as usize + usize::from(boundary.opposite)];
        assert_eq!(facet, own);
    }
}
