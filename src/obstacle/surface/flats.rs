//! Flat parts of a triangulation: facets that lie in one plane, up to what numbers of seven digits
//! round. A large part beside a small one is the face of a body beside a rounding, or the strip of a
//! cylinder beside that of its rim. There the curvature jumps: vertices of the one say nothing of
//! the other, and the normal at the border is that of the large one.

use crate::parallel;
use rayon::prelude::*;

use super::TriangulatedSurface;
use crate::geometry::vector3::{cross, dot, norm, sub};

/// Angle between normals of one plane.
const IN_PLANE: f64 = 1e-5;
/// Rounding of coordinates in files, over the largest of them.
const ROUNDING: f64 = 2e-7;
/// Area of a part over that of another at the same vertex from which on the other is small.
const SMALL: f64 = 4.0;

/// The flat parts.
pub(super) struct Flats {
    /// The part of each facet, named by one of its facets.
    part: Vec<u32>,
    /// Area of each part, at the facet that names it.
    area: Vec<f64>,
}

impl Flats {
    /// Those of `surface` with the normals `flat`.
    pub(super) fn new(surface: &TriangulatedSurface, flat: &[[f64; 3]]) -> Self {
        let largest = surface.vertices().as_flattened().iter();
        let rounding = ROUNDING * largest.fold(0.0_f64, |most, x| most.max(x.abs()));
        let sizes = parallel::map(flat.len(), 1, &|facet| {
            sizes(surface.corners(facet), rounding)
        });
        let is_one = |facet: usize, other: usize| {
            let turned = norm(sub(flat[facet], flat[other]));
            turned <= IN_PLANE + sizes[facet].1 + sizes[other].1
        };
        let across = surface.linked.across.par_iter().enumerate();
        let joined = across.flat_map_iter(|(facet, across)| {
            let others = across.iter().map(move |&other| (facet, other as usize));
            others.filter(|&(facet, other)| other > facet && is_one(facet, other))
        });
        let joined: Vec<(usize, usize)> = joined.collect();
        let mut part: Vec<u32> = (0..flat.len() as u32).collect();
        for (facet, other) in joined {
            let [a, b] = [root(&mut part, facet), root(&mut part, other)];
            part[a.max(b)] = a.min(b) as u32;
        }
        for facet in 0..part.len() {
            part[facet] = root(&mut part, facet) as u32;
        }
        let mut area = vec![0.0; part.len()];
        for (name, (own, _)) in part.iter().zip(&sizes) {
            area[*name as usize] += own;
        }
        Self { part, area }
    }

    /// Area of the part of a facet, twice.
    pub(super) fn area_of(&self, facet: usize) -> f64 {
        self.area[self.part[facet] as usize]
    }

    /// Least and largest area of the parts of some facets, twice.
    pub(super) fn range(&self, facets: &[usize]) -> [f64; 2] {
        let areas = facets.iter().map(|&facet| self.area_of(facet));
        areas.fold([f64::INFINITY, 0.0], |[least, most], area| {
            [least.min(area), most.max(area)]
        })
    }

    /// Whether one of the parts is small beside another one.
    pub(super) fn are_uneven(&self, facets: &[usize]) -> bool {
        let [least, most] = self.range(facets);
        most >= SMALL * least
    }

    /// Whether the facets are of one part.
    pub(super) fn are_one(&self, facets: &[usize]) -> bool {
        let mut parts = facets.iter().map(|&facet| self.part[facet]);
        let first = parts.next();
        parts.all(|part| Some(part) == first)
    }

    /// Whether the part of a facet is about as large as those of others.
    pub(super) fn is_like(&self, facets: &[usize]) -> impl Fn(usize) -> bool {
        let range = self.range(facets);
        move |facet| is_like(range, self.area_of(facet))
    }

    /// One facet of each part that is not small beside another, ascending.
    pub(super) fn large(&self, facets: &[usize]) -> Vec<usize> {
        let areas = facets.iter().map(|&facet| self.area_of(facet));
        let most = areas.fold(0.0, f64::max);
        let mut seen = Vec::new();
        let is_first = |facet: &usize| {
            let name = self.part[*facet];
            let is_new = !seen.contains(&name);
            seen.push(name);
            is_new && SMALL * self.area_of(*facet) > most
        };
        facets.iter().copied().filter(is_first).collect()
    }
}

/// Whether an area is about as large as those from the least to the most.
pub(super) fn is_like([least, most]: [f64; 2], area: f64) -> bool {
    (least / SMALL..most * SMALL).contains(&area)
}

/// Twice the area of a facet, and the angle by which rounding turns it.
fn sizes([a, b, c]: [[f64; 3]; 3], rounding: f64) -> (f64, f64) {
    let twice_area = norm(cross(sub(b, a), sub(c, a)));
    let squares = [sub(b, a), sub(c, b), sub(a, c)].map(|edge| dot(edge, edge));
    let longest = squares.into_iter().fold(0.0, f64::max).sqrt();
    (twice_area, rounding * longest / twice_area)
}

/// The first facet of a part, which names it; ways to it are halved.
fn root(part: &mut [u32], mut facet: usize) -> usize {
    while part[facet] as usize != facet {
        part[facet] = part[part[facet] as usize];
        facet = part[facet] as usize;
    }
    facet
}
