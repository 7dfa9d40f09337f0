//! Estimate and bound of the discretisation error of a goal,
//!
//! ```text
//! eta_K = int_K (H* - H_h) : A : (Y* - Y_h)      J(u) - J(u_h) ~ sum of eta_K
//! b_K = sqrt(|A| (H* - H_h)^2 |A| (Y* - Y_h)^2)  |J(u) - J(u_h)| <~ sum of b_K
//! ```
//!
//! H the gradient of the displacement, Y that of the dual solution, both recovered by patches
//! ([`crate::assembly::recovery`]); A the tangent of the law in the middle of the cell under its
//! pressure, |A| the positive one with its eigenvectors. What the pressures' own errors add is left
//! out, as is the edge of the contact, where the error is of second order but wins on uniform meshes:
//! there the bound counts, not the estimate (R. Becker and R. Rannacher, Acta Numerica 10, 2001; A.
//! Schroeder and A. Rademacher, Comput. Methods Appl. Mech. Eng. 200, 2011). No guarantee.
//!
//! Non-dimensional. Cost: two recoveries, and of rubber an eigenvalue problem of nine a cell.

use super::dual::Dual;
use crate::assembly::recovery::{CellForm, Recovery, cell_products};
use crate::linalg::DenseMatrix;
use crate::linalg::eigen::symmetric;
use crate::linalg::vector::dot;
use crate::material::{Rubber, TangentMatrix};
use crate::model::Model;
use crate::model::state::State;
use crate::model::values::gradient_at;
use crate::report::GoalBound;
use crate::results::estimate::moduli;

/// Middle of a triangle and of a tetrahedron.
const MIDDLES: [[f64; 4]; 2] = [[1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0, 0.0], [0.25; 4]];

/// The error of one goal at a state, in the caller's units but for what the solver left.
pub(super) fn bound(model: &Model<'_>, state: &State, dual: &Dual) -> GoalBound {
    let laws = model.is_rubber().then(|| model.plan.laws_at_rest());
    let form = |cell: usize| match &laws {
        Some(laws) => of_rubber((model, state), cell, laws),
        None => of_linear(moduli(model, cell)),
    };
    let smooth = dual.goal.smooth(model, &dual.fields);
    let whole = model.prepared.geometry.cells();
    let none = vec![[0.0; 2]; whole];
    let recovery = |displacement| Recovery {
        mesh: model.mesh,
        scale: model.plan.problem.units.coordinate_scale,
        space: &model.prepared.space,
        geometry: &model.prepared.geometry,
        regions: &model.plan.problem.resolved.cell_material,
        moduli: &none,
        displacement,
    };
    let fields = [&state.displacement[..], &smooth].map(recovery);
    let products = cell_products([&fields[0], &fields[1]], &form);
    let unit = dual.goal.unit();
    let part = |[_, own, dual]: &[f64; 3]| (own.max(0.0) * dual.max(0.0)).sqrt() * unit;
    let cells: Vec<f64> = products.iter().map(part).collect();
    GoalBound {
        estimate: products.iter().map(|[signed, ..]| signed).sum::<f64>() * unit,
        discretisation: cells.iter().sum(),
        geometry: dual.goal.geometry(model, state),
        solver: 0.0,
        cells,
    }
}

/// 2 mu e : e + lambda tr e tr e of the symmetric part e.
fn of_linear([shear, lame]: [f64; 2]) -> CellForm {
    let mut signed = [[0.0; 9]; 9];
    for i in 0..3 {
        for j in 0..3 {
            signed[3 * i + j][3 * i + j] += shear;
            signed[3 * i + j][3 * j + i] += shear;
            signed[4 * i][4 * j] += lame;
        }
    }
    CellForm {
        positive: signed,
        signed,
    }
}

/// The tangent of the law of a cell under its pressure.
fn of_rubber((model, state): (&Model<'_>, &State), cell: usize, laws: &[Rubber]) -> CellForm {
    let corners = model.mesh.cell(cell);
    let middle = &MIDDLES[corners.len() - 3];
    let gradient = gradient_at(model, state, cell, middle);
    let own = corners.iter().zip(middle);
    let own = own.filter_map(|(&vertex, share)| Some(share * state.pressure.get(vertex as usize)?));
    let material = usize::from(model.plan.problem.resolved.cell_material[cell]);
    let signed = laws[material].tangent(&gradient, own.sum());
    CellForm {
        positive: positive(&signed),
        signed,
    }
}

/// The matrix with the absolute values of its eigenvalues; where these are not found its diagonal's,
/// by rows.
fn positive(matrix: &TangentMatrix) -> TangentMatrix {
    let mut dense = DenseMatrix::zeros(9, 9);
    for (i, row) in matrix.iter().enumerate() {
        for (j, value) in row.iter().enumerate() {
            *dense.at_mut(i, j) = *value;
        }
    }
    let mut sum = [[0.0; 9]; 9];
    let Some(vectors) = symmetric(&dense) else {
        for (i, row) in matrix.iter().enumerate() {
            sum[i][i] = row.iter().map(|value| value.abs()).sum();
        }
        return sum;
    };
    for vector in vectors {
        let mut image = vec![0.0; 9];
        dense.multiply(&vector, &mut image);
        let size = dot(&vector, &image).abs();
        for (i, row) in sum.iter_mut().enumerate() {
            for (j, value) in row.iter_mut().enumerate() {
                *value += size * vector[i] * vector[j];
            }
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_positive_form_bounds_the_tangent_in_both_signs() {
        let law = Rubber::neo_hookean(1.0, 0.0);
        let gradient = [[-0.3, 0.2, 0.0], [0.1, 0.4, 0.0], [0.0, 0.0, 0.05]];
        let signed = law.tangent(&gradient, 3.0);
        let positive = positive(&signed);
        for k in 0..9_usize {
            let x: [f64; 9] = std::array::from_fn(|i| ((3 * i + 5 * k) % 7) as f64 - 3.0);
            let along = |matrix: &TangentMatrix| -> f64 {
                let rows = matrix.iter().zip(&x);
                rows.map(|(row, own)| own * dot(row, &x)).sum()
            };
            assert!(along(&positive) >= along(&signed).abs() - 1e-12);
        }
    }
}
