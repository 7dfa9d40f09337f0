//! Pressure that follows the deformed faces x = X + u of a body:
//!
//! ```text
//! f(v) = - int p n . v da = - int p (x_s x x_t) . v ds dt
//! ```
//!
//! with the outward normal n, so that p > 0 pushes on the body, and its derivative
//! with respect to u (Bonet and Wood, Nonlinear Continuum Mechanics, 8.4.3; the part
//! of a free edge of the surface is not symmetric). In the plane x_t is the unit
//! vector out of it; about the axis x = 0 the area is that of the deformed full
//! turn, 2 pi r with r = x + u.
//!
//! Vertices of a facet are ordered so that its normal points outwards, as those of a
//! mesh are. The rules are exact on straight-sided meshes. Shapes: hierarchical
//! displacement and force `[unknowns]`. Cost: some 500 flops a face for the load,
//! 15 000 for the derivative, the latter in parallel over nodes, summed in the
//! order of the faces.

use crate::parallel;
use std::f64::consts::TAU;

use super::load::shape_values;
use crate::element::quadrature::{Simplex, rule};
use crate::geometry::vector3::{cross, norm, scale};
use crate::linalg::{SparseRows, SparseRowsBuilder};
use crate::mesh::CurvedFacet;
use crate::mesh::Mesh;
use crate::space::TaylorHood;

/// Nodes of a face at most.
const NODES: usize = 6;

/// What an area of the model stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurfaceMeasure {
    /// The area of a face.
    Solid,
    /// A length in the plane, times a thickness of one.
    Plane,
    /// A length in the half-plane x > 0, times its way around the axis x = 0.
    Axisymmetric,
}

impl SurfaceMeasure {
    fn facet(self) -> Simplex {
        match self {
            Self::Solid => Simplex::Triangle,
            Self::Plane | Self::Axisymmetric => Simplex::Segment,
        }
    }

    /// Of a shape function times the area vector.
    fn degree(self) -> u32 {
        match self {
            Self::Solid => 4,
            Self::Plane => 3,
            Self::Axisymmetric => 5,
        }
    }

    /// Area vector over x_s x x_t at radius `radius`, per weight of the rule.
    fn factor(self, radius: f64) -> f64 {
        match self {
            Self::Solid => 0.5,
            Self::Plane => 1.0,
            Self::Axisymmetric => TAU * radius,
        }
    }

    /// Its derivative with respect to the radius.
    fn factor_slope(self) -> f64 {
        match self {
            Self::Solid | Self::Plane => 0.0,
            Self::Axisymmetric => TAU,
        }
    }
}

/// A body in a deformed state.
#[derive(Clone, Copy)]
pub struct PressedBody<'a> {
    /// Mesh.
    pub mesh: &'a Mesh,
    /// Multiplies the coordinates.
    pub scale: f64,
    /// Numbering.
    pub space: &'a TaylorHood,
    /// What areas stand for.
    pub measure: SurfaceMeasure,
    /// Hierarchical displacement `[unknowns]`; none where pressures act on the undeformed body.
    pub displacement: &'a [f64],
}

/// A pressure on facets of the mesh.
#[derive(Clone, Copy, Debug)]
pub struct FollowerPressure<'a> {
    /// Facets, by number.
    pub facets: &'a [u32],
    /// p, with the load factor.
    pub pressure: PressureValues<'a>,
}

/// How a pressure varies over its facets.
#[derive(Clone, Copy, Debug)]
pub enum PressureValues<'a> {
    /// The same everywhere.
    Uniform(f64),
    /// Coefficients of the quadratic Bernstein functions of the displacement's nodes `[nodes]`:
    /// L_v^2 of a vertex, 2 L_a L_b of an edge.
    Nodes(&'a [f64]),
}

impl PressureValues<'_> {
    /// Degree of the variation.
    fn degree(self) -> u32 {
        match self {
            Self::Uniform(_) => 0,
            Self::Nodes(_) => 2,
        }
    }

    /// On the face with these nodes.
    fn on(self, nodes: &[u32]) -> FacePressure {
        match self {
            Self::Uniform(pressure) => FacePressure::Uniform(pressure),
            Self::Nodes(all) => {
                let mut own = [0.0; NODES];
                for (value, &node) in own.iter_mut().zip(nodes) {
                    *value = all[node as usize];
                }
                FacePressure::Nodes(own)
            }
        }
    }
}

/// Pressure on one face.
enum FacePressure {
    Uniform(f64),
    /// Bernstein coefficients of its nodes.
    Nodes([f64; NODES]),
}

impl FacePressure {
    fn at(&self, point: &FacePoint) -> f64 {
        match self {
            Self::Uniform(pressure) => *pressure,
            Self::Nodes(own) => {
                let parts = own.iter().zip(&point.bernstein);
                parts.map(|(value, shape)| value * shape).sum()
            }
        }
    }

    fn is_zero(&self) -> bool {
        match self {
            Self::Uniform(_) => false,
            Self::Nodes(own) => own.iter().all(|&value| value == 0.0),
        }
    }
}

/// Shape functions of a face at a point of the rule.
struct FacePoint {
    weight: f64,
    values: Vec<f64>,
    /// Quadratic Bernstein functions.
    bernstein: Vec<f64>,
    /// Derivatives along s and t.
    slopes: Vec<[f64; 2]>,
}

/// The points of the rule for `pressures` over `measure`.
fn face_points(measure: SurfaceMeasure, pressures: &[FollowerPressure<'_>]) -> Vec<FacePoint> {
    let simplex = measure.facet();
    let corners = simplex.vertices();
    let varying = pressures.iter().map(|one| one.pressure.degree());
    let rule = rule(simplex, measure.degree() + varying.max().unwrap_or(0));
    let points = rule.points.iter().zip(&rule.weights);
    let tabulated = points.map(|(point, &weight)| FacePoint {
        weight,
        values: shape_values(&point[..corners]),
        bernstein: bernstein_values(&point[..corners]),
        slopes: shape_slopes(&point[..corners]),
    });
    tabulated.collect()
}

/// Quadratic Bernstein functions of corners, then edges, at barycentric coordinates.
fn bernstein_values(l: &[f64]) -> Vec<f64> {
    let mut values: Vec<f64> = l.iter().map(|l| l * l).collect();
    for a in 0..l.len() {
        values.extend((a + 1..l.len()).map(|b| 2.0 * l[a] * l[b]));
    }
    values
}

/// Of [`shape_values`] along s = l_1 and t = l_2.
pub fn shape_slopes(l: &[f64]) -> Vec<[f64; 2]> {
    let hats = [[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]];
    let hats = match l.len() {
        2 => [[-1.0, 0.0], [1.0, 0.0], [0.0, 0.0]],
        _ => hats,
    };
    let mut slopes = hats[..l.len()].to_vec();
    for a in 0..l.len() {
        for b in a + 1..l.len() {
            slopes.push([0, 1].map(|k| 4.0 * (l[a] * hats[b][k] + l[b] * hats[a][k])));
        }
    }
    slopes
}

/// A face with pressure on it.
struct Face {
    nodes: Vec<u32>,
    /// Hierarchical coefficients of X + u.
    place: [[f64; 3]; NODES],
    pressure: FacePressure,
}

/// Entries (column, value) in the rows of a node, one row a direction.
type NodeRows = [Vec<(u32, f64)>; 3];

/// Position and tangents of a face at a point.
struct Frame {
    radius: f64,
    along: [[f64; 3]; 2],
}

impl Face {
    fn new(body: &PressedBody<'_>, facet: u32, pressure: PressureValues<'_>) -> Self {
        let corners = body.mesh.facet(facet as usize);
        let nodes = body.space.facet_nodes(corners);
        let mut place = [[0.0; 3]; NODES];
        for (row, &vertex) in place.iter_mut().zip(corners) {
            *row = scale(body.scale, body.mesh.coordinates()[vertex as usize]);
        }
        if let Some(curve) = CurvedFacet::of(body.mesh, body.scale, corners) {
            place[corners.len()..]
                .iter_mut()
                .zip(curve.offsets)
                .for_each(|(row, o)| *row = o);
        }
        let c = body.space.components;
        let is_moved = !body.displacement.is_empty();
        for (row, &node) in place.iter_mut().zip(&nodes).filter(|_| is_moved) {
            let first = node as usize * c;
            let moved = &body.displacement[first..first + c];
            row.iter_mut().zip(moved).for_each(|(x, u)| *x += u);
        }
        Self {
            pressure: pressure.on(&nodes),
            nodes,
            place,
        }
    }

    fn frame(&self, measure: SurfaceMeasure, point: &FacePoint) -> Frame {
        let mut radius = 0.0;
        let mut along = [[0.0; 3]; 2];
        let shapes = point.values.iter().zip(&point.slopes);
        for (x, (value, slopes)) in self.place.iter().zip(shapes) {
            radius += value * x[0];
            for (tangent, slope) in along.iter_mut().zip(slopes) {
                (0..3).for_each(|i| tangent[i] += slope * x[i]);
            }
        }
        match measure {
            SurfaceMeasure::Solid => {}
            SurfaceMeasure::Plane | SurfaceMeasure::Axisymmetric => along[1] = [0.0, 0.0, 1.0],
        }
        Frame { radius, along }
    }

    /// The force of the face on its nodes.
    fn load(&self, measure: SurfaceMeasure, points: &[FacePoint]) -> [[f64; 3]; NODES] {
        let mut load = [[0.0; 3]; NODES];
        for point in points {
            let Frame { radius, along } = self.frame(measure, point);
            let factor = -self.pressure.at(point) * point.weight * measure.factor(radius);
            let area = scale(factor, cross(along[0], along[1]));
            for (sum, value) in load.iter_mut().zip(&point.values) {
                (0..3).for_each(|i| sum[i] += value * area[i]);
            }
        }
        load
    }

    /// Derivative of the force on node `k` with respect to every node's
    /// displacement, `[node][direction of u][direction of the force]`.
    fn slopes(
        &self,
        measure: SurfaceMeasure,
        points: &[FacePoint],
        k: usize,
    ) -> [[[f64; 3]; 3]; NODES] {
        let mut slopes = [[[0.0; 3]; 3]; NODES];
        for point in points {
            let Frame { radius, along } = self.frame(measure, point);
            let weight = -self.pressure.at(point) * point.weight * point.values[k];
            let factor = weight * measure.factor(radius);
            let area = cross(along[0], along[1]);
            let on_radius = scale(weight * measure.factor_slope(), area);
            let units = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            let first = units.map(|unit| scale(factor, cross(unit, along[1])));
            let second = units.map(|unit| scale(factor, cross(along[0], unit)));
            let shapes = point.values.iter().zip(&point.slopes);
            for (block, (value, [s, t])) in slopes.iter_mut().zip(shapes) {
                for (j, row) in block.iter_mut().enumerate() {
                    (0..3).for_each(|i| row[i] += s * first[j][i] + t * second[j][i]);
                }
                (0..3).for_each(|i| block[0][i] += value * on_radius[i]);
            }
        }
        slopes
    }
}

fn faces(body: &PressedBody<'_>, pressures: &[FollowerPressure<'_>]) -> Vec<Face> {
    let faces = pressures.iter().flat_map(|one| {
        let facets = one.facets.iter();
        facets.map(|&facet| Face::new(body, facet, one.pressure))
    });
    faces.filter(|face| !face.pressure.is_zero()).collect()
}

/// Adds the force of `pressures` to `force` `[unknowns]`.
pub fn add_follower_load(
    body: &PressedBody<'_>,
    pressures: &[FollowerPressure<'_>],
    force: &mut [f64],
) {
    let points = face_points(body.measure, pressures);
    let c = body.space.components;
    for face in faces(body, pressures) {
        let load = face.load(body.measure, &points);
        for (&node, part) in face.nodes.iter().zip(&load) {
            let first = node as usize * c;
            let sums = force[first..first + c].iter_mut();
            sums.zip(part).for_each(|(sum, part)| *sum += part);
        }
    }
}

/// Integral of `pressures` over the area on which they act, without direction.
pub fn follower_sum(body: &PressedBody<'_>, pressures: &[FollowerPressure<'_>]) -> f64 {
    let points = face_points(body.measure, pressures);
    let mut sum = 0.0;
    for face in faces(body, pressures) {
        for point in &points {
            let Frame { radius, along } = face.frame(body.measure, point);
            let area = body.measure.factor(radius) * norm(cross(along[0], along[1]));
            sum += face.pressure.at(point) * point.weight * area;
        }
    }
    sum
}

/// Derivative of the force of `pressures` with respect to the displacement: what
/// they take off the stiffness `[unknowns, unknowns]`, held rows and columns left
/// out. Not symmetric where the surface has a free edge.
pub fn follower_tangent(
    body: &PressedBody<'_>,
    pressures: &[FollowerPressure<'_>],
    held: &[bool],
) -> SparseRows {
    let points = face_points(body.measure, pressures);
    let faces = faces(body, pressures);
    let mut shares: Vec<(u32, u32, usize)> = Vec::new();
    for (face, number) in faces.iter().zip(0..) {
        let nodes = face.nodes.iter().enumerate();
        shares.extend(nodes.map(|(k, &node)| (node, number, k)));
    }
    shares.sort_unstable();
    let at_nodes: Vec<_> = shares.chunk_by(|a, b| a.0 == b.0).collect();
    let c = body.space.components;
    let mut rows = parallel::map(at_nodes.len(), 1, &|place| {
        let shares = at_nodes[place];
        let mut rows = NodeRows::default();
        for &(_, number, k) in shares.iter() {
            let face = &faces[number as usize];
            let slopes = face.slopes(body.measure, &points, k);
            add_rows((face, &slopes), c, held, &mut rows);
        }
        (shares[0].0 as usize, rows)
    });
    assemble(body.space.displacement_unknowns(), c, held, &mut rows)
}

/// Appends one face's part in the rows of a node.
fn add_rows(
    (face, slopes): (&Face, &[[[f64; 3]; 3]; NODES]),
    components: usize,
    held: &[bool],
    rows: &mut NodeRows,
) {
    for (&node, block) in face.nodes.iter().zip(slopes) {
        for (j, column) in block.iter().enumerate().take(components) {
            let unknown = node as usize * components + j;
            if !held[unknown] {
                let rows = rows.iter_mut().zip(column);
                rows.for_each(|(row, &value)| row.push((unknown as u32, value)));
            }
        }
    }
}

/// The matrix with the given rows of nodes, ascending, and no others.
fn assemble(
    unknowns: usize,
    components: usize,
    held: &[bool],
    rows: &mut [(usize, NodeRows)],
) -> SparseRows {
    let mut builder = SparseRowsBuilder::new(unknowns);
    let mut next = 0;
    for (node, rows) in rows {
        let first = *node * components;
        (next..first).for_each(|_| builder.push_row(&mut []));
        for (row, is_held) in rows.iter_mut().zip(&held[first..first + components]) {
            if *is_held {
                builder.push_row(&mut [])
            } else {
                builder.push_row(row)
            }
        }
        next = first + components;
    }
    (next..unknowns).for_each(|_| builder.push_row(&mut []));
    builder.finish()
}

#[cfg(test)]
mod tests;
