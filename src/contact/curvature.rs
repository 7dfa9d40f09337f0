//! The curvature term of the Lagrangian, what the contact pressure takes off the
//! stiffness:
//!
//! ```text
//! K_kl = int lambda (Hessian of d) N_k N_l dS   [unknowns, unknowns]
//! ```
//!
//! On a curved face the Hessian of d(x(u)), with the turning of the offsets.
//! Cost: (rule points) * (faces under pressure) Hessians, each times the squared
//! number of nodes of a face.

use std::borrow::Cow;
use std::collections::BTreeMap;

use rayon::prelude::*;

use super::deformed::{Deformed, FacePoints, Table};
use super::face::ContactFace;
use super::surface::ContactSurface;
use crate::linalg::{SparseRows, SparseRowsBuilder};
use crate::obstacle::{Obstacle, What};

/// Fewer nodes are not worth a second thread.
const PARALLEL_NODES: usize = 64;

/// Entries of some rows, by unknown.
type Rows = Vec<(u32, Vec<(u32, f64)>)>;

/// K of surfaces on their obstacles with their pressures `[multipliers]`; rows and
/// columns of unknowns that are `held` are left out.
pub fn curvature(
    body: &Deformed<'_>,
    surfaces: &[(&ContactSurface, &dyn Obstacle, &[f64])],
    held: &[bool],
) -> SparseRows {
    let unknowns = body.space.displacement_unknowns();
    let mut rows: BTreeMap<u32, Vec<(u32, f64)>> = BTreeMap::new();
    for &surface in surfaces {
        for (unknown, mut entries) in Integrated::new(body, surface, held).rows() {
            rows.entry(unknown).or_default().append(&mut entries);
        }
    }
    let mut builder = SparseRowsBuilder::new(unknowns);
    let mut next = 0;
    for (unknown, mut entries) in rows {
        (next..unknown).for_each(|_| builder.push_row(&mut []));
        builder.push_row(&mut entries);
        next = unknown + 1;
    }
    (next..unknowns as u32).for_each(|_| builder.push_row(&mut []));
    builder.finish()
}

/// Whether any coefficient of the face is not zero; a face without pressure adds nothing
/// and is not integrated.
fn is_under_pressure(face: &ContactFace, pressure: &[f64]) -> bool {
    face.functions.iter().any(|&m| pressure[m as usize] != 0.0)
}

/// A surface under pressure, integrated face by face.
struct Integrated<'a> {
    /// The surface whose faces are integrated.
    surface: &'a ContactSurface,
    /// Coefficients of the contact pressure `[functions]`, non-dimensional.
    pressure: Cow<'a, [f64]>,
    /// Whether a displacement unknown is held `[unknowns]`; held rows and columns are
    /// left out.
    held: &'a [bool],
    /// Components of the displacement: 3 in space, 2 in the plane.
    components: usize,
    /// Displacement nodes of a face: 6 in space, 3 in the plane.
    nodes: usize,
    /// int lambda H N_k N_l `[faces, nodes, nodes, 3, 3]`.
    blocks: Vec<f64>,
}

impl<'a> Integrated<'a> {
    /// Integrates lambda times the curvature of the obstacle over every face under
    /// pressure, in parallel. Cost: one probe a quadrature point.
    fn new(
        body: &Deformed<'_>,
        (surface, obstacle, pressure): (&'a ContactSurface, &dyn Obstacle, &'a [f64]),
        held: &'a [bool],
    ) -> Self {
        let pressure = surface.shares.spread(pressure);
        let table = Table::new(body, surface.basis);
        let size = 9 * table.nodes * table.nodes;
        let blocks = body.on_faces(&table, &surface.faces, size, |points, face, blocks| {
            if is_under_pressure(face, &pressure) {
                points.probe(obstacle, face, What::Curvature);
                match &points.standing {
                    Some(_) => add_curved_blocks(points, face, &pressure, blocks),
                    None => add_blocks(points, face, &pressure, blocks),
                }
            }
        });
        Self {
            surface,
            pressure,
            held,
            components: body.space.components,
            nodes: table.nodes,
            blocks,
        }
    }

    /// All rows, columns ascending, equal ones in the order of the faces.
    fn rows(&self) -> Rows {
        let nodes = self.surface.nodes.par_iter().enumerate();
        nodes
            .with_min_len(PARALLEL_NODES)
            .flat_map_iter(|(local, &node)| self.rows_of(local, node))
            .collect()
    }

    /// Rows of a node, which is number `local` of the surface.
    fn rows_of(&self, local: usize, node: u32) -> impl Iterator<Item = (u32, Vec<(u32, f64)>)> {
        let first = node * self.components as u32;
        let own = (0..self.components).map(move |i| (i, first + i as u32));
        own.filter(|&(_, unknown)| !self.held[unknown as usize])
            .map(move |(i, unknown)| (unknown, self.row(local, i)))
    }

    /// Row of component `i` of a node.
    fn row(&self, local: usize, i: usize) -> Vec<(u32, f64)> {
        let (c, n) = (self.components, self.nodes);
        let mut row = Vec::new();
        for place in self.surface.at_nodes.of(local) {
            let face = &self.surface.faces[place.face as usize];
            if !is_under_pressure(face, &self.pressure) {
                continue;
            }
            let first = (place.face as usize * n + place.slot as usize) * 9 * n;
            let blocks = self.blocks[first..first + 9 * n].chunks_exact(9);
            for (&column, block) in face.nodes.iter().zip(blocks) {
                let unknowns = (0..c).map(|j| (column * c as u32 + j as u32, block[3 * i + j]));
                row.extend(unknowns.filter(|&(unknown, _)| !self.held[unknown as usize]));
            }
        }
        row.sort_by_key(|entry| entry.0);
        row
    }
}

/// Adds int lambda d''(u) of all pairs of nodes of a curved face `[nodes, nodes, 3, 3]`.
fn add_curved_blocks(
    points: &FacePoints<'_>,
    face: &ContactFace,
    pressure: &[f64],
    blocks: &mut [f64],
) {
    let (table, nodes) = (points.table, points.table.nodes);
    let Some(standing) = &points.standing else {
        return;
    };
    for (point, contact) in points.contacts.iter().enumerate() {
        let weight = points.weights[point] * points.pressure(face, point, pressure);
        let at = standing.at(table.shapes(point), table.corners);
        for (pair, block) in blocks.chunks_exact_mut(9).enumerate() {
            let nodes = [pair / nodes, pair % nodes];
            let hessian = at.hessian(nodes, contact.normal, &contact.curvature);
            for (entry, value) in block.iter_mut().zip(hessian.as_flattened()) {
                *entry += weight * value;
            }
        }
    }
}

/// Adds int lambda H N_k N_l of all pairs of nodes of a face `[nodes, nodes, 3, 3]`.
fn add_blocks(points: &FacePoints<'_>, face: &ContactFace, pressure: &[f64], blocks: &mut [f64]) {
    let nodes = points.table.nodes;
    for (point, contact) in points.contacts.iter().enumerate() {
        let weight = points.weights[point] * points.pressure(face, point, pressure);
        let hessian = contact.curvature.as_flattened();
        let shapes = points.table.shapes(point);
        for (a, rows) in shapes.iter().zip(blocks.chunks_exact_mut(9 * nodes)) {
            for (b, block) in shapes.iter().zip(rows.chunks_exact_mut(9)) {
                let factor = weight * a * b;
                for (entry, value) in block.iter_mut().zip(hessian) {
                    *entry += factor * value;
                }
            }
        }
    }
}
