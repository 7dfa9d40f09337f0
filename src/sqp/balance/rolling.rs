//! Where a tool that grips the body and is turned or led begins: free components follow so that it
//! slips least,
//!
//! ```text
//! min |s + D_t z|^2   over the points that are closed,   s the slips that its given motion makes
//! ```
//!
//! A tool that begins by sliding is pulled at by friction alone, whose force no small motion
//! changes: a cylinder that rolls freely under friction 0.05 found no equilibrium. Components that
//! act along the normals more than across them stay. Cost: two evaluations of the gaps.

use super::rigid::gap_changes;
use crate::linalg::vector::{add_scaled, dot};
use crate::model::drive::Drive;
use crate::model::evaluate::evaluate_contact;
use crate::model::push::Control;
use crate::model::state::State;
use crate::sqp::push_stiffness::PushStiffness;
use crate::sqp::run::Run;

/// The motion `[controls]` of obstacles on the way to `drive`, whose sought components have not
/// moved there; none where nothing slips.
pub(super) fn least_slip(run: &Run<'_>, drive: &Drive, controls: &[Control]) -> Option<Vec<f64>> {
    let friction = run.model.interfaces.friction.as_ref()?;
    let moved = State {
        drive: drive.clone(),
        ..run.state.clone()
    };
    let [before, after] =
        [&*run.state, &moved].map(|state| evaluate_contact(&run.model, state).gap);
    let tractions = friction.first..friction.first + friction.size();
    let is_closed = |k: &usize| run.state.status[*k].is_closed();
    let [normal, across]: [Vec<usize>; 2] =
        [0..friction.first, tractions].map(|places| places.filter(is_closed).collect());
    let at =
        |all: &[f64], places: &[usize]| -> Vec<f64> { places.iter().map(|&k| all[k]).collect() };
    let mut slips = at(&after, &across);
    add_scaled(&mut slips, -1.0, &at(&before, &across));
    if slips.iter().all(|&slip| slip == 0.0) {
        return None;
    }
    let columns = gap_changes(&run.model, run.state, controls).into_iter();
    let columns: Vec<Vec<f64>> = columns
        .map(|column| {
            let [along, across] = [&normal, &across].map(|places| at(&column, places));
            match dot(&across, &across) > dot(&along, &along) {
                true => across,
                false => vec![0.0; slips.len()],
            }
        })
        .collect();
    let products = |other: &[f64]| columns.iter().map(|column| dot(column, other)).collect();
    let normal_equations = PushStiffness {
        controls: controls.to_vec(),
        columns: columns.iter().map(|column| products(column)).collect(),
    };
    Some(normal_equations.solve(&products(&slips)).0)
}
