//! Stokes flow: sigma = 2 mu eps(u) - p I with -div u = 0, where u is a velocity
//! and mu a viscosity.
//!
//! The equations are those of an incompressible linear elastic body with
//! displacement and shear modulus in their place. The pressure is a stress,
//! forces are forces, and 1/2 int sigma : eps is half of the power dissipated.

use super::LinearElastic;

/// A viscous fluid without inertia.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stokes {
    /// Dynamic viscosity mu, stress times time, above zero.
    pub viscosity: f64,
}

impl Stokes {
    /// The elastic law with the same equations.
    pub fn elastic(self) -> LinearElastic {
        LinearElastic {
            shear_modulus: self.viscosity,
            inverse_lame: 0.0,
            direct_lame: 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flow_has_the_equations_of_an_incompressible_body() {
        let flow = Stokes { viscosity: 0.7 }.elastic();
        assert_eq!(flow, LinearElastic::from_shear_modulus(0.7, 0.5));
    }
}
