//! Numbers that move together, one per element of a batch, in the vector
//! registers of whatever instruction set runs (pulp's `Simd`).

use std::ops::{Add, AddAssign, Mul, Neg, Sub};

use pulp::Simd;

use crate::geometry::tensor::Number;

/// Elements per batch; a multiple of every register width.
pub const WIDTH: usize = 8;

/// Eight numbers in memory.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub struct Lanes(pub [f64; WIDTH]);

impl Lanes {
    /// All zero.
    pub const ZERO: Self = Self([0.0; WIDTH]);
}

/// One register of numbers.
#[derive(Clone, Copy)]
pub struct Pack<S: Simd> {
    simd: S,
    value: S::f64s,
}

impl<S: Simd> Pack<S> {
    /// Registers per batch.
    pub const PARTS: usize = WIDTH / S::F64_LANES;

    /// Part `part` of eight numbers.
    #[inline(always)]
    pub fn load(simd: S, lanes: &Lanes, part: usize) -> Self {
        Self {
            simd,
            value: S::as_simd_f64s(&lanes.0).0[part],
        }
    }

    /// Writes part `part` of eight numbers.
    #[inline(always)]
    pub fn store(self, lanes: &mut Lanes, part: usize) {
        S::as_mut_simd_f64s(&mut lanes.0).0[part] = self.value;
    }

    /// The same number everywhere.
    #[inline(always)]
    pub fn splat(simd: S, value: f64) -> Self {
        Self {
            simd,
            value: simd.splat_f64s(value),
        }
    }

    /// `self + a * b`.
    #[inline(always)]
    #[must_use]
    pub fn plus_product(self, a: Self, b: Self) -> Self {
        Self {
            value: self.simd.mul_add_e_f64s(a.value, b.value, self.value),
            ..self
        }
    }
}

impl<S: Simd> Add for Pack<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self {
            value: self.simd.add_f64s(self.value, other.value),
            ..self
        }
    }
}

impl<S: Simd> Sub for Pack<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self {
            value: self.simd.sub_f64s(self.value, other.value),
            ..self
        }
    }
}

impl<S: Simd> Mul for Pack<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self {
            value: self.simd.mul_f64s(self.value, other.value),
            ..self
        }
    }
}

impl<S: Simd> Mul<f64> for Pack<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        self * Self::splat(self.simd, factor)
    }
}

impl<S: Simd> Neg for Pack<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self {
            value: self.simd.neg_f64s(self.value),
            ..self
        }
    }
}

impl<S: Simd> AddAssign for Pack<S> {
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
        let mut lanes = Lanes::ZERO;
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
