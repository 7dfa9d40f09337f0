//! Corners, edges and faces of elements, all numbered from 0.
//!
//! Nodes are corners first, then middles of edges in the order of [`ElementKind::edges`], then
//! centres of faces. That is the order of VTK and Abaqus, but for the tetrahedron of ten nodes,
//! which is that of Gmsh. Faces are in the order of Abaqus (`S1`, `S2`, ...), their normals by the
//! right hand point into a cell that is not inverted.

use super::raw::ElementKind;

/// Local corners of the faces of a cell, or of the sides of an element of the plane.
type Faces = &'static [&'static [usize]];

const TRIANGLE: Faces = &[&[0, 1], &[1, 2], &[2, 0]];
const QUADRANGLE: Faces = &[&[0, 1], &[1, 2], &[2, 3], &[3, 0]];
const TETRAHEDRON: Faces = &[&[0, 1, 2], &[0, 3, 1], &[1, 3, 2], &[2, 3, 0]];
const PYRAMID: Faces = &[
    &[0, 1, 2, 3],
    &[0, 4, 1],
    &[1, 4, 2],
    &[2, 4, 3],
    &[3, 4, 0],
];
const WEDGE: Faces = &[
    &[0, 1, 2],
    &[3, 5, 4],
    &[0, 3, 4, 1],
    &[1, 4, 5, 2],
    &[2, 5, 3, 0],
];
const HEXAHEDRON: Faces = &[
    &[0, 1, 2, 3],
    &[4, 7, 6, 5],
    &[0, 4, 5, 1],
    &[1, 5, 6, 2],
    &[2, 6, 7, 3],
    &[3, 7, 4, 0],
];

/// Ends of the edges that have middles, in the order of these.
type Edges = &'static [(usize, usize)];

const OF_LINE: Edges = &[(0, 1)];
const OF_TRIANGLE: Edges = &[(0, 1), (1, 2), (0, 2)];
const OF_QUADRANGLE: Edges = &[(0, 1), (1, 2), (2, 3), (3, 0)];
/// In the order of Gmsh: Abaqus and VTK have the last two the other way round.
const OF_TETRAHEDRON: Edges = &[(0, 1), (1, 2), (0, 2), (0, 3), (2, 3), (1, 3)];
const OF_PYRAMID: Edges = &[
    (0, 1),
    (1, 2),
    (2, 3),
    (3, 0),
    (0, 4),
    (1, 4),
    (2, 4),
    (3, 4),
];
const OF_WEDGE: Edges = &[
    (0, 1),
    (1, 2),
    (2, 0),
    (3, 4),
    (4, 5),
    (5, 3),
    (0, 3),
    (1, 4),
    (2, 5),
];
const OF_HEXAHEDRON: Edges = &[
    (0, 1),
    (1, 2),
    (2, 3),
    (3, 0),
    (4, 5),
    (5, 6),
    (6, 7),
    (7, 4),
    (0, 4),
    (1, 5),
    (2, 6),
    (3, 7),
];

impl ElementKind {
    /// Corners, which come first among the nodes of an element.
    pub(crate) fn vertices(self) -> usize {
        match (self.dimension, self.nodes) {
            (2, 4 | 8 | 9) => 4,
            (3, 5 | 13 | 14) => 5,
            (3, 6 | 15 | 18) => 6,
            (3, 8 | 20 | 27) => 8,
            (dimension, _) => dimension + 1,
        }
    }

    /// Ends of the edge of each node that follows the corners; none of first order.
    pub(crate) fn edges(self) -> Edges {
        match (self.dimension, self.nodes) {
            (1, 3) => OF_LINE,
            (2, 6) => OF_TRIANGLE,
            (2, 8 | 9) => OF_QUADRANGLE,
            (3, 10) => OF_TETRAHEDRON,
            (3, 13 | 14) => OF_PYRAMID,
            (3, 15 | 18) => OF_WEDGE,
            (3, 20 | 27) => OF_HEXAHEDRON,
            _ => &[],
        }
    }

    /// Local corners of the faces; of an element of the plane, of its sides.
    pub(crate) fn faces(self) -> Faces {
        match (self.dimension, self.vertices()) {
            (2, 3) => TRIANGLE,
            (2, 4) => QUADRANGLE,
            (3, 4) => TETRAHEDRON,
            (3, 5) => PYRAMID,
            (3, 6) => WEDGE,
            (3, 8) => HEXAHEDRON,
            _ => &[],
        }
    }

    /// The node in the middle of a face of four corners, where the element has one.
    pub(crate) fn centre(self, face: usize) -> Option<usize> {
        let centres: &[usize] = match (self.dimension, self.nodes) {
            (2, 9) => &[8],
            (3, 14) => &[13],
            (3, 18) => &[18, 18, 15, 16, 17],
            (3, 27) => &[24, 25, 22, 21, 23, 20],
            _ => &[],
        };
        let found = centres.get(face).copied();
        found.filter(|node| *node < self.nodes)
    }

    /// Its name, of many, where it is no simplex.
    pub(crate) fn composite(self) -> Option<&'static str> {
        match (self.dimension, self.vertices()) {
            (2, 4) => Some("quadrangles"),
            (3, 5) => Some("pyramids"),
            (3, 6) => Some("wedges"),
            (3, 8) => Some("hexahedra"),
            _ => None,
        }
    }
}
