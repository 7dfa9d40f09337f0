//! Error of a displacement from a recovered strain (O. C. Zienkiewicz and
//! J. Z. Zhu, Int. J. Numer. Methods Eng. 33, 1992): per cell
//!
//! ```text
//! eta_K^2 = int_K 2 mu |e* - eps(u_h)|^2 + lambda (tr e* - div u_h)^2
//! ```
//!
//! e* is quadratic in each cell. Around a vertex inside a region, a quadratic
//! polynomial is fitted to eps(u_h) at the points of the cells' degree-2 rule;
//! a vertex on the rim of a region takes the mean of the polynomials of its
//! inner neighbours, a corner that of its neighbours on the rim; a region without
//! inner vertices fits to two rings of cells. At an
//! edge's midpoint the polynomials of its ends are averaged.
//!
//! Cells of different regions (materials) never share a fit: a strain that
//! jumps at an interface is no error. Where u is smooth, e* converges faster
//! than eps(u_h), so that eta tends to the error's norm; at singular points it
//! is of its size. lambda is zero in mixed forms, whose pressure carries the
//! volume response. Straight-sided cells; all quantities non-dimensional. About an axis e* has no
//! strain around it, whose error is left out.
//!
//! Cost: some 100 points a vertex, 20 kflop, and 3 kflop a cell; about 500 bytes
//! a vertex and 250 a cell while it runs. Parallel; every sum has a fixed order.

mod fit;
mod pairs;
mod sites;
mod strain;

use super::cells::CellGeometry;
use crate::element::quadrature::{Simplex, rule};
use crate::mesh::Mesh;
use crate::parallel;
use crate::space::TaylorHood;
use fit::{Fit, Quadratic};
use sites::Sites;
use strain::{Cells, EnergyForm};

pub use pairs::{CellProducts, FormMatrix, NUMBERS, cell_products};

/// How far the polynomials of inner vertices reach along the rim: a corner has
/// neighbours on the rim only.
const ROUNDS: usize = 2;

/// A displacement and the cells it lives on.
#[derive(Clone, Copy)]
pub struct Recovery<'a> {
    /// Mesh.
    pub mesh: &'a Mesh,
    /// Multiplies its coordinates.
    pub scale: f64,
    /// Numbering.
    pub space: &'a TaylorHood,
    /// Of the scaled cells.
    pub geometry: &'a CellGeometry,
    /// Region of each cell: fits do not cross from one to another `[cells]`.
    pub regions: &'a [u16],
    /// mu and lambda of each cell `[cells]`.
    pub moduli: &'a [[f64; 2]],
    /// Hierarchical displacement.
    pub displacement: &'a [f64],
    /// Pressures of the vertices; empty where there are none.
    pub pressure: &'a [f64],
}

/// Squares of energy norms, cell by cell.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CellSquares {
    /// eta_K^2 `[cells]`.
    pub error: Vec<f64>,
    /// int_K 2 mu |eps(u_h)|^2 + lambda (div u_h)^2 `[cells]`.
    pub energy: Vec<f64>,
}

impl Recovery<'_> {
    /// Estimates the error cell by cell.
    pub fn squares(&self) -> CellSquares {
        match self.space.components {
            2 => self.run::<2, 3, 3, 6, 3>(),
            _ => self.run::<3, 4, 6, 10, 6>(),
        }
    }

    /// D components, V vertices and E edges a cell, M monomials, S strains.
    fn run<const D: usize, const V: usize, const E: usize, const M: usize, const S: usize>(
        &self,
    ) -> CellSquares {
        let cells = Cells::<D, V, E, S>::new(*self);
        let sites = Sites::new(self.mesh, self.regions);
        let polynomials = polynomials::<D, V, E, M, S>(&cells, &sites);
        let form = EnergyForm::<V, E, S>::new();
        let squares = parallel::map(self.geometry.cells(), 1, &|cell| {
            let at = sites.of_cell(self.mesh.cell(cell), self.regions[cell]);
            let difference = cells.difference::<M>(cell, |corner| &polynomials[at[corner]]);
            let measure = self.geometry.volumes[cell];
            let [shear, lame] = self.moduli[cell];
            let error = form.square(&difference, shear, lame);
            [measure * error, measure * cells.energy(cell, [shear, lame])]
        });
        CellSquares {
            error: squares.iter().map(|pair| pair[0]).collect(),
            energy: squares.iter().map(|pair| pair[1]).collect(),
        }
    }
}

/// The recovered strain around every site.
fn polynomials<const D: usize, const V: usize, const E: usize, const M: usize, const S: usize>(
    cells: &Cells<'_, D, V, E, S>,
    sites: &Sites,
) -> Vec<Quadratic<M, S>> {
    let simplex = match D {
        2 => Simplex::Triangle,
        _ => Simplex::Tetrahedron,
    };
    let points = rule(simplex, 2).points;
    let fitted = |patch: &[u32], centre: [f64; 3]| {
        let mut fit = Fit::<D, M, S>::default();
        for &cell in patch {
            cells.visit(cell as usize, &points, |x, strain| {
                fit.add(std::array::from_fn(|i| x[i] - centre[i]), strain);
            });
        }
        fit.solve()
    };
    let mut known = parallel::map(sites.len(), 1, &|site| {
        let centre = cells.vertex(sites.vertex(site));
        (!sites.is_rim(site)).then(|| fitted(sites.cells(site), centre))
    });
    for _ in 0..ROUNDS {
        known = parallel::map(sites.len(), 1, &|site| {
            known[site].or_else(|| mean_at(cells, sites, &known, site))
        });
    }
    parallel::map(sites.len(), 1, &|site| {
        known[site].unwrap_or_else(|| {
            let centre = cells.vertex(sites.vertex(site));
            let around = sites.neighbours(cells.problem.mesh, cells.problem.regions, site);
            fitted(&sites.two_rings(&around), centre)
        })
    })
}

/// Mean of the neighbours' known polynomials, centred anew; none without one.
fn mean_at<const D: usize, const V: usize, const E: usize, const M: usize, const S: usize>(
    cells: &Cells<'_, D, V, E, S>,
    sites: &Sites,
    known: &[Option<Quadratic<M, S>>],
    site: usize,
) -> Option<Quadratic<M, S>> {
    let centre = cells.vertex(sites.vertex(site));
    let mut sum = Quadratic::default();
    let mut count = 0.0;
    for site in sites.neighbours(cells.problem.mesh, cells.problem.regions, site) {
        if let Some(polynomial) = &known[site] {
            let other = cells.vertex(sites.vertex(site));
            let shift = std::array::from_fn(|i| centre[i] - other[i]);
            sum.add(&polynomial.centred_at::<D>(shift));
            count += 1.0;
        }
    }
    (count > 0.0).then(|| sum.scaled(1.0 / count))
}

#[cfg(test)]
mod tests;
