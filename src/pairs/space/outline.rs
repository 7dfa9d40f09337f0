//! Polygons on a face whose sides are parabolas, in its coordinates l_1 and l_2:
//!
//! ```text
//! l = (1 - s) a + s b + 4 s (1 - s) m   from a corner a to the next one b
//! ```
//!
//! The outline of a face of the other surface as the rays of a face see it has curved sides, which
//! are cut until parabolas through their middles are off by less than `OFF`: neighbours share their
//! sides, so that nothing is counted twice, and what lies between a parabola and the true side belongs
//! to the wrong one of two faces. Their second derivatives differ at first order: the second variation
//! of a volume that is kept, zero at any pressure, has an error of that. Polygons are clipped by
//! Sutherland and Hodgman's rule. Cost: some 1 us a side.

use super::patch::{At, Patch};
use super::rays::Rayed;
use crate::geometry::vector3::{add, scale};

/// How far a parabola may be off its side, in face coordinates.
const OFF: f64 = 1e-5;
/// Halvings of a side at most.
const HALVINGS: u32 = 5;
/// How far off the face sides are still cut, in face coordinates.
const BESIDE: f64 = 0.1;
/// Areas below this, in face coordinates, are none.
pub(super) const LEAST: f64 = 1e-12;
/// Parts of a side below this are none.
const SHORTEST: f64 = 1e-14;

/// A corner of a polygon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corner {
    /// Where it is.
    pub at: At,
    /// m of the side to the next one.
    pub bulge: At,
    /// What that side is a part of, if it lies beyond a rim.
    pub rim: Option<Rim>,
}

/// A corner of a face of the other surface, or where the surface goes on to from there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// Which of its corners.
    pub corner: usize,
    /// Whether it is beyond.
    pub is_far: bool,
}

/// A part of a line beyond a rim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rim {
    /// The ends of the line.
    pub ends: [Spot; 2],
    /// Where on the line the part begins and ends.
    pub part: [f64; 2],
}

impl Rim {
    fn reversed(self) -> Self {
        let [from, to] = self.part;
        Self {
            part: [to, from],
            ..self
        }
    }

    fn part(self, [from, to]: [f64; 2]) -> Self {
        let [first, last] = self.part;
        Self {
            part: [from, to].map(|s| first + s * (last - first)),
            ..self
        }
    }
}

/// Corners, one after the other.
pub type Polygon = Vec<Corner>;

/// A face of the other surface, where it is, with how far the surface goes on at its corners.
#[derive(Clone, Copy, Debug)]
pub struct Partner {
    /// The face.
    pub patch: Patch,
    /// Which edges are rims.
    pub rims: [bool; 3],
    /// From each corner on beyond the rims.
    pub beyond: [[f64; 3]; 3],
}

/// A side of a face in space: an edge by its two corners, or a line beyond a rim.
#[derive(Clone, Copy)]
enum Side {
    Edge(usize, usize),
    Line([Spot; 2]),
}

impl Partner {
    /// The sides around it in the order of its corners, beyond its rims.
    fn sides(&self) -> Vec<Side> {
        let mut sides = Vec::with_capacity(8);
        let [corner, far] = [false, true].map(|is_far| {
            move |k: usize| Spot {
                corner: k % 3,
                is_far,
            }
        });
        // Edges (0,1), (1,2), (2,0) by their numbers.
        let is_rim = |k: usize| self.rims[[0, 2, 1][k % 3]];
        for k in 0..3 {
            if !is_rim(k) {
                sides.push(Side::Edge(k, (k + 1) % 3));
                continue;
            }
            if !is_rim(k + 2) {
                sides.push(Side::Line([corner(k), far(k)]));
            }
            sides.push(Side::Line([far(k), far(k + 1)]));
            if !is_rim(k + 1) {
                sides.push(Side::Line([far(k + 1), corner(k + 1)]));
            }
        }
        sides
    }

    /// The same without what it goes on by.
    pub fn closed(&self) -> Self {
        Self {
            rims: [false; 3],
            beyond: [[0.0; 3]; 3],
            ..*self
        }
    }

    /// The outline as rays of `face` see it, counterclockwise where both look at each other.
    pub fn outline(&self, face: &Rayed) -> Polygon {
        reversed(&self.outline_from_behind(face))
    }

    /// The same, counterclockwise where it turns its back on the face.
    pub fn outline_from_behind(&self, face: &Rayed) -> Polygon {
        let mut polygon = Polygon::with_capacity(12);
        for side in self.sides() {
            let place = |s: f64| face.below(self.on(side, s));
            let ends = [place(0.0), place(1.0)];
            let traced = Traced {
                place: &place,
                line: match side {
                    Side::Line(ends) => Some(ends),
                    Side::Edge(..) => None,
                },
            };
            traced.arcs(([0.0, 1.0], ends), HALVINGS, &mut polygon);
        }
        polygon
    }

    fn spot(&self, spot: Spot) -> [f64; 3] {
        let corner = self.patch.nodes[spot.corner];
        if spot.is_far {
            add(corner, self.beyond[spot.corner])
        } else {
            corner
        }
    }

    fn on(&self, side: Side, s: f64) -> [f64; 3] {
        let between = |a, b| add(scale(1.0 - s, a), scale(s, b));
        match side {
            Side::Line([a, b]) => between(self.spot(a), self.spot(b)),
            Side::Edge(i, j) => {
                let straight = between(self.patch.nodes[i], self.patch.nodes[j]);
                let edge = self.patch.nodes[2 + i + j];
                add(straight, scale(4.0 * s * (1.0 - s), edge))
            }
        }
    }
}

/// A polygon the other way round.
fn reversed(polygon: &Polygon) -> Polygon {
    let count = polygon.len();
    let corner = |k: usize| {
        let before = polygon[(k + count - 1) % count];
        Corner {
            at: polygon[k].at,
            bulge: before.bulge,
            rim: before.rim.map(Rim::reversed),
        }
    };
    (0..count).rev().map(corner).collect()
}

/// A point of the parabola from `a` to `b`.
fn on_side([a, b]: [At; 2], bulge: At, s: f64) -> At {
    let rise = 4.0 * s * (1.0 - s);
    [0, 1].map(|i| (1.0 - s) * a[i] + s * b[i] + rise * bulge[i])
}

/// A side as rays see it.
struct Traced<'a> {
    place: &'a dyn Fn(f64) -> At,
    /// The ends of the line that it is beyond a rim.
    line: Option<[Spot; 2]>,
}

impl Traced<'_> {
    fn corner(&self, at: At, bulge: At, part: [f64; 2]) -> Corner {
        let rim = self.line.map(|ends| Rim { ends, part });
        Corner { at, bulge, rim }
    }

    /// Adds the parabolas of a part of it.
    fn arcs(&self, ([from, to], ends): ([f64; 2], [At; 2]), halvings: u32, polygon: &mut Polygon) {
        let [a, b] = ends;
        if is_beside(a, b) {
            polygon.push(self.corner(a, [0.0; 2], [from, to]));
            return;
        }
        let along = |s: f64| (self.place)(from + s * (to - from));
        let middle = along(0.5);
        let bulge = [0, 1].map(|i| middle[i] - 0.5 * (a[i] + b[i]));
        let off = [0.25, 0.75].map(|s| {
            let [at, near] = [along(s), on_side(ends, bulge, s)];
            (at[0] - near[0]).hypot(at[1] - near[1])
        });
        if halvings == 0 || off[0].max(off[1]) <= OFF {
            polygon.push(self.corner(a, bulge, [from, to]));
            return;
        }
        let half = 0.5 * (from + to);
        self.arcs(([from, half], [a, middle]), halvings - 1, polygon);
        self.arcs(([half, to], [middle, b]), halvings - 1, polygon);
    }
}

/// l_0, l_1, l_2.
fn coordinates([s, t]: At) -> [f64; 3] {
    [1.0 - s - t, s, t]
}

/// Whether a side lies on the far side of an edge of the face.
fn is_beside(a: At, b: At) -> bool {
    let [a, b] = [a, b].map(coordinates);
    (0..3).any(|k| a[k] < -BESIDE && b[k] < -BESIDE)
}

/// The sides of a polygon: ends and bulge.
pub(super) fn sides(polygon: &Polygon) -> impl Iterator<Item = ([At; 2], At)> + '_ {
    let after = polygon.iter().cycle().skip(1);
    let pairs = polygon.iter().zip(after);
    pairs.map(|(from, to)| ([from.at, to.at], from.bulge))
}

/// Where a parabola crosses zero within its side, from its ends and what its middle is off their mean.
fn crossings([first, last]: [f64; 2], middle: f64) -> Vec<f64> {
    let [bend, slope] = [-4.0 * middle, last - first + 4.0 * middle];
    let root = (slope * slope - 4.0 * bend * first).sqrt();
    let pivot = -0.5 * (slope + root.copysign(slope));
    let both = [pivot / bend, first / pivot].into_iter();
    let mut found: Vec<f64> = both.filter(|s| *s > 0.0 && *s < 1.0).collect();
    found.sort_by(f64::total_cmp);
    found
}

/// The part of a polygon where `inside` is not negative; it is linear.
pub(super) fn clipped(polygon: &Polygon, inside: &dyn Fn(At) -> f64) -> Polygon {
    let mut kept = Polygon::with_capacity(polygon.len() + 2);
    let (mut first, mut was_inside, mut end) = (None, false, None);
    for (corner, (ends, bulge)) in polygon.iter().zip(sides(polygon)) {
        let values = ends.map(inside);
        let middle = inside(on_side(ends, bulge, 0.5)) - 0.5 * (values[0] + values[1]);
        let mut marks = vec![0.0];
        marks.extend(crossings(values, middle));
        marks.push(1.0);
        for part in marks.windows(2).filter(|part| part[1] - part[0] > SHORTEST) {
            let length = part[1] - part[0];
            let is_inside = inside(on_side(ends, bulge, 0.5 * (part[0] + part[1]))) >= 0.0;
            first.get_or_insert(is_inside);
            if is_inside {
                if let Some(at) = end.filter(|_| !was_inside) {
                    kept.push(straight(at));
                }
                kept.push(Corner {
                    at: on_side(ends, bulge, part[0]),
                    bulge: bulge.map(|x| length * length * x),
                    rim: corner.rim.map(|rim| rim.part([part[0], part[1]])),
                });
                end = Some(on_side(ends, bulge, part[1]));
            }
            was_inside = is_inside;
        }
    }
    if let Some(at) = end.filter(|_| !(was_inside && first == Some(true))) {
        kept.push(straight(at));
    }
    kept
}

/// A corner before a straight side.
pub(super) fn straight(at: At) -> Corner {
    Corner {
        at,
        bulge: [0.0; 2],
        rim: None,
    }
}

/// The part of a polygon on the face.
pub(super) fn on_face(mut polygon: Polygon) -> Polygon {
    for k in 0..3 {
        polygon = clipped(&polygon, &|at| coordinates(at)[k]);
    }
    polygon
}

/// A triangle between a point and a side.
#[derive(Clone, Copy, Debug)]
pub struct Wedge {
    centre: At,
    ends: [At; 2],
    bulge: At,
}

impl Wedge {
    /// The place at barycentric coordinates, and twice the area there of that of a rule's weight.
    pub fn place(&self, [r, s, t, _]: [f64; 4]) -> (At, f64) {
        let ([a, b], m) = (self.ends, self.bulge);
        let at = [0, 1].map(|i| r * self.centre[i] + s * a[i] + t * b[i] + 4.0 * s * t * m[i]);
        let u = [0, 1].map(|i| a[i] - self.centre[i] + 4.0 * t * m[i]);
        let v = [0, 1].map(|i| b[i] - self.centre[i] + 4.0 * s * m[i]);
        (at, u[0] * v[1] - u[1] * v[0])
    }
}

/// The triangles between the middle of a polygon and its sides, whose areas have signs.
pub fn wedges(polygon: &Polygon) -> Vec<Wedge> {
    let centre = middle(polygon);
    let wedge = |(ends, bulge)| Wedge {
        centre,
        ends,
        bulge,
    };
    sides(polygon).map(wedge).collect()
}

/// Area of a triangle, positive counterclockwise.
fn area([a, b, c]: [At; 3]) -> f64 {
    0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
}

/// The triangles between the first corner of a polygon and its other ones.
fn fan(polygon: &Polygon) -> impl Iterator<Item = [At; 3]> + '_ {
    let first = polygon.first().map(|corner| corner.at).unwrap_or_default();
    let rest = polygon.get(1..).unwrap_or(&[]);
    rest.windows(2)
        .map(move |pair| [first, pair[0].at, pair[1].at])
}

/// Area of a polygon.
pub(super) fn whole(polygon: &Polygon) -> f64 {
    let beside =
        sides(polygon).map(|([a, b], m)| 2.0 / 3.0 * (m[0] * (b[1] - a[1]) - m[1] * (b[0] - a[0])));
    fan(polygon).map(area).sum::<f64>() + beside.sum::<f64>()
}

/// The middle of a polygon with straight sides.
pub(super) fn middle(polygon: &Polygon) -> At {
    let mut sums = [0.0; 3];
    for triangle in fan(polygon) {
        let own = area(triangle);
        sums[2] += own;
        for i in 0..2 {
            sums[i] += own / 3.0 * triangle.iter().map(|at| at[i]).sum::<f64>();
        }
    }
    if sums[2] > LEAST {
        return [sums[0] / sums[2], sums[1] / sums[2]];
    }
    // Little more than a side.
    let count = polygon.len().max(1) as f64;
    [0, 1].map(|i| polygon.iter().map(|corner| corner.at[i]).sum::<f64>() / count)
}

/// The parts of a polygon outside of another one, whose sides count as straight.
pub(super) fn without(polygon: Polygon, other: &Polygon) -> Vec<Polygon> {
    let mut left = vec![polygon];
    for triangle in fan(other).filter(|own| area(*own) > LEAST) {
        left = left
            .into_iter()
            .flat_map(|own| outside(own, triangle))
            .collect();
    }
    left
}

/// The parts of a polygon outside of a triangle.
fn outside(mut polygon: Polygon, triangle: [At; 3]) -> Vec<Polygon> {
    let mut parts = Vec::new();
    for k in 0..3 {
        let ends = [triangle[k], triangle[(k + 1) % 3]];
        let left = |at: At| area([ends[0], ends[1], at]);
        let part = clipped(&polygon, &|at| -left(at));
        if whole(&part) > LEAST {
            parts.push(part);
        }
        polygon = clipped(&polygon, &left);
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polygon(corners: &[[f64; 4]]) -> Polygon {
        let corner = |&[x, y, m, n]: &[f64; 4]| Corner {
            at: [x, y],
            bulge: [m, n],
            rim: None,
        };
        corners.iter().map(corner).collect()
    }

    #[test]
    fn a_clipped_polygon_and_the_rest_are_the_polygon() {
        let round = polygon(&[
            [0.1, -0.2, 0.05, -0.02],
            [0.9, 0.1, 0.03, 0.1],
            [0.4, 0.7, -0.06, 0.01],
        ]);
        for [x, y, c] in [[1.0, 0.3, -0.4], [-0.2, 1.0, 0.1], [0.0, -1.0, 0.03]] {
            let line = |at: At| x * at[0] + y * at[1] + c;
            let [own, rest] = [clipped(&round, &line), clipped(&round, &|at| -line(at))];
            let [own, rest, all] = [&own, &rest, &round].map(whole);
            assert!(own > 0.0 && rest > 0.0 && (own + rest - all).abs() < 1e-14);
        }
    }

    #[test]
    fn wedges_have_the_area_of_their_polygon() {
        let round = polygon(&[
            [0.1, 0.0, 0.05, -0.02],
            [0.9, 0.1, 0.03, 0.1],
            [0.4, 0.7, -0.06, 0.01],
        ]);
        // The middle of each side of a triangle has a third of the weight.
        let points = [
            [0.5, 0.5, 0.0, 0.0],
            [0.5, 0.0, 0.5, 0.0],
            [0.0, 0.5, 0.5, 0.0],
        ];
        let area_of = |wedge: Wedge| {
            let own = points.map(|l| wedge.place(l).1);
            own.iter().sum::<f64>() / 6.0
        };
        let sum: f64 = wedges(&round).into_iter().map(area_of).sum();
        assert!((sum - whole(&round)).abs() < 1e-15, "{sum}");
    }
}
