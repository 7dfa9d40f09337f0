//! How fields of a mesh continue on its refinement: what is piecewise quadratic or linear there is
//! so here, and keeps its values to rounding. On curved cells, too: halves follow the map of their
//! parent. Cost: some operations a new vertex and edge.

use super::edges::{Edges, Middle, Recipe};
use super::surface::FacetOrigin;
use crate::mesh::Mesh;

/// Where vertices, edges, cells and facets of a refined mesh come from.
#[derive(Clone, Debug)]
pub struct Lineage {
    /// Vertices and edges of the earlier mesh.
    before: [usize; 2],
    /// Vertices that are new, numbered after the earlier ones.
    middles: Vec<Middle>,
    /// Edges that are new, those that were halved again included, numbered after the earlier ones.
    recipes: Vec<Recipe>,
    /// Place of each edge of the refined mesh among earlier and new ones `[edges]`.
    edges: Vec<u32>,
    /// Earlier cell of each cell `[cells]`.
    cells: Vec<u32>,
    /// Earlier facet of each facet `[facets]`.
    facets: Vec<FacetOrigin>,
}

impl Lineage {
    /// Of `refined`, the mesh of these edges, with what is known of its cells and facets.
    pub(super) fn new(
        [mesh, refined]: [&Mesh; 2],
        edges: Edges<'_>,
        cells: Vec<u32>,
        facets: Vec<FacetOrigin>,
    ) -> Self {
        let own = refined.edges().iter();
        Self {
            before: [mesh.coordinates().len(), mesh.edges().len()],
            // All edges of the refined mesh are known.
            edges: own.filter_map(|&[a, b]| edges.number(a, b)).collect(),
            middles: edges.middles,
            recipes: edges.recipes,
            cells,
            facets,
        }
    }

    /// The earlier cell of each cell, 0-based `[cells]`.
    pub fn cells(&self) -> &[u32] {
        &self.cells
    }

    /// The earlier facet of each facet of the mesh, and the place in it `[facets]`.
    pub fn facets(&self) -> &[FacetOrigin] {
        &self.facets
    }

    /// Vertices and edges of the earlier mesh, then of the refined one.
    pub(crate) fn sizes(&self) -> [[usize; 2]; 2] {
        let vertices = self.before[0] + self.middles.len();
        [self.before, [vertices, self.edges.len()]]
    }

    /// Number of vertices that are new.
    pub fn new_vertices(&self) -> usize {
        self.middles.len()
    }

    /// A hierarchical P2 field of that many components, vertices first
    /// `[nodes * components]`, on the refined mesh; missing values count as zero.
    pub fn quadratic(&self, field: &[f64], components: usize) -> Vec<f64> {
        let [vertices, edges] = self.before.map(|count| count * components);
        let mut at_vertices = resized(field.get(..vertices).unwrap_or(field), vertices);
        let at_edges = resized(field.get(vertices..).unwrap_or_default(), edges);
        let at_edges = continued(&self.recipes, at_edges, components);
        for middle in &self.middles {
            let [a, b, e] = [middle.ends[0], middle.ends[1], middle.edge]
                .map(|place| place as usize * components);
            for i in 0..components {
                let mean = 0.5 * (at_vertices[a + i] + at_vertices[b + i]);
                at_vertices.push(mean + at_edges[e + i]);
            }
        }
        for &edge in &self.edges {
            let first = edge as usize * components;
            at_vertices.extend_from_slice(&at_edges[first..first + components]);
        }
        at_vertices
    }

    /// A P1 field `[vertices]` on the refined mesh; missing values count as zero.
    pub fn linear(&self, field: &[f64]) -> Vec<f64> {
        let mut values = resized(field, self.before[0]);
        for middle in &self.middles {
            let [a, b] = middle.ends.map(|end| values[end as usize]);
            values.push(0.5 * (a + b));
        }
        values
    }

    /// Values of cells `[cells]` on the cells of the refined mesh; missing ones are left out.
    pub fn of_cells<T: Copy>(&self, values: &[T]) -> Vec<T> {
        let cells = self.cells.iter();
        cells
            .filter_map(|&cell| values.get(cell as usize).copied())
            .collect()
    }
}

/// The first `count` numbers, zeros where there are fewer.
fn resized(values: &[f64], count: usize) -> Vec<f64> {
    let mut values = values[..count.min(values.len())].to_vec();
    values.resize(count, 0.0);
    values
}

/// Corrections `[edges * components]`, middle less mean of the ends, with those of new edges.
pub(super) fn continued(recipes: &[Recipe], mut values: Vec<f64>, components: usize) -> Vec<f64> {
    values.reserve(recipes.len() * components);
    for recipe in recipes {
        let shares = recipe.shares();
        for i in 0..components {
            let parts = shares.map(|(edge, share)| share * values[edge as usize * components + i]);
            values.push(parts.iter().sum());
        }
    }
    values
}
