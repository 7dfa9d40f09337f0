//! Facets of a mesh under bisection: each is halved over the edge that the cells behind it halve
//! first, until its edges are whole.
//!
//! A child knows its place in the facet that it comes from by the barycentric coordinates of its
//! vertices, dyadic and so exact, from which quadratics on the facet follow:
//!
//! ```text
//! f = L . F L on the parent,  L = P^T l on the child:   F_child = P F P^T
//! ```
//!
//! P is not negative and its rows sum to one: coefficients of Bernstein polynomials that are not
//! negative stay so. Cost: one look-up a facet, new ones included.

use super::edges::Edges;
use crate::mesh::Mesh;

/// Where a facet of a refined mesh lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FacetOrigin {
    /// The facet of the earlier mesh, 0-based.
    pub facet: u32,
    /// Barycentric coordinates in it of the facet's vertices `[vertices][3]`, both in the order of
    /// their meshes; rows and columns beyond the vertices are zero.
    pub corners: [[f64; 3]; 3],
}

/// A facet on the way: of a line the third vertex repeats the second.
#[derive(Clone, Copy)]
pub(super) struct Piece {
    pub(super) vertices: [u32; 3],
    /// Ends of the edge that is halved first.
    edge: [u32; 2],
    pub(super) origin: FacetOrigin,
}

/// Mean of two points in barycentric coordinates.
fn between(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| 0.5 * (a[i] + b[i]))
}

impl Piece {
    /// A whole facet, halved first over `edge`.
    pub(super) fn whole(facet: usize, vertices: &[u32], edge: [u32; 2]) -> Self {
        let unit = |i: usize| std::array::from_fn(|j| f64::from(u8::from(i == j)));
        let width = vertices.len();
        let zero = [0.0; 3];
        Self {
            vertices: std::array::from_fn(|i| vertices[i.min(width - 1)]),
            edge,
            origin: FacetOrigin {
                facet: facet as u32,
                corners: std::array::from_fn(|i| if i < width { unit(i) } else { zero }),
            },
        }
    }

    /// Ends of the edge that is halved first.
    pub(super) fn edge(&self) -> [u32; 2] {
        self.edge
    }

    /// The halves over the middle of its edge.
    fn halves(&self, width: usize, middle: u32) -> [Self; 2] {
        let own = &self.vertices[..width];
        let place = |vertex: u32| own.iter().position(|&other| other == vertex).unwrap_or(0);
        let [i, j] = self.edge.map(place);
        let corners = self.origin.corners;
        let at_middle = between(corners[i], corners[j]);
        [[i, j], [j, i]].map(|[kept, replaced]| {
            let mut half = *self;
            half.vertices[replaced] = middle;
            if width == 2 {
                half.vertices[2] = half.vertices[1];
            }
            half.origin.corners[replaced] = at_middle;
            // Opposite the new vertex; of a line what is left of it.
            let third = (0..width).find(|&local| local != i && local != j);
            half.edge = [self.vertices[kept], third.map_or(middle, |k| own[k])];
            half
        })
    }
}

/// The pieces of `facets` whose edges are whole, those of a facet one after the other.
pub(super) fn pieces(mesh: &Mesh, facets: Vec<Piece>, edges: &Edges<'_>) -> Vec<Piece> {
    let width = mesh.cell_kind().facet_vertices();
    let mut found = Vec::with_capacity(facets.len());
    for facet in facets {
        let mut open = vec![facet];
        while let Some(piece) = open.pop() {
            match edges.middle(piece.edge[0], piece.edge[1]) {
                None => found.push(piece),
                Some(middle) => {
                    let [first, second] = piece.halves(width, middle);
                    open.extend([second, first]);
                }
            }
        }
    }
    found
}
