//! What a mechanic would doubt in a result, in words and as a word for programs.

/// What a warning is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WarningKind {
    /// The body snapped through from a lost equilibrium.
    Snapped,
    /// The equilibrium is a saddle: another one is lower.
    UnstableEquilibrium,
    /// An obstacle touched nothing in an increment that moved it.
    UntouchedObstacle,
    /// An obstacle begins inside the body.
    BeginsInside,
    /// An obstacle has passed through the surface of the body within an increment.
    PassedThrough,
    /// An obstacle lies inside the body where no contact pressure acts.
    MissedContact,
    /// Strains of a linear law beyond what it is meant for.
    LargeStrain,
    /// Linear bodies have slid on each other farther than they are meant to.
    LargeSliding,
    /// Nothing holds the body along a direction.
    FreeMotion,
    /// Faces in contact are large beside the contact.
    CoarseContact,
    /// Facets in contact are far off the curved surface that they stand for.
    CoarseFacets,
    /// A frictional obstacle has turned too far against the body in one increment.
    CoarseTurn,
    /// Rubber has lost more volume between the vertices than its pressure explains.
    CoarseVolume,
    /// Friction may admit another equilibrium under the same drive.
    NotUnique,
    /// Digits are lost: in motions far larger than the strains, between moduli far apart, in very
    /// flat cells.
    LostDigits,
    /// Under a little more pressure of a fluid nothing holds the body.
    PushedOut,
    /// Contacts are at the border of closing or opening, where derivatives of goals are one-sided.
    OneSided,
}

impl WarningKind {
    /// All, in the order in which they are listed.
    pub const ALL: [Self; 17] = [
        Self::Snapped,
        Self::UnstableEquilibrium,
        Self::UntouchedObstacle,
        Self::BeginsInside,
        Self::PassedThrough,
        Self::MissedContact,
        Self::LargeStrain,
        Self::LargeSliding,
        Self::FreeMotion,
        Self::CoarseContact,
        Self::CoarseFacets,
        Self::CoarseTurn,
        Self::CoarseVolume,
        Self::NotUnique,
        Self::LostDigits,
        Self::PushedOut,
        Self::OneSided,
    ];

    /// The word used on the wire and in result lines.
    pub fn name(self) -> &'static str {
        match self {
            Self::Snapped => "snapped",
            Self::UnstableEquilibrium => "unstable_equilibrium",
            Self::UntouchedObstacle => "untouched_obstacle",
            Self::BeginsInside => "begins_inside",
            Self::PassedThrough => "passed_through",
            Self::MissedContact => "missed_contact",
            Self::LargeStrain => "large_strain",
            Self::LargeSliding => "large_sliding",
            Self::FreeMotion => "free_motion",
            Self::CoarseContact => "coarse_contact",
            Self::CoarseFacets => "coarse_facets",
            Self::CoarseTurn => "coarse_turn",
            Self::CoarseVolume => "coarse_volume",
            Self::NotUnique => "not_unique",
            Self::LostDigits => "lost_digits",
            Self::PushedOut => "pushed_out",
            Self::OneSided => "one_sided",
        }
    }
}

/// One warning.
#[derive(Clone, Debug, PartialEq)]
pub struct Warning {
    /// What it is about.
    pub kind: WarningKind,
    /// Name of the obstacle, support or fluid that it is about; empty for the body.
    pub subject: String,
    /// The number that it is about, in the caller's units; none where there is none.
    pub value: Option<f64>,
    /// A sentence for people.
    pub message: String,
}

impl Warning {
    /// About `subject`, which is empty where it is the whole body.
    pub(crate) fn new(
        kind: WarningKind,
        subject: &str,
        value: Option<f64>,
        message: String,
    ) -> Self {
        Self {
            kind,
            subject: subject.to_owned(),
            value,
            message,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The next kind: a walk that a new one has to join.
    fn following(kind: WarningKind) -> Option<WarningKind> {
        use WarningKind::*;
        Some(match kind {
            Snapped => UnstableEquilibrium,
            UnstableEquilibrium => UntouchedObstacle,
            UntouchedObstacle => BeginsInside,
            BeginsInside => PassedThrough,
            PassedThrough => MissedContact,
            MissedContact => LargeStrain,
            LargeStrain => LargeSliding,
            LargeSliding => FreeMotion,
            FreeMotion => CoarseContact,
            CoarseContact => CoarseFacets,
            CoarseFacets => CoarseTurn,
            CoarseTurn => CoarseVolume,
            CoarseVolume => NotUnique,
            NotUnique => LostDigits,
            LostDigits => PushedOut,
            PushedOut => OneSided,
            OneSided => return None,
        })
    }

    #[test]
    fn all_kinds_are_listed() {
        let walk = std::iter::successors(Some(WarningKind::Snapped), |kind| following(*kind));
        assert!(walk.eq(WarningKind::ALL));
    }
}
