use super::*;
use crate::geometry::rotation_matrix;
use crate::geometry::tensor::{contract, plus_unit, product, volume_change};
use crate::material::{Deformation, InvariantLaw};

const H: Tensor<f64> = [[0.3, -0.2, 0.3], [0.15, 0.2, -0.25], [-0.3, 0.1, -0.35]];

fn law(terms: &[(f64, f64)]) -> Ogden {
    let terms = terms
        .iter()
        .map(|&(modulus, exponent)| OgdenTerm { modulus, exponent });
    Ogden {
        terms: terms.collect(),
    }
}

/// Treloar's rubber in the fit of Ogden (1972), with mu over 0.1 MPa.
fn treloar() -> Ogden {
    law(&[(6.3, 1.3), (0.012, 5.0), (-0.1, -2.0)])
}

fn less_unit(f: &Tensor<f64>) -> Tensor<f64> {
    let mut h = *f;
    (0..3).for_each(|i| h[i][i] -= 1.0);
    h
}

/// R2 diag(stretches) R1 - I.
fn stretched(stretches: [f64; 3]) -> Tensor<f64> {
    let mut first = rotation_matrix([0.3, -0.5, 0.8]);
    for (row, stretch) in first.iter_mut().zip(stretches) {
        row.iter_mut().for_each(|x| *x *= stretch);
    }
    less_unit(&product(&rotation_matrix([-1.1, 0.4, 0.2]), &first))
}

/// Random, extreme, equal and nearly equal stretches.
fn states() -> Vec<Tensor<f64>> {
    vec![
        H,
        H.map(|row| row.map(|x| 1e-3 * x)),
        stretched([0.2, 1.0, 5.0]),
        stretched([5.0, 5.0, 0.2]),
        stretched([0.2, 0.2, 0.2]),
        stretched([3.0, 1.0 / 3.0, 1.2]),
        stretched([1.3, 1.3, 1.3]),
        stretched([1.0, 1.0, 1.0 + 1e-9]),
        stretched([1.7, 1.7 + 1e-7, 0.4]),
        [[0.0; 3]; 3],
    ]
}

fn invariants(h: &Tensor<f64>, c10: f64, c01: f64) -> (f64, Tensor<f64>, TangentMatrix) {
    let (c20, c30) = (0.0, 0.0);
    let law = InvariantLaw { c10, c01, c20, c30 };
    let at = Deformation::new(*h, (1.0 + volume_change(h)).cbrt().recip());
    let tangent = std::array::from_fn(|place| {
        let mut change = [[0.0; 3]; 3];
        change[place / 3][place % 3] = 1.0;
        let column = law.tangent(&at, 0.0, &change).0;
        std::array::from_fn(|row| column[row / 3][row % 3])
    });
    (law.energy(&at), law.stress(&at), tangent)
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most: f64, x| most.max(x.abs()))
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    let pairs = a.iter().zip(b);
    pairs.fold(0.0, |most: f64, (x, y)| most.max((x - y).abs()))
}

#[test]
fn the_stress_is_the_slope_of_the_energy() {
    let law = treloar();
    for h in states() {
        let stress = law.stress(&h);
        let size = 1.0 + largest(stress.as_flattened());
        for i in 0..3 {
            for j in 0..3 {
                let energy = |length: f64| {
                    let mut moved = h;
                    moved[i][j] += length;
                    law.energy(&moved)
                };
                // Fourth order, so that steep energies are met too.
                let step = 2e-4;
                let slope = (8.0 * (energy(step) - energy(-step))
                    - (energy(2.0 * step) - energy(-2.0 * step)))
                    / (12.0 * step);
                let found = stress[i][j];
                assert!((slope - found).abs() < 1e-8 * size, "{slope} {found} {h:?}");
            }
        }
    }
}

#[test]
fn the_tangent_is_the_slope_of_the_stress_and_symmetric() {
    let law = treloar();
    for h in states() {
        let tangent = law.tangent(&h);
        let size = largest(tangent.as_flattened());
        for place in 0..9 {
            let stress = |length: f64| {
                let mut moved = h;
                moved[place / 3][place % 3] += length;
                law.stress(&moved)
            };
            let step = 2e-4;
            let [far, near, back, least] = [2.0 * step, step, -step, -2.0 * step].map(stress);
            for row in 0..9 {
                let at = |p: &Tensor<f64>| p[row / 3][row % 3];
                let slope =
                    (8.0 * (at(&near) - at(&back)) - (at(&far) - at(&least))) / (12.0 * step);
                let found = tangent[row][place];
                assert!((slope - found).abs() < 1e-8 * size, "{slope} {found} {h:?}");
                assert!((found - tangent[place][row]).abs() < 1e-13 * size);
            }
        }
    }
}

#[test]
fn exponents_two_and_minus_two_are_the_laws_of_mooney_and_rivlin() {
    for h in states() {
        for (terms, c10, c01) in [
            (vec![(0.8, 2.0)], 0.4, 0.0),
            (vec![(0.8, 2.0), (-0.2, -2.0)], 0.4, 0.1),
        ] {
            let law = law(&terms);
            let (energy, stress, tangent) = invariants(&h, c10, c01);
            let size = largest(tangent.as_flattened());
            assert!((law.energy(&h) - energy).abs() < 1e-13 * (1.0 + energy));
            let apart = distance(law.stress(&h).as_flattened(), stress.as_flattened());
            assert!(apart < 1e-13 * size, "{apart} {h:?}");
            let apart = distance(law.tangent(&h).as_flattened(), tangent.as_flattened());
            assert!(apart < 1e-13 * size, "{apart} {h:?}");
            assert!((law.shear_modulus() - 2.0 * (c10 + c01)).abs() < 1e-15);
        }
    }
}

#[test]
fn a_rotated_body_has_the_same_energy_and_a_rotated_stress() {
    let law = treloar();
    for turns in [0.1, 1.7, 20.0 * std::f64::consts::PI + 0.3] {
        let rotation = rotation_matrix([0.6 * turns, -0.64 * turns, 0.48 * turns]);
        for h in states() {
            let turned = less_unit(&product(&rotation, &plus_unit(&h)));
            let energy = law.energy(&h);
            assert!((law.energy(&turned) - energy).abs() < 1e-13 * (1.0 + energy));
            let expected = product(&rotation, &law.stress(&h));
            let size = 1.0 + largest(law.tangent(&h).as_flattened());
            let apart = distance(law.stress(&turned).as_flattened(), expected.as_flattened());
            assert!(apart < 1e-13 * size, "{apart} {h:?}");
        }
    }
}

#[test]
fn a_change_of_volume_alone_costs_nothing() {
    let law = treloar();
    for factor in [0.2, 1.0 + 1e-12, 5.0] {
        let h = stretched([factor; 3]);
        assert!(law.energy(&h).abs() < 1e-28);
        assert!(largest(law.stress(&h).as_flattened()) < 1e-14 / factor);
    }
}

#[test]
fn tiny_strains_keep_their_digits() {
    let law = treloar();
    let modulus = law.shear_modulus();
    let small = H.map(|row| row.map(|x| 1e-10 * x));
    let stress = law.stress(&small);
    let third = (H[0][0] + H[1][1] + H[2][2]) / 3.0;
    let strain: Tensor<f64> = std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            1e-10 * (0.5 * (H[i][j] + H[j][i]) - if i == j { third } else { 0.0 })
        })
    });
    for i in 0..3 {
        for j in 0..3 {
            let exact = 2.0 * modulus * strain[i][j];
            assert!((stress[i][j] - exact).abs() < 1e-19 * modulus);
        }
    }
    let exact = modulus * contract(&strain, &strain);
    assert!((law.energy(&small) - exact).abs() < 1e-9 * exact);
}
