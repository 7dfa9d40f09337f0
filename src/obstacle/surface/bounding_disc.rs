//! Flat cylinders around pieces of a surface: a piece of size h of a smooth surface is thinner
//! than h^2 across its normal, where a box along the axes is as thick as it is wide.
//!
//! A disc also knows how far normals there turn away from its axis, those of all facets around the
//! corners of its own included. The way from a nearest point leads along one of these normals, or
//! between those of facets that meet there, to either side. A disc that no such way leaves
//! towards a point has none of its nearest points, however near it is:
//!
//! ```text
//! min over both signs of |u +- a| > k + r / D + rounding,   u = (x - m) / D,   D = |x - m|
//! ```
//!
//! a the axis, m the middle, r the reach of the disc around it, and k = max |a - n| over the normals.
//!
//! Of the nodes of a tree those of the last levels have discs around their facets, those above
//! around discs some levels below, which is little wider and does not read all facets again on
//! every level. Cost: one pass over the facets for each of the last levels.

use crate::geometry::vector3::{add, cross, dot, norm, normalised, sub};
use crate::parallel::{self, Pieces};

/// By how much discs are widened: above all rounding of coordinates of about one.
const SLACK: f64 = 1e-6;
/// Share that a distance is taken for: the axis is a unit vector but for rounding.
const CAREFUL: f64 = 1.0 - 4e-6;
/// Levels whose discs lie around facets.
const LAST: u32 = 3;
/// Levels between a disc and those that it lies around, at most.
const APART: u32 = 5;

/// A facet as discs see it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flat {
    pub(super) corners: [[f64; 3]; 3],
    /// Unit.
    pub(super) normal: [f64; 3],
    /// Largest difference from the normal of a facet at one of its corners.
    pub(super) turn: f64,
}

/// A piece of a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    /// Corners of the box around it.
    low: [f64; 3],
    high: [f64; 3],
    /// Sum of the normals of its facets, each as long as twice its area.
    normal: [f64; 3],
}

impl Piece {
    /// Of some facets.
    pub(super) fn of(facets: impl Iterator<Item = Flat>) -> Self {
        let start = Self {
            low: [f64::INFINITY; 3],
            high: [f64::NEG_INFINITY; 3],
            normal: [0.0; 3],
        };
        facets.fold(start, |piece, facet| {
            let [a, b, c] = facet.corners;
            let least = |i: usize| a[i].min(b[i]).min(c[i]);
            let most = |i: usize| a[i].max(b[i]).max(c[i]);
            piece.with(&Self {
                low: [0, 1, 2].map(least),
                high: [0, 1, 2].map(most),
                normal: cross(sub(b, a), sub(c, a)),
            })
        })
    }

    /// Both together.
    pub(super) fn with(&self, other: &Self) -> Self {
        Self {
            low: std::array::from_fn(|i| self.low[i].min(other.low[i])),
            high: std::array::from_fn(|i| self.high[i].max(other.high[i])),
            normal: add(self.normal, other.normal),
        }
    }
}

/// All points within `half` of the middle along the axis, and within `radius` across.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct BoundingDisc {
    axis: [f32; 3],
    middle: [f32; 3],
    half: f32,
    radius: f32,
    /// Largest distance of a point from the middle.
    reach: f32,
    /// Largest difference of a normal from the axis.
    turn: f32,
}

/// How far what is in a disc goes, still growing.
struct Extent {
    /// Least and largest place along the axis from the middle.
    along: [f64; 2],
    /// Largest distance from the axis.
    across: f64,
    turn: f64,
}

impl Extent {
    const EMPTY: Self = Self {
        along: [f64::INFINITY, f64::NEG_INFINITY],
        across: 0.0,
        turn: 0.0,
    };

    fn with(self, [from, to]: [f64; 2], across: f64, turn: f64) -> Self {
        let [least, most] = self.along;
        Self {
            along: [least.min(from), most.max(to)],
            across: self.across.max(across),
            turn: self.turn.max(turn),
        }
    }
}

impl BoundingDisc {
    /// Around what lies in a box and looks along an axis, still empty.
    fn new(piece: &Piece) -> Self {
        let axis = normalised(piece.normal).unwrap_or([0.0, 0.0, 1.0]);
        let middle = |i: usize| (0.5 * (piece.low[i] + piece.high[i])) as f32;
        Self {
            axis: axis.map(|x| x as f32),
            middle: std::array::from_fn(middle),
            ..Self::default()
        }
    }

    /// Around the facets of a piece.
    pub(super) fn around(piece: &Piece, facets: impl Iterator<Item = Flat>) -> Self {
        let disc = Self::new(piece);
        let axis = disc.axis.map(f64::from);
        let extent = facets.fold(Extent::EMPTY, |extent, facet| {
            let turn = norm(sub(axis, facet.normal)) + facet.turn;
            facet.corners.into_iter().fold(extent, |extent, corner| {
                let (along, square) = disc.parts(corner);
                extent.with([along; 2], square.sqrt(), turn)
            })
        });
        disc.grown(&extent)
    }

    /// Around the discs of the parts of a piece.
    pub(super) fn around_discs(piece: &Piece, parts: &[Self]) -> Self {
        let disc = Self::new(piece);
        let own = disc.axis.map(f64::from);
        let extent = parts.iter().fold(Extent::EMPTY, |extent, part| {
            let (along, square) = disc.parts(part.middle.map(f64::from));
            let axis = part.axis.map(f64::from);
            // Of the angle between the axes.
            let (cosine, sine) = (dot(axis, own).abs(), norm(cross(axis, own)));
            let [thick, wide] = [part.half, part.radius].map(f64::from);
            let (up, aside) = (thick * cosine + wide * sine, thick * sine + wide);
            let turn = norm(sub(own, axis)) + f64::from(part.turn);
            extent.with([along - up, along + up], square.sqrt() + aside, turn)
        });
        disc.grown(&extent)
    }

    /// As large as its extent, the middle moved along the axis.
    fn grown(self, extent: &Extent) -> Self {
        let [least, most] = extent.along;
        if least > most {
            return self;
        }
        let shift = 0.5 * (least + most);
        let moved: [f64; 3] =
            std::array::from_fn(|i| f64::from(self.middle[i]) + shift * f64::from(self.axis[i]));
        let middle = moved.map(|x| x as f32);
        // Far from the origin of a file the middle is rounded by more than a disc is thick.
        let off = norm(sub(moved, middle.map(f64::from)));
        let (half, across) = (0.5 * (most - least) + off, extent.across + off);
        Self {
            axis: self.axis,
            middle,
            half: widened(half),
            radius: widened(across),
            reach: widened(half.hypot(across)),
            turn: widened(extent.turn),
        }
    }

    /// Radius across the axis.
    pub(super) fn radius(&self) -> f32 {
        self.radius
    }

    /// Where a point is from the middle along the axis, and the square across.
    #[inline]
    fn parts(&self, x: [f64; 3]) -> (f64, f64) {
        // Written out: closures are not always put in place here.
        let ([a, b, c], [p, q, r]) = (self.axis, self.middle);
        let offset = sub(x, [f64::from(p), f64::from(q), f64::from(r)]);
        let along = dot(offset, [f64::from(a), f64::from(b), f64::from(c)]);
        (along, (dot(offset, offset) - along * along).max(0.0))
    }

    /// At most the square of the distance of a point at this place.
    fn square(&self, (along, across): (f64, f64)) -> f64 {
        let beyond = (along.abs() - f64::from(self.half)).max(0.0);
        let aside = (across.sqrt() - f64::from(self.radius)).max(0.0);
        CAREFUL * (beyond * beyond + aside * aside)
    }

    /// At most the square of the distance of a point where the disc may have what is nearest to it on
    /// a closed surface, and no farther than `most`; else infinity.
    pub(super) fn square_of_nearest(&self, x: [f64; 3], most: f64) -> f64 {
        let (along, across) = self.parts(x);
        let square = self.square((along, across));
        if square <= most && self.is_left_towards((along, across), 0.0) {
            square
        } else {
            f64::INFINITY
        }
    }

    /// Whether the disc may have the nearest point to one within `around` of `x`, which is no farther
    /// than `farthest` from `x`.
    pub(super) fn may_be_nearest(&self, (x, around): ([f64; 3], f64), farthest: f64) -> bool {
        let (along, across) = self.parts(x);
        let is_near = self.square((along, across)) <= farthest * farthest;
        is_near && self.is_left_towards((along, across), around)
    }

    /// Whether a normal of the disc may lead from one of its points to one within `around` of this
    /// place.
    fn is_left_towards(&self, (along, across): (f64, f64), around: f64) -> bool {
        let distance = (along * along + across).sqrt();
        let share = (f64::from(self.reach) + around) / distance;
        if share.is_nan() || share >= 1.0 {
            return true;
        }
        // Of directions to a ball: 2 sin(asin(share) / 2) is less.
        let seen = share * (1.0 + 0.42 * share * share);
        let most = f64::from(self.turn) + seen;
        // Squares of |u - a| for the nearer sign, axis and sum being rounded.
        2.0 - 2.0 * along.abs() / distance <= most * most + ROUNDED
    }
}

/// Rounding of squares of differences of directions.
const ROUNDED: f64 = 1e-6;

fn widened(size: f64) -> f32 {
    ((size + SLACK) as f32).next_up()
}

/// Discs of the nodes of a tree `[2 leaves]` from 1, `facets` being those under a node; the first
/// is not used. `leaves` is a power of two.
pub(super) fn of_tree<I>(leaves: usize, facets: impl Fn(usize) -> I + Sync) -> Vec<BoundingDisc>
where
    I: Iterator<Item = Flat>,
{
    let levels = leaves.ilog2();
    let mut discs = vec![BoundingDisc::default(); 2 * leaves];
    let mut pieces = parallel::map(leaves, 1, &|leaf| Piece::of(facets(leaves + leaf)));
    for level in (0..=levels).rev() {
        let first = 1 << level;
        let (upper, lower) = discs.split_at_mut(2 * first);
        parallel::each(Pieces::of(&mut upper[first..], 1), 1, &|place, disc| {
            let piece = &pieces[place];
            disc[0] = match levels - level {
                apart if apart < LAST => BoundingDisc::around(piece, facets(first + place)),
                apart => BoundingDisc::around_discs(
                    piece,
                    below(lower, (place, apart.min(APART)), first),
                ),
            };
        });
        let pairs = pieces.as_chunks::<2>().0;
        pieces = parallel::map(pairs.len(), 1, &|k| pairs[k][0].with(&pairs[k][1]));
    }
    discs
}

/// The discs some levels below node `place` of a level of `size`, among those of all levels below.
fn below(lower: &[BoundingDisc], (place, apart): (usize, u32), size: usize) -> &[BoundingDisc] {
    let first = (size << apart) - 2 * size;
    &lower[first + (place << apart)..first + ((place + 1) << apart)]
}
