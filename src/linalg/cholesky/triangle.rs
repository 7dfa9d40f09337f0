//! Triangular solves with the entries of one supernode, w columns of w + r rows each: a lower
//! triangle T, whose upper part is not read, and a rest L.
//!
//! Four columns at a time, so that vectors are read and written once for four; what is left of
//! the time is that of reading the entries. Runs with the widest registers of the machine.

use pulp::{Simd, WithSimd};

use crate::linalg::Scalar;

/// Columns at a time.
const COLUMNS: usize = 4;
/// Partial sums of an inner product; one order for every instruction set.
const LANES: usize = 16;

/// A number that factors are made of and divided by.
pub(super) trait Factor: Scalar + std::ops::Div<Output = Self> {}

impl Factor for f32 {}
impl Factor for f64 {}

/// `x = T^-1 x`, `below -= L x`.
pub(super) fn solve_lower<T: Factor>(entries: &[T], x: &mut [T], below: &mut [T]) {
    pulp::Arch::new().dispatch(Lower { entries, x, below });
}

/// `x = T^-T (x - L^T below)`.
pub(super) fn solve_upper<T: Factor>(entries: &[T], x: &mut [T], below: &[T]) {
    pulp::Arch::new().dispatch(Upper { entries, x, below });
}

struct Lower<'a, T> {
    entries: &'a [T],
    x: &'a mut [T],
    below: &'a mut [T],
}

/// A method and not a closure: only a method is sure to be inlined where the registers are known.
impl<T: Factor> WithSimd for Lower<'_, T> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        lower(self.entries, self.x, self.below);
    }
}

struct Upper<'a, T> {
    entries: &'a [T],
    x: &'a mut [T],
    below: &'a [T],
}

impl<T: Factor> WithSimd for Upper<'_, T> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        upper(self.entries, self.x, self.below);
    }
}

#[inline(always)]
fn lower<T: Factor>(entries: &[T], x: &mut [T], below: &mut [T]) {
    let (width, height) = (x.len(), x.len() + below.len());
    let mut columns = entries.chunks_exact(height.max(1));
    for first in (0..width).step_by(COLUMNS) {
        let last = (first + COLUMNS).min(width);
        let (solved, rest) = x.split_at_mut(last);
        let solved = &mut solved[first..];
        // Columns that are missing take nothing off.
        let mut four = [(T::default(), &entries[..height]); COLUMNS];
        for (index, ((factor, place), column)) in four.iter_mut().zip(&mut columns).enumerate() {
            let own = &column[first..last];
            let value = solved[index] / own[index];
            solved[index] = value;
            for (later, entry) in solved.iter_mut().zip(own).skip(index + 1) {
                *later -= *entry * value;
            }
            (*factor, *place) = (value, column);
            if first + index + 1 == last {
                break;
            }
        }
        subtract_columns(
            rest,
            four.map(|(factor, column)| (factor, &column[last..width])),
        );
        subtract_columns(
            below,
            four.map(|(factor, column)| (factor, &column[width..])),
        );
    }
}

/// `y -= sum of factors times columns`.
#[inline(always)]
fn subtract_columns<T: Factor>(y: &mut [T], columns: [(T, &[T]); COLUMNS]) {
    let [a, b, c, d] = columns.map(|(factor, _)| factor);
    let [p, q, r, s] = columns.map(|(_, column)| &column[..y.len()]);
    for ((((y, p), q), r), s) in y.iter_mut().zip(p).zip(q).zip(r).zip(s) {
        *y -= (*p * a + *q * b) + (*r * c + *s * d);
    }
}

#[inline(always)]
fn upper<T: Factor>(entries: &[T], x: &mut [T], below: &[T]) {
    let (width, height) = (x.len(), x.len() + below.len());
    for first in (0..width).step_by(COLUMNS).rev() {
        let last = (first + COLUMNS).min(width);
        let column = |index: usize| &entries[(first + index).min(width - 1) * height..][..height];
        let columns: [&[T]; COLUMNS] = std::array::from_fn(column);
        let beside = inner_products(&x[last..], columns.map(|column| &column[last..width]));
        let lower = inner_products(below, columns.map(|column| &column[width..]));
        for index in (0..last - first).rev() {
            let own = &columns[index][first..last];
            let mut value = x[first + index] - beside[index] - lower[index];
            for (later, entry) in x[first..last].iter().zip(own).skip(index + 1) {
                value -= *entry * *later;
            }
            x[first + index] = value / own[index];
        }
    }
}

/// `y . column` of each.
#[inline(always)]
fn inner_products<T: Factor>(y: &[T], columns: [&[T]; COLUMNS]) -> [T; COLUMNS] {
    let mut sums = [[T::default(); LANES]; COLUMNS];
    let (whole, rest) = y.as_chunks::<LANES>();
    let parts = columns.map(|column| column[..y.len()].as_chunks::<LANES>());
    for (index, y) in whole.iter().enumerate() {
        for (sums, (part, _)) in sums.iter_mut().zip(&parts) {
            let part = &part[index];
            for lane in 0..LANES {
                sums[lane] += part[lane] * y[lane];
            }
        }
    }
    let mut out = sums.map(|lanes| {
        lanes
            .into_iter()
            .fold(T::default(), |sum, value| sum + value)
    });
    for (out, (_, part)) in out.iter_mut().zip(&parts) {
        for (part, y) in part.iter().zip(rest) {
            *out += *part * *y;
        }
    }
    out
}
