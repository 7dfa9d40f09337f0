//! A cell whose edges are curved, as a stress-free deformation of the straight one:
//!
//! ```text
//! X(l) = sum L_v X_v + sum 4 L_a L_b o_e,   F0 = I + grad o = sum_j l_j (I + O_j)
//! grad u -> grad u F0^-1,   dV -> det F0 dV
//! ```
//!
//! O_j the gradient of the offsets o at vertex j on the straight cell, on which they are linear. In
//! the plane F0 is one out of it. Orders of
//! convergence are those of straight boundaries where the boundary is curved (Ciarlet, The Finite
//! Element Method for Elliptic Problems, 4.3). Cost: some 100 flops a point.

use super::jacobian::{least_jacobian_bound, most_jacobian_bound};
use crate::geometry::tensor::{Tensor, cofactor, contract, plus, plus_unit, scaled, transposed};

/// Edges of a tetrahedron, the most that a cell has.
pub const MOST_EDGES: usize = 6;

/// The curved edges of a cell.
#[derive(Clone, Copy, Debug, Default)]
pub struct CurvedCell {
    /// Gradients of the offsets at the vertices `[4][3][3]`, zero beyond those of the cell.
    pub slopes: [Tensor<f64>; 4],
    /// Offsets of the edges `[6][3]`, zero beyond those of the cell.
    pub offsets: [[f64; 3]; MOST_EDGES],
    /// Vertices of the cell.
    vertices: usize,
}

/// What a curved cell is at a point of the straight one.
#[derive(Clone, Copy, Debug)]
pub struct CellMap {
    /// F0^-1 `[3, 3]`.
    pub inverse: Tensor<f64>,
    /// det F0.
    pub measure: f64,
}

impl CurvedCell {
    /// Of a cell with these barycentric `gradients` `[vertices][3]`, ends of edges and offsets.
    pub fn new(
        gradients: &[[f64; 3]],
        pairs: &[(usize, usize)],
        offsets: [[f64; 3]; MOST_EDGES],
    ) -> Self {
        let mut slopes = [[[0.0; 3]; 3]; 4];
        for (&(a, b), offset) in pairs.iter().zip(&offsets) {
            for (at, along) in [(a, gradients[b]), (b, gradients[a])] {
                for (row, o) in slopes[at].iter_mut().zip(offset) {
                    (row.iter_mut().zip(along)).for_each(|(entry, g)| *entry += 4.0 * o * g);
                }
            }
        }
        Self {
            slopes,
            offsets,
            vertices: gradients.len(),
        }
    }

    /// grad o at barycentric coordinates `l` `[3, 3]`.
    pub fn slope_at(&self, l: &[f64]) -> Tensor<f64> {
        let mut slope = [[0.0; 3]; 3];
        for (share, own) in l.iter().zip(&self.slopes) {
            slope = plus(&slope, *share, own);
        }
        slope
    }

    /// F0 and its inverse at barycentric coordinates `l`.
    pub fn map(&self, l: &[f64]) -> CellMap {
        let base = plus_unit(&self.slope_at(l));
        let turned = cofactor(&base);
        let measure = contract(&base, &turned) / 3.0;
        CellMap {
            inverse: scaled(measure.recip(), &transposed(&turned)),
            measure,
        }
    }

    /// How far the point at `l` is off the straight cell `[3]`; `pairs` are the ends of edges.
    pub fn offset_at(&self, l: &[f64], pairs: &[(usize, usize)]) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for (&(a, b), offset) in pairs.iter().zip(&self.offsets) {
            (sum.iter_mut().zip(offset)).for_each(|(x, o)| *x += 4.0 * l[a] * l[b] * o);
        }
        sum
    }

    /// A number that det F0 is nowhere below.
    pub fn least_measure(&self) -> f64 {
        let corners = self.slopes.map(|slope| plus_unit(&slope));
        least_jacobian_bound(&corners[..self.vertices])
    }

    /// A number that det F0 is nowhere above.
    pub fn most_measure(&self) -> f64 {
        let corners = self.slopes.map(|slope| plus_unit(&slope));
        most_jacobian_bound(&corners[..self.vertices])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::tensor::product;

    const PAIRS: [(usize, usize); 6] = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];
    /// Of the unit tetrahedron.
    const GRADIENTS: [[f64; 3]; 4] = [
        [-1.0, -1.0, -1.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
    ];

    fn bent() -> CurvedCell {
        let wave = |e: usize, i: usize| 0.08 * (1.0 + (3 * e + i) as f64).sin();
        let offsets = std::array::from_fn(|e| std::array::from_fn(|i| wave(e, i)));
        CurvedCell::new(&GRADIENTS, &PAIRS, offsets)
    }

    fn barycentric(x: [f64; 3]) -> [f64; 4] {
        [1.0 - x[0] - x[1] - x[2], x[0], x[1], x[2]]
    }

    #[test]
    fn the_map_is_the_derivative_of_the_offsets() {
        let (cell, x) = (bent(), [0.2, 0.3, 0.15]);
        let map = cell.map(&barycentric(x));
        let mut slope = [[0.0; 3]; 3];
        for j in 0..3 {
            let at = |by: f64| {
                let mut moved = x;
                moved[j] += by;
                cell.offset_at(&barycentric(moved), &PAIRS)
            };
            let (above, below) = (at(0.5), at(-0.5));
            (0..3).for_each(|i| slope[i][j] = above[i] - below[i]);
        }
        let unit = product(&plus_unit(&slope), &map.inverse);
        let rest = plus(&unit, -1.0, &plus_unit(&[[0.0; 3]; 3]));
        let most = rest
            .as_flattened()
            .iter()
            .fold(0.0_f64, |a, b| a.max(b.abs()));
        assert!(most < 1e-14, "{most}");
    }

    #[test]
    fn no_measure_is_below_its_bound() {
        let cell = bent();
        let steps = 0..=8;
        let points = steps.flat_map(|i| (0..=8 - i).map(move |j| [i, j]));
        let measures = points.map(|[i, j]| {
            let x = [f64::from(i) / 8.0, f64::from(j) / 8.0, 0.0];
            cell.map(&barycentric(x)).measure
        });
        let measures = measures.fold([f64::INFINITY, 0.0_f64], |[a, b], x| [a.min(x), b.max(x)]);
        let [least, most] = measures;
        assert!(cell.least_measure() <= least && least < 1.0, "{least}");
        assert!(cell.most_measure() >= most && most > 1.0, "{most}");
    }
}
