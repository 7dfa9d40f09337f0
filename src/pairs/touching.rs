//! Where linear bodies touch that are apart at rest, or inside each other: gaps are taken there, the
//! other surface moved by d, and carried back to rest along their derivatives.
//!
//! ```text
//! T_j = dG_j by a motion of the other surface,   g_j = G_j / |T_j|,   g = the least of them
//! w_j = (g / g_j)^8, or (g_j / g)^8 inside,   D = sum w_j T_j, as a unit vector
//! d = -D sum w_j (T_j.D) g_j / sum w_j (T_j.D)^2 / |T_j|
//! ```
//!
//! Rays fan out from a curved surface: those of a ball meet another one, a gap g away, on a part that is
//! wider by g over the radius. Points that meet in the end are opposite where the surfaces touch. Nothing
//! moves where normals of what is nearest point all around, as in a ring, along components that supports
//! hold at what is nearest, across an axis, and between parts of one body. Cost: two more evaluations of
//! the gaps, once.

use super::piece::Section;
use super::surface::{PairSurface, Sides};
use crate::contact::{ContactSurface, Deformed, Linearisation};
use crate::geometry::vector3::{add, dot, norm, scale};

/// Times the surfaces are brought to touch; each leaves about a tenth of the gap.
const PASSES: usize = 2;
/// Power by which nearer parts count for more; chosen.
const SHARPNESS: i32 = 8;
/// Share of all normals that their sum must have, for it to be a direction; chosen.
const ALIKE: f64 = 0.5;
/// Weight from which on a part is near: what supports hold there is not moved; chosen.
const NEAR: f64 = 0.1;
/// Gaps below this, over the length of the body, are none.
const NONE: f64 = 1e-9;

/// G, T and g of a function.
struct Facing {
    gap: f64,
    by_motion: [f64; 3],
    distance: f64,
    held: [bool; 3],
}

impl PairSurface {
    /// Displacements at which the surfaces of the linear `body` touch `[displacement unknowns]`.
    pub(super) fn touching(&self, body: &Deformed<'_>, surface: &ContactSurface) -> Vec<f64> {
        let mut moved = body.displacement.to_vec();
        if self.is_folded() {
            return moved;
        }
        let components = body.space.components;
        let vertices = self.other_nodes().into_iter();
        let vertices: Vec<usize> = vertices
            .map(|node| node as usize)
            .filter(|node| *node < body.space.vertices)
            .collect();
        for _ in 0..PASSES {
            let at = Deformed {
                displacement: &moved,
                ..*body
            };
            let found = self.where_it_is(&at, surface);
            let Some(by) = self.nearer(&found, (&vertices, components)) else {
                break;
            };
            for &node in &vertices {
                (0..components).for_each(|i| moved[components * node + i] += by[i]);
            }
        }
        moved
    }

    /// d.
    fn nearer(
        &self,
        found: &Linearisation,
        (vertices, components): (&[usize], usize),
    ) -> Option<[f64; 3]> {
        let rows = found.gap.iter().zip(&found.rows).zip(&self.held);
        let facing = rows
            .filter_map(|((&gap, row), &held)| facing((gap, held), row, (vertices, components)));
        let facing: Vec<Facing> = facing.collect();
        let nearest = facing.iter().map(|own| own.distance);
        let nearest = nearest.min_by(f64::total_cmp)?;
        if nearest.abs() <= NONE {
            return None;
        }
        let weight = |own: &Facing| {
            let ratio = if nearest > 0.0 {
                nearest / own.distance
            } else {
                (own.distance / nearest).max(0.0)
            };
            ratio.powi(SHARPNESS)
        };
        let (mut sum, mut all) = ([0.0; 3], 0.0);
        for own in &facing {
            sum = add(sum, scale(weight(own), own.by_motion));
            all += weight(own) * norm(own.by_motion);
        }
        let near = || facing.iter().filter(|own| weight(own) > NEAR);
        let stays = |i: usize| self.is_radial(i) || near().any(|own| own.held[i]);
        let sum = [0, 1, 2].map(|i| if stays(i) { 0.0 } else { sum[i] });
        let size = norm(sum);
        if size < ALIKE * all {
            return None;
        }
        let along = scale(size.recip(), sum);
        let (mut closed, mut square) = (0.0, 0.0);
        for own in &facing {
            let part = dot(own.by_motion, along);
            let weight = weight(own) * part / norm(own.by_motion);
            closed += weight * own.gap;
            square += weight * part;
        }
        Some(scale(-closed / square, along))
    }

    /// Whether a component is that across an axis.
    fn is_radial(&self, component: usize) -> bool {
        match &self.sides {
            Sides::Plane(plane) => component == 0 && plane.pair.section == Section::AboutAxis,
            Sides::Space(_) => false,
        }
    }
}

/// What a function faces; none without a partner.
fn facing(
    (gap, held): (f64, [bool; 3]),
    row: &[(u32, f64)],
    (vertices, components): (&[usize], usize),
) -> Option<Facing> {
    let mut by_motion = [0.0; 3];
    for &(unknown, value) in row {
        let (node, i) = (unknown as usize / components, unknown as usize % components);
        if vertices.binary_search(&node).is_ok() {
            // Rows are minus the derivative.
            by_motion[i] -= value;
        }
    }
    let size = norm(by_motion);
    (size > 0.0).then(|| Facing {
        gap,
        by_motion,
        distance: gap / size,
        held,
    })
}
