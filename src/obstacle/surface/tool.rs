//! A triangulated surface as an obstacle.

use std::sync::Arc;

use super::closest::{Foot, Part};
use super::patch::{Patch, bend};
use super::tree::FacetTree;
use super::{Between, SurfaceShape, TriangulatedSurface, normals};
use crate::geometry::Matrix3;
use crate::geometry::vector3::{add, dot, norm, normalised, scale, sub};
use crate::obstacle::{
    Ball, Contact, Obstacle, ObstacleError, What, check_length, round_curvature,
};

/// Distance from an edge, over the size of the tool, below which its normal is that of its
/// facets.
const AT_EDGE: f64 = 1e-9;
/// Facets that a search goes through at most.
const WALK: usize = 24;
/// Points an axis of the lattice on which the inner ball is looked for.
const LATTICE: u32 = 8;

/// Patches over the facets of a surface. Reference point is the origin of its coordinates.
#[derive(Clone, Debug)]
pub struct Triangulated {
    surface: Arc<TriangulatedSurface>,
    patches: Vec<Patch>,
    /// Unit normals of the facets.
    flat: Vec<[f64; 3]>,
    /// Whether the edge opposite each corner is a feature.
    features: Vec<[bool; 3]>,
    tree: FacetTree,
    /// Diagonal of its box.
    size: f64,
    ball: Option<Ball>,
    sharpest: Option<f64>,
}

/// A point of the surface: the facet and its place on the patch.
#[derive(Clone, Copy)]
struct Nearest {
    facet: usize,
    foot: Foot,
}

impl Triangulated {
    /// The tool of `shape`, its lengths divided by `length`.
    ///
    /// # Errors
    /// The scale is not finite or not above zero, or the feature angle is not an angle.
    pub fn new(shape: &SurfaceShape, length: f64) -> Result<Self, ObstacleError> {
        check_length("scale", shape.scale)?;
        let surface = &shape.surface;
        let factor = shape.scale / length;
        let flat = normals::flat(surface);
        let angle = match shape.between {
            Between::Facets => 0.0,
            Between::Patches(angle) if angle > 0.0 && angle < std::f64::consts::PI => angle,
            Between::Patches(value) => {
                return Err(ObstacleError::NotBetweenFacets {
                    parameter: "feature_angle",
                    degrees: value.to_degrees(),
                });
            }
        };
        let features = normals::features(surface, &flat, angle);
        let corners = match shape.between {
            Between::Facets => flat.iter().map(|normal| [*normal; 3]).collect(),
            Between::Patches(_) => normals::corners(surface, &flat, &features),
        };
        let mut tool = Self {
            patches: patches(surface, factor, &corners),
            tree: FacetTree::new(surface, factor),
            surface: Arc::clone(surface),
            flat,
            features,
            size: factor * diagonal(surface),
            ball: None,
            sharpest: None,
        };
        tool.ball = tool.largest_ball();
        tool.sharpest = tool.smallest_radius();
        Ok(tool)
    }

    /// The triangulation.
    pub fn surface(&self) -> &TriangulatedSurface {
        &self.surface
    }

    fn nearest(&self, x: [f64; 3]) -> Nearest {
        let (facet, start) = self.tree.nearest(x);
        let mut best = Nearest {
            facet,
            foot: self.patches[facet].closest(x, start),
        };
        let mut seen = vec![facet];
        while seen.len() < WALK {
            let beside = self.beside(best);
            let new: Vec<usize> = beside
                .into_iter()
                .filter(|one| !seen.contains(one))
                .collect();
            let before = best.foot.distance;
            for facet in new {
                seen.push(facet);
                let foot = self.patches[facet].closest(x, [1.0 / 3.0; 3]);
                // Facets that share the point tell the same distance but for rounding.
                let is_nearer = foot.distance < best.foot.distance * (1.0 - 1e-14);
                let is_better = foot.part == Part::Inside && foot.distance <= best.foot.distance;
                if is_nearer || is_better {
                    best = Nearest { facet, foot };
                }
            }
            if best.foot.distance >= before {
                break;
            }
        }
        best
    }

    /// Facets that meet at the point.
    fn beside(&self, at: Nearest) -> Vec<usize> {
        match at.foot.part {
            Part::Inside => Vec::new(),
            Part::Edge(opposite) => vec![self.surface.across[at.facet][opposite] as usize],
            Part::Corner(corner) => self.surface.around(at.facet, corner).split_off(1),
        }
    }

    /// The side of the surface at a point: unit, the sum over the facets that meet there.
    fn side(&self, at: Nearest) -> [f64; 3] {
        let own = self.patches[at.facet].normal(at.foot.l);
        match at.foot.part {
            Part::Inside => own,
            Part::Edge(opposite) => {
                let other = self.surface.across[at.facet][opposite] as usize;
                let (from, to) = ((opposite + 1) % 3, (opposite + 2) % 3);
                let beyond = [(from, at.foot.l[from]), (to, at.foot.l[to])];
                let mut l = [0.0; 3];
                for (corner, value) in beyond {
                    let vertex = self.surface.facets[at.facet][corner];
                    if let Some(corner) = self.surface.corner_of(other, vertex) {
                        l[corner] = value;
                    }
                }
                normalised(add(own, self.patches[other].normal(l))).unwrap_or(own)
            }
            Part::Corner(corner) => {
                let around = self.surface.around(at.facet, corner);
                let vertex = self.surface.facets[at.facet][corner];
                let sum = around.iter().fold([0.0; 3], |sum, &facet| {
                    add(sum, scale(self.angle(facet, vertex), self.flat[facet]))
                });
                normalised(sum).unwrap_or(own)
            }
        }
    }

    fn angle(&self, facet: usize, vertex: u32) -> f64 {
        let Some(corner) = self.surface.corner_of(facet, vertex) else {
            return 0.0;
        };
        let place = |k: usize| self.patches[facet].corners[(corner + k) % 3];
        let [a, b] = [sub(place(1), place(0)), sub(place(2), place(0))];
        norm(crate::geometry::vector3::cross(a, b)).atan2(dot(a, b))
    }

    /// Whether the surface has an edge or a corner at the point.
    fn is_sharp(&self, at: Nearest) -> bool {
        match at.foot.part {
            Part::Inside => false,
            Part::Edge(opposite) => self.features[at.facet][opposite],
            Part::Corner(corner) => {
                let vertex = self.surface.facets[at.facet][corner];
                let around = self.surface.around(at.facet, corner);
                around.into_iter().any(|facet| {
                    let own = self.surface.corner_of(facet, vertex).unwrap_or_default();
                    self.features[facet][(own + 1) % 3] || self.features[facet][(own + 2) % 3]
                })
            }
        }
    }

    fn contact(&self, x: [f64; 3], what: What, contact: &mut Contact) {
        let at = self.nearest(x);
        let side = self.side(at);
        let sign = 1.0_f64.copysign(dot(at.foot.offset, side));
        contact.distance = sign * at.foot.distance;
        if what == What::Gap {
            return;
        }
        let is_edge = self.is_sharp(at) && at.foot.distance > AT_EDGE * self.size;
        contact.normal = match is_edge {
            true => scale(1.0 / contact.distance, at.foot.offset),
            false => side,
        };
        if what == What::Curvature {
            contact.curvature = match (is_edge, at.foot.part) {
                (true, Part::Edge(opposite)) => {
                    let along = self.along(at, opposite);
                    round_curvature(contact.normal, along, contact.distance)
                }
                (true, _) => round_curvature(contact.normal, [0.0; 3], contact.distance),
                (false, _) => {
                    let normal = contact.normal;
                    curvature(&self.patches[at.facet], at.foot.l, normal, contact.distance)
                }
            };
        }
    }

    /// Unit tangent of an edge at a point.
    fn along(&self, at: Nearest, opposite: usize) -> [f64; 3] {
        let patch = &self.patches[at.facet];
        let (from, to) = ((opposite + 1) % 3, (opposite + 2) % 3);
        let chord = sub(patch.corners[to], patch.corners[from]);
        let bent = scale(1.0 - 2.0 * at.foot.l[to], patch.bends[opposite]);
        normalised(sub(chord, bent)).unwrap_or_default()
    }

    /// The deepest point of a lattice over its box.
    fn largest_ball(&self) -> Option<Ball> {
        let mut ball: Option<Ball> = None;
        let (low, high) = bounds(self.patches.iter().flat_map(|patch| patch.corners));
        let at = |i: usize, step: u32| {
            let share = (f64::from(step) + 0.5) / f64::from(LATTICE);
            low[i] + share * (high[i] - low[i])
        };
        for index in 0..LATTICE.pow(3) {
            let steps = [
                index % LATTICE,
                index / LATTICE % LATTICE,
                index / (LATTICE * LATTICE),
            ];
            let centre = [at(0, steps[0]), at(1, steps[1]), at(2, steps[2])];
            let mut contact = Contact::default();
            self.contact(centre, What::Gap, &mut contact);
            let radius = -contact.distance;
            if radius > ball.map_or(0.0, |ball| ball.radius) {
                ball = Some(Ball { centre, radius });
            }
        }
        ball
    }

    /// Zero where there is a convex feature, else the least of the patches' middles.
    fn smallest_radius(&self) -> Option<f64> {
        let mut largest = 0.0_f64;
        for (facet, patch) in self.patches.iter().enumerate() {
            for (opposite, is_feature) in self.features[facet].iter().enumerate() {
                let other = self.surface.across[facet][opposite] as usize;
                let middle = scale(1.0 / 3.0, sum(self.patches[other].corners));
                let edge = patch.corners[(opposite + 1) % 3];
                if *is_feature && dot(sub(middle, edge), self.flat[facet]) < 0.0 {
                    return Some(0.0);
                }
            }
            let normal = patch.normal([1.0 / 3.0; 3]);
            let bent = curvature(patch, [1.0 / 3.0; 3], normal, 0.0);
            let trace: f64 = (0..3).map(|i| bent[i][i]).sum();
            let squares: f64 = bent.as_flattened().iter().map(|x| x * x).sum();
            let half = 0.5 * trace;
            largest = largest.max(half + (0.5 * squares - half * half).max(0.0).sqrt());
        }
        (largest > 0.0).then(|| 1.0 / largest)
    }
}

fn sum([a, b, c]: [[f64; 3]; 3]) -> [f64; 3] {
    add(a, add(b, c))
}

/// Corners of the box around points.
fn bounds(points: impl Iterator<Item = [f64; 3]>) -> ([f64; 3], [f64; 3]) {
    let start = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    points.fold(start, |(low, high), point| {
        (
            std::array::from_fn(|i| low[i].min(point[i])),
            std::array::from_fn(|i| high[i].max(point[i])),
        )
    })
}

fn diagonal(surface: &TriangulatedSurface) -> f64 {
    let (low, high) = bounds(surface.vertices.iter().copied());
    norm(sub(high, low))
}

fn patches(surface: &TriangulatedSurface, factor: f64, normals: &[[[f64; 3]; 3]]) -> Vec<Patch> {
    let of_facet = |(facet, normals): (usize, &[[f64; 3]; 3])| {
        let corners = surface.corners(facet).map(|place| scale(factor, place));
        let bends = [0, 1, 2].map(|opposite: usize| {
            let (a, b) = ((opposite + 1) % 3, (opposite + 2) % 3);
            bend([corners[a], corners[b]], [normals[a], normals[b]])
        });
        Patch { corners, bends }
    };
    normals.iter().enumerate().map(of_facet).collect()
}

/// Hessian of the distance at `distance` along `normal` from the point `l`: with the tangents
/// T, the metric I = T^T T and B = -n . d2X,
///
/// ```text
/// H = T I^-1 B (I + d B)^-1 T^T
/// ```
///
/// zero where the point is beyond a centre of curvature.
fn curvature(patch: &Patch, l: [f64; 3], normal: [f64; 3], distance: f64) -> Matrix3 {
    let d = patch.derivatives(l);
    let symmetric = |m: [f64; 3]| [[m[0], m[1]], [m[1], m[2]]];
    let metric = symmetric([
        dot(d.first[0], d.first[0]),
        dot(d.first[0], d.first[1]),
        dot(d.first[1], d.first[1]),
    ]);
    let bent = symmetric(d.second.map(|second| -dot(normal, second)));
    let moved: [[f64; 2]; 2] =
        std::array::from_fn(|i| std::array::from_fn(|j| metric[i][j] + distance * bent[i][j]));
    let (Some(metric), Some(moved)) = (inverse(&metric), inverse(&moved)) else {
        return [[0.0; 3]; 3];
    };
    let middle = product(&product(&metric, &bent), &moved);
    let entry = |i: usize, j: usize| {
        let mut sum = 0.0;
        for (a, row) in middle.iter().enumerate() {
            for (b, value) in row.iter().enumerate() {
                sum += d.first[a][i] * value * d.first[b][j];
            }
        }
        sum
    };
    // Symmetric but for rounding.
    std::array::from_fn(|i| std::array::from_fn(|j| 0.5 * (entry(i, j) + entry(j, i))))
}

fn inverse(m: &[[f64; 2]; 2]) -> Option<[[f64; 2]; 2]> {
    let determinant = m[0][0] * m[1][1] - m[0][1] * m[1][0];
    let is_positive = m[0][0] > 0.0 && determinant > 1e-12 * m[0][0] * m[1][1].abs();
    is_positive.then(|| {
        [
            [m[1][1] / determinant, -m[0][1] / determinant],
            [-m[1][0] / determinant, m[0][0] / determinant],
        ]
    })
}

fn product(a: &[[f64; 2]; 2], b: &[[f64; 2]; 2]) -> [[f64; 2]; 2] {
    std::array::from_fn(|i| std::array::from_fn(|j| a[i][0] * b[0][j] + a[i][1] * b[1][j]))
}

impl Obstacle for Triangulated {
    fn probe(&self, points: &[[f64; 3]], what: What, out: &mut [Contact]) {
        for (contact, &point) in out.iter_mut().zip(points) {
            self.contact(point, what, contact);
        }
    }

    fn reference_point(&self) -> [f64; 3] {
        [0.0; 3]
    }

    fn is_flat(&self) -> bool {
        false
    }

    fn inner_ball(&self) -> Option<Ball> {
        self.ball
    }

    fn sharpest_radius(&self) -> Option<f64> {
        self.sharpest
    }

    fn is_smooth(&self) -> bool {
        self.features.iter().flatten().all(|is_feature| !is_feature)
    }

    fn is_closed(&self) -> bool {
        true
    }

    fn lies_in_plane(&self) -> Result<(), ObstacleError> {
        Err(ObstacleError::OutOfPlane { parameter: "kind" })
    }
}
