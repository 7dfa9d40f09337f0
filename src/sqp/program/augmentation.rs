//! What rubber under contact pressure needs beside its tangent: the terms of
//! [`crate::inequality::augmentation`] about the present state. None for linear bodies,
//! whose stiffness knows no pressure.

use crate::contact::area_change::{AreaChange, Pressures, area_change};
use crate::contact::shares::add_equal_columns;
use crate::inequality::Augmentation;
use crate::linalg::ordering::{Graph, nested_dissection};
use crate::linalg::{SparseRows, SparseRowsBuilder};
use crate::model::Model;
use crate::model::interfaces::Interface;
use crate::model::state::State;

/// Mean contact pressure, in shear moduli, from which on the part of the internal pressure is
/// cancelled as well: mr-sphere, which stays below, takes 45 applications an increment with that
/// part in the operator and 56 without, a block at 8 moduli 131 and 75.
const HIGH: f64 = 1.0;

/// The terms about `state`.
pub(super) fn augmentation(model: &Model<'_>, state: &State) -> Option<Augmentation> {
    // The terms know no tractions.
    let is_rough = model.interfaces.friction.is_some();
    let is_pressed = state.multiplier.iter().any(|&l| l != 0.0);
    if !model.is_rubber() || is_rough || !is_pressed {
        return None;
    }
    let internal: &[f64] = match mean_pressure(model, state) < HIGH {
        true => &[],
        false => &state.pressure,
    };
    let closed = state.status.iter().map(|status| status.is_closed());
    let closed: Vec<f64> = closed
        .map(|is_closed| f64::from(u8::from(is_closed)))
        .collect();
    let size = state.multiplier.len();
    let mut all = AreaChange {
        rows: vec![Vec::new(); size],
        mass: vec![Vec::new(); size],
    };
    let body = model.deformed(&state.displacement);
    for interface in &model.interfaces.list {
        let pressures = Pressures {
            contact: &interface.own(&state.multiplier),
            internal,
            closed: &interface.own(&closed),
        };
        let part = area_change(
            &body,
            &interface.surface,
            pressures,
            &model.prepared.is_held,
        );
        add(interface, part, &mut all);
    }
    let mass = finish(all.mass, size);
    Some(Augmentation {
        order: order(model, &mass),
        rows: finish(all.rows, state.displacement.len()),
        mass,
    })
}

/// Mean pressure on the closed part of all surfaces, in shear moduli.
fn mean_pressure(model: &Model<'_>, state: &State) -> f64 {
    let (mut force, mut area) = (0.0, 0.0);
    for interface in &model.interfaces.list {
        let weights = interface.surface.weights.iter();
        for (place, weight) in interface.places().zip(weights) {
            if state.status[place].is_closed() {
                force += weight * state.multiplier[place].abs();
                area += weight;
            }
        }
    }
    match area > 0.0 {
        true => force / area,
        false => 0.0,
    }
}

/// Adds the part of one interface to the rows of all multipliers.
fn add(interface: &Interface, part: AreaChange, all: &mut AreaChange) {
    let places = interface.places().zip(part.rows.into_iter().zip(part.mass));
    for (place, (rows, mass)) in places {
        all.rows[place].extend(rows);
        let among_all = |(own, value): (u32, f64)| (interface.multipliers[own as usize], value);
        all.mass[place].extend(mass.into_iter().map(among_all));
    }
}

/// Rows with equal columns added up.
fn finish(rows: Vec<Vec<(u32, f64)>>, columns: usize) -> SparseRows {
    let mut builder = SparseRowsBuilder::new(columns);
    for mut row in rows {
        add_equal_columns(&mut row);
        builder.push_row(&mut row);
    }
    builder.finish()
}

/// Elimination order of the mass by nested dissection of the multipliers' places.
fn order(model: &Model<'_>, mass: &SparseRows) -> Vec<u32> {
    let size = mass.diagonal().len();
    let mut edges = Vec::new();
    for row in 0..size as u32 {
        let (columns, _) = mass.row(row as usize);
        let above = columns.iter().filter(|&&column| column > row);
        edges.extend(above.map(|&column| [row, column]));
    }
    let graph = Graph::from_edges(size, &edges);
    nested_dissection(&places(model, size), &graph, &[])
}

/// The undeformed place of each multiplier, in the mesh's lengths.
fn places(model: &Model<'_>, size: usize) -> Vec<[f64; 3]> {
    let (space, coordinates) = (&model.prepared.space, model.mesh.coordinates());
    let mut places = vec![[0.0; 3]; size];
    for interface in &model.interfaces.list {
        for (function, &node) in (0..).zip(&interface.surface.carriers) {
            let place = space.node_place(coordinates, node);
            let own = interface.surface.shares.of(function);
            for (multiplier, _) in own.filter(|&(_, share)| share > 0.99) {
                places[interface.multipliers[multiplier as usize] as usize] = place;
            }
        }
    }
    places
}
