//! The stiffness under pushed obstacles as the metric of contact says.
//!
//! ```text
//! J ~ D_A^T H_AA^-1 D_A
//! ```
//!
//! H an approximation of the compliance C A^-1 C^T, A what is closed at the present state:
//! pressures,
//! and tractions, as if they stuck: points that slip apart under a press stick, most of them,
//! once the tool is pushed aside, and too stiff is learnt better than nothing at all. Cost: a factor of H_AA.

use super::gap_changes::gap_changes;
use crate::linalg::vector::{dot, scale};
use crate::linalg::{SymmetricMatrix, Workspace};
use crate::model::push::Control;
use crate::sqp::contact_metric::evenly;
use crate::sqp::program::QuadraticProgram;
use crate::sqp::push_stiffness::PushStiffness;
use crate::sqp::run::Run;

constants! {
    /// Force over way of a punch, over the body's length and shear modulus.
    const PUNCH: f64 = 1.0;
}

/// As the metric says at the present state.
pub(super) fn by_metric(run: &mut Run<'_>, controls: &[Control]) -> PushStiffness {
    let now = run.evaluate();
    let program = QuadraticProgram::new(run, &now, None, &mut 0.0);
    let statuses = run.state.status.iter().enumerate();
    let closed = statuses.filter(|(_, status)| status.is_closed());
    let closed: Vec<usize> = closed.map(|(place, _)| place).collect();
    let changes = gap_changes(&run.model, run.state, controls);
    let own = |change: &Vec<f64>| -> Vec<f64> { closed.iter().map(|&k| change[k]).collect() };
    let own: Vec<Vec<f64>> = changes.iter().map(own).collect();
    let mut known = condensed(program.metric(), &closed, &own, run.work);
    let stiffer = evenly(&run.model).recip();
    for column in known.iter_mut().flatten() {
        scale(column, stiffer);
    }
    PushStiffness {
        controls: controls.to_vec(),
        columns: known.unwrap_or_else(|| of_punches(&own)),
    }
}

/// D_A^T H_AA^-1 D_A of the multipliers `closed`, column by column; none where the metric has
/// no such part, or no factor of it.
fn condensed(
    metric: &dyn SymmetricMatrix,
    closed: &[usize],
    changes: &[Vec<f64>],
    work: &mut Workspace,
) -> Option<Vec<Vec<f64>>> {
    let is_known = closed.last().is_none_or(|&last| last < metric.size());
    if !is_known {
        return None;
    }
    let factor = metric.factor_of_part(closed).ok()?;
    let mut column = |change: &Vec<f64>| {
        let mut pressure = change.clone();
        factor.solve_part(&mut pressure, work);
        let entries = changes.iter().map(|other| dot(other, &pressure));
        entries.collect()
    };
    Some(changes.iter().map(&mut column).collect())
}

/// That of punches as large as the body, each for itself, where the metric says nothing: the
/// stiffness is learnt on the way.
fn of_punches(changes: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let size = changes.len();
    let column = |(place, change): (usize, &Vec<f64>)| {
        let mut column = vec![0.0; size];
        column[place] = if dot(change, change) > 0.0 {
            PUNCH
        } else {
            0.0
        };
        column
    };
    changes.iter().enumerate().map(column).collect()
}
