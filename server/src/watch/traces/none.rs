//! A build that sends no traces.

use signorini::report::{IterationRecord, StepReport};

/// Traces of a server.
pub(crate) struct Traces;

impl Traces {
    /// # Errors
    /// What is wrong: any endpoint.
    pub(crate) fn start(endpoint: &str) -> Result<Self, String> {
        match endpoint {
            "" => Ok(Self),
            _ => Err("`otlp_endpoint` needs a build with the feature `otlp`".to_owned()),
        }
    }

    pub(crate) fn update(&self, _session: &str, _sequence: i64) -> UpdateTrace {
        UpdateTrace
    }

    pub(crate) fn close(&self) {}
}

/// Of one update.
#[derive(Clone)]
pub(crate) struct UpdateTrace;

impl UpdateTrace {
    pub(crate) fn increment(&self, _number: u32) -> IncrementTrace {
        IncrementTrace
    }
}

/// Of one increment.
pub(crate) struct IncrementTrace;

impl IncrementTrace {
    #[expect(
        clippy::needless_pass_by_ref_mut,
        reason = "as that of a build which sends them"
    )]
    pub(crate) fn iteration(&mut self, _record: &IterationRecord) {}

    pub(crate) fn finish(self, _report: &StepReport) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_endpoint_is_refused_with_what_it_takes() {
        assert!(Traces::start("").is_ok());
        let refused = Traces::start("http://127.0.0.1:4317").err();
        assert!(refused.is_some_and(|why| why.contains("feature `otlp`")));
    }
}
