//! How a solve ended, and why; what kind of equilibrium it found.
//!
//! The enums are exhaustive: whoever maps them, as the server does onto the wire,
//! names every value, so that a new one does not compile until it has its place.

/// How a step, an increment or an inner solve ended. Not converging is a
/// result: the best iterate is kept and a [`Cause`] says why. The default claims
/// nothing: only a solver that met its tolerance says that it converged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Termination {
    /// All four criteria are at or below the tolerance.
    Converged,
    /// The method stopped without reaching the tolerance.
    #[default]
    NotConverged,
    /// The caller cancelled; the last good state is kept.
    Cancelled,
    /// `max_wall_time` or the caller's deadline passed.
    DeadlineExceeded,
    /// A defect of the solver; the session cannot go on.
    InternalError,
}

impl Termination {
    /// All, in the order in which they are listed.
    pub const ALL: [Self; 5] = [
        Self::Converged,
        Self::NotConverged,
        Self::Cancelled,
        Self::DeadlineExceeded,
        Self::InternalError,
    ];

    /// The name used on the wire and in result lines.
    pub fn name(self) -> &'static str {
        match self {
            Self::Converged => "converged",
            Self::NotConverged => "not_converged",
            Self::Cancelled => "cancelled",
            Self::DeadlineExceeded => "deadline_exceeded",
            Self::InternalError => "internal_error",
        }
    }
}

/// Why a step did not converge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// The Krylov method no longer reduces the residual.
    Stagnation,
    /// The Krylov method used up its iterations before the residual was small.
    IterationLimit,
    /// The active set returned to an earlier one, so that vertices would open and close
    /// by turns.
    ActiveSetCycle,
    /// Cut-backs made the increment smaller than its floor.
    StepTooSmall,
    /// The line search found no step length that makes progress.
    LineSearch,
    /// Loads or free rigid modes admit no equilibrium.
    NoEquilibrium,
    /// Prescribed motion changes the volume of an enclosed incompressible body.
    EnclosedVolume,
    /// A residual or field became infinite or not a number.
    NotFinite,
    /// A factorisation met a pivot that is not positive.
    IndefiniteTangent,
    /// No equilibrium lies beyond the load that was reached: the path turns back.
    LimitPoint,
    /// The equilibrium is no minimum of the energy: the body buckles or snaps.
    UnstableEquilibrium,
    /// det F falls to zero at a point of the rule: cells would turn inside out.
    NegativeJacobian,
    /// All is in balance, but det F is below zero between the points of the rule: a cell is
    /// inside out, which no body is.
    InsideOut,
    /// A fluid reaches what must stay dry, or another fluid.
    Leaks,
}

impl Cause {
    /// Whether it may be the method's alone: nothing that the body has been seen to do.
    pub(crate) fn is_numerical(self) -> bool {
        matches!(
            self,
            Self::Stagnation
                | Self::IterationLimit
                | Self::ActiveSetCycle
                | Self::IndefiniteTangent
                | Self::LineSearch
        )
    }

    /// All, in the order in which they are listed.
    pub const ALL: [Self; 14] = [
        Self::Stagnation,
        Self::IterationLimit,
        Self::ActiveSetCycle,
        Self::StepTooSmall,
        Self::LineSearch,
        Self::NoEquilibrium,
        Self::EnclosedVolume,
        Self::NotFinite,
        Self::IndefiniteTangent,
        Self::LimitPoint,
        Self::UnstableEquilibrium,
        Self::NegativeJacobian,
        Self::InsideOut,
        Self::Leaks,
    ];

    /// The name used on the wire and in result lines.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stagnation => "stagnation",
            Self::IterationLimit => "iteration_limit",
            Self::ActiveSetCycle => "active_set_cycle",
            Self::StepTooSmall => "step_too_small",
            Self::LineSearch => "line_search",
            Self::NoEquilibrium => "no_equilibrium",
            Self::EnclosedVolume => "enclosed_volume",
            Self::NotFinite => "not_finite",
            Self::IndefiniteTangent => "indefinite_tangent",
            Self::LimitPoint => "limit_point",
            Self::UnstableEquilibrium => "unstable_equilibrium",
            Self::NegativeJacobian => "negative_jacobian",
            Self::InsideOut => "inside_out",
            Self::Leaks => "leaks",
        }
    }
}

/// A snap-through from a lost equilibrium, down the energy to the next minimum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Snapped {
    /// Potential energy that was lost, in the caller's unit of energy.
    pub energy_drop: f64,
    /// Largest motion of a vertex, in the caller's unit of length.
    pub largest_motion: f64,
    /// Undeformed place of that vertex, in the caller's unit of length.
    pub point: [f64; 3],
}

/// Where an increment that did not converge lost its equilibrium.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CauseSite {
    /// Undeformed point of the body, in the caller's unit of length; none where the whole
    /// body is concerned.
    pub point: Option<[f64; 3]>,
    /// Unit vector along which that point, or the whole body, gives way; none where nothing
    /// moves.
    pub motion: Option<[f64; 3]>,
    /// Key of a step that asks for what cannot be, as `obstacle.ball.force.x`; none where none
    /// does.
    pub key: Option<String>,
}

/// What kind of equilibrium a state is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stability {
    /// The energy is at a minimum among admissible states: stable.
    Minimum,
    /// Some admissible direction lowers the energy: the body would snap or buckle from
    /// here.
    Saddle,
    /// Nobody has counted the unstable motions; none was met.
    NotDetermined,
}

impl Stability {
    /// The name used on the wire and in result lines.
    pub fn name(self) -> &'static str {
        match self {
            Self::Minimum => "minimum",
            Self::Saddle => "saddle",
            Self::NotDetermined => "not_determined",
        }
    }
}
