//! Whether friction admits other equilibria beside the one that was found: the dense problem
//! of [`crate::inequality::dense_cone`] in the compliance about it,
//!
//! ```text
//! q = (gap, slip) - H x,   solutions of the law for q + H x' beside x
//! ```
//!
//! H is as near to the body's compliance as a metric is (condition 2 to 4), and knows the volume
//! of rubber as it is at rest: another solution is reason for a doubt, no proof. Cost: the
//! metric of a program, a Cholesky factor of the pressures; only up to `MOST` multipliers.

use crate::inequality::dense_cone::{DenseSolution, cones, uniqueness};
use crate::linalg::LinearOperator;
use crate::linalg::vector::add_scaled;
use crate::model::ending::{AlternativeEquilibrium, Ending};
use crate::report::Termination;
use crate::saddle::{ProductSet, Status};
use crate::scene::MetricKind;
use crate::sqp::contact_metric::ContactMetric;
use crate::sqp::run::Run;
use crate::sqp::volumes::volumes;

constants! {
    /// Multipliers at most, whose factor is not felt.
    const MOST: usize = 900;
}

/// Notes in `ending` what speaks for another equilibrium under the same drive.
pub(crate) fn look_for_an_alternative(run: &mut Run<'_>, ending: &mut Ending) {
    let is_asked = ending.termination == Termination::Converged
        && run.model.interfaces.friction.is_some()
        && run.state.drive.friction.iter().any(|&mu| mu > 0.0)
        // Where nothing has moved what was said after the last increment holds.
        && run.counters.sqp_iterations > 0
        && run.model.plan.decisions.contact.metric == MetricKind::Compliance
        && run.state.multiplier.len() <= MOST;
    if is_asked {
        ending.alternative = alternative(run);
    }
}

fn alternative(run: &mut Run<'_>) -> Option<AlternativeEquilibrium> {
    let now = run.evaluate();
    let prepared = run.model.prepared;
    let made = run.learned.refresh.made();
    let inverse = made.unwrap_or_else(|| prepared.at_rest.clone());
    let pressure = prepared.pressure.as_ref();
    let divergence = pressure.map(|block| &block.coupling as &dyn LinearOperator);
    let body = (&*inverse, divergence);
    let volumes = volumes(&run.model, body, run.work);
    let metric = ContactMetric::new(&run.model, &inverse, volumes, &now, run.work);
    let matrix = &*metric.matrix;
    let known = DenseSolution {
        values: run.state.multiplier.clone(),
        ..DenseSolution::default()
    };
    let mut linear = vec![0.0; known.values.len()];
    matrix.product(&known.values, &mut linear);
    linear.iter_mut().for_each(|value| *value = -*value);
    add_scaled(&mut linear, 1.0, &now.gap);
    let set = now.contact_set();
    let found = uniqueness(matrix, &linear, set, &known)?;
    let other = found.other?;
    Some(AlternativeEquilibrium {
        indicator: found.indicator,
        own: counts(&set, &run.state.status)?,
        other: counts(&set, &other.status)?,
    })
}

/// Points of friction that stick, slip and are open.
fn counts(set: &ProductSet<'_>, status: &[Status]) -> Option<[usize; 3]> {
    let (cones, first) = cones(set)?;
    let mut counts = [0; 3];
    for (partner, _, place) in cones.points() {
        let of_pressure = status[first + partner].is_closed();
        counts[match (of_pressure, status[first + place]) {
            (false, _) => 2,
            (true, Status::Stick) => 0,
            (true, Status::Open | Status::Slip) => 1,
        }] += 1;
    }
    Some(counts)
}
