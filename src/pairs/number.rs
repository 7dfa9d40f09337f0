//! Numbers that carry their derivatives: forward-mode automatic differentiation of first and
//! second order, written once for every formula of this room.
//!
//! ```text
//! value v, first derivatives g_i [N], second derivatives h_ij [N][N], j <= i
//! (v w)_ij = v w_ij + w v_ij + v_i w_j + w_i v_j
//! ```
//!
//! Derivatives by N inputs are exact but for rounding: no step is chosen. Where a number is the root
//! of an equation, two steps of Newton's method from its value in these numbers give its derivatives
//! of both orders. Reference: A. Griewank and A. Walther, *Evaluating Derivatives* (2008), chapter 13.
//! Cost: of a product 2 N flops to first order, some 2.5 N^2 to second.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A real number, alone or with its derivatives.
pub trait Number:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// Steps of Newton's method, from the value of a root, that give all derivatives that are carried.
    const STEPS: usize;

    /// A number that depends on no input.
    fn constant(value: f64) -> Self;

    /// The value alone.
    fn value(&self) -> f64;

    /// The square root of a positive number.
    fn sqrt(self) -> Self;

    /// The number times one without derivatives.
    fn times(self, factor: f64) -> Self;
}

impl Number for f64 {
    const STEPS: usize = 1;

    fn constant(value: f64) -> Self {
        value
    }

    fn value(&self) -> f64 {
        *self
    }

    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }

    fn times(self, factor: f64) -> Self {
        factor * self
    }
}

/// A number with its first derivatives by `N` inputs.
#[derive(Clone, Copy, Debug)]
pub struct First<const N: usize> {
    /// Its value.
    pub value: f64,
    /// Derivatives by the inputs.
    pub first: [f64; N],
}

/// A number with its first and second derivatives by `N` inputs.
#[derive(Clone, Copy, Debug)]
pub struct Second<const N: usize> {
    /// Its value.
    pub value: f64,
    /// Derivatives by the inputs.
    pub first: [f64; N],
    /// Second derivatives, of which the lower triangle is kept `[N][N]`.
    pub second: [[f64; N]; N],
}

impl<const N: usize> First<N> {
    /// Input number `index`.
    pub fn input(index: usize, value: f64) -> Self {
        let mut input = Self::constant(value);
        if let Some(own) = input.first.get_mut(index) {
            *own = 1.0;
        }
        input
    }

    /// f of the number, from its value and slope there.
    fn chained(mut self, [value, slope]: [f64; 2]) -> Self {
        self.value = value;
        self.first.iter_mut().for_each(|x| *x *= slope);
        self
    }
}

impl<const N: usize> Second<N> {
    /// Input number `index`.
    pub fn input(index: usize, value: f64) -> Self {
        let mut input = Self::constant(value);
        if let Some(own) = input.first.get_mut(index) {
            *own = 1.0;
        }
        input
    }

    /// Second derivative by two inputs.
    pub fn second_by(&self, i: usize, j: usize) -> f64 {
        self.second[i.max(j)][i.min(j)]
    }

    /// f of the number, from its value, slope and bend there.
    fn chained(mut self, [value, slope, bend]: [f64; 3]) -> Self {
        for i in 0..N {
            let along = bend * self.first[i];
            for (entry, first) in self.second[i][..=i].iter_mut().zip(&self.first) {
                *entry = slope * *entry + along * first;
            }
        }
        self.first.iter_mut().for_each(|x| *x *= slope);
        self.value = value;
        self
    }

    /// `own` times the number plus `others` times another, and their values' sum.
    fn combined(mut self, other: &Self, [own, others]: [f64; 2]) -> Self {
        self.value = own * self.value + others * other.value;
        for i in 0..N {
            self.first[i] = own * self.first[i] + others * other.first[i];
            let entries = self.second[i][..=i].iter_mut().zip(&other.second[i]);
            entries.for_each(|(entry, one)| *entry = own * *entry + others * one);
        }
        self
    }
}

impl<const N: usize> Number for First<N> {
    const STEPS: usize = 1;

    fn constant(value: f64) -> Self {
        Self {
            value,
            first: [0.0; N],
        }
    }

    fn value(&self) -> f64 {
        self.value
    }

    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chained([root, 0.5 / root])
    }

    fn times(mut self, factor: f64) -> Self {
        self.value *= factor;
        self.first.iter_mut().for_each(|x| *x *= factor);
        self
    }
}

impl<const N: usize> Number for Second<N> {
    const STEPS: usize = 2;

    fn constant(value: f64) -> Self {
        Self {
            value,
            first: [0.0; N],
            second: [[0.0; N]; N],
        }
    }

    fn value(&self) -> f64 {
        self.value
    }

    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chained([root, 0.5 / root, -0.25 / (root * self.value)])
    }

    fn times(mut self, factor: f64) -> Self {
        self.value *= factor;
        for i in 0..N {
            self.first[i] *= factor;
            self.second[i][..=i].iter_mut().for_each(|x| *x *= factor);
        }
        self
    }
}

impl<const N: usize> Add for First<N> {
    type Output = Self;

    fn add(mut self, other: Self) -> Self {
        self.value += other.value;
        (0..N).for_each(|i| self.first[i] += other.first[i]);
        self
    }
}

impl<const N: usize> Sub for First<N> {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl<const N: usize> Neg for First<N> {
    type Output = Self;

    fn neg(self) -> Self {
        self.times(-1.0)
    }
}

impl<const N: usize> First<N> {
    /// By the rule of products.
    fn product(mut self, other: &Self) -> Self {
        let (own, others) = (self.value, other.value);
        (0..N).for_each(|i| self.first[i] = others * self.first[i] + own * other.first[i]);
        self.value *= others;
        self
    }
}

impl<const N: usize> Mul for First<N> {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        self.product(&other)
    }
}

impl<const N: usize> Div for First<N> {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        let inverse = other.value.recip();
        self * other.chained([inverse, -inverse * inverse])
    }
}

impl<const N: usize> Add for Second<N> {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        self.combined(&other, [1.0, 1.0])
    }
}

impl<const N: usize> Sub for Second<N> {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self.combined(&other, [1.0, -1.0])
    }
}

impl<const N: usize> Neg for Second<N> {
    type Output = Self;

    fn neg(self) -> Self {
        self.times(-1.0)
    }
}

impl<const N: usize> Second<N> {
    /// By the rule of products.
    fn product(mut self, other: &Self) -> Self {
        let (own, others) = (self.value, other.value);
        for i in 0..N {
            let (first, second) = (self.first[i], other.first[i]);
            let row = self.second[i][..=i].iter_mut().zip(&other.second[i]);
            let firsts = self.first.iter().zip(&other.first);
            for ((entry, one), (a, b)) in row.zip(firsts) {
                *entry = others * *entry + own * one + first * b + second * a;
            }
        }
        (0..N).for_each(|i| self.first[i] = others * self.first[i] + own * other.first[i]);
        self.value *= others;
        self
    }
}

impl<const N: usize> Mul for Second<N> {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        self.product(&other)
    }
}

impl<const N: usize> Div for Second<N> {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        let inverse = other.value.recip();
        let square = inverse * inverse;
        self * other.chained([inverse, -square, 2.0 * square * inverse])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// sqrt(x^2 y + 1) / (x - y) - x y, without and with derivatives.
    fn formula<T: Number>(x: T, y: T) -> T {
        (x * x * y + T::constant(1.0)).sqrt() / (x - y) - (x * y).times(0.5)
    }

    const AT: [f64; 2] = [1.3, 0.4];

    #[test]
    fn values_are_those_of_plain_numbers() {
        let plain = formula(AT[0], AT[1]);
        let first = formula(First::<2>::input(0, AT[0]), First::input(1, AT[1]));
        let second = formula(Second::<2>::input(0, AT[0]), Second::input(1, AT[1]));
        assert!((first.value - plain).abs() < 1e-15 && (second.value - plain).abs() < 1e-15);
    }

    #[test]
    fn derivatives_are_those_of_differences() {
        let second = formula(Second::<2>::input(0, AT[0]), Second::input(1, AT[1]));
        let h = 1e-5;
        for i in 0..2 {
            let moved = |by: f64| {
                let at = [0, 1].map(|k| AT[k] + if k == i { by } else { 0.0 });
                formula(First::<2>::input(0, at[0]), First::input(1, at[1]))
            };
            let (before, after) = (moved(-h), moved(h));
            let slope = (after.value - before.value) / (2.0 * h);
            assert!((second.first[i] - slope).abs() < 1e-9);
            for j in 0..2 {
                let bend = (after.first[j] - before.first[j]) / (2.0 * h);
                assert!((second.second_by(i, j) - bend).abs() < 1e-8, "{i} {j}");
                assert!((second.first[j] - 0.5 * (after.first[j] + before.first[j])).abs() < 1e-8);
            }
        }
    }

    #[test]
    fn a_root_has_its_derivatives_after_two_steps() {
        // y^3 + a y = 2 at a = 1: y = 1, y' = -y / (3 y^2 + a), y'' by the same rule.
        let a = Second::<1>::input(0, 1.0);
        let mut y = Second::constant(1.0);
        for _ in 0..2 {
            let residual = y * y * y + a * y - Second::constant(2.0);
            y = y - residual / ((y * y).times(3.0) + a);
        }
        assert!((y.first[0] + 0.25).abs() < 1e-15);
        // y'' = -(6 y y'^2 + 2 y') / (3 y^2 + a).
        assert!((y.second_by(0, 0) - 0.03125).abs() < 1e-15, "{y:?}");
    }
}
