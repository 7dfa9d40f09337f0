//! Between nodes and lanes: eight nodes of four numbers each become four
//! registers of eight lanes, and back.
//!
//! Written with shuffles where the processor has them: numbers written one by
//! one and read as a whole register wait for each other.

use super::lanes::{Lanes, WIDTH};

/// The numbers of one node: displacement, then pressure in the last place.
pub type Row = [f64; 4];

/// Transposes with the registers of one instruction set.
pub trait Transpose: Copy {
    /// Number `i` of all rows in lanes `i`.
    fn to_lanes(self, rows: [&Row; WIDTH]) -> [Lanes; 4];
    /// The rows again.
    fn to_rows(self, lanes: &[Lanes; 4]) -> [Row; WIDTH];
}

impl Transpose for pulp::Scalar {
    #[inline(always)]
    fn to_lanes(self, rows: [&Row; WIDTH]) -> [Lanes; 4] {
        let mut out = [Lanes::ZERO; 4];
        for lane in 0..WIDTH {
            for i in 0..4 {
                out[i].0[lane] = rows[lane][i];
            }
        }
        out
    }

    #[inline(always)]
    fn to_rows(self, lanes: &[Lanes; 4]) -> [Row; WIDTH] {
        let mut out = [[0.0; 4]; WIDTH];
        for lane in 0..WIDTH {
            for i in 0..4 {
                out[lane][i] = lanes[i].0[lane];
            }
        }
        out
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use std::arch::x86_64::{__m256d, __m512d, __m512i};

    use pulp::bytemuck::cast;
    use pulp::x86::{V3, V4};

    use super::{Lanes, Row, Transpose, WIDTH};

    impl Transpose for V3 {
        #[inline(always)]
        fn to_lanes(self, rows: [&Row; WIDTH]) -> [Lanes; 4] {
            let mut registers: [__m256d; WIDTH] = [cast(*rows[0]); WIDTH];
            for (register, row) in registers.iter_mut().zip(rows) {
                *register = cast(*row);
            }
            let [a, b, c, d, e, f, g, h] = registers;
            let (low, high) = (square(self, [a, b, c, d]), square(self, [e, f, g, h]));
            let mut out = [Lanes::ZERO; 4];
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
}
