//! What an increment has tried in vain.

use super::Cause;

/// A way to solve a part of an increment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Strategy {
    /// A part of the load path at once.
    Part,
    /// Half of that part.
    SmallerPart,
    /// A larger volume penalty, which holds motions that the element pair alone lets go.
    VolumePenalty,
    /// Down the energy to the next minimum.
    SnapThrough,
    /// A sequence of equilibria, each held back to the one before, for a body that contact alone
    /// holds.
    ProximalRest,
}

impl Strategy {
    /// All, in the order in which they are listed.
    pub const ALL: [Self; 5] = [
        Self::Part,
        Self::SmallerPart,
        Self::VolumePenalty,
        Self::SnapThrough,
        Self::ProximalRest,
    ];

    /// The name used on the wire, in metrics and in result lines.
    pub fn name(self) -> &'static str {
        match self {
            Self::Part => "part",
            Self::SmallerPart => "smaller_part",
            Self::VolumePenalty => "volume_penalty",
            Self::SnapThrough => "snap_through",
            Self::ProximalRest => "proximal_rest",
        }
    }
}

/// An attempt that failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Attempt {
    /// What was tried.
    pub strategy: Strategy,
    /// Why it failed; none where no cause is known.
    pub cause: Option<Cause>,
    /// Applications of the displacement preconditioner that it took.
    pub preconditioner_applications: u32,
    /// What followed; none where the increment ended.
    pub followed_by: Option<Strategy>,
}
