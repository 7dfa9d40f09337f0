//! A curved triangle of six nodes:
//!
//! ```text
//! x = sum l_k x_k + 4 (l_0 l_1 m_3 + l_0 l_2 m_4 + l_1 l_2 m_5),   l_0 = 1 - l_1 - l_2
//! ```
//!
//! x_k its corners, m the places of the middles of its edges less the means of their ends. Slopes are
//! by l_1 and l_2. Cost: some 30 flops a value.

use crate::geometry::vector3::{add, cross, scale, sub};

/// Nodes of a face: corners, then edges (0,1), (0,2), (1,2).
pub const NODES: usize = 6;
/// Corners of the edges, in their order.
pub const EDGES: [[usize; 2]; 3] = [[0, 1], [0, 2], [1, 2]];

/// Place on a face: l_1 and l_2.
pub type At = [f64; 2];

/// Where nodes are: of a vertex its place, of an edge that of its middle less the mean of its ends.
pub type PlaceOf<'a> = dyn Fn(u32) -> [f64; 3] + Sync + 'a;

/// A face where it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// Corners, and what edges are off the means of their ends `[6][3]`.
    pub nodes: [[f64; 3]; NODES],
}

/// Values of the nodes' functions at a place.
pub fn values([s, t]: At) -> [f64; NODES] {
    let r = 1.0 - s - t;
    [r, s, t, 4.0 * r * s, 4.0 * r * t, 4.0 * s * t]
}

/// Their slopes by l_1 and by l_2.
pub fn slopes([s, t]: At) -> [[f64; NODES]; 2] {
    let r = 1.0 - s - t;
    [
        [-1.0, 1.0, 0.0, 4.0 * (r - s), -4.0 * t, 4.0 * t],
        [-1.0, 0.0, 1.0, -4.0 * s, 4.0 * (r - t), 4.0 * s],
    ]
}

/// l_0^2, l_1^2, l_2^2, 2 l_0 l_1, 2 l_0 l_2, 2 l_1 l_2.
pub fn bernstein([s, t]: At) -> [f64; NODES] {
    let r = 1.0 - s - t;
    [r * r, s * s, t * t, 2.0 * r * s, 2.0 * r * t, 2.0 * s * t]
}

impl Patch {
    fn sum(&self, factors: &[f64; NODES]) -> [f64; 3] {
        let terms = self.nodes.iter().zip(factors);
        terms.fold([0.0; 3], |sum, (node, factor)| {
            add(sum, scale(*factor, *node))
        })
    }

    /// The point at a place.
    pub fn point(&self, at: At) -> [f64; 3] {
        self.sum(&values(at))
    }

    /// The tangents x_,1 and x_,2.
    pub fn tangents(&self, at: At) -> [[f64; 3]; 2] {
        slopes(at).map(|slopes| self.sum(&slopes))
    }

    /// x_,11, x_,12 and x_,22, the same everywhere.
    pub fn bends(&self) -> [[f64; 3]; 3] {
        let [_, _, _, m, n, o] = self.nodes;
        let mixed = sub(o, add(m, n));
        [scale(-8.0, m), scale(4.0, mixed), scale(-8.0, n)]
    }

    /// x_,1 x x_,2, out of the body.
    pub fn area_vector(&self, at: At) -> [f64; 3] {
        let [first, second] = self.tangents(at);
        cross(first, second)
    }

    /// Points whose hull the face is in: corners, and control points of its edges.
    pub fn hull(&self) -> [[f64; 3]; NODES] {
        let mut hull = self.nodes;
        for (edge, [a, b]) in EDGES.iter().enumerate() {
            let ends = scale(0.5, add(self.nodes[*a], self.nodes[*b]));
            hull[3 + edge] = add(ends, scale(2.0, self.nodes[3 + edge]));
        }
        hull
    }
}
