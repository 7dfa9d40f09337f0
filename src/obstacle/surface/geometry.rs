//! The patches over a triangulation with all that a search for their nearest points needs, in
//! units of about the surface's size, whatever its scale as a tool: made once for all tools.

use crate::parallel;
use rayon::prelude::*;

use super::bending::curvature;
use super::bounding_disc::Flat;
use super::closest::Part;
use super::normals::{self, Corners};
use super::patch::{Patch, bend};
use super::tree::{self, FacetTree, Found};
use super::walk::{Nearest, Searched};
use super::{Interpolation, TriangulatedSurface};
use crate::geometry::vector3::{add, cross, dot, norm, normalised, scale, sub};
use crate::obstacle::{Ball, Contact, Derivatives, larger_curvature, round_curvature};

/// Distance from an edge, over the size of the tool, below which its normal is the mean of its
/// patches'.
const AT_EDGE: f64 = 1e-9;
/// Points an axis of the lattice on which the inner ball is looked for.
const LATTICE: u32 = 8;

/// Patches with what they are beside their places.
#[derive(Debug)]
pub(super) struct Geometry {
    /// Length of the surface's file that is one here: a power of two, so that coordinates keep
    /// their bits.
    pub(super) unit: f64,
    pub(super) searched: Searched,
    /// Whether the edge opposite each corner is a feature.
    features: Vec<[bool; 3]>,
    pub(super) ball: Option<Ball>,
    pub(super) sharpest: Option<f64>,
    pub(super) is_smooth: bool,
    /// Further solids that these cross, nest in or touch.
    beside: Vec<Self>,
}

impl Geometry {
    /// Of a surface with this between its vertices; the angle is one.
    pub(super) fn new(surface: &TriangulatedSurface, between: Interpolation) -> Self {
        let layers = surface.layers();
        let mut layers = layers.iter().map(|layer| Self::of_layer(layer, between));
        match layers.next() {
            Some(first) => first.with(layers.collect()),
            None => Self::of_layer(surface, between),
        }
    }

    /// The union with other solids.
    fn with(mut self, beside: Vec<Self>) -> Self {
        for other in &beside {
            let factor = other.unit / self.unit;
            let ball = other.ball.map(|ball| Ball {
                centre: scale(factor, ball.centre),
                radius: factor * ball.radius,
            });
            let larger = |a: &Ball, b: &Ball| a.radius.total_cmp(&b.radius);
            self.ball = self.ball.into_iter().chain(ball).max_by(larger);
            let radius = other.sharpest.map(|radius| factor * radius);
            self.sharpest = self.sharpest.into_iter().chain(radius).reduce(f64::min);
        }
        // They may meet in an edge.
        self.is_smooth &= beside.is_empty();
        self.beside = beside;
        self
    }

    /// Of solids that lie apart.
    fn of_layer(surface: &TriangulatedSurface, between: Interpolation) -> Self {
        let flat = normals::flat(surface);
        let (features, corners) = match between {
            Interpolation::Facets => {
                let corners = Corners {
                    normals: flat.iter().map(|normal| [*normal; 3]).collect(),
                    are_uneven: false,
                };
                (normals::features(surface, &flat, 0.0), corners)
            }
            Interpolation::Patches(angle) => {
                let features = normals::features(surface, &flat, angle);
                let corners = normals::corners(surface, &flat, &features);
                (features, corners)
            }
        };
        let turns = normals::turns(surface, &flat);
        let unit = surface.diagonal().log2().ceil().exp2();
        let places = |facet: usize| surface.corners(facet).map(|place| place.map(|x| x / unit));
        let all: Vec<[[f64; 3]; 3]> = parallel::map(flat.len(), 1, &places);
        let order = tree::order(&all);
        let facet = |place: usize| order[place] as usize;
        let patches: Vec<Patch> = parallel::map(order.len(), 1, &|at| {
            patch(all[facet(at)], &corners.normals[facet(at)])
        });
        let features = parallel::map(order.len(), 1, &|at| features[facet(at)]);
        // In the order of the tree: it is read level by level.
        let facing = parallel::map(order.len(), 1, &|at| (flat[facet(at)], turns[facet(at)]));
        let mut geometry = Self {
            unit,
            searched: Searched {
                facets: surface.linked.ordered(&order),
                tree: FacetTree::new(order.len(), |place| Flat {
                    corners: patches[place].corners,
                    normal: facing[place].0,
                    turn: facing[place].1,
                }),
                patches,
            },
            is_smooth: !corners.are_uneven && features.iter().all(|edges| *edges == [false; 3]),
            features,
            ball: None,
            sharpest: None,
            beside: Vec::new(),
        };
        geometry.ball = geometry.largest_ball();
        geometry.sharpest = geometry.smallest_radius();
        geometry
    }

    /// Bytes of one of so many facets.
    pub(super) fn bytes(facets: usize) -> usize {
        let facet = size_of::<Patch>() + 2 * size_of::<[u32; 3]>() + size_of::<[bool; 3]>();
        facets * facet + FacetTree::bytes(facets)
    }

    /// What the solids are to points near each other `[points][3]`: the nearest or deepest of all.
    pub(super) fn contacts(
        &self,
        points: impl ExactSizeIterator<Item = [f64; 3]> + Clone,
        derivatives: Derivatives,
        out: &mut [Contact],
    ) {
        self.of_own(points.clone(), derivatives, out);
        for other in &self.beside {
            // Units are powers of two: their ratio changes no digit.
            let factor = other.unit / self.unit;
            let mut found = vec![Contact::default(); out.len()];
            let points = points.clone().map(|point| point.map(|x| x / factor));
            other.of_own(points, derivatives, &mut found);
            for (own, mut found) in out.iter_mut().zip(found) {
                found.distance *= factor;
                if found.distance < own.distance {
                    let bent = found.curvature.map(|row| row.map(|entry| entry / factor));
                    *own = Contact {
                        curvature: bent,
                        ..found
                    };
                }
            }
        }
    }

    /// What the solids of this layer are to points near each other `[points][3]`.
    fn of_own(
        &self,
        points: impl ExactSizeIterator<Item = [f64; 3]> + Clone,
        derivatives: Derivatives,
        out: &mut [Contact],
    ) {
        let Some(first) = points.clone().next() else {
            return;
        };
        let mut found = self.searched.nearest_facet(first);
        let squares = points.clone().map(|x| {
            let offset = sub(x, first);
            dot(offset, offset)
        });
        let reach = squares
            .fold(0.0, |most: f64, square| most.max(square))
            .sqrt();
        if points.len() == 1 || !(reach.is_finite() && found.place.square.is_finite()) {
            for (x, contact) in points.zip(out) {
                self.contact((x, &self.searched.nearest_facet(x)), derivatives, contact);
            }
            return;
        }
        let region = self.searched.tree.region(first, &found, reach);
        for (index, (x, contact)) in points.zip(out).enumerate() {
            if index > 0 {
                found = self.searched.nearest_facet_from(x, found.facet, &region);
            }
            self.contact((x, &found), derivatives, contact);
        }
    }

    /// What the surface is to `x`, to which a facet is the nearest.
    fn contact(
        &self,
        (x, found): ([f64; 3], &Found),
        derivatives: Derivatives,
        contact: &mut Contact,
    ) {
        let at = self.searched.nearest(x, found);
        let side = self.side(at);
        let sign = 1.0_f64.copysign(dot(at.foot.offset, side));
        contact.distance = sign * at.foot.distance;
        if derivatives == Derivatives::Gap {
            return;
        }
        // Beside an edge, smooth or sharp, the slope of the distance leads away from it.
        let is_beside = at.foot.distance > AT_EDGE && at.foot.part != Part::Inside;
        contact.normal = if is_beside {
            scale(1.0 / contact.distance, at.foot.offset)
        } else {
            side
        };
        if derivatives == Derivatives::Curvature {
            let (normal, distance) = (contact.normal, contact.distance);
            // That of a smooth edge itself would be a spike between those of its patches.
            contact.curvature = match (is_beside && self.is_sharp(at), at.foot.part) {
                (true, Part::Edge(opposite)) => {
                    round_curvature(normal, self.along(at, opposite), distance)
                }
                (true, _) => round_curvature(normal, [0.0; 3], distance),
                (false, _) => curvature(
                    &self.searched.patches[at.facet],
                    at.foot.l,
                    normal,
                    distance,
                ),
            };
        }
    }

    /// The side of the surface at a point: unit, the sum over the facets that meet there.
    fn side(&self, at: Nearest) -> [f64; 3] {
        let own = self.searched.patches[at.facet].normal(at.foot.l);
        let sum = match at.foot.part {
            Part::Inside => return own,
            Part::Edge(opposite) => {
                let (other, l) = self.searched.beyond(at, opposite);
                add(own, self.searched.patches[other].normal(l))
            }
            Part::Corner(corner) => {
                let vertex = self.searched.facets.corners[at.facet][corner];
                let around = self.searched.facets.around(at.facet, corner);
                around.fold([0.0; 3], |sum, facet| {
                    let mut l = [0.0; 3];
                    l[self
                        .searched
                        .facets
                        .corner_of(facet, vertex)
                        .unwrap_or_default()] = 1.0;
                    let normal = self.searched.patches[facet].normal(l);
                    add(sum, scale(self.angle(facet, vertex), normal))
                })
            }
        };
        normalised(sum).unwrap_or(own)
    }

    fn angle(&self, facet: usize, vertex: u32) -> f64 {
        let Some(corner) = self.searched.facets.corner_of(facet, vertex) else {
            return 0.0;
        };
        let place = |k: usize| self.searched.patches[facet].corners[(corner + k) % 3];
        let [a, b] = [sub(place(1), place(0)), sub(place(2), place(0))];
        norm(cross(a, b)).atan2(dot(a, b))
    }

    /// Whether the edge of a facet opposite a corner is a feature that stands out.
    fn is_convex_feature(&self, facet: usize, opposite: usize) -> bool {
        if !self.features[facet][opposite] {
            return false;
        }
        let other = self.searched.facets.across[facet][opposite] as usize;
        let [a, b, c] = self.searched.patches[facet].corners;
        let [p, q, r] = self.searched.patches[other].corners;
        let middle = scale(1.0 / 3.0, add(p, add(q, r)));
        let edge = self.searched.patches[facet].corners[(opposite + 1) % 3];
        dot(sub(middle, edge), cross(sub(b, a), sub(c, a))) < 0.0
    }

    /// Whether the surface has an edge or a corner at the point.
    fn is_sharp(&self, at: Nearest) -> bool {
        match at.foot.part {
            Part::Inside => false,
            Part::Edge(opposite) => self.features[at.facet][opposite],
            Part::Corner(corner) => {
                let vertex = self.searched.facets.corners[at.facet][corner];
                self.searched.facets.around(at.facet, corner).any(|facet| {
                    let own = self
                        .searched
                        .facets
                        .corner_of(facet, vertex)
                        .unwrap_or_default();
                    self.features[facet][(own + 1) % 3] || self.features[facet][(own + 2) % 3]
                })
            }
        }
    }

    /// Unit tangent of an edge at a point.
    fn along(&self, at: Nearest, opposite: usize) -> [f64; 3] {
        let patch = &self.searched.patches[at.facet];
        let (from, to) = ((opposite + 1) % 3, (opposite + 2) % 3);
        let chord = sub(patch.corners[to], patch.corners[from]);
        let bent = scale(1.0 - 2.0 * at.foot.l[to], patch.bends[opposite]);
        normalised(sub(chord, bent)).unwrap_or_default()
    }

    /// The deepest point of a lattice over the box of the surface.
    fn largest_ball(&self) -> Option<Ball> {
        let corners = self.searched.patches.iter().flat_map(|patch| patch.corners);
        let (low, high) = super::bounds(corners);
        let centre = |index: u32| -> [f64; 3] {
            let steps = [
                index % LATTICE,
                index / LATTICE % LATTICE,
                index / (LATTICE * LATTICE),
            ];
            std::array::from_fn(|i| {
                let share = (f64::from(steps[i]) + 0.5) / f64::from(LATTICE);
                low[i] + share * (high[i] - low[i])
            })
        };
        let ball = |index: u32| {
            let mut contact = Contact::default();
            let centre = centre(index);
            let found = self.searched.nearest_facet(centre);
            self.contact((centre, &found), Derivatives::Gap, &mut contact);
            let radius = -contact.distance;
            (radius > 0.0).then_some((Ball { centre, radius }, index))
        };
        let balls = (0..LATTICE.pow(3)).into_par_iter().filter_map(ball);
        let larger = |a: &(Ball, u32), b: &(Ball, u32)| {
            let by_radius = a.0.radius.total_cmp(&b.0.radius);
            by_radius.then(b.1.cmp(&a.1))
        };
        balls.max_by(larger).map(|(ball, _)| ball)
    }

    /// Zero where there is a convex feature, else the least of the patches' middles.
    fn smallest_radius(&self) -> Option<f64> {
        let facets = (0..self.searched.patches.len()).into_par_iter();
        let edges = facets
            .clone()
            .flat_map_iter(|facet| (0..3).map(move |k| (facet, k)));
        if edges.any(|(facet, opposite)| self.is_convex_feature(facet, opposite)) {
            return Some(0.0);
        }
        let bent = facets.map(|facet| self.largest_curvature(facet));
        let largest = bent.reduce(|| 0.0, f64::max);
        (largest > 0.0).then(|| 1.0 / largest)
    }

    /// The larger principal curvature in the middle of a patch.
    fn largest_curvature(&self, facet: usize) -> f64 {
        let patch = &self.searched.patches[facet];
        let normal = patch.normal([1.0 / 3.0; 3]);
        let bent = curvature(patch, [1.0 / 3.0; 3], normal, 0.0);
        larger_curvature(&bent)
    }
}

fn patch(corners: [[f64; 3]; 3], normals: &[[f64; 3]; 3]) -> Patch {
    let bends = [0, 1, 2].map(|opposite: usize| {
        let (a, b) = ((opposite + 1) % 3, (opposite + 2) % 3);
        bend([corners[a], corners[b]], [normals[a], normals[b]])
    });
    Patch { corners, bends }
}
