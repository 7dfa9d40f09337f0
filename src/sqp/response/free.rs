//! The body under the loads and supports of a drive, without contact.

use super::kept::Free;
use crate::inequality::BodyFactor;
use crate::linalg::vector::add_scaled;
use crate::model::evaluate::evaluate_body;
use crate::model::prescribed::{carry, prescribe};
use crate::sqp::run::Run;

/// Solutions with the factor: the second takes the shift's error off.
const PASSES: usize = 2;

/// u0 and p0 under the drive of the state.
pub(super) fn free(run: &mut Run<'_>, factor: &BodyFactor) -> Free {
    let mut state = run.state.clone();
    state.displacement.fill(0.0);
    state.pressure.fill(0.0);
    state.multiplier.fill(0.0);
    prescribe(&run.model, &run.state.drive, &mut state.displacement);
    let at_rest = vec![0.0; state.displacement.len()];
    carry(&run.model, &at_rest, &mut state.displacement);
    for _ in 0..PASSES {
        let now = evaluate_body(&run.model, &state, &mut run.work);
        let mut load = now.force;
        load.extend_from_slice(&now.constraint);
        factor.solve(&mut load, &mut run.work);
        let (moved, pressure) = load.split_at(state.displacement.len());
        add_scaled(&mut state.displacement, 1.0, moved);
        add_scaled(&mut state.pressure, 1.0, pressure);
    }
    Free {
        drive: state.drive,
        displacement: state.displacement,
        pressure: state.pressure,
    }
}
