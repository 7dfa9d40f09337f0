//! Points of friction between bodies: slips along the other body's surface ([`crate::pairs::sliding`]).
//!
//! Their points stand after those of obstacles, contact by contact. What no slip explains of a way is
//! one or two numbers along the surface, so that it turns with the bodies. Cost: see [`crate::pairs::slip`].

use std::ops::Range;

use super::{Frame, Friction, Slips};
use crate::contact::ContactSurface;
use crate::contact::shares::add_equal_columns;
use crate::linalg::{SparseRows, SparseRowsBuilder};
use crate::model::Model;
use crate::model::state::State;
use crate::pairs::{PairSurface, Sliding};

/// Entries by unknown.
type Row = Vec<(u32, f64)>;

/// The points of one frictional contact between bodies.
#[derive(Clone, Debug)]
pub(crate) struct PairPoints {
    /// Its place among all interfaces.
    pub(crate) interface: usize,
    /// Its points.
    pub(crate) points: Range<usize>,
}

/// A frictional contact between bodies at a state.
pub(crate) struct Between<'a> {
    /// Its points.
    pub(crate) points: Range<usize>,
    /// Name of the contact.
    pub(crate) name: &'a str,
    /// The surface that carries.
    pub(crate) surface: &'a ContactSurface,
    /// What it meets.
    pub(crate) pair: &'a PairSurface,
    /// Slips since the increment began.
    pub(crate) sliding: Sliding,
}

impl Friction {
    /// The frictional contacts between bodies with their slips since the increment began.
    pub(crate) fn between<'a>(&self, model: &Model<'a>, state: &State) -> Vec<Between<'a>> {
        let pairs = self.pairs.iter();
        pairs
            .filter_map(|own| self.of_pair(own, (model, state)))
            .collect()
    }

    fn of_pair<'a>(
        &self,
        own: &PairPoints,
        (model, state): (&Model<'a>, &State),
    ) -> Option<Between<'a>> {
        let body = model.deformed(&state.displacement);
        let start = model.conditions.slip_start.as_ref();
        let from = start.map_or(&state.displacement[..], |start| start.displacement());
        let width = self.components.count();
        let interface = &model.interfaces.list[own.interface];
        let pair = interface.pair()?;
        let mut sliding = pair.sliding(&body, from, &interface.surface);
        for (place, slip) in sliding.slips.iter_mut().enumerate() {
            let (point, along) = (own.points.start + place / width, place % width);
            let residue = start.map(|start| start.residue()[point][along]);
            *slip = residue.map_or(0.0, |residue| *slip + residue);
        }
        Some(Between {
            points: own.points.clone(),
            name: &interface.name,
            surface: &interface.surface,
            pair,
            sliding,
        })
    }

    /// Where the tractions of points are among all multipliers.
    pub(crate) fn tractions_of(&self, points: &Range<usize>) -> Range<usize> {
        let width = self.components.count();
        self.first + points.start * width..self.first + points.end * width
    }

    /// Tangents of the carriers at the points of all frictional contacts between bodies.
    pub(super) fn frames_between(&self, model: &Model<'_>, state: &State) -> Vec<Frame> {
        let body = model.deformed(&state.displacement);
        let of_pair = |own: &PairPoints| {
            let interface = &model.interfaces.list[own.interface];
            let known = interface.pair()?.frames(&body, &interface.surface);
            known.or_else(|| Some(self.of_pair(own, (model, state))?.sliding.frames))
        };
        self.pairs.iter().filter_map(of_pair).flatten().collect()
    }

    /// Adds slips and their rows, columns of `held` unknowns left out.
    pub(super) fn add_between(
        &self,
        (model, state): (&Model<'_>, &State),
        held: &[bool],
        slips: &mut Slips,
    ) {
        for own in self.between(model, state) {
            let rows = own.sliding.rows.iter().map(|row| negative(row, held));
            let first = slips.rows.len();
            slips.rows.extend(rows);
            let moved = own.sliding.slips.iter().zip(&slips.rows[first..]);
            // What nothing can move does not slip.
            let moved = moved.map(|(&slip, row)| if row.is_empty() { 0.0 } else { slip });
            slips.slip.extend(moved);
        }
    }

    /// What the change of the surfaces adds to the rows of slips `[multipliers, displacement]`, and
    /// what tractions take off the stiffness, without rows and columns of `held` unknowns; none
    /// without such contacts of bodies of finite strain.
    pub(super) fn change_between(
        &self,
        (model, state): (&Model<'_>, &State),
        held: &[bool],
    ) -> Option<[SparseRows; 2]> {
        if !model.is_rubber() || self.pairs.is_empty() {
            return None;
        }
        let body = model.deformed(&state.displacement);
        let start = model.conditions.slip_start.as_ref();
        let from = start.map_or(&state.displacement[..], |start| start.displacement());
        let mut rows: Vec<Row> = vec![Vec::new(); state.multiplier.len()];
        let mut geometric: Option<SparseRows> = None;
        for own in self.between(model, state) {
            let surface = own.surface;
            let places = self.tractions_of(&own.points);
            let changes = own.pair.sliding_change((&body, surface), from, held);
            let pairs = changes.into_iter().flatten().zip(&own.sliding.rows);
            for (place, (change, row)) in places.clone().zip(pairs) {
                rows[place] = negative(&change, held);
                rows[place].extend(negative(row, held).iter().map(|&(k, value)| (k, -value)));
                add_equal_columns(&mut rows[place]);
            }
            let tractions = &state.multiplier[places];
            let change = own.pair.traction_change(&body, (surface, tractions), held);
            geometric = match (geometric, change) {
                (Some(all), Some(own)) => Some(all.plus(&own)),
                (all, own) => all.or(own),
            };
        }
        let mut builder = SparseRowsBuilder::new(state.displacement.len());
        rows.iter_mut().for_each(|row| builder.push_row(row));
        Some([builder.finish(), geometric?])
    }
}

/// Minus a row without `held` columns.
fn negative(row: &Row, held: &[bool]) -> Row {
    let free = row.iter().filter(|&&(k, _)| !held[k as usize]);
    free.map(|&(k, value)| (k, -value)).collect()
}
