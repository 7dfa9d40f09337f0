//! The form by which errors of a displacement and its pressure count in a cell:
//!
//! ```text
//! S = [ A         -cof F ]        A = d P/dF of the law without its pressure
//!     [ -cof F^T  -1/K   ]        linear: 2 mu e : e + lambda tr e tr e, cof F = 1
//! ```
//!
//! The pressure's own part of the tangent, -p d(cof F)/dF, is left out: of the gradients of motions
//! that change no volume it is a divergence, which the pressures of what presses and the curvature
//! of gaps take up, but of recovered gradients, which belong to no motion, it is p times their
//! square. Under p of many shear moduli, as in bonded layers, that would be all of the sum.
//!
//! Non-dimensional. Cost: one tangent a cell of rubber, one form a material else.

use crate::assembly::recovery::{FormMatrix, NUMBERS};
use crate::geometry::Matrix3;
use crate::material::Rubber;
use crate::model::Model;
use crate::model::state::State;
use crate::model::values::gradient_at;

/// Middle of a triangle and of a tetrahedron.
const MIDDLES: [[f64; 4]; 2] = [[1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0, 0.0], [0.25; 4]];
/// Place of the pressure.
const PRESSURE: usize = NUMBERS - 1;

/// The forms of a body at a state.
pub(super) struct Forms<'m> {
    model: &'m Model<'m>,
    state: &'m State,
    /// Of each material: rubber at rest; empty for linear bodies.
    laws: Vec<Rubber>,
    /// Of each material of a linear body.
    linear: Vec<FormMatrix>,
}

impl<'m> Forms<'m> {
    pub(super) fn new(model: &'m Model<'m>, state: &'m State) -> Self {
        let is_rubber = model.is_rubber();
        let count = model.plan.problem.resolved.materials.len();
        let linear = |material| of_linear(&linear(model, material));
        Self {
            model,
            state,
            laws: if is_rubber {
                model.plan.laws_at_rest()
            } else {
                Vec::new()
            },
            linear: (0..count).filter(|_| !is_rubber).map(linear).collect(),
        }
    }

    /// The form of a cell.
    pub(super) fn of(&self, cell: usize) -> FormMatrix {
        let material = usize::from(self.model.plan.problem.resolved.cell_material[cell]);
        match self.laws.get(material) {
            Some(law) => {
                let corners = self.model.mesh.cell(cell).len();
                let middle = &MIDDLES[corners - 3];
                of_rubber(law, &gradient_at(self.model, self.state, cell, middle))
            }
            None => self.linear[material],
        }
    }
}

/// Constants of a linear body.
#[derive(Clone, Copy, Debug)]
pub(super) struct Linear {
    pub(super) shear: f64,
    /// What displacements carry of lambda.
    pub(super) lame: f64,
    /// 1 / lambda of the pressure; none without pressures.
    pub(super) inverse: Option<f64>,
}

/// Those of a material.
pub(super) fn linear(model: &Model<'_>, material: usize) -> Linear {
    let law = model.plan.problem.resolved.materials[material].law;
    let stress = model.plan.problem.units.stress;
    let is_mixed = model.plan.is_mixed();
    Linear {
        shear: law.shear_modulus / stress,
        lame: if is_mixed {
            law.direct_lame
        } else {
            law.lame()
        } / stress,
        inverse: is_mixed.then_some(law.inverse_lame * stress),
    }
}

fn of_linear(own: &Linear) -> FormMatrix {
    let mut signed = [[0.0; NUMBERS]; NUMBERS];
    for i in 0..3 {
        for j in 0..3 {
            signed[3 * i + j][3 * i + j] += own.shear;
            signed[3 * i + j][3 * j + i] += own.shear;
            signed[4 * i][4 * j] += own.lame;
        }
    }
    if let Some(inverse) = own.inverse {
        let cofactor =
            std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
        add_pressure(&mut signed, &cofactor, inverse);
    }
    signed
}

/// The form of a law at a gradient of the displacement.
fn of_rubber(law: &Rubber, gradient: &Matrix3) -> FormMatrix {
    let mut signed = [[0.0; NUMBERS]; NUMBERS];
    for (row, own) in signed.iter_mut().zip(law.tangent(gradient, 0.0)) {
        row[..PRESSURE].copy_from_slice(&own);
    }
    // Stress and volume are linear in the pressure.
    let [none, one] = [0.0, 1.0].map(|p| (law.stress(gradient, p), law.volume_defect(gradient, p)));
    let cofactor = std::array::from_fn(|i| std::array::from_fn(|j| none.0[i][j] - one.0[i][j]));
    add_pressure(&mut signed, &cofactor, none.1 - one.1);
    signed
}

fn add_pressure(signed: &mut FormMatrix, cofactor: &Matrix3, inverse: f64) {
    for (place, value) in cofactor.as_flattened().iter().enumerate() {
        signed[place][PRESSURE] -= value;
        signed[PRESSURE][place] -= value;
    }
    signed[PRESSURE][PRESSURE] -= inverse;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rubber_at_rest_has_the_form_of_a_linear_body() {
        let found = of_rubber(&Rubber::neo_hookean(0.7, 0.2), &[[0.0; 3]; 3]);
        // 2 mu of the deviator of e.
        let linear = Linear {
            shear: 0.7,
            lame: -2.0 * 0.7 / 3.0,
            inverse: Some(0.2),
        };
        for (found, exact) in found
            .iter()
            .flatten()
            .zip(of_linear(&linear).iter().flatten())
        {
            assert!((found - exact).abs() < 1e-12, "{found} {exact}");
        }
    }
}
