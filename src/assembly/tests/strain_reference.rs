//! The vector passes of finite strain against plain sums over cells and points of
//! stress and tangent matrix as the materials give them, one point at a time.

use std::sync::Arc;

use super::*;
use crate::assembly::strain::{CellLaws, Linearised, Mixed, Response, StrainGrid};
use crate::geometry::tensor::{Tensor, cofactor, contract, plus_unit, volume_change};
use crate::linalg::vector::{add_scaled, scale};
use crate::material::{InvariantLaw, Isochoric, Ogden, OgdenTerm, Rubber};

fn invariants([c10, c01, c20, c30]: [f64; 4]) -> Isochoric {
    Isochoric::Invariants(InvariantLaw { c10, c01, c20, c30 })
}

/// Neo-Hookean, Mooney-Rivlin, Yeoh, Ogden.
fn laws() -> [Isochoric; 4] {
    let terms = [(0.7, 2.6), (-0.2, -1.3)];
    let terms = terms.map(|(modulus, exponent)| OgdenTerm { modulus, exponent });
    [
        invariants([0.5, 0.0, 0.0, 0.0]),
        invariants([0.3, 0.4, 0.0, 0.0]),
        invariants([1.0, 0.0, 0.2, 0.1]),
        Isochoric::Ogden(Ogden {
            terms: terms.to_vec(),
        }),
    ]
}

/// The law of a cell.
fn rubber(cell: usize) -> Rubber {
    Rubber {
        isochoric: laws()[cell % 4].clone(),
        inverse_bulk: 0.0,
    }
}

/// What a pass gives: forces and volume integrals.
type Sums = (Vec<f64>, Vec<f64>);

/// A state (u, p) and a change of it.
struct State {
    u: Vec<f64>,
    p: Vec<f64>,
    du: Vec<f64>,
    dp: Vec<f64>,
}

impl State {
    /// Gradients of some tenths.
    fn new(sample: &Sample) -> Self {
        let mut u = reproducible_noise(sample.unknowns());
        let du = u.iter().rev().copied().collect();
        scale(&mut u, 0.002);
        let p = reproducible_noise(sample.space.vertices);
        let dp = p.iter().rev().copied().collect();
        Self { u, p, du, dp }
    }
}

impl Sample {
    fn strain(&self, set: InstructionSet) -> StrainGrid {
        let of_cell: Vec<u16> = (0..self.mesh.cell_count() as u16).map(|c| c % 4).collect();
        let laws: Vec<Rubber> = (0..4).map(rubber).collect();
        let laws = CellLaws {
            laws: &laws,
            of_cell: &of_cell,
        };
        let grid = Arc::new(self.grid.clone().with_instruction_set(set));
        StrainGrid::new(&self.mesh, grid, laws, self.volume_rule())
    }

    fn at_vertices(&self, cell: usize, l: &[f64], values: &[f64]) -> f64 {
        let pairs = self.mesh.cell(cell).iter().zip(l);
        pairs.map(|(&v, l)| l * values[v as usize]).sum()
    }

    /// Adds `weight` P : grad v to `force`.
    fn add_force(
        &self,
        cell: usize,
        weight: f64,
        stress: &Tensor<f64>,
        slopes: &[[f64; 3]],
        force: &mut [f64],
    ) {
        let c = self.space.components;
        for (&node, slope) in self.nodes_of(cell).iter().zip(slopes) {
            for i in 0..c {
                for j in 0..c {
                    force[node * c + i] += weight * stress[i][j] * slope[j];
                }
            }
        }
    }

    fn add_volume(&self, cell: usize, weight: f64, l: &[f64], value: f64, volumes: &mut [f64]) {
        for (&vertex, l) in self.mesh.cell(cell).iter().zip(l) {
            volumes[vertex as usize] -= weight * l * value;
        }
    }

    fn zeros(&self) -> Sums {
        (vec![0.0; self.unknowns()], vec![0.0; self.space.vertices])
    }

    /// (f, c) and int W, int J - 1, least J.
    fn plain_response(&self, state: &State) -> (Sums, Response) {
        let (mut force, mut volumes) = self.zeros();
        let mut response = Response {
            energy: 0.0,
            volume_change: 0.0,
            least_jacobian: f64::INFINITY,
        };
        self.integrate(Basis::Hierarchical, |cell, weight, l, slopes| {
            let rubber = rubber(cell);
            let h = self.gradient(cell, slopes, &state.u);
            let stress = rubber.stress(&h, self.at_vertices(cell, l, &state.p));
            self.add_force(cell, weight, &stress, slopes, &mut force);
            let change = volume_change(&h);
            self.add_volume(cell, weight, l, change, &mut volumes);
            response.energy += weight * rubber.isochoric.energy(&h);
            response.volume_change += weight * change;
            response.least_jacobian = response.least_jacobian.min(1.0 + change);
        });
        ((force, volumes), response)
    }

    /// (A du + B^T dp, B du).
    fn plain_tangent(&self, state: &State) -> Sums {
        let (mut force, mut volumes) = self.zeros();
        self.integrate(Basis::Hierarchical, |cell, weight, l, slopes| {
            let h = self.gradient(cell, slopes, &state.u);
            let change = self.gradient(cell, slopes, &state.du);
            let pressure = self.at_vertices(cell, l, &state.p);
            let more = self.at_vertices(cell, l, &state.dp);
            let tangent = rubber(cell).tangent(&h, pressure);
            let cofactor = cofactor(&plus_unit(&h));
            let stress = std::array::from_fn(|i| {
                std::array::from_fn(|j| {
                    let row = tangent[3 * i + j].iter();
                    let product = row.zip(change.as_flattened()).map(|(a, b)| a * b);
                    product.sum::<f64>() - more * cofactor[i][j]
                })
            });
            self.add_force(cell, weight, &stress, slopes, &mut force);
            let volume = contract(&cofactor, &change);
            self.add_volume(cell, weight, l, volume, &mut volumes);
        });
        (force, volumes)
    }
}

fn distance(found: &Sums, expected: &Sums) -> f64 {
    let of = |a: &[f64], b: &[f64]| {
        let mut difference = a.to_vec();
        add_scaled(&mut difference, -1.0, b);
        largest(&difference) / largest(b)
    };
    of(&found.0, &expected.0).max(of(&found.1, &expected.1))
}

#[test]
fn forces_volumes_and_energy_are_the_sums_over_cells_and_points() {
    for sample in samples() {
        let state = State::new(&sample);
        let (expected, plain) = sample.plain_response(&state);
        for set in InstructionSet::ALL.into_iter().filter(|set| set.is_here()) {
            let mut found = sample.zeros();
            let response = sample.strain(set).respond(
                (&state.u, &state.p),
                (&mut found.0, &mut found.1),
                &mut Workspace::new(),
            );
            assert!(distance(&found, &expected) < 1e-12);
            assert!((response.energy - plain.energy).abs() < 1e-12 * plain.energy);
            assert!((response.volume_change - plain.volume_change).abs() < 1e-12);
            assert!((response.least_jacobian - plain.least_jacobian).abs() < 1e-12);
        }
    }
}

#[test]
fn products_with_the_tangent_are_the_sums_over_cells_and_points() {
    for sample in samples() {
        let state = State::new(&sample);
        let expected = sample.plain_tangent(&state);
        for set in InstructionSet::ALL.into_iter().filter(|set| set.is_here()) {
            let (cells, work) = (sample.strain(set), &mut Workspace::new());
            let mut at = Linearised::default();
            cells.linearise((&state.u, &state.p), &mut at, work);
            let mut found = sample.zeros();
            cells.about(&at).apply(
                Rows::All,
                (&state.du, &state.dp),
                Mixed {
                    displacement: &mut found.0,
                    pressure: &mut found.1,
                },
                work,
            );
            assert!(distance(&found, &expected) < 1e-12);
        }
    }
}
