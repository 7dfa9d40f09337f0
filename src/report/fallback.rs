//! The rungs of the ladder: what solved an increment where the plan's own method failed.

/// A second attempt, by what it does otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fallback {
    /// The metric of the contact pressure is the mass of the surface.
    MassMetric,
    /// Contact is solved by proportioning with reduced gradient projection.
    Mprgp,
    /// The saddle point is assembled and factorised.
    Direct,
}

impl Fallback {
    /// All of them, in the order in which they are tried.
    pub const ALL: [Self; 3] = [Self::MassMetric, Self::Mprgp, Self::Direct];

    /// The name used on the wire and in result lines.
    pub fn name(self) -> &'static str {
        match self {
            Self::MassMetric => "mass_metric",
            Self::Mprgp => "mprgp",
            Self::Direct => "direct",
        }
    }
}
