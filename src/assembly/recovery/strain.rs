//! The strain of a P2 displacement in a cell and the energy norm of a quadratic
//! strain field.
//!
//! Strains are `[xx, yy, xy]` or `[xx, yy, zz, xy, yz, zx]`, tensor components; in their place a whole
//! gradient may stand, row by row, with the pressure after it: as many numbers as the square of the
//! dimension and one.
//! eps(u_h) is linear in a straight cell: its values at the corners tell all. In a curved one they
//! stand for it.

use super::Recovery;
use super::fit::Quadratic;
use crate::assembly::load::shape_values;
use crate::element::curved_cell::CurvedCell;
use crate::element::quadrature::{Simplex, rule};
use crate::geometry::Matrix3;
use crate::parallel;

/// Strains at the nodes of a cell: corners, then edge midpoints.
pub(super) struct NodeStrains<const V: usize, const E: usize, const S: usize> {
    corners: [[f64; S]; V],
    edges: [[f64; S]; E],
}

impl<const V: usize, const E: usize, const S: usize> NodeStrains<V, E, S> {
    /// Corners, then edges.
    pub(super) fn nodes(&self) -> impl Iterator<Item = &[f64; S]> + Clone {
        self.corners.iter().chain(&self.edges)
    }
}

/// Row and column of each strain component.
const fn place(components: usize, strain: usize) -> (usize, usize) {
    match (components, strain) {
        (2, 2) => (0, 1),
        (_, 3) => (0, 1),
        (_, 4) => (1, 2),
        (_, 5) => (2, 0),
        (_, diagonal) => (diagonal, diagonal),
    }
}

/// The cells of a recovery.
pub(super) struct Cells<'a, const D: usize, const V: usize, const E: usize, const S: usize> {
    pub(super) problem: Recovery<'a>,
    /// eps(u_h) at the corners of each cell: every cell is read once a corner.
    strains: Vec<[[f64; S]; V]>,
}

impl<'a, const D: usize, const V: usize, const E: usize, const S: usize> Cells<'a, D, V, E, S> {
    pub(super) fn new(problem: Recovery<'a>) -> Self {
        let mut cells = Self {
            problem,
            strains: Vec::new(),
        };
        let count = problem.geometry.cells();
        cells.strains = parallel::map(count, 1, &|cell| cells.at_corners(cell));
        cells
    }

    /// Scaled position of a vertex.
    pub(super) fn vertex(&self, vertex: usize) -> [f64; 3] {
        self.problem.mesh.coordinates()[vertex].map(|x| x * self.problem.scale)
    }

    /// Strains at the corners.
    fn at_corners(&self, cell: usize) -> [[f64; S]; V] {
        let problem = &self.problem;
        let gradients = problem.geometry.gradients_of(cell);
        let value = |node: usize, i: usize| problem.displacement[node * D + i];
        let mut constant = [[0.0; D]; D];
        for (&vertex, slope) in problem.mesh.cell(cell).iter().zip(gradients) {
            add_product(&mut constant, 1.0, |i| value(vertex as usize, i), slope);
        }
        let mut corners = [constant; V];
        let pairs = problem.mesh.cell_kind().edges();
        let edges = &problem.mesh.cell_edges()[cell * E..(cell + 1) * E];
        for (&edge, &(a, b)) in edges.iter().zip(pairs) {
            let correction = |i| value(problem.space.vertices + edge as usize, i);
            add_product(&mut corners[a], 4.0, correction, &gradients[b]);
            add_product(&mut corners[b], 4.0, correction, &gradients[a]);
        }
        let curved = problem.geometry.curves.of(cell);
        let maps = curved.map(corner_maps::<V>);
        std::array::from_fn(|a| {
            let vertex = problem.mesh.cell(cell)[a] as usize;
            let pressure = problem.pressure.get(vertex).copied().unwrap_or(0.0);
            match &maps {
                Some(maps) => strain_of(&on_curved(&corners[a], &maps[a]), pressure),
                None => strain_of(&corners[a], pressure),
            }
        })
    }

    /// Calls `visit` with position and strain at points in barycentric
    /// coordinates.
    pub(super) fn visit(
        &self,
        cell: usize,
        points: &[[f64; 4]],
        mut visit: impl FnMut([f64; 3], &[f64; S]),
    ) {
        let corners = &self.strains[cell];
        let vertices = self.problem.mesh.cell(cell);
        let positions: [[f64; 3]; V] = std::array::from_fn(|a| self.vertex(vertices[a] as usize));
        for point in points {
            let (mut x, mut strain) = ([0.0; 3], [0.0; S]);
            for a in 0..V {
                for i in 0..D {
                    x[i] += point[a] * positions[a][i];
                }
                for s in 0..S {
                    strain[s] += point[a] * corners[a][s];
                }
            }
            visit(x, &strain);
        }
    }

    /// Mean of 2 mu |eps(u_h)|^2 + lambda (div u_h)^2: the P1 mass matrix has
    /// equal entries, and twice them on its diagonal.
    pub(super) fn energy(&self, cell: usize, [shear, lame]: [f64; 2]) -> f64 {
        let corners = &self.strains[cell];
        let sum: [f64; S] = std::array::from_fn(|s| corners.iter().map(|e| e[s]).sum());
        let own = corners.iter().map(|e| product::<V, S>(e, e, shear, lame));
        let all = product::<V, S>(&sum, &sum, shear, lame) + own.sum::<f64>();
        all / (V * (V + 1)) as f64
    }

    /// eps(u_h) at the nodes.
    fn at_nodes(&self, cell: usize) -> NodeStrains<V, E, S> {
        let corners = self.strains[cell];
        let pairs = self.problem.mesh.cell_kind().edges();
        let edges = std::array::from_fn(|edge| {
            let (a, b) = pairs[edge];
            std::array::from_fn(|s| 0.5 * (corners[a][s] + corners[b][s]))
        });
        NodeStrains { corners, edges }
    }

    /// e* - eps(u_h) at the nodes, e* from the polynomials at the corners.
    pub(super) fn difference<'b, const M: usize>(
        &self,
        cell: usize,
        polynomial: impl Fn(usize) -> &'b Quadratic<M, S>,
    ) -> NodeStrains<V, E, S> {
        let mut out = self.at_nodes(cell);
        let vertices = self.problem.mesh.cell(cell);
        let positions: [[f64; 3]; V] = std::array::from_fn(|a| self.vertex(vertices[a] as usize));
        for (corner, value) in out.corners.iter_mut().enumerate() {
            let recovered = polynomial(corner).at_centre();
            *value = std::array::from_fn(|s| recovered[s] - value[s]);
        }
        let pairs = self.problem.mesh.cell_kind().edges();
        for (&(a, b), value) in pairs.iter().zip(&mut out.edges) {
            let half: [f64; 3] = std::array::from_fn(|i| 0.5 * (positions[b][i] - positions[a][i]));
            let one = polynomial(a).at::<D>(half);
            let other = polynomial(b).at::<D>(half.map(|x| -x));
            *value = std::array::from_fn(|s| 0.5 * (one[s] + other[s]) - value[s]);
        }
        out
    }
}

/// F0^-1 at the corners of a cell.
fn corner_maps<const V: usize>(curved: &CurvedCell) -> [Matrix3; V] {
    std::array::from_fn(|a| {
        let mut at = [0.0; V];
        at[a] = 1.0;
        curved.map(&at).inverse
    })
}

/// A gradient on the straight cell as one on the curved one.
fn on_curved<const D: usize>(straight: &[[f64; D]; D], inverse: &Matrix3) -> [[f64; D]; D] {
    straight.map(|row| std::array::from_fn(|j| (0..D).map(|k| row[k] * inverse[k][j]).sum()))
}

fn add_product<const D: usize>(
    matrix: &mut [[f64; D]; D],
    factor: f64,
    left: impl Fn(usize) -> f64,
    right: &[f64; 3],
) {
    for (i, row) in matrix.iter_mut().enumerate() {
        let value = factor * left(i);
        for (entry, slope) in row.iter_mut().zip(right) {
            *entry += value * slope;
        }
    }
}

/// The strain of a gradient, or all of it and the pressure.
fn strain_of<const D: usize, const S: usize>(gradient: &[[f64; D]; D], pressure: f64) -> [f64; S] {
    std::array::from_fn(|s| {
        if S == D * D + 1 {
            return gradient.as_flattened().get(s).copied().unwrap_or(pressure);
        }
        let (i, j) = place(D, s);
        0.5 * (gradient[i][j] + gradient[j][i])
    })
}

/// Mean products of the P2 Lagrange functions over a cell.
pub(super) struct EnergyForm<const V: usize, const E: usize, const S: usize> {
    /// Lower triangle `[nodes, nodes]`, corners first, doubled off the diagonal.
    means: Vec<Vec<f64>>,
}

impl<const V: usize, const E: usize, const S: usize> EnergyForm<V, E, S> {
    pub(super) fn new() -> Self {
        let simplex = match V {
            3 => Simplex::Triangle,
            _ => Simplex::Tetrahedron,
        };
        let rule = rule(simplex, 4);
        let mut means: Vec<Vec<f64>> = (1..=V + E).map(|length| vec![0.0; length]).collect();
        for (point, weight) in rule.points.iter().zip(&rule.weights) {
            let values = lagrange::<V>(&point[..V]);
            for (a, row) in means.iter_mut().enumerate() {
                for (b, mean) in row.iter_mut().enumerate().take(a + 1) {
                    let twice = if a == b { 1.0 } else { 2.0 };
                    *mean += twice * weight * values[a] * values[b];
                }
            }
        }
        Self { means }
    }

    /// Mean of 2 mu |e|^2 + lambda (tr e)^2 over the cell.
    pub(super) fn square(&self, strains: &NodeStrains<V, E, S>, shear: f64, lame: f64) -> f64 {
        let nodes = strains.nodes();
        let mut sum = 0.0;
        for (a, row) in nodes.clone().zip(&self.means) {
            let mut image = [0.0; S];
            for (b, mean) in nodes.clone().zip(row) {
                for s in 0..S {
                    image[s] += mean * b[s];
                }
            }
            sum += product::<V, S>(a, &image, shear, lame);
        }
        sum
    }
}

/// 2 mu a:b + lambda tr a tr b.
fn product<const V: usize, const S: usize>(
    a: &[f64; S],
    b: &[f64; S],
    shear: f64,
    lame: f64,
) -> f64 {
    let components = V - 1;
    let (mut diagonal, mut rest, mut traces) = (0.0, 0.0, [0.0; 2]);
    for s in 0..S {
        if s < components {
            diagonal += a[s] * b[s];
            traces[0] += a[s];
            traces[1] += b[s];
        } else {
            rest += a[s] * b[s]
        }
    }
    2.0 * shear * (diagonal + 2.0 * rest) + lame * traces[0] * traces[1]
}

/// P2 Lagrange functions: corners, then edges.
pub(super) fn lagrange<const V: usize>(l: &[f64]) -> Vec<f64> {
    let mut values = shape_values(l);
    for (value, l) in values.iter_mut().zip(&l[..V]) {
        *value = l * (2.0 * l - 1.0);
    }
    values
}
