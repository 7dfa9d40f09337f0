//! Stretches of contact along the surface of a plane body or a section: faces under pressure that
//! follow each other, with the ends of contact found inside the faces.
//!
//! The pressure is above zero on every face that one of its functions reaches, and the gap at the
//! first face without pressure still feels that; psi of `node_gaps` at the nodes of the second is
//! smooth. Where it grows away from contact, the end is at its zero,
//!
//! ```text
//! x(psi) = sum_i x_i prod_(j != i) (psi - psi_j) / (psi_i - psi_j)   at psi = 0, x along the surface
//! ```
//!
//! if that lies on the last pressed face or the first without pressure; else at the zero of the
//! line through the first two nodes beyond. Contact that fills a smooth patch of the surface ends
//! with it. Lengths are those of the deformed, scaled body. Cost: one sort of the faces.

use std::collections::BTreeMap;

use super::node_gaps::NodeGaps;
use super::portion::Point;
use super::surface::ContactSurface;
use crate::geometry::vector3::{norm, sub};

/// Faces in contact with the shares of their lengths where that begins and ends.
pub(super) type Stretch = Vec<(usize, [f64; 2])>;

/// A part of a segment as barycentric coordinates.
pub(super) fn polygon([from, to]: [f64; 2]) -> [Point; 2] {
    [from, to].map(|share| [1.0 - share, share, 0.0])
}

/// The order of faces along the surface, the body on the left.
pub(super) struct Order {
    /// The face after and before each `[2][faces]`, on the same smooth patch or not.
    beside: [Vec<Option<usize>>; 2],
}

impl Order {
    /// Of the faces of `surface`.
    pub(super) fn of(surface: &ContactSurface) -> Self {
        let faces = || surface.faces.iter().enumerate();
        let starts: BTreeMap<u32, usize> =
            faces().map(|(at, face)| (face.corners[0], at)).collect();
        let next = surface.faces.iter();
        let next = next.map(|face| starts.get(&face.corners[1]).copied());
        let next: Vec<Option<usize>> = next.collect();
        let mut previous = vec![None; next.len()];
        for (face, next) in next.iter().enumerate() {
            if let Some(next) = next {
                previous[*next] = Some(face);
            }
        }
        Self {
            beside: [next, previous],
        }
    }

    /// Faces one after the other: curves that do not close from their starts, then the others.
    pub(super) fn faces(&self) -> Vec<usize> {
        let [next, previous] = &self.beside;
        let all = 0..next.len();
        let heads = all.clone().filter(|&face| previous[face].is_none());
        let mut is_done = vec![false; next.len()];
        let mut order = Vec::with_capacity(next.len());
        for first in heads.chain(all) {
            let mut face = Some(first);
            while let Some(own) = face.filter(|&own| !is_done[own]) {
                is_done[own] = true;
                order.push(own);
                face = next[own];
            }
        }
        order
    }

    /// Runs of pressed faces, in the order of their first faces.
    pub(super) fn runs(&self, pressed: &[bool]) -> Vec<Vec<usize>> {
        let [next, previous] = &self.beside;
        let order = self.faces();
        let is_first = |face: &&usize| {
            pressed[**face] && !previous[**face].is_some_and(|before| pressed[before])
        };
        let mut is_done = vec![false; pressed.len()];
        let mut runs = Vec::new();
        // A closed curve under pressure all round has no first face.
        for &first in order.iter().filter(is_first).chain(&order) {
            let mut run = Vec::new();
            let mut face = Some(first);
            while let Some(own) = face.filter(|&own| pressed[own] && !is_done[own]) {
                is_done[own] = true;
                run.push(own);
                face = next[own];
            }
            runs.push(run);
        }
        runs.retain(|run| !run.is_empty());
        runs
    }
}

/// An end of a run of pressed faces, seen from inside contact.
struct End<'g, 's> {
    gaps: &'g NodeGaps<'s>,
    order: &'g Order,
    pressed: &'g [bool],
    /// 0 at the end of a run, 1 at its start: the side of `Order` and the corner that is first met.
    side: usize,
}

impl End<'_, '_> {
    /// The face beyond, without pressure and on the same smooth patch.
    fn beyond(&self, face: usize) -> Option<usize> {
        let beyond = self.order.beside[self.side][face].filter(|&next| !self.pressed[next])?;
        let functions = |face: usize| &self.gaps.surface.faces[face].functions;
        let (far, near) = (1 - self.side, self.side);
        (functions(face)[far] == functions(beyond)[near]).then_some(beyond)
    }

    /// Places on the way and psi at the nodes of a face whose near corner is at `from`.
    fn nodes(&self, face: usize, from: f64) -> [[f64; 2]; 3] {
        let nodes = [self.side, 2, 1 - self.side];
        let mut way = from;
        let mut before = self.gaps.node(face, nodes[0]).1;
        nodes.map(|node| {
            let (_, place) = self.gaps.node(face, node);
            way += norm(sub(place, before));
            before = place;
            [way, self.gaps.psi(face, node)]
        })
    }

    /// The faces at the end and the share of each that is in contact, counted from inside: `last`,
    /// the last pressed face, and where contact goes on beyond it the next.
    fn found(&self, last: usize) -> (f64, Option<(usize, f64)>) {
        let Some(first) = self.beyond(last) else {
            return (1.0, None);
        };
        let [[from, _], _, [length, _]] = self.nodes(last, 0.0);
        let near = self.nodes(first, length - from);
        let far = near[2][0];
        let second = self.beyond(first).map(|face| self.nodes(face, far));
        let end = second
            .and_then(smooth_end)
            .filter(|end| (0.0..=far).contains(end));
        let end = end.unwrap_or_else(|| linear_end(near).max(0.0).min(length));
        if end > length {
            (1.0, Some((first, (end - length) / (far - length))))
        } else {
            (end / length, None)
        }
    }
}

/// Zero of psi by inverse interpolation, where it grows from above zero.
fn smooth_end(nodes: [[f64; 2]; 3]) -> Option<f64> {
    let [[a, of_a], [b, of_b], [c, of_c]] = nodes;
    let is_growing = 0.0 < of_a && of_a < of_b && of_b < of_c;
    is_growing.then(|| {
        a * of_b * of_c / ((of_a - of_b) * (of_a - of_c))
            + b * of_a * of_c / ((of_b - of_a) * (of_b - of_c))
            + c * of_a * of_b / ((of_c - of_a) * (of_c - of_b))
    })
}

/// Zero of the line through psi at the first two nodes; the first where it does not grow.
fn linear_end([[a, of_a], [b, of_b], _]: [[f64; 2]; 3]) -> f64 {
    if of_b > of_a {
        a - of_a * (b - a) / (of_b - of_a)
    } else {
        a
    }
}

/// The stretches of contact; `pressed` marks the faces that the pressure acts on `[faces]`.
pub(super) fn stretches(gaps: &NodeGaps<'_>, pressed: &[bool]) -> Vec<Stretch> {
    let order = Order::of(gaps.surface);
    let ends = [0, 1].map(|side| End {
        gaps,
        order: &order,
        pressed,
        side,
    });
    let runs = order.runs(pressed).into_iter();
    runs.map(|run| stretch(&run, &ends)).collect()
}

/// The stretch of one run of pressed faces.
fn stretch(run: &[usize], [end, start]: &[End<'_, '_>; 2]) -> Stretch {
    let mut parts: Stretch = run.iter().map(|&face| (face, [0.0, 1.0])).collect();
    let (mut before, mut after) = (None, None);
    if let (Some(first), Some(last)) = (run.first(), run.last()) {
        let (of_first, of_last) = (start.found(*first), end.found(*last));
        (before, after) = (of_first.1, of_last.1);
        parts[0].1[0] = 1.0 - of_first.0;
        parts[run.len() - 1].1[1] = of_last.0;
    }
    // Ends that pass each other say nothing.
    let passed = parts.iter_mut().filter(|(_, [from, to])| from >= to);
    passed.for_each(|(_, share)| *share = [0.0, 1.0]);
    let before = before.map(|(face, share)| (face, [1.0 - share, 1.0]));
    let after = after.map(|(face, share)| (face, [0.0, share]));
    before.into_iter().chain(parts).chain(after).collect()
}
