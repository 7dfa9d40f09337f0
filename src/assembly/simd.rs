//! Runs the element kernels with the instruction set of the machine, chosen once
//! at run time by pulp. Results differ between sets by rounding only: the wider
//! set fuses products and sums. The name stands in every result.

use pulp::{Simd, WithSimd};

use super::kernel::{Batch, Element, Kernel};
use super::lanes::WIDTH;
use super::transpose::{Batched, Row, Transpose};

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
    pub(super) fn run<P: BatchPass>(self, pass: P) -> P::Output {
        let narrow = level_3().filter(|_| self == Self::Avx2);
        let wide = level_4().filter(|_| self == Self::Avx512);
        match (narrow, wide) {
            (Some(simd), _) => Simd::vectorize(simd, Transposing(pass, simd)),
            (None, Some(simd)) => Simd::vectorize(simd, Transposing(pass, simd)),
            (None, None) => Transposing(pass, pulp::Scalar).with_simd(pulp::Scalar),
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

/// What runs on the registers and shuffles of one instruction set.
pub(super) trait BatchPass {
    type Output;
    fn run<S: Simd, T: Transpose>(self, simd: S, transpose: T) -> Self::Output;
}

/// A pass together with the shuffles of the set it runs on.
struct Transposing<P, T>(P, T);

impl<P: BatchPass, T: Transpose> WithSimd for Transposing<P, T> {
    type Output = P::Output;
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> P::Output {
        self.0.run(simd, self.1)
    }
}

/// Asks for the cache lines of something that is read soon: batches are read
/// once a pass, nodes in the order of a block, and waiting for either takes a
/// third of a pass.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
#[allow(unsafe_code)]
fn prefetch<T>(item: &T) {
    use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
    const LINE: usize = 64;
    let start = std::ptr::from_ref(item).cast::<i8>();
    for line in 0..size_of::<T>().div_ceil(LINE) {
        // SAFETY: the address lies inside `item`, and a prefetch reads nothing.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(start.add(line * LINE)) };
    }
}

#[cfg(not(target_arch = "x86_64"))]
fn prefetch<T>(_item: &T) {}

/// [`prefetch`] of one entry; nothing where there is none.
#[inline(always)]
pub(super) fn prefetch_at<T>(items: &[T], index: usize) {
    if let Some(item) = items.get(index) {
        prefetch(item);
    }
}

/// Batches with argument and result, [`Kernel`] still open.
struct Pass<'a, const V: usize, const D: usize, const E: usize, R = f64, const W: usize = WIDTH> {
    batches: &'a [Batch<V, D, E, R, W>],
    x: &'a [Row<R>],
    y: &'a mut [Row<R>],
}

macro_rules! dispatched {
    ($(#[$doc:meta])* $name:ident, $pass:ident) => {
        struct $pass<'a, const V: usize, const D: usize, const E: usize, R, const W: usize>(
            Pass<'a, V, D, E, R, W>,
        );

        impl<const V: usize, const D: usize, const E: usize, R: Batched<W>, const W: usize>
            BatchPass for $pass<'_, V, D, E, R, W>
        {
            type Output = ();
            #[inline(always)]
            fn run<S: Simd, T: Transpose>(self, simd: S, transpose: T) {
                let mut element = Element::zero();
                let Pass { batches, x, y } = self.0;
                for (index, batch) in batches.iter().enumerate() {
                    prefetch_at(batches, index + 1);
                    let (element, y) = (&mut element, &mut *y);
                    Kernel { simd, transpose, batch, element, x, y }.$name();
                }
            }
        }

        $(#[$doc])*
        pub fn $name<const V: usize, const D: usize, const E: usize, R: Batched<W>, const W: usize>(
            set: InstructionSet,
            batches: &[Batch<V, D, E, R, W>],
            x: &[Row<R>],
            y: &mut [Row<R>],
        ) {
            set.run($pass(Pass { batches, x, y }));
        }
    };
}

dispatched! {
    /// `Kernel::stiffness` on all batches.
    stiffness, StiffnessPass
}
dispatched! {
    /// `Kernel::augmented_stiffness` on all batches.
    augmented_stiffness, AugmentedPass
}
dispatched! {
    /// `Kernel::divergence` on all batches.
    divergence, DivergencePass
}
dispatched! {
    /// `Kernel::divergence_transposed` on all batches.
    divergence_transposed, DivergenceTransposedPass
}
dispatched! {
    /// `Kernel::saddle` on all batches.
    saddle, SaddlePass
}

/// Rows as lanes and back, by the shuffles of `set`.
#[cfg(test)]
pub(super) fn there_and_back<R: Batched<W>, const W: usize>(
    set: InstructionSet,
    rows: &[Row<R>; W],
) -> ([super::lanes::Lanes<R, W>; 4], [Row<R>; W]) {
    struct Trip<'a, R, const W: usize>(&'a [Row<R>; W]);
    impl<R: Batched<W>, const W: usize> BatchPass for Trip<'_, R, W> {
        type Output = ([super::lanes::Lanes<R, W>; 4], [Row<R>; W]);
        #[inline(always)]
        fn run<S: Simd, T: Transpose>(self, _simd: S, transpose: T) -> Self::Output {
            let lanes = R::to_lanes(transpose, self.0.each_ref());
            (lanes, R::to_rows(transpose, &lanes))
        }
    }
    set.run(Trip(rows))
}
