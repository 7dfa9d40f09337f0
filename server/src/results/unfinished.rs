//! Results of increments that no solver finished.

use signorini::report::{StepReport, Termination};
use signorini_proto::v1 as wire;

/// A report that names the increment and how it ended, with nothing done.
pub(crate) fn report(step: u32, increment: u32, termination: Termination) -> StepReport {
    StepReport {
        step,
        increment,
        time: f64::from(step.saturating_sub(1)),
        termination,
        // Of the undeformed body.
        volume_ratio: 1.0,
        ..StepReport::default()
    }
}

/// The last good state, reported again for an increment that was stopped before
/// it began and is `blank` otherwise.
pub(crate) fn stopped(
    last: Option<&wire::StepReport>,
    blank: wire::StepReport,
) -> wire::StepReport {
    let Some(last) = last.cloned() else {
        return blank;
    };
    wire::StepReport {
        time: last.time,
        load: last.load,
        active_vertices: last.active_vertices,
        strain_energy: last.strain_energy,
        volume_ratio: last.volume_ratio,
        min_jacobian: last.min_jacobian,
        min_jacobian_bound: last.min_jacobian_bound,
        penalty: last.penalty,
        stability: last.stability,
        max_penetration: last.max_penetration,
        residuals: last.residuals,
        tolerance: last.tolerance,
        obstacles: last.obstacles,
        supports: last.supports,
        probes: last.probes,
        error_estimate: last.error_estimate,
        errors: last.errors,
        unknowns: last.unknowns,
        memory_bytes: last.memory_bytes,
        instruction_set: last.instruction_set,
        left_out: last.left_out,
        obstacle_poses: last.obstacle_poses,
        ..blank
    }
}
