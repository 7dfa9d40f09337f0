//! Numbers that move together, one per element of a batch, in the vector
//! registers of whatever instruction set runs (pulp's `Simd`): eight in double
//! precision, sixteen in single.

use std::ops::{Add, AddAssign, Mul, Neg, Sub};

use pulp::Simd;

use crate::geometry::tensor::Number;
use crate::linalg::Scalar;

/// Elements per batch in double precision; a multiple of every register width.
pub const WIDTH: usize = 8;
/// Elements per batch in single precision.
pub const SINGLE_WIDTH: usize = 16;

/// The numbers of a batch in memory.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub struct Lanes<R = f64, const W: usize = WIDTH>(pub [R; W]);

impl<R: Scalar, const W: usize> Lanes<R, W> {
    /// All zero.
    pub fn zero() -> Self {
        Self([R::default(); W])
    }
}

/// Numbers that registers hold, [`Register`] by [`Register`].
///
/// [`Register`]: Packed::Register
pub trait Packed: Scalar {
    /// One register of instruction set S.
    type Register<S: Simd>: Copy;
    /// Numbers of a register.
    fn lanes<S: Simd>() -> usize;
    /// Register `part` of `numbers`.
    fn load<S: Simd>(numbers: &[Self], part: usize) -> Self::Register<S>;
    /// Writes it.
    fn store<S: Simd>(register: Self::Register<S>, numbers: &mut [Self], part: usize);
    /// The same number everywhere.
    fn splat<S: Simd>(simd: S, value: f64) -> Self::Register<S>;
    /// `a + b`.
    fn sum<S: Simd>(simd: S, a: Self::Register<S>, b: Self::Register<S>) -> Self::Register<S>;
    /// `a - b`.
    fn difference<S: Simd>(
        simd: S,
        a: Self::Register<S>,
        b: Self::Register<S>,
    ) -> Self::Register<S>;
    /// `a b`.
    fn product<S: Simd>(simd: S, a: Self::Register<S>, b: Self::Register<S>) -> Self::Register<S>;
    /// `a b + c`.
    fn product_sum<S: Simd>(
        simd: S,
        a: Self::Register<S>,
        b: Self::Register<S>,
        c: Self::Register<S>,
    ) -> Self::Register<S>;
    /// `-a`.
    fn negative<S: Simd>(simd: S, a: Self::Register<S>) -> Self::Register<S>;
}

macro_rules! packed {
    ($number:ty, $register:ident, $lanes:ident, $view:ident, $view_mut:ident, $splat:ident,
     $add:ident, $sub:ident, $mul:ident, $mul_add:ident, $neg:ident) => {
        impl Packed for $number {
            type Register<S: Simd> = S::$register;

            #[inline(always)]
            fn lanes<S: Simd>() -> usize {
                S::$lanes
            }

            #[inline(always)]
            fn load<S: Simd>(numbers: &[Self], part: usize) -> S::$register {
                S::$view(numbers).0[part]
            }

            #[inline(always)]
            fn store<S: Simd>(register: S::$register, numbers: &mut [Self], part: usize) {
                S::$view_mut(numbers).0[part] = register;
            }

            #[inline(always)]
            fn splat<S: Simd>(simd: S, value: f64) -> S::$register {
                simd.$splat(Self::narrow(value))
            }

            #[inline(always)]
            fn sum<S: Simd>(simd: S, a: S::$register, b: S::$register) -> S::$register {
                simd.$add(a, b)
            }

            #[inline(always)]
            fn difference<S: Simd>(simd: S, a: S::$register, b: S::$register) -> S::$register {
                simd.$sub(a, b)
            }

            #[inline(always)]
            fn product<S: Simd>(simd: S, a: S::$register, b: S::$register) -> S::$register {
                simd.$mul(a, b)
            }

            #[inline(always)]
            fn product_sum<S: Simd>(
                simd: S,
                a: S::$register,
                b: S::$register,
                c: S::$register,
            ) -> S::$register {
                simd.$mul_add(a, b, c)
            }

            #[inline(always)]
            fn negative<S: Simd>(simd: S, a: S::$register) -> S::$register {
                simd.$neg(a)
            }
        }
    };
}

packed!(
    f64,
    f64s,
    F64_LANES,
    as_simd_f64s,
    as_mut_simd_f64s,
    splat_f64s,
    add_f64s,
    sub_f64s,
    mul_f64s,
    mul_add_e_f64s,
    neg_f64s
);
packed!(
    f32,
    f32s,
    F32_LANES,
    as_simd_f32s,
    as_mut_simd_f32s,
    splat_f32s,
    add_f32s,
    sub_f32s,
    mul_f32s,
    mul_add_e_f32s,
    neg_f32s
);

/// One register of numbers.
#[derive(Clone, Copy)]
pub struct Pack<S: Simd, R: Packed = f64> {
    simd: S,
    value: R::Register<S>,
}

impl<S: Simd, R: Packed> Pack<S, R> {
    /// Part `part` of the numbers of a batch.
    #[inline(always)]
    pub fn load<const W: usize>(simd: S, lanes: &Lanes<R, W>, part: usize) -> Self {
        Self {
            simd,
            value: R::load::<S>(&lanes.0, part),
        }
    }

    /// Writes part `part` of the numbers of a batch.
    #[inline(always)]
    pub fn store<const W: usize>(self, lanes: &mut Lanes<R, W>, part: usize) {
        R::store::<S>(self.value, &mut lanes.0, part);
    }

    /// The same number everywhere.
    #[inline(always)]
    pub fn splat(simd: S, value: f64) -> Self {
        Self {
            simd,
            value: R::splat(simd, value),
        }
    }

    /// `self + a * b`.
    #[inline(always)]
    #[must_use]
    pub fn plus_product(self, a: Self, b: Self) -> Self {
        Self {
            value: R::product_sum(self.simd, a.value, b.value, self.value),
            ..self
        }
    }
}

impl<S: Simd, R: Packed> Add for Pack<S, R> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self {
            value: R::sum(self.simd, self.value, other.value),
            ..self
        }
    }
}

impl<S: Simd, R: Packed> Sub for Pack<S, R> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self {
            value: R::difference(self.simd, self.value, other.value),
            ..self
        }
    }
}

impl<S: Simd, R: Packed> Mul for Pack<S, R> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self {
            value: R::product(self.simd, self.value, other.value),
            ..self
        }
    }
}

impl<S: Simd, R: Packed> Mul<f64> for Pack<S, R> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        self * Self::splat(self.simd, factor)
    }
}

impl<S: Simd, R: Packed> Neg for Pack<S, R> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self {
            value: R::negative(self.simd, self.value),
            ..self
        }
    }
}

impl<S: Simd, R: Packed> AddAssign for Pack<S, R> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<S: Simd> Pack<S> {
    /// The first numbers of `lanes`, as many as of `self`.
    #[inline(always)]
    #[must_use]
    pub fn first_of(self, lanes: &Lanes) -> Self {
        Self::load(self.simd, lanes, 0)
    }

    /// `change` of each number, one after the other.
    #[inline(always)]
    #[must_use]
    pub fn each(self, change: impl Fn(f64) -> f64) -> Self {
        let mut lanes = <Lanes>::zero();
        self.store(&mut lanes, 0);
        for value in &mut lanes.0[..S::F64_LANES] {
            *value = change(*value);
        }
        Self::load(self.simd, &lanes, 0)
    }
}

impl<S: Simd> Number for Pack<S> {
    #[inline(always)]
    fn constant(self, value: f64) -> Self {
        Self::splat(self.simd, value)
    }

    #[inline(always)]
    fn plus_product(self, a: Self, b: Self) -> Self {
        Pack::plus_product(self, a, b)
    }

    #[inline(always)]
    fn inverse(self) -> Self {
        self.each(f64::recip)
    }
}
