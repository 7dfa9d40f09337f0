//! Products of the errors of two displacements with their pressures by a form, cell by cell:
//!
//! ```text
//! int_K (X* - X_h) : S : (Y* - Y_h),   X = (grad u, p), Y = (grad z, q)
//! ```
//!
//! X* and Y* as the gradients are recovered ([`super`]), S constant in a cell. Cost: that of two
//! recoveries with half as many numbers again, and 5 kflop a cell.

use super::fit::Quadratic;
use super::sites::Sites;
use super::strain::{Cells, lagrange};
use super::{Recovery, polynomials};
use crate::element::quadrature::{Simplex, rule};
use crate::parallel;

/// Degree of products of quadratic functions.
const DEGREE: u32 = 4;

/// Numbers of a gradient and a pressure.
pub const NUMBERS: usize = 10;

/// A matrix on gradients with their pressures: row and column 3 i + j for entry (i, j), the last
/// one for the pressure.
pub type FormMatrix = [[f64; NUMBERS]; NUMBERS];

/// Products of both errors in a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CellProducts {
    /// By the whole form.
    pub whole: f64,
    /// By its part of the gradients alone.
    pub gradients: f64,
    /// Each error by itself, by the gradients alone.
    pub own: [f64; 2],
}

/// A displacement with its recovered gradients.
struct Recovered<'a, const D: usize, const V: usize, const E: usize, const M: usize, const S: usize>
{
    cells: Cells<'a, D, V, E, S>,
    polynomials: Vec<Quadratic<M, S>>,
}

/// Products of both errors by a symmetric form `[cells]`. Both displacements are of one body; moduli
/// are not read.
pub fn cell_products(
    fields: [&Recovery<'_>; 2],
    form: &(dyn Fn(usize) -> FormMatrix + Sync),
) -> Vec<CellProducts> {
    match fields[0].space.components {
        2 => products::<2, 3, 3, 6, 5>(fields, form),
        _ => products::<3, 4, 6, 10, 10>(fields, form),
    }
}

fn products<const D: usize, const V: usize, const E: usize, const M: usize, const S: usize>(
    fields: [&Recovery<'_>; 2],
    form: &(dyn Fn(usize) -> FormMatrix + Sync),
) -> Vec<CellProducts> {
    let [first, _] = fields;
    let sites = Sites::new(first.mesh, first.regions);
    let recovered = fields.map(|field| {
        let cells = Cells::<D, V, E, S>::new(*field);
        Recovered {
            polynomials: polynomials::<D, V, E, M, S>(&cells, &sites),
            cells,
        }
    });
    let means = means::<V>();
    parallel::map(first.geometry.cells(), 1, &|cell| {
        let at = sites.of_cell(first.mesh.cell(cell), first.regions[cell]);
        let errors = recovered.each_ref().map(|one| {
            let polynomial = |corner: usize| &one.polynomials[at[corner]];
            let error = one.cells.difference::<M>(cell, polynomial);
            error.nodes().copied().collect::<Vec<[f64; S]>>()
        });
        let [own, dual] = &errors;
        let whole = form(cell);
        let gradients = of_gradients(&whole);
        let measure = first.geometry.volumes[cell];
        let by = |fields: [&[[f64; S]]; 2], form| measure * product::<D, S>(&means, fields, form);
        CellProducts {
            whole: by([own, dual], &whole),
            gradients: by([own, dual], &gradients),
            own: [by([own, own], &gradients), by([dual, dual], &gradients)],
        }
    })
}

/// The form without row and column of the pressure.
fn of_gradients(form: &FormMatrix) -> FormMatrix {
    let mut part = *form;
    for place in 0..NUMBERS {
        part[place][NUMBERS - 1] = 0.0;
        part[NUMBERS - 1][place] = 0.0;
    }
    part
}

/// Mean products of the P2 Lagrange functions over a cell `[nodes][nodes]`.
fn means<const V: usize>() -> Vec<Vec<f64>> {
    let simplex = match V {
        3 => Simplex::Triangle,
        _ => Simplex::Tetrahedron,
    };
    let rule = rule(simplex, DEGREE);
    let nodes = V * (V + 1) / 2;
    let mut means = vec![vec![0.0; nodes]; nodes];
    for (point, weight) in rule.points.iter().zip(&rule.weights) {
        let values = lagrange::<V>(&point[..V]);
        for (row, a) in means.iter_mut().zip(&values) {
            for (mean, b) in row.iter_mut().zip(&values) {
                *mean += weight * a * b;
            }
        }
    }
    means
}

/// Mean of a : S : b over a cell, from values at its nodes.
fn product<const D: usize, const S: usize>(
    means: &[Vec<f64>],
    [a, b]: [&[[f64; S]]; 2],
    form: &FormMatrix,
) -> f64 {
    let place = |s: usize| {
        if s == D * D {
            NUMBERS - 1
        } else {
            3 * (s / D) + s % D
        }
    };
    let image = |value: &[f64; S]| -> [f64; S] {
        std::array::from_fn(|s| {
            let row = &form[place(s)];
            let terms = value.iter().enumerate();
            terms.map(|(t, value)| row[place(t)] * value).sum()
        })
    };
    let images: Vec<[f64; S]> = b.iter().map(image).collect();
    let mut sum = 0.0;
    for (own, row) in a.iter().zip(means) {
        for (image, mean) in images.iter().zip(row) {
            let terms = own.iter().zip(image);
            sum += mean * terms.map(|(x, y)| x * y).sum::<f64>();
        }
    }
    sum
}
