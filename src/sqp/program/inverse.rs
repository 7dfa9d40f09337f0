//! The approximate inverse for a program about the present state: that in use, made
//! anew where it has become too dear.
//!
//! Made anew it costs one factorisation or hierarchy of the P1 tangent and one P1 solve for
//! each trace; the rule that asks for it is that of `preconditioner_refresh`.

use std::sync::Arc;

use super::augmentation::mean_pressure;
use crate::linalg::SparseRows;
use crate::model::counters::timed;
use crate::model::tangent::Tangent;
use crate::precond::stiff_constraints::Pressed;
use crate::prepare::{ApproximateInverse, ClosedGaps, Deformed};
use crate::scene::MetricKind;
use crate::sqp::preconditioner_refresh::PRESSED;
use crate::sqp::run::Run;

/// Mean contact pressure, in shear moduli, above which the inverse leaves the pressure out: the
/// springs no longer outweigh it, and `augmentation` cancels it.
const HIGH: f64 = 10.0;

/// The approximate inverse for a program about the present state.
pub(super) fn inverse(
    run: &mut Run<'_>,
    tangent: Option<&Tangent>,
    coupling: &SparseRows,
) -> Arc<ApproximateInverse> {
    if let Some(tangent) = tangent {
        let pressure = mean_pressure(&run.model, run.state);
        run.learned.refresh.see_release(pressure);
        if run.learned.refresh.is_stale(pressure) {
            make(run, tangent, (coupling, pressure));
        }
    }
    let made = run.learned.refresh.made();
    made.unwrap_or_else(|| run.model.prepared.at_rest.clone())
}

/// Makes the approximate inverse anew about `tangent` and counts it; where the tangent
/// has no factor the one in use stays.
fn make(run: &mut Run<'_>, tangent: &Tangent, (coupling, pressure): (&SparseRows, f64)) {
    let is_known = run.model.plan.contact.metric == MetricKind::Compliance;
    let is_thin = (run.model.prepared.pressure.as_ref()).is_some_and(|block| block.coarse.is_thin);
    // On springs a thin body lets no volume pass below the contact, and the modes that contact
    // shares with the internal pressure know nothing of it.
    let has_springs = is_known && pressure > PRESSED && !is_thin;
    let is_pressed = run.state.multiplier.iter().any(|&l| l > 0.0);
    let closed = run.state.status.iter().map(|status| status.is_closed());
    let closed: Vec<bool> = closed.collect();
    let contact = ClosedGaps {
        coupling,
        pressed: Pressed {
            closed: &closed,
            own: &run.state.multiplier,
            mean: pressure,
        },
    };
    let deformed = Deformed {
        cells: &tangent.cells,
        at: &tangent.at,
        displacement: &run.state.displacement,
        pressure: &run.state.pressure,
        contact: has_springs.then_some(contact),
    };
    let model = &run.model;
    let made = timed(&mut run.counters.seconds.factorise, || {
        let cancel = run.watch.cancel;
        let (prepared, plan) = (model.prepared, model.plan);
        // What is pressed and not held is unstable.
        let knows_pressure = match has_springs {
            true => pressure <= HIGH,
            false => !is_pressed,
        };
        match knows_pressure {
            true => prepared.about(plan, model.mesh, deformed, cancel),
            false => prepared.about_without_pressure(plan, model.mesh, deformed, cancel),
        }
    });
    match made {
        Ok(made) => {
            run.counters.factorisations += 1;
            run.learned.refresh.take(made, pressure);
        }
        // A cancelled one is noticed by the next iteration.
        Err(_) => run.learned.refresh.refuse(pressure),
    }
}
