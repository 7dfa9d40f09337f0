//! Products in single precision against those in double.

use super::*;
use crate::assembly::SingleStiffness;
use crate::assembly::grid::SingleGrid;
use crate::linalg::ResidualUpdate;

#[test]
fn a_product_in_single_precision_is_the_one_in_double_rounded() {
    for sample in samples() {
        let x = reproducible_noise(sample.unknowns());
        let narrow: Vec<f32> = x.iter().map(|&x| x as f32).collect();
        for basis in [Basis::Hierarchical, Basis::Lagrange] {
            let on = (basis, Rows::Free, VolumeTerm::Augmented);
            let mut expected = sample.product(on, &x);
            for &index in &sample.held {
                expected[index as usize] = x[index as usize];
            }
            for set in InstructionSet::ALL.into_iter().filter(|set| set.is_here()) {
                let grid = sample.grid.clone().with_instruction_set(set);
                let operator = SingleStiffness {
                    grid: SingleGrid::new(&grid),
                    basis,
                    held: sample.held(),
                };
                let mut r = vec![1.0_f32; x.len()];
                operator.update_residual(&narrow, &mut r, &mut Workspace::new());
                let scale = largest(&expected);
                for (r, expected) in r.iter().zip(&expected) {
                    let found = 1.0 - f64::from(*r);
                    assert!((found - expected).abs() < 2e-6 * scale, "{}", set.name());
                }
            }
        }
    }
}
