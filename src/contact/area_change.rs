//! How the area under contact pressure changes with the displacement, weighted by how far the
//! contact pressure is from the internal pressure there:
//!
//! ```text
//! R_j(v) = int psi_j (p - lambda) da(v),   da = |x_,1 x x_,2|,   M_jk = int psi_j psi_k da
//! ```
//!
//! p: the internal pressure, or zero. In the tangent of the energy the
//! internal pressure takes int p (u.n da(v) + v.n da(u)) off on a loaded face, and the second
//! derivative of the gap gives the same with lambda back: they differ by the deviatoric stress.
//! The gap holds u.n, and with u.n = sum_k (M^-1 C u)_k psi_k these rows say what is left there.
//! Faces that are closed in part keep the term: the gap does not hold u.n there. Shapes
//! `[multipliers, displacement]`, `[multipliers, multipliers]`. Cost: some 100 flops
//! a quadrature point and node of the closed faces.

use super::deformed::{Deformed, FacePoints, Table};
use super::face::ContactFace;
use super::shares::add_equal_columns;
use super::surface::ContactSurface;

/// Share of closed multipliers that makes a function closed, but for rounding.
pub(super) const WHOLE: f64 = 1.0 - 1e-9;

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
    /// Internal pressure `[vertices]`; empty where it counts as zero.
    pub internal: &'a [f64],
    /// One where a multiplier is closed, else zero `[multipliers]`: faces count whose
    /// functions all are.
    pub closed: &'a [f64],
}

/// R and M of `surface` under `pressures`; `held[k]` says that unknown k is prescribed.
pub fn area_change(
    body: &Deformed<'_>,
    surface: &ContactSurface,
    pressures: Pressures<'_>,
    held: &[bool],
) -> AreaChange {
    let coefficients = surface.shares.spread(pressures.contact);
    let closed = surface.shares.spread(pressures.closed);
    let table = Table::new(body, surface.basis);
    let changes = table.functions * table.nodes * 3;
    let size = changes + table.functions * table.functions;
    let numbers = body.on_faces(&table, &surface.faces, size, |points, face, numbers| {
        let (rows, mass) = numbers.split_at_mut(changes);
        add_mass(points, mass);
        let is_closed = |&k: &u32| closed[k as usize] > WHOLE;
        if face.functions.iter().all(is_closed) {
            for point in 0..points.table.points() {
                let internal = points.at_corners(face, point, pressures.internal);
                let excess = internal - points.pressure(face, point, &coefficients);
                add_change(points, (point, excess), rows);
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

/// Adds psi_j excess da of a point `[functions, nodes, 3]`.
fn add_change(points: &FacePoints<'_>, (point, excess): (usize, f64), rows: &mut [f64]) {
    let Some(area) = points.areas.get(point) else {
        return;
    };
    let load = points.table.rule.weights[point] * excess;
    let (values, shapes) = (points.table.values(point), points.table.shapes(point));
    for (value, row) in values.iter().zip(rows.chunks_exact_mut(3 * shapes.len())) {
        for (node, entries) in row.chunks_exact_mut(3).enumerate() {
            let change = area.gradient(node, shapes[node]);
            let entries = entries.iter_mut().zip(change);
            entries.for_each(|(entry, part)| *entry += load * value * part);
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
