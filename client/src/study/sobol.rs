//! Points of the Sobol sequence: x_d(n) = XOR of the direction numbers v_d(k) over the bits k
//! of the Gray code of n, as 32-bit fractions in [0, 1).
//!
//! Reference: S. Joe and F. Y. Kuo, "Constructing Sobol sequences with better two-dimensional
//! projections", SIAM J. Sci. Comput. 30, 2008; primitive polynomials and initial numbers are
//! those of its set D(6). A seed shifts the points digitally (XOR of one random number a
//! dimension), which keeps how evenly they lie. Any point is found without those before
//! it. Cost: 32 operations a coordinate, 128 bytes a dimension.

/// Most dimensions: initial numbers of more are published, but not in this table.
pub(crate) const DIMENSIONS: usize = INITIAL.len() + 1;

/// Points before the sequence repeats, less than the numbers of its index.
pub(crate) const MOST_POINTS: u64 = 1 << 31;

/// Of every dimension but the first: primitive polynomial, bit by bit with both ends, and
/// the odd numbers m_1, m_2, ... that begin the recurrence.
const INITIAL: [(u32, &[u32]); 31] = [
    (3, &[1]),
    (7, &[1, 3]),
    (11, &[1, 3, 1]),
    (13, &[1, 1, 1]),
    (19, &[1, 1, 3, 3]),
    (25, &[1, 3, 5, 13]),
    (37, &[1, 1, 5, 5, 17]),
    (41, &[1, 1, 5, 5, 5]),
    (47, &[1, 1, 7, 11, 19]),
    (55, &[1, 1, 5, 1, 1]),
    (59, &[1, 1, 1, 3, 11]),
    (61, &[1, 3, 5, 5, 31]),
    (67, &[1, 3, 3, 9, 7, 49]),
    (91, &[1, 1, 1, 15, 21, 21]),
    (97, &[1, 3, 1, 13, 27, 49]),
    (103, &[1, 1, 1, 15, 7, 5]),
    (109, &[1, 3, 1, 15, 13, 25]),
    (115, &[1, 1, 5, 5, 19, 61]),
    (131, &[1, 3, 7, 11, 23, 15, 103]),
    (137, &[1, 3, 7, 13, 13, 15, 69]),
    (143, &[1, 1, 3, 13, 7, 35, 63]),
    (145, &[1, 3, 5, 9, 1, 25, 53]),
    (157, &[1, 3, 1, 13, 9, 35, 107]),
    (167, &[1, 3, 1, 5, 27, 61, 31]),
    (171, &[1, 1, 5, 11, 19, 41, 61]),
    (185, &[1, 3, 5, 3, 3, 13, 69]),
    (191, &[1, 1, 7, 13, 1, 19, 1]),
    (193, &[1, 3, 7, 5, 13, 19, 59]),
    (203, &[1, 1, 3, 9, 25, 29, 41]),
    (211, &[1, 3, 5, 13, 23, 1, 55]),
    (213, &[1, 3, 7, 3, 13, 59, 17]),
];

/// The sequence in some dimensions.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Sobol {
    /// Direction numbers and shift of each dimension.
    dimensions: Vec<([u32; 32], u32)>,
}

impl Sobol {
    /// As many dimensions as are asked for and known; without a seed as published, the first
    /// point being the origin.
    pub(crate) fn new(dimensions: usize, seed: Option<u64>) -> Self {
        let later = INITIAL
            .iter()
            .map(|(polynomial, initial)| directions(*polynomial, initial));
        let all = std::iter::once(halves()).chain(later).take(dimensions);
        let shift = |dimension: u64| seed.map_or(0, |seed| random(seed, dimension));
        Self {
            dimensions: all.zip((0..).map(shift)).collect(),
        }
    }

    /// A coordinate of a point, counted from 0; 0 in a dimension that is not there.
    pub(crate) fn coordinate(&self, point: u64, dimension: usize) -> f64 {
        let Some((directions, shift)) = self.dimensions.get(dimension) else {
            return 0.0;
        };
        let gray = point ^ (point >> 1);
        let bits = directions
            .iter()
            .zip(0..)
            .filter(|(_, bit)| gray >> bit & 1 == 1);
        let fraction = bits.fold(*shift, |sum, (direction, _)| sum ^ direction);
        f64::from(fraction) / 4_294_967_296.0
    }
}

/// The first dimension: 1/2, 1/4, ... (van der Corput).
fn halves() -> [u32; 32] {
    std::array::from_fn(|bit| 1 << (31 - bit))
}

/// v(k) = m_(k+1) / 2^(k+1), then v(k) = v(k-s) / 2^s XOR a_1 v(k-1) XOR ... XOR v(k-s) for a
/// polynomial of degree s with the inner bits a.
fn directions(polynomial: u32, initial: &[u32]) -> [u32; 32] {
    let degree = initial.len();
    let mut numbers = [0_u32; 32];
    for bit in 0..numbers.len() {
        let before = |back: usize| {
            bit.checked_sub(back)
                .and_then(|bit| numbers.get(bit))
                .copied()
        };
        let number = match initial.get(bit) {
            Some(first) => first << (31 - bit),
            None => {
                let base = before(degree).unwrap_or_default();
                let inner = (1..degree).filter(|back| polynomial >> (degree - back) & 1 == 1);
                let inner = inner.filter_map(before);
                inner.fold(base ^ (base >> degree), |sum, number| sum ^ number)
            }
        };
        if let Some(place) = numbers.get_mut(bit) {
            *place = number;
        }
    }
    numbers
}

/// The upper half of a number of the generator SplitMix64.
fn random(seed: u64, index: u64) -> u32 {
    let step = 0x9e37_79b9_7f4a_7c15_u64;
    let mut mixed = seed.wrapping_add(step.wrapping_mul(index.wrapping_add(1)));
    mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((mixed ^ (mixed >> 31)) >> 32) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From SciPy 1.x, `qmc.Sobol(8, scramble=False)`, which has the same numbers.
    const FIRST: [[f64; 8]; 6] = [
        [0.0; 8],
        [0.5; 8],
        [0.75, 0.25, 0.25, 0.25, 0.75, 0.75, 0.25, 0.75],
        [0.25, 0.75, 0.75, 0.75, 0.25, 0.25, 0.75, 0.25],
        [0.375, 0.375, 0.625, 0.875, 0.375, 0.125, 0.375, 0.875],
        [0.875, 0.875, 0.125, 0.375, 0.875, 0.625, 0.875, 0.375],
    ];

    #[test]
    fn the_first_points_are_those_that_are_published() {
        let sobol = Sobol::new(8, None);
        for (point, expected) in (0..).zip(FIRST) {
            let found: [f64; 8] = std::array::from_fn(|axis| sobol.coordinate(point, axis));
            assert!(
                found
                    .iter()
                    .zip(expected)
                    .all(|(a, b)| (a - b).abs() < 1e-15),
                "{found:?}"
            );
        }
    }

    #[test]
    fn a_late_point_has_the_published_coordinates_in_every_dimension() {
        let sobol = Sobol::new(DIMENSIONS, None);
        // Point 1000, in 1024ths.
        let expected = [
            225, 99, 531, 693, 287, 929, 47, 921, 513, 71, 87, 261, 165, 393, 147, 379, 737, 353,
            1015, 743, 535, 563, 973, 553, 597, 929, 41, 1003, 61, 349, 151, 149,
        ];
        for (axis, expected) in expected.iter().enumerate() {
            let found = sobol.coordinate(1000, axis) * 1024.0;
            assert!(
                (found - f64::from(*expected)).abs() < 1e-9,
                "{axis}: {found}"
            );
        }
    }

    #[test]
    fn each_interval_of_two_to_the_k_points_has_one_in_every_dimension_whatever_the_seed() {
        for seed in [None, Some(0), Some(7)] {
            let sobol = Sobol::new(DIMENSIONS, seed);
            for axis in 0..DIMENSIONS {
                let mut cells: Vec<u32> = (0..1024)
                    .map(|point| (sobol.coordinate(point, axis) * 1024.0) as u32)
                    .collect();
                cells.sort_unstable();
                assert_eq!(cells, (0..1024).collect::<Vec<_>>(), "{seed:?} {axis}");
            }
        }
    }

    #[test]
    fn seeds_give_other_points_and_the_same_seed_the_same() {
        let first = |seed| Sobol::new(2, Some(seed)).coordinate(0, 1).to_bits();
        assert_eq!(first(3), first(3));
        assert_ne!(first(3), first(4));
    }
}
