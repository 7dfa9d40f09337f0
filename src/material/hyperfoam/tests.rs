use super::*;
use crate::geometry::tensor::volume_change;
use crate::geometry::{rotation_matrix, tensor};
use crate::material::{Rubber, blatz_ko};

const H: Tensor<f64> = [[0.3, -0.2, 0.3], [0.15, 0.2, -0.25], [-0.3, 0.1, -0.35]];

fn foam(terms: &[[f64; 3]]) -> Hyperfoam {
    let term = |&[modulus, exponent, nu]: &[f64; 3]| FoamTerm {
        modulus,
        exponent,
        beta: nu / (1.0 - 2.0 * nu),
    };
    Hyperfoam::new(terms.iter().map(term).collect())
}

/// No Poisson ratio, two terms, one below zero, one near 1/2, Blatz and Ko.
fn foams() -> [Hyperfoam; 5] {
    [
        foam(&[[1.0, 8.0, 0.0]]),
        foam(&[[0.7, 3.0, 0.2], [0.4, -2.5, 0.0]]),
        foam(&[[1.0, 2.0, -0.6]]),
        foam(&[[1.0, 2.0, 0.48]]),
        blatz_ko(1.3),
    ]
}

/// R2 diag(stretches) R1 - I.
fn stretched(stretches: [f64; 3]) -> Tensor<f64> {
    let mut first = rotation_matrix([0.3, -0.5, 0.8]);
    for (row, stretch) in first.iter_mut().zip(stretches) {
        row.iter_mut().for_each(|x| *x *= stretch);
    }
    let mut f = tensor::product(&rotation_matrix([-1.1, 0.4, 0.2]), &first);
    (0..3).for_each(|i| f[i][i] -= 1.0);
    f
}

/// Large, small, equal and nearly equal stretches.
fn states() -> Vec<Tensor<f64>> {
    vec![
        H,
        H.map(|row| row.map(|x| 1e-3 * x)),
        stretched([0.4, 1.0, 1.6]),
        stretched([0.5, 0.5, 0.5]),
        stretched([1.4, 1.4, 0.7]),
        stretched([1.0, 1.0, 1.0 + 1e-9]),
        stretched([1.7, 1.7 + 1e-7, 0.6]),
        [[0.0; 3]; 3],
    ]
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most: f64, x| most.max(x.abs()))
}

/// The fourth-order slope of `value` along entry `place` of `h`.
fn slope<const N: usize>(
    h: &Tensor<f64>,
    place: usize,
    value: impl Fn(&Tensor<f64>) -> [f64; N],
) -> [f64; N] {
    const STEP: f64 = 2e-4;
    let [far, near, back, least] = [2.0, 1.0, -1.0, -2.0].map(|steps: f64| {
        let mut moved = *h;
        moved[place / 3][place % 3] += steps * STEP;
        value(&moved)
    });
    std::array::from_fn(|n| (8.0 * (near[n] - back[n]) - (far[n] - least[n])) / (12.0 * STEP))
}

fn flat(tensor: &Tensor<f64>) -> [f64; 9] {
    std::array::from_fn(|n| tensor[n / 3][n % 3])
}

#[test]
fn stress_and_tangent_are_the_slopes_of_energy_and_stress() {
    for law in foams() {
        for h in states() {
            let (stress, tangent) = (flat(&law.stress(&h)), law.tangent(&h));
            let size = largest(tangent.as_flattened());
            for place in 0..9 {
                let [found] = slope(&h, place, |h| [law.energy(h)]);
                let error = (found - stress[place]).abs();
                assert!(error < 3e-8 * size, "{law:?} {h:?}: {found} {stress:?}");
                let found = slope(&h, place, |h| flat(&law.stress(h)));
                for (row, found) in found.into_iter().enumerate() {
                    let error = (found - tangent[row][place]).abs();
                    assert!(error < 1e-7 * size, "{law:?} {h:?}: {error} {size}");
                    let apart = (tangent[row][place] - tangent[place][row]).abs();
                    assert!(apart < 1e-13 * size, "{law:?} {h:?}: {apart}");
                }
            }
        }
    }
}

#[test]
fn at_rest_the_tangent_is_that_of_its_two_moduli() {
    for law in foams() {
        let (mu, bulk) = (law.shear_modulus(), law.bulk_modulus());
        let lame = bulk - law.carried() - 2.0 / 3.0 * mu;
        let tangent = law.tangent(&[[0.0; 3]; 3]);
        for row in 0..9 {
            for column in 0..9 {
                let [i, j, k, l] = [row / 3, row % 3, column / 3, column % 3];
                let same = |a: usize, b: usize| f64::from(u8::from(a == b));
                let exact = lame * same(i, j) * same(k, l)
                    + mu * (same(i, k) * same(j, l) + same(i, l) * same(j, k));
                let found = tangent[row][column];
                assert!(
                    (found - exact).abs() < 1e-14 * (mu + bulk),
                    "{found} {exact}"
                );
            }
        }
    }
}

#[test]
fn the_part_of_the_pressure_leaves_both_parts_stiff_at_rest() {
    for nu in [-0.9, -0.3, 0.0, 0.2, 0.45, 0.49, 0.4999] {
        let law = foam(&[[2.0, 5.0, nu]]);
        let (mu, bulk) = (law.shear_modulus(), law.bulk_modulus());
        let exact = 2.0 * mu * (1.0 + nu) / (3.0 - 6.0 * nu);
        assert!((bulk - exact).abs() < 1e-12 * exact, "{nu}");
        let left = bulk - law.carried();
        assert!(law.carried() > 0.0 && left > 0.0, "{nu}");
        assert!(law.carried() < 0.021 * mu, "{nu}");
    }
}

#[test]
fn with_its_pressure_the_law_is_that_of_the_foam_at_each_point() {
    for law in foams() {
        let rubber = Rubber::of_foam(law.clone());
        for h in states() {
            let pressure = -law.carried() * volume_change(&h);
            let logarithms = Stretches::new(&h).whole;
            let volume = logarithms.iter().sum::<f64>();
            let of_term = |term: &FoamTerm| {
                let power = |e: f64| (term.exponent * e).exp() - 1.0;
                let held = match term.beta {
                    0.0 => -term.exponent * volume,
                    beta => ((-term.exponent * beta * volume).exp() - 1.0) / beta,
                };
                let sum = logarithms.map(power).iter().sum::<f64>() + held;
                2.0 * term.modulus / term.exponent.powi(2) * sum
            };
            let exact: f64 = law.terms().iter().map(of_term).sum();
            let found = rubber.energy(&h, pressure);
            assert!(
                (found - exact).abs() < 1e-13 * (1.0 + exact),
                "{found} {exact}"
            );
            assert!(rubber.volume_defect(&h, pressure).abs() < 1e-14);
            // tr(P F^T) is the sum of the Kirchhoff stresses.
            let nominal = rubber.stress(&h, pressure);
            let found = tensor::contract(&nominal, &tensor::plus_unit(&h));
            let exact: f64 = law.kirchhoff(&logarithms).iter().sum();
            assert!(
                (found - exact).abs() < 1e-13 * (1.0 + exact.abs()),
                "{found} {exact}"
            );
        }
    }
}

#[test]
fn blatz_and_ko_have_their_energy_in_the_invariants() {
    let law = blatz_ko(1.3);
    let rubber = Rubber::of_foam(law.clone());
    let [a, b, c]: [f64; 3] = [1.3, 0.7, 1.1];
    let h = stretched([a, b, c]);
    let exact = 0.65 * (a.powi(-2) + b.powi(-2) + c.powi(-2) + 2.0 * a * b * c - 5.0);
    let found = rubber.energy(&h, -law.carried() * volume_change(&h));
    assert!((found - exact).abs() < 1e-14, "{found} {exact}");
}

#[test]
fn tiny_strains_keep_their_digits() {
    for law in foams() {
        let small = H.map(|row| row.map(|x| 1e-10 * x));
        let tangent = law.tangent(&[[0.0; 3]; 3]);
        let stress = flat(&law.stress(&small));
        let h = flat(&small);
        let size = largest(tangent.as_flattened());
        for (row, stress) in tangent.iter().zip(stress) {
            let exact: f64 = row.iter().zip(&h).map(|(c, x)| c * x).sum();
            assert!((stress - exact).abs() < 1e-18 * size, "{stress} {exact}");
        }
        let exact = 0.5 * stress.iter().zip(&h).map(|(s, x)| s * x).sum::<f64>();
        assert!((law.energy(&small) - exact).abs() < 1e-8 * exact);
    }
}
