//! Between nodes and lanes: eight nodes of four numbers each become four
//! registers of eight lanes, and back; sixteen in single precision.
//!
//! Written with shuffles where the processor has them: numbers written one by
//! one and read as a whole register wait for each other.

use pulp::Simd;

use super::lanes::{Lanes, Packed, SINGLE_WIDTH, WIDTH};
use crate::linalg::Scalar;

/// The numbers of one node: displacement, then pressure in the last place.
pub type Row<R = f64> = [R; 4];

/// Transposes with the registers of one instruction set.
pub trait Transpose: Copy {
    /// Number `i` of all rows in lanes `i`.
    fn to_lanes(self, rows: [&Row; WIDTH]) -> [Lanes; 4];
    /// The rows again.
    fn to_rows(self, lanes: &[Lanes; 4]) -> [Row; WIDTH];
    /// [`Self::to_lanes`] in single precision.
    fn to_single_lanes(self, rows: [&Row<f32>; SINGLE_WIDTH]) -> [Single; 4];
    /// [`Self::to_rows`] in single precision.
    fn to_single_rows(self, lanes: &[Single; 4]) -> [Row<f32>; SINGLE_WIDTH];
}

/// The numbers of a batch in single precision.
type Single = Lanes<f32, SINGLE_WIDTH>;

/// A batch of W numbers with the shuffles between nodes and lanes.
pub trait Batched<const W: usize>: Packed {
    /// Number `i` of all rows in lanes `i`.
    fn to_lanes<T: Transpose>(transpose: T, rows: [&Row<Self>; W]) -> [Lanes<Self, W>; 4];
    /// The rows again.
    fn to_rows<T: Transpose>(transpose: T, lanes: &[Lanes<Self, W>; 4]) -> [Row<Self>; W];

    /// Registers of a batch.
    #[inline(always)]
    fn parts<S: Simd>() -> usize {
        W / Self::lanes::<S>()
    }
}

impl Batched<WIDTH> for f64 {
    #[inline(always)]
    fn to_lanes<T: Transpose>(transpose: T, rows: [&Row; WIDTH]) -> [Lanes; 4] {
        transpose.to_lanes(rows)
    }

    #[inline(always)]
    fn to_rows<T: Transpose>(transpose: T, lanes: &[Lanes; 4]) -> [Row; WIDTH] {
        transpose.to_rows(lanes)
    }
}

impl Batched<SINGLE_WIDTH> for f32 {
    #[inline(always)]
    fn to_lanes<T: Transpose>(
        transpose: T,
        rows: [&Row<f32>; SINGLE_WIDTH],
    ) -> [Lanes<f32, SINGLE_WIDTH>; 4] {
        transpose.to_single_lanes(rows)
    }

    #[inline(always)]
    fn to_rows<T: Transpose>(
        transpose: T,
        lanes: &[Lanes<f32, SINGLE_WIDTH>; 4],
    ) -> [Row<f32>; SINGLE_WIDTH] {
        transpose.to_single_rows(lanes)
    }
}

/// Number `i` of all rows in lanes `i`, one by one.
#[inline(always)]
fn lanes_of<R: Scalar, const W: usize>(rows: [&Row<R>; W]) -> [Lanes<R, W>; 4] {
    let mut out = [Lanes::zero(); 4];
    for lane in 0..W {
        for i in 0..4 {
            out[i].0[lane] = rows[lane][i];
        }
    }
    out
}

/// The rows again, one by one.
#[inline(always)]
fn rows_of<R: Scalar, const W: usize>(lanes: &[Lanes<R, W>; 4]) -> [Row<R>; W] {
    let mut out = [[R::default(); 4]; W];
    for lane in 0..W {
        for i in 0..4 {
            out[lane][i] = lanes[i].0[lane];
        }
    }
    out
}

impl Transpose for pulp::Scalar {
    #[inline(always)]
    fn to_lanes(self, rows: [&Row; WIDTH]) -> [Lanes; 4] {
        lanes_of(rows)
    }

    #[inline(always)]
    fn to_rows(self, lanes: &[Lanes; 4]) -> [Row; WIDTH] {
        rows_of(lanes)
    }

    #[inline(always)]
    fn to_single_lanes(self, rows: [&Row<f32>; SINGLE_WIDTH]) -> [Single; 4] {
        lanes_of(rows)
    }

    #[inline(always)]
    fn to_single_rows(self, lanes: &[Single; 4]) -> [Row<f32>; SINGLE_WIDTH] {
        rows_of(lanes)
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use std::arch::x86_64::{__m128, __m256, __m256d, __m512, __m512d, __m512i};

    use pulp::bytemuck::cast;
    use pulp::x86::{V3, V4};

    use super::{Lanes, Row, SINGLE_WIDTH, Single, Transpose, WIDTH};

    impl Transpose for V3 {
        #[inline(always)]
        fn to_lanes(self, rows: [&Row; WIDTH]) -> [Lanes; 4] {
            let mut registers: [__m256d; WIDTH] = [cast(*rows[0]); WIDTH];
            for (register, row) in registers.iter_mut().zip(rows) {
                *register = cast(*row);
            }
            let [a, b, c, d, e, f, g, h] = registers;
            let (low, high) = (square(self, [a, b, c, d]), square(self, [e, f, g, h]));
            let mut out = [Lanes::zero(); 4];
            for ((lanes, low), high) in out.iter_mut().zip(low).zip(high) {
                *lanes = Lanes(cast([low, high]));
            }
            out
        }

        #[inline(always)]
        fn to_rows(self, lanes: &[Lanes; 4]) -> [Row; WIDTH] {
            let mut halves: [[__m256d; 4]; 2] = [[cast([0.0_f64; 4]); 4]; 2];
            for (i, lanes) in lanes.iter().enumerate() {
                [halves[0][i], halves[1][i]] = cast(lanes.0);
            }
            let [low, high] = halves;
            cast([square(self, low), square(self, high)])
        }

        #[inline(always)]
        fn to_single_lanes(self, rows: [&Row<f32>; SINGLE_WIDTH]) -> [Single; 4] {
            let avx = self.avx;
            let pair = |i: usize| -> __m256 {
                let (lower, upper): (__m128, __m128) = (cast(*rows[i]), cast(*rows[i + 4]));
                avx._mm256_insertf128_ps::<1>(avx._mm256_castps128_ps256(lower), upper)
            };
            let low = squares(self, [pair(0), pair(1), pair(2), pair(3)]);
            let high = squares(self, [pair(8), pair(9), pair(10), pair(11)]);
            [
                Lanes(cast([low[0], high[0]])),
                Lanes(cast([low[1], high[1]])),
                Lanes(cast([low[2], high[2]])),
                Lanes(cast([low[3], high[3]])),
            ]
        }

        #[inline(always)]
        fn to_single_rows(self, lanes: &[Single; 4]) -> [Row<f32>; SINGLE_WIDTH] {
            let [x, y, z, w] = lanes;
            let ([x0, x1], [y0, y1]): ([__m256; 2], [__m256; 2]) = (cast(x.0), cast(y.0));
            let ([z0, z1], [w0, w1]): ([__m256; 2], [__m256; 2]) = (cast(z.0), cast(w.0));
            let low: [[Row<f32>; 2]; 4] = cast(squares(self, [x0, y0, z0, w0]));
            let high: [[Row<f32>; 2]; 4] = cast(squares(self, [x1, y1, z1, w1]));
            let [[r0, r4], [r1, r5], [r2, r6], [r3, r7]] = low;
            let [[s0, s4], [s1, s5], [s2, s6], [s3, s7]] = high;
            [
                r0, r1, r2, r3, r4, r5, r6, r7, s0, s1, s2, s3, s4, s5, s6, s7,
            ]
        }
    }

    /// The transposes of four rows of four in each half.
    #[inline(always)]
    fn squares(simd: V3, [a, b, c, d]: [__m256; 4]) -> [__m256; 4] {
        let avx = simd.avx;
        let (low_ab, high_ab) = (avx._mm256_unpacklo_ps(a, b), avx._mm256_unpackhi_ps(a, b));
        let (low_cd, high_cd) = (avx._mm256_unpacklo_ps(c, d), avx._mm256_unpackhi_ps(c, d));
        [
            avx._mm256_shuffle_ps::<0x44>(low_ab, low_cd),
            avx._mm256_shuffle_ps::<0xEE>(low_ab, low_cd),
            avx._mm256_shuffle_ps::<0x44>(high_ab, high_cd),
            avx._mm256_shuffle_ps::<0xEE>(high_ab, high_cd),
        ]
    }

    /// The transpose of four rows of four.
    #[inline(always)]
    fn square(simd: V3, [a, b, c, d]: [__m256d; 4]) -> [__m256d; 4] {
        let avx = simd.avx;
        let (even_ab, odd_ab) = (avx._mm256_unpacklo_pd(a, b), avx._mm256_unpackhi_pd(a, b));
        let (even_cd, odd_cd) = (avx._mm256_unpacklo_pd(c, d), avx._mm256_unpackhi_pd(c, d));
        [
            avx._mm256_permute2f128_pd::<0x20>(even_ab, even_cd),
            avx._mm256_permute2f128_pd::<0x20>(odd_ab, odd_cd),
            avx._mm256_permute2f128_pd::<0x31>(even_ab, even_cd),
            avx._mm256_permute2f128_pd::<0x31>(odd_ab, odd_cd),
        ]
    }

    /// Pairs of neighbours from two registers, in the order of lanes.
    const FIRST: [i64; 8] = [0, 1, 8, 9, 4, 5, 12, 13];
    const SECOND: [i64; 8] = [2, 3, 10, 11, 6, 7, 14, 15];
    /// Rows of even and of odd halves.
    const LOWER: [i64; 8] = [0, 1, 8, 9, 2, 3, 10, 11];
    const UPPER: [i64; 8] = [4, 5, 12, 13, 6, 7, 14, 15];

    impl Transpose for V4 {
        #[inline(always)]
        fn to_lanes(self, rows: [&Row; WIDTH]) -> [Lanes; 4] {
            let avx = self.avx512f;
            // Straight into registers: a copy in memory would be read too soon.
            let pair = |i: usize| -> __m512d {
                let (lower, upper): (__m256d, __m256d) = (cast(*rows[i]), cast(*rows[i + 4]));
                avx._mm512_insertf64x4::<1>(avx._mm512_castpd256_pd512(lower), upper)
            };
            let (a, b, c, d) = (pair(0), pair(1), pair(2), pair(3));
            let (even_ab, odd_ab) = (avx._mm512_unpacklo_pd(a, b), avx._mm512_unpackhi_pd(a, b));
            let (even_cd, odd_cd) = (avx._mm512_unpacklo_pd(c, d), avx._mm512_unpackhi_pd(c, d));
            let (first, second): (__m512i, __m512i) = (cast(FIRST), cast(SECOND));
            [
                Lanes(cast(avx._mm512_permutex2var_pd(even_ab, first, even_cd))),
                Lanes(cast(avx._mm512_permutex2var_pd(odd_ab, first, odd_cd))),
                Lanes(cast(avx._mm512_permutex2var_pd(even_ab, second, even_cd))),
                Lanes(cast(avx._mm512_permutex2var_pd(odd_ab, second, odd_cd))),
            ]
        }

        #[inline(always)]
        fn to_rows(self, lanes: &[Lanes; 4]) -> [Row; WIDTH] {
            let avx = self.avx512f;
            let [a, b, c, d] = lanes;
            let (a, b): (__m512d, __m512d) = (cast(a.0), cast(b.0));
            let (c, d): (__m512d, __m512d) = (cast(c.0), cast(d.0));
            let (even_ab, odd_ab) = (avx._mm512_unpacklo_pd(a, b), avx._mm512_unpackhi_pd(a, b));
            let (even_cd, odd_cd) = (avx._mm512_unpacklo_pd(c, d), avx._mm512_unpackhi_pd(c, d));
            let (lower, upper): (__m512i, __m512i) = (cast(LOWER), cast(UPPER));
            let rows = |x: __m512d, index: __m512i, y: __m512d| -> [Row; 2] {
                cast(avx._mm512_permutex2var_pd(x, index, y))
            };
            let [r0, r2] = rows(even_ab, lower, even_cd);
            let [r1, r3] = rows(odd_ab, lower, odd_cd);
            let [r4, r6] = rows(even_ab, upper, even_cd);
            let [r5, r7] = rows(odd_ab, upper, odd_cd);
            [r0, r1, r2, r3, r4, r5, r6, r7]
        }

        #[inline(always)]
        fn to_single_lanes(self, rows: [&Row<f32>; SINGLE_WIDTH]) -> [Single; 4] {
            let avx = self.avx512f;
            let every_fourth = |i: usize| -> __m512 {
                let row = |k: usize| -> __m128 { cast(*rows[i + 4 * k]) };
                let first = avx._mm512_castps128_ps512(row(0));
                let first = avx._mm512_insertf32x4::<1>(first, row(1));
                let first = avx._mm512_insertf32x4::<2>(first, row(2));
                avx._mm512_insertf32x4::<3>(first, row(3))
            };
            let (a, b) = (every_fourth(0), every_fourth(1));
            let (c, d) = (every_fourth(2), every_fourth(3));
            let [x, y, z, w] = quarters(self, [a, b, c, d]);
            [
                Lanes(cast(x)),
                Lanes(cast(y)),
                Lanes(cast(z)),
                Lanes(cast(w)),
            ]
        }

        #[inline(always)]
        fn to_single_rows(self, lanes: &[Single; 4]) -> [Row<f32>; SINGLE_WIDTH] {
            let [x, y, z, w] = lanes;
            let rows = quarters(self, [cast(x.0), cast(y.0), cast(z.0), cast(w.0)]);
            let [a, b, c, d]: [[Row<f32>; 4]; 4] = cast(rows);
            [
                a[0], b[0], c[0], d[0], a[1], b[1], c[1], d[1], a[2], b[2], c[2], d[2], a[3], b[3],
                c[3], d[3],
            ]
        }
    }

    /// The transposes of four rows of four in each quarter.
    #[inline(always)]
    fn quarters(simd: V4, [a, b, c, d]: [__m512; 4]) -> [__m512; 4] {
        let avx = simd.avx512f;
        let (low_ab, high_ab) = (avx._mm512_unpacklo_ps(a, b), avx._mm512_unpackhi_ps(a, b));
        let (low_cd, high_cd) = (avx._mm512_unpacklo_ps(c, d), avx._mm512_unpackhi_ps(c, d));
        [
            avx._mm512_shuffle_ps::<0x44>(low_ab, low_cd),
            avx._mm512_shuffle_ps::<0xEE>(low_ab, low_cd),
            avx._mm512_shuffle_ps::<0x44>(high_ab, high_cd),
            avx._mm512_shuffle_ps::<0xEE>(high_ab, high_cd),
        ]
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // Values are moved, not computed.
mod tests {
    use super::*;
    use crate::assembly::simd::{self, InstructionSet};

    #[test]
    fn every_instruction_set_transposes_there_and_back() {
        let rows: [Row; WIDTH] =
            std::array::from_fn(|lane| std::array::from_fn(|i| (10 * lane + i) as f64));
        for set in InstructionSet::ALL.into_iter().filter(|set| set.is_here()) {
            let (lanes, back) = simd::there_and_back(set, &rows);
            for (i, lanes) in lanes.iter().enumerate() {
                let expected: [f64; WIDTH] = std::array::from_fn(|lane| (10 * lane + i) as f64);
                assert_eq!(lanes.0, expected, "{}", set.name());
            }
            assert_eq!(back, rows, "{}", set.name());
        }
    }

    #[test]
    fn every_instruction_set_transposes_single_precision_there_and_back() {
        let rows: [Row<f32>; SINGLE_WIDTH] =
            std::array::from_fn(|lane| std::array::from_fn(|i| (10 * lane + i) as f32));
        for set in InstructionSet::ALL.into_iter().filter(|set| set.is_here()) {
            let (lanes, back) = simd::there_and_back(set, &rows);
            for (i, lanes) in lanes.iter().enumerate() {
                let expected: [f32; SINGLE_WIDTH] =
                    std::array::from_fn(|lane| (10 * lane + i) as f32);
                assert_eq!(lanes.0, expected, "{}", set.name());
            }
            assert_eq!(back, rows, "{}", set.name());
        }
    }
}
