//! A progress bar, on terminals only.

use indicatif::{ProgressBar, ProgressStyle};
use signorini_proto::v1;

/// Without colours, so that `NO_COLOR` holds by itself.
const TEMPLATE: &str = "{wide_msg} [{bar:20}] {pos}/{len} {elapsed}";

/// Whether anything is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Visibility {
    /// On a terminal.
    Shown,
    /// Never.
    Hidden,
}

/// Shows the newest iteration and the finished increments.
pub(crate) struct Progress(ProgressBar);

impl Progress {
    /// A bar over all increments of a run; hidden where stderr is no terminal.
    pub(crate) fn new(increments: u64, visibility: Visibility) -> Self {
        let bar = match visibility {
            Visibility::Shown => ProgressBar::new(increments),
            Visibility::Hidden => ProgressBar::hidden(),
        };
        if let Ok(style) = ProgressStyle::with_template(TEMPLATE) {
            bar.set_style(style.progress_chars("=> "));
        }
        Self(bar)
    }

    /// What is being done.
    pub(crate) fn phase(&self, phase: &str) {
        self.0.set_message(phase.to_owned());
        self.0.tick();
    }

    /// Newest statistics.
    pub(crate) fn iteration(&self, report: &v1::IterationReport) {
        let residuals = report.residuals.unwrap_or_default();
        let largest = residuals
            .equilibrium
            .max(residuals.incompressibility)
            .max(residuals.complementarity)
            .max(residuals.gap);
        self.0.set_message(format!(
            "step {}.{} sqp {} krylov {} residual {largest:.1e} contact {}",
            report.step,
            report.increment,
            report.sqp_iteration,
            report.krylov_iterations,
            report.active_vertices,
        ));
    }

    /// One increment is done.
    pub(crate) fn finished(&self) {
        self.0.inc(1);
    }

    /// Prints a line above the bar.
    pub(crate) fn note(&self, line: &str) {
        self.0.suspend(|| crate::text::note(&format!("{line}\n")));
    }

    /// Removes the bar.
    pub(crate) fn clear(&self) {
        self.0.finish_and_clear();
    }
}
