//! Where contact ends on the faces of a surface in space.
//!
//! The pressure is above zero on every face that one of its functions reaches, so that its zeros
//! are sides of faces whatever the true edge is. The gap beyond shows where the body leaves the
//! obstacle: psi of `node_gaps` is continued linearly onto the pressed faces,
//!
//! ```text
//! psi(x) = mean over w of psi(w) + G_w . (x - x_w),   contact where it is below zero
//! ```
//!
//! w: corner of the pressed face that faces without pressure share, G_w the slope of psi there
//! over their quarters at w. A face without such a corner is in contact as a whole: contact that
//! fills a smooth patch of the surface ends with it. Cost: some 100 flops a face.

use super::node_gaps::NodeGaps;
use super::portion::{Point, below_zero, whole};
use crate::geometry::vector3::{add, dot, scale, sub};

/// Middles of the edges at each corner, among the nodes of a face.
const MIDDLES: [[usize; 2]; 3] = [[3, 4], [3, 5], [4, 5]];

/// psi at a corner, and its slope on the faces without pressure around.
#[derive(Clone, Copy, Debug, Default)]
struct Beyond {
    value: f64,
    place: [f64; 3],
    /// Slope times the weight.
    slope: [f64; 3],
    /// Sizes of the faces' quarters at the corner; zero where no face without pressure is.
    weight: f64,
}

impl Beyond {
    /// The function there, continued to `place`.
    fn at(&self, place: [f64; 3]) -> f64 {
        self.value + dot(self.slope, sub(place, self.place)) / self.weight
    }
}

/// Functions of the corners of a face.
fn at_corners<'g>(gaps: &NodeGaps<'g>, face: usize) -> &'g [u32] {
    &gaps.surface.faces[face].functions[..gaps.corners]
}

/// `pressed` with the faces beside whose common corner the obstacle reaches `[faces]`.
fn grown(gaps: &NodeGaps<'_>, pressed: &[bool]) -> Vec<bool> {
    let mut is_reached = vec![false; gaps.surface.carriers.len()];
    for face in (0..pressed.len()).filter(|&face| pressed[face]) {
        for (corner, &function) in at_corners(gaps, face).iter().enumerate() {
            is_reached[function as usize] |= gaps.node(face, corner).0 <= 0.0;
        }
    }
    let reaches = |&function: &u32| is_reached[function as usize];
    let faces = pressed.iter().enumerate();
    faces
        .map(|(face, is_pressed)| *is_pressed || at_corners(gaps, face).iter().any(reaches))
        .collect()
}

/// What is beyond the pressed faces, at the functions of corners `[functions]`.
fn beyond(gaps: &NodeGaps<'_>, pressed: &[bool]) -> Vec<Beyond> {
    let mut all = vec![Beyond::default(); gaps.surface.carriers.len()];
    for face in (0..pressed.len()).filter(|&face| !pressed[face]) {
        for (corner, &function) in at_corners(gaps, face).iter().enumerate() {
            let Some((slope, size)) = slope(gaps, face, corner) else {
                continue;
            };
            let own = &mut all[function as usize];
            own.value = gaps.psi(face, corner);
            own.place = gaps.node(face, corner).1;
            own.slope = add(own.slope, scale(size, slope));
            own.weight += size;
        }
    }
    all
}

/// Slope of psi over the quarter of a face at a corner, and the size of that; none where it has
/// none.
fn slope(gaps: &NodeGaps<'_>, face: usize, corner: usize) -> Option<([f64; 3], f64)> {
    let (_, place) = gaps.node(face, corner);
    let value = gaps.psi(face, corner);
    let [(a, of_a), (b, of_b)] = MIDDLES[corner].map(|node| {
        let along = sub(gaps.node(face, node).1, place);
        (along, gaps.psi(face, node) - value)
    });
    let (aa, ab, bb) = (dot(a, a), dot(a, b), dot(b, b));
    let gram = aa * bb - ab * ab;
    let slope = add(
        scale((of_a * bb - of_b * ab) / gram, a),
        scale((of_b * aa - of_a * ab) / gram, b),
    );
    (gram > 0.0).then(|| (slope, gram.sqrt()))
}

/// The part of a pressed face in contact.
fn portion(gaps: &NodeGaps<'_>, face: usize, beyond: &[Beyond]) -> Vec<Point> {
    let corners = at_corners(gaps, face).iter();
    let known = corners.map(|&function| &beyond[function as usize]);
    let known: Vec<&Beyond> = known.filter(|one| one.weight > 0.0).collect();
    if known.is_empty() {
        return whole(gaps.corners);
    }
    below_zero([0, 1, 2].map(|corner| {
        let (_, place) = gaps.node(face, corner);
        let sum: f64 = known.iter().map(|one| one.at(place)).sum();
        sum / known.len() as f64
    }))
}

/// The faces in contact with their parts; `pressed` marks those that the pressure acts on
/// `[faces]`, of which all are in contact as a whole where none seems to be.
pub(super) fn portions(gaps: &NodeGaps<'_>, pressed: &[bool]) -> Vec<(usize, Vec<Point>)> {
    let marked =
        |marks: &[bool]| -> Vec<usize> { (0..marks.len()).filter(|&face| marks[face]).collect() };
    let grown = grown(gaps, pressed);
    let beyond = beyond(gaps, &grown);
    let parts = marked(&grown).into_iter();
    let parts = parts.map(|face| (face, portion(gaps, face, &beyond)));
    let parts: Vec<_> = parts.filter(|(_, part)| !part.is_empty()).collect();
    if parts.is_empty() {
        let faces = marked(pressed).into_iter();
        return faces.map(|face| (face, whole(gaps.corners))).collect();
    }
    parts
}
