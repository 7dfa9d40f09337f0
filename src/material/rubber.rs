//! Rubber in mixed form: an isochoric energy W(F) and a volumetric part,
//!
//! ```text
//! W(F) - p (J - 1) - p^2 / 2K,   so that P = dW/dF - p cof F,  -(J - 1) - p / K = 0
//! ```
//!
//! with bulk modulus K, 1/K = 0 where the volume cannot change. A foam, whose energy is one of shape
//! and volume together, has that less K/2 (J - 1)^2 for W, a sheet that of its plane less a like
//! part of its area. All of it is given at a displacement gradient H = F - I, one point at a time;
//! the kernels take the laws in invariants several elements at a time.

use sha2::Sha256;

use super::mixed::subtract_pressure;
use super::{
    BodyLaw, Deformation, Hyperfoam, InvariantLaw, Ogden, Potential, Sheet, TangentMatrix,
};
use crate::geometry::tensor::{Tensor, plus, volume_change};

/// What displacements carry: the isochoric part, of a foam more than that.
#[derive(Clone, Debug, PartialEq)]
pub enum Isochoric {
    /// The invariants' law: Mooney-Rivlin, neo-Hookean or Yeoh.
    Invariants(InvariantLaw<f64>),
    /// Ogden's law: powers of the principal stretches.
    Ogden(Ogden),
    /// Any function of the invariants.
    Potential(Potential),
    /// A foam, less what its pressure carries.
    Hyperfoam(Hyperfoam),
    /// Any of them in the plane of a sheet that nothing holds across.
    Sheet(Box<Sheet<Isochoric>>),
}

/// A rubber.
#[derive(Clone, Debug, PartialEq)]
pub struct Rubber {
    /// W, the energy of a change of shape per undeformed volume; of a foam with the part of the
    /// volume that displacements carry.
    pub isochoric: Isochoric,
    /// 1 / K, one over stress; zero where the volume cannot change. Of a foam that of the part that
    /// its pressure carries.
    pub inverse_bulk: f64,
}

/// The deformation with displacement gradient H, its cube root of J taken once.
fn deformation(h: &Tensor<f64>) -> Deformation<f64> {
    Deformation::new(*h, (1.0 + volume_change(h)).cbrt().recip())
}

/// The tensor with one in place 3 i + j.
fn unit(place: usize) -> Tensor<f64> {
    let mut change = [[0.0; 3]; 3];
    change[place / 3][place % 3] = 1.0;
    change
}

impl BodyLaw for Isochoric {
    fn energy(&self, h: &Tensor<f64>) -> f64 {
        self.energy(h)
    }

    fn stress(&self, h: &Tensor<f64>) -> Tensor<f64> {
        self.stress(h)
    }

    fn tangent(&self, h: &Tensor<f64>) -> TangentMatrix {
        self.tangent(h)
    }

    fn shear_modulus(&self) -> f64 {
        self.shear_modulus()
    }

    fn over(&self, stress: f64) -> Self {
        self.over(stress)
    }

    fn hash_into(&self, hash: &mut Sha256) {
        self.hash_into(hash);
    }
}

impl Rubber {
    /// The neo-Hookean law of that shear modulus, stress, and 1 / K, one over stress.
    pub fn neo_hookean(shear_modulus: f64, inverse_bulk: f64) -> Self {
        let isochoric = Isochoric::Invariants(InvariantLaw {
            c10: 0.5 * shear_modulus,
            c01: 0.0,
            c20: 0.0,
            c30: 0.0,
        });
        Self {
            isochoric,
            inverse_bulk,
        }
    }
}

impl Isochoric {
    /// The law in units of `stress`.
    fn over(&self, stress: f64) -> Self {
        match self {
            Self::Invariants(law) => Self::Invariants(law.over(stress)),
            Self::Ogden(law) => Self::Ogden(law.over(stress)),
            Self::Potential(law) => Self::Potential(law.over(stress)),
            Self::Hyperfoam(law) => Self::Hyperfoam(law.over(stress)),
            Self::Sheet(law) => Self::Sheet(Box::new(law.over(stress))),
        }
    }

    /// Adds the law to a digest that tells laws apart.
    pub fn hash_into(&self, hash: &mut Sha256) {
        match self {
            Self::Invariants(law) => law.hash_into(hash),
            Self::Ogden(law) => law.hash_into(hash),
            Self::Potential(law) => law.hash_into(hash),
            Self::Hyperfoam(law) => law.hash_into(hash),
            Self::Sheet(law) => law.hash_into(hash),
        }
    }

    /// The law of a foam, in a sheet too.
    fn foam(&self) -> Option<&Hyperfoam> {
        match self {
            Self::Hyperfoam(law) => Some(law),
            Self::Sheet(sheet) => sheet.body().foam(),
            Self::Invariants(_) | Self::Ogden(_) | Self::Potential(_) => None,
        }
    }

    /// Whether kernels take it point by point.
    pub fn is_by_point(&self) -> bool {
        match self {
            Self::Invariants(_) => false,
            Self::Ogden(_) | Self::Potential(_) | Self::Hyperfoam(_) | Self::Sheet(_) => true,
        }
    }

    /// Shear modulus at rest, stress.
    pub fn shear_modulus(&self) -> f64 {
        match self {
            Self::Invariants(law) => law.modulus(),
            Self::Ogden(law) => law.shear_modulus(),
            Self::Potential(law) => law.shear_modulus(),
            Self::Hyperfoam(law) => law.shear_modulus(),
            Self::Sheet(law) => law.body().shear_modulus(),
        }
    }

    /// W.
    pub fn energy(&self, h: &Tensor<f64>) -> f64 {
        match self {
            Self::Invariants(law) => law.energy(&deformation(h)),
            Self::Ogden(law) => law.energy(h),
            Self::Potential(law) => law.energy(&deformation(h)),
            Self::Hyperfoam(law) => law.energy(h),
            Self::Sheet(law) => law.energy(h),
        }
    }

    /// dW/dF.
    pub fn stress(&self, h: &Tensor<f64>) -> Tensor<f64> {
        match self {
            Self::Invariants(law) => law.stress(&deformation(h)),
            Self::Ogden(law) => law.stress(h),
            Self::Potential(law) => law.stress(&deformation(h)),
            Self::Hyperfoam(law) => law.stress(h),
            Self::Sheet(law) => law.stress(h),
        }
    }

    /// d2W/dF2.
    pub fn tangent(&self, h: &Tensor<f64>) -> TangentMatrix {
        match self {
            Self::Invariants(law) => {
                let at = deformation(h);
                std::array::from_fn(|place| {
                    let (change, _) = law.tangent(&at, 0.0, &unit(place));
                    std::array::from_fn(|row| change[row / 3][row % 3])
                })
            }
            Self::Ogden(law) => law.tangent(h),
            Self::Potential(law) => law.tangent(&deformation(h)),
            Self::Hyperfoam(law) => law.tangent(h),
            Self::Sheet(law) => law.tangent(h),
        }
    }
}

impl Rubber {
    /// A foam.
    pub fn of_foam(law: Hyperfoam) -> Self {
        Self {
            inverse_bulk: law.carried().recip(),
            isochoric: Isochoric::Hyperfoam(law),
        }
    }

    /// The law of a foam; none of laws whose volume is a matter of the pressure alone.
    pub fn foam(&self) -> Option<&Hyperfoam> {
        self.isochoric.foam()
    }

    /// The rubber in units of `stress`.
    pub fn over(&self, stress: f64) -> Self {
        Self {
            isochoric: self.isochoric.over(stress),
            inverse_bulk: self.inverse_bulk * stress,
        }
    }

    /// Shear modulus at rest, stress.
    pub fn shear_modulus(&self) -> f64 {
        self.isochoric.shear_modulus()
    }

    /// W - p (J - 1) - p^2 / 2K.
    pub fn energy(&self, h: &Tensor<f64>, pressure: f64) -> f64 {
        let volumetric = volume_change(h) + 0.5 * pressure * self.inverse_bulk;
        self.isochoric.energy(h) - pressure * volumetric
    }

    /// P = dW/dF - p cof F.
    pub fn stress(&self, h: &Tensor<f64>, pressure: f64) -> Tensor<f64> {
        let cofactor = deformation(h).cofactor;
        plus(&self.isochoric.stress(h), -pressure, &cofactor)
    }

    /// dP/dF at fixed pressure.
    pub fn tangent(&self, h: &Tensor<f64>, pressure: f64) -> TangentMatrix {
        let mut tangent = self.isochoric.tangent(h);
        subtract_pressure(&mut tangent, &deformation(h).gradient, pressure);
        tangent
    }

    /// K of the body, stress, that of a sheet too; infinite where the volume cannot change.
    pub fn bulk_modulus(&self) -> f64 {
        match &self.isochoric {
            Isochoric::Sheet(sheet) => sheet.inverse_bulk(),
            Isochoric::Invariants(_)
            | Isochoric::Ogden(_)
            | Isochoric::Potential(_)
            | Isochoric::Hyperfoam(_) => self.inverse_bulk,
        }
        .recip()
    }

    /// J - 1 of the body; that of a sheet with the stretch across it.
    pub fn volume_change(&self, h: &Tensor<f64>) -> f64 {
        match &self.isochoric {
            Isochoric::Sheet(sheet) => sheet.volume_change(h),
            Isochoric::Invariants(_)
            | Isochoric::Ogden(_)
            | Isochoric::Potential(_)
            | Isochoric::Hyperfoam(_) => volume_change(h),
        }
    }

    /// The law as a sheet of it has it in its plane.
    #[must_use]
    pub fn of_a_sheet(self) -> Self {
        let sheet = Sheet::new(self.isochoric, self.inverse_bulk);
        Self {
            inverse_bulk: sheet.carried().recip(),
            isochoric: Isochoric::Sheet(Box::new(sheet)),
        }
    }

    /// -(J - 1) - p / K.
    pub fn volume_defect(&self, h: &Tensor<f64>, pressure: f64) -> f64 {
        -volume_change(h) - pressure * self.inverse_bulk
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::tensor::{contract, plus_unit};
    use crate::material::OgdenTerm;

    const H: Tensor<f64> = [[0.3, -0.2, 0.3], [0.15, 0.2, -0.25], [-0.3, 0.1, -0.35]];

    fn rubbers() -> Vec<Rubber> {
        let invariants = Isochoric::Invariants(InvariantLaw {
            c10: 0.4,
            c01: 0.1,
            c20: 0.05,
            c30: 0.02,
        });
        let terms = vec![OgdenTerm {
            modulus: 0.7,
            exponent: 2.6,
        }];
        let others = crate::material::examples().map(Isochoric::Potential);
        let all = [invariants, Isochoric::Ogden(Ogden { terms })].into_iter();
        all.chain(others)
            .map(|isochoric| Rubber {
                isochoric,
                inverse_bulk: 0.2,
            })
            .collect()
    }

    fn moved(place: usize, length: f64) -> Tensor<f64> {
        plus(&H, length, &unit(place))
    }

    #[test]
    fn stress_and_volume_defect_are_the_slopes_of_the_energy() {
        let pressure = 0.37;
        for rubber in rubbers() {
            let stress = rubber.stress(&H, pressure);
            for (place, found) in stress.as_flattened().iter().enumerate() {
                let energy = |length| rubber.energy(&moved(place, length), pressure);
                let slope = (energy(1e-5) - energy(-1e-5)) / 2e-5;
                assert!((slope - found).abs() < 1e-9, "{slope} {found}");
            }
            let energy = |pressure| rubber.energy(&H, pressure);
            let slope = (energy(pressure + 1e-4) - energy(pressure - 1e-4)) / 2e-4;
            assert!((slope - rubber.volume_defect(&H, pressure)).abs() < 1e-10);
        }
    }

    #[test]
    fn the_tangent_is_the_slope_of_the_stress_and_symmetric() {
        let pressure = 0.37;
        for rubber in rubbers() {
            let tangent = rubber.tangent(&H, pressure);
            for place in 0..9 {
                let stress = |length| rubber.stress(&moved(place, length), pressure);
                let (up, down) = (stress(1e-5), stress(-1e-5));
                for row in 0..9 {
                    let slope = (up[row / 3][row % 3] - down[row / 3][row % 3]) / 2e-5;
                    let found = tangent[row][place];
                    assert!(
                        (slope - found).abs() < 1e-8 * (1.0 + found.abs()),
                        "{slope} {found}"
                    );
                    assert!((found - tangent[place][row]).abs() < 1e-13);
                }
            }
        }
    }

    #[test]
    fn the_work_of_a_hydrostatic_change_is_that_of_the_pressure() {
        for rubber in rubbers() {
            // d/dt of (1 + t) F changes no isochoric energy; dJ/dt = 3 J.
            let work = contract(&rubber.stress(&H, 0.37), &plus_unit(&H));
            let exact = -0.37 * 3.0 * (1.0 + volume_change(&H));
            assert!((work - exact).abs() < 1e-14);
        }
    }
}
