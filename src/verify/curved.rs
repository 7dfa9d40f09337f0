//! The true surface over a facet, from the tangents of the facet:
//!
//! ```text
//! o = a t_1 + b t_2 + c n,   do = a dt_1 + b dt_2 + c (I - n n^T) (dt_1 x t_2 + t_1 x dt_2) / |t_1 x t_2|
//! ```
//!
//! with the a, b, c of the undeformed facet. In the plane t_2 is the unit vector out of
//! it. Lengths are those of the scaled body.

use crate::contact::{ContactFace, CurvedFace, Kinematics};
use crate::geometry::vector3::{add, cross, dot, norm, normalised, scale, sub};

/// Tangents of a facet, or how they change.
type Tangents = [[f64; 3]; 2];

/// A curved face of a deformed body.
pub(super) struct Curved<'a> {
    curve: &'a CurvedFace,
    /// Corners of the face.
    count: usize,
    /// Tangents about which offsets are varied.
    tangents: Tangents,
    /// a, b, c of each edge.
    parts: [[f64; 3]; 3],
    /// Offsets of the deformed body.
    offsets: [[f64; 3]; 3],
}

impl<'a> Curved<'a> {
    /// `moved` are the displacements of the corners; none for a flat face.
    pub(super) fn of(face: &'a ContactFace, moved: [[f64; 3]; 3]) -> Option<Self> {
        let (curve, count) = (face.curve.as_deref()?, face.corners.len());
        let at_rest = tangents(&curve.corners, count);
        let parts = curve.offsets.map(|offset| parts(&at_rest, offset));
        let change = changes(&moved, count);
        let now = [0, 1].map(|k| add(at_rest[k], change[k]));
        let tangents = match curve.kinematics {
            Kinematics::Linear => at_rest,
            Kinematics::Finite => now,
        };
        let offset = |edge: usize| match curve.kinematics {
            Kinematics::Linear => add(curve.offsets[edge], varied(&at_rest, parts[edge], &change)),
            Kinematics::Finite => composed(&now, parts[edge]),
        };
        Some(Self {
            offsets: [offset(0), offset(1), offset(2)],
            curve,
            count,
            tangents,
            parts,
        })
    }

    /// How far the point with the edge functions `edges` is off the flat facet: of the
    /// deformed and of the undeformed body.
    pub(super) fn off(&self, edges: &[f64]) -> [[f64; 3]; 2] {
        [&self.offsets, &self.curve.offsets].map(|offsets| {
            let terms = edges.iter().zip(offsets);
            terms.fold([0.0; 3], |sum, (value, offset)| {
                add(sum, scale(*value, *offset))
            })
        })
    }

    /// What `force` at that point does to `corner` by turning and stretching the facet.
    pub(super) fn pull(&self, edges: &[f64], corner: usize, force: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|axis| {
            let mut moved = [[0.0; 3]; 3];
            moved[corner][axis] = 1.0;
            let change = changes(&moved, self.count);
            let works = edges
                .iter()
                .zip(self.parts)
                .map(|(value, parts)| value * dot(force, varied(&self.tangents, parts, &change)));
            works.sum()
        })
    }

    /// Area (length in 2D) per weight of a rule at `l`, undeformed, without any turn: by
    /// central differences of the position, which is quadratic.
    pub(super) fn measure(&self, l: &[f64]) -> f64 {
        let along = |end: usize| {
            let moved = |by: f64| {
                let mut l = l.to_vec();
                l[0] -= by;
                l[end] += by;
                self.curve.position(&l)
            };
            sub(moved(0.5), moved(-0.5))
        };
        match self.count {
            2 => norm(along(1)),
            _ => 0.5 * norm(cross(along(1), along(2))),
        }
    }
}

fn tangents(corners: &[[f64; 3]; 3], count: usize) -> Tangents {
    let second = match count {
        2 => [0.0, 0.0, 1.0],
        _ => sub(corners[2], corners[0]),
    };
    [sub(corners[1], corners[0]), second]
}

fn changes(moved: &[[f64; 3]; 3], count: usize) -> Tangents {
    let second = match count {
        2 => [0.0; 3],
        _ => sub(moved[2], moved[0]),
    };
    [sub(moved[1], moved[0]), second]
}

/// a, b, c of a vector.
fn parts([first, second]: &Tangents, vector: [f64; 3]) -> [f64; 3] {
    let area = cross(*first, *second);
    let normal = normalised(area).unwrap_or_default();
    let size = norm(area);
    [
        dot(vector, cross(*second, normal)) / size,
        dot(vector, cross(normal, *first)) / size,
        dot(vector, normal),
    ]
}

/// The vector with those parts.
fn composed([first, second]: &Tangents, [a, b, c]: [f64; 3]) -> [f64; 3] {
    let normal = normalised(cross(*first, *second)).unwrap_or_default();
    add(add(scale(a, *first), scale(b, *second)), scale(c, normal))
}

/// How a vector with those parts changes with the tangents.
fn varied([first, second]: &Tangents, [a, b, c]: [f64; 3], change: &Tangents) -> [f64; 3] {
    let area = cross(*first, *second);
    let normal = normalised(area).unwrap_or_default();
    let turned = add(cross(change[0], *second), cross(*first, change[1]));
    let along = sub(turned, scale(dot(turned, normal), normal));
    let tangential = add(scale(a, change[0]), scale(b, change[1]));
    add(tangential, scale(c / norm(area), along))
}
