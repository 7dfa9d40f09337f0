//! How the area under contact pressure changes with the displacement:
//!
//! ```text
//! R_j(v) = int psi_j p da(v),   a = n . (x_,1 x x_,2),   M_jk = int psi_j psi_k dS
//! ```
//!
//! n: the obstacle's normal; x_,1, x_,2: tangents of the deformed face; p: the internal
//! pressure there, or lambda dS / a where the body has none. A body under pressure takes
//! int p (u.n da(v) + v.n da(u)) off its stiffness on a loaded face, far more than its
//! shear stiffness where p is; the gap holds u.n, and with u.n = sum_k (M^-1 C u)_k psi_k
//! these rows say what is cancelled there. It has to be the pressure in the stiffness:
//! lambda agrees with it at an equilibrium only. Faces that are closed in part keep the
//! term: pressure is small at the rim of contact, and the gap does not hold u.n there. Shapes `[multipliers, displacement]`,
//! `[multipliers, multipliers]`. Cost: one probe a quadrature point of the faces under
//! pressure.

use std::f64::consts::TAU;

use super::counterpart::Counterpart;
use super::deformed::{Deformed, FacePoints, Table};
use super::deformed_area::node_positions;
use super::face::ContactFace;
use super::shares::add_equal_columns;
use super::surface::ContactSurface;
use crate::assembly::follower::shape_slopes;
use crate::geometry::vector3::{add, cross, dot, norm, scale};
use crate::obstacle::What;

/// Least cosine between a face and its obstacle: beyond it pressure is no area's.
const FACING: f64 = 0.1;

/// Share of closed multipliers that makes a function closed, but for rounding.
const WHOLE: f64 = 1.0 - 1e-9;

/// R and M of one surface, sparse rows with ascending columns.
#[derive(Clone, Debug, Default)]
pub struct AreaChange {
    /// R, held columns left out `[multipliers]`.
    pub rows: Vec<Vec<(u32, f64)>>,
    /// M `[multipliers]`.
    pub mass: Vec<Vec<(u32, f64)>>,
}

/// Pressures at a contact surface.
#[derive(Clone, Copy, Debug)]
pub struct Pressures<'a> {
    /// Contact pressure `[multipliers]`.
    pub contact: &'a [f64],
    /// Internal pressure `[vertices]`; empty for a body in displacement form.
    pub internal: &'a [f64],
    /// One where a multiplier is closed, else zero `[multipliers]`: faces count whose
    /// functions all are.
    pub closed: &'a [f64],
}

/// R and M of `surface` under `pressures`; `held[k]` says that unknown k is prescribed.
pub fn area_change<C: Counterpart + ?Sized>(
    body: &Deformed<'_>,
    (surface, counterpart): (&ContactSurface, &C),
    pressures: Pressures<'_>,
    held: &[bool],
) -> AreaChange {
    let coefficients = surface.shares.spread(pressures.contact);
    let closed = surface.shares.spread(pressures.closed);
    let table = Table::new(body, surface.basis);
    let slopes: Vec<Vec<[f64; 2]>> = (0..table.points())
        .map(|point| shape_slopes(table.coordinates(point)))
        .collect();
    let changes = table.functions * table.nodes * 3;
    let size = changes + table.functions * table.functions;
    let numbers = body.on_faces(&table, &surface.faces, size, |points, face, numbers| {
        let (rows, mass) = numbers.split_at_mut(changes);
        add_mass(points, mass);
        let is_closed = |&k: &u32| closed[k as usize] > WHOLE;
        if face.functions.iter().all(is_closed) {
            points.probe(counterpart, face, What::Normal);
            let nodes = node_positions(body, points, face);
            for (point, slopes) in slopes.iter().enumerate() {
                let change = AreaAt::new(points, (face, &nodes), (point, slopes));
                let load = match pressures.internal {
                    [] => points.weights[point] * points.pressure(face, point, &coefficients),
                    internal => {
                        let corners = face.corners.iter().zip(points.table.coordinates(point));
                        let p: f64 = corners.map(|(&v, l)| l * internal[v as usize]).sum();
                        points.table.rule.weights[point] * change.area * p
                    }
                };
                add_change(points, (point, load), &change.relative, rows);
            }
        }
    });
    let mut out = AreaChange {
        rows: vec![Vec::new(); surface.carriers.len()],
        mass: vec![Vec::new(); surface.carriers.len()],
    };
    for (face, numbers) in surface.faces.iter().zip(numbers.chunks_exact(size)) {
        out.add_face(face, numbers, (body.space.components, held));
    }
    out.gathered(surface)
}

/// int psi_j psi_k of a face `[functions, functions]`.
fn add_mass(points: &FacePoints<'_>, mass: &mut [f64]) {
    let functions = points.table.functions;
    for (point, weight) in points.weights.iter().enumerate() {
        let values = points.table.values(point);
        for (left, row) in values.iter().zip(mass.chunks_exact_mut(functions)) {
            for (right, entry) in values.iter().zip(row) {
                *entry += weight * left * right;
            }
        }
    }
}

/// The area at a point as an obstacle sees it.
struct AreaAt {
    /// |n . a| of the deformed face were it everywhere as here.
    area: f64,
    /// da(v) / a for every node and direction `[nodes][3]`; zero where the face does not
    /// face its obstacle.
    relative: Vec<[f64; 3]>,
}

impl AreaAt {
    fn new(
        points: &FacePoints<'_>,
        (face, nodes): (&ContactFace, &[[f64; 3]; 6]),
        (point, slopes): (usize, &[[f64; 2]]),
    ) -> Self {
        let mut along = [[0.0; 3], [0.0, 0.0, 1.0]];
        let mut radius = 0.0;
        let values = points.table.shapes(point);
        let directions = face.corners.len() - 1;
        for ((position, slope), value) in nodes.iter().zip(slopes).zip(values) {
            radius += value * position[0];
            for (tangent, &slope) in along[..directions].iter_mut().zip(slope) {
                if directions == 2 || tangent[2] == 0.0 {
                    *tangent = add(*tangent, scale(slope, *position));
                }
            }
        }
        let normal = points.contacts[point].normal;
        let area = cross(along[0], along[1]);
        let facing = dot(normal, area);
        if facing.abs() <= FACING * norm(area) {
            return Self {
                area: 0.0,
                relative: vec![[0.0; 3]; slopes.len()],
            };
        }
        let by_first = scale(1.0 / facing, cross(along[1], normal));
        let by_second = scale(1.0 / facing, cross(normal, along[0]));
        let turn = face.radii.map_or(0.0, |_| 1.0 / radius);
        let change = |(slope, value): (&[f64; 2], &f64)| {
            let mut change = scale(slope[0], by_first);
            if directions == 2 {
                change = add(change, scale(slope[1], by_second));
            }
            change[0] += turn * value;
            change
        };
        let measure = match (directions, face.radii) {
            (2, _) => 0.5,
            (_, Some(_)) => TAU * radius,
            (_, None) => 1.0,
        };
        Self {
            area: measure * facing.abs(),
            relative: slopes.iter().zip(values).map(change).collect(),
        }
    }
}

/// Adds psi_j load da / a of a point `[functions, nodes, 3]`.
fn add_change(
    points: &FacePoints<'_>,
    (point, load): (usize, f64),
    change: &[[f64; 3]],
    rows: &mut [f64],
) {
    let values = points.table.values(point);
    let width = 3 * points.table.nodes;
    for (value, row) in values.iter().zip(rows.chunks_exact_mut(width)) {
        let weight = load * value;
        for (entry, part) in row.iter_mut().zip(change.as_flattened()) {
            *entry += weight * part;
        }
    }
}

impl AreaChange {
    /// Adds the numbers of one face to the rows of its functions.
    fn add_face(
        &mut self,
        face: &ContactFace,
        numbers: &[f64],
        (components, held): (usize, &[bool]),
    ) {
        let (functions, nodes) = (face.functions.len(), face.nodes.len());
        let (rows, mass) = numbers.split_at(functions * nodes * 3);
        for (slot, &function) in face.functions.iter().enumerate() {
            let own = &rows[slot * nodes * 3..(slot + 1) * nodes * 3];
            let row = &mut self.rows[function as usize];
            for (&node, parts) in face.nodes.iter().zip(own.chunks_exact(3)) {
                let first = node * components as u32;
                let unknowns = (first..first + components as u32).zip(parts);
                let free = unknowns.filter(|&(k, &part)| part != 0.0 && !held[k as usize]);
                row.extend(free.map(|(k, &part)| (k, part)));
            }
            let own = mass[slot * functions..(slot + 1) * functions].iter();
            let entries = face.functions.iter().copied().zip(own.copied());
            self.mass[function as usize].extend(entries);
        }
    }

    /// Of the multipliers that stand for the functions.
    fn gathered(mut self, surface: &ContactSurface) -> Self {
        let shares = &surface.shares;
        self.rows.iter_mut().for_each(add_equal_columns);
        for row in &mut self.mass {
            let own = row.iter().flat_map(|&(function, value)| {
                let of = shares.of(function);
                of.map(move |(m, share)| (m, share * value))
            });
            *row = own.collect();
            add_equal_columns(row);
        }
        Self {
            rows: shares.gather_rows(self.rows),
            mass: shares.gather_rows(self.mass),
        }
    }
}
