//! How slips and tractions change with the deformed area that they are integrated over:
//!
//! ```text
//! ds_i = T_i int phi_i (x - Q x0) d(da),   df = sum_i int phi_i N_k t_i d(da)
//! ```
//!
//! for bodies of finite strain. The tractions have no potential, so that the second is not
//! symmetric. Cost: four linearisations of a frictional surface.

use super::{Friction, SlipStart, turn};
use crate::contact::shares::add_equal_columns;
use crate::contact::{area_rows, traction_change};
use crate::geometry::rigid_motion::multiply;
use crate::geometry::vector3::{add, scale, sub};
use crate::linalg::{SparseRows, SparseRowsBuilder};
use crate::model::Model;
use crate::model::state::State;
use crate::obstacle::Moving;

/// Entries by unknown.
type Row = Vec<(u32, f64)>;

/// What the change of the area makes of the rows of slips `[multipliers, displacement]` and of
/// the tractions `[displacement, displacement]`.
pub(super) fn change_of_area(
    friction: &Friction,
    (model, state): (&Model<'_>, &State),
    held: &[bool],
) -> [SparseRows; 2] {
    let frames = friction.frames(model, state);
    let width = friction.components.count();
    let body = model.deformed(&state.displacement);
    let mut rows: Vec<Row> = vec![Vec::new(); state.multiplier.len()];
    let mut surfaces = Vec::new();
    let mut point = 0;
    for (index, interface) in model.frictional() {
        let own = point..point + interface.multipliers.len();
        point = own.end;
        if let Some(start) = &model.conditions.slip_start {
            let field = slip_field((model, state), start, index);
            let along = [0, 1, 2].map(|axis| {
                if axis < model.prepared.space.components {
                    area_rows(&body, &interface.surface, (&field, axis), held)
                } else {
                    vec![Row::new(); own.len()]
                }
            });
            for (local, number) in own.clone().enumerate() {
                for (a, tangent) in frames[number].iter().enumerate().take(width) {
                    let parts = along.iter().zip(tangent).flat_map(|(rows, factor)| {
                        rows[local]
                            .iter()
                            .map(move |&(k, value)| (k, factor * value))
                    });
                    let row = &mut rows[friction.first + number * width + a];
                    row.extend(parts);
                    add_equal_columns(row);
                }
            }
        }
        let traction = |number: usize| {
            let ([a, b], _) = friction.traction(state, number);
            let [first, second] = frames[number];
            add(scale(a, first), scale(b, second))
        };
        surfaces.push((&interface.surface, own.map(traction).collect()));
    }
    let geometric = traction_change(&body, &surfaces, held);
    [stored(rows, state.displacement.len()), geometric]
}

/// x - Q x0 as coefficients of the hierarchical functions `[displacement unknowns]`, Q the
/// motion of that obstacle since `start`.
fn slip_field(
    (model, state): (&Model<'_>, &State),
    start: &SlipStart,
    obstacle: usize,
) -> Vec<f64> {
    let length = model.plan.problem.units.length;
    let [from, to]: [Vec<Moving>; 2] =
        [&start.drive, &state.drive].map(|drive| model.interfaces.obstacles(drive, length));
    let [before, after] = [from[obstacle].motion(), to[obstacle].motion()];
    let turn = turn(&before.matrix(), &after.matrix());
    let centre = add(before.about, before.translation);
    let shift = sub(after.translation, before.translation);
    let space = &model.prepared.space;
    let c = space.components;
    let mut field = vec![0.0; state.displacement.len()];
    for (node, slip) in field.chunks_exact_mut(c).enumerate() {
        let vector = |all: &[f64]| {
            let own = &all[node * c..(node + 1) * c];
            std::array::from_fn(|i| own.get(i).copied().unwrap_or(0.0))
        };
        let (now, then): ([f64; 3], [f64; 3]) =
            (vector(&state.displacement), vector(&start.displacement));
        // Vertices carry the constant part of a field, edges corrections only.
        let place = model.place(node, &start.displacement);
        let (arm, shift) = if node < space.vertices {
            (sub(place, centre), shift)
        } else {
            (place, [0.0; 3])
        };
        let carried = add(sub(multiply(&turn, arm), arm), shift);
        let moved = sub(sub(now, then), carried);
        slip.copy_from_slice(&moved[..c]);
    }
    field
}

/// The rows with that many columns.
fn stored(rows: Vec<Row>, columns: usize) -> SparseRows {
    let mut builder = SparseRowsBuilder::new(columns);
    for mut row in rows {
        builder.push_row(&mut row);
    }
    builder.finish()
}
