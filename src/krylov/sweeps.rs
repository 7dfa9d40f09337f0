//! One step of generalised conjugate residuals in two sweeps over memory. With kept pairs
//! `(d_k, q_k)`, `q_k = A d_k` orthonormal and orthogonal to the residual r, and a new pair
//! `(d, q)`:
//!
//! ```text
//! sweep 1    c_k = q . q_k,   q . q,   q . r
//! between    l^2 = q . q - sum c_k^2,   s = (q . r) / l
//! sweep 2    q = (q - sum c_k q_k) / l,   d = (d - sum c_k d_k) / l
//!            x += s d,   r -= s q,   r . r
//! ```
//!
//! Reads and writes 40 vectors with ten pairs, where one operation after the other takes 51. The
//! square of the length by Pythagoras loses two bits where a quarter of it is left; below that the
//! caller takes its own way. Sums run over a tree of blocks that depends on the length only.

use crate::linalg::vector::{BLOCK, PARALLEL, dot_block};

/// Pairs that one sweep takes.
pub const GROUP: usize = 10;
/// Entries that stay in the innermost cache while all pairs pass by.
const STRIP: usize = 512;

/// What the first sweep finds.
#[derive(Clone, Copy, Debug)]
pub struct Overlaps {
    /// `q . q_k`; zero where there is no pair.
    pub kept: [f64; GROUP],
    /// `q . q`.
    pub square: f64,
    /// `q . r`.
    pub along: f64,
}

impl Overlaps {
    const NONE: Self = Self {
        kept: [0.0; GROUP],
        square: 0.0,
        along: 0.0,
    };

    /// The first sweep; `images` that are missing are empty.
    pub fn of(q: &[f64], r: &[f64], images: &[&[f64]; GROUP]) -> Self {
        if q.len() <= PARALLEL {
            let mut sums = Self::NONE;
            for (block, (q, r)) in q.chunks(BLOCK).zip(r.chunks(BLOCK)).enumerate() {
                sums = sums.with(Self::of_block(q, r, &parts(images, block * BLOCK, q.len())));
            }
            return sums;
        }
        let middle = q.len().div_ceil(2 * BLOCK) * BLOCK;
        let ((q_low, q_high), (r_low, r_high)) = (q.split_at(middle), r.split_at(middle));
        let low = images.map(|image| &image[..middle.min(image.len())]);
        let high = images.map(|image| &image[middle.min(image.len())..]);
        let (low, high) = rayon::join(
            || Self::of(q_low, r_low, &low),
            || Self::of(q_high, r_high, &high),
        );
        low.with(high)
    }

    fn of_block(q: &[f64], r: &[f64], images: &[&[f64]; GROUP]) -> Self {
        Self {
            kept: images.map(|image| dot_block(q, image)),
            square: dot_block(q, q),
            along: dot_block(q, r),
        }
    }

    fn with(self, other: Self) -> Self {
        Self {
            kept: std::array::from_fn(|k| self.kept[k] + other.kept[k]),
            square: self.square + other.square,
            along: self.along + other.along,
        }
    }

    /// The square of what is left of q after the kept images.
    pub fn rest(&self) -> f64 {
        self.square - self.kept.iter().map(|c| c * c).sum::<f64>()
    }
}

/// The vectors that the second sweep changes.
#[derive(Debug)]
pub struct Step<'a> {
    /// d.
    pub direction: &'a mut [f64],
    /// q.
    pub product: &'a mut [f64],
    /// x.
    pub x: &'a mut [f64],
    /// r.
    pub r: &'a mut [f64],
}

/// Kept pairs and what the second sweep takes of them.
#[derive(Clone, Copy, Debug)]
pub struct Combination<'a> {
    /// c.
    pub overlaps: &'a [f64; GROUP],
    /// d_k; empty where there is no pair.
    pub directions: [&'a [f64]; GROUP],
    /// q_k; empty where there is no pair.
    pub images: [&'a [f64]; GROUP],
    /// l.
    pub length: f64,
    /// s.
    pub step: f64,
}

impl Step<'_> {
    /// The second sweep; the square of the new residual.
    pub fn take(self, by: &Combination<'_>) -> f64 {
        if self.r.len() <= PARALLEL {
            return self.take_blocks(by);
        }
        let middle = self.r.len().div_ceil(2 * BLOCK) * BLOCK;
        let (low, high) = self.split_at(middle);
        let (below, above) = by.split_at(middle);
        let (low, high) = rayon::join(|| low.take(&below), || high.take(&above));
        low + high
    }

    fn take_blocks(self, by: &Combination<'_>) -> f64 {
        let mut square = 0.0;
        let vectors = (self.direction.chunks_mut(BLOCK))
            .zip(self.product.chunks_mut(BLOCK))
            .zip(self.x.chunks_mut(BLOCK))
            .zip(self.r.chunks_mut(BLOCK));
        for (block, (((direction, product), x), r)) in vectors.enumerate() {
            let strips = (direction.chunks_mut(STRIP))
                .zip(product.chunks_mut(STRIP))
                .zip(x.chunks_mut(STRIP))
                .zip(r.chunks_mut(STRIP));
            for (strip, (((direction, product), x), r)) in strips.enumerate() {
                let first = block * BLOCK + strip * STRIP;
                combine(direction, by, &by.directions, first);
                combine(product, by, &by.images, first);
                for (x, d) in x.iter_mut().zip(&*direction) {
                    *x += by.step * d;
                }
                for (r, q) in r.iter_mut().zip(&*product) {
                    *r -= by.step * q;
                }
            }
            square += dot_block(r, r);
        }
        square
    }

    fn split_at(self, middle: usize) -> (Self, Self) {
        let (direction, product) = (
            self.direction.split_at_mut(middle),
            self.product.split_at_mut(middle),
        );
        let (x, r) = (self.x.split_at_mut(middle), self.r.split_at_mut(middle));
        let half = |direction, product, x, r| Self {
            direction,
            product,
            x,
            r,
        };
        (
            half(direction.0, product.0, x.0, r.0),
            half(direction.1, product.1, x.1, r.1),
        )
    }
}

impl<'a> Combination<'a> {
    fn split_at(&self, middle: usize) -> (Self, Self) {
        let low = |vector: &'a [f64]| &vector[..middle.min(vector.len())];
        let high = |vector: &'a [f64]| &vector[middle.min(vector.len())..];
        let half = |directions, images| Self {
            directions,
            images,
            ..*self
        };
        (
            half(self.directions.map(low), self.images.map(low)),
            half(self.directions.map(high), self.images.map(high)),
        )
    }
}

/// `y = (y - sum c_k y_k) / l` on entries from `first` on.
fn combine(y: &mut [f64], by: &Combination<'_>, kept: &[&[f64]; GROUP], first: usize) {
    let parts = parts(kept, first, y.len());
    for (factor, part) in by.overlaps.iter().zip(parts) {
        for (value, part) in y.iter_mut().zip(part) {
            *value -= factor * part;
        }
    }
    let scale = 1.0 / by.length;
    y.iter_mut().for_each(|value| *value *= scale);
}

/// The entries `[first, first + length)` of each vector, none of the empty ones.
fn parts<'a>(vectors: &[&'a [f64]; GROUP], first: usize, length: usize) -> [&'a [f64]; GROUP] {
    vectors.map(|vector| {
        let first = first.min(vector.len());
        &vector[first..(first + length).min(vector.len())]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::vector::{dot, norm, reproducible_noise};

    /// Two orthonormal images, a new product and a residual orthogonal to the images.
    fn sample(length: usize) -> ([Vec<f64>; 2], Vec<f64>, Vec<f64>) {
        let noise = reproducible_noise(4 * length);
        let part = |k: usize| noise[k * length..(k + 1) * length].to_vec();
        let mut images = [part(0), part(1)];
        let unit = |v: &mut Vec<f64>| {
            let scale = 1.0 / norm(v);
            v.iter_mut().for_each(|v| *v *= scale);
        };
        let off = |v: &mut Vec<f64>, q: &[f64]| {
            let along = dot(v, q);
            v.iter_mut().zip(q).for_each(|(v, q)| *v -= along * q);
        };
        unit(&mut images[0]);
        let first = images[0].clone();
        off(&mut images[1], &first);
        unit(&mut images[1]);
        let mut r = part(2);
        images.iter().for_each(|image| off(&mut r, image));
        (images, part(3), r)
    }

    #[test]
    fn a_step_in_two_sweeps_is_the_step_of_its_definition() {
        for length in [7, 5000, 100_003] {
            let ([first, second], product, residual) = sample(length);
            let mut images: [&[f64]; GROUP] = [&[]; GROUP];
            (images[0], images[1]) = (&first, &second);
            // The direction is twice its product, for the kept pairs too.
            let doubled: Vec<Vec<f64>> = images
                .iter()
                .map(|q| q.iter().map(|q| 2.0 * q).collect())
                .collect();
            let directions = std::array::from_fn(|k| &doubled[k][..]);
            let overlaps = Overlaps::of(&product, &residual, &images);
            let length_left = overlaps.rest().sqrt();
            let by = Combination {
                overlaps: &overlaps.kept,
                directions,
                images,
                length: length_left,
                step: overlaps.along / length_left,
            };
            let mut d: Vec<f64> = product.iter().map(|q| 2.0 * q).collect();
            let (mut q, mut x, mut r) = (product, vec![0.0; length], residual.clone());
            let square = Step {
                direction: &mut d,
                product: &mut q,
                x: &mut x,
                r: &mut r,
            }
            .take(&by);
            assert!((norm(&q) - 1.0).abs() < 1e-12);
            assert!(dot(&q, &first).abs() + dot(&q, &second).abs() < 1e-12);
            assert!(dot(&q, &r).abs() < 1e-12 * norm(&residual));
            assert!((square - dot(&r, &r)).abs() <= 1e-14 * square);
            for ((x, r), old) in x.iter().zip(&r).zip(&residual) {
                assert!((0.5 * x + r - old).abs() < 1e-13);
            }
        }
    }

    #[test]
    fn sweeps_have_the_same_bits_for_every_number_of_threads() {
        let ([first, _], product, residual) = sample(100_003);
        let mut images: [&[f64]; GROUP] = [&[]; GROUP];
        images[0] = &first;
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .expect("a pool of a few threads");
            let overlaps = pool.install(|| Overlaps::of(&product, &residual, &images));
            let by = Combination {
                overlaps: &overlaps.kept,
                directions: images,
                images,
                length: overlaps.rest().sqrt(),
                step: 0.5,
            };
            let [mut d, mut q, mut x, mut r] =
                [&product, &product, &residual, &residual].map(|vector: &Vec<f64>| vector.clone());
            let step = Step {
                direction: &mut d,
                product: &mut q,
                x: &mut x,
                r: &mut r,
            };
            let square = pool.install(|| step.take(&by));
            [d, q, x, r, vec![square]].map(|v| v.iter().map(|v| v.to_bits()).collect::<Vec<_>>())
        };
        assert_eq!(with(1), with(3));
    }
}
