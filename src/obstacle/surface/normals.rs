//! Normals of the patches at the corners of facets: one for all facets around a vertex that
//! meet smoothly, fitted to the vertices of two rings. Where large flats meet small facets, as
//! in parts of CAD programs, the vertices around do not show the curvature at the one between
//! them: there the normal is the mean of the large flats' by the squares of their areas, and fits
//! beside it look at the small ones only. Cost: one fit a vertex and side of a feature.

use super::TriangulatedSurface;
use super::around::{Around, MOST};
use super::fit;
use super::flats::Flats;
use super::rings::Rings;
use super::topology::edge;
use crate::geometry::vector3::{add, cross, dot, norm, normalised, scale, sub};
use crate::parallel;

/// Facets around a corner whose normals are compared, at most.
const MOST_AROUND: usize = 64;
/// Vertices that a thread takes at a time.
const VERTICES: usize = 256;

/// Unit normals of the flat facets.
pub(super) fn flat(surface: &TriangulatedSurface) -> Vec<[f64; 3]> {
    let normal = |facet: usize| {
        let [a, b, c] = surface.corners(facet);
        normalised(cross(sub(b, a), sub(c, a))).unwrap_or_default()
    };
    parallel::map(surface.facets().len(), 1, &normal)
}

/// Whether the edge opposite each corner is a feature: its facets meet at more than `angle`.
pub(super) fn features(
    surface: &TriangulatedSurface,
    flat: &[[f64; 3]],
    angle: f64,
) -> Vec<[bool; 3]> {
    let least = angle.cos();
    let across = &surface.linked.across;
    let of_facet =
        |facet: usize| across[facet].map(|other| dot(flat[facet], flat[other as usize]) < least);
    parallel::map(across.len(), 1, &of_facet)
}

/// Largest difference of the normal of each facet from those of the facets at its corners.
pub(super) fn turns(surface: &TriangulatedSurface, flat: &[[f64; 3]]) -> Vec<f64> {
    let at_corner = |facet: usize, corner: usize| {
        let around = surface.linked.around(facet, corner).take(MOST_AROUND + 1);
        let (mut count, mut most) = (0, 0.0_f64);
        for other in around {
            let difference = sub(flat[facet], flat[other]);
            most = most.max(dot(difference, difference));
            count += 1;
        }
        // As different as normals can be, where there are too many to look at.
        if count > MOST_AROUND { 4.0 } else { most }
    };
    let of_facet = |facet: usize| {
        let squares = [0, 1, 2].map(|corner| at_corner(facet, corner));
        squares.into_iter().fold(0.0, f64::max).sqrt()
    };
    parallel::map(flat.len(), 1, &of_facet)
}

/// Normals at the corners of all facets.
pub(super) struct Corners {
    pub(super) normals: Vec<[[f64; 3]; 3]>,
    /// Whether large flats meet small facets without a feature: there the curvature jumps.
    pub(super) are_uneven: bool,
}

/// Normals at the corners of all facets.
pub(super) fn corners(
    surface: &TriangulatedSurface,
    flat: &[[f64; 3]],
    features: &[[bool; 3]],
) -> Corners {
    let rings = Rings::new(surface.facets(), surface.vertices().len());
    let fitter = Fitter::new(surface, (flat, features), &rings);
    let of_block = |block: usize| {
        let vertices = block * VERTICES..rings.vertices().min((block + 1) * VERTICES);
        let mut normals = Vec::with_capacity(8 * VERTICES);
        let mut are_uneven = false;
        for vertex in vertices {
            are_uneven |= fitter.around(vertex as u32, rings.of(vertex), &mut normals);
        }
        (normals, are_uneven)
    };
    let blocks = parallel::map(rings.vertices().div_ceil(VERTICES), 1, &of_block);
    let are_uneven = blocks.iter().any(|(_, are_uneven)| *are_uneven);
    let normals: Vec<[f64; 3]> = blocks
        .into_iter()
        .flat_map(|(normals, _)| normals)
        .collect();
    let places = &rings.places;
    let at_corner = |facet: usize| places[facet].map(|place| normals[place as usize]);
    Corners {
        normals: parallel::map(places.len(), 1, &at_corner),
        are_uneven,
    }
}

/// Fits normals.
pub(super) struct Fitter<'a> {
    pub(super) around: Around<'a>,
    surface: &'a TriangulatedSurface,
    flat: &'a [[f64; 3]],
    pub(super) flats: Flats,
    features: &'a [[bool; 3]],
}

impl<'a> Fitter<'a> {
    /// On a surface with its flat normals and features.
    pub(super) fn new(
        surface: &'a TriangulatedSurface,
        (flat, features): (&'a [[f64; 3]], &'a [[bool; 3]]),
        rings: &'a Rings,
    ) -> Self {
        let flats = Flats::new(surface, flat);
        Self {
            around: Around::new(&surface.linked, (rings, features), &flats),
            surface,
            flat,
            flats,
            features,
        }
    }

    /// The normals at `vertex` of the facets `ring` around it, added to `normals`; whether some of
    /// them are small beside flats that they meet smoothly.
    fn around(&self, vertex: u32, ring: &[u32], normals: &mut Vec<[f64; 3]>) -> bool {
        let first = normals.len();
        normals.resize(first + ring.len(), [0.0; 3]);
        let mut is_left = vec![true; ring.len()];
        let mut are_uneven = false;
        for next in 0..ring.len() {
            if !is_left[next] {
                continue;
            }
            // Where a sector is cut short the facets beyond it find their own.
            let sector = if self.around.is_plain(vertex) {
                ring.iter().map(|&facet| facet as usize).collect()
            } else {
                self.sector(ring[next] as usize, vertex)
            };
            let is_uneven = self.flats.are_uneven(&sector);
            let normal = self.normal(vertex, &sector, is_uneven);
            are_uneven |= is_uneven;
            for &facet in &sector {
                if let Ok(place) = ring.binary_search(&(facet as u32))
                    && is_left[place]
                {
                    is_left[place] = false;
                    normals[first + place] = normal.unwrap_or(self.flat[facet]);
                }
            }
        }
        are_uneven
    }

    /// The normal of the facets `sector` at `vertex`; none where they cancel.
    fn normal(&self, vertex: u32, sector: &[usize], is_uneven: bool) -> Option<[f64; 3]> {
        let place = self.surface.vertices()[vertex as usize];
        let mut sum = [0.0; 3];
        for &facet in sector {
            sum = add(sum, scale(self.angle(facet, vertex), self.flat[facet]));
        }
        let guess = normalised(sum)?;
        let is_flat = is_uneven || self.flats.are_one(sector);
        let fitted = if is_flat {
            self.mean_of_large(sector).unwrap_or(guess)
        } else {
            fit::normal(place, guess, &self.two_rings(sector, vertex))
        };
        // A fit that leaves the facets behind is none.
        let is_outward = |&facet: &usize| dot(fitted, self.flat[facet]) > 0.0;
        Some(if sector.iter().all(is_outward) {
            fitted
        } else {
            guess
        })
    }

    /// Mean of the large flats' normals by the squares of their areas.
    fn mean_of_large(&self, sector: &[usize]) -> Option<[f64; 3]> {
        let large = self.flats.large(sector);
        let weighted = |&facet: &usize| {
            let area = self.flats.area_of(facet);
            scale(area * area, self.flat[facet])
        };
        normalised(large.iter().map(weighted).fold([0.0; 3], add))
    }

    /// Facets around `vertex` that are reached from `facet` across edges without a feature,
    /// ascending.
    pub(super) fn sector(&self, facet: usize, vertex: u32) -> Vec<usize> {
        self.flood(vec![facet], |next| {
            self.surface.linked.corner_of(next, vertex).is_some()
        })
    }

    /// Facets that are reached from some (ascending) without a feature, ascending.
    fn flood(&self, start: Vec<usize>, is_in: impl Fn(usize) -> bool) -> Vec<usize> {
        let mut open = start.clone();
        let mut found = start;
        while let Some(facet) = open.pop() {
            for opposite in 0..3 {
                let next = self.surface.linked.across[facet][opposite] as usize;
                if self.features[facet][opposite] || found.len() >= MOST {
                    continue;
                }
                if let Err(place) = found.binary_search(&next)
                    && is_in(next)
                {
                    found.insert(place, next);
                    open.push(next);
                }
            }
        }
        found
    }

    /// Places of the vertices of two rings, without the own one, ascending by number.
    fn two_rings(&self, sector: &[usize], vertex: u32) -> Vec<[f64; 3]> {
        let range = self.flats.range(sector);
        let all = self.around.two_rings(vertex, range);
        let all = all.unwrap_or_else(|| self.flooded(sector, vertex));
        let place = |&vertex: &u32| self.surface.vertices()[vertex as usize];
        all.iter().map(place).collect()
    }

    /// The vertices of two rings, without the own one, ascending.
    pub(super) fn flooded(&self, sector: &[usize], vertex: u32) -> Vec<u32> {
        let vertices_of = |facets: &[usize]| -> Vec<u32> {
            let corners = facets
                .iter()
                .flat_map(|&facet| self.surface.facets()[facet]);
            let mut all: Vec<u32> = corners.filter(|&corner| corner != vertex).collect();
            all.sort_unstable();
            all.dedup();
            all
        };
        let first = vertices_of(sector);
        // Where flats are much larger or smaller the curvature is another one.
        let is_like = self.flats.is_like(sector);
        let meets = |facet: usize| {
            if !is_like(facet) {
                return false;
            }
            let mut corners = self.surface.facets()[facet].iter();
            corners.any(|one| first.binary_search(one).is_ok())
        };
        vertices_of(&self.flood(sector.to_vec(), meets))
    }

    /// Angle of a facet at one of its vertices.
    fn angle(&self, facet: usize, vertex: u32) -> f64 {
        let Some(corner) = self.surface.linked.corner_of(facet, vertex) else {
            return 0.0;
        };
        let (next, last) = edge(self.surface.facets()[facet], corner);
        let place = |vertex: u32| self.surface.vertices()[vertex as usize];
        let [a, b] = [next, last].map(|other| sub(place(other), place(vertex)));
        norm(cross(a, b)).atan2(dot(a, b))
    }
}
