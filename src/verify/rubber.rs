//! Rubber as textbooks write it, from F and J themselves:
//!
//! ```text
//! P = 2 W1 J^(-2/3) (F - I1/3 F^-T) + 2 W2 J^(-4/3) (I1 F - F C - 2 I2/3 F^-T) - p J F^-T
//! P = sum_k tau_k n_k n_k^T F^-T - p J F^-T,   tau_k = sum_i mu_i (m_k^alpha_i - mean over k)
//! ```
//!
//! of foams tau_k = sum_i 2 mu_i / alpha_i (l_k^alpha_i - J^(-alpha_i beta_i)) - k (J - 1) J,
//! (Holzapfel, Nonlinear Solid Mechanics, 6.4-6.5), n_k and m_k from b = F F^T. Where
//! F is near I it loses digits that the solver keeps: in stress, a unit in the last
//! place of the modulus.

use crate::geometry::symmetric::Spectrum;
use crate::geometry::tensor::{Tensor, contract, plus, product, scaled, trace, transposed};
use crate::geometry::vector3::{cross, dot};
use crate::material::{
    FoamTerm, Hyperfoam, InvariantLaw, Isochoric, Ogden, POWERS, Potential, Rubber, Sheet,
};

/// Share of Gent's limit from which on the law goes on along its tangent.
const GENT_LAST: f64 = 0.999;
/// The same of the limit of the van der Waals network.
const VAN_DER_WAALS_LAST: f64 = 0.999;

/// A deformation gradient with what the formulas name.
pub(crate) struct Deformed {
    f: Tensor<f64>,
    /// J F^-T.
    pub(crate) cofactor: Tensor<f64>,
    jacobian: f64,
    /// J - 1.
    dilation: f64,
}

impl Deformed {
    /// At displacement gradient `h`.
    pub(crate) fn new(h: &Tensor<f64>) -> Self {
        let mut f = *h;
        (0..3).for_each(|i| f[i][i] += 1.0);
        let cofactor = [cross(f[1], f[2]), cross(f[2], f[0]), cross(f[0], f[1])];
        let squared = trace(&product(h, h));
        let determinant = dot(h[0], cross(h[1], h[2]));
        Self {
            f,
            cofactor,
            jacobian: dot(f[0], cofactor[0]),
            dilation: trace(h) + 0.5 * (trace(h) * trace(h) - squared) + determinant,
        }
    }

    /// J - 1 + p / K.
    pub(crate) fn volume_defect(&self, rubber: &Rubber, pressure: f64) -> f64 {
        self.dilation + pressure * rubber.inverse_bulk
    }

    /// P.
    pub(crate) fn stress(&self, rubber: &Rubber, pressure: f64) -> Tensor<f64> {
        let isochoric = match &rubber.isochoric {
            Isochoric::Invariants(law) => self.of_invariants(law),
            Isochoric::Ogden(law) => self.of_stretches(law),
            Isochoric::Potential(law) => self.of_slopes(|first, second| slopes(law, first, second)),
            Isochoric::Hyperfoam(law) => self.of_foam(law),
            Isochoric::Sheet(law) => self.of_a_sheet(law),
        };
        plus(&isochoric, -pressure, &self.cofactor)
    }

    /// P of the body as thick as P33 = 0 makes it, less k (det F - 1) d det F / dF.
    fn of_a_sheet(&self, sheet: &Sheet<Isochoric>) -> Tensor<f64> {
        let body = &Rubber {
            isochoric: sheet.body().clone(),
            inverse_bulk: sheet.inverse_bulk(),
        };
        let area = self.cofactor[2][2];
        let at = |thickness: f64| {
            let mut h = self.f;
            (0..2).for_each(|i| h[i][i] -= 1.0);
            h[2][2] = thickness - 1.0;
            Self::new(&h)
        };
        let across = |thickness: f64, pressure: f64| at(thickness).stress(body, pressure)[2][2];
        let (thickness, pressure) = if body.inverse_bulk == 0.0 {
            let thickness = 1.0 / area;
            (thickness, across(thickness, 0.0) / area)
        } else {
            // P33 grows with the thickness.
            let pressure = |thickness: f64| (1.0 - area * thickness) / body.inverse_bulk;
            let (mut least, mut most) = (1e-3, 1e3);
            for _ in 0..200 {
                let middle = 0.5 * (least + most);
                if across(middle, pressure(middle)) < 0.0 {
                    least = middle;
                } else {
                    most = middle;
                }
            }
            (least, pressure(least))
        };
        let stress = at(thickness).stress(body, pressure);
        let carried = sheet.carried() * (area - 1.0);
        let mut stress = plus(&stress, -carried, &self.cofactor);
        (0..3).for_each(|i| (stress[i][2], stress[2][i]) = (0.0, 0.0));
        stress
    }

    fn inverse_transposed(&self) -> Tensor<f64> {
        scaled(1.0 / self.jacobian, &self.cofactor)
    }

    fn of_invariants(&self, law: &InvariantLaw<f64>) -> Tensor<f64> {
        self.of_slopes(|first, _| {
            let excess = first - 3.0;
            let slope = law.c10 + 2.0 * law.c20 * excess + 3.0 * law.c30 * excess * excess;
            [slope, law.c01]
        })
    }

    /// The stress where `slopes` gives W1 and W2 at i1 and i2.
    fn of_slopes(&self, slopes: impl Fn(f64, f64) -> [f64; 2]) -> Tensor<f64> {
        let third = self.jacobian.powf(-2.0 / 3.0);
        let inverse = self.inverse_transposed();
        let stretch = product(&transposed(&self.f), &self.f);
        let first = trace(&stretch);
        let second = 0.5 * (first * first - contract(&stretch, &stretch));
        let [by_first, by_second] = slopes(third * first, third * third * second);
        let direction = plus(&self.f, -first / 3.0, &inverse);
        let stress = scaled(2.0 * by_first * third, &direction);
        let turned = scaled(first, &self.f);
        let turned = plus(&turned, -1.0, &product(&self.f, &stretch));
        let turned = plus(&turned, -2.0 * second / 3.0, &inverse);
        plus(&stress, 2.0 * by_second * third * third, &turned)
    }

    fn of_foam(&self, law: &Hyperfoam) -> Tensor<f64> {
        let spectrum = Spectrum::new(&product(&self.f, &transposed(&self.f)));
        let carried = law.carried() * self.dilation * self.jacobian;
        let mut stress = [[0.0; 3]; 3];
        for (k, square) in spectrum.values.iter().enumerate() {
            let of_term = |term: &FoamTerm| {
                let held = self.jacobian.powf(-term.exponent * term.beta);
                let grown = square.powf(0.5 * term.exponent);
                2.0 * term.modulus / term.exponent * (grown - held)
            };
            let whole: f64 = law.terms().iter().map(of_term).sum();
            let n = spectrum.direction(k);
            let dyad = n.map(|a| n.map(|b| a * b));
            stress = plus(&stress, whole - carried, &dyad);
        }
        product(&stress, &self.inverse_transposed())
    }

    fn of_stretches(&self, law: &Ogden) -> Tensor<f64> {
        let spectrum = Spectrum::new(&product(&self.f, &transposed(&self.f)));
        let scale = self.jacobian.powf(-1.0 / 3.0);
        let stretches = spectrum.values.map(|square| scale * square.sqrt());
        let mut stress = [[0.0; 3]; 3];
        for term in &law.terms {
            let powers = stretches.map(|stretch| stretch.powf(term.exponent));
            let mean = (powers[0] + powers[1] + powers[2]) / 3.0;
            for (k, power) in powers.iter().enumerate() {
                let n = spectrum.direction(k);
                let dyad = n.map(|a| n.map(|b| a * b));
                stress = plus(&stress, term.modulus * (power - mean), &dyad);
            }
        }
        product(&stress, &self.inverse_transposed())
    }
}

/// W1 and W2 at the invariants, as the laws' papers write them.
fn slopes(law: &Potential, first: f64, second: f64) -> [f64; 2] {
    match law {
        Potential::Polynomial(law) => {
            let (x, y) = (first - 3.0, second - 3.0);
            let terms = law.coefficients.iter().zip(POWERS);
            terms.fold([0.0; 2], |[one, two], (c, (i, j))| {
                let slope =
                    |n: i32, x: f64| f64::from(n) * if n == 0 { 0.0 } else { x.powi(n - 1) };
                [
                    one + c * slope(i, x) * y.powi(j),
                    two + c * x.powi(i) * slope(j, y),
                ]
            })
        }
        Potential::Gent(law) => {
            let within = (first - 3.0).min(GENT_LAST * law.limit);
            let left = 1.0 - within / law.limit;
            let beyond = (first - 3.0 - within) / (law.limit * left);
            [0.5 * law.shear_modulus / left * (1.0 + beyond), 0.0]
        }
        Potential::ArrudaBoyce(law) => {
            let chain = [
                0.5,
                1.0 / 20.0,
                11.0 / 1050.0,
                19.0 / 7000.0,
                519.0 / 673_750.0,
            ];
            let square = law.locking_stretch * law.locking_stretch;
            let terms = (1..).zip(chain);
            let slope = terms.map(|(i, a)| f64::from(i) * a * (first / square).powi(i - 1));
            [law.modulus * slope.sum::<f64>(), 0.0]
        }
        Potential::VanDerWaals(law) => {
            let limit = law.locking_stretch * law.locking_stretch - 3.0;
            let share = law.second_share;
            let x = ((1.0 - share) * first + share * second - 3.0).max(0.0);
            let within = x.min(VAN_DER_WAALS_LAST * limit);
            let eta = (within / limit).sqrt();
            let mut slope = 1.0 / (1.0 - eta) - law.interaction * (0.5 * within).sqrt();
            if x > within {
                let chains = 1.0 / ((1.0 - eta).powi(2) * 2.0 * (limit * within).sqrt());
                slope += (x - within) * (chains - 0.5 * law.interaction / (2.0 * within).sqrt());
            }
            let slope = 0.5 * law.shear_modulus * slope;
            [(1.0 - share) * slope, share * slope]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::{OgdenTerm, blatz_ko};

    const H: Tensor<f64> = [[0.3, -0.2, 0.3], [0.15, 0.2, -0.25], [-0.3, 0.1, -0.35]];

    fn foams() -> [Hyperfoam; 2] {
        let terms = [(0.7, 2.6, 0.3), (0.2, -1.3, 0.0)];
        let terms = terms.map(|(modulus, exponent, beta)| FoamTerm {
            modulus,
            exponent,
            beta,
        });
        [Hyperfoam::new(terms.to_vec()), blatz_ko(0.8)]
    }

    fn rubbers() -> Vec<Rubber> {
        let (c10, c01, c20, c30) = (0.4, 0.1, 0.05, 0.02);
        let terms = [(0.7, 2.6), (-0.2, -1.3)];
        let terms = terms.map(|(modulus, exponent)| OgdenTerm { modulus, exponent });
        [
            Isochoric::Invariants(InvariantLaw { c10, c01, c20, c30 }),
            Isochoric::Ogden(Ogden {
                terms: terms.to_vec(),
            }),
        ]
        .into_iter()
        .chain(crate::material::examples().map(Isochoric::Potential))
        .map(|isochoric| Rubber {
            isochoric,
            inverse_bulk: 0.1,
        })
        .chain(foams().map(Rubber::of_foam))
        .collect()
    }

    #[test]
    fn the_textbook_and_the_solver_write_the_same_law() {
        for rubber in rubbers() {
            for h in [H, scaled(-0.9, &H), scaled(1e-6, &H)] {
                let deformed = Deformed::new(&h);
                let (stress, expected) = (deformed.stress(&rubber, 0.3), rubber.stress(&h, 0.3));
                let pairs = stress.as_flattened().iter().zip(expected.as_flattened());
                for (found, expected) in pairs {
                    assert!((found - expected).abs() < 3e-15, "{found} {expected}");
                }
                let defect = deformed.volume_defect(&rubber, 0.3);
                assert!((defect + rubber.volume_defect(&h, 0.3)).abs() < 1e-16);
            }
        }
    }

    #[test]
    fn uniaxial_tension_has_the_nominal_stress_of_rivlin() {
        // 2 (C1 + C2 / l) (l - l^-2) at l = 2, free of stress across.
        let rubber = Rubber {
            isochoric: Isochoric::Invariants(InvariantLaw {
                c10: 0.4,
                c01: 0.1,
                c20: 0.0,
                c30: 0.0,
            }),
            inverse_bulk: 0.0,
        };
        let side = 0.5_f64.sqrt() - 1.0;
        let h = [[1.0, 0.0, 0.0], [0.0, side, 0.0], [0.0, 0.0, side]];
        let deformed = Deformed::new(&h);
        let without = deformed.stress(&rubber, 0.0);
        let pressure = without[1][1] / deformed.cofactor[1][1];
        let stress = deformed.stress(&rubber, pressure);
        assert!((stress[0][0] - 1.575).abs() < 1e-14);
        assert!(stress[1][1].abs() < 1e-14 && stress[2][2].abs() < 1e-14);
    }
}
