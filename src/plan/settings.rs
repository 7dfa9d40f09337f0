//! Numerical settings that methods read while they run.

use crate::scene::{
    Choice, ErrorEstimate, OnInstability, ReportScope, SolverOptions, ToleranceRule,
};

/// What a scene asks of every increment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Settings {
    /// Bound on all four residuals, relative to load or first residual.
    pub(crate) tolerance: f64,
    /// Whether that bound is reached in every case, or only until the discretisation
    /// error dominates.
    pub(crate) tolerance_rule: ToleranceRule,
    /// Whether a converged increment reports an estimate of its discretisation error.
    pub(crate) estimates_error: bool,
    /// Degree of the volume rule where the scene names one.
    pub(crate) quadrature_degree: Option<u32>,
    /// Wall seconds after which a step ends with its last good state; none for no
    /// limit.
    pub(crate) max_wall_time: Option<f64>,
    /// Weight of the volume penalty in units of the shear modulus where the scene
    /// names one.
    pub(crate) penalty: Option<f64>,
    /// What follows where an equilibrium of rubber is a saddle, or is lost.
    pub(crate) on_instability: OnInstability,
    /// What the report of an increment is about.
    pub(crate) report: ReportScope,
    /// Whether the independent path recomputes the residuals of each increment.
    pub(crate) verify: bool,
}

impl Settings {
    /// The settings among valid options.
    pub(super) fn new(options: &SolverOptions) -> Self {
        Self {
            tolerance: options.tolerance,
            tolerance_rule: options.tolerance_rule,
            estimates_error: match options.error_estimate {
                Choice::Auto => true,
                Choice::Named(ErrorEstimate::Off) => false,
            },
            quadrature_degree: options.quadrature_degree,
            max_wall_time: options.max_wall_time,
            penalty: options.penalty,
            on_instability: match options.on_instability {
                Choice::Auto => OnInstability::Descend,
                Choice::Named(named) => named,
            },
            report: options.report.named().unwrap_or(ReportScope::Whole),
            verify: options.verify,
        }
    }
}
