//! Flat cylinders around pieces of a surface: a piece of size h of a smooth surface is thinner
//! than h^2 across its normal, where a box along the axes is as thick as it is wide.

use crate::geometry::vector3::{add, cross, dot, normalised, sub};

/// By how much coins are widened: above all rounding of coordinates of about one.
const SLACK: f64 = 1e-6;
/// Share that a distance is taken for: the axis is a unit vector but for rounding.
const CAREFUL: f64 = 1.0 - 4e-6;

/// All points within `half` of the middle along the axis, and within `radius` across.
#[derive(Clone, Copy, Debug)]
pub(super) struct Coin {
    axis: [f32; 3],
    middle: [f32; 3],
    half: f32,
    radius: f32,
}

impl Coin {
    /// Around facets; without any the coin is a point.
    pub(super) fn around(facets: impl Iterator<Item = [[f64; 3]; 3]> + Clone) -> Self {
        let start = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3], [0.0; 3]);
        let (low, high, normal) = facets.clone().fold(start, |(low, high, normal), facet| {
            let [a, b, c] = facet;
            let least = |i: usize| low[i].min(a[i]).min(b[i]).min(c[i]);
            let most = |i: usize| high[i].max(a[i]).max(b[i]).max(c[i]);
            let own = cross(sub(b, a), sub(c, a));
            let [low, high] = [[0, 1, 2].map(least), [0, 1, 2].map(most)];
            (low, high, add(normal, own))
        });
        let axis = normalised(normal).unwrap_or([0.0, 0.0, 1.0]);
        let mut coin = Self {
            axis: axis.map(|x| x as f32),
            middle: std::array::from_fn(|i| (0.5 * (low[i] + high[i])) as f32),
            half: 0.0,
            radius: 0.0,
        };
        let (mut half, mut square) = (0.0_f64, 0.0_f64);
        for corner in facets.flatten() {
            let (along, across) = coin.parts(corner);
            half = half.max(along);
            square = square.max(across);
        }
        coin.half = widened(half);
        coin.radius = widened(square.sqrt());
        coin
    }

    /// How far a point is from the middle along the axis, and the square across.
    fn parts(&self, x: [f64; 3]) -> (f64, f64) {
        let offset = sub(x, self.middle.map(f64::from));
        let along = dot(offset, self.axis.map(f64::from));
        (along.abs(), (dot(offset, offset) - along * along).max(0.0))
    }

    /// At most the square of the distance of a point.
    pub(super) fn square_to(&self, x: [f64; 3]) -> f64 {
        let (along, across) = self.parts(x);
        let beyond = (along - f64::from(self.half)).max(0.0);
        let aside = (across.sqrt() - f64::from(self.radius)).max(0.0);
        CAREFUL * (beyond * beyond + aside * aside)
    }
}

fn widened(size: f64) -> f32 {
    ((size + SLACK) as f32).next_up()
}
