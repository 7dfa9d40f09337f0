//! Vector kernels. Reductions sum over blocks of fixed length and then over
//! a tree that depends on the length only: the same bits for every number of
//! threads, and nothing allocated.

use crate::parallel::{self, Pieces};

/// Entries per block of a reduction.
pub(crate) const BLOCK: usize = 4096;
/// Shorter vectors are not worth a second thread.
pub(crate) const PARALLEL: usize = 8 * BLOCK;

/// `x . y` of one block, the shorter one's entries.
pub(crate) fn dot_block(x: &[f64], y: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (x8, x_rest) = x.as_chunks::<8>();
    let (y8, y_rest) = y.as_chunks::<8>();
    for (a, b) in x8.iter().zip(y8) {
        for lane in 0..8 {
            sums[lane] += a[lane] * b[lane];
        }
    }
    let rest: f64 = x_rest.iter().zip(y_rest).map(|(a, b)| a * b).sum();
    ((sums[0] + sums[4]) + (sums[1] + sums[5])) + ((sums[2] + sums[6]) + (sums[3] + sums[7])) + rest
}

/// `x . y`, summed over a fixed tree of blocks.
pub fn dot(x: &[f64], y: &[f64]) -> f64 {
    debug_assert_eq!(x.len(), y.len());
    if x.len() <= PARALLEL {
        return x
            .chunks(BLOCK)
            .zip(y.chunks(BLOCK))
            .map(|(a, b)| dot_block(a, b))
            .sum();
    }
    let middle = x.len().div_ceil(2 * BLOCK) * BLOCK;
    let ((x_low, x_high), (y_low, y_high)) = (x.split_at(middle), y.split_at(middle));
    let (low, high) = rayon::join(|| dot(x_low, y_low), || dot(x_high, y_high));
    low + high
}

/// Euclidean norm.
pub fn norm(x: &[f64]) -> f64 {
    dot(x, x).sqrt()
}

fn zip_blocks(y: &mut [f64], x: &[f64], kernel: impl Fn(&mut [f64], &[f64]) + Sync) {
    debug_assert_eq!(x.len(), y.len());
    if y.len() < PARALLEL {
        kernel(y, x);
    } else {
        parallel::each(Pieces::of(y, BLOCK), 1, &|k, y| {
            kernel(y, &x[k * BLOCK..][..y.len()]);
        });
    }
}

/// `y = x`.
pub fn assign(y: &mut [f64], x: &[f64]) {
    zip_blocks(y, x, <[f64]>::copy_from_slice);
}

/// `y += a x`.
pub fn add_scaled(y: &mut [f64], a: f64, x: &[f64]) {
    zip_blocks(y, x, |y, x| {
        for (b, v) in y.iter_mut().zip(x) {
            *b += a * v;
        }
    });
}

/// `y = x + a y`.
pub fn scale_and_add(y: &mut [f64], a: f64, x: &[f64]) {
    zip_blocks(y, x, |y, x| {
        for (b, v) in y.iter_mut().zip(x) {
            *b = v + a * *b;
        }
    });
}

/// `y = x - y`.
pub fn subtract_from(y: &mut [f64], x: &[f64]) {
    scale_and_add(y, -1.0, x);
}

/// `y *= x` entry by entry.
pub fn multiply(y: &mut [f64], x: &[f64]) {
    zip_blocks(y, x, |y, x| {
        for (b, v) in y.iter_mut().zip(x) {
            *b *= v;
        }
    });
}

/// `y *= a`.
pub fn scale(y: &mut [f64], a: f64) {
    let kernel = |_, y: &mut [f64]| y.iter_mut().for_each(|v| *v *= a);
    if y.len() < PARALLEL {
        kernel(0, y)
    } else {
        parallel::each(Pieces::of(y, BLOCK), 1, &kernel)
    }
}

/// `x . y_k` for each of `ys`, with one sweep over `x`; the same bits as
/// [`dot`].
pub fn dots<const K: usize>(x: &[f64], ys: &[&[f64]; K]) -> [f64; K] {
    if x.len() <= PARALLEL {
        let mut sums = [0.0; K];
        for (block, x) in x.chunks(BLOCK).enumerate() {
            for (sum, y) in sums.iter_mut().zip(ys) {
                let first = (block * BLOCK).min(y.len());
                let y = &y[first..(first + x.len()).min(y.len())];
                *sum += dot_block(x, y);
            }
        }
        return sums;
    }
    let middle = x.len().div_ceil(2 * BLOCK) * BLOCK;
    let (x_low, x_high) = x.split_at(middle);
    let low = ys.map(|y| &y[..middle.min(y.len())]);
    let high = ys.map(|y| &y[middle.min(y.len())..]);
    let (low, high) = rayon::join(|| dots(x_low, &low), || dots(x_high, &high));
    std::array::from_fn(|k| low[k] + high[k])
}

/// `y -= sum_k a_k x_k` with one sweep over `y`; empty vectors are left out.
pub fn subtract_combination<const K: usize>(y: &mut [f64], a: &[f64; K], xs: &[&[f64]; K]) {
    let kernel = |block: usize, y: &mut [f64]| {
        let first = block * BLOCK;
        for (factor, x) in a.iter().zip(xs).filter(|(_, x)| !x.is_empty()) {
            for (value, x) in y.iter_mut().zip(&x[first..]) {
                *value -= factor * x;
            }
        }
    };
    if y.len() < PARALLEL {
        let pieces = y.chunks_mut(BLOCK).enumerate();
        pieces.for_each(|(block, y)| kernel(block, y))
    } else {
        parallel::each(Pieces::of(y, BLOCK), 1, &kernel)
    }
}

/// Largest absolute entry; zero for an empty vector, not a number if an entry
/// is not.
pub fn largest(x: &[f64]) -> f64 {
    if x.iter().any(|v| v.is_nan()) {
        f64::NAN
    } else {
        x.iter().fold(0.0, |m, v| v.abs().max(m))
    }
}

/// The largest power of two that is not above a positive `value`.
pub fn power_of_two_below(value: f64) -> f64 {
    const EXPONENT: u64 = 0x7FF0_0000_0000_0000;
    f64::from_bits(value.to_bits() & EXPONENT).max(f64::MIN_POSITIVE)
}

/// value / scale; zero where there is nothing to scale, not a number where one of
/// them is not.
pub fn ratio(value: f64, scale: f64) -> f64 {
    if value == 0.0 && !scale.is_nan() {
        0.0
    } else if scale < f64::MIN_POSITIVE {
        value / f64::MIN_POSITIVE
    } else {
        value / scale
    }
}

/// The largest of values that are zero at best; not a number if one is not.
pub fn worst(values: &[f64]) -> f64 {
    if values.iter().any(|value| value.is_nan()) {
        f64::NAN
    } else {
        values.iter().copied().fold(0.0, f64::max)
    }
}

/// A fixed vector that excites all modes: entries in `[-1, 1]` from a linear
/// congruential sequence, the same in every run.
pub fn reproducible_noise(length: usize) -> Vec<f64> {
    let mut state = 0x9E37_79B9_7F4A_7C15_u64;
    (0..length)
        .map(|_| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reductions_have_the_same_bits_for_every_number_of_threads() {
        let x = reproducible_noise(100_003);
        let y: Vec<f64> = x.iter().rev().copied().collect();
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .expect("a pool of a few threads");
            pool.install(|| dot(&x, &y))
        };
        assert_eq!(with(1).to_bits(), with(3).to_bits());
        let plain: f64 = x.iter().zip(&y).map(|(a, b)| a * b).sum();
        assert!((with(2) - plain).abs() < 1e-9);
    }

    #[test]
    fn several_products_have_the_bits_of_one_each() {
        for length in [0, 7, 5000, 100_003] {
            let x = reproducible_noise(length);
            let y: Vec<f64> = x.iter().rev().copied().collect();
            let [first, second, none] = dots(&x, &[&x, &y, &[]]);
            // An empty sum is a zero of either sign.
            assert_eq!(first.to_bits(), (0.0 + dot(&x, &x)).to_bits());
            assert_eq!(second.to_bits(), (0.0 + dot(&x, &y)).to_bits());
            assert!(none.abs() < f64::MIN_POSITIVE);
        }
    }

    #[test]
    fn a_combination_is_taken_off_at_once() {
        for length in [7, 40_000] {
            let x = reproducible_noise(length);
            let y: Vec<f64> = x.iter().rev().copied().collect();
            let mut z = vec![1.0; length];
            subtract_combination(&mut z, &[2.0, -0.5, 3.0], &[&x, &y, &[]]);
            for ((z, x), y) in z.iter().zip(&x).zip(&y) {
                assert!((z - (1.0 - 2.0 * x + 0.5 * y)).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn updates_match_their_definition() {
        let x = reproducible_noise(40_000);
        let mut y = vec![1.0; 40_000];
        add_scaled(&mut y, 2.0, &x);
        scale_and_add(&mut y, 0.5, &x);
        for (value, &v) in y.iter().zip(&x) {
            assert!((value - (v + 0.5 * (1.0 + 2.0 * v))).abs() < 1e-15);
        }
    }
}
