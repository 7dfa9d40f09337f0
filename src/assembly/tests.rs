//! The matrix-free operators against element integrals written plainly.

use super::grid::{Basis, GridSource, Rows, StiffnessForm, VolumeTerm};
use super::mass::weighted_mass;
use super::p1_stiffness::StiffCells;
use super::simd::InstructionSet;
use super::{CellGeometry, CellModuli, Grid};
use crate::element::quadrature::{Rule, Simplex, rule};
use crate::linalg::vector::{dot, largest, reproducible_noise};
use crate::linalg::{Held, LinearOperator, Workspace};
use crate::mesh::{Mesh, MeshParts, barycentric_gradients, samples};
use crate::space::TaylorHood;

mod curved;
mod loads;
mod single;
mod strain;
mod strain_reference;

const SCALE: f64 = 0.5;

/// A mesh with everything that the operators are made of.
struct Sample {
    mesh: Mesh,
    space: TaylorHood,
    geometry: CellGeometry,
    moduli: CellModuli,
    held: Vec<u32>,
    grid: Grid,
}

impl Sample {
    /// Moves inner vertices, varies the moduli from cell to cell, and holds
    /// some unknowns.
    fn new(mut parts: MeshParts) -> Self {
        let dimension = parts.cell_kind.dimension();
        let noise = reproducible_noise(3 * parts.coordinates.len());
        for (point, moves) in parts.coordinates.iter_mut().zip(noise.chunks_exact(3)) {
            for (x, by) in point[..dimension].iter_mut().zip(moves) {
                if *x > 1e-9 && *x < 1.0 - 1e-9 {
                    *x += 0.01 * by;
                }
            }
        }
        Self::of(Mesh::new(parts).expect("a valid sample"))
    }

    /// The same on a mesh as it is.
    fn of(mesh: Mesh) -> Self {
        let geometry = CellGeometry::new(&mesh, SCALE);
        Self::with(mesh, geometry)
    }

    /// The same as the section of a body of revolution.
    fn about_axis(self) -> Self {
        let geometry = CellGeometry::about_axis(&self.mesh, SCALE);
        Self::with(self.mesh, geometry)
    }

    fn with(mesh: Mesh, geometry: CellGeometry) -> Self {
        let space = TaylorHood::new(&mesh);
        let cells = 0..mesh.cell_count();
        let moduli = CellModuli {
            shear: cells.clone().map(|cell| 1.0 + (cell % 3) as f64).collect(),
            lame: cells.clone().map(|cell| 0.5 * (cell % 4) as f64).collect(),
            augmented: cells.map(|cell| 0.3 + 0.4 * (cell % 5) as f64).collect(),
            inverse_lame: Vec::new(),
        };
        let held: Vec<u32> = (0..space.displacement_unknowns() as u32)
            .step_by(7)
            .collect();
        let grid = Grid::new(GridSource {
            mesh: &mesh,
            space: &space,
            geometry: &geometry,
            moduli: &moduli,
            held: &Held::of_entries(space.components, held.clone()),
        });
        Self {
            mesh,
            space,
            geometry,
            moduli,
            held,
            grid,
        }
    }

    fn stiff_cells(&self) -> StiffCells<'_> {
        StiffCells {
            mesh: &self.mesh,
            space: &self.space,
            geometry: &self.geometry,
            stiffness: &self.moduli,
        }
    }

    fn held(&self) -> Held {
        Held::of_entries(self.space.components, self.held.clone())
    }

    fn unknowns(&self) -> usize {
        self.space.displacement_unknowns()
    }

    fn stiffness(&self, basis: Basis, rows: Rows, x: &[f64]) -> Vec<f64> {
        self.product((basis, rows, VolumeTerm::Own), x)
    }

    fn product(&self, (basis, rows, volume): (Basis, Rows, VolumeTerm), x: &[f64]) -> Vec<f64> {
        let form = StiffnessForm {
            basis,
            rows,
            volume,
        };
        let mut y = vec![f64::NAN; x.len()];
        self.grid.stiffness(form, x, &mut y, &mut Workspace::new());
        y
    }

    fn divergence(&self, rows: Rows, x: &[f64]) -> Vec<f64> {
        let mut r = vec![f64::NAN; self.space.vertices];
        self.grid.divergence(rows, x, &mut r, &mut Workspace::new());
        r
    }

    fn divergence_transposed(&self, rows: Rows, p: &[f64]) -> Vec<f64> {
        let mut y = vec![f64::NAN; self.unknowns()];
        self.grid
            .divergence_transposed(rows, p, &mut y, &mut Workspace::new());
        y
    }

    fn mask(&self, rows: Rows, mut x: Vec<f64>) -> Vec<f64> {
        if rows == Rows::Free {
            self.held.iter().for_each(|&index| x[index as usize] = 0.0);
        }
        x
    }

    fn nodes_of(&self, cell: usize) -> Vec<usize> {
        let pairs = self.mesh.cell_kind().edges().len();
        let edges = &self.mesh.cell_edges()[cell * pairs..(cell + 1) * pairs];
        let vertices = self.mesh.cell(cell).iter().map(|&v| v as usize);
        vertices
            .chain(edges.iter().map(|&e| self.space.vertices + e as usize))
            .collect()
    }

    fn volume_rule(&self) -> Rule {
        match self.mesh.cell_kind().dimension() {
            2 => rule(Simplex::Triangle, 4),
            _ => rule(Simplex::Tetrahedron, 4),
        }
    }

    /// Visits every point of a rule on every cell: cell, weight, barycentric
    /// coordinates, slopes of the shape functions.
    fn integrate(&self, basis: Basis, mut visit: impl FnMut(usize, f64, &[f64], &[[f64; 3]])) {
        let kind = self.mesh.cell_kind();
        let rule = self.volume_rule();
        for cell in 0..self.mesh.cell_count() {
            let corners = self.mesh.corners(cell).map(|x| x.map(|x| SCALE * x));
            let g = barycentric_gradients(kind, &corners);
            let measure = kind.signed_measure(&corners);
            for (point, weight) in rule.points.iter().zip(&rule.weights) {
                let l = &point[..kind.vertices()];
                visit(
                    cell,
                    weight * measure,
                    l,
                    &slopes(basis, l, &g, kind.edges()),
                );
            }
        }
    }

    fn gradient(&self, cell: usize, slopes: &[[f64; 3]], x: &[f64]) -> [[f64; 3]; 3] {
        let c = self.space.components;
        let mut gradient = [[0.0; 3]; 3];
        for (&node, slope) in self.nodes_of(cell).iter().zip(slopes) {
            for i in 0..c {
                for j in 0..c {
                    gradient[i][j] += x[node * c + i] * slope[j];
                }
            }
        }
        gradient
    }

    fn plain_stiffness(
        &self,
        (basis, rows, volume): (Basis, Rows, VolumeTerm),
        x: &[f64],
    ) -> Vec<f64> {
        let lame = match volume {
            VolumeTerm::Own => &self.moduli.lame,
            VolumeTerm::Augmented => &self.moduli.augmented,
        };
        let c = self.space.components;
        let x = self.mask(rows, x.to_vec());
        let mut y = vec![0.0; x.len()];
        self.integrate(basis, |cell, weight, _, slopes| {
            let g = self.gradient(cell, slopes, &x);
            let trace: f64 = (0..c).map(|i| g[i][i]).sum();
            for (&node, slope) in self.nodes_of(cell).iter().zip(slopes) {
                for i in 0..c {
                    for j in 0..c {
                        let volume = if i == j { lame[cell] * trace } else { 0.0 };
                        let stress = self.moduli.shear[cell] * (g[i][j] + g[j][i]) + volume;
                        y[node * c + i] += weight * stress * slope[j];
                    }
                }
            }
        });
        self.mask(rows, y)
    }

    fn plain_divergence(&self, rows: Rows, x: &[f64]) -> Vec<f64> {
        let x = self.mask(rows, x.to_vec());
        let mut r = vec![0.0; self.space.vertices];
        self.integrate(Basis::Hierarchical, |cell, weight, l, slopes| {
            let g = self.gradient(cell, slopes, &x);
            let trace = g[0][0] + g[1][1] + g[2][2];
            for (&vertex, hat) in self.mesh.cell(cell).iter().zip(l) {
                r[vertex as usize] -= weight * hat * trace;
            }
        });
        r
    }
}

fn slopes(basis: Basis, l: &[f64], g: &[[f64; 3]; 4], pairs: &[(usize, usize)]) -> Vec<[f64; 3]> {
    let vertex = |a: usize| match basis {
        Basis::Hierarchical => g[a],
        Basis::Lagrange => g[a].map(|x| (4.0 * l[a] - 1.0) * x),
    };
    let edge =
        |&(a, b): &(usize, usize)| std::array::from_fn(|j| 4.0 * (l[a] * g[b][j] + l[b] * g[a][j]));
    (0..l.len())
        .map(vertex)
        .chain(pairs.iter().map(edge))
        .collect()
}

fn samples() -> Vec<Sample> {
    // The first is larger than one block.
    vec![
        Sample::new(samples::cube_parts(7)),
        Sample::new(samples::rectangle_parts(5, 4)),
    ]
}

fn assert_close(found: &[f64], expected: &[f64], tolerance: f64) {
    let size = largest(expected);
    for (index, (a, b)) in found.iter().zip(expected).enumerate() {
        assert!((a - b).abs() <= tolerance * size, "{index}: {a} {b}");
    }
    assert_eq!(found.len(), expected.len());
}

#[test]
fn the_stiffness_matches_plain_integration_in_both_bases() {
    for sample in samples() {
        let x = reproducible_noise(sample.unknowns());
        for basis in [Basis::Hierarchical, Basis::Lagrange] {
            for rows in [Rows::All, Rows::Free] {
                for volume in [VolumeTerm::Own, VolumeTerm::Augmented] {
                    let on = (basis, rows, volume);
                    let expected = sample.plain_stiffness(on, &x);
                    assert_close(&sample.product(on, &x), &expected, 1e-13);
                }
            }
        }
    }
}

#[test]
fn the_divergence_matches_plain_integration() {
    for sample in samples() {
        let x = reproducible_noise(sample.unknowns());
        for rows in [Rows::All, Rows::Free] {
            let expected = sample.plain_divergence(rows, &x);
            assert_close(&sample.divergence(rows, &x), &expected, 1e-13);
        }
    }
}

#[test]
fn the_transposed_divergence_is_the_adjoint() {
    for sample in samples() {
        let x = reproducible_noise(sample.unknowns());
        let p = reproducible_noise(sample.space.vertices);
        for rows in [Rows::All, Rows::Free] {
            let left = dot(&sample.divergence(rows, &x), &p);
            let right = dot(&sample.divergence_transposed(rows, &p), &x);
            assert!(
                (left - right).abs() <= 1e-13 * x.len() as f64 * largest(&p),
                "{left} {right}"
            );
        }
    }
}

#[test]
fn the_joint_product_is_the_sum_of_its_parts() {
    for sample in samples() {
        let (u, p) = (
            reproducible_noise(sample.unknowns()),
            reproducible_noise(sample.space.vertices),
        );
        let mut work = Workspace::new();
        let (mut force, mut volume) = (vec![f64::NAN; u.len()], vec![f64::NAN; p.len()]);
        sample
            .grid
            .saddle((&u, &p), (&mut force, &mut volume), &mut work);
        let mut expected = sample.stiffness(Basis::Hierarchical, Rows::Free, &u);
        let pressed = sample.divergence_transposed(Rows::Free, &p);
        expected
            .iter_mut()
            .zip(&pressed)
            .for_each(|(sum, f)| *sum += f);
        assert_close(&force, &expected, 1e-13);
        assert_close(&volume, &sample.divergence(Rows::Free, &u), 1e-13);
    }
}

#[test]
fn sweeps_that_add_match_product_and_sum() {
    for sample in samples() {
        let (x, p) = (
            reproducible_noise(sample.unknowns()),
            reproducible_noise(sample.space.vertices),
        );
        let mut work = Workspace::new();
        for basis in [Basis::Hierarchical, Basis::Lagrange] {
            let mut r = vec![1.0; x.len()];
            let on = (basis, VolumeTerm::Augmented);
            sample.grid.subtract_stiffness(on, &x, &mut r, &mut work);
            let product = sample.product((basis, Rows::Free, VolumeTerm::Augmented), &x);
            let expected: Vec<f64> = product.iter().map(|y| 1.0 - y).collect();
            assert_close(&r, &expected, 1e-13);
        }
        let mut y = vec![1.0; x.len()];
        sample
            .grid
            .add_divergence_transposed(-0.5, &p, &mut y, &mut work);
        let product = sample.divergence_transposed(Rows::Free, &p);
        let expected: Vec<f64> = product.iter().map(|f| 1.0 - 0.5 * f).collect();
        assert_close(&y, &expected, 1e-13);
    }
}

#[test]
fn the_stiffness_is_symmetric() {
    for sample in samples() {
        let x = reproducible_noise(sample.unknowns());
        let y: Vec<f64> = x.iter().rev().copied().collect();
        for basis in [Basis::Hierarchical, Basis::Lagrange] {
            let left = dot(&sample.stiffness(basis, Rows::Free, &x), &y);
            let right = dot(&sample.stiffness(basis, Rows::Free, &y), &x);
            assert!(
                (left - right).abs() <= 1e-12 * left.abs().max(1.0),
                "{left} {right}"
            );
        }
    }
}

#[test]
fn rigid_motions_cost_no_energy() {
    for sample in samples() {
        let c = sample.space.components;
        let mut x = vec![0.0; sample.unknowns()];
        for (vertex, point) in sample.mesh.coordinates().iter().enumerate() {
            // A translation and a rotation about z; linear, so edges stay zero.
            x[vertex * c] = 0.3 - point[1];
            x[vertex * c + 1] = -0.2 + point[0];
        }
        let force = sample.stiffness(Basis::Hierarchical, Rows::All, &x);
        assert!(largest(&force) < 1e-13, "{}", largest(&force));
    }
}

#[test]
fn passes_have_the_same_bits_for_every_number_of_threads() {
    let sample = Sample::new(samples::cube_parts(7));
    let x = reproducible_noise(sample.unknowns());
    let p = reproducible_noise(sample.space.vertices);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("a pool of a few threads").install(|| {
            let y = sample.stiffness(Basis::Lagrange, Rows::Free, &x);
            let r = sample.divergence(Rows::Free, &x);
            let z = sample.divergence_transposed(Rows::Free, &p);
            [y, r, z]
                .concat()
                .into_iter()
                .map(f64::to_bits)
                .collect::<Vec<_>>()
        })
    };
    let one = with(1);
    assert!(with(2) == one && with(3) == one);
}

#[test]
fn the_p1_block_is_the_hierarchical_prefix() {
    for sample in samples() {
        let size = sample.space.vertices * sample.space.components;
        let lower = sample
            .stiff_cells()
            .p1_blocks(0.0)
            .lower_columns(&sample.space, &sample.held);
        let mut x = reproducible_noise(sample.unknowns());
        x[size..].fill(0.0);
        let mut product = vec![0.0; size];
        for column in 0..lower.size() {
            for entry in lower.offsets[column] as usize..lower.offsets[column + 1] as usize {
                let (row, value) = (lower.rows[entry] as usize, lower.values[entry]);
                product[row] += value * x[column];
                if row != column {
                    product[column] += value * x[row];
                }
            }
        }
        let on = (Basis::Hierarchical, Rows::Free, VolumeTerm::Augmented);
        let mut expected = sample.product(on, &x);
        for &index in &sample.held {
            expected[index as usize] = x[index as usize];
        }
        assert_close(&product, &expected[..size], 1e-13);
    }
}

#[test]
fn node_blocks_are_the_diagonal_blocks_of_the_lagrange_stiffness() {
    for parts in [samples::cube_parts(2), samples::rectangle_parts(3, 2)] {
        let sample = Sample::new(parts);
        let c = sample.space.components;
        let blocks = sample.stiff_cells().node_blocks(&sample.held());
        for column in 0..sample.unknowns() {
            let mut unit = vec![0.0; sample.unknowns()];
            unit[column] = 1.0;
            let on = (Basis::Lagrange, Rows::Free, VolumeTerm::Augmented);
            let mut expected = sample.plain_stiffness(on, &unit);
            if sample.held.contains(&(column as u32)) {
                expected[column] = 1.0;
            }
            let node = column / c;
            for i in 0..c {
                let found = blocks[(node * c + i) * c + column % c];
                assert!((found - expected[node * c + i]).abs() < 1e-12, "{node} {i}");
            }
        }
    }
}

#[test]
fn mass_rows_sum_to_the_hats_integrals() {
    for sample in samples() {
        let mass = weighted_mass(
            (&sample.mesh, &sample.geometry),
            &sample.volume_rule(),
            |cell| sample.moduli.shear[cell],
        );
        let mut sums = vec![0.0; sample.space.vertices];
        mass.apply(&vec![1.0; sums.len()], &mut sums, &mut Workspace::new());
        let mut expected = vec![0.0; sums.len()];
        for (cell, volume) in sample.geometry.volumes.iter().enumerate() {
            let vertices = sample.mesh.cell(cell);
            for &vertex in vertices {
                expected[vertex as usize] +=
                    sample.moduli.shear[cell] * volume / vertices.len() as f64;
            }
        }
        assert_close(&sums, &expected, 1e-13);
    }
}

#[test]
fn every_instruction_set_gives_the_portable_result() {
    for sample in samples() {
        let size = sample.space.displacement_unknowns();
        let (x, p) = (
            reproducible_noise(size),
            reproducible_noise(sample.space.vertices),
        );
        let passes = |set| {
            let grid = sample.grid.clone().with_instruction_set(set);
            let mut work = Workspace::new();
            let (mut force, mut gradient) = (vec![0.0; size], vec![0.0; size]);
            let mut volume = vec![0.0; sample.space.vertices];
            let form = StiffnessForm {
                basis: Basis::Lagrange,
                rows: Rows::Free,
                volume: VolumeTerm::Own,
            };
            grid.stiffness(form, &x, &mut force, &mut work);
            grid.divergence(Rows::All, &x, &mut volume, &mut work);
            grid.divergence_transposed(Rows::All, &p, &mut gradient, &mut work);
            let (mut joint, mut rate) = (vec![0.0; size], vec![0.0; p.len()]);
            grid.saddle((&x, &p), (&mut joint, &mut rate), &mut work);
            [force, volume, gradient, joint, rate]
        };
        let expected = passes(InstructionSet::Portable);
        for set in InstructionSet::ALL.into_iter().filter(|set| set.is_here()) {
            for (found, expected) in passes(set).iter().zip(&expected) {
                assert_close(found, expected, 1e-13);
            }
        }
    }
}
