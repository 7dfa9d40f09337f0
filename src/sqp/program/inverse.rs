//! The approximate inverse for a program about the present state: that in use, made
//! anew where it has become too dear.
//!
//! Made anew it costs one factorisation or hierarchy of the P1 tangent and one P1 solve for
//! each trace; the rule that asks for it is that of `preconditioner_refresh`.

use std::sync::Arc;

use crate::model::counters::timed;
use crate::model::tangent::Tangent;
use crate::prepare::{ApproximateInverse, Deformed};
use crate::sqp::run::Run;

/// The approximate inverse for a program about the present state.
pub(super) fn inverse(run: &mut Run<'_>, tangent: Option<&Tangent>) -> Arc<ApproximateInverse> {
    if let Some(tangent) = tangent
        && run.learned.refresh.is_stale()
    {
        make(run, tangent);
    }
    let made = run.learned.refresh.made();
    made.unwrap_or_else(|| run.model.prepared.at_rest.clone())
}

/// Makes the approximate inverse anew about `tangent` and counts it; where the tangent
/// has no factor the one in use stays.
fn make(run: &mut Run<'_>, tangent: &Tangent) {
    let is_pressed = run.state.multiplier.iter().any(|&l| l > 0.0);
    let deformed = Deformed {
        cells: &tangent.cells,
        at: &tangent.at,
        displacement: &run.state.displacement,
        pressure: &run.state.pressure,
    };
    let model = &run.model;
    let made = timed(&mut run.counters.seconds.factorise, || {
        let cancel = run.watch.cancel;
        let (prepared, plan) = (model.prepared, model.plan);
        // What is pressed and not held is unstable.
        if is_pressed {
            prepared.about_without_pressure(plan, model.mesh, deformed, cancel)
        } else {
            prepared.about(plan, model.mesh, deformed, cancel)
        }
    });
    match made {
        Ok(made) => {
            run.counters.factorisations += 1;
            run.learned.refresh.take(made);
        }
        // A cancelled one is noticed by the next iteration.
        Err(_) => run.learned.refresh.refuse(),
    }
}
