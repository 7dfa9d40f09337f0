//! Normals of the patches at the corners of facets: one for all facets around a vertex that
//! meet smoothly, fitted to the vertices of two rings. Where large facets meet small ones, as
//! flats meet roundings in parts of CAD programs, the vertices around do not show the curvature
//! at the one between them: there the normal is the mean of the facets' by the squares of their
//! areas, near that of the flat.

use std::collections::BTreeSet;

use rayon::prelude::*;

use super::TriangulatedSurface;
use super::fit;
use super::topology::edge;
use crate::geometry::vector3::{add, cross, dot, norm, normalised, scale, sub};

/// Unit normals of the flat facets.
pub(super) fn flat(surface: &TriangulatedSurface) -> Vec<[f64; 3]> {
    let normal = |facet: usize| {
        let [a, b, c] = surface.corners(facet);
        normalised(cross(sub(b, a), sub(c, a))).unwrap_or_default()
    };
    (0..surface.facets.len())
        .into_par_iter()
        .map(normal)
        .collect()
}

/// Whether the edge opposite each corner is a feature: its facets meet at more than `angle`.
pub(super) fn features(
    surface: &TriangulatedSurface,
    flat: &[[f64; 3]],
    angle: f64,
) -> Vec<[bool; 3]> {
    let least = angle.cos();
    let of_facet = |facet: usize| {
        surface.across[facet].map(|other| dot(flat[facet], flat[other as usize]) < least)
    };
    (0..surface.facets.len()).map(of_facet).collect()
}

/// Normals at the corners of all facets.
pub(super) fn corners(
    surface: &TriangulatedSurface,
    flat: &[[f64; 3]],
    features: &[[bool; 3]],
) -> Vec<[[f64; 3]; 3]> {
    let fitter = Fitter {
        surface,
        flat,
        features,
    };
    let of_facet = |facet: usize| [0, 1, 2].map(|corner| fitter.normal(facet, corner));
    (0..surface.facets.len())
        .into_par_iter()
        .map(of_facet)
        .collect()
}

/// Largest over least area around a vertex from which on a fit knows its far side only.
const UNEVEN: f64 = 4.0;

struct Fitter<'a> {
    surface: &'a TriangulatedSurface,
    flat: &'a [[f64; 3]],
    features: &'a [[bool; 3]],
}

impl Fitter<'_> {
    /// Each facet of a sector finds the same vertices in the same order, so that all have one
    /// normal to the bit.
    fn normal(&self, facet: usize, corner: usize) -> [f64; 3] {
        let vertex = self.surface.facets[facet][corner];
        let sector = self.sector(facet, vertex);
        let place = self.surface.vertices[vertex as usize];
        let mut sum = [0.0; 3];
        for &facet in &sector {
            sum = add(sum, scale(self.angle(facet, vertex), self.flat[facet]));
        }
        let Some(guess) = normalised(sum) else {
            return self.flat[facet];
        };
        let fitted = match self.is_uneven(&sector) {
            true => self.mean_by_areas(&sector).unwrap_or(guess),
            false => fit::normal(place, guess, &self.two_rings(&sector, vertex)),
        };
        // A fit that leaves the facets behind is none.
        match sector
            .iter()
            .all(|&facet| dot(fitted, self.flat[facet]) > 0.0)
        {
            true => fitted,
            false => guess,
        }
    }

    /// Whether areas of facets differ so much that they are of different parts.
    fn is_uneven(&self, sector: &BTreeSet<usize>) -> bool {
        let areas = sector.iter().map(|&facet| norm(self.twice_area(facet)));
        let (least, most) = areas.fold((f64::INFINITY, 0.0_f64), |(least, most), area| {
            (least.min(area), most.max(area))
        });
        most >= UNEVEN * least
    }

    /// Normal of a facet, as long as twice its area.
    fn twice_area(&self, facet: usize) -> [f64; 3] {
        let [a, b, c] = self.surface.corners(facet);
        cross(sub(b, a), sub(c, a))
    }

    /// Mean of the facets' normals by the squares of their areas.
    fn mean_by_areas(&self, sector: &BTreeSet<usize>) -> Option<[f64; 3]> {
        let weighted = |&facet: &usize| {
            let twice_area = self.twice_area(facet);
            scale(norm(twice_area), twice_area)
        };
        normalised(sector.iter().map(weighted).fold([0.0; 3], add))
    }

    /// Facets around `vertex` that are reached from `facet` across edges without a feature,
    /// ascending.
    fn sector(&self, facet: usize, vertex: u32) -> BTreeSet<usize> {
        self.flood([facet].into(), |next| {
            self.surface.corner_of(next, vertex).is_some()
        })
    }

    fn flood(&self, start: BTreeSet<usize>, is_in: impl Fn(usize) -> bool) -> BTreeSet<usize> {
        let mut open: Vec<usize> = start.iter().copied().collect();
        let mut found = start;
        while let Some(facet) = open.pop() {
            for opposite in 0..3 {
                let next = self.surface.across[facet][opposite] as usize;
                if !self.features[facet][opposite] && is_in(next) && found.insert(next) {
                    open.push(next);
                }
            }
        }
        found
    }

    /// Places of the vertices of two rings, without the own one, ascending by number.
    fn two_rings(&self, sector: &BTreeSet<usize>, vertex: u32) -> Vec<[f64; 3]> {
        let vertices_of = |facets: &BTreeSet<usize>| -> BTreeSet<u32> {
            let corners = facets.iter().flat_map(|&facet| self.surface.facets[facet]);
            corners.filter(|&corner| corner != vertex).collect()
        };
        let first = vertices_of(sector);
        let meets = |facet: usize| {
            self.surface.facets[facet]
                .iter()
                .any(|one| first.contains(one))
        };
        let wide = self.flood(sector.clone(), meets);
        let places = vertices_of(&wide);
        let place = |&vertex: &u32| self.surface.vertices[vertex as usize];
        places.iter().map(place).collect()
    }

    /// Angle of a facet at one of its vertices.
    fn angle(&self, facet: usize, vertex: u32) -> f64 {
        let Some(corner) = self.surface.corner_of(facet, vertex) else {
            return 0.0;
        };
        let (next, last) = edge(self.surface.facets[facet], corner);
        let place = |vertex: u32| self.surface.vertices[vertex as usize];
        let [a, b] = [next, last].map(|other| sub(place(other), place(vertex)));
        norm(cross(a, b)).atan2(dot(a, b))
    }
}
