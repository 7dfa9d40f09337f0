//! The second derivative of the weighted gaps times the contact pressure, which is
//! subtracted from the stiffness:
//!
//! ```text
//! K_kl = int lambda (Hessian of d) N_k N_l dS   [unknowns, unknowns]
//! ```
//!
//! over the undeformed surface, and over the deformed one, with the derivatives a_k of da,
//!
//! ```text
//! K_kl = int lambda [ (Hessian of d) N_k N_l da + N_k n a_l^T + a_k n^T N_l + d a_kl ]
//! ```
//!
//! On a curved face the Hessian of d(x(u)), with the turning of the offsets.
//! Cost: (rule points) * (faces under pressure) Hessians, each times the squared
//! number of nodes of a face.

use std::borrow::Cow;
use std::collections::BTreeMap;

use rayon::prelude::*;

use super::area_change::{Pressures, WHOLE};
use super::area_element::{AreaElement, NODES};
use super::counterpart::Counterpart;
use super::deformed::{Deformed, FacePoints, Measure, Table};
use super::face::ContactFace;
use super::surface::ContactSurface;
use crate::linalg::{SparseRows, SparseRowsBuilder};
use crate::obstacle::{Contact, Derivatives};

/// Fewer nodes are not worth a second thread.
const PARALLEL_NODES: usize = 64;

/// Entries of some rows, by unknown.
type Rows = Vec<(u32, Vec<(u32, f64)>)>;

/// K of surfaces on what they meet with their pressures `[multipliers]`; rows and
/// columns of unknowns that are `held` are left out.
pub fn curvature<C: Counterpart + ?Sized>(
    body: &Deformed<'_>,
    surfaces: &[(&ContactSurface, &C, &[f64])],
    held: &[bool],
) -> SparseRows {
    let integrated = surfaces.iter();
    let integrated = integrated.map(|&surface| Integrated::new(body, surface, held));
    summed(body, integrated)
}

/// K of surfaces under `pressures` with what the gaps hold left out: on faces whose functions are
/// all closed the derivatives of da count with the internal pressure ([`super::area_change`]),
/// so that what a constraint u.n = 0 cancels is not there, nor d a_kl, whose d the next step
/// closes.
pub fn curvature_where_held<C: Counterpart + ?Sized>(
    body: &Deformed<'_>,
    surfaces: &[(&ContactSurface, &C, Pressures<'_>)],
    held: &[bool],
) -> SparseRows {
    let integrated = surfaces.iter();
    let integrated = integrated.map(|&(surface, counterpart, pressures)| {
        let closed = surface.shares.spread(pressures.closed);
        let pressure = surface.shares.spread(pressures.contact);
        let loaded = pressure.clone();
        Integrated::of_faces(body, (surface, loaded, held), |points, face, blocks| {
            points.probe(counterpart, face, Derivatives::Curvature);
            let is_closed = |&k: &u32| closed[k as usize] > WHOLE;
            let is_held = face.functions.iter().all(is_closed);
            if is_held {
                // At equilibrium d is next to nothing; before, it is what the next step closes.
                points
                    .contacts
                    .iter_mut()
                    .for_each(|contact| contact.distance = 0.0);
            }
            let internal = is_held.then_some(pressures.internal);
            add_deformed_blocks(points, (face, internal), &pressure, blocks);
        })
    });
    summed(body, integrated)
}

/// What the change of the deformed area makes of tractions, int N_k T (da/du_l) with
/// T = sum psi_i T_i, of surfaces with their T_i `[multipliers][3]`; rows and columns of unknowns
/// that are `held` are left out. Not symmetric.
pub fn traction_change(
    body: &Deformed<'_>,
    surfaces: &[(&ContactSurface, Vec<[f64; 3]>)],
    held: &[bool],
) -> SparseRows {
    let integrated = surfaces.iter();
    let integrated = integrated
        .map(|(surface, tractions)| Integrated::of_tractions(body, (surface, tractions), held));
    summed(body, integrated)
}

/// The sum over surfaces `[unknowns, unknowns]`.
fn summed<'a>(body: &Deformed<'_>, surfaces: impl Iterator<Item = Integrated<'a>>) -> SparseRows {
    let unknowns = body.space.displacement_unknowns();
    let mut rows: BTreeMap<u32, Vec<(u32, f64)>> = BTreeMap::new();
    for surface in surfaces {
        for (unknown, mut entries) in surface.rows() {
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
    /// Which functions are loaded: coefficients of the contact pressure `[functions]`,
    /// non-dimensional, or sizes of tractions.
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
    fn new<C: Counterpart + ?Sized>(
        body: &Deformed<'_>,
        (surface, counterpart, pressure): (&'a ContactSurface, &C, &'a [f64]),
        held: &'a [bool],
    ) -> Self {
        let pressure = surface.shares.spread(pressure);
        let loaded = pressure.clone();
        Self::of_faces(body, (surface, loaded, held), |points, face, blocks| {
            points.probe(counterpart, face, Derivatives::Curvature);
            match body.measure {
                Measure::Deformed => {
                    add_deformed_blocks(points, (face, None), &pressure, blocks);
                }
                Measure::Undeformed => add_blocks(points, face, &pressure, blocks),
            }
        })
    }

    /// The same of tractions `[multipliers][3]`.
    fn of_tractions(
        body: &Deformed<'_>,
        (surface, tractions): (&'a ContactSurface, &[[f64; 3]]),
        held: &'a [bool],
    ) -> Self {
        let along = [0, 1, 2].map(|i| {
            let own: Vec<f64> = tractions.iter().map(|traction| traction[i]).collect();
            surface.shares.spread(&own).into_owned()
        });
        let size = |k: usize| along.iter().map(|own| own[k].abs()).fold(0.0, f64::max);
        let sizes: Vec<f64> = (0..surface.carriers.len()).map(size).collect();
        Self::of_faces(
            body,
            (surface, sizes.into(), held),
            |points, face, blocks| {
                add_traction_blocks(points, (face, &along), blocks);
            },
        )
    }

    /// Of what `add` integrates over every face where a coefficient of `loaded` is not zero.
    fn of_faces(
        body: &Deformed<'_>,
        (surface, loaded, held): (&'a ContactSurface, Cow<'a, [f64]>, &'a [bool]),
        add: impl Fn(&mut FacePoints<'_>, &ContactFace, &mut [f64]) + Sync,
    ) -> Self {
        let table = Table::new(body, surface.basis);
        let size = 9 * table.nodes * table.nodes;
        let blocks = body.on_faces(&table, &surface.faces, size, |points, face, blocks| {
            if is_under_pressure(face, &loaded) {
                add(points, face, blocks);
            }
        });
        Self {
            surface,
            pressure: loaded,
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

/// Adds what the deformed area makes of them `[nodes, nodes, 3, 3]`; the derivatives of da count
/// with the pressure at the corners where there is one.
fn add_deformed_blocks(
    points: &FacePoints<'_>,
    (face, of_area): (&ContactFace, Option<&[f64]>),
    pressure: &[f64],
    blocks: &mut [f64],
) {
    let (table, nodes) = (points.table, points.table.nodes);
    let elements = points.contacts.iter().zip(&points.areas).enumerate();
    for (point, (contact, area)) in elements {
        let lambda = table.rule.weights[point] * points.pressure(face, point, pressure);
        let area_lambda = of_area.map_or(lambda, |internal| {
            table.rule.weights[point] * points.at_corners(face, point, internal)
        });
        let at = Point {
            contact,
            area,
            shapes: table.shapes(point),
            slopes: table.slopes(point),
            changes: std::array::from_fn(|k| {
                table
                    .shapes(point)
                    .get(k)
                    .map_or([0.0; 3], |&shape| area.gradient(k, shape))
            }),
        };
        for (pair, block) in blocks.chunks_exact_mut(9).enumerate() {
            at.add_hessian([pair / nodes, pair % nodes], [lambda, area_lambda], block);
        }
    }
}

/// Adds int N_k T a_l^T `[nodes, nodes, 3, 3]`.
fn add_traction_blocks(
    points: &FacePoints<'_>,
    (face, tractions): (&ContactFace, &[Vec<f64>; 3]),
    blocks: &mut [f64],
) {
    let (table, nodes) = (points.table, points.table.nodes);
    for (point, area) in points.areas.iter().enumerate() {
        let weight = table.rule.weights[point];
        let traction = tractions
            .each_ref()
            .map(|own| weight * points.pressure(face, point, own));
        let shapes = table.shapes(point);
        for (pair, block) in blocks.chunks_exact_mut(9).enumerate() {
            let (k, l) = (pair / nodes, pair % nodes);
            let change = area.gradient(l, shapes[l]);
            for (row, traction) in block.chunks_exact_mut(3).zip(traction) {
                let moved = row.iter_mut().zip(change);
                moved.for_each(|(entry, change)| *entry += shapes[k] * traction * change);
            }
        }
    }
}

/// d da at a point and its derivatives.
struct Point<'a> {
    contact: &'a Contact,
    area: &'a AreaElement,
    shapes: &'a [f64],
    slopes: &'a [[f64; 2]],
    /// a_k.
    changes: [[f64; 3]; NODES],
}

impl Point<'_> {
    /// Adds the second derivative by the coefficients of two nodes `[3, 3]` times a factor, its
    /// terms of the area times another.
    fn add_hessian(&self, [k, l]: [usize; 2], [factor, of_area]: [f64; 2], block: &mut [f64]) {
        let values = [self.shapes[k], self.shapes[l]];
        let slopes = [self.slopes[k], self.slopes[l]];
        let bend = self.area.hessian([k, l], values, slopes);
        let size = values[0] * values[1] * self.area.size();
        let normal = self.contact.normal;
        for (i, row) in block.chunks_exact_mut(3).enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                *entry += factor
                    * (size * self.contact.curvature[i][j] + self.contact.distance * bend[i][j])
                    + of_area
                        * (values[0] * normal[i] * self.changes[l][j]
                            + values[1] * self.changes[k][i] * normal[j]);
            }
        }
    }
}
