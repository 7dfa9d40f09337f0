//! Contacts at the border of what they do, where derivatives are one-sided.

use crate::linalg::vector::norm;
use crate::model::Model;
use crate::model::evaluate::Evaluation;
use crate::model::friction::Law;
use crate::model::state::State;
use crate::saddle::{AdmissibleSet, Status};

/// Pressure over the largest one, and gap over the widest one, of a contact at its border; the same of tractions and
/// slips. Without unit; chosen: far above rounding, far below what a change of contact makes.
const BORDER: f64 = 1e-6;

/// Contacts of obstacles that are closed without pressure, or open without a gap, and points that
/// stick at the edge of friction, or slip by nothing.
pub(super) fn borderline(model: &Model<'_>, state: &State, now: &Evaluation) -> u32 {
    let largest = state
        .multiplier
        .iter()
        .fold(0.0, |most: f64, l| most.max(l.abs()));
    let widest = norm(&now.gap);
    let depths = depths(model, now);
    let deepest = depths
        .iter()
        .fold(0.0, |most: f64, gap| most.max(gap.abs()));
    let contacts = contacts(now)
        .zip(&state.status)
        .zip(state.multiplier.iter().zip(&depths));
    let at_border = contacts.filter(|((is_contact, status), (pressure, gap))| {
        *is_contact
            && match status {
                Status::Open => gap.abs() <= BORDER * deepest,
                Status::Stick | Status::Slip => pressure.abs() <= BORDER * largest,
            }
    });
    let law = now.friction.as_ref();
    let slips = law.map_or(0, |law| about_to_turn(law, (state, now), widest));
    (at_border.count() + slips) as u32
}

/// Gaps over the areas that they are of: those of small faces are no smaller.
fn depths(model: &Model<'_>, now: &Evaluation) -> Vec<f64> {
    let mut weights = vec![0.0; now.gap.len()];
    for interface in &model.interfaces.list {
        interface.add_own(&interface.surface.weights, &mut weights);
    }
    let all = now.gap.iter().zip(weights);
    let depth = |(gap, weight): (&f64, f64)| if weight > 0.0 { gap / weight } else { *gap };
    all.map(depth).collect()
}

/// Whether each multiplier is a pressure of contact, from the first.
fn contacts(now: &Evaluation) -> Box<dyn Iterator<Item = bool> + '_> {
    match &now.friction {
        Some(law) => Box::new((0..now.gap.len()).map(|place| place < law.normals)),
        None => Box::new(now.sets.iter().flat_map(|part| {
            let is_contact = part.set == AdmissibleSet::NonNegative;
            std::iter::repeat_n(is_contact, part.size)
        })),
    }
}

/// Points under pressure between sticking and slipping.
fn about_to_turn(law: &Law, (state, now): (&State, &Evaluation), widest: f64) -> usize {
    let width = law.components.count();
    let radii = law.radii(&state.multiplier);
    let points = radii.iter().enumerate().filter(|(number, radius)| {
        let first = law.normals + number * width;
        let own = first..first + width;
        let is_held = now.coupling.row(first).0.is_empty();
        **radius > 0.0
            && !is_held
            && match state.status[first] {
                Status::Open => false,
                Status::Stick => norm(&state.multiplier[own]) >= (1.0 - BORDER) * **radius,
                Status::Slip => norm(&now.gap[own]) <= BORDER * widest,
            }
    });
    points.count()
}
