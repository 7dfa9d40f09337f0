//! What rubber under contact pressure needs beside its tangent: the terms of
//! [`crate::inequality::augmentation`] about the present state. None for linear bodies,
//! whose stiffness knows no pressure, and below [`HIGH`] with friction. Where bodies meet each other
//! there are none: what is wrong with one body's trace there is right with the other's.
//!
//! Tractions have rows like those of pressures, R_j(v) = - int psi_j t da(v) for each component
//! t, without the internal pressure, which acts along the normal. Cost: a pass over the closed
//! faces, with friction one more for each component.

use crate::contact::area_change::{AreaChange, Pressures, area_change};
use crate::contact::shares::add_equal_columns;
use crate::inequality::Augmentation;
use crate::linalg::ordering::{Graph, nested_dissection};
use crate::linalg::{SparseRows, SparseRowsBuilder};
use crate::model::Model;
use crate::model::interfaces::Interface;
use crate::model::state::State;

constants! {
    /// Mean contact pressure, in shear moduli, from which on the part of the internal pressure is
    /// cancelled as well: mr-sphere, which stays below, takes 45 applications an increment with that
    /// part in the operator and 56 without, a block at 8 moduli 131 and 75. With friction the terms
    /// as a whole count from there on: a gripper, which stays below, takes 477 applications with them
    /// everywhere and 445 so; above, an O-ring takes 4538 with them and 4866 without, a belt 4742 and
    /// 7497, two blocks of contrast 1e4 931 and 10411, of contrast 100 942 and 644.
    const HIGH: f64 = 1.0;
}

/// The terms about `state`.
pub(super) fn augmentation(model: &Model<'_>, state: &State) -> Option<Augmentation> {
    let mut list = model.interfaces.list.iter();
    let has_terms = list.any(Interface::is_by_points);
    let is_pressed = state.multiplier.iter().any(|&l| l != 0.0);
    if !model.is_rubber() || !is_pressed || !has_terms {
        return None;
    }
    let is_high = mean_pressure(model, state) >= HIGH;
    if model.interfaces.friction.is_some() && !is_high {
        return None;
    }
    let size = state.multiplier.len();
    let mut all = AreaChange {
        rows: vec![Vec::new(); size],
        mass: vec![Vec::new(); size],
    };
    let closed = closed(state);
    let internal: &[f64] = if is_high { &state.pressure } else { &[] };
    let tractions = traction_surfaces(model);
    let mut is_traction = vec![false; size];
    let places = tractions.iter().flat_map(|(_, places)| places);
    places.for_each(|&place| is_traction[place] = true);
    let list = model.interfaces.list.iter();
    let list = list.filter(|interface| interface.is_by_points());
    let normals = list.map(|interface| (interface, interface.places().collect(), internal));
    let none: &[f64] = &[];
    let along = tractions
        .into_iter()
        .map(|(one, places)| (one, places, none));
    for (interface, places, internal) in normals.chain(along) {
        let own = |all: &[f64]| -> Vec<f64> { places.iter().map(|&place| all[place]).collect() };
        let pressures = Pressures {
            contact: &own(&state.multiplier),
            internal,
            closed: &own(&closed),
        };
        let body = model.deformed(&state.displacement);
        let held = &model.prepared.is_held;
        add(
            &mut all,
            &places,
            area_change(&body, &interface.surface, pressures, held),
        );
    }
    own_mass_of_pairs(model, &mut all.mass);
    let mass = finish(all.mass, size);
    Some(Augmentation {
        order: order(model, &mass),
        rows: model
            .prepared
            .held
            .project_columns(finish(all.rows, state.displacement.len())),
        is_traction,
        mass,
    })
}

/// Where bodies meet there are no terms, and the mass is one that has a factor.
fn own_mass_of_pairs(model: &Model<'_>, mass: &mut [Vec<(u32, f64)>]) {
    let list = model.interfaces.list.iter();
    for interface in list.filter(|interface| !interface.is_by_points()) {
        for (place, &weight) in interface.places().zip(&interface.surface.weights) {
            mass[place].push((place as u32, weight));
        }
    }
}

/// One where a multiplier is closed, else zero.
fn closed(state: &State) -> Vec<f64> {
    let closed = state.status.iter().map(|status| status.is_closed());
    closed
        .map(|is_closed| f64::from(u8::from(is_closed)))
        .collect()
}

/// Frictional surfaces with the places of their tractions among all multipliers, once for each
/// component.
fn traction_surfaces<'a>(model: &Model<'a>) -> Vec<(&'a Interface, Vec<usize>)> {
    let mut surfaces = Vec::new();
    let Some(friction) = &model.interfaces.friction else {
        return surfaces;
    };
    let width = friction.components.count();
    let mut point = 0;
    for (_, interface) in model.frictional() {
        let own = point..point + interface.multipliers.len();
        point = own.end;
        for component in 0..width {
            let place = |number: usize| friction.first + number * width + component;
            surfaces.push((interface, own.clone().map(place).collect()));
        }
    }
    surfaces
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
    if area > 0.0 { force / area } else { 0.0 }
}

/// Adds the part of one surface to the rows of its multipliers at `places`.
fn add(all: &mut AreaChange, places: &[usize], part: AreaChange) {
    for (&place, (rows, mass)) in places.iter().zip(part.rows.into_iter().zip(part.mass)) {
        all.rows[place].extend(rows);
        let among_all = |(own, value): (u32, f64)| (places[own as usize] as u32, value);
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
    let space = &model.prepared.space;
    let mut places = vec![[0.0; 3]; size];
    for interface in &model.interfaces.list {
        for (function, &node) in (0..).zip(&interface.surface.carriers) {
            let place = space.node_place(model.mesh, node);
            let own = interface.surface.shares.of(function);
            for (multiplier, _) in own.filter(|&(_, share)| share > 0.99) {
                places[interface.multipliers[multiplier as usize] as usize] = place;
            }
        }
    }
    if let Some(friction) = &model.interfaces.friction {
        let width = friction.components.count();
        for (number, &partner) in friction.partners.iter().enumerate() {
            let first = friction.first + number * width;
            let own = places[partner as usize];
            places[first..first + width].fill(own);
        }
    }
    places
}
