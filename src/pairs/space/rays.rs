//! Where rays of a face meet another one, and which ray of a face passes a point.
//!
//! ```text
//! y(l') - g n = x   for l', g at a place of the face;    x(l) + g n(l) = y   for l, g at a point y
//! ```
//!
//! by Newton's method from the flat triangle between the corners, on which it is exact in one step if
//! normals are all alike. Cost: some 150 flops a step, one to five steps.

use super::patch::{At, Patch};
use crate::geometry::vector3::{add, cross, dot, norm, scale, sub};

/// Steps at most; from flat to curved faces five are enough for rounding.
const STEPS: usize = 12;
/// Change of a place on a face after which the next one is rounding: steps square what is left.
const SETTLED: f64 = 1e-9;
/// How far from where the flat face has it a place is believed, in face coordinates: beyond, parabolas
/// turn back.
const BELIEVED: f64 = 0.5;

/// A face with the normals at its corners.
#[derive(Clone, Copy, Debug)]
pub struct Rayed {
    /// The face.
    pub patch: Patch,
    /// Unit normals at its corners, out of the body.
    pub normals: [[f64; 3]; 3],
}

/// A ray of a face.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Where it begins.
    pub from: [f64; 3],
    /// n, about of unit length.
    pub along: [f64; 3],
}

/// Where a ray meets a face.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Place on the face that is met.
    pub at: At,
    /// g.
    pub gap: f64,
}

impl Rayed {
    /// n_,1 and n_,2.
    pub fn turns(&self) -> [[f64; 3]; 2] {
        let [a, b, c] = self.normals;
        [sub(b, a), sub(c, a)]
    }

    /// n at a place.
    pub fn normal(&self, [s, t]: At) -> [f64; 3] {
        let [first, second] = self.turns();
        add(self.normals[0], add(scale(s, first), scale(t, second)))
    }

    /// The ray at a place.
    pub fn ray(&self, at: At) -> Ray {
        Ray {
            from: self.patch.point(at),
            along: self.normal(at),
        }
    }

    /// Where the ray begins that passes `y`.
    pub fn below(&self, y: [f64; 3]) -> At {
        let mean = self.normal([1.0 / 3.0; 2]);
        let flat = flat(&self.patch, (y, mean));
        let ([mut s, mut t], mut gap) = (flat.at, -flat.gap);
        let turns = self.turns();
        for _ in 0..STEPS {
            let at = [s, t];
            let n = self.normal(at);
            let [first, second] = self.patch.tangents(at);
            let columns = [
                add(first, scale(gap, turns[0])),
                add(second, scale(gap, turns[1])),
                n,
            ];
            let miss = sub(y, add(self.patch.point(at), scale(gap, n)));
            let Some([ds, dt, dg]) = solved(columns, miss) else {
                return flat.at;
            };
            (s, t, gap) = (s + ds, t + dt, gap + dg);
            if !is_near([s, t], flat.at) {
                return flat.at;
            }
            if ds.abs().max(dt.abs()) < SETTLED {
                break;
            }
        }
        [s, t]
    }
}

/// Where `ray` meets a face; none where Newton's method finds no place.
pub fn hit(patch: &Patch, ray: Ray) -> Option<Hit> {
    let mut found = flat(patch, (ray.from, ray.along));
    let start = found.at;
    for _ in 0..STEPS {
        let [first, second] = patch.tangents(found.at);
        let miss = sub(
            add(ray.from, scale(found.gap, ray.along)),
            patch.point(found.at),
        );
        let [ds, dt, dg] = solved([first, second, scale(-1.0, ray.along)], miss)?;
        found = Hit {
            at: [found.at[0] + ds, found.at[1] + dt],
            gap: found.gap + dg,
        };
        if !is_near(found.at, start) {
            return None;
        }
        if ds.abs().max(dt.abs()) < SETTLED {
            break;
        }
    }
    Some(found)
}

fn is_near(a: At, b: At) -> bool {
    (0..2).all(|i| (a[i] - b[i]).abs() <= BELIEVED * (1.0 + b[i].abs()))
}

/// Where the line through `from` along `along` meets the flat triangle of a face.
fn flat(patch: &Patch, (from, along): ([f64; 3], [f64; 3])) -> Hit {
    let [a, b, c, ..] = patch.nodes;
    let found = solved([sub(b, a), sub(c, a), scale(-1.0, along)], sub(from, a));
    let [s, t, gap] = found.unwrap_or_default();
    Hit { at: [s, t], gap }
}

/// x of sum x_k column_k = b; none where columns are in a plane.
fn solved([p, q, r]: [[f64; 3]; 3], b: [f64; 3]) -> Option<[f64; 3]> {
    let across = cross(q, r);
    let determinant = dot(p, across);
    if determinant.abs() <= 1e-9 * norm(p) * norm(q) * norm(r) {
        return None;
    }
    let x = [dot(b, across), dot(p, cross(b, r)), dot(p, cross(q, b))];
    Some(x.map(|x| x / determinant))
}
