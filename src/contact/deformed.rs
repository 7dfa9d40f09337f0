//! The deformed faces of a contact surface, point by point of the rule: what every
//! contact integral is made of.
//!
//! Faces run in parallel and write numbers of their own; whoever adds them up does
//! so in the order of faces and points, so that the bits do not depend on the
//! threads. Nothing is allocated for a face or a point.

use super::area_element::{AreaElement, Extent, NODES};
use super::basis::ContactBasis;
use super::counterpart::{Counterpart, Places};
use super::face::ContactFace;
use crate::assembly::follower::shape_slopes;
use crate::assembly::load::push_shape_values;
use crate::element::quadrature::Rule;
use crate::geometry::vector3::add;
use crate::mesh::Mesh;
use crate::obstacle::{Contact, Derivatives};
use crate::parallel::{self, Pieces, Scratch};
use crate::space::TaylorHood;

/// Fewer faces are not worth a second thread.
const PARALLEL_FACES: usize = 48;

/// The surface that contact integrals are taken over.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Measure {
    /// The undeformed surface: bodies of small strain.
    #[default]
    Undeformed,
    /// The deformed surface, whose area moves with the displacement: bodies of finite strain.
    Deformed,
}

/// What every contact integral reads.
#[derive(Clone, Copy)]
pub struct Deformed<'a> {
    /// The undeformed mesh, in the caller's lengths.
    pub mesh: &'a Mesh,
    /// Factor that brings mesh coordinates to the scaled body.
    pub scale: f64,
    /// Numbering of the displacement: vertices, then edges.
    pub space: &'a TaylorHood,
    /// Displacement in the hierarchical basis `[nodes, components]`, in units of the
    /// scaled body.
    pub displacement: &'a [f64],
    /// Quadrature rule on the reference face; its weights add up to one.
    pub rule: &'a Rule,
    /// Which area the rule weighs.
    pub measure: Measure,
}

/// A rule with the values of all functions at its points: the same on every face.
pub(super) struct Table<'a> {
    /// The quadrature rule on the reference face.
    pub(super) rule: &'a Rule,
    /// Corners of a face: 3 in space, 2 in the plane.
    pub(super) corners: usize,
    /// Displacement nodes of a face: corners and edge midpoints, 6 in space, 3 in the
    /// plane.
    pub(super) nodes: usize,
    /// Multiplier functions of a face: as many as its basis has.
    pub(super) functions: usize,
    /// Barycentric coordinates times the scale of the mesh `[points, corners]`.
    scaled: Vec<f64>,
    /// Values of the hierarchical P2 functions at the points of the rule, row-major
    /// `[points, nodes]`.
    shapes: Vec<f64>,
    /// Values of the multiplier functions at the points of the rule, row-major
    /// `[points, functions]`.
    values: Vec<f64>,
    /// Slopes of the hierarchical P2 functions, row-major `[points, nodes]`; empty where the
    /// area is the undeformed one.
    slopes: Vec<[f64; 2]>,
}

impl<'a> Table<'a> {
    /// Tabulates displacement and multiplier functions once: on the reference face they
    /// are the same for every face.
    pub(super) fn new(body: &Deformed<'a>, basis: &dyn ContactBasis) -> Self {
        // A face of the body has as many corners as the body has dimensions.
        let corners = body.space.components;
        let functions = basis.functions(corners);
        let rule = body.rule;
        let mut values = vec![0.0; rule.len() * functions];
        for (point, values) in rule.points.iter().zip(values.chunks_exact_mut(functions)) {
            basis.values(&point[..corners], values);
        }
        let nodes = corners * (corners + 1) / 2;
        let mut scaled = Vec::with_capacity(rule.len() * corners);
        let mut shapes = Vec::with_capacity(rule.len() * nodes);
        let mut slopes = Vec::new();
        for point in &rule.points {
            scaled.extend(point[..corners].iter().map(|l| l * body.scale));
            push_shape_values(&point[..corners], &mut shapes);
            if body.measure == Measure::Deformed {
                slopes.extend(shape_slopes(&point[..corners]));
            }
        }
        Self {
            rule,
            corners,
            nodes,
            functions,
            scaled,
            shapes,
            values,
            slopes,
        }
    }

    /// Points of the rule.
    pub(super) fn points(&self) -> usize {
        self.rule.len()
    }

    /// Barycentric coordinates of a point `[corners]`.
    pub(super) fn coordinates(&self, point: usize) -> &[f64] {
        &self.rule.points[point][..self.corners]
    }

    /// Hierarchical P2 values at a point `[nodes]`.
    pub(super) fn shapes(&self, point: usize) -> &[f64] {
        &self.shapes[point * self.nodes..(point + 1) * self.nodes]
    }

    /// Slopes of the hierarchical P2 functions at a point `[nodes]`; empty where the area is
    /// the undeformed one.
    pub(super) fn slopes(&self, point: usize) -> &[[f64; 2]] {
        let own = point * self.nodes..(point + 1) * self.nodes;
        self.slopes.get(own).unwrap_or_default()
    }

    /// Multiplier functions at a point `[functions]`.
    pub(super) fn values(&self, point: usize) -> &[f64] {
        &self.values[point * self.functions..(point + 1) * self.functions]
    }
}

/// The points of the rule on one deformed face, filled again and again for the faces of a piece.
pub(super) struct FacePoints<'a> {
    /// The rule and the functions at its points.
    pub(super) table: &'a Table<'a>,
    /// Weight times area at each point `[points]`, so that a sum is an integral.
    pub(super) weights: Vec<f64>,
    /// Elements of the deformed area `[points]`; empty where the area is the undeformed one.
    pub(super) areas: Vec<AreaElement>,
    /// Deformed position x + u of each point `[points][3]`, in units of the scaled
    /// body.
    pub(super) deformed: Vec<[f64; 3]>,
    /// What the obstacle is to each point `[points]`: distance, and normal and
    /// curvature where asked for.
    pub(super) contacts: Vec<Contact>,
}

impl<'a> FacePoints<'a> {
    /// Room for the points of one face.
    fn new(table: &'a Table<'a>) -> Self {
        let points = table.points();
        Self {
            table,
            weights: vec![0.0; points],
            areas: Vec::with_capacity(table.slopes.len() / table.nodes),
            deformed: vec![[0.0; 3]; points],
            contacts: vec![Contact::default(); points],
        }
    }

    /// Moves to `face` of `body`.
    fn place(&mut self, body: &Deformed<'_>, face: &ContactFace) {
        let table = self.table;
        let c = body.space.components;
        self.deformed.fill([0.0; 3]);
        let corners = self.deformed.iter_mut();
        for (position, factors) in corners.zip(table.scaled.chunks_exact(table.corners)) {
            for (&vertex, factor) in face.corners.iter().zip(factors) {
                let corner = body.mesh.coordinates()[vertex as usize];
                for i in 0..3 {
                    position[i] += factor * corner[i];
                }
            }
        }
        for (slot, &node) in face.nodes.iter().enumerate() {
            let mut moved = [0.0; 3];
            let first = node as usize * c;
            moved[..c].copy_from_slice(&body.displacement[first..first + c]);
            for (point, position) in self.deformed.iter_mut().enumerate() {
                let shape = table.shapes(point)[slot];
                for i in 0..3 {
                    position[i] += shape * moved[i];
                }
            }
        }
        self.add_offsets(face);
        self.weigh(body, face);
    }

    /// Weights of the points of `face` by the measure of `body`.
    fn weigh(&mut self, body: &Deformed<'_>, face: &ContactFace) {
        let table = self.table;
        let weights = self.weights.iter_mut().zip(&table.rule.weights);
        if body.measure == Measure::Undeformed {
            for (point, (weight, share)) in weights.enumerate() {
                *weight = share * face.area_at(table.coordinates(point));
            }
            return;
        }
        let place = node_positions(body, face);
        let extent = match (face.corners.len(), face.radii) {
            (2, None) => Extent::Segment,
            (2, Some(_)) => Extent::Ring,
            _ => Extent::Triangle,
        };
        self.areas.clear();
        for (point, (weight, share)) in weights.enumerate() {
            let functions = (table.shapes(point), table.slopes(point));
            let area = AreaElement::new(extent, &place, functions);
            *weight = share * area.size();
            self.areas.push(area);
        }
    }

    /// Moves the points from the flat facet to the true surface.
    fn add_offsets(&mut self, face: &ContactFace) {
        let Some(curve) = &face.curve else {
            return;
        };
        for (point, position) in self.deformed.iter_mut().enumerate() {
            let edges = &self.table.shapes(point)[self.table.corners..];
            for (shape, offset) in edges.iter().zip(&curve.offsets) {
                for i in 0..3 {
                    position[i] += shape * offset[i];
                }
            }
        }
    }

    /// Asks what `face` meets for `what` at all points.
    pub(super) fn probe<C: Counterpart + ?Sized>(
        &mut self,
        counterpart: &C,
        face: &ContactFace,
        what: Derivatives,
    ) {
        let places = Places {
            coordinates: &self.table.rule.points,
            deformed: &self.deformed,
        };
        counterpart.probe_on(face, places, what, &mut self.contacts);
    }

    /// A field of vertices at a point; zero where the field is empty.
    pub(super) fn at_corners(&self, face: &ContactFace, point: usize, field: &[f64]) -> f64 {
        let corners = face.corners.iter().zip(self.table.coordinates(point));
        corners
            .filter_map(|(&vertex, share)| Some(share * field.get(vertex as usize)?))
            .sum()
    }

    /// Deepest penetration at a point, zero without any.
    pub(super) fn deepest(&self) -> f64 {
        let depths = self.contacts.iter().map(|contact| -contact.distance);
        depths.fold(0.0, f64::max)
    }

    /// lambda at a point, from its coefficients `[functions]`.
    pub(super) fn pressure(&self, face: &ContactFace, point: usize, pressure: &[f64]) -> f64 {
        let values = face.functions.iter().zip(self.table.values(point));
        values.map(|(&m, value)| value * pressure[m as usize]).sum()
    }
}

/// Coefficients of x + u at the nodes of a face: positions of the corners, those of
/// the edges in the hierarchical basis; zero beyond the face's nodes.
pub(super) fn node_positions(body: &Deformed<'_>, face: &ContactFace) -> [[f64; 3]; NODES] {
    let c = body.space.components;
    let mut values = [[0.0; 3]; NODES];
    for (shape, (&node, value)) in face.nodes.iter().zip(&mut values).enumerate() {
        if let Some(&corner) = face.corners.get(shape) {
            *value = body.mesh.coordinates()[corner as usize].map(|x| body.scale * x);
        }
        for (i, x) in value.iter_mut().enumerate().take(c) {
            *x += body.displacement[node as usize * c + i];
        }
    }
    if let Some(curve) = &face.curve {
        let edges = values.iter_mut().skip(face.corners.len());
        for (value, offset) in edges.zip(curve.offsets) {
            *value = add(*value, offset);
        }
    }
    values
}

impl<'a> Deformed<'a> {
    /// The body with another displacement.
    pub fn displaced(&self, displacement: &'a [f64]) -> Self {
        Self {
            displacement,
            ..*self
        }
    }
}

impl Deformed<'_> {
    /// Place of a vertex; of an edge that of its middle less the mean of its ends.
    pub fn place(&self, node: usize) -> [f64; 3] {
        let vertices = self.mesh.coordinates();
        let rest = match vertices.get(node) {
            Some(vertex) => *vertex,
            None => self.mesh.offset_of(node - vertices.len()),
        };
        let first = node * self.space.components;
        let moved = self.displacement.get(first..).unwrap_or(&[]);
        let moved = moved.iter().take(self.space.components);
        let mut place = rest.map(|x| self.scale * x);
        place.iter_mut().zip(moved).for_each(|(x, u)| *x += u);
        place
    }

    /// Runs `kernel` on each of `faces`, in parallel where they are many; it fills
    /// the `size` numbers of its face, zero before, in the result `[faces, size]`.
    pub(super) fn on_faces(
        &self,
        table: &Table<'_>,
        faces: &[ContactFace],
        size: usize,
        kernel: impl Fn(&mut FacePoints<'_>, &ContactFace, &mut [f64]) + Sync,
    ) -> Vec<f64> {
        let mut out = vec![0.0; faces.len() * size];
        let fresh = || FacePoints::new(table);
        let scratch = Scratch::new(&fresh);
        let pieces = Pieces::of(&mut out, PARALLEL_FACES * size);
        parallel::each(pieces, 1, &|piece, numbers| {
            let faces = &faces[piece * PARALLEL_FACES..];
            scratch.lend(|points| {
                for (face, numbers) in faces.iter().zip(numbers.chunks_mut(size)) {
                    points.place(self, face);
                    kernel(points, face, numbers);
                }
            });
        });
        out
    }
}
