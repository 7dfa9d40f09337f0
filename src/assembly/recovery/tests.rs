//! What the recovered strain reproduces, and what it takes for an error.

use super::fit::Fit;
use super::{CellSquares, Recovery};
use crate::assembly::CellGeometry;
use crate::linalg::vector::reproducible_noise;
use crate::mesh::{Mesh, samples};
use crate::space::TaylorHood;

/// Squares of the displacement that is `field` at the P2 nodes.
fn squares(
    mesh: &Mesh,
    regions: &[u16],
    lame: f64,
    field: impl Fn([f64; 3]) -> [f64; 3],
) -> CellSquares {
    let space = TaylorHood::new(mesh);
    let geometry = CellGeometry::new(mesh, 1.0);
    let c = space.components;
    let x = mesh.coordinates();
    let mut displacement: Vec<f64> = x.iter().flat_map(|&x| field(x)[..c].to_vec()).collect();
    for &[a, b] in space.edges.iter() {
        let (a, b) = (x[a as usize], x[b as usize]);
        let middle = field(std::array::from_fn(|i| 0.5 * (a[i] + b[i])));
        let (at_a, at_b) = (field(a), field(b));
        displacement.extend((0..c).map(|i| middle[i] - 0.5 * (at_a[i] + at_b[i])));
    }
    let moduli = vec![[1.0, lame]; mesh.cell_count()];
    let recovery = Recovery {
        mesh,
        scale: 1.0,
        space: &space,
        geometry: &geometry,
        regions,
        moduli: &moduli,
        displacement: &displacement,
        pressure: &[],
    };
    recovery.squares()
}

fn sum(values: &[f64]) -> f64 {
    values.iter().sum()
}

#[test]
fn a_quadratic_displacement_has_no_error() {
    let field = |[x, y, z]: [f64; 3]| [x * x - y * z, x * y + 0.5 * z * z, y * y - x * z];
    let plane = |[x, y, _]: [f64; 3]| [x * x - x * y, y * y + 2.0 * x * y, 0.0];
    for (mesh, field) in [
        (samples::cube(1), field as fn([f64; 3]) -> [f64; 3]),
        (samples::cube(4), field),
        (samples::rectangle(4, 3), plane),
    ] {
        let regions = vec![0; mesh.cell_count()];
        let found = squares(&mesh, &regions, 0.7, field);
        assert!(
            sum(&found.error) < 1e-24 * sum(&found.energy),
            "{:e}",
            sum(&found.error)
        );
    }
}

#[test]
fn the_energy_is_that_of_the_displacement() {
    // eps = diag(2x, 0, 0): int 2 |eps|^2 + lambda (tr eps)^2 = (2 + lambda) 4 / 3.
    let mesh = samples::cube(3);
    let regions = vec![0; mesh.cell_count()];
    let found = squares(&mesh, &regions, 0.5, |[x, _, _]| [x * x, 0.0, 0.0]);
    assert!((sum(&found.energy) - 2.5 * 4.0 / 3.0).abs() < 1e-12);
}

#[test]
fn a_strain_that_jumps_between_regions_is_no_error() {
    let kink = |[x, _, _]: [f64; 3]| [(x - 0.5).abs(), 0.0, 0.0];
    for mesh in [samples::cube(4), samples::rectangle(4, 4)] {
        let middle = |cell: usize| {
            let corners = mesh.cell(cell).iter();
            let sum: f64 = corners.map(|&v| mesh.coordinates()[v as usize][0]).sum();
            sum / mesh.cell(cell).len() as f64
        };
        let sides: Vec<u16> = (0..mesh.cell_count())
            .map(|cell| u16::from(middle(cell) > 0.5))
            .collect();
        let apart = squares(&mesh, &sides, 0.0, kink);
        assert!(sum(&apart.error) < 1e-24, "{:e}", sum(&apart.error));
        let together = squares(&mesh, &vec![0; sides.len()], 0.0, kink);
        assert!(sum(&together.error) > 1e-2 * sum(&together.energy));
    }
}

#[test]
fn the_error_of_a_cubic_displacement_is_found() {
    // The error of the nodal interpolant of x^3 in 1D: int (d/dx)^2 = h^4 / 20.
    let mesh = samples::cube(8);
    let regions = vec![0; mesh.cell_count()];
    let found = squares(&mesh, &regions, 0.0, |[x, _, _]| [x.powi(3), 0.0, 0.0]);
    let exact = 2.0 * (1.0_f64 / 8.0).powi(4) / 20.0;
    let index = (sum(&found.error) / exact).sqrt();
    assert!((index - 1.0).abs() < 0.3, "{index}");
}

#[test]
fn a_moved_centre_leaves_the_polynomial_as_it_is() {
    let mut fit = Fit::<3, 10, 6>::default();
    for x in reproducible_noise(120).as_chunks::<3>().0 {
        let value = std::array::from_fn(|s| x[0] * x[1] - 0.3 * x[2] * x[2] + s as f64 * x[2]);
        fit.add(*x, &value);
    }
    let polynomial = fit.solve();
    let moved = polynomial.centred_at::<3>([0.2, -0.1, 0.4]);
    let (near, far) = (
        moved.at::<3>([0.3, 0.5, -0.2]),
        polynomial.at::<3>([0.5, 0.4, 0.2]),
    );
    for s in 0..6 {
        assert!((near[s] - far[s]).abs() < 1e-12);
        let exact = 0.5 * 0.4 - 0.3 * 0.2 * 0.2 + s as f64 * 0.2;
        assert!((far[s] - exact).abs() < 1e-10, "{} {exact}", far[s]);
    }
}

#[test]
fn points_that_determine_less_than_a_quadratic_are_fitted_by_less() {
    let mut fit = Fit::<2, 6, 3>::default();
    for (x, y) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
        fit.add([x, y, 0.0], &[1.0 + x, 2.0 * y, x - y]);
    }
    let value = fit.solve().at::<2>([0.25, 0.5, 0.0]);
    for (found, exact) in value.iter().zip([1.25, 1.0, -0.25]) {
        assert!((found - exact).abs() < 1e-12, "{value:?}");
    }
}
