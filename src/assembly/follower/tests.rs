use super::*;
use crate::geometry::rotation_matrix;
use crate::geometry::tensor::{cofactor, contract, plus_unit};
use crate::linalg::vector::{dot, reproducible_noise};
use crate::linalg::{LinearOperator, Workspace};
use crate::mesh::{GroupKind, barycentric_gradients, samples};

const PRESSURE: f64 = 0.7;

/// Meshes with their measures and scales.
fn samples() -> [(Mesh, SurfaceMeasure, f64); 3] {
    [
        (samples::cube(2), SurfaceMeasure::Solid, 1.0),
        (samples::rectangle(2, 3), SurfaceMeasure::Plane, 1.0),
        // About its left side, at half its size.
        (samples::rectangle(3, 2), SurfaceMeasure::Axisymmetric, 0.5),
    ]
}

fn sides(mesh: &Mesh, names: &[&str]) -> Vec<u32> {
    let groups = names.iter().map(|name| {
        let group = mesh.group(name, GroupKind::Facets).expect("a side");
        group.members.clone()
    });
    groups.flatten().collect()
}

fn all_sides(mesh: &Mesh) -> Vec<u32> {
    match mesh.cell_kind().dimension() {
        2 => sides(mesh, &["x0", "x1", "y0", "y1"]),
        _ => sides(mesh, &["x0", "x1", "y0", "y1", "z0", "z1"]),
    }
}

/// A sample with pressure on some of its facets.
struct Pressed<'a> {
    mesh: &'a Mesh,
    space: TaylorHood,
    measure: SurfaceMeasure,
    scale: f64,
    facets: Vec<u32>,
}

impl<'a> Pressed<'a> {
    fn new(sample: &'a (Mesh, SurfaceMeasure, f64), facets: Vec<u32>) -> Self {
        Self {
            mesh: &sample.0,
            space: TaylorHood::new(&sample.0),
            measure: sample.1,
            scale: sample.2,
            facets,
        }
    }

    fn noise(&self) -> Vec<f64> {
        let noise = reproducible_noise(self.space.displacement_unknowns());
        noise.iter().map(|x| 0.05 * x).collect()
    }

    fn body<'b>(&'b self, displacement: &'b [f64]) -> PressedBody<'b> {
        PressedBody {
            mesh: self.mesh,
            scale: self.scale,
            space: &self.space,
            measure: self.measure,
            displacement,
        }
    }

    fn pressures(&self) -> [FollowerPressure<'_>; 1] {
        [FollowerPressure {
            facets: &self.facets,
            pressure: PressureValues::Uniform(PRESSURE),
        }]
    }

    fn load(&self, displacement: &[f64]) -> Vec<f64> {
        let mut force = vec![0.0; displacement.len()];
        add_follower_load(&self.body(displacement), &self.pressures(), &mut force);
        force
    }

    fn tangent(&self, displacement: &[f64], held: &[bool]) -> SparseRows {
        follower_tangent(&self.body(displacement), &self.pressures(), held)
    }

    /// The deformed volume by integrals over the cells: int J dX, times 2 pi x.
    fn volume(&self, displacement: &[f64]) -> f64 {
        let kind = self.mesh.cell_kind();
        let simplex = match kind.dimension() {
            2 => Simplex::Triangle,
            _ => Simplex::Tetrahedron,
        };
        let rule = rule(simplex, 4);
        let edges = kind.edges().len();
        let cells = (0..self.mesh.cell_count()).map(|cell| {
            let corners = self.mesh.corners(cell).map(|x| scale(self.scale, x));
            let own = self.mesh.cell_edges()[cell * edges..(cell + 1) * edges].iter();
            let own = own.map(|&edge| edge + self.space.vertices as u32);
            let nodes: Vec<u32> = self.mesh.cell(cell).iter().copied().chain(own).collect();
            let points = rule.points.iter().zip(&rule.weights);
            let sum: f64 = points
                .map(|(point, weight)| {
                    let hats = &point[..kind.vertices()];
                    weight * self.density(&corners, &nodes, hats, displacement)
                })
                .sum();
            kind.signed_measure(&corners) * sum
        });
        cells.sum()
    }

    /// J, or 2 pi x J in the plane.
    fn density(&self, corners: &[[f64; 3]; 4], nodes: &[u32], l: &[f64], u: &[f64]) -> f64 {
        let kind = self.mesh.cell_kind();
        let gradients = barycentric_gradients(kind, corners);
        let mut slopes: Vec<[f64; 3]> = gradients[..l.len()].to_vec();
        for &(a, b) in kind.edges() {
            let slope = |i: usize| 4.0 * (l[a] * gradients[b][i] + l[b] * gradients[a][i]);
            slopes.push([0, 1, 2].map(slope));
        }
        let mut h = [[0.0; 3]; 3];
        let mut x: f64 = l.iter().zip(corners).map(|(l, corner)| l * corner[0]).sum();
        let c = self.space.components;
        for ((&node, slope), value) in nodes.iter().zip(&slopes).zip(shape_values(l)) {
            let moved = &u[node as usize * c..][..c];
            x += value * moved[0];
            for (row, u) in h.iter_mut().zip(moved) {
                (0..3).for_each(|j| row[j] += u * slope[j]);
            }
        }
        let f = plus_unit(&h);
        let jacobian = contract(&f, &cofactor(&f)) / 3.0;
        match self.measure {
            SurfaceMeasure::Solid | SurfaceMeasure::Plane => jacobian,
            SurfaceMeasure::Axisymmetric => TAU * x * jacobian,
        }
    }
}

fn moved(u: &[f64], factor: f64, direction: &[f64]) -> Vec<f64> {
    let pairs = u.iter().zip(direction);
    pairs.map(|(u, d)| u + factor * d).collect()
}

#[test]
fn pressure_all_around_does_the_work_of_the_volume() {
    for sample in &samples() {
        let body = Pressed::new(sample, all_sides(&sample.0));
        let u = body.noise();
        let load = body.load(&u);
        let mut direction = u.clone();
        direction.reverse();
        // Fourth order: exact for volumes, which are of degree four at most.
        let volume = |factor: f64| body.volume(&moved(&u, factor, &direction));
        let slope = (8.0 * (volume(0.5) - volume(-0.5)) - (volume(1.0) - volume(-1.0))) / 6.0;
        let work = dot(&load, &direction);
        assert!((work + PRESSURE * slope).abs() < 1e-14, "{work} {slope}");
        assert!(work.abs() > 1e-3);
    }
}

#[test]
fn pressure_all_around_has_no_resultant() {
    for sample in &samples() {
        let body = Pressed::new(sample, all_sides(&sample.0));
        let load = body.load(&body.noise());
        let c = body.space.components;
        // About an axis only the force along it is a resultant.
        let first = usize::from(body.measure == SurfaceMeasure::Axisymmetric);
        for i in first..c {
            // Vertex functions sum up to one.
            let vertices = load[..body.space.vertices * c].iter();
            let sum: f64 = vertices.skip(i).step_by(c).sum();
            assert!(sum.abs() < 1e-14, "{sum}");
        }
    }
}

#[test]
fn the_tangent_is_the_slope_of_the_load() {
    for sample in &samples() {
        for facets in [sides(&sample.0, &["x1"]), all_sides(&sample.0)] {
            let body = Pressed::new(sample, facets);
            let u = body.noise();
            let direction = reproducible_noise(u.len());
            let tangent = body.tangent(&u, &vec![false; u.len()]);
            let mut found = vec![0.0; u.len()];
            tangent.apply(&direction, &mut found, &mut Workspace::default());
            // Loads are quadratic: a central difference is exact.
            let (up, down) = (
                body.load(&moved(&u, 0.1, &direction)),
                body.load(&moved(&u, -0.1, &direction)),
            );
            for ((found, up), down) in found.iter().zip(&up).zip(&down) {
                assert!((found - (up - down) / 0.2).abs() < 1e-13);
            }
            assert!(found.iter().any(|x| x.abs() > 1e-2));
        }
    }
}

/// Largest difference between an entry and its mirror image.
fn asymmetry(matrix: &SparseRows, unknowns: usize) -> f64 {
    let entry = |row: usize, column: usize| {
        let (columns, values) = matrix.row(row);
        let place = columns.binary_search(&(column as u32));
        place.map_or(0.0, |place| values[place])
    };
    let pairs = (0..unknowns).flat_map(|row| (0..row).map(move |column| (row, column)));
    pairs.fold(0.0, |most: f64, (i, j)| {
        most.max((entry(i, j) - entry(j, i)).abs())
    })
}

#[test]
fn only_a_free_edge_makes_the_tangent_unsymmetric() {
    for sample in &samples() {
        let closed = Pressed::new(sample, all_sides(&sample.0));
        let u = closed.noise();
        let free = vec![false; u.len()];
        assert!(asymmetry(&closed.tangent(&u, &free), u.len()) < 1e-15);
        let open = Pressed::new(sample, sides(&sample.0, &["x1"]));
        assert!(asymmetry(&open.tangent(&u, &free), u.len()) > 1e-3);
    }
}

#[test]
fn held_rows_and_columns_are_left_out() {
    for sample in &samples() {
        let body = Pressed::new(sample, sides(&sample.0, &["x1", "y0"]));
        let u = body.noise();
        let held: Vec<bool> = (0..u.len()).map(|unknown| unknown % 3 == 1).collect();
        let whole = body.tangent(&u, &vec![false; u.len()]);
        let part = body.tangent(&u, &held);
        for row in 0..u.len() {
            let (columns, values) = whole.row(row);
            let kept = columns.iter().zip(values);
            let kept = kept.filter(|(column, _)| !held[row] && !held[**column as usize]);
            let (columns, values) = part.row(row);
            assert!(kept.eq(columns.iter().zip(values)));
        }
    }
}

#[test]
fn a_uniform_stretch_has_the_area_of_the_textbook() {
    // x = (1.2 X, 0.7 Y, 1.5 Z): the side x1 has a deformed area of 0.7 * 1.5.
    let stretch = [1.2, 0.7, 1.5];
    for (sample, area) in samples().iter().zip([1.05, 0.7, 0.35 * TAU * 0.6]) {
        let body = Pressed::new(sample, sides(&sample.0, &["x1"]));
        let c = body.space.components;
        let mut u = vec![0.0; body.space.displacement_unknowns()];
        for (vertex, place) in sample.0.coordinates().iter().enumerate() {
            for i in 0..c {
                u[vertex * c + i] = (stretch[i] - 1.0) * place[i] * sample.2;
            }
        }
        let load = body.load(&u);
        let along = |i: usize| -> f64 {
            let vertices = load[..body.space.vertices * c].iter();
            vertices.skip(i).step_by(c).sum()
        };
        assert!((along(0) + PRESSURE * area).abs() < 1e-14);
        (1..c).for_each(|i| assert!(along(i).abs() < 1e-14));
    }
}

#[test]
fn a_rotated_body_has_the_rotated_load() {
    let sample = (samples::cube(2), SurfaceMeasure::Solid, 1.0);
    let body = Pressed::new(&sample, sides(&sample.0, &["x1", "z0"]));
    let u = body.noise();
    let rotation = rotation_matrix([2.0, -1.5, 0.8]);
    let turned = |v: [f64; 3]| rotation.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2]);
    // x = R (X + u); edge nodes carry differences of positions.
    let mut rotated = Vec::new();
    for (node, &row) in u.as_chunks::<3>().0.iter().enumerate() {
        let place = sample
            .0
            .coordinates()
            .get(node)
            .copied()
            .unwrap_or([0.0; 3]);
        let x = turned([0, 1, 2].map(|i| row[i] + place[i]));
        rotated.extend([0, 1, 2].map(|i| x[i] - place[i]));
    }
    let (load, of_rotated) = (body.load(&u), body.load(&rotated));
    for (row, found) in load
        .as_chunks::<3>()
        .0
        .iter()
        .zip(of_rotated.as_chunks::<3>().0)
    {
        let expected = turned(*row);
        (0..3).for_each(|i| assert!((expected[i] - found[i]).abs() < 1e-15));
    }
}
