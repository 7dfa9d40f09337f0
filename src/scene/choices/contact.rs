//! Methods for contact and the metrics of its pressure.

super::named! {
    /// A method for contact, `solver.contact`.
    pub enum ContactMethod {
        /// All unknowns together, the set by a small dense problem.
        OneLevel = "one-level",
        /// Primal-dual active set, each set solved to the end.
        ActiveSet = "active-set",
        /// Projected steps in a metric that learns.
        Nested = "nested",
        /// Proportioning with reduced gradient projection.
        Mprgp = "mprgp",
        /// Conjugate gradients on the free face, projected.
        ConjugateProjectedGradient = "conjugate-projected-gradient",
        /// Fixed projected steps in the metric.
        ProjectedArrowHurwicz = "projected-arrow-hurwicz",
        /// One level, Coulomb friction by iteration on its threshold.
        ThresholdIteration = "threshold-iteration",
        /// Coulomb friction by springs on the slip, moved until nothing creeps.
        RegularisedFriction = "regularised-friction",
    }
}

super::named! {
    /// A metric of the contact pressure, `solver.contact_metric`.
    pub enum MetricKind {
        /// Dense compliance of the P1 body with its edges.
        Compliance = "compliance",
        /// Mass of the surface: lumped where a method scales by it, consistent where
        /// it projects in it.
        Mass = "mass",
        /// Inverse square root of the surface Laplacian, consistent mass.
        Fractional = "fractional",
    }
}

super::named! {
    /// Functions of the contact pressure, `solver.contact_space`.
    pub enum ContactSpace {
        /// Quadratic Bernstein functions, one at every displacement node of the
        /// candidate surface.
        Quadratic = "quadratic",
        /// Hats, one at every vertex.
        Linear = "linear",
    }
}

impl ContactMethod {
    /// The metric that it takes where none is asked for.
    pub fn natural_metric(self) -> MetricKind {
        match self {
            Self::OneLevel
            | Self::ActiveSet
            | Self::Nested
            | Self::Mprgp
            | Self::ThresholdIteration
            | Self::RegularisedFriction => MetricKind::Compliance,
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
            | Self::ProjectedArrowHurwicz
            | Self::ThresholdIteration
            | Self::RegularisedFriction => true,
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
            Self::OneLevel | Self::ThresholdIteration | Self::RegularisedFriction => false,
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
            Self::OneLevel
            | Self::ActiveSet
            | Self::ThresholdIteration
            | Self::RegularisedFriction => false,
            Self::Nested
            | Self::Mprgp
            | Self::ConjugateProjectedGradient
            | Self::ProjectedArrowHurwicz => true,
        }
    }
}
