//! What the places of vertices do in cells:
//!
//! ```text
//! L = int l dX,   l = - P(H, p) : Z + q (J - 1 + p / K) + b . z  [+ W - p (J - 1) - p^2 / (2 K)]
//! dL/dX_b = int (l I - H^T l_H - Z^T l_Z) grad N_b dX
//! ```
//!
//! H the gradient of the displacement, Z and z those of the dual one, q its pressure; in brackets
//! what a goal of the energy adds. Coefficients stay, so that gradients change by -H (dX grad N_b)
//! (J. D. Eshelby, 1951). About an axis the radius moves with the vertices, and with it the measure
//! and what goes around. The rule is that of the residuals. Non-dimensional.
//!
//! Cost: a tangent of the law a point of the rule.

use super::super::dual::Dual;
use super::super::form::{Linear, linear};
use super::add_share;
use crate::assembly::strain::CURVED_DEGREE;
use crate::element::quadrature::{Rule, rule};
use crate::geometry::Matrix3;
use crate::geometry::vector3::{add, dot, scale};
use crate::material::Rubber;
use crate::model::Model;
use crate::model::loads::simplices;
use crate::model::state::State;
use crate::model::values::{displacement_at, gradient_at, radius_at};

/// Cells that are worth a thread; chosen.
const LEAST_CELLS: usize = 64;

/// A law at the points of a cell.
enum Law<'a> {
    Rubber { law: &'a Rubber, penalty: f64 },
    Linear(Linear),
}

/// Fields at a point.
struct Point {
    /// H and Z.
    gradients: [Matrix3; 2],
    /// p and q.
    pressures: [f64; 2],
    /// Whether the goal is the energy.
    is_energy: bool,
}

/// l with its derivatives by H and Z.
struct Density {
    value: f64,
    by: [Matrix3; 2],
}

/// Adds dL/dX of all cells; `motion` is z.
pub(super) fn add_cells(
    model: &Model<'_>,
    state: &State,
    (dual, motion): (&Dual, &[f64]),
    sums: &mut [[f64; 3]],
) {
    let cells = Cells::new(model, state, (dual, motion));
    let count = model.prepared.geometry.cells();
    let all = crate::parallel::map(count, LEAST_CELLS, &|cell| cells.of(cell));
    for (cell, own) in all.into_iter().enumerate() {
        for (&vertex, value) in model.mesh.cell(cell).iter().zip(own) {
            add_share(&mut sums[vertex as usize], 1.0, value);
        }
    }
}

/// All cells of a body.
struct Cells<'a> {
    model: &'a Model<'a>,
    state: &'a State,
    /// z and q in the place of displacement and pressure.
    dual: State,
    is_energy: bool,
    laws: Vec<Rubber>,
    rule: Rule,
    /// Force per volume, with the load factor.
    body_force: [f64; 3],
}

impl<'a> Cells<'a> {
    fn new(model: &'a Model<'a>, state: &'a State, (dual, motion): (&Dual, &[f64])) -> Self {
        let problem = &model.plan.problem;
        let simplex = simplices(problem.units.dimension).0;
        let unit = state.drive.load / problem.units.body_force();
        Self {
            model,
            state,
            dual: State {
                displacement: motion.to_vec(),
                pressure: dual.fields.pressure.clone(),
                ..state.clone()
            },
            is_energy: dual.goal.is_energy(),
            laws: model.plan.laws(),
            rule: match &model.prepared.strain {
                Some(cells) => cells.rule().clone(),
                None => rule(simplex, CURVED_DEGREE),
            },
            body_force: scale(unit, problem.resolved.body_force),
        }
    }

    fn law(&self, cell: usize) -> Law<'_> {
        let material = usize::from(self.model.plan.problem.resolved.cell_material[cell]);
        match self.laws.get(material) {
            Some(law) => Law::Rubber {
                law,
                penalty: self.state.penalty * law.shear_modulus(),
            },
            None => Law::Linear(linear(self.model, material)),
        }
    }

    /// dL/dX of the corners of a cell.
    fn of(&self, cell: usize) -> [[f64; 3]; 4] {
        let geometry = &self.model.prepared.geometry;
        let (law, hats) = (self.law(cell), geometry.gradients_of(cell));
        let mut sums = [[0.0; 3]; 4];
        let points = self.rule.points.iter().zip(&self.rule.weights);
        for (point, weight) in points {
            let radius = geometry.radii.get(cell);
            let radius = radius.map(|mean| (radius_at(self.model, cell, point), *mean));
            let turn = radius.map_or(1.0, |(own, mean)| own / mean);
            let weight = weight * turn * geometry.volumes[cell];
            let at = self.point(cell, point);
            let mut density = law.density(&at);
            let force = displacement_at(self.model, &self.dual, cell, point);
            density.value += dot(self.body_force, force);
            for ((sum, hat), share) in sums.iter_mut().zip(hats).zip(point) {
                add_share(sum, weight, density.along(&at, *hat));
                if let Some((radius, _)) = radius {
                    sum[0] += weight * share / radius * density.around(&at);
                }
            }
        }
        sums
    }

    fn point(&self, cell: usize, point: &[f64; 4]) -> Point {
        let fields = [self.state, &self.dual];
        let pressure = |state: &State| {
            let corners = self.model.mesh.cell(cell).iter().zip(point);
            let parts = corners.filter_map(|(&v, l)| Some(l * state.pressure.get(v as usize)?));
            parts.sum()
        };
        Point {
            gradients: fields.map(|state| gradient_at(self.model, state, cell, point)),
            pressures: fields.map(pressure),
            is_energy: self.is_energy,
        }
    }
}

impl Density {
    /// (l I - H^T l_H - Z^T l_Z) n.
    fn along(&self, at: &Point, n: [f64; 3]) -> [f64; 3] {
        let mut sum = scale(self.value, n);
        for (gradient, by) in at.gradients.iter().zip(&self.by) {
            for (row, by) in gradient.iter().zip(by) {
                sum = add(sum, scale(-dot(*by, n), *row));
            }
        }
        sum
    }

    /// l less what goes around: by the radius, times the radius.
    fn around(&self, at: &Point) -> f64 {
        let parts = at.gradients.iter().zip(&self.by);
        self.value
            - parts
                .map(|(gradient, by)| gradient[2][2] * by[2][2])
                .sum::<f64>()
    }
}

impl Law<'_> {
    fn density(&self, at: &Point) -> Density {
        match self {
            Self::Rubber { law, penalty } => of_rubber(law, *penalty, at),
            Self::Linear(own) => of_linear(own, at),
        }
    }
}

fn of_rubber(law: &Rubber, penalty: f64, at: &Point) -> Density {
    let ([h, z], [p, q]) = (&at.gradients, at.pressures);
    let defect = -law.volume_defect(h, p);
    let pushed = p - penalty * defect;
    let stress = law.stress(h, pushed);
    let one = law.stress(h, pushed + 1.0);
    let cofactor: Matrix3 =
        std::array::from_fn(|i| std::array::from_fn(|j| stress[i][j] - one[i][j]));
    let tangent = law.tangent(h, pushed);
    let spread = penalty * double_dot(&cofactor, z);
    let mut by_h: Matrix3 = std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            let turned: f64 = dot_flat(&tangent[3 * i + j], z);
            -turned + (q - spread) * cofactor[i][j]
        })
    });
    let mut value = -double_dot(&stress, z) + q * defect;
    if at.is_energy {
        value += law.energy(h, p) + 0.5 * penalty * defect * defect;
        add_scaled(&mut by_h, 1.0, &stress);
    }
    Density {
        value,
        by: [by_h, stress.map(|row| row.map(|value| -value))],
    }
}

fn of_linear(own: &Linear, at: &Point) -> Density {
    let ([h, z], [p, q]) = (&at.gradients, at.pressures);
    let stress = |g: &Matrix3| -> Matrix3 {
        let trace = g[0][0] + g[1][1] + g[2][2];
        std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let volume = if i == j { own.lame * trace } else { 0.0 };
                own.shear * (g[i][j] + g[j][i]) + volume
            })
        })
    };
    let unit: Matrix3 =
        std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
    let trace = |g: &Matrix3| g[0][0] + g[1][1] + g[2][2];
    let inverse = own.inverse.unwrap_or(0.0);
    let (of_h, of_z) = (stress(h), stress(z));
    let mut by_h = of_z.map(|row| row.map(|value| -value));
    add_scaled(&mut by_h, q, &unit);
    let mut by_z = of_h.map(|row| row.map(|value| -value));
    add_scaled(&mut by_z, p, &unit);
    let mut value = -double_dot(&of_h, z) + p * trace(z) + q * (trace(h) + p * inverse);
    if at.is_energy {
        value += 0.5 * double_dot(&of_h, h) - p * trace(h) - 0.5 * p * p * inverse;
        add_scaled(&mut by_h, 1.0, &of_h);
        add_scaled(&mut by_h, -p, &unit);
    }
    Density {
        value,
        by: [by_h, by_z],
    }
}

fn add_scaled(sum: &mut Matrix3, factor: f64, other: &Matrix3) {
    let pairs = sum.as_flattened_mut().iter_mut().zip(other.as_flattened());
    pairs.for_each(|(sum, value)| *sum += factor * value);
}

fn double_dot(a: &Matrix3, b: &Matrix3) -> f64 {
    dot_flat(a.as_flattened(), b)
}

fn dot_flat(row: &[f64], b: &Matrix3) -> f64 {
    row.iter().zip(b.as_flattened()).map(|(a, b)| a * b).sum()
}
