//! Moduli of the cells, non-dimensional, with the grad-div penalty of a plan, and what the
//! approximate inverse holds beside.

use crate::assembly::CellModuli;
use crate::plan::Plan;

/// Non-dimensional moduli of each cell.
pub(crate) fn moduli(plan: &Plan) -> CellModuli {
    let mut moduli = CellModuli::default();
    for &index in &plan.problem.resolved.cell_material {
        let law = plan.problem.resolved.materials[usize::from(index)].law;
        let stress = plan.problem.units.stress;
        let (lame, inverse) = if plan.is_mixed() {
            // The penalty is a grad-div term of the displacement block.
            let penalty = plan.penalty() * law.shear_modulus;
            (
                (penalty + law.direct_lame) / stress,
                law.inverse_lame * stress,
            )
        } else {
            (law.lame() / stress, 0.0)
        };
        let shear = law.shear_modulus / plan.problem.units.stress;
        moduli.shear.push(shear);
        moduli.lame.push(lame);
        moduli.augmented.push(lame + plan.augmentation() * shear);
        moduli.inverse_lame.push(inverse);
    }
    moduli
}
