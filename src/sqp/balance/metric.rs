//! The stiffness under pushed obstacles as the metric of contact says.
//!
//! ```text
//! J ~ D_A^T H_AA^-1 D_A
//! ```
//!
//! H an approximation of the compliance C A^-1 C^T, A what is closed at the present state:
//! pressures, and tractions that stick. Cost: a factor of H_AA.

use super::rigid::gap_changes;
use crate::linalg::vector::dot;
use crate::linalg::{DenseCholesky, SymmetricMatrix};
use crate::model::push::Control;
use crate::saddle::Status;
use crate::sqp::program::QuadraticProgram;
use crate::sqp::push_stiffness::PushStiffness;
use crate::sqp::run::Run;

/// As the metric says at the present state.
pub(super) fn by_metric(run: &mut Run<'_>, controls: &[Control]) -> PushStiffness {
    let now = run.evaluate();
    let program = QuadraticProgram::new(run, &now, None, &mut 0.0);
    let closed = |status: &Status| *status == Status::Stick;
    let statuses = run.state.status.iter().enumerate();
    let closed = statuses.filter(|(_, status)| closed(status));
    let closed: Vec<usize> = closed.map(|(place, _)| place).collect();
    let changes = gap_changes(&run.model, run.state, controls);
    PushStiffness {
        controls: controls.to_vec(),
        columns: condensed(program.metric(), &closed, &changes),
    }
}

/// D_A^T H_AA^-1 D_A of the multipliers `closed`, column by column; zero where the metric has
/// no such part.
fn condensed(
    metric: &dyn SymmetricMatrix,
    closed: &[usize],
    changes: &[Vec<f64>],
) -> Vec<Vec<f64>> {
    let zero = vec![vec![0.0; changes.len()]; changes.len()];
    let is_there = closed.last().is_some_and(|&last| last < metric.size());
    if !is_there {
        return zero;
    }
    let Ok(factor) = DenseCholesky::new(&metric.principal_part(closed)) else {
        return zero;
    };
    let own = |change: &Vec<f64>| -> Vec<f64> { closed.iter().map(|&k| change[k]).collect() };
    let own: Vec<Vec<f64>> = changes.iter().map(own).collect();
    let column = |change: &Vec<f64>| {
        let mut pressure = change.clone();
        factor.solve(&mut pressure);
        own.iter().map(|other| dot(other, &pressure)).collect()
    };
    own.iter().map(column).collect()
}
