//! What ties carry: force and moment between the two bodies, and the largest traction, in the
//! caller's units.
//!
//! ```text
//! F = -sum_j l_j int psi_j dS,   t = -sum_j l_j psi_j   (on the body that carries)
//! ```
//!
//! Cost: one pass over the rows and the faces.

use std::collections::BTreeMap;

use crate::contact::ContactFace;
use crate::geometry::vector3::{add, norm, scale};
use crate::model::Model;
use crate::model::interfaces::Interface;
use crate::model::state::State;
use crate::plan::ties::PlannedTie;
use crate::report::TieResult;

/// Results of all ties.
pub(crate) fn results(model: &Model<'_>, state: &State) -> BTreeMap<String, TieResult> {
    let ties = model.plan.problem.ties.iter();
    let list = model.interfaces.list.iter();
    let mut interfaces = list.filter(|one| one.tie().is_some());
    let results = ties.map(|tie| {
        let own: Vec<&Interface> = interfaces.by_ref().take(tie.layouts.len()).collect();
        (tie.pair.name.clone(), one(model, state, (tie, &own)))
    });
    results.collect()
}

/// The result of a tie with these interfaces, one a component.
fn one(model: &Model<'_>, state: &State, (tie, own): (&PlannedTie, &[&Interface])) -> TieResult {
    let units = &model.plan.problem.units;
    let body = model.deformed(&state.displacement);
    let mut sums = [[0.0; 3]; 2];
    for interface in own {
        let Some(tied) = interface.tie() else {
            continue;
        };
        let found = tied.forces(&body, &interface.own(&state.multiplier));
        let found = if tie.pair.first_carries() {
            found.on_carrier
        } else {
            found.on_other
        };
        sums = [add(sums[0], found[0]), add(sums[1], found[1])];
    }
    let [force, mut moment] = sums;
    if model.plan.is_axisymmetric() {
        moment = [0.0; 3];
    }
    let (peak, place) = peak(model, state, (tie, own));
    let gap = tie.seam.gap.map_or(0.0, |gap| gap.width);
    TieResult {
        force: scale(units.force(), force),
        moment: scale(units.energy(), moment),
        area: tie.seam.covered.iter().sum::<f64>() * units.area(),
        gap: gap * units.coordinate_scale * units.length,
        peak_traction: peak * units.stress,
        peak_traction_place: scale(units.length, place),
    }
}

/// The largest traction at a node of a tied facet, and where that is.
fn peak(
    model: &Model<'_>,
    state: &State,
    (tie, own): (&PlannedTie, &[&Interface]),
) -> (f64, [f64; 3]) {
    let coefficients = own.iter().map(|one| one.coefficients(&state.multiplier));
    let coefficients: Vec<Vec<f64>> = coefficients.collect();
    let mut largest = (0.0, [0.0; 3]);
    let faces = own.first().map_or(&[][..], |one| &one.surface.faces);
    let is_tied = |face: &&ContactFace| {
        let mut functions = face.functions.iter();
        functions.all(|&k| tie.seam.covered[k as usize] > 0.0)
    };
    for face in faces.iter().filter(is_tied) {
        for place in places(face.corners.len()) {
            let mut traction = [0.0; 3];
            for (value, own) in traction.iter_mut().zip(&coefficients) {
                let functions = face.functions.iter().zip(bernstein(&place));
                *value = functions.map(|(&k, psi)| psi * own[k as usize]).sum();
            }
            let size = norm(traction);
            if size > largest.0 {
                let nodes = face.nodes.iter().zip(hierarchical(&place));
                let at = nodes.fold([0.0; 3], |sum, (&node, value)| {
                    let node = model.place(node as usize, &state.displacement);
                    add(sum, scale(value, node))
                });
                largest = (size, at);
            }
        }
    }
    largest
}

/// Barycentric coordinates of the corners and the middles of the edges of a face.
fn places(corners: usize) -> Vec<Vec<f64>> {
    let at = |i: usize, j: usize| {
        let mut place = vec![0.0; corners];
        place[i] += 0.5;
        place[j] += 0.5;
        place
    };
    let pairs = (0..corners).flat_map(|i| (i..corners).map(move |j| (i, j)));
    pairs.map(|(i, j)| at(i, j)).collect()
}

/// L^2 of the corners, 2 L_a L_b of the edges (0,1), (0,2), (1,2).
fn bernstein(place: &[f64]) -> Vec<f64> {
    let squares = place.iter().map(|l| l * l);
    squares.chain(products(place, 2.0)).collect()
}

/// L of the corners, 4 L_a L_b of the edges.
fn hierarchical(place: &[f64]) -> Vec<f64> {
    let corners = place.iter().copied();
    corners.chain(products(place, 4.0)).collect()
}

fn products(place: &[f64], factor: f64) -> impl Iterator<Item = f64> + '_ {
    let pairs = (0..place.len()).flat_map(move |i| (i + 1..place.len()).map(move |j| (i, j)));
    pairs.map(move |(i, j)| factor * place[i] * place[j])
}
