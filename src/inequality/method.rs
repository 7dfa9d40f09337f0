//! Names of methods and metrics, and the chooser.

use super::active_set::ActiveSet;
use super::arrow_hurwicz::ProjectedArrowHurwicz;
use super::mprgp::Mprgp;
use super::nested::Nested;
use super::projected_gradient::ConjugateProjectedGradient;
use super::{InequalitySolver, OneLevel, QpProblem};

/// Methods for contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactMethod {
    /// [`super::one_level`].
    OneLevel,
    /// [`super::active_set`].
    ActiveSet,
    /// [`super::nested`].
    Nested,
    /// [`super::mprgp`].
    Mprgp,
    /// [`super::projected_gradient`].
    ConjugateProjectedGradient,
    /// [`super::arrow_hurwicz`].
    ProjectedArrowHurwicz,
}

/// Metrics of the contact pressure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MetricKind {
    /// Dense compliance of the P1 body with its edges.
    Compliance,
    /// Mass of the surface: lumped where a method scales by it, consistent where
    /// it projects in it.
    Mass,
    /// Inverse square root of the surface Laplacian, consistent mass.
    Fractional,
}

impl ContactMethod {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::OneLevel,
        Self::ActiveSet,
        Self::Nested,
        Self::Mprgp,
        Self::ConjugateProjectedGradient,
        Self::ProjectedArrowHurwicz,
    ];

    /// The name in scenes.
    pub fn name(self) -> &'static str {
        match self {
            Self::OneLevel => "one-level",
            Self::ActiveSet => "active-set",
            Self::Nested => "nested",
            Self::Mprgp => "mprgp",
            Self::ConjugateProjectedGradient => "conjugate-projected-gradient",
            Self::ProjectedArrowHurwicz => "projected-arrow-hurwicz",
        }
    }

    /// The method of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|method| method.name() == name)
    }

    /// The metric that it takes where none is asked for.
    pub fn natural_metric(self) -> MetricKind {
        match self {
            Self::OneLevel | Self::ActiveSet | Self::Nested | Self::Mprgp => MetricKind::Compliance,
            Self::ConjugateProjectedGradient | Self::ProjectedArrowHurwicz => MetricKind::Mass,
        }
    }

    /// Whether it can work in that metric.
    pub fn takes(self, metric: MetricKind) -> bool {
        match self {
            Self::ConjugateProjectedGradient => metric == MetricKind::Mass,
            Self::OneLevel
            | Self::ActiveSet
            | Self::Nested
            | Self::Mprgp
            | Self::ProjectedArrowHurwicz => true,
        }
    }

    /// Whether it needs that metric as a dense matrix; else the lumped mass is
    /// all that it reads.
    pub fn needs_dense(self, metric: MetricKind) -> bool {
        let scales_only = matches!(self, Self::ConjugateProjectedGradient | Self::Mprgp);
        !(scales_only && metric == MetricKind::Mass)
    }

    /// Whether it solves with a fixed contact pressure on the way, which a body
    /// that only contact holds does not allow.
    pub fn solves_without_contact(self) -> bool {
        match self {
            Self::OneLevel => false,
            Self::ActiveSet
            | Self::Nested
            | Self::Mprgp
            | Self::ConjugateProjectedGradient
            | Self::ProjectedArrowHurwicz => true,
        }
    }

    /// Whether its steps are as long as the metric says, so that the metric must
    /// bound the compliance.
    pub fn has_fixed_steps(self) -> bool {
        self == Self::ProjectedArrowHurwicz
    }

    /// Whether it reads the lumped mass.
    pub fn reads_weights(self) -> bool {
        matches!(self, Self::ConjugateProjectedGradient | Self::Mprgp)
    }

    /// Whether it nests inner solves: such a method that spends its products
    /// does so in parts of the increment as well.
    pub fn is_nested(self) -> bool {
        match self {
            Self::OneLevel | Self::ActiveSet => false,
            Self::Nested
            | Self::Mprgp
            | Self::ConjugateProjectedGradient
            | Self::ProjectedArrowHurwicz => true,
        }
    }
}

impl MetricKind {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Compliance, Self::Mass, Self::Fractional];

    /// The name in scenes.
    pub fn name(self) -> &'static str {
        match self {
            Self::Compliance => "compliance",
            Self::Mass => "mass",
            Self::Fractional => "fractional",
        }
    }

    /// The metric of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|metric| metric.name() == name)
    }
}

/// The method on a problem.
pub fn choose<'a>(method: ContactMethod, problem: QpProblem<'a>) -> Box<dyn InequalitySolver + 'a> {
    match method {
        ContactMethod::OneLevel => Box::new(OneLevel::new(problem)),
        ContactMethod::ActiveSet => Box::new(ActiveSet::new(problem)),
        ContactMethod::Nested => Box::new(Nested { problem }),
        ContactMethod::Mprgp => Box::new(Mprgp { problem }),
        ContactMethod::ConjugateProjectedGradient => {
            Box::new(ConjugateProjectedGradient { problem })
        }
        ContactMethod::ProjectedArrowHurwicz => Box::new(ProjectedArrowHurwicz { problem }),
    }
}
