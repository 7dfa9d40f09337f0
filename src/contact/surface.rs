//! The faces of the body that may touch one obstacle, and their multipliers.
//!
//! Faces that share a node share its function, where they meet smoothly; functions are
//! numbered by their nodes, ascending, and most have a multiplier of their own
//! (`Shares`). Incidence and the pattern of the coupling are found once, so that rows are
//! added up face by face in one order, whatever the number of threads. Cost: one sort of
//! the nodes.

use std::f64::consts::TAU;

use super::basis::{ContactBasis, Hats};
use super::face::ContactFace;
use super::incidence::{Couplings, Incidence};
use super::layout::Layout;
use super::shares::Shares;
use crate::assembly::load::facet_measure;
use crate::element::quadrature::{Rule, Simplex, rule};
use crate::geometry::vector3::{add, cross, norm, normalised, sub};
use crate::mesh::CurvedFacet;
use crate::mesh::Mesh;
use crate::space::TaylorHood;

/// Degree of the rule on faces.
pub const FACE_DEGREE: u32 = 8;
/// Degree where the curvature of an obstacle jumps.
pub const KINKED_DEGREE: u32 = 16;

/// The candidate surface of one obstacle.
#[derive(Clone, Debug)]
pub struct ContactSurface {
    /// Displacement node of each function, ascending `[functions]`; nodes below the
    /// number of vertices are mesh vertices.
    pub carriers: Vec<u32>,
    /// The multipliers of the functions.
    pub shares: Shares,
    /// Candidate faces, in the order in which the surface was given.
    pub faces: Vec<ContactFace>,
    /// Integral of each multiplier function over the undeformed surface
    /// `[multipliers]`, area of the scaled body.
    pub weights: Vec<f64>,
    /// Functions of the contact pressure on a face: vertex hats or quadratic Bernstein
    /// functions.
    pub(super) basis: &'static dyn ContactBasis,
    /// Displacement nodes of all faces, ascending and each once.
    pub(super) nodes: Vec<u32>,
    /// The faces around each function, along which rows of gap and coupling are added
    /// up.
    pub(super) at_functions: Incidence,
    /// The faces around each of `nodes`, along which rows of the curvature are added
    /// up.
    pub(super) at_nodes: Incidence,
    /// Displacement nodes that the row of each function meets: the pattern of C, found
    /// once.
    pub(super) couplings: Couplings,
}

impl ContactSurface {
    /// The surface made of `facets` (vertex lists), with hats.
    pub fn new(mesh: &Mesh, space: &TaylorHood, scale: f64, facets: &[Vec<u32>]) -> Self {
        let face = |corners: &Vec<u32>| {
            let (area, normal) = facet_measure(mesh, corners, scale);
            let first = mesh.coordinates()[corners[0] as usize];
            ContactFace {
                nodes: space.facet_nodes(corners),
                corners: corners.clone(),
                functions: Vec::new(),
                area,
                radii: None,
                flat_area: area,
                point: first.map(|x| x * scale),
                normal,
                curve: CurvedFacet::of(mesh, scale, corners).map(Box::new),
            }
        };
        Self::of(facets.iter().map(face).collect(), &Hats)
    }

    /// The surface that `facets` (segments) sweep about the axis x = 0, with hats.
    pub fn about_axis(mesh: &Mesh, space: &TaylorHood, scale: f64, facets: &[Vec<u32>]) -> Self {
        let mut faces = Self::new(mesh, space, scale, facets).faces;
        for face in &mut faces {
            let radius = |end: usize| scale * mesh.coordinates()[face.corners[end] as usize][0];
            let [a, b] = [radius(0), radius(1)];
            face.area = TAU * face.flat_area * 0.5 * (a + b);
            face.radii = Some([a, b]);
        }
        Self::of(faces, &Hats)
    }

    /// The same surface with other functions, one a node.
    pub fn with_basis(self, basis: &'static dyn ContactBasis) -> Self {
        Self::of(self.faces, basis)
    }

    /// The same surface with other functions, numbered by `layout`, whose faces are
    /// those of the surface.
    pub fn with_layout(self, basis: &'static dyn ContactBasis, layout: Layout) -> Self {
        Self::laid_out(self.faces, basis, layout)
    }

    /// Numbers the functions by the nodes that carry them, ascending.
    fn of(faces: Vec<ContactFace>, basis: &'static dyn ContactBasis) -> Self {
        let own = |face: &ContactFace| basis.functions(face.corners.len());
        let nodes: Vec<&[u32]> = faces.iter().map(|face| &face.nodes[..own(face)]).collect();
        let layout = Layout::by_nodes(&nodes);
        Self::laid_out(faces, basis, layout)
    }

    /// Finds weights, incidence and pattern. Cost: one sort of the nodes.
    fn laid_out(
        mut faces: Vec<ContactFace>,
        basis: &'static dyn ContactBasis,
        layout: Layout,
    ) -> Self {
        let carriers = layout.nodes;
        let mut weights = vec![0.0; carriers.len()];
        let curved = faces.iter().find(|face| face.curve.is_some());
        let rule = curved.map(|face| face_rule(face.corners.len(), FACE_DEGREE));
        for (face, functions) in faces.iter_mut().zip(layout.faces) {
            face.functions = functions;
            for (k, &function) in face.functions.iter().enumerate() {
                weights[function as usize] += match rule.as_ref().filter(|_| face.curve.is_some()) {
                    Some(rule) => integral(face, basis, k, rule),
                    None => basis.weight(face, k),
                };
            }
        }
        let nodes = ascending(faces.iter().flat_map(|face| &face.nodes));
        let of_faces: Vec<Vec<u32>> = faces
            .iter()
            .map(|face| face.nodes.iter().map(|node| place(&nodes, node)).collect())
            .collect();
        let functions = faces.iter().map(|face| &face.functions[..]);
        let at_functions = Incidence::new(carriers.len(), functions);
        let couplings = Couplings::new(carriers.len(), &at_functions, |face| {
            &faces[face as usize].nodes
        });
        Self {
            at_nodes: Incidence::new(nodes.len(), of_faces.iter().map(|own| &own[..])),
            at_functions,
            couplings,
            carriers,
            faces,
            weights: layout.shares.gather(weights),
            shares: layout.shares,
            basis,
            nodes,
        }
    }

    /// The same where `takers[m]` take over multiplier m in equal parts: it has no function then, and
    /// the weight that it had.
    pub fn lending(&self, takers: &[Option<Vec<u32>>]) -> Self {
        let mut weights = self.weights.clone();
        for (takers, lent) in takers.iter().zip(&self.weights) {
            let takers = takers.iter().flatten();
            let part = lent / takers.clone().count() as f64;
            takers.for_each(|&taker| weights[taker as usize] += part);
        }
        Self {
            shares: self.shares.lending(takers),
            weights,
            ..self.clone()
        }
    }

    /// Number of multipliers.
    pub fn multipliers(&self) -> usize {
        self.shares.multipliers()
    }
}

/// The rule of contact integrals on faces with that many corners: the distance to a
/// curved obstacle along a quadratic face is integrated to far below the tolerance by
/// [`FACE_DEGREE`]. Where the curvature jumps no degree does; [`KINKED_DEGREE`] leaves some 1e-5.
pub fn face_rule(corners: usize, degree: u32) -> Rule {
    match corners {
        2 => rule(Simplex::Segment, degree),
        _ => rule(Simplex::Triangle, degree),
    }
}

/// int psi_k dS over a face by a rule.
fn integral(face: &ContactFace, basis: &dyn ContactBasis, k: usize, rule: &Rule) -> f64 {
    let corners = face.corners.len();
    let mut values = vec![0.0; basis.functions(corners)];
    let points = rule.points.iter().zip(&rule.weights);
    let terms = points.map(|(point, weight)| {
        let l = &point[..corners];
        basis.values(l, &mut values);
        weight * face.area_at(l) * values[k]
    });
    terms.sum()
}

/// The values that occur, ascending.
fn ascending<'a>(values: impl Iterator<Item = &'a u32>) -> Vec<u32> {
    let mut values: Vec<u32> = values.copied().collect();
    values.sort_unstable();
    values.dedup();
    values
}

/// Where `value` stands among `ascending`.
fn place(ascending: &[u32], value: &u32) -> u32 {
    ascending.partition_point(|other| other < value) as u32
}

/// Unit normals at `vertices` (ascending; others are left out) of the surface made
/// of `facets`, whose vertices are at `position`, coordinates near one: means by
/// area. Where both sides of a thin body are candidates, that of one facet.
pub fn vertex_normals<'a>(
    position: impl Fn(u32) -> [f64; 3],
    facets: impl Iterator<Item = &'a [u32]>,
    vertices: &[u32],
) -> Vec<[f64; 3]> {
    let mut sums = vec![[0.0; 3]; vertices.len()];
    let mut anyone = sums.clone();
    for facet in facets {
        let point = |corner: usize| position(facet[corner]);
        let first = sub(point(1), point(0));
        let normal = match facet.len() {
            2 => [first[1], -first[0], 0.0],
            _ => cross(first, sub(point(2), point(0))),
        };
        for vertex in facet {
            if let Ok(index) = vertices.binary_search(vertex) {
                sums[index] = add(sums[index], normal);
                anyone[index] = normal;
            }
        }
    }
    let unit = |(sum, one): ([f64; 3], [f64; 3])| {
        let mean = normalised(sum).filter(|_| norm(sum) > 1e-3 * norm(one));
        mean.or_else(|| normalised(one)).unwrap_or_default()
    };
    sums.into_iter().zip(anyone).map(unit).collect()
}
