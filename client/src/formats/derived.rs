//! Fields that are computed from others, for pictures:
//!
//! ```text
//! von Mises             q = sqrt(3/2 s : s),  s = stress - tr(stress)/3 I
//! principal stresses    eigenvalues of the stress
//! principal stretches   square roots of the eigenvalues of F^T F,  F = I + grad u
//! ```
//!
//! Stresses are those of the cells, stretches those at the centroids of cells with straight
//! edges. Principal values descend. Cost: some hundred operations a cell.

use super::vtu::Grid;

/// A matrix by rows.
type Matrix = [[f64; 3]; 3];

/// What stretches out of the plane of a mesh of triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutOfPlane {
    /// Nothing: plane strain; solids have no plane.
    Nothing,
    /// The circle about the axis x = 0.
    Hoop,
    /// The thickness of a sheet whose volume does not change.
    Thickness,
}

/// Von Mises stress from rows of xx yy zz xy yz zx.
pub fn von_mises(stress: &[f64]) -> Vec<f64> {
    let (rows, _) = stress.as_chunks::<6>();
    let one = |&[xx, yy, zz, xy, yz, zx]: &[f64; 6]| {
        let normal = (xx - yy).powi(2) + (yy - zz).powi(2) + (zz - xx).powi(2);
        let shear = xy * xy + yz * yz + zx * zx;
        (0.5 * normal + 3.0 * shear).sqrt()
    };
    rows.iter().map(one).collect()
}

/// Principal stresses [rows, 3] from rows of xx yy zz xy yz zx.
pub fn principal_stresses(stress: &[f64]) -> Vec<f64> {
    let (rows, _) = stress.as_chunks::<6>();
    rows.iter().flat_map(|row| eigenvalues(*row)).collect()
}

/// Principal stretches [cells, 3] from the displacement of the nodes [nodes, 3].
pub fn principal_stretches(grid: &Grid, displacement: &[f64], out: OutOfPlane) -> Vec<f64> {
    let cells = grid.connectivity().chunks_exact(grid.nodes_per_cell());
    let one = |cell: &[i64]| {
        let nodes = Nodes {
            places: rows(grid.points(), cell),
            motions: rows(displacement, cell),
        };
        let gradient = nodes.deformation_gradient(out);
        eigenvalues(transposed_product(&gradient)).map(|square| square.max(0.0).sqrt())
    };
    cells.flat_map(one).collect()
}

/// Rows of a table of three columns.
fn rows(table: &[f64], indices: &[i64]) -> Vec<[f64; 3]> {
    let (table, _) = table.as_chunks::<3>();
    let row = |index: &i64| {
        let index = usize::try_from(*index).ok()?;
        table.get(index).copied()
    };
    indices
        .iter()
        .map(|index| row(index).unwrap_or_default())
        .collect()
}

/// Places and displacements of the nodes of a cell, in the order of VTK.
struct Nodes {
    places: Vec<[f64; 3]>,
    motions: Vec<[f64; 3]>,
}

impl Nodes {
    /// I + grad u at the centroid, where all barycentric coordinates are 1/n:
    /// vertex functions have gradients (4/n - 1) grad L_a there, those of edges
    /// 4/n (grad L_a + grad L_b).
    fn deformation_gradient(&self, out: OutOfPlane) -> Matrix {
        let vertices = if self.places.len() == 6 { 3 } else { 4 };
        let share = 4.0 / vertices as f64;
        let slopes = self.slopes(vertices);
        let mut gradient = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let of_vertices = slopes.iter().map(|slope| slope.map(|x| (share - 1.0) * x));
        let of_edges = edges(vertices).iter().map(|&(a, b)| {
            let slope = |at: usize| slopes.get(at).copied().unwrap_or_default();
            combined(slope(a), slope(b), |a, b| share * (a + b))
        });
        for (motion, slope) in self.motions.iter().zip(of_vertices.chain(of_edges)) {
            for (row, u) in gradient.iter_mut().zip(motion) {
                row.iter_mut()
                    .zip(slope)
                    .for_each(|(entry, slope)| *entry += u * slope);
            }
        }
        let [[xx, xy, _], [yx, yy, _], _] = gradient;
        gradient[2][2] = match out {
            OutOfPlane::Nothing => gradient[2][2],
            OutOfPlane::Hoop => self.hoop(),
            OutOfPlane::Thickness => 1.0 / (xx * yy - xy * yx),
        };
        gradient
    }

    /// 1 + u_r / r at the centroid of a triangle: vertex functions are -1/9 there, those of
    /// edges 4/9.
    fn hoop(&self) -> f64 {
        let radius: f64 = self.places.iter().take(3).map(|[x, _, _]| x / 3.0).sum();
        let weights = [-1.0 / 9.0; 3].into_iter().chain([4.0 / 9.0; 3]);
        let motion: f64 = self
            .motions
            .iter()
            .zip(weights)
            .map(|([x, _, _], w)| w * x)
            .sum();
        1.0 + motion / radius
    }

    /// Gradients of the barycentric coordinates; a triangle has a third side along z.
    fn slopes(&self, vertices: usize) -> Vec<[f64; 3]> {
        let place = |at: usize| self.places.get(at).copied().unwrap_or_default();
        let side = |at: usize| combined(place(at), place(0), |a, b| a - b);
        let third = if vertices == 4 {
            side(3)
        } else {
            [0.0, 0.0, 1.0]
        };
        let (a, b, c) = (side(1), side(2), third);
        let volume = dot(a, cross(b, c));
        let scaled = |vector: [f64; 3]| vector.map(|x| x / volume);
        let mut slopes = vec![scaled(cross(b, c)), scaled(cross(c, a))];
        if vertices == 4 {
            slopes.push(scaled(cross(a, b)));
        }
        let sum = slopes
            .iter()
            .fold([0.0; 3], |sum, one| combined(sum, *one, |a, b| a - b));
        slopes.insert(0, sum);
        slopes
    }
}

/// Edges of a cell in the order of its further nodes.
fn edges(vertices: usize) -> &'static [(usize, usize)] {
    match vertices {
        3 => &[(0, 1), (1, 2), (0, 2)],
        _ => &[(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)],
    }
}

fn combined(a: [f64; 3], b: [f64; 3], combine: impl Fn(f64, f64) -> f64) -> [f64; 3] {
    let ([ax, ay, az], [bx, by, bz]) = (a, b);
    [combine(ax, bx), combine(ay, by), combine(az, bz)]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    combined(a, b, |a, b| a * b).iter().sum()
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    let ([ax, ay, az], [bx, by, bz]) = (a, b);
    [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx]
}

/// F^T F as xx yy zz xy yz zx.
fn transposed_product(&[first, second, third]: &Matrix) -> [f64; 6] {
    let ([a, b, c], [d, e, f], [g, h, i]) = (first, second, third);
    let (x, y, z) = ([a, d, g], [b, e, h], [c, f, i]);
    [
        dot(x, x),
        dot(y, y),
        dot(z, z),
        dot(x, y),
        dot(y, z),
        dot(z, x),
    ]
}

/// Descending eigenvalues of a symmetric matrix xx yy zz xy yz zx, by Jacobi's rotations:
/// to rounding, also where they lie close together.
fn eigenvalues([mut xx, mut yy, mut zz, mut xy, mut yz, mut zx]: [f64; 6]) -> [f64; 3] {
    for _ in 0..12 {
        [xx, yy, xy, zx, yz] = rotated([xx, yy, xy, zx, yz]);
        [xx, zz, zx, xy, yz] = rotated([xx, zz, zx, xy, yz]);
        [yy, zz, yz, xy, zx] = rotated([yy, zz, yz, xy, zx]);
    }
    let mut values = [xx, yy, zz];
    values.sort_by(|a, b| b.total_cmp(a));
    values
}

/// The entries pp, qq, pq, pr, qr after the rotation that makes pq zero.
fn rotated([pp, qq, pq, pr, qr]: [f64; 5]) -> [f64; 5] {
    if pq.abs() < f64::MIN_POSITIVE || !pq.is_finite() {
        return [pp, qq, pq, pr, qr];
    }
    let half = 0.5 * (qq - pp) / pq;
    let tangent = half.signum() / (half.abs() + half.hypot(1.0));
    let cosine = 1.0 / tangent.hypot(1.0);
    let sine = tangent * cosine;
    [
        pp - tangent * pq,
        qq + tangent * pq,
        0.0,
        cosine * pr - sine * qr,
        sine * pr + cosine * qr,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(found: &[f64], expected: &[f64]) {
        assert_eq!(found.len(), expected.len());
        for (a, b) in found.iter().zip(expected) {
            assert!((a - b).abs() < 1e-13, "{found:?} {expected:?}");
        }
    }

    #[test]
    fn uniaxial_stress_and_pure_shear_have_their_known_values() {
        let stress = [3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0];
        close(&von_mises(&stress), &[3.0, 12.0_f64.sqrt()]);
        close(
            &principal_stresses(&stress),
            &[3.0, 0.0, 0.0, 2.0, 0.0, -2.0],
        );
    }

    #[test]
    fn eigenvalues_of_a_full_matrix_keep_its_invariants() {
        let [a, b, c] = eigenvalues([4.0, 3.0, -1.0, 1.0, 0.5, -2.0]);
        close(&[a + b + c], &[6.0]);
        close(&[a * b + b * c + c * a], &[-0.25]);
        close(&[a * b * c], &[-26.0]);
    }

    /// Displacements (F - I) X of the nodes of a grid.
    fn moved(grid: &Grid, gradient: Matrix) -> Vec<f64> {
        let (points, _) = grid.points().as_chunks::<3>();
        let motion = |point: &[f64; 3]| {
            let image = gradient.map(|row| dot(row, *point));
            combined(image, *point, |a, b| a - b)
        };
        points.iter().flat_map(motion).collect()
    }

    #[test]
    fn a_stretched_and_turned_tetrahedron_has_the_stretches() {
        let corners = [
            [0.1, 0.0, 0.0],
            [1.0, 0.2, 0.0],
            [0.0, 1.0, 0.3],
            [0.0, 0.1, 1.0],
        ];
        let grid = Grid::new(4, &corners, &[0, 1, 2, 3]).unwrap();
        let (s, c) = 0.7_f64.sin_cos();
        let gradient = [
            [2.0 * c, -0.5 * s, 0.0],
            [2.0 * s, 0.5 * c, 0.0],
            [0.0, 0.0, 1.25],
        ];
        let found = principal_stretches(&grid, &moved(&grid, gradient), OutOfPlane::Nothing);
        close(&found, &[2.0, 1.25, 0.5]);
    }

    #[test]
    fn a_widened_ring_stretches_along_its_hoop() {
        let corners = [[2.0, 0.0, 0.0], [3.0, 0.0, 0.0], [2.0, 1.0, 0.0]];
        let grid = Grid::new(3, &corners, &[0, 1, 2]).unwrap();
        let gradient = [[1.5, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 1.0]];
        let motion = moved(&grid, gradient);
        close(
            &principal_stretches(&grid, &motion, OutOfPlane::Hoop),
            &[1.5, 1.5, 0.5],
        );
        close(
            &principal_stretches(&grid, &motion, OutOfPlane::Nothing),
            &[1.5, 1.0, 0.5],
        );
        close(
            &principal_stretches(&grid, &motion, OutOfPlane::Thickness),
            &[1.5, 1.0 / 0.75, 0.5],
        );
        // A quadratic bulge of an edge has its slope at the centroid.
        let mut bulge = vec![0.0; 18];
        bulge[3 * 3 + 1] = 0.3;
        let bulged = principal_stretches(&grid, &bulge, OutOfPlane::Nothing);
        // grad L_0 + grad L_1 = (0, -1): F_yy = 1 - 4/3 0.3.
        close(&bulged, &[1.0, 1.0, 0.6]);
    }
}
