//! Numerical settings of a scene.

use super::choices::{
    Choice, ContactMethod, ContactSpace, DisplacementMethod, ElementKind, ErrorEstimate,
    MetricKind, OnInstability, P1Solver, ReportScope, ResponseMethod, SaddleMethod, StabilityCheck,
};

/// How far the residuals are reduced.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToleranceRule {
    /// To [`SolverOptions::tolerance`] in every case.
    #[default]
    Fixed,
    /// Until the algebraic error is a tenth of the estimated discretisation
    /// error, but not below [`SolverOptions::tolerance`].
    Discretisation,
}

/// Numerical settings; every one has a default.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolverOptions {
    /// Bound on all four residuals, relative to load or first residual.
    pub tolerance: f64,
    /// Whether that bound is reached in every case, or only as far as the
    /// discretisation deserves.
    pub tolerance_rule: ToleranceRule,
    /// Estimate of the discretisation error that converged increments report.
    pub error_estimate: Choice<ErrorEstimate>,
    /// Degree of the volume rule: for loads and norms, and for the stress of
    /// rubber (2 to 12 there); `None` chooses.
    pub quadrature_degree: Option<u32>,
    /// Seconds after which a step ends with its last good state.
    pub max_wall_time: Option<f64>,
    /// Spaces of displacement and pressure.
    pub element: Choice<ElementKind>,
    /// Preconditioner of the displacement block.
    pub displacement_preconditioner: Choice<DisplacementMethod>,
    /// Solver of the P1 block inside that preconditioner.
    pub p1_solver: Choice<P1Solver>,
    /// Method of the linear systems.
    pub saddle: Choice<SaddleMethod>,
    /// Method for contact.
    pub contact: Choice<ContactMethod>,
    /// Metric in which the contact pressure is stepped.
    pub contact_metric: Choice<MetricKind>,
    /// Functions of the contact pressure.
    pub contact_space: Choice<ContactSpace>,
    /// How equilibria of rubber are certified.
    pub stability: Choice<StabilityCheck>,
    /// What follows where an equilibrium of rubber is a saddle, or is lost.
    pub on_instability: Choice<OnInstability>,
    /// How a linear body answers the motion of its obstacles.
    pub response: Choice<ResponseMethod>,
    /// What the reports of increments are about.
    pub report: Choice<ReportScope>,
    /// Weight of a grad-div term in the displacement block, in units of the shear
    /// modulus; for incompressible materials. `None`: none. Of rubber: of the volume
    /// change that the pressure does not see; `None`: where an equilibrium is lost.
    pub penalty: Option<f64>,
    /// Recompute the residuals by the independent path after each increment.
    pub verify: bool,
}

impl Default for SolverOptions {
    fn default() -> Self {
        Self {
            tolerance: 1e-8,
            tolerance_rule: ToleranceRule::Fixed,
            error_estimate: Choice::Auto,
            quadrature_degree: None,
            max_wall_time: None,
            element: Choice::Auto,
            displacement_preconditioner: Choice::Auto,
            p1_solver: Choice::Auto,
            saddle: Choice::Auto,
            contact: Choice::Auto,
            contact_metric: Choice::Auto,
            contact_space: Choice::Auto,
            stability: Choice::Auto,
            on_instability: Choice::Auto,
            response: Choice::Auto,
            report: Choice::Auto,
            penalty: None,
            verify: false,
        }
    }
}
