//! The inf-sup constant of contact pressures against displacements:
//!
//! ```text
//! beta = inf over l of |l|_h / |l|,   |l|^2 = sup over v of (int l v_n dS)^2 / a(v, v) = l C A^-1 C^T l
//! ```
//!
//! `|.|_h` over the displacements of the own mesh, `|.|` over those of a much finer one,
//! a(v, v) = int 2 mu eps:eps with rollers on all sides but the lid. The values are those of an
//! independent code (contact_space_digits.py).

use std::sync::Arc;

use crate::common::meshes::{cube, square};
use signorini::assembly::grid::{Basis, GridSource, VolumeTerm};
use signorini::assembly::probe::{Probed, Probes};
use signorini::assembly::{CellGeometry, CellModuli, Grid, Stiffness};
use signorini::contact::basis::{Bernstein, Hats};
use signorini::contact::gap::{Deformed, Measure};
use signorini::contact::surface::{FACE_DEGREE, face_rule};
use signorini::contact::{ContactBasis, ContactSurface, linearise};
use signorini::linalg::cholesky::{LowerColumns, Precision, SparseCholesky};
use signorini::linalg::ordering::nested_dissection;
use signorini::linalg::{DenseCholesky, DenseMatrix, Held, SparseRows, Workspace};
use signorini::mesh::GroupKind;
use signorini::obstacle::HalfSpace;
use signorini::space::TaylorHood;
use signorini::{Mesh, MeshParts};

/// The unit square or cube with its lid, the last upper side.
struct Body {
    mesh: Mesh,
    space: TaylorHood,
    surface: ContactSurface,
    /// Whether rollers hold an unknown.
    held: Vec<bool>,
}

impl Body {
    fn new(parts: MeshParts, basis: &'static dyn ContactBasis) -> Self {
        let mesh = Mesh::new(parts).expect("a valid mesh");
        let space = TaylorHood::new(&mesh);
        let lid = ["", "", "y1", "z1"][space.components];
        let lid = mesh.group(lid, GroupKind::Facets).expect("a lid");
        let facets = lid.members.iter();
        let facets: Vec<Vec<u32>> = facets.map(|&f| mesh.facet(f as usize).to_vec()).collect();
        let surface = ContactSurface::new(&mesh, &space, 1.0, &facets).with_basis(basis);
        let held = held(&mesh, &space);
        Self {
            mesh,
            space,
            surface,
            held,
        }
    }

    /// -int psi_j v_n dS `[multipliers, unknowns]`.
    fn coupling(&self) -> Vec<Vec<(u32, f64)>> {
        let up = self.space.components - 1;
        let axis = |length: f64| std::array::from_fn(|i| if i == up { length } else { 0.0 });
        let lid = HalfSpace::new(axis(1.0), axis(-1.0)).expect("a half-space");
        let body = Deformed {
            mesh: &self.mesh,
            scale: 1.0,
            space: &self.space,
            displacement: &vec![0.0; self.held.len()],
            rule: &face_rule(self.space.components, FACE_DEGREE),
            measure: Measure::Undeformed,
        };
        linearise(&body, &self.surface, &lid, &self.held).rows
    }

    fn stiffness(&self, probes: &Probes) -> SparseRows {
        let cells = self.mesh.cell_count();
        let moduli = CellModuli {
            shear: vec![1.0; cells],
            lame: vec![0.0; cells],
            augmented: vec![0.0; cells],
            inverse_lame: Vec::new(),
        };
        let grid = Arc::new(Grid::new(GridSource {
            mesh: &self.mesh,
            space: &self.space,
            geometry: &CellGeometry::new(&self.mesh, 1.0),
            moduli: &moduli,
            held: &Held::of_entries(self.space.components, []),
        }));
        let operator = Stiffness {
            grid,
            basis: Basis::Hierarchical,
            volume: VolumeTerm::Own,
            size: self.held.len(),
        };
        let probed = Probed {
            operator: &operator,
            rows: self.space.components,
        };
        let matrix = probes.matrix(probed, &|| false, &mut Workspace::new());
        matrix.expect("nobody stops")
    }

    fn factor(&self) -> SparseCholesky {
        let probes = Probes::new(&self.mesh, &self.space);
        let lower = lower_columns(&self.stiffness(&probes), &self.held);
        let nodes = 0..self.space.nodes() as u32;
        let places = nodes.map(|node| self.space.node_place(&self.mesh, node));
        let places: Vec<[f64; 3]> = places.collect();
        let c = self.space.components as u32;
        let order = nested_dissection(&places, &probes.near, &[]);
        let order = order
            .iter()
            .flat_map(|node| (0..c).map(move |i| node * c + i));
        let order: Vec<u32> = order.collect();
        SparseCholesky::new(&lower, &order, Precision::Double).expect("a held body")
    }

    /// R A^-1 R^T.
    fn compliance(&self, rows: &[Vec<(u32, f64)>]) -> DenseMatrix {
        let (factor, mut work) = (self.factor(), Workspace::new());
        let mut compliance = DenseMatrix::zeros(rows.len(), rows.len());
        for (j, row) in rows.iter().enumerate() {
            let mut u = vec![0.0; self.held.len()];
            row.iter().for_each(|&(k, value)| u[k as usize] = value);
            factor.solve(&mut u, 1, &mut work);
            for (i, row) in rows.iter().enumerate() {
                let products = row.iter().map(|&(k, value)| value * u[k as usize]);
                *compliance.at_mut(i, j) = products.sum();
            }
        }
        compliance
    }

    /// Values of all functions at a point of the lid.
    fn values(&self, point: [f64; 3], basis: &dyn ContactBasis) -> Vec<f64> {
        let corners = self.space.components;
        let inside = |l: &Vec<f64>| l.iter().all(|&l| l > -1e-12);
        let faces = self.surface.faces.iter();
        let places = faces.map(|face| (face, self.barycentric(&face.corners, point)));
        let mut around = places.filter(|(_, l)| inside(l));
        let (face, l) = around.next().expect("a point of the lid");
        let mut own = vec![0.0; basis.functions(corners)];
        basis.values(&l, &mut own);
        let mut values = vec![0.0; self.surface.multipliers()];
        for (&function, value) in face.functions.iter().zip(own) {
            values[function as usize] = value;
        }
        values
    }

    /// Barycentric coordinates on a face of the lid, whose height they leave out.
    fn barycentric(&self, corners: &[u32], point: [f64; 3]) -> Vec<f64> {
        let corner = |k: usize| self.mesh.coordinates()[corners[k] as usize];
        let from = |k: usize, x: [f64; 3]| [x[0] - corner(k)[0], x[1] - corner(k)[1]];
        let (to, first) = (from(0, point), from(0, corner(1)));
        if corners.len() == 2 {
            let along = to[0] / first[0];
            return vec![1.0 - along, along];
        }
        let second = from(0, corner(2));
        let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
        let whole = cross(first, second);
        let (a, b) = (cross(to, second) / whole, cross(first, to) / whole);
        vec![1.0 - a - b, a, b]
    }
}

/// Normal components of all sides but the lid.
fn held(mesh: &Mesh, space: &TaylorHood) -> Vec<bool> {
    let c = space.components;
    let of_node = |node: u32| {
        let place = space.node_place(mesh, node);
        (0..c).map(move |axis| {
            let is_lid = axis == c - 1 && place[axis] > 0.5;
            !is_lid && (place[axis] - 0.5).abs() > 0.5 - 1e-12
        })
    };
    (0..space.nodes() as u32).flat_map(of_node).collect()
}

/// The lower triangle, identity where an unknown is held.
fn lower_columns(matrix: &SparseRows, held: &[bool]) -> LowerColumns {
    let mut lower = LowerColumns {
        offsets: vec![0],
        ..LowerColumns::default()
    };
    for (j, &is_held) in held.iter().enumerate() {
        let (rows, values) = matrix.row(j);
        for (&i, &value) in rows.iter().zip(values) {
            let is_diagonal = i as usize == j;
            if i as usize >= j && (is_diagonal || !(is_held || held[i as usize])) {
                lower.rows.push(i);
                lower.values.push(if is_held { 1.0 } else { value });
            }
        }
        lower.offsets.push(lower.rows.len() as u32);
    }
    lower
}

/// The rows of the coarse multipliers on a finer body, whose functions hold the coarse
/// ones: coefficients are values at vertices and 2 psi(middle) - mean of the ends at edges.
fn injected(coarse: &Body, fine: &Body, basis: &'static dyn ContactBasis) -> Vec<Vec<(u32, f64)>> {
    let mut dense = vec![vec![0.0; fine.held.len()]; coarse.surface.multipliers()];
    for (&node, row) in fine.surface.carriers.iter().zip(fine.coupling()) {
        for (one, coefficient) in dense
            .iter_mut()
            .zip(coefficients(coarse, fine, node, basis))
        {
            row.iter()
                .for_each(|&(k, value)| one[k as usize] += coefficient * value);
        }
    }
    let entries = |row: Vec<f64>| {
        let all = (0..).zip(row);
        all.filter(|(_, value)| value.abs() > 0.0).collect()
    };
    dense.into_iter().map(entries).collect()
}

/// Coefficients of the coarse functions in the function of a fine node.
fn coefficients(
    coarse: &Body,
    fine: &Body,
    node: u32,
    basis: &'static dyn ContactBasis,
) -> Vec<f64> {
    let place = |node: u32| fine.space.node_place(&fine.mesh, node);
    let at_node = coarse.values(place(node), basis);
    let Some(edge) = (node as usize).checked_sub(fine.space.vertices) else {
        return at_node;
    };
    let ends = fine.space.edges[edge].map(|end| coarse.values(place(end), basis));
    let values = at_node.iter().zip(&ends[0]).zip(&ends[1]);
    values.map(|((m, a), b)| 2.0 * m - 0.5 * (a + b)).collect()
}

/// The largest beta for which |l|_h >= beta |l|, to 1e-4, by bisection on the sign.
fn inf_sup(
    mesh: fn(usize) -> MeshParts,
    [own, finer]: [usize; 2],
    basis: &'static dyn ContactBasis,
) -> f64 {
    let (coarse, fine) = (Body::new(mesh(own), basis), Body::new(mesh(finer), basis));
    let own = coarse.compliance(&coarse.coupling());
    let all = fine.compliance(&injected(&coarse, &fine, basis));
    let (mut low, mut high) = (0.0, 1.0);
    while high - low > 1e-4 {
        let middle = 0.5 * (low + high);
        match is_larger(&own, &all, middle * middle) {
            true => low = middle,
            false => high = middle,
        }
    }
    low
}

/// Whether `own` - `factor` `all` is positive definite.
fn is_larger(own: &DenseMatrix, all: &DenseMatrix, factor: f64) -> bool {
    let mut difference = DenseMatrix::zeros(own.rows(), own.rows());
    for j in 0..own.rows() {
        for i in 0..own.rows() {
            *difference.at_mut(i, j) = own.at(i, j) - factor * all.at(i, j);
        }
    }
    DenseCholesky::new(&difference).is_ok()
}

/// Checks own and finer meshes against the values of the independent code.
fn check(
    mesh: fn(usize) -> MeshParts,
    basis: &'static dyn ContactBasis,
    cases: &[([usize; 2], f64)],
) {
    for &(counts, expected) in cases {
        let beta = inf_sup(mesh, counts, basis);
        assert!((beta - expected).abs() < 2e-4, "{counts:?} {beta}");
    }
}

#[test]
fn quadratic_pressures_on_a_square_have_the_same_constant_on_every_mesh() {
    let cases = [
        ([2, 8], 0.5531),
        ([4, 16], 0.5538),
        ([8, 32], 0.5541),
        ([16, 64], 0.5541),
    ];
    check(square, &Bernstein, &cases);
}

#[test]
fn quadratic_pressures_on_a_cube_have_a_constant_above_a_half_on_every_mesh() {
    check(cube, &Bernstein, &[([2, 4], 0.5463), ([3, 6], 0.5439)]);
    let finest = inf_sup(cube, [4, 8], &Bernstein);
    assert!((finest - 0.5439).abs() < 1e-3, "{finest}");
}

#[test]
fn hats_have_a_larger_constant() {
    check(
        square,
        &Hats,
        &[([2, 8], 0.8381), ([4, 16], 0.8380), ([8, 32], 0.8380)],
    );
    check(cube, &Hats, &[([2, 4], 0.8132), ([3, 6], 0.8181)]);
}
