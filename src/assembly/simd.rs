//! Runs the element kernels with the instruction set of the machine, chosen once
//! at run time by pulp. Results differ between sets by rounding only: the wider
//! set fuses products and sums. The name stands in every result.

use pulp::{Arch, Simd, WithSimd};

use super::kernel::{self, Batch};

/// Which kernels run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InstructionSet {
    /// What every processor of the target has.
    Portable,
    /// 256-bit vectors with fused products (x86-64 level 3).
    Avx2,
}

impl InstructionSet {
    /// The widest that this machine has.
    pub fn of_this_machine() -> Self {
        #[cfg(target_arch = "x86_64")]
        if matches!(Arch::new(), Arch::V3(_)) {
            return Self::Avx2;
        }
        Self::Portable
    }

    /// The name in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Portable => "portable",
            Self::Avx2 => "avx2",
        }
    }

    fn run(self, pass: impl WithSimd<Output = ()>) {
        match self {
            Self::Portable => pass.with_simd(pulp::Scalar),
            Self::Avx2 => Arch::new().dispatch(pass),
        }
    }
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
