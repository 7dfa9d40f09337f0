//! Assembled matrices of the enriched elements: stiffness A, divergence B and
//! pressure mass, with exact integrals.
//!
//! For shapes s, t along directions d, e: int 2 mu eps:eps + lambda div div =
//! mu (d.e grad s . grad t + (d . grad t)(e . grad s)) + lambda (d . grad s)(e . grad t).
//! Shapes are products of barycentric coordinates, so that gradients are sums
//! of such products times constant vectors, with means
//! d! prod alpha_i! / (|alpha| + d)! over a simplex. Nothing is eliminated.
//! Cost: some thousand flops per cell and 12 bytes per entry.

use crate::assembly::cells::{CellGeometry, CellModuli};
use crate::compare::space::enriched::{Enriched, Function, Pressures, Shape};
use crate::linalg::{SparseRows, SparseRowsBuilder};
use crate::mesh::Mesh;

/// Mean over a simplex of a product of barycentric coordinates, each listed as
/// often as it is a factor.
fn mean(corners: usize, factors: impl Iterator<Item = usize>) -> f64 {
    let mut powers = [0_u32; 4];
    let mut total = corners - 1;
    let mut value: f64 = (1..corners).map(|k| k as f64).product();
    for factor in factors {
        powers[factor] += 1;
        total += 1;
        value *= f64::from(powers[factor]);
    }
    value / (1..=total).map(|k| k as f64).product::<f64>()
}

/// Vertices of a shape without one of them.
fn without(shape: &Shape, left_out: usize) -> impl Iterator<Item = usize> {
    shape
        .vertices
        .iter()
        .copied()
        .filter(move |&v| v != left_out)
}

/// One term of an integral of two gradients.
#[derive(Clone, Copy, Debug)]
struct Term {
    /// Local vertex of the cell whose barycentric gradient stands on the left.
    first: usize,
    /// Local vertex of the cell whose barycentric gradient stands on the right.
    second: usize,
    /// Mean over the cell of what multiplies the product of the two gradients.
    weight: f64,
}

/// Means of products of gradients for each pair of shapes.
struct GradientProducts {
    /// Number of shapes of a cell, so that the pair (s, t) stands at `s * shapes + t`.
    shapes: usize,
    /// The terms of each pair of shapes, row-major `[shapes, shapes]`; none where the
    /// integral vanishes.
    terms: Vec<Vec<Term>>,
}

impl GradientProducts {
    /// Integrates the products of barycentric coordinates once for all cells: they do
    /// not depend on the geometry.
    fn new(space: &Enriched) -> Self {
        let corners = space.components + 1;
        let shapes = &space.shapes;
        let terms = |s: &Shape, t: &Shape| {
            // The gradient of a full bubble has mean zero, that of P1 is constant.
            let full = |shape: &Shape| shape.vertices.len() == corners;
            let linear = |shape: &Shape| shape.vertices.len() == 1;
            if (full(s) && linear(t)) || (linear(s) && full(t)) {
                return Vec::new();
            }
            let pairs = s
                .vertices
                .iter()
                .flat_map(|&v| t.vertices.iter().map(move |&w| (v, w)));
            pairs
                .map(|(first, second)| Term {
                    first,
                    second,
                    weight: s.scale
                        * t.scale
                        * mean(corners, without(s, first).chain(without(t, second))),
                })
                .collect()
        };
        Self {
            shapes: shapes.len(),
            terms: shapes
                .iter()
                .flat_map(|s| shapes.iter().map(move |t| terms(s, t)))
                .collect(),
        }
    }

    /// The terms of the integral of grad s . grad t over a cell.
    fn of(&self, s: usize, t: usize) -> &[Term] {
        &self.terms[s * self.shapes + t]
    }
}

/// The scalar product of two vectors `[3]`.
fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Cells and local numbers of the functions of each unknown.
fn incident(size: usize, functions: &[Vec<Function>]) -> Vec<Vec<(u32, u8)>> {
    let mut incident = vec![Vec::new(); size];
    for (cell, list) in functions.iter().enumerate() {
        for (local, function) in list.iter().enumerate() {
            incident[function.unknown as usize].push((cell as u32, local as u8));
        }
    }
    incident
}

/// The functions of every cell `[cells]`, gathered once so that assembly does not
/// search facets.
fn all_functions(space: &Enriched, mesh: &Mesh) -> Vec<Vec<Function>> {
    let cells = 0..space.cells;
    cells.map(|cell| space.functions(mesh, cell)).collect()
}

/// A `[displacement, displacement]`.
pub(crate) fn stiffness(
    space: &Enriched,
    mesh: &Mesh,
    geometry: &CellGeometry,
    moduli: &CellModuli,
) -> SparseRows {
    let products = GradientProducts::new(space);
    let functions = all_functions(space, mesh);
    let entry = |cell: usize, a: &Function, b: &Function| {
        let g = geometry.gradients_of(cell);
        let (shear, lame) = (moduli.shear[cell], moduli.lame[cell]);
        let (d, e) = (&a.direction, &b.direction);
        let along = dot(d, e);
        let term = |term: &Term| {
            let (s, t) = (&g[term.first], &g[term.second]);
            let shear_part = along * dot(s, t) + dot(d, t) * dot(e, s);
            term.weight * (shear * shear_part + lame * dot(d, s) * dot(e, t))
        };
        let terms = products.of(a.shape, b.shape).iter();
        geometry.volumes[cell] * terms.map(term).sum::<f64>()
    };
    let mut builder = SparseRowsBuilder::new(space.displacement_unknowns());
    let mut row = Vec::new();
    for touching in &incident(space.displacement_unknowns(), &functions) {
        row.clear();
        for &(cell, local) in touching {
            let list = &functions[cell as usize];
            let own = &list[usize::from(local)];
            let coupled = |other: &&Function| !products.of(own.shape, other.shape).is_empty();
            for other in list.iter().filter(coupled) {
                row.push((other.unknown, entry(cell as usize, own, other)));
            }
        }
        builder.push_row(&mut row);
    }
    builder.finish()
}

/// Means of a pressure function times the gradient of a displacement function,
/// along its direction.
fn flux(space: &Enriched, g: &[[f64; 3]], function: &Function, pressure: Option<usize>) -> f64 {
    let shape = &space.shapes[function.shape];
    let term = |&v: &usize| {
        let factors = without(shape, v).chain(pressure);
        let weight = shape.scale * mean(space.components + 1, factors);
        weight * dot(&g[v], &function.direction)
    };
    shape.vertices.iter().map(term).sum()
}

/// B `[pressure, displacement]`: (B u)_q = - int q div u.
pub(crate) fn divergence(space: &Enriched, mesh: &Mesh, geometry: &CellGeometry) -> SparseRows {
    let mut rows: Vec<Vec<(u32, f64)>> = vec![Vec::new(); space.pressure_unknowns()];
    for cell in 0..space.cells {
        let g = geometry.gradients_of(cell);
        for function in space.functions(mesh, cell) {
            let mut add = |row: u32, pressure: Option<usize>| {
                let value = -geometry.volumes[cell] * flux(space, g, &function, pressure);
                rows[row as usize].push((function.unknown, value));
            };
            match space.pressures(mesh, cell) {
                Pressures::Constant(own) => add(own, None),
                Pressures::Linear(corners) => {
                    let corners = corners.iter().enumerate();
                    corners.for_each(|(local, &vertex)| add(vertex, Some(local)));
                }
            }
        }
    }
    let mut builder = SparseRowsBuilder::new(space.displacement_unknowns());
    rows.iter_mut().for_each(|row| builder.push_row(row));
    builder.finish()
}

/// Pressure mass with a weight per cell `[pressure, pressure]`.
pub(crate) fn pressure_mass(
    space: &Enriched,
    mesh: &Mesh,
    geometry: &CellGeometry,
    weight: impl Fn(usize) -> f64,
) -> SparseRows {
    let corners = space.components + 1;
    let mut rows: Vec<Vec<(u32, f64)>> = vec![Vec::new(); space.pressure_unknowns()];
    for cell in 0..space.cells {
        let volume = weight(cell) * geometry.volumes[cell];
        match space.pressures(mesh, cell) {
            Pressures::Constant(own) => rows[own as usize].push((own, volume)),
            Pressures::Linear(vertices) => {
                for (i, &row) in vertices.iter().enumerate() {
                    for (j, &column) in vertices.iter().enumerate() {
                        let value = volume * mean(corners, [i, j].into_iter());
                        rows[row as usize].push((column, value));
                    }
                }
            }
        }
    }
    let mut builder = SparseRowsBuilder::new(space.pressure_unknowns());
    rows.iter_mut().for_each(|row| builder.push_row(row));
    builder.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::space::enriched::Enrichment;
    use crate::element::quadrature::{Simplex, rule};
    use crate::linalg::vector::{dot as inner, reproducible_noise};
    use crate::linalg::{LinearOperator, Workspace};
    use crate::mesh::samples;

    struct Case {
        mesh: Mesh,
        space: Enriched,
        geometry: CellGeometry,
        moduli: CellModuli,
        simplex: Simplex,
    }

    fn cases() -> Vec<Case> {
        let mut cases = Vec::new();
        for enrichment in [Enrichment::CellBubbles, Enrichment::FacetBubbles] {
            for (mesh, simplex) in [
                (samples::cube(1), Simplex::Tetrahedron),
                (samples::rectangle(2, 1), Simplex::Triangle),
            ] {
                let geometry = CellGeometry::new(&mesh, 0.7);
                let cells = geometry.cells();
                cases.push(Case {
                    space: Enriched::new(&mesh, enrichment),
                    moduli: CellModuli {
                        shear: (0..cells).map(|cell| 1.0 + 0.3 * cell as f64).collect(),
                        lame: vec![0.4; cells],
                        augmented: vec![0.4; cells],
                        inverse_lame: vec![0.1; cells],
                    },
                    geometry,
                    mesh,
                    simplex,
                });
            }
        }
        cases
    }

    impl Case {
        /// Gradient du_i/dx_j of a vector at a point of a cell.
        fn gradient(&self, u: &[f64], cell: usize, l: &[f64]) -> [[f64; 3]; 3] {
            let g = self.geometry.gradients_of(cell);
            let mut sum = [[0.0; 3]; 3];
            for function in self.space.functions(&self.mesh, cell) {
                let slope = self.space.shapes[function.shape].gradient(l, g);
                for i in 0..3 {
                    for j in 0..3 {
                        let value = u[function.unknown as usize] * function.direction[i];
                        sum[i][j] += value * slope[j];
                    }
                }
            }
            sum
        }

        /// Energies by a rule of degree 8: 1/2 u.A u and p.B u.
        fn by_quadrature(&self, u: &[f64], p: &[f64]) -> [f64; 2] {
            let rule = rule(self.simplex, 8);
            let mut sums = [0.0; 2];
            for cell in 0..self.geometry.cells() {
                let (shear, lame) = (self.moduli.shear[cell], self.moduli.lame[cell]);
                for (point, weight) in rule.points.iter().zip(&rule.weights) {
                    let l = &point[..self.space.components + 1];
                    let weight = weight * self.geometry.volumes[cell];
                    let g = self.gradient(u, cell, l);
                    let divergence = g[0][0] + g[1][1] + g[2][2];
                    let mut square = 0.5 * lame * divergence * divergence;
                    for i in 0..3 {
                        for j in 0..3 {
                            square += shear * (0.5 * (g[i][j] + g[j][i])).powi(2);
                        }
                    }
                    let pressure = self.space.pressures(&self.mesh, cell).at(l, p);
                    sums[0] += weight * square;
                    sums[1] -= weight * pressure * divergence;
                }
            }
            sums
        }
    }

    #[test]
    fn assembled_matrices_have_the_energies_of_their_functions() {
        let mut work = Workspace::new();
        for case in cases() {
            let u = reproducible_noise(case.space.displacement_unknowns());
            let p = reproducible_noise(case.space.pressure_unknowns());
            let a = stiffness(&case.space, &case.mesh, &case.geometry, &case.moduli);
            let b = divergence(&case.space, &case.mesh, &case.geometry);
            let (mut au, mut bu) = (vec![0.0; u.len()], vec![0.0; p.len()]);
            a.apply(&u, &mut au, &mut work);
            b.apply(&u, &mut bu, &mut work);
            let exact = case.by_quadrature(&u, &p);
            let found = [0.5 * inner(&u, &au), inner(&p, &bu)];
            for (found, exact) in found.iter().zip(exact) {
                assert!(
                    (found - exact).abs() < 1e-12 * exact.abs().max(1.0),
                    "{found} {exact}"
                );
            }
        }
    }

    #[test]
    fn the_pressure_mass_of_one_is_the_volume() {
        let mut work = Workspace::new();
        for case in cases() {
            let mass = pressure_mass(&case.space, &case.mesh, &case.geometry, |_| 1.0);
            let ones = vec![1.0; case.space.pressure_unknowns()];
            let mut product = vec![0.0; ones.len()];
            mass.apply(&ones, &mut product, &mut work);
            let volume: f64 = case.geometry.volumes.iter().sum();
            assert!((inner(&ones, &product) - volume).abs() < 1e-13);
        }
    }
}
