//! Faces of a surface in space at rest, flat, and whether two of them look at each other across a crease.

use super::patch::Patch;
use super::shell::place_at_rest;
use super::skin::SkinFace;
use crate::contact::patches::SMOOTH;
use crate::geometry::vector3::{dot, norm, scale, sub};
use crate::mesh::Mesh;
use crate::space::TaylorHood;

/// How far one face is in front of another over their sizes, without unit: less is rounding.
const IN_FRONT: f64 = 1e-9;

/// A face at rest.
#[derive(Clone, Copy, Debug)]
pub(super) struct Still {
    /// Mean of its corners.
    pub(super) middle: [f64; 3],
    /// Unit normal.
    pub(super) normal: [f64; 3],
    /// Square root of twice its area.
    pub(super) size: f64,
}

impl Still {
    /// A face by its nodes at rest.
    pub(super) fn new(ground: (&Mesh, &TaylorHood), face: &SkinFace) -> Self {
        let patch = at_rest(ground, face);
        let flat = Patch {
            nodes: [0, 1, 2, 3, 4, 5].map(|k: usize| if k < 3 { patch.nodes[k] } else { [0.0; 3] }),
        };
        let middle = [1.0 / 3.0; 2];
        let area = flat.area_vector(middle);
        let size = norm(area);
        Self {
            middle: flat.point(middle),
            normal: scale(size.recip(), area),
            size: size.sqrt(),
        }
    }

    /// Whether `other` lies in front of it.
    fn sees(&self, other: &Self) -> bool {
        dot(self.normal, sub(other.middle, self.middle)) > IN_FRONT * other.size
    }
}

/// Whether two faces with a common vertex make a corner that points into the body, by more than smooth
/// surfaces turn.
pub(super) fn are_across([a, b]: [Still; 2]) -> bool {
    dot(a.normal, b.normal) < SMOOTH && a.sees(&b) && b.sees(&a)
}

/// A face where its nodes are at rest.
pub(super) fn at_rest(ground: (&Mesh, &TaylorHood), face: &SkinFace) -> Patch {
    Patch {
        nodes: face.nodes.map(|node| place_at_rest(ground, node)),
    }
}
