//! The nearest point of a flat triangle (Ericson, Real-Time Collision Detection, 5.1.5): which of
//! the regions of corners, edges and inside a point is in, by signs of products.

use crate::geometry::vector3::{add, dot, scale, sub};

/// Square of the sine between two edges below which a triangle is a sliver.
const SLIVER: f64 = 1e-12;

/// The nearest point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// Its barycentric coordinates.
    pub(super) l: [f64; 3],
    /// Square of the distance to it.
    pub(super) square: f64,
}

/// The nearest point of the triangle to `x`.
pub(super) fn nearest(x: [f64; 3], [a, b, c]: [[f64; 3]; 3]) -> Place {
    let l = coordinates(x, [a, b, c]);
    let point = add(a, add(scale(l[1], sub(b, a)), scale(l[2], sub(c, a))));
    let offset = sub(x, point);
    Place {
        l,
        square: dot(offset, offset),
    }
}

fn coordinates(x: [f64; 3], [a, b, c]: [[f64; 3]; 3]) -> [f64; 3] {
    let (ab, ac) = (sub(b, a), sub(c, a));
    let from = |corner: [f64; 3]| {
        let offset = sub(x, corner);
        (dot(ab, offset), dot(ac, offset))
    };
    let (d1, d2) = from(a);
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let (d3, d4) = from(b);
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let t = d1 / (d1 - d3);
        return [1.0 - t, t, 0.0];
    }
    let (d5, d6) = from(c);
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let t = d2 / (d2 - d6);
        return [1.0 - t, 0.0, t];
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return [0.0, 1.0 - t, t];
    }
    let whole = va + vb + vc;
    if whole <= SLIVER * dot(ab, ab) * dot(ac, ac) {
        return on_edges(x, [a, b, c]);
    }
    let (v, w) = (vb / whole, vc / whole);
    [1.0 - v - w, v, w]
}

/// The nearest point of the three edges: in slivers products are rounding.
fn on_edges(x: [f64; 3], corners: [[f64; 3]; 3]) -> [f64; 3] {
    let on_edge = |from: usize| {
        let to = (from + 1) % 3;
        let along = sub(corners[to], corners[from]);
        let offset = sub(x, corners[from]);
        let t = (dot(offset, along) / dot(along, along)).clamp(0.0, 1.0);
        let rest = sub(offset, scale(t, along));
        let mut l = [0.0; 3];
        l[from] = 1.0 - t;
        l[to] = t;
        (dot(rest, rest), l)
    };
    let [first, second, third] = [0, 1, 2].map(on_edge);
    let nearer = |a: (f64, [f64; 3]), b: (f64, [f64; 3])| if b.0 < a.0 { b } else { a };
    nearer(nearer(first, second), third).1
}
