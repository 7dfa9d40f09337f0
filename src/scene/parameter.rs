//! Parameters as users name them, by the keys of the scene.
//!
//! | text | parameter | unit |
//! |---|---|---|
//! | `material.GROUP.c10` | a constant of a law; of lists `mu.0`, `alpha.1` | its own |
//! | `obstacle.NAME.translation.x` | pose of an obstacle | length |
//! | `obstacle.NAME.rotation.z` | the same, its rotation vector | radians |
//! | `obstacle.NAME.radius` | a number of its shape; `centre.x` | its own |
//! | `obstacle.NAME.friction` | its coefficient of friction, at the end of the increment | |
//! | `obstacle.NAME.tresca` | the given bound of its tractions | stress |
//! | `obstacle.NAME.force.y` | what the obstacle is pushed by, also `moment.z` | force |
//! | `load` | factor of all loads | |
//! | `mesh` | the places of all vertices | length |
//! | `pressure.0` | a follower pressure, by its place in the scene | stress |
//! | `traction.0.x` | a dead load, by its place or its name | stress |
//! | `body_force.y` | | force per volume |
//! | `support.NAME.x` | what a support prescribes | length |

use std::fmt;
use std::str::FromStr;

use super::goal::{Malformed, axis, axis_name};

/// What a goal is differentiated by.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Parameter {
    /// A constant of the law of a group of cells, by its key in the scene.
    Material {
        /// The group.
        group: String,
        /// The key.
        constant: String,
    },
    /// A component of an obstacle's pose.
    Pose {
        /// The obstacle.
        obstacle: String,
        /// 0 to 2 along an axis, 3 to 5 about one.
        axis: u8,
    },
    /// What an obstacle is pushed by, whose pose follows from it.
    Push {
        /// The obstacle.
        obstacle: String,
        /// 0 to 2 force, 3 to 5 moment.
        axis: u8,
    },
    /// A number of an obstacle's shape, by its key in the scene.
    Shape {
        /// The obstacle.
        obstacle: String,
        /// The key; of points with the axis, `centre.x`.
        key: String,
    },
    /// An obstacle's coefficient of friction.
    Friction {
        /// The obstacle.
        obstacle: String,
    },
    /// The given bound of an obstacle's tractions.
    Tresca {
        /// The obstacle.
        obstacle: String,
    },
    /// The coefficient of friction of a contact between bodies.
    ContactFriction {
        /// The contact.
        contact: String,
    },
    /// The given bound of the tractions of a contact between bodies.
    ContactTresca {
        /// The contact.
        contact: String,
    },
    /// The factor of all loads.
    Load,
    /// The places of all vertices.
    Mesh,
    /// A follower pressure.
    Pressure {
        /// Its place among the pressures of the scene.
        index: usize,
    },
    /// The pressure of a fluid.
    Fluid {
        /// The fluid.
        fluid: String,
    },
    /// A component of a dead load.
    Traction {
        /// Its name, or its place among the tractions of the scene.
        item: String,
        /// 0 to 2.
        axis: u8,
    },
    /// A component of the force per volume.
    BodyForce {
        /// 0 to 2.
        axis: u8,
    },
    /// A component of what a support is pushed by, whose displacement follows from it.
    SupportPush {
        /// The support.
        support: String,
        /// 0 to 2.
        axis: u8,
    },
    /// A component that a support prescribes.
    Support {
        /// The support.
        support: String,
        /// 0 to 2.
        axis: u8,
    },
}

/// The form of parameters, for messages.
const FORM: &str = "material.GROUP.KEY, obstacle.NAME.KEY, contact.NAME.KEY, support.NAME.AXIS, pressure.NUMBER, \
                    fluid.NAME.pressure, traction.NAME.AXIS, body_force.AXIS, mesh or load";

/// Keys of an obstacle with an axis that are not its shape's, and their first axis.
const MOTIONS: [(&str, u8); 4] = [
    ("translation", 0),
    ("rotation", 3),
    ("force", 0),
    ("moment", 3),
];

impl FromStr for Parameter {
    type Err = Malformed;

    fn from_str(text: &str) -> Result<Self, Malformed> {
        parsed(text).ok_or_else(|| Malformed {
            text: text.to_owned(),
            expected: FORM,
        })
    }
}

fn parsed(text: &str) -> Option<Parameter> {
    if text == "load" {
        return Some(Parameter::Load);
    }
    if text == "mesh" {
        return Some(Parameter::Mesh);
    }
    let (kind, rest) = text.split_once('.')?;
    match kind {
        "material" => {
            let (group, constant) = with_key(rest, |last| last.parse::<usize>().is_ok())?;
            Some(Parameter::Material { group, constant })
        }
        "obstacle" => of_obstacle(rest),
        "contact" => of_contact(rest),
        "support" => {
            let (support, last) = rest.rsplit_once('.')?;
            let axis = axis(last)?;
            Some(match support.strip_suffix(".force") {
                Some(name) => Parameter::SupportPush {
                    support: name.to_owned(),
                    axis,
                },
                None => Parameter::Support {
                    support: support.to_owned(),
                    axis,
                },
            })
        }
        "pressure" => Some(Parameter::Pressure {
            index: rest.parse().ok()?,
        }),
        "fluid" => {
            let name = rest.strip_suffix(".pressure")?;
            (!name.is_empty()).then(|| Parameter::Fluid {
                fluid: name.to_owned(),
            })
        }
        "traction" => {
            let (item, last) = rest.rsplit_once('.')?;
            Some(Parameter::Traction {
                item: item.to_owned(),
                axis: axis(last)?,
            })
        }
        "body_force" => Some(Parameter::BodyForce { axis: axis(rest)? }),
        _ => None,
    }
}

/// A name and the key after it, whose last part belongs to the one before where `is_part`.
fn with_key(text: &str, is_part: impl Fn(&str) -> bool) -> Option<(String, String)> {
    let (before, last) = text.rsplit_once('.')?;
    let (name, key) = match before.rsplit_once('.').filter(|_| is_part(last)) {
        Some((name, key)) => (name, format!("{key}.{last}")),
        None => (before, last.to_owned()),
    };
    (!name.is_empty() && !key.is_empty()).then(|| (name.to_owned(), key))
}

fn of_obstacle(text: &str) -> Option<Parameter> {
    let (obstacle, key) = with_key(text, |last| axis(last).is_some())?;
    let motion = key.split_once('.').and_then(|(key, last)| {
        let (key, first) = MOTIONS.into_iter().find(|(name, _)| *name == key)?;
        Some((key, first + axis(last)?))
    });
    Some(match motion {
        Some(("translation" | "rotation", axis)) => Parameter::Pose { obstacle, axis },
        Some((_, axis)) => Parameter::Push { obstacle, axis },
        None if key == "friction" => Parameter::Friction { obstacle },
        None if key == "tresca" => Parameter::Tresca { obstacle },
        None => Parameter::Shape { obstacle, key },
    })
}

fn of_contact(text: &str) -> Option<Parameter> {
    let (name, key) = text.rsplit_once('.').filter(|(name, _)| !name.is_empty())?;
    let contact = name.to_owned();
    match key {
        "friction" => Some(Parameter::ContactFriction { contact }),
        "tresca" => Some(Parameter::ContactTresca { contact }),
        _ => None,
    }
}

impl fmt::Display for Parameter {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let of_six = |[along, about]: [&'static str; 2], axis: u8| {
            let half = if axis < 3 { along } else { about };
            format!("{half}.{}", axis_name(axis % 3))
        };
        match self {
            Self::Material { group, constant } => write!(out, "material.{group}.{constant}"),
            Self::Pose { obstacle, axis } => {
                let key = of_six(["translation", "rotation"], *axis);
                write!(out, "obstacle.{obstacle}.{key}")
            }
            Self::Push { obstacle, axis } => {
                let key = of_six(["force", "moment"], *axis);
                write!(out, "obstacle.{obstacle}.{key}")
            }
            Self::Shape { obstacle, key } => write!(out, "obstacle.{obstacle}.{key}"),
            Self::Friction { obstacle } => write!(out, "obstacle.{obstacle}.friction"),
            Self::Tresca { obstacle } => write!(out, "obstacle.{obstacle}.tresca"),
            Self::ContactFriction { contact } => write!(out, "contact.{contact}.friction"),
            Self::ContactTresca { contact } => write!(out, "contact.{contact}.tresca"),
            Self::Load => write!(out, "load"),
            Self::Mesh => write!(out, "mesh"),
            Self::Pressure { index } => write!(out, "pressure.{index}"),
            Self::Fluid { fluid } => write!(out, "fluid.{fluid}.pressure"),
            Self::Traction { item, axis } => write!(out, "traction.{item}.{}", axis_name(*axis)),
            Self::BodyForce { axis } => write!(out, "body_force.{}", axis_name(*axis)),
            Self::SupportPush { support, axis } => {
                write!(out, "support.{support}.force.{}", axis_name(*axis))
            }
            Self::Support { support, axis } => {
                write!(out, "support.{support}.{}", axis_name(*axis))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parameter_reads_what_it_writes() {
        for text in [
            "material.body.c10",
            "material.left.half.mu.0",
            "obstacle.ball.translation.y",
            "obstacle.the.ball.rotation.z",
            "obstacle.ball.radius",
            "obstacle.ball.centre.x",
            "obstacle.lid.force.y",
            "obstacle.lid.friction",
            "obstacle.lid.tresca",
            "contact.ring.friction",
            "contact.back-up.ring.tresca",
            "load",
            "mesh",
            "pressure.0",
            "fluid.oil.pressure",
            "traction.side.x",
            "body_force.z",
            "support.base.x",
            "support.base.force.x",
        ] {
            assert_eq!(
                text.parse::<Parameter>().expect("a parameter").to_string(),
                text
            );
        }
    }

    #[test]
    fn what_is_no_parameter_is_refused_with_its_text() {
        for text in [
            "",
            "loads",
            "material.c10",
            "pressure.x",
            "contact.friction",
            "contact.ring.carries",
            "fluid.oil",
            "fluid.pressure",
            "support.base",
            "body_force.w",
        ] {
            let error = text
                .parse::<Parameter>()
                .expect_err("no parameter")
                .to_string();
            assert!(error.contains(&format!("`{text}`")), "{error}");
        }
    }
}
