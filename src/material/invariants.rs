//! Isochoric laws in the invariants of the deformation gradient:
//!
//! ```text
//! W = c10 (i1 - 3) + c20 (i1 - 3)^2 + c30 (i1 - 3)^3 + c01 (i2 - 3)
//! i1 = J^(-2/3) F:F,   i2 = J^(-4/3) cof F : cof F
//! ```
//!
//! Mooney-Rivlin (c10, c01), neo-Hookean (c10), Yeoh (c10, c20, c30). Everything
//! comes from H = F - I = grad u: where F is near I, differences of large terms
//! are never taken (Schussnig, Fehn, Munch, Kronbichler, arXiv 2408.12479). With
//! e1 = F:F / 3J, e2 = cof F : cof F / 3J and the directions
//!
//! ```text
//! n1 = F - e1 cof F,   n2 = cof F x F - 2 e2 cof F
//! P  = 2 W1 J^(-2/3) n1 + 2 W2 J^(-4/3) n2
//! ```
//!
//! the tangent is symmetric. Written once for single numbers and for vector
//! registers. Cost at a point: some 150 products for the stress, 300 for stress
//! direction and tangent together.

use sha2::{Digest, Sha256};

use crate::geometry::tensor::{
    Number, Tensor, cofactor, contract, cross, plus, plus_unit, scaled, trace, unit_cross,
};

/// Coefficients, stress; several elements at a time where `N` does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InvariantLaw<N> {
    /// Coefficient of i1 - 3, stress.
    pub c10: N,
    /// Coefficient of i2 - 3, stress; zero but for Mooney-Rivlin.
    pub c01: N,
    /// Coefficient of (i1 - 3)^2, stress; zero but for Yeoh.
    pub c20: N,
    /// Coefficient of (i1 - 3)^3, stress; zero but for Yeoh.
    pub c30: N,
}

impl InvariantLaw<f64> {
    /// The law in units of `stress`.
    pub fn over(&self, stress: f64) -> Self {
        Self {
            c10: self.c10 / stress,
            c01: self.c01 / stress,
            c20: self.c20 / stress,
            c30: self.c30 / stress,
        }
    }

    /// Adds the law to a digest that tells laws apart.
    pub(super) fn hash_into(&self, hash: &mut Sha256) {
        hash.update(b"invariants");
        for coefficient in [self.c10, self.c01, self.c20, self.c30] {
            hash.update(coefficient.to_le_bytes());
        }
    }
}

/// The deformation at a point, as the law needs it.
#[derive(Clone, Copy, Debug)]
pub struct Deformation<N> {
    /// F, the deformation gradient.
    pub gradient: Tensor<N>,
    /// cof F, the derivative of J by F.
    pub cofactor: Tensor<N>,
    /// J - 1, found without the loss of digits that J itself would bring.
    pub volume_change: N,
    /// H = F - I, the displacement gradient.
    displacement_gradient: Tensor<N>,
    /// cof F - I, found from H so that small strains keep their digits.
    cofactor_change: Tensor<N>,
    /// 1 / J.
    inverse: N,
    /// J^(-1/3), which takes the change of volume out of the stretches.
    root: N,
}

impl<N: Number> Deformation<N> {
    /// At displacement gradient `h`; `root` is J^(-1/3) there.
    #[inline(always)]
    pub fn new(h: Tensor<N>, root: N) -> Self {
        let minors = cofactor(&h);
        let first = (h[0][0] * minors[0][0])
            .plus_product(h[0][1], minors[0][1])
            .plus_product(h[0][2], minors[0][2]);
        let volume_change = trace(&h) + trace(&minors) + first;
        let cofactor_change = plus(&minors, first.constant(1.0), &unit_cross(&h));
        Self {
            gradient: plus_unit(&h),
            cofactor: plus_unit(&cofactor_change),
            volume_change,
            displacement_gradient: h,
            cofactor_change,
            inverse: root * root * root,
            root,
        }
    }
}

/// Invariants and their directions at a deformation.
pub(super) struct Response<N> {
    /// n1 = F - e1 cof F, along which the first invariant changes with F.
    pub(super) first: Tensor<N>,
    /// e1 = F:F / 3 J.
    first_ratio: N,
    /// i1 - 3, zero at rest.
    pub(super) first_excess: N,
}

/// The second invariant and its direction at a deformation.
pub(super) struct SecondResponse<N> {
    /// n2 = cof F x F - 2 e2 cof F, along which the second invariant changes with F.
    pub(super) second: Tensor<N>,
    /// e2 = cof F : cof F / 3 J.
    second_ratio: N,
    /// i2 - 3, zero at rest.
    pub(super) second_excess: N,
}

/// Slopes of an energy whose second invariant enters linearly.
pub(super) struct Slopes<N> {
    /// dW/di1.
    pub(super) first: N,
    /// d2W/di1^2.
    pub(super) bend: N,
    /// dW/di2.
    pub(super) second: N,
}

impl<N: Number> Deformation<N> {
    /// (x - 3 J) / 3 J and J^(-n/3) x - 3 for x = 3 + `excess`, n = 2 or 4.
    #[inline(always)]
    fn third_of(&self, excess: N) -> N {
        (excess - self.volume_change * 3.0) * self.inverse * (1.0 / 3.0)
    }

    /// J^(-2/3).
    #[inline(always)]
    pub(super) fn square(&self) -> N {
        self.root * self.root
    }

    /// J^(1/3) - 1 = (J - 1) / (J^(2/3) + J^(1/3) + 1).
    #[inline(always)]
    fn root_change(&self) -> N {
        let one = self.root.constant(1.0);
        // With y = J^(-1/3): y^2 / (1 + y + y^2).
        let square = self.root * self.root;
        self.volume_change * square * (one + self.root + square).inverse()
    }

    /// The first invariant and its derivative, from H so that small strains keep their
    /// digits.
    #[inline(always)]
    pub(super) fn first(&self) -> Response<N> {
        let h = &self.displacement_gradient;
        let one = self.root.constant(1.0);
        let excess = trace(h) * 2.0 + contract(h, h);
        let ratio = self.third_of(excess);
        let first = plus(
            &plus(h, -one, &self.cofactor_change),
            -ratio,
            &self.cofactor,
        );
        // J^(2/3) - 1 = r (2 + r) for r = J^(1/3) - 1.
        let r = self.root_change();
        let square_change = r * (one.constant(2.0) + r);
        Response {
            first,
            first_ratio: one + ratio,
            first_excess: self.root * self.root * (excess - square_change * 3.0),
        }
    }

    /// The second invariant and its derivative; laws without c01 never ask for it.
    #[inline(always)]
    pub(super) fn second(&self) -> SecondResponse<N> {
        let h = &self.displacement_gradient;
        let one = self.root.constant(1.0);
        let change = &self.cofactor_change;
        let excess = trace(change) * 2.0 + contract(change, change);
        let ratio = self.third_of(excess);
        // cof F x F - 2 cof F with the unit parts taken off.
        let mut second = plus(&unit_cross(h), one, &unit_cross(change));
        second = plus(&second, one, &cross(change, h));
        second = plus(&second, one.constant(-2.0), change);
        second = plus(&second, ratio * -2.0, &self.cofactor);
        let r = self.root_change();
        let square_change = r * (one.constant(2.0) + r);
        let fourth_change = square_change * (one.constant(2.0) + square_change);
        let square = self.root * self.root;
        SecondResponse {
            second,
            second_ratio: one + ratio,
            second_excess: square * square * (excess - fourth_change * 3.0),
        }
    }
}

impl<N: Number> InvariantLaw<N> {
    /// Shear modulus at rest.
    #[inline(always)]
    pub fn modulus(&self) -> N {
        (self.c10 + self.c01) * 2.0
    }

    /// dW/di1 and d2W/di1^2.
    #[inline(always)]
    fn slopes(&self, excess: N) -> (N, N) {
        let slope = self
            .c10
            .plus_product(self.c20 * 2.0, excess)
            .plus_product(self.c30 * 3.0, excess * excess);
        (slope, (self.c20 * 2.0).plus_product(self.c30 * 6.0, excess))
    }

    /// W.
    #[inline(always)]
    pub fn energy(&self, at: &Deformation<N>) -> N {
        let (one, two) = (at.first().first_excess, at.second().second_excess);
        let inner = self.c20.plus_product(self.c30, one);
        (self.c01 * two).plus_product(self.c10.plus_product(inner, one), one)
    }

    /// dW/dF.
    #[inline(always)]
    pub fn stress(&self, at: &Deformation<N>) -> Tensor<N> {
        let square = at.root * at.root;
        let one = at.first();
        let (slope, _) = self.slopes(one.first_excess);
        let two = at.second();
        let stress = scaled(slope * square * 2.0, &one.first);
        plus(&stress, self.c01 * square * square * 2.0, &two.second)
    }

    /// d2W/dF2 : `change`, less `pressure` times the change of cof F; also
    /// cof F : `change`, the change of volume.
    #[inline(always)]
    pub fn tangent(&self, at: &Deformation<N>, pressure: N, change: &Tensor<N>) -> (Tensor<N>, N) {
        let one = at.first();
        let (first, bend) = self.slopes(one.first_excess);
        let slopes = Slopes {
            first,
            bend,
            second: self.c01,
        };
        at.tangent((&one, slopes), pressure, change)
    }
}

impl<N: Number> Deformation<N> {
    /// The change of 2 W1 J^(-2/3) n1 + 2 W2 J^(-4/3) n2, W2 held, less `pressure` times that
    /// of cof F, along `change`; also cof F : `change`.
    #[inline(always)]
    pub(super) fn tangent(
        &self,
        (one, slopes): (&Response<N>, Slopes<N>),
        pressure: N,
        change: &Tensor<N>,
    ) -> (Tensor<N>, N) {
        let at = self;
        let square = at.root * at.root;
        let (slope, bend) = (slopes.first, slopes.bend);
        let volume = contract(&at.cofactor, change);
        let third = at.inverse * (1.0 / 3.0);
        let along = contract(&one.first, change);
        let turned = cross(&at.gradient, change);
        let weight = slope * square * 2.0;
        // Coefficients of change, n1, cof F, F x change and n2.
        let on_first = (bend * square * square * along * 4.0) - weight * volume * third * 2.0;
        let on_cofactor = weight * third * (one.first_ratio * volume - along * 2.0);
        let on_turned = -(weight * one.first_ratio) - pressure;
        let mut out = scaled(weight, change);
        out = plus(&out, on_first, &one.first);

        let two = at.second();
        let along = contract(&two.second, change);
        let weight = slopes.second * square * square * 2.0;
        let pair = plus(
            &cross(&turned, &at.gradient),
            weight.constant(1.0),
            &cross(&at.cofactor, change),
        );
        out = plus(&out, weight, &pair);
        out = plus(&out, weight * volume * third * -4.0, &two.second);
        let on_cofactor =
            on_cofactor - weight * third * (along * 4.0 + two.second_ratio * volume * 2.0);
        let on_turned = on_turned - weight * two.second_ratio * 2.0;
        out = plus(&out, on_turned, &turned);
        (plus(&out, on_cofactor, &at.cofactor), volume)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::tensor::volume_change;

    const LAW: InvariantLaw<f64> = InvariantLaw {
        c10: 0.4,
        c01: 0.1,
        c20: 0.05,
        c30: 0.02,
    };
    const H: Tensor<f64> = [[0.3, -0.2, 0.3], [0.15, 0.2, -0.25], [-0.3, 0.1, -0.35]];

    fn at(h: Tensor<f64>) -> Deformation<f64> {
        Deformation::new(h, (1.0 + volume_change(&h)).cbrt().recip())
    }

    fn moved(h: &Tensor<f64>, length: f64, i: usize, j: usize) -> Tensor<f64> {
        let mut out = *h;
        out[i][j] += length;
        out
    }

    #[test]
    fn the_energy_is_that_of_the_textbook() {
        let d = at(H);
        let jacobian = 1.0 + d.volume_change;
        let first = jacobian.powf(-2.0 / 3.0) * contract(&d.gradient, &d.gradient) - 3.0;
        let second = jacobian.powf(-4.0 / 3.0) * contract(&d.cofactor, &d.cofactor) - 3.0;
        let exact = 0.4 * first + 0.1 * second + 0.05 * first.powi(2) + 0.02 * first.powi(3);
        assert!((LAW.energy(&d) - exact).abs() < 1e-14 * exact);
    }

    #[test]
    fn the_stress_is_the_slope_of_the_energy() {
        for h in [H, scaled(1e-3, &H), scaled(-0.9, &H)] {
            let stress = LAW.stress(&at(h));
            for i in 0..3 {
                for j in 0..3 {
                    let energy = |length| LAW.energy(&at(moved(&h, length, i, j)));
                    let slope = (energy(1e-5) - energy(-1e-5)) / 2e-5;
                    assert!(
                        (slope - stress[i][j]).abs() < 1e-9,
                        "{slope} {}",
                        stress[i][j]
                    );
                }
            }
        }
    }

    #[test]
    fn the_tangent_is_the_slope_of_the_stress() {
        let pressure = 0.37;
        for h in [H, scaled(1e-3, &H), scaled(-0.9, &H)] {
            for i in 0..3 {
                for j in 0..3 {
                    let total = |length| {
                        let d = at(moved(&h, length, i, j));
                        plus(&LAW.stress(&d), -pressure, &d.cofactor)
                    };
                    let (up, down) = (total(1e-5), total(-1e-5));
                    let change = moved(&[[0.0; 3]; 3], 1.0, i, j);
                    let (tangent, volume) = LAW.tangent(&at(h), pressure, &change);
                    assert!((volume - at(h).cofactor[i][j]).abs() < 1e-15);
                    for k in 0..3 {
                        for l in 0..3 {
                            let slope = (up[k][l] - down[k][l]) / 2e-5;
                            let found = tangent[k][l];
                            assert!(
                                (slope - found).abs() < 2e-9 * (1.0 + found.abs()),
                                "{slope} {found}"
                            );
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn tiny_strains_keep_their_digits() {
        // 2 mu dev eps with mu = 2 (c10 + c01).
        let small = scaled(1e-10, &H);
        let stress = LAW.stress(&at(small));
        let third = trace(&H) / 3.0;
        for i in 0..3 {
            for j in 0..3 {
                let unit = if i == j { third } else { 0.0 };
                let exact = 1e-10 * (H[i][j] + H[j][i] - 2.0 * unit);
                assert!((stress[i][j] - exact).abs() < 1e-19);
            }
        }
    }
}
