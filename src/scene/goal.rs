//! Goals as users name them: functionals of an increment whose error or derivatives are asked for.
//!
//! | text | functional | unit |
//! |---|---|---|
//! | `force.NAME.x` | force of an obstacle on the body, or of a contact on the body named first | force |
//! | `moment.NAME.z` | its moment about its reference point | force times length |
//! | `reaction.NAME.y` | force of a support on the body | force |
//! | `displacement.NAME.y` | displacement of a probe | length |
//! | `max_pressure.NAME` | largest contact pressure of an obstacle | stress |
//! | `strain_energy` | energy that the body stores | force times length |
//!
//! About an axis forces along x are radial, summed over the full turn: those of opposite sides do not
//! balance each other there.

use std::fmt;
use std::str::FromStr;

use super::SceneKind;

/// A text that names no goal or parameter.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{text}` is not of the form {expected}")]
pub struct Malformed {
    /// The text.
    pub text: String,
    /// What it should be.
    pub expected: &'static str,
}

/// A functional of the state, whose error or derivatives are asked for.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Goal {
    /// What is measured.
    pub kind: GoalKind,
    /// Name of the obstacle, the support or the probe; empty where there is none.
    pub name: String,
    /// Axis of the component, 0 to 2; 0 where there is none.
    pub axis: u8,
}

/// What a goal measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum GoalKind {
    /// Force that an obstacle exerts on the body, or a contact between bodies on the one named first.
    Force,
    /// Moment of that force about the obstacle's present reference point.
    Moment,
    /// Force that a support exerts on the body.
    Reaction,
    /// Displacement of a probe.
    Displacement,
    /// Largest contact pressure at a node of an obstacle's surface.
    MaxPressure,
    /// Energy that the body stores.
    StrainEnergy,
}

impl GoalKind {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Force,
        Self::Moment,
        Self::Reaction,
        Self::Displacement,
        Self::MaxPressure,
        Self::StrainEnergy,
    ];

    /// The name used in scenes.
    pub fn name(self) -> &'static str {
        match self {
            Self::Force => "force",
            Self::Moment => "moment",
            Self::Reaction => "reaction",
            Self::Displacement => "displacement",
            Self::MaxPressure => "max_pressure",
            Self::StrainEnergy => "strain_energy",
        }
    }

    /// Whether such a goal has a name and an axis.
    fn has(self) -> [bool; 2] {
        match self {
            Self::Force | Self::Moment | Self::Reaction | Self::Displacement => [true, true],
            Self::MaxPressure => [true, false],
            Self::StrainEnergy => [false, false],
        }
    }

    /// What the name of such a goal is the name of.
    pub fn owner(self) -> &'static str {
        match self {
            Self::Force => "obstacle or contact between bodies",
            Self::Moment | Self::MaxPressure => "obstacle",
            Self::Reaction => "support",
            Self::Displacement => "probe",
            Self::StrainEnergy => "body",
        }
    }
}

impl Goal {
    /// Why no body of that kind has the goal; none where it has.
    pub(crate) fn absent(&self, kind: SceneKind) -> Option<&'static str> {
        let is_plane = kind != SceneKind::Solid;
        let is_moment = self.kind == GoalKind::Moment;
        let [_, has_axis] = self.kind.has();
        if is_moment && kind == SceneKind::Axisymmetric {
            Some("moments of a full turn are zero")
        } else if has_axis && is_plane && is_moment != (self.axis == 2) {
            Some("a plane body has forces and displacements along x and y and moments about z")
        } else {
            None
        }
    }
}

/// The axis of that name.
pub(super) fn axis(text: &str) -> Option<u8> {
    ["x", "y", "z"]
        .iter()
        .position(|name| *name == text)
        .map(|axis| axis as u8)
}

/// The name of an axis.
pub(super) fn axis_name(axis: u8) -> &'static str {
    ["x", "y", "z"].get(usize::from(axis)).unwrap_or(&"z")
}

impl fmt::Display for Goal {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (kind, axis) = (self.kind.name(), axis_name(self.axis));
        match self.kind.has() {
            [true, true] => write!(out, "{kind}.{}.{axis}", self.name),
            [true, false] => write!(out, "{kind}.{}", self.name),
            [false, _] => write!(out, "{kind}"),
        }
    }
}

impl FromStr for Goal {
    type Err = Malformed;

    /// Names may have dots in them.
    fn from_str(text: &str) -> Result<Self, Malformed> {
        let malformed = || Malformed {
            text: text.to_owned(),
            expected: "KIND.NAME.AXIS, such as force.lid.y; kinds are force, moment, reaction and \
                       displacement; or max_pressure.NAME, or strain_energy",
        };
        let (kind, rest) = text.split_once('.').unwrap_or((text, ""));
        let mut kinds = GoalKind::ALL.into_iter();
        let kind = kinds.find(|one| one.name() == kind).ok_or_else(malformed)?;
        let (name, axis) = match kind.has() {
            [true, true] => {
                let (name, last) = rest.rsplit_once('.').ok_or_else(malformed)?;
                (name, axis(last).ok_or_else(malformed)?)
            }
            [true, false] => (rest, 0),
            [false, _] if text == kind.name() => {
                return Ok(Self {
                    kind,
                    name: String::new(),
                    axis: 0,
                });
            }
            [false, _] => return Err(malformed()),
        };
        if name.is_empty() {
            return Err(malformed());
        }
        Ok(Self {
            kind,
            name: name.to_owned(),
            axis,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_goal_reads_what_it_writes() {
        for text in [
            "force.lid.y",
            "reaction.left.wall.x",
            "displacement.p.z",
            "max_pressure.left.lid",
            "strain_energy",
        ] {
            assert_eq!(text.parse::<Goal>().expect("a goal").to_string(), text);
        }
    }

    #[test]
    fn what_is_no_goal_is_refused_with_its_text() {
        for text in [
            "",
            "force",
            "force.y",
            "force..y",
            "force.lid",
            "area.lid.y",
            "max_pressure",
            "max_pressure.",
            "strain_energy.",
            "strain_energy.lid",
        ] {
            let error = text.parse::<Goal>().expect_err("no goal").to_string();
            assert!(error.contains(&format!("`{text}`")), "{error}");
        }
    }
}
