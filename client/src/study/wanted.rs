//! Values that a study takes from the results of a case: a path into the line of an increment,
//! and of which increment.
//!
//! Parts of a path are keys and positions of lists, `x`, `y`, `z` for the first three:
//! `obstacles.ball.force.z`. Names with dots are found too: the longest key that fits is taken.

use std::str::FromStr;

use serde::{Deserialize, Serialize};
use serde_json::Value;
use signorini_proto::v1;

use super::asked::goals;
use crate::library::result_line;

/// Of which increments, or what of them all.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum At {
    /// The last one.
    Last,
    /// All, as a list.
    Every,
    /// The largest number.
    Max,
    /// The smallest number.
    Min,
    /// The sum of the numbers.
    Sum,
}

/// A value of each case.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq, Serialize)]
pub struct Wanted {
    /// Its column.
    pub name: String,
    /// Where it stands in a result line of the event `step`.
    pub of: String,
    /// Of which increments.
    pub at: At,
}

impl FromStr for At {
    type Err = String;

    fn from_str(word: &str) -> Result<Self, String> {
        match word {
            "last" => Ok(Self::Last),
            "every" => Ok(Self::Every),
            "max" => Ok(Self::Max),
            "min" => Ok(Self::Min),
            "sum" => Ok(Self::Sum),
            other => Err(format!(
                "\"{other}\" is not known; known are last, every, max, min, sum"
            )),
        }
    }
}

impl std::fmt::Display for At {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.write_str(match self {
            Self::Last => "last",
            Self::Every => "every",
            Self::Max => "max",
            Self::Min => "min",
            Self::Sum => "sum",
        })
    }
}

impl Wanted {
    /// The forces of the obstacles of a scene, and its goals with their bounds and derivatives, for
    /// studies that name nothing.
    pub(crate) fn forces(scene: &v1::Scene) -> Vec<Self> {
        let forces = scene.obstacles.iter().flat_map(|obstacle| {
            let axes = ["x", "y", "z"].into_iter();
            axes.map(|axis| format!("obstacles.{}.force.{axis}", obstacle.name))
        });
        let wanted = |of: String| Self {
            name: of.clone(),
            of,
            at: At::Last,
        };
        let goals = goals(scene);
        let answers = goals.iter().flat_map(|(name, goal)| {
            let derivatives = goal.derivatives.keys();
            let derivatives = derivatives.map(|parameter| format!("derivatives.{parameter}"));
            let bound = goal.bound.map(|_| "bound.total".to_owned());
            let columns = ["value".to_owned()]
                .into_iter()
                .chain(bound)
                .chain(derivatives);
            columns.map(move |column| format!("goals.{name}.{column}"))
        });
        forces.chain(answers).map(wanted).collect()
    }

    /// What is wrong with its path for a scene, if something is.
    pub(crate) fn fault(&self, scene: &v1::Scene) -> Option<String> {
        match find(&blank(scene), &self.of) {
            Ok(Value::Object(keys)) => {
                let keys: Vec<&str> = keys.keys().map(String::as_str).collect();
                Some(format!("has several values: {}", keys.join(", ")))
            }
            Ok(_) => None,
            Err(fault) => Some(fault),
        }
    }
}

/// The line of a result that has all names of a scene and no numbers.
fn blank(scene: &v1::Scene) -> Value {
    let obstacles = scene.obstacles.iter().map(|one| &one.name).cloned();
    let supports = scene.supports.iter().map(|one| one.name.clone());
    let probes = scene.probes.iter().map(|one| one.name.clone());
    let fluids = scene.fluids.iter().map(|one| one.name.clone());
    let wet = || v1::FluidResult {
        leak_path: Some(v1::LeakPath::default()),
        ..Default::default()
    };
    let pose = |name| v1::ObstaclePose {
        name,
        ..Default::default()
    };
    result_line::step(&v1::StepReport {
        obstacle_poses: obstacles.clone().map(pose).collect(),
        obstacles: obstacles.map(|name| (name, Default::default())).collect(),
        supports: supports.map(|name| (name, Default::default())).collect(),
        probes: probes.map(|name| (name, Default::default())).collect(),
        fluids: fluids.map(|name| (name, wet())).collect(),
        goals: goals(scene),
        seconds: Some(v1::Seconds::default()),
        residuals: Some(v1::Residuals::default()),
        ..Default::default()
    })
}

/// The value at a path; null where a list is too short or a value is null on the way.
fn find(line: &Value, path: &str) -> Result<Value, String> {
    let (mut value, mut rest) = (line, path);
    while !rest.is_empty() {
        (value, rest) = match value {
            Value::Object(keys) => {
                let fits = keys
                    .iter()
                    .filter_map(|(key, value)| Some((value, after(rest, key)?)));
                let found = fits.min_by_key(|(_, rest)| rest.len());
                found.ok_or_else(|| unknown(rest, keys))?
            }
            Value::Array(values) => {
                let (part, rest) = rest.split_once('.').unwrap_or((rest, ""));
                let found = values.get(position(part)?);
                (found.unwrap_or(&Value::Null), rest)
            }
            Value::Null => return Ok(Value::Null),
            Value::Bool(_) | Value::Number(_) | Value::String(_) => {
                return Err(format!("\"{rest}\" lies inside a single value"));
            }
        };
    }
    Ok(value.clone())
}

/// What follows a key at the front of a path.
fn after<'a>(path: &'a str, key: &str) -> Option<&'a str> {
    let rest = path.strip_prefix(key)?;
    if rest.is_empty() {
        return Some(rest);
    }
    rest.strip_prefix('.')
}

fn unknown(rest: &str, keys: &serde_json::Map<String, Value>) -> String {
    let part = rest.split('.').next().unwrap_or(rest);
    let keys: Vec<&str> = keys.keys().map(String::as_str).collect();
    if keys.is_empty() {
        format!("there is no \"{part}\": there is nothing")
    } else {
        format!("there is no \"{part}\"; there are {}", keys.join(", "))
    }
}

fn position(part: &str) -> Result<usize, String> {
    match part {
        "x" => Ok(0),
        "y" => Ok(1),
        "z" => Ok(2),
        other => other
            .parse()
            .map_err(|_| format!("\"{other}\" is no position in a list: x, y, z, or one from 0")),
    }
}

/// The values of a case under way.
#[derive(Debug)]
pub struct Gathered<'a> {
    wanted: &'a [Wanted],
    values: Vec<Value>,
}

impl<'a> Gathered<'a> {
    /// Before the first increment.
    pub fn new(wanted: &'a [Wanted]) -> Self {
        let start = |one: &Wanted| match one.at {
            At::Every => Value::Array(Vec::new()),
            At::Last | At::Max | At::Min | At::Sum => Value::Null,
        };
        let values = wanted.iter().map(start).collect();
        Self { wanted, values }
    }

    /// Takes the result of an increment.
    pub fn see(&mut self, report: &v1::StepReport) {
        let line = result_line::step(report);
        for (wanted, value) in self.wanted.iter().zip(&mut self.values) {
            // What was checked for the scene may lack in a result: null.
            let new = find(&line, &wanted.of).unwrap_or_default();
            join(wanted.at, value, new);
        }
    }

    /// One value for each that is wanted.
    pub fn finish(self) -> Vec<Value> {
        self.values
    }
}

fn join(at: At, value: &mut Value, new: Value) {
    if let (At::Every, Value::Array(all)) = (at, &mut *value) {
        all.push(new);
        return;
    }
    let (Some(old), Some(number)) = (value.as_f64(), new.as_f64()) else {
        if at == At::Last || value.is_null() {
            *value = new;
        }
        return;
    };
    let joined = match at {
        At::Last | At::Every => number,
        At::Max => old.max(number),
        At::Min => old.min(number),
        At::Sum => old + number,
    };
    *value = Value::from(joined);
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    fn wanted(of: &str, at: At) -> Wanted {
        let (name, of) = (of.to_owned(), of.to_owned());
        Wanted { name, of, at }
    }

    fn scene() -> v1::Scene {
        let obstacle = v1::Obstacle {
            name: "ball.big".to_owned(),
            ..Default::default()
        };
        let water = v1::Fluid {
            name: "water".to_owned(),
            ..Default::default()
        };
        v1::Scene {
            obstacles: vec![obstacle],
            fluids: vec![water],
            ..Default::default()
        }
    }

    fn report(force: f64) -> v1::StepReport {
        let result = v1::ObstacleResult {
            force: vec![0.0, 0.0, force],
            ..Default::default()
        };
        v1::StepReport {
            obstacles: BTreeMap::from([("ball.big".to_owned(), result)]),
            ..Default::default()
        }
    }

    #[test]
    fn values_are_those_of_the_last_increment_or_of_all() {
        let path = "obstacles.ball.big.force.z";
        let all = [At::Last, At::Max, At::Min, At::Sum, At::Every].map(|at| wanted(path, at));
        let mut gathered = Gathered::new(&all);
        for force in [-1.0, 3.0, 2.0] {
            gathered.see(&report(force));
        }
        let text: Vec<String> = gathered.finish().iter().map(Value::to_string).collect();
        assert_eq!(text, ["2.0", "3.0", "-1.0", "4.0", "[-1.0,3.0,2.0]"]);
    }

    #[test]
    fn paths_that_lead_nowhere_say_what_there_is() {
        let fault = |of: &str| wanted(of, At::Last).fault(&scene());
        for good in [
            "strain_energy",
            "obstacles.ball.big.force.2",
            "cause",
            "error_estimate",
            "seconds.total",
            "residuals.gap",
            "obstacles.ball.big.pose.translation.z",
            "fluids.water.blow_off_low",
            "fluids.water.leak_path.margin",
        ] {
            assert_eq!(fault(good), None, "{good}");
        }
        for (wrong, said) in [
            ("obstacles.bell.force.z", "there are ball.big"),
            ("obstacles.ball.big", "several values: force"),
            ("obstacles.ball.big.force.up", "no position"),
            ("strain_energy.x", "inside a single value"),
            ("probes.tip.pressure", "there is nothing"),
        ] {
            let fault = fault(wrong).unwrap_or_default();
            assert!(fault.contains(said), "{wrong}: {fault}");
        }
    }

    #[test]
    fn goals_of_the_scene_are_columns_of_studies_that_name_none() {
        let texts = |all: &[&str]| all.iter().map(|&one| one.to_owned()).collect();
        let scene = v1::Scene {
            gradients: vec![v1::Gradient {
                of: texts(&["force.ball.z"]),
                to: texts(&["material.body.c10", "load"]),
                at: 0,
            }],
            accuracy: Some(v1::Accuracy {
                bound: texts(&["force.ball.z"]),
                ..Default::default()
            }),
            ..Default::default()
        };
        let all = Wanted::forces(&scene);
        let names: Vec<&str> = all.iter().map(|one| one.name.as_str()).collect();
        let expected = [
            "goals.force.ball.z.value",
            "goals.force.ball.z.bound.total",
            "goals.force.ball.z.derivatives.load",
            "goals.force.ball.z.derivatives.material.body.c10",
        ];
        assert_eq!(names, expected);
        assert!(all.iter().all(|one| one.fault(&scene).is_none()));
        let none = v1::Scene::default();
        assert!(all[0].fault(&none).is_some());
    }
}
