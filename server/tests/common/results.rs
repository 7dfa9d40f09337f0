//! Results of two runs side by side.

use signorini_proto::v1 as wire;

/// What must be the same in every run: all but times, memory and what was found prepared.
pub(crate) fn bare(mut result: wire::StepFinished) -> wire::StepFinished {
    if let Some(report) = &mut result.report {
        report.seconds = None;
        report.memory_bytes = 0;
        report.reused.clear();
        report.factorisations = 0;
        report.eigenvalue_applications = 0;
        report.compliance_columns = 0;
    }
    result
}
