//! A sheet of rubber that nothing holds across its plane, as a law of the plane alone:
//!
//! ```text
//! W_s(F) = min over F33 of W(F, F33) + K/2 (J - 1)^2,   F33 = 1 / det F where K is infinite
//! P_s = dW/dF - p cof F,   p such that P33 = 0
//! ```
//!
//! (Holzapfel, Nonlinear Solid Mechanics, 6.2; Klinkel and Govindjee, Eng. Comput. 19, 2002.) F is
//! the gradient in the plane, J = F33 det F; energy, force and stress P are per undeformed thickness.
//!
//! The mixed form has a pressure q with its -q (det F - 1) - q^2 / 2k beside each law. So that the
//! two together are W_s at each point, displacements carry W_s - k/2 (det F - 1)^2: a sheet resists
//! a change of its area by some 2 mu, so that k is small. Cost: a law by point; with a finite K some
//! four stresses and tangents more.

use sha2::{Digest, Sha256};

use super::TangentMatrix;
use super::linear_elastic::CARRIED_BY_PRESSURE;
use super::mixed::subtract_pressure;
use crate::geometry::tensor::{Tensor, cofactor, plus, plus_unit, volume_change};

/// Newton steps for the stretch across, at most: stretches of 0.1 to 10 in the plane and bulk moduli
/// of 0.05 mu and more take 41.
const STEPS: usize = 60;
/// Change of its logarithm, without unit, that is rounding.
const ROUNDING: f64 = 1e-15;
/// Places 3 i + j of the components in the plane.
const IN_PLANE: [usize; 4] = [0, 1, 3, 4];
/// That of the one across it.
const ACROSS: usize = 8;

/// W of a body, the part that its pressure does not carry.
pub trait BodyLaw {
    /// W.
    fn energy(&self, h: &Tensor<f64>) -> f64;
    /// dW/dF.
    fn stress(&self, h: &Tensor<f64>) -> Tensor<f64>;
    /// d2W/dF2.
    fn tangent(&self, h: &Tensor<f64>) -> TangentMatrix;
    /// Shear modulus at rest, stress.
    fn shear_modulus(&self) -> f64;
    /// The law in units of `stress`.
    #[must_use]
    fn over(&self, stress: f64) -> Self;
    /// Adds the law to a digest that tells laws apart.
    fn hash_into(&self, hash: &mut Sha256);
}

/// The law.
#[derive(Clone, Debug, PartialEq)]
pub struct Sheet<B> {
    /// W of the body.
    body: B,
    /// 1 / K, one over stress; zero where the volume cannot change.
    inverse_bulk: f64,
    /// k, stress.
    carried: f64,
}

/// The body where nothing acts across the sheet.
struct Free {
    /// Displacement gradient with that across.
    h: Tensor<f64>,
    /// p.
    pressure: f64,
    /// cof F.
    cofactor: Tensor<f64>,
}

/// det F - 1.
fn area_change(h: &Tensor<f64>) -> f64 {
    h[0][0] + h[1][1] + h[0][0] * h[1][1] - h[0][1] * h[1][0]
}

/// d det F / dF.
fn slopes_of_area(h: &Tensor<f64>) -> Tensor<f64> {
    [
        [1.0 + h[1][1], -h[1][0], 0.0],
        [-h[0][1], 1.0 + h[0][0], 0.0],
        [0.0; 3],
    ]
}

/// d2 det F / dF2 of two components in the plane.
fn curvature_of_area(row: usize, column: usize) -> f64 {
    match (row, column) {
        (0, 4) | (4, 0) => 1.0,
        (1, 3) | (3, 1) => -1.0,
        _ => 0.0,
    }
}

/// A component by its place.
fn at(tensor: &Tensor<f64>, place: usize) -> f64 {
    tensor[place / 3][place % 3]
}

impl<B: BodyLaw> Sheet<B> {
    /// Of a body of that W, with 1 / K.
    pub fn new(body: B, inverse_bulk: f64) -> Self {
        Self {
            carried: CARRIED_BY_PRESSURE * body.shear_modulus(),
            body,
            inverse_bulk,
        }
    }

    /// W of the body.
    pub fn body(&self) -> &B {
        &self.body
    }

    /// 1 / K of the body, one over stress.
    pub fn inverse_bulk(&self) -> f64 {
        self.inverse_bulk
    }

    /// k, stress: what the pressure of the mixed form carries.
    pub fn carried(&self) -> f64 {
        self.carried
    }

    /// The law in units of `stress`.
    pub fn over(&self, stress: f64) -> Self {
        Self {
            body: self.body.over(stress),
            inverse_bulk: self.inverse_bulk * stress,
            carried: self.carried / stress,
        }
    }

    /// Adds the law to a digest that tells laws apart.
    pub(super) fn hash_into(&self, hash: &mut Sha256) {
        hash.update(b"sheet");
        hash.update(self.inverse_bulk.to_le_bytes());
        self.body.hash_into(hash);
    }

    /// J - 1 of the body.
    pub fn volume_change(&self, h: &Tensor<f64>) -> f64 {
        volume_change(&self.with_thickness(h))
    }

    /// K; none where the volume cannot change.
    fn bulk_modulus(&self) -> Option<f64> {
        (self.inverse_bulk > 0.0).then(|| self.inverse_bulk.recip())
    }

    /// `h` with the displacement gradient across at which P33 is zero.
    fn with_thickness(&self, h: &Tensor<f64>) -> Tensor<f64> {
        let area = area_change(h);
        let mut whole = *h;
        whole[2][2] = -area / (1.0 + area);
        let Some(bulk) = self.bulk_modulus() else {
            return whole;
        };
        for _ in 0..STEPS {
            let (thickness, pushed) = (1.0 + whole[2][2], bulk * (1.0 + area));
            let stress = self.body.stress(&whole)[2][2] + pushed * volume_change(&whole);
            let slope = self.body.tangent(&whole)[ACROSS][ACROSS] + pushed * (1.0 + area);
            // For the logarithm of the stretch, in which stable laws are convex.
            let step = -stress / (stress + thickness * slope);
            whole[2][2] += thickness * step.exp_m1();
            if step.abs() <= ROUNDING {
                break;
            }
        }
        whole
    }

    fn free(&self, h: &Tensor<f64>) -> Free {
        let h = self.with_thickness(h);
        let cofactor = cofactor(&plus_unit(&h));
        Free {
            pressure: self.body.stress(&h)[2][2] / cofactor[2][2],
            cofactor,
            h,
        }
    }

    /// W_s - k/2 (det F - 1)^2.
    pub fn energy(&self, h: &Tensor<f64>) -> f64 {
        let whole = self.with_thickness(h);
        let volume = self.bulk_modulus().map_or(0.0, |bulk| {
            let change = volume_change(&whole);
            0.5 * bulk * change * change
        });
        let area = area_change(h);
        self.body.energy(&whole) + volume - 0.5 * self.carried * area * area
    }

    /// Its first derivative; zero across the plane.
    pub fn stress(&self, h: &Tensor<f64>) -> Tensor<f64> {
        let free = self.free(h);
        let whole = plus(&self.body.stress(&free.h), -free.pressure, &free.cofactor);
        let (carried, slopes) = (self.carried * area_change(h), slopes_of_area(h));
        let mut stress = [[0.0; 3]; 3];
        for place in IN_PLANE {
            stress[place / 3][place % 3] = at(&whole, place) - carried * at(&slopes, place);
        }
        stress
    }

    /// Its second derivative; zero across the plane.
    pub fn tangent(&self, h: &Tensor<f64>) -> TangentMatrix {
        let free = self.free(h);
        let whole = self.tangent_of_body(&free);
        let across = self.change_across(&free, &whole);
        let (area, slopes) = (area_change(h), slopes_of_area(h));
        let mut tangent = [[0.0; 9]; 9];
        for row in IN_PLANE {
            for column in IN_PLANE {
                let (by_row, by_column) = (across[row], across[column]);
                let carried =
                    at(&slopes, row) * at(&slopes, column) + area * curvature_of_area(row, column);
                tangent[row][column] = whole[row][column]
                    + whole[row][ACROSS] * by_column
                    + by_row * whole[ACROSS][column]
                    + by_row * whole[ACROSS][ACROSS] * by_column
                    - self.carried * carried;
            }
        }
        tangent
    }

    /// Second derivative of W + K/2 (J - 1)^2, of W - p (J - 1) where K is infinite.
    fn tangent_of_body(&self, free: &Free) -> TangentMatrix {
        let mut tangent = self.body.tangent(&free.h);
        subtract_pressure(&mut tangent, &plus_unit(&free.h), free.pressure);
        let bulk = self.bulk_modulus().unwrap_or_default();
        for (row, entries) in tangent.iter_mut().enumerate() {
            for (column, entry) in entries.iter_mut().enumerate() {
                *entry += bulk * at(&free.cofactor, row) * at(&free.cofactor, column);
            }
        }
        tangent
    }

    /// dF33 / dF that keeps P33 zero, or the volume.
    fn change_across(&self, free: &Free, tangent: &TangentMatrix) -> [f64; 9] {
        match self.bulk_modulus() {
            Some(_) => tangent[ACROSS].map(|entry| -entry / tangent[ACROSS][ACROSS]),
            None => {
                std::array::from_fn(|place| -at(&free.cofactor, place) / at(&free.cofactor, ACROSS))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::{Isochoric, Ogden, OgdenTerm};

    const H: Tensor<f64> = [[0.3, -0.2, 0.0], [0.15, 0.2, 0.0], [0.0; 3]];

    fn sheets() -> Vec<Sheet<Isochoric>> {
        let terms = vec![OgdenTerm {
            modulus: 0.7,
            exponent: 2.6,
        }];
        let laws = crate::material::examples().map(Isochoric::Potential);
        let laws = laws.into_iter().chain([Isochoric::Ogden(Ogden { terms })]);
        laws.flat_map(|law| [0.0, 0.3].map(|inverse| Sheet::new(law.clone(), inverse)))
            .collect()
    }

    fn moved(place: usize, length: f64) -> Tensor<f64> {
        let mut unit = [[0.0; 3]; 3];
        unit[place / 3][place % 3] = 1.0;
        plus(&H, length, &unit)
    }

    #[test]
    fn stress_and_tangent_are_slopes_of_the_energy() {
        for sheet in sheets() {
            let (stress, tangent) = (sheet.stress(&H), sheet.tangent(&H));
            for place in IN_PLANE {
                let energy = |length| sheet.energy(&moved(place, length));
                let slope = (energy(1e-5) - energy(-1e-5)) / 2e-5;
                assert!((slope - at(&stress, place)).abs() < 1e-9, "{sheet:?}");
                let stress = |length| sheet.stress(&moved(place, length));
                let (up, down) = (stress(1e-5), stress(-1e-5));
                for row in IN_PLANE {
                    let slope = (at(&up, row) - at(&down, row)) / 2e-5;
                    let found = tangent[row][place];
                    assert!((slope - found).abs() < 1e-8, "{slope} {found} {sheet:?}");
                    assert!((found - tangent[place][row]).abs() < 1e-13);
                }
            }
        }
    }

    /// P33 or, where the volume is fixed, its change; and the largest part of P33.
    fn across(sheet: &Sheet<Isochoric>, h: &Tensor<f64>) -> [f64; 2] {
        let whole = sheet.with_thickness(h);
        let change = volume_change(&whole);
        match sheet.bulk_modulus() {
            None => [change, 1.0],
            Some(bulk) => {
                let own = sheet.body.stress(&whole)[2][2];
                [own + bulk * change * (1.0 + area_change(h)), own.abs()]
            }
        }
    }

    #[test]
    fn nothing_acts_across_the_sheet() {
        for sheet in sheets() {
            let [stress, _] = across(&sheet, &H);
            assert!(stress.abs() < 1e-14, "{sheet:?} {stress}");
        }
    }

    #[test]
    fn the_thickness_is_found_at_any_stretch_of_a_soft_body() {
        let terms = vec![OgdenTerm {
            modulus: 1.0,
            exponent: 1.3,
        }];
        for inverse_bulk in [1e-3, 1.0, 20.0] {
            let law = Isochoric::Ogden(Ogden {
                terms: terms.clone(),
            });
            let sheet = Sheet::new(law, inverse_bulk);
            for first in [0.1, 0.3, 1.0, 3.0, 10.0] {
                for second in [0.1, 0.3, 1.0, 3.0, 10.0] {
                    let h = [[first - 1.0, 0.0, 0.0], [0.0, second - 1.0, 0.0], [0.0; 3]];
                    let [stress, size] = across(&sheet, &h);
                    assert!(
                        stress.abs() <= 1e-10 * size.max(1.0),
                        "{first} {second} {inverse_bulk}: {stress}"
                    );
                }
            }
        }
    }

    #[test]
    fn at_rest_a_sheet_has_the_moduli_of_plane_stress() {
        for sheet in sheets() {
            let rest = sheet.tangent(&[[0.0; 3]; 3]);
            let (mu, inverse) = (sheet.body.shear_modulus(), sheet.inverse_bulk);
            let lame = match sheet.bulk_modulus() {
                None => 2.0 * mu,
                Some(bulk) => {
                    let lame = bulk - 2.0 / 3.0 * mu;
                    2.0 * lame * mu / (lame + 2.0 * mu)
                }
            };
            let carried = lame - sheet.carried;
            assert!((rest[0][0] - 2.0 * mu - carried).abs() < 1e-12, "{inverse}");
            assert!((rest[0][4] - carried).abs() < 1e-12, "{inverse}");
            assert!((rest[1][1] - mu).abs() < 1e-12 && (rest[1][3] - mu).abs() < 1e-12);
        }
    }
}
