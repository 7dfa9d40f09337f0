//! What a mesh gave, and how the loop ended.

use std::fmt;

use crate::report::Termination;

/// One goal on one mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct GoalRound {
    /// The functional, as scenes name it.
    pub goal: String,
    /// Its value.
    pub value: f64,
    /// The exact value less this one, estimated.
    pub estimate: f64,
    /// What the error is not above: of the mesh, of the solver and of flat facets together.
    pub bound: f64,
    /// The part of flat facets in it.
    pub geometry: f64,
    /// Largest error over the absolute value that was asked for.
    pub tolerance: f64,
}

impl GoalRound {
    /// The bound over the absolute value; infinite where the value is zero.
    pub fn relative(&self) -> f64 {
        let relative = self.bound / self.value.abs();
        if relative.is_nan() {
            f64::INFINITY
        } else {
            relative
        }
    }

    /// Whether it is known as well as was asked for.
    pub fn is_reached(&self) -> bool {
        self.relative() <= self.tolerance
    }
}

/// One mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Round {
    /// Its number, from 1.
    pub round: u32,
    /// Cells of the mesh.
    pub cells: u64,
    /// Unknowns, those of contact included.
    pub unknowns: u64,
    /// Goals, in the order in which they were asked for.
    pub goals: Vec<GoalRound>,
    /// Wall seconds of the round, preparation included.
    pub seconds: f64,
    /// Wall seconds of its dual solutions and bounds.
    pub dual_seconds: f64,
}

/// Why there is no finer mesh.
#[derive(Clone, Debug, PartialEq)]
pub enum End {
    /// All goals are known as well as was asked for.
    Reached,
    /// The next mesh would have more unknowns than are allowed.
    Unknowns {
        /// What it would have; none where it was not made to the end.
        needed: Option<u64>,
        /// What is allowed.
        most: u64,
    },
    /// The next mesh would take more memory than is allowed.
    Memory {
        /// Bytes that it would take; none where it was not made to the end.
        needed: Option<u64>,
        /// What is allowed.
        most: u64,
    },
    /// There is no room for the next mesh beside what others hold.
    NoRoom {
        /// Bytes that it would take.
        needed: u64,
    },
    /// The next mesh would take more time than is left.
    Time {
        /// Seconds allowed.
        most: f64,
    },
    /// As many meshes as are allowed.
    Rounds(u32),
    /// Flat facets that stand for a curved surface, and what the solver left, make more of a goal
    /// than is asked for: no refinement of these facets helps.
    Facets {
        /// The goal.
        goal: String,
        /// Their part of the bound over the absolute value.
        relative: f64,
    },
    /// What the solver left makes more of a goal than is asked for.
    Solver {
        /// The goal.
        goal: String,
        /// Its part of the bound over the absolute value.
        relative: f64,
    },
    /// The goal is zero: it has no relative error.
    Zero(String),
    /// A step found no equilibrium on the mesh of the scene: no goal has a value.
    NoEquilibrium {
        /// The step, from 1.
        step: u32,
        /// How it ended.
        termination: Termination,
    },
    /// The state found no equilibrium on the next mesh; that of the mesh before is kept.
    NotConverged(Termination),
    /// The next mesh has no answer; that of the mesh before is kept.
    Failed(String),
}

impl End {
    /// Whether what was asked for is reached.
    pub fn is_reached(&self) -> bool {
        *self == Self::Reached
    }

    /// The word used in result lines.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Reached => "reached",
            Self::Unknowns { .. } => "max_unknowns",
            Self::Memory { .. } => "max_memory",
            Self::NoRoom { .. } => "no_room",
            Self::Time { .. } => "max_time",
            Self::Rounds(_) => "max_rounds",
            Self::Facets { .. } => "facets",
            Self::Solver { .. } => "solver",
            Self::Zero(_) => "zero",
            Self::NoEquilibrium { .. } | Self::NotConverged(_) => "not_converged",
            Self::Failed(_) => "failed",
        }
    }
}

impl fmt::Display for End {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Reached => write!(out, "all goals are known as well as was asked for"),
            Self::Unknowns {
                needed: Some(needed),
                most,
            } => write!(
                out,
                "the next mesh would have {needed} unknowns, and {most} are allowed"
            ),
            Self::Unknowns { needed: None, most } => write!(
                out,
                "the next mesh would have more unknowns than the {most} that are allowed"
            ),
            Self::Memory {
                needed: Some(needed),
                most,
            } => write!(
                out,
                "the next mesh would take {needed} bytes, and {most} are allowed"
            ),
            Self::Memory { needed: None, most } => write!(
                out,
                "the next mesh would take more than the {most} bytes that are allowed"
            ),
            Self::NoRoom { needed } => write!(
                out,
                "the next mesh would take {needed} bytes, for which there is no room now"
            ),
            Self::Time { most } => write!(
                out,
                "the next mesh would take longer than the {most} s that are allowed"
            ),
            Self::Rounds(most) => write!(out, "{most} meshes are allowed"),
            Self::Facets { goal, relative } => write!(
                out,
                "flat facets stand for a curved surface and make {:.2} % of {goal}: use cells of \
                 second order, or surface = \"smooth\"",
                100.0 * relative
            ),
            Self::Solver { goal, relative } => write!(
                out,
                "what the solver left makes {relative:.1e} of {goal}: ask for less, or give solver.tolerance"
            ),
            Self::Zero(goal) => write!(out, "{goal} is zero, which has no relative error"),
            Self::NoEquilibrium { step, termination } => write!(
                out,
                "step {step} found no equilibrium on the mesh of the scene ({})",
                termination.name()
            ),
            Self::NotConverged(termination) => write!(
                out,
                "the state found no equilibrium on the next mesh ({})",
                termination.name()
            ),
            Self::Failed(cause) => write!(out, "the next mesh has no answer: {cause}"),
        }
    }
}
