//! Linear elasticity for every Poisson ratio up to one half:
//! sigma = 2 mu eps(u) - p I with -div u - p / lambda = 0.
//!
//! mu, lambda: stress. lambda = 2 mu nu / (1 - 2 nu), infinite at nu = 1/2.
//! Tensors are 3 by 3 in two dimensions too (plane strain).
//!
//! Where lambda is small or negative and a pressure is there because of another material,
//! p / lambda is no well scaled number. Then lambda = lambda_1 + lambda_2 with
//!
//! ```text
//! sigma = 2 mu eps(u) + lambda_1 div u I - p I,   -div u - p / lambda_2 = 0
//! ```
//!
//! lambda_2 small and above zero, lambda_1 above -2 mu / 3: both parts are positive.

/// lambda_2 in shear moduli: lambda at a Poisson ratio of 0.01.
pub(super) const CARRIED_BY_PRESSURE: f64 = 0.02 / 0.98;

/// Moduli of one material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearElastic {
    /// Shear modulus mu, stress, above zero.
    pub shear_modulus: f64,
    /// 1 / lambda, zero for an incompressible material; may be negative for
    /// Poisson ratios below zero and infinite at zero.
    /// Of lambda_2 alone where [`Self::direct_lame`] is not zero.
    pub inverse_lame: f64,
    /// lambda_1, stress: the part of lambda that displacements carry beside a pressure.
    pub direct_lame: f64,
}

impl LinearElastic {
    /// From the shear modulus and Poisson's ratio, at most one half.
    pub fn from_shear_modulus(shear_modulus: f64, poisson_ratio: f64) -> Self {
        Self {
            shear_modulus,
            inverse_lame: (1.0 - 2.0 * poisson_ratio) / (2.0 * shear_modulus * poisson_ratio),
            direct_lame: 0.0,
        }
    }

    /// The same material with a pressure that carries a small part of lambda.
    pub fn beside_a_pressure(self) -> Self {
        let bulk = self.lame() + 2.0 / 3.0 * self.shear_modulus;
        let carried = (CARRIED_BY_PRESSURE * self.shear_modulus).min(0.5 * bulk);
        Self {
            inverse_lame: 1.0 / carried,
            direct_lame: self.lame() - carried,
            ..self
        }
    }

    /// From Young's modulus and Poisson's ratio, at most one half.
    pub fn from_young_modulus(young_modulus: f64, poisson_ratio: f64) -> Self {
        Self::from_shear_modulus(0.5 * young_modulus / (1.0 + poisson_ratio), poisson_ratio)
    }

    /// The material of plane strain whose plane stresses are those of a sheet of this one:
    /// lambda' = 2 lambda mu / (lambda + 2 mu), nu' = nu / (1 + nu).
    pub fn of_a_sheet(self) -> Self {
        let ratio = self.poisson_ratio();
        Self::from_shear_modulus(self.shear_modulus, ratio / (1.0 + ratio))
    }

    /// eps_zz over eps_xx + eps_yy in a sheet, of its [`Self::of_a_sheet`].
    pub fn thinning(&self) -> f64 {
        -0.5 * self.lame() / self.shear_modulus
    }

    /// lambda; zero at a Poisson ratio of zero, infinite at one half.
    pub fn lame(&self) -> f64 {
        self.direct_lame + 1.0 / self.inverse_lame
    }

    /// Poisson's ratio.
    pub fn poisson_ratio(&self) -> f64 {
        let compliance = if self.direct_lame == 0.0 {
            self.inverse_lame
        } else {
            1.0 / self.lame()
        };
        0.5 / (1.0 + self.shear_modulus * compliance)
    }

    /// -lambda div u over the pressure unknown: one unless displacements carry a part of it.
    pub fn pressure_share(&self) -> f64 {
        1.0 + self.direct_lame * self.inverse_lame
    }

    /// Stress at `gradient` = du_i/dx_j and pressure.
    pub fn stress(&self, gradient: &[[f64; 3]; 3], pressure: f64) -> [[f64; 3]; 3] {
        let mut stress = [[0.0; 3]; 3];
        let dilation = gradient[0][0] + gradient[1][1] + gradient[2][2];
        for i in 0..3 {
            for j in 0..3 {
                stress[i][j] = self.shear_modulus * (gradient[i][j] + gradient[j][i]);
            }
            stress[i][i] += self.direct_lame * dilation - pressure;
        }
        stress
    }

    /// 1 / K, one over stress; zero where the volume cannot change.
    pub fn inverse_bulk(&self) -> f64 {
        (self.lame() + 2.0 / 3.0 * self.shear_modulus).recip()
    }

    /// The pressure that belongs to a volume strain, for displacement forms.
    pub fn pressure(&self, volume_strain: f64) -> f64 {
        -volume_strain * self.lame()
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // These values are exact.
mod tests {
    use super::*;

    #[test]
    fn both_parametrisations_give_the_same_moduli() {
        let a = LinearElastic::from_young_modulus(2.6, 0.3);
        let b = LinearElastic::from_shear_modulus(1.0, 0.3);
        assert!((a.shear_modulus - 1.0).abs() < 1e-15);
        assert!((a.lame() - 1.5).abs() < 1e-14 && (b.lame() - 1.5).abs() < 1e-14);
    }

    #[test]
    fn the_limits_of_poisson_ratio_are_finite_numbers() {
        assert_eq!(
            LinearElastic::from_shear_modulus(1.0, 0.5).inverse_lame,
            0.0
        );
        assert_eq!(LinearElastic::from_shear_modulus(1.0, 0.0).lame(), 0.0);
    }

    #[test]
    fn a_stretched_sheet_has_youngs_modulus_and_thins_by_poissons_ratio() {
        for ratio in [-0.4, 0.0, 0.3, 0.5] {
            let sheet = LinearElastic::from_young_modulus(2.6, ratio).of_a_sheet();
            let stretch = [[0.01, 0.0, 0.0], [0.0, -0.01 * ratio, 0.0], [0.0; 3]];
            let stress = sheet.stress(&stretch, sheet.pressure(0.01 * (1.0 - ratio)));
            assert!((stress[0][0] - 0.026).abs() < 1e-15, "{ratio} {stress:?}");
            assert!(stress[1][1].abs() < 1e-15, "{ratio} {stress:?}");
            let across = sheet.thinning() * 0.01 * (1.0 - ratio);
            assert!((across + 0.01 * ratio).abs() < 1e-15, "{ratio} {across}");
        }
    }

    #[test]
    fn the_stress_is_the_derivative_of_the_energy() {
        let law = LinearElastic::from_shear_modulus(1.3, 0.4);
        let energy = |g: &[[f64; 3]; 3]| {
            let mut sum = 0.0;
            for i in 0..3 {
                for j in 0..3 {
                    sum += law.shear_modulus * (0.5 * (g[i][j] + g[j][i])).powi(2);
                }
            }
            sum + 0.5 * law.lame() * (g[0][0] + g[1][1] + g[2][2]).powi(2)
        };
        let g = [[0.1, -0.2, 0.3], [0.05, 0.2, -0.1], [0.4, 0.0, -0.15]];
        let stress = law.stress(&g, law.pressure(g[0][0] + g[1][1] + g[2][2]));
        for i in 0..3 {
            for j in 0..3 {
                let (mut up, mut down) = (g, g);
                up[i][j] += 1e-6;
                down[i][j] -= 1e-6;
                let slope = (energy(&up) - energy(&down)) / 2e-6;
                assert!((slope - stress[i][j]).abs() < 1e-9);
            }
        }
    }
}
