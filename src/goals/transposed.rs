//! The transposed matrix of the dual problem times a displacement, rows and columns of what is held
//! included:
//!
//! ```text
//! M^T w = [ (A - G)^T w ]
//!         [ B w         ]
//!         [ C w         ]
//! ```
//!
//! Non-dimensional. Cost: one product with the tangent, one pass over the surfaces.

use crate::assembly::grid::{Basis, Rows, StiffnessForm, VolumeTerm};
use crate::assembly::strain::Mixed;
use crate::contact::curvature;
use crate::linalg::vector::add_scaled;
use crate::linalg::{LinearOperator, SparseRows, Workspace};
use crate::model::Model;
use crate::model::fluids::wetted_tangent;
use crate::model::joined::Joined;
use crate::model::pressures::pressed_tangent;
use crate::model::state::State;
use crate::model::tangent::Tangent;
use crate::sqp::fields::Fields;

/// Zeros of all unknowns.
pub(super) fn zeros(state: &State) -> Fields {
    Fields {
        displacement: vec![0.0; state.displacement.len()],
        pressure: vec![0.0; state.pressure.len()],
        multiplier: vec![0.0; state.multiplier.len()],
    }
}

/// M^T w of a displacement w, rows and columns of what is held included.
pub(super) fn transposed(
    model: &Model<'_>,
    state: &State,
    motion: &[f64],
    work: &mut Workspace,
) -> Fields {
    let mut out = zeros(state);
    add_body(model, state, (motion, &mut out), work);
    add_follower(model, state, (motion, &mut out), work);
    add_contact(model, state, (motion, &mut out), work);
    out
}

/// Adds A w and B w.
fn add_body(
    model: &Model<'_>,
    state: &State,
    (motion, out): (&[f64], &mut Fields),
    work: &mut Workspace,
) {
    match Tangent::new(model, state, &mut Default::default(), work) {
        Some(tangent) => {
            let still = vec![0.0; out.pressure.len()];
            let into = Mixed {
                displacement: &mut out.displacement,
                pressure: &mut out.pressure,
            };
            let about = tangent.cells.about(&tangent.at);
            about.apply(Rows::All, (motion, &still), into, work);
        }
        None => {
            let grid = &model.prepared.grid;
            let form = StiffnessForm {
                basis: Basis::Hierarchical,
                rows: Rows::All,
                volume: VolumeTerm::Own,
            };
            grid.stiffness(form, motion, &mut out.displacement, work);
            if !out.pressure.is_empty() {
                grid.divergence(Rows::All, motion, &mut out.pressure, work);
            }
        }
    }
}

/// Takes off what pressures and fluids that follow the body make of the stiffness.
fn add_follower(
    model: &Model<'_>,
    state: &State,
    (motion, out): (&[f64], &mut Fields),
    work: &mut Workspace,
) {
    let free = vec![false; motion.len()];
    let tangents = [
        pressed_tangent(model, state, &free),
        wetted_tangent(model, state, &free),
    ];
    for tangent in tangents.into_iter().flatten() {
        let mut product = vec![0.0; motion.len()];
        tangent.apply_transposed(motion, &mut product, work);
        add_scaled(&mut out.displacement, -1.0, &product);
    }
}

/// Adds C w, and takes the curvature of the gaps and what turns tractions off.
fn add_contact(
    model: &Model<'_>,
    state: &State,
    (motion, out): (&[f64], &mut Fields),
    work: &mut Workspace,
) {
    let free = vec![false; motion.len()];
    let body = model.deformed(&state.displacement);
    let placed: Vec<_> = model.placed(&state.drive).collect();
    let mut joined = Joined::new(out.multiplier.len());
    for (interface, met) in &placed {
        let mut part = met.linearise(&body, &interface.surface, &free);
        for &multiplier in &interface.idle {
            part.rows[multiplier as usize].clear();
        }
        joined.add(interface, part);
    }
    let friction = model.interfaces.friction.as_ref();
    if let Some(friction) = friction {
        joined.add_friction(friction, friction.linearised(model, state, &free));
    }
    let (_, coupling) = joined.finish(motion.len());
    coupling.apply(motion, &mut out.multiplier, work);
    let mut product = vec![0.0; motion.len()];
    let turning = friction.and_then(|friction| friction.turning_of((model, state), &free));
    if let Some(turning) = turning {
        let turned = turning.geometric;
        turned.apply_transposed(motion, &mut product, work);
        add_scaled(&mut out.displacement, -1.0, &product);
    }
    if model.is_linear() {
        return;
    }
    let by_points = placed.iter().filter(|(one, _)| one.is_by_points());
    let own: Vec<_> = by_points
        .map(|(one, met)| (one, met, one.own(&state.multiplier)))
        .collect();
    let surfaces = own.iter();
    let surfaces = surfaces.map(|(one, met, own)| (&one.surface, *met, &own[..]));
    let bent = curvature(&body, &surfaces.collect::<Vec<_>>(), &free);
    for bent in [Some(bent), curvature_between(model, state)]
        .into_iter()
        .flatten()
    {
        bent.apply_transposed(motion, &mut product, work);
        add_scaled(&mut out.displacement, -1.0, &product);
    }
}

/// Curvature of the gaps between bodies, held unknowns included; none where no two bodies meet.
fn curvature_between(model: &Model<'_>, state: &State) -> Option<SparseRows> {
    let body = model.deformed(&state.displacement);
    let free = vec![false; state.displacement.len()];
    let pairs = model.interfaces.list.iter().filter_map(|interface| {
        let pressures = interface.own(&state.multiplier);
        let own = (&interface.surface, &pressures[..]);
        Some(interface.pair()?.curvature(&body, own, &free))
    });
    pairs.reduce(|sum, one| sum.plus(&one))
}
