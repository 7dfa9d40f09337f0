//! The two cells and their local numbering.
//!
//! Local edges are (low, high) pairs in lexicographic order. Local facet i lies
//! opposite vertex i; its vertices are ordered so that, in a cell of positive
//! measure, the facet's normal points outwards: (b − a) × (c − a) for a
//! triangle (a, b, c), (t_y, −t_x) for a line with t = b − a.

use crate::geometry::vector3::{cross, dot, max_norm, scale, sub};

/// Shape of all cells of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CellKind {
    /// Three vertices, in the plane z = 0, counter-clockwise.
    Triangle,
    /// Four vertices, the fourth on the side of the right-hand normal of the first three.
    Tetrahedron,
}

impl CellKind {
    /// Vertices of a cell: 3 or 4.
    pub fn vertices(self) -> usize {
        match self {
            Self::Triangle => 3,
            Self::Tetrahedron => 4,
        }
    }

    /// 2 or 3.
    pub fn dimension(self) -> usize {
        self.vertices() - 1
    }

    /// Vertices of a facet (a line or a triangle): 2 or 3.
    pub fn facet_vertices(self) -> usize {
        self.vertices() - 1
    }

    /// Local vertex pairs of the edges: 3 or 6.
    pub fn edges(self) -> &'static [(usize, usize)] {
        match self {
            Self::Triangle => &[(0, 1), (0, 2), (1, 2)],
            Self::Tetrahedron => &[(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)],
        }
    }

    /// Local vertices of the facets, the i-th opposite vertex i, oriented outwards.
    pub fn facets(self) -> &'static [&'static [usize]] {
        match self {
            Self::Triangle => &[&[1, 2], &[2, 0], &[0, 1]],
            Self::Tetrahedron => &[&[1, 2, 3], &[0, 3, 2], &[0, 1, 3], &[0, 2, 1]],
        }
    }

    /// Signed area or volume of the cell with the given corners; the fourth
    /// corner of a triangle is not read.
    pub fn signed_measure(self, corners: &[[f64; 3]; 4]) -> f64 {
        let first = sub(corners[1], corners[0]);
        let second = sub(corners[2], corners[0]);
        match self {
            Self::Triangle => 0.5 * cross(first, second)[2],
            Self::Tetrahedron => dot(cross(first, second), sub(corners[3], corners[0])) / 6.0,
        }
    }

    /// Measure and sum of squared edge lengths of the cell scaled so that its
    /// longest edge component is 1: free of overflow and of units. Cells
    /// without extent, or of infinite extent, give NaN.
    pub(crate) fn scaled_measures(self, corners: &[[f64; 3]; 4]) -> ScaledMeasures {
        let mut edges = [[0.0; 3]; 6];
        for (edge, &(low, high)) in edges.iter_mut().zip(self.edges()) {
            *edge = sub(corners[high], corners[low]);
        }
        let extent = edges
            .iter()
            .fold(0.0, |most: f64, &edge| most.max(max_norm(edge)));
        let edges = edges.map(|edge| edge.map(|component| component / extent));
        let squares = edges.map(|edge| dot(edge, edge));
        let measure = match self {
            Self::Triangle => 0.5 * cross(edges[0], edges[1])[2],
            Self::Tetrahedron => dot(cross(edges[0], edges[1]), edges[2]) / 6.0,
        };
        ScaledMeasures {
            measure,
            sum_of_squares: squares.iter().sum(),
            longest: squares
                .iter()
                .fold(0.0, |most: f64, &square| most.max(square))
                .sqrt(),
        }
    }
}

/// Sizes of one cell after scaling; see [`CellKind::scaled_measures`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct ScaledMeasures {
    /// Signed area or volume of the scaled cell; negative where the cell is inverted.
    pub(crate) measure: f64,
    /// Sum of the squared lengths of the edges, Σ l² after scaling.
    pub(crate) sum_of_squares: f64,
    /// Length of the longest edge after scaling, between 1 and √3.
    pub(crate) longest: f64,
}

/// Gradients of the barycentric coordinates `[vertices, 3]` of a cell of positive
/// measure; unused rows are zero. Row i has length 1/height above facet i.
pub fn barycentric_gradients(kind: CellKind, corners: &[[f64; 3]; 4]) -> [[f64; 3]; 4] {
    let mut gradients = [[0.0; 3]; 4];
    let measure = kind.signed_measure(corners);
    for (gradient, facet) in gradients.iter_mut().zip(kind.facets()) {
        *gradient = match kind {
            CellKind::Triangle => {
                let tangent = sub(corners[facet[1]], corners[facet[0]]);
                scale(-0.5 / measure, [tangent[1], -tangent[0], 0.0])
            }
            CellKind::Tetrahedron => {
                let first = sub(corners[facet[1]], corners[facet[0]]);
                let second = sub(corners[facet[2]], corners[facet[0]]);
                scale(-1.0 / (6.0 * measure), cross(first, second))
            }
        };
    }
    gradients
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::vector3::{add, norm};

    const TETRAHEDRON: [[f64; 3]; 4] = [
        [0.1, 0.0, 0.0],
        [1.0, 0.2, 0.0],
        [0.0, 1.5, 0.1],
        [0.2, 0.3, 0.9],
    ];
    const TRIANGLE: [[f64; 3]; 4] = [[0.1, 0.0, 0.0], [1.0, 0.2, 0.0], [0.3, 1.5, 0.0], [0.0; 3]];

    fn samples() -> [(CellKind, [[f64; 3]; 4]); 2] {
        [
            (CellKind::Triangle, TRIANGLE),
            (CellKind::Tetrahedron, TETRAHEDRON),
        ]
    }

    #[test]
    fn barycentric_gradients_reproduce_the_coordinates() {
        for (kind, corners) in samples() {
            let gradients = barycentric_gradients(kind, &corners);
            for row in 0..kind.vertices() {
                for vertex in 0..kind.vertices() {
                    let rise = dot(gradients[row], sub(corners[vertex], corners[0]));
                    let expected =
                        f64::from(u8::from(row == vertex)) - f64::from(u8::from(row == 0));
                    assert!((rise - expected).abs() < 1e-14, "{kind:?} {row} {vertex}");
                }
            }
        }
    }

    #[test]
    fn barycentric_gradients_sum_to_zero() {
        for (kind, corners) in samples() {
            let sum = barycentric_gradients(kind, &corners)
                .into_iter()
                .fold([0.0; 3], add);
            assert!(norm(sum) < 1e-14);
        }
    }

    #[test]
    fn facet_normals_point_away_from_the_opposite_vertex() {
        let kind = CellKind::Tetrahedron;
        for (opposite, facet) in kind.facets().iter().enumerate() {
            let [a, b, c] = [facet[0], facet[1], facet[2]].map(|vertex| TETRAHEDRON[vertex]);
            let normal = cross(sub(b, a), sub(c, a));
            assert!(dot(normal, sub(TETRAHEDRON[opposite], a)) < 0.0);
        }
        for (opposite, facet) in CellKind::Triangle.facets().iter().enumerate() {
            let [a, b] = [facet[0], facet[1]].map(|vertex| TRIANGLE[vertex]);
            let tangent = sub(b, a);
            let normal = [tangent[1], -tangent[0], 0.0];
            assert!(dot(normal, sub(TRIANGLE[opposite], a)) < 0.0);
        }
    }

    #[test]
    fn swapping_two_vertices_changes_the_sign_of_the_measure() {
        for (kind, corners) in samples() {
            let mut swapped = corners;
            swapped.swap(1, 2);
            let (before, after) = (kind.signed_measure(&corners), kind.signed_measure(&swapped));
            assert!(before > 0.1);
            assert!((before + after).abs() < 1e-15);
        }
    }
}
