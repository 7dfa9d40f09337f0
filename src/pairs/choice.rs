//! Which parts of a face meet which faces of the other surface.
//!
//! Ends of the pieces are where the rays of the face pass vertices of the other surface, and where it
//! stops going on beyond its ends and corners: roots of cubics. They count within the reach along the
//! ray, and at any distance those of faces that are met, or of the same body: what else is among the
//! candidates of another body changes nothing. Between two of them the partner is that of the ray in
//! the middle: the nearest face that it meets from outside, within the reach and before half of the
//! way to where neighbouring rays meet. The choice is by values alone; derivatives are taken with the
//! topology as it is. Cost: one cubic a vertex and one ray a part and face among the candidates.

use super::piece::{
    Beside, End, Face, Piece, cross, dot, meeting, minus, point, slope, to_the_right,
};

/// Pieces shorter than this share of a face are left out.
pub(super) const SHORTEST: f64 = 1e-12;
/// Share of a face by which a hit may miss the end of its partner, for rounding.
const BESIDE: f64 = 1e-9;
/// Cosine between a ray and the normal of a wall at most, without unit; chosen below the .83 of flanks of a wedge of
/// 67 degrees: where these count as walls, it ends as `not_converged` in the increment of first touch.
const SQUARE: f64 = 0.7;
/// Least cosine between a ray and the normal of what it meets: rays that graze move without bound.
pub(super) const GRAZING: f64 = 0.2;
/// Gap of a piece over the reach at most, where another piece of its face is within that: a part that
/// ended in the middle of a face where the gap is wide would grow and shrink with vertices that pass,
/// and programs would see a gap close that is far open.
pub(super) const WIDE: f64 = 2.0;
/// Gap over the length of a face from which on it is open, without unit; chosen.
const OPEN: f64 = 0.1;
/// Cosine between a ray and the normal of what it meets below which that is met aslant, without unit; chosen, above
/// the .45 at which the contact of a round tip half inside a block ends.
pub(super) const ASLANT: f64 = 0.5;
/// Share of the way to where neighbouring rays meet up to which they count, without unit; chosen: at
/// the whole of it what they sweep is zero.
pub(super) const SIDE_BY_SIDE: f64 = 0.5;
/// Halvings that find a root to rounding.
const HALVINGS: usize = 60;

/// A face of the other surface, where it is.
#[derive(Clone, Copy, Debug)]
pub struct Partner {
    /// Ends and edge.
    pub nodes: [[f64; 2]; 3],
    /// Part of its line that counts: \[0, 1\], and beyond where the surface ends.
    pub range: [f64; 2],
    /// What it is to the face.
    pub role: Role,
}

/// What a face of the other surface is to a face of the carrier.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// One of another body, which rays may meet.
    Apart,
    /// One of the same body, which rays may meet; none looks through it from behind.
    Meets,
    /// One of the same body that only stops rays.
    Hides,
}

impl Role {
    /// Of faces of one body the one that comes first in `ranks` `[faces]` presses; either where there are none.
    pub(super) fn by_ranks(ranks: &[usize], [own, other]: [usize; 2]) -> Self {
        if ranks.is_empty() || ranks[own] < ranks[other] {
            Self::Meets
        } else {
            Self::Hides
        }
    }
}

/// How far partners are looked for along the rays.
#[derive(Clone, Copy, Debug)]
pub struct Reach {
    /// Largest gap of a face's nearest piece; its other pieces may be `WIDE` times as far.
    pub open: f64,
    /// Largest penetration at the ends of the face, between them along a straight line.
    pub inside: [f64; 2],
}

impl Reach {
    /// Whether a gap at `s` is within.
    fn holds(self, s: f64, gap: f64) -> bool {
        let [first, last] = self.inside;
        gap <= WIDE * self.open && -gap <= first + s * (last - first)
    }
}

/// An end of a partner's part as rays of the face see it.
#[derive(Clone, Copy, Debug)]
struct Break {
    s: f64,
    partner: usize,
    r: f64,
}

/// A part of the face with its partner, before it is known what its ends are.
#[derive(Clone, Copy, Debug)]
struct Run {
    partner: usize,
    part: [f64; 2],
    /// The least one in the middle of its parts.
    gap: f64,
}

/// The pieces of a face among `partners`, with the numbers of these, ascending along the face.
pub(super) fn pieces(
    face: &Face<f64>,
    beside: [Beside; 2],
    partners: &[Partner],
    reach: Reach,
) -> Vec<(usize, Piece)> {
    let counts = |one: &Break| {
        let other = &partners[one.partner];
        let gap = gap_at(face, one.s, point(other.nodes, one.r));
        other.role != Role::Apart || reach.holds(one.s, gap)
    };
    let (mut breaks, mut far): (Vec<Break>, Vec<Break>) =
        breaks(face, partners).into_iter().partition(counts);
    let runs = loop {
        let runs = runs(face, &breaks, partners, reach);
        let is_met = |one: &Break| runs.iter().any(|run| run.partner == one.partner);
        let (met, rest): (Vec<Break>, Vec<Break>) = far.into_iter().partition(is_met);
        if met.is_empty() {
            break runs;
        }
        breaks.extend(met);
        far = rest;
    };
    if runs.iter().all(|run| run.gap > reach.open) {
        return Vec::new();
    }
    let piece = |(
        k,
        Run {
            partner, part: run, ..
        },
    ): (usize, Run)| {
        let goes_on = [k.checked_sub(1).map(|k| runs[k]), runs.get(k + 1).copied()];
        let goes_on = [0, 1].map(|side: usize| {
            let next =
                goes_on[side].filter(|next| (next.part[1 - side] - run[side]).abs() <= SHORTEST);
            next.is_some_and(|next| are_joined(&partners[partner], &partners[next.partner]))
        });
        let is_apart = partners[partner].role == Role::Apart;
        let ends = [0, 1].map(|side: usize| {
            let is_open = || is_open(face, run[side], &partners[partner]);
            if is_apart || goes_on[side] || !is_open() {
                end(run[side], partner, &breaks)
            } else {
                // What is beyond is not met, or another part far behind: that end moves no volume that
                // contact could close.
                End::Fixed(run[side])
            }
        });
        let piece = Piece {
            beside,
            ends,
            fading: [0.0; 3],
        };
        (partner, piece)
    };
    runs.iter().copied().enumerate().map(piece).collect()
}

/// The partners between `breaks`, ascending.
fn runs(face: &Face<f64>, breaks: &[Break], partners: &[Partner], reach: Reach) -> Vec<Run> {
    let mut places: Vec<f64> = breaks.iter().map(|one| one.s).collect();
    places.extend([0.0, 1.0]);
    places.sort_by(f64::total_cmp);
    let mut runs: Vec<Run> = Vec::new();
    for pair in places
        .windows(2)
        .filter(|pair| pair[1] - pair[0] > SHORTEST)
    {
        let middle = 0.5 * (pair[0] + pair[1]);
        let Some((partner, gap)) = nearest(face, middle, partners, reach) else {
            continue;
        };
        match runs.last_mut() {
            // A vertex of another part that the rays pass on their way.
            Some(run) if run.partner == partner && pair[0] - run.part[1] <= SHORTEST => {
                run.part[1] = pair[1];
                run.gap = run.gap.min(gap);
            }
            _ => {
                let part = [pair[0], pair[1]];
                runs.push(Run { partner, part, gap });
            }
        }
    }
    runs
}

/// Gap beyond which a face is open.
fn near(face: &Face<f64>) -> f64 {
    let along = slope(face.nodes, 0.5);
    OPEN * dot(along, along).sqrt()
}

/// Whether a face is as far from a partner at `s` that contact there is not near.
fn is_open(face: &Face<f64>, s: f64, partner: &Partner) -> bool {
    met(face, s, partner).is_some_and(|met| met.gap > near(face))
}

/// Whether two partners have a common vertex.
fn are_joined(one: &Partner, other: &Partner) -> bool {
    let [[a, b, _], [c, d, _]] = [one.nodes, other.nodes];
    let bits = |vertex: [f64; 2]| vertex.map(f64::to_bits);
    let [c, d] = [bits(c), bits(d)];
    [a, b].into_iter().map(bits).any(|own| own == c || own == d)
}

/// The end of a piece at `s`.
fn end(s: f64, partner: usize, breaks: &[Break]) -> End {
    if !(SHORTEST..=1.0 - SHORTEST).contains(&s) {
        return End::Fixed(s.round());
    }
    let own = breaks.iter().filter(|one| one.partner == partner);
    let own = own.min_by(|a, b| (a.s - s).abs().total_cmp(&(b.s - s).abs()));
    match own.filter(|own| (own.s - s).abs() <= BESIDE) {
        Some(own) => End::Opposite { s: own.s, r: own.r },
        None => End::Fixed(s),
    }
}

/// Where the rays of the face pass the ends of all partners, and of another body those of what goes on
/// beyond them: at a corner the lines of both its faces cross.
fn breaks(face: &Face<f64>, partners: &[Partner]) -> Vec<Break> {
    let mut breaks = Vec::new();
    for (partner, other) in partners.iter().enumerate() {
        let [from, to] = other.range;
        let is_apart = other.role == Role::Apart;
        let corners = [from.max(0.0), to.min(1.0)].into_iter();
        let corners = corners.filter(|r| is_apart && !other.range.contains(r));
        for r in other.range.into_iter().chain(corners) {
            let v = point(other.nodes, r);
            let roots = roots(cubic(face, v)).into_iter();
            breaks.extend(roots.map(|s| Break { s, partner, r }));
        }
    }
    breaks
}

/// Coefficients of T.(x - v) by powers of s.
pub(super) fn cubic(face: &Face<f64>, v: [f64; 2]) -> [f64; 4] {
    let [a, b, middle] = face.nodes;
    let [first, last] = face.tangents;
    let turn = minus(last, first);
    let bulge = middle.map(|x| 4.0 * x);
    let by_power = [
        minus(a, v),
        [0, 1].map(|i| b[i] - a[i] + bulge[i]),
        bulge.map(|x| -x),
    ];
    let [zero, one, two] = by_power;
    [
        dot(first, zero),
        dot(first, one) + dot(turn, zero),
        dot(first, two) + dot(turn, one),
        dot(turn, two),
    ]
}

fn value([k0, k1, k2, k3]: [f64; 4], s: f64) -> f64 {
    k0 + s * (k1 + s * (k2 + s * k3))
}

/// Roots of a cubic in (0, 1), by halving between its extrema.
pub(super) fn roots(k: [f64; 4]) -> Vec<f64> {
    let [_, b, c, d] = [k[0], k[1], 2.0 * k[2], 3.0 * k[3]];
    let size = (c * c - 4.0 * d * b).sqrt();
    let pivot = -0.5 * (c + size.copysign(c));
    let extrema = [pivot / d, b / pivot].into_iter();
    let mut marks: Vec<f64> = extrema.filter(|s| *s > 0.0 && *s < 1.0).collect();
    marks.extend([0.0, 1.0]);
    marks.sort_by(f64::total_cmp);
    let between = marks
        .windows(2)
        .filter_map(|ends| root(k, [ends[0], ends[1]]));
    between.collect()
}

/// The root between two places where the cubic is monotone; none without a change of sign.
fn root(k: [f64; 4], ends: [f64; 2]) -> Option<f64> {
    crossing(&|s| value(k, s) > 0.0, ends)
}

/// Where `is_past` changes between two places; none where both have the same.
pub(super) fn crossing(
    is_past: &dyn Fn(f64) -> bool,
    [mut low, mut high]: [f64; 2],
) -> Option<f64> {
    let first = is_past(low);
    if first == is_past(high) {
        return None;
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if is_past(middle) == first {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some(0.5 * (low + high))
}

/// The nearest partner that the ray from `s` meets from outside, and its gap.
fn nearest(face: &Face<f64>, s: f64, partners: &[Partner], reach: Reach) -> Option<(usize, f64)> {
    let mut best: Option<(usize, f64, f64)> = None;
    for (index, partner) in partners.iter().enumerate() {
        let Some(gap) = gap_to(face, s, partner) else {
            continue;
        };
        let far = gap.abs() + beyond(face, s, partner);
        if stands_out(face, s, index, partners) || is_beside(face, s, index, partners) {
            continue;
        }
        if reach.holds(s, gap) && best.is_none_or(|(_, _, least)| far < least) {
            best = Some((index, gap, far));
        }
    }
    let best = best.map(|(index, gap, _)| (index, gap));
    best.filter(|&(index, gap)| {
        let is_hidden = |other: &Partner| is_behind(face, s, (other, gap));
        let is_clear = match partners[index].role {
            Role::Apart => gap <= 0.0 || is_before_focus(face, s, gap),
            Role::Meets => is_before_focus(face, s, gap),
            Role::Hides => false,
        };
        is_clear && !partners.iter().any(is_hidden)
    })
}

/// Whether a partner is met where its line stands out of the other body beyond a corner, before the face on the
/// other side of that corner, which the ray meets more squarely: the flank of a tip would touch before its end.
fn stands_out(face: &Face<f64>, s: f64, index: usize, partners: &[Partner]) -> bool {
    let own = met(face, s, &partners[index]).filter(|own| !is_on(own));
    let is_before = |own: Met| {
        let others = across(face, s, (index, &own), partners);
        others
            .into_iter()
            .any(|(_, met)| is_on(&met) && met.gap > own.gap)
    };
    own.is_some_and(is_before)
}

/// Whether a partner is met where the ray has met more squarely, before it, what goes on beyond the corner
/// from the face on its other side: a wall beside the end of a sole. In a hollow corner that lies behind.
fn is_beside(face: &Face<f64>, s: f64, index: usize, partners: &[Partner]) -> bool {
    let is_wall = |own: &Met| is_on(own) && own.cosine < SQUARE;
    let own = met(face, s, &partners[index]).filter(is_wall);
    let goes_on = |(other, met): (&Partner, Met)| {
        let [low, high] = other.range;
        !is_on(&met) && (low..=high).contains(&met.r)
    };
    own.is_some_and(|own| {
        let others = across(face, s, (index, &own), partners).into_iter();
        others.filter(|(_, met)| met.gap < own.gap).any(goes_on)
    })
}

/// Whether a ray meets a face itself, not what goes on beyond its ends.
fn is_on(met: &Met) -> bool {
    (-BESIDE..=1.0 + BESIDE).contains(&met.r)
}

/// What the ray meets more squarely of the faces of another body that have a vertex in common with one, where it
/// has `own`.
fn across<'p>(
    face: &Face<f64>,
    s: f64,
    (index, own): (usize, &Met),
    partners: &'p [Partner],
) -> Vec<(&'p Partner, Met)> {
    let partner = &partners[index];
    let others = partners
        .iter()
        .filter(|other| other.role == Role::Apart && are_joined(partner, other));
    let met = others.filter_map(|other| Some((other, met(face, s, other)?)));
    met.filter(|(_, met)| met.cosine > own.cosine).collect()
}

/// Whether neighbouring rays of a point of the face still go their way side by side at a distance
/// `gap`: those of a hollow face meet in its middle, and what they sweep beyond is negative, so that a
/// wide gap would count as closed and pull.
fn is_before_focus(face: &Face<f64>, s: f64, gap: f64) -> bool {
    let [tangent, change] = face.tangent(s);
    let n = to_the_right(tangent);
    let along = cross(n, slope(face.nodes, s));
    let turning = cross(n, to_the_right(change));
    gap / dot(n, n).sqrt() * turning >= -SIDE_BY_SIDE * along
}

/// How far beyond its end a face of the same body is met, so that one beside it goes before.
fn beyond(face: &Face<f64>, s: f64, partner: &Partner) -> f64 {
    if partner.role == Role::Apart {
        return 0.0;
    }
    let [tangent, _] = face.tangent(s);
    let r = meeting(point(face.nodes, s), tangent, partner.nodes);
    let along = slope(partner.nodes, 0.5);
    let over = r.map_or(0.0, |r| (-r).max(r - 1.0).max(0.0));
    over * dot(along, along).sqrt()
}

/// Whether a face of the same body lies between a point of the face and what the ray meets at a
/// distance `gap`, turned away from it or so that the ray grazes it: the ray is in the body from there
/// on.
fn is_behind(face: &Face<f64>, s: f64, (other, gap): (&Partner, f64)) -> bool {
    if other.role == Role::Apart || gap <= 0.0 {
        return false;
    }
    let [tangent, _] = face.tangent(s);
    let Some(r) = meeting(point(face.nodes, s), tangent, other.nodes) else {
        return false;
    };
    let n = to_the_right(tangent);
    let distance = face.gap(s, other.nodes, r) * dot(n, n).sqrt();
    let is_between = distance > 0.0 && distance < gap;
    is_between && (0.0..=1.0).contains(&r) && gap_to(face, s, other).is_none()
}

/// Distance from a point of the face to `y` on the ray from there, negative inside.
fn gap_at(face: &Face<f64>, s: f64, y: [f64; 2]) -> f64 {
    let n = to_the_right(face.tangent(s)[0]);
    dot(n, minus(y, point(face.nodes, s))) / dot(n, n).sqrt()
}

/// Where a ray meets the line of a partner.
struct Met {
    /// Place on the partner.
    r: f64,
    /// Distance along the ray, negative inside.
    gap: f64,
    /// Between the ray and the inner normal of the partner.
    cosine: f64,
}

/// Where the ray from a point of the face meets the line of a partner.
fn met(face: &Face<f64>, s: f64, partner: &Partner) -> Option<Met> {
    let [tangent, _] = face.tangent(s);
    let n = to_the_right(tangent);
    let r = meeting(point(face.nodes, s), tangent, partner.nodes)?;
    let other = slope(partner.nodes, r);
    let size = dot(n, n).sqrt();
    Some(Met {
        r,
        gap: face.gap(s, partner.nodes, r) * size,
        cosine: -cross(n, other) / (size * dot(other, other).sqrt()),
    })
}

/// Distance from a point of the face to a partner along the ray there, negative inside; none where
/// the ray misses it, grazes it or meets it from behind.
pub(super) fn gap_to(face: &Face<f64>, s: f64, partner: &Partner) -> Option<f64> {
    let met = met(face, s, partner)?;
    let [low, high] = partner.range;
    let is_on = (low - BESIDE..=high + BESIDE).contains(&met.r);
    (is_on && met.cosine >= GRAZING).then_some(met.gap)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_of_cubics_are_found_between_their_extrema() {
        // (s - .1)(s - .4)(s - .9)
        let found = roots([-0.036, 0.49, -1.4, 1.0]);
        for (found, exact) in found.iter().zip([0.1, 0.4, 0.9]) {
            assert!((found - exact).abs() < 1e-14, "{found}");
        }
        assert_eq!(found.len(), 3);
        // A line, a parabola, and none.
        assert!((roots([-0.25, 1.0, 0.0, 0.0])[0] - 0.25).abs() < 1e-15);
        assert_eq!(roots([0.21, -1.0, 1.0, 0.0]).len(), 2);
        assert!(roots([1.0, 0.5, 0.0, 0.0]).is_empty());
    }
}
