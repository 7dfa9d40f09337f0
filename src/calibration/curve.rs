//! Test curves of an incompressible law in closed form.
//!
//! ```text
//! uniaxial (l, l^-1/2, l^-1/2)   planar (l, 1, 1/l)   equibiaxial (l, l, l^-2)
//! nominal stress = (tau_1 - tau_3) / l,   tau = dW/dF F^T,   direction 3 free
//! ```
//!
//! The stress is the law's own; the pressure follows from the free direction.
//! Reference: L. R. G. Treloar, The Physics of Rubber Elasticity, 1975, chapter 5.

use std::fmt;

use crate::geometry::tensor::Tensor;
use crate::material::Isochoric;

/// A test with a uniform deformation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum TestKind {
    /// Tension or compression along one direction.
    Uniaxial,
    /// Pure shear: a wide strip that keeps its width.
    Planar,
    /// The same stretch along two directions.
    Equibiaxial,
}

impl TestKind {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::Uniaxial, Self::Planar, Self::Equibiaxial];

    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Uniaxial => "uniaxial",
            Self::Planar => "planar",
            Self::Equibiaxial => "equibiaxial",
        }
    }

    /// Principal stretches, the third of the free direction.
    fn stretches(self, stretch: f64) -> [f64; 3] {
        match self {
            Self::Uniaxial => [stretch, stretch.powf(-0.5), stretch.powf(-0.5)],
            Self::Planar => [stretch, 1.0, stretch.recip()],
            Self::Equibiaxial => [stretch, stretch, stretch.powi(-2)],
        }
    }

    /// i1 - 3.
    pub(super) fn first_invariant(self, stretch: f64) -> f64 {
        let squares = self.stretches(stretch).map(|l| l * l);
        squares.iter().sum::<f64>() - 3.0
    }
}

impl fmt::Display for TestKind {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name())
    }
}

/// Nominal stress of `law` in a test, unit of its constants.
pub(super) fn nominal_stress(law: &Isochoric, kind: TestKind, stretch: f64) -> f64 {
    let stretches = kind.stretches(stretch);
    let mut h: Tensor<f64> = [[0.0; 3]; 3];
    for (axis, stretch) in stretches.into_iter().enumerate() {
        h[axis][axis] = stretch - 1.0;
    }
    let stress = law.stress(&h);
    let [first, _, third] = [0, 1, 2].map(|axis| stress[axis][axis] * stretches[axis]);
    (first - third) / stretch
}
