//! Vector kernels. Reductions sum over blocks of fixed length and then over
//! a tree that depends on the length only: the same bits for every number of
//! threads, and nothing allocated.

use rayon::prelude::*;

/// Entries per block of a reduction.
const BLOCK: usize = 4096;
/// Shorter vectors are not worth a second thread.
const PARALLEL: usize = 8 * BLOCK;

fn dot_block(x: &[f64], y: &[f64]) -> f64 {
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
        y.par_chunks_mut(BLOCK)
            .zip(x.par_chunks(BLOCK))
            .for_each(|(b, a)| kernel(b, a));
    }
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
    y.iter_mut().for_each(|v| *v *= a);
}

/// Largest absolute entry; zero for an empty vector, not a number if an entry
/// is not.
pub fn largest(x: &[f64]) -> f64 {
    match x.iter().any(|v| v.is_nan()) {
        true => f64::NAN,
        false => x.iter().fold(0.0, |m, v| v.abs().max(m)),
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
