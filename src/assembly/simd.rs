//! Runs the element kernels with the instruction set of the machine, chosen once
//! at run time by pulp. Results differ between sets by rounding only: the wider
//! set fuses products and sums. The name stands in every result.

use pulp::{Simd, WithSimd};

use super::kernel::{self, Batch};

/// Which kernels run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InstructionSet {
    /// What every processor of the target has.
    Portable,
    /// 256-bit vectors with fused products (x86-64 level 3).
    Avx2,
    /// 512-bit vectors with fused products (x86-64 level 4).
    Avx512,
}

impl InstructionSet {
    /// All, the narrowest first.
    pub const ALL: [Self; 3] = [Self::Portable, Self::Avx2, Self::Avx512];

    /// The widest that this machine has.
    pub fn of_this_machine() -> Self {
        let mut widest_first = Self::ALL.into_iter().rev();
        let here = widest_first.find(|set| set.is_here());
        here.unwrap_or(Self::Portable)
    }

    /// Whether this machine has it.
    pub fn is_here(self) -> bool {
        match self {
            Self::Portable => true,
            Self::Avx2 => level_3().is_some(),
            Self::Avx512 => level_4().is_some(),
        }
    }

    /// The name in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Portable => "portable",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
        }
    }

    /// Runs `pass`, on the portable path where the machine lacks the set.
    fn run(self, pass: impl WithSimd<Output = ()>) {
        let narrow = level_3().filter(|_| self == Self::Avx2);
        let wide = level_4().filter(|_| self == Self::Avx512);
        match (narrow, wide) {
            (Some(simd), _) => Simd::vectorize(simd, pass),
            (None, Some(simd)) => Simd::vectorize(simd, pass),
            (None, None) => pass.with_simd(pulp::Scalar),
        }
    }
}

#[cfg(target_arch = "x86_64")]
fn level_3() -> Option<pulp::x86::V3> {
    pulp::x86::V3::try_new()
}

#[cfg(target_arch = "x86_64")]
fn level_4() -> Option<pulp::x86::V4> {
    pulp::x86::V4::try_new()
}

#[cfg(not(target_arch = "x86_64"))]
fn level_3() -> Option<pulp::Scalar> {
    None
}

#[cfg(not(target_arch = "x86_64"))]
fn level_4() -> Option<pulp::Scalar> {
    None
}

/// Batches with argument and result, [`kernel`] function still open.
struct Pass<'a, const V: usize, const D: usize, const E: usize> {
    batches: &'a [Batch<V, D, E>],
    x: &'a [f64],
    y: &'a mut [f64],
}

macro_rules! dispatched {
    ($(#[$doc:meta])* $name:ident, $pass:ident) => {
        struct $pass<'a, const V: usize, const D: usize, const E: usize>(Pass<'a, V, D, E>);

        impl<const V: usize, const D: usize, const E: usize> WithSimd for $pass<'_, V, D, E> {
            type Output = ();
            #[inline(always)]
            fn with_simd<S: Simd>(self, simd: S) {
                for batch in self.0.batches {
                    kernel::$name(simd, batch, self.0.x, self.0.y);
                }
            }
        }

        $(#[$doc])*
        pub fn $name<const V: usize, const D: usize, const E: usize>(
            set: InstructionSet,
            batches: &[Batch<V, D, E>],
            x: &[f64],
            y: &mut [f64],
        ) {
            set.run($pass(Pass { batches, x, y }));
        }
    };
}

dispatched! {
    /// [`kernel::stiffness`] on all batches.
    stiffness, StiffnessPass
}
dispatched! {
    /// [`kernel::divergence`] on all batches.
    divergence, DivergencePass
}
dispatched! {
    /// [`kernel::divergence_transposed`] on all batches.
    divergence_transposed, DivergenceTransposedPass
}
