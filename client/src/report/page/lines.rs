//! The result lines as the page needs them.

use std::collections::BTreeMap;

use serde::{Deserialize, Deserializer, Serialize};
use serde_json::Value;

/// Everything that the lines of a run tell.
#[derive(Debug, Default)]
pub(super) struct Lines {
    /// As it was written; null before it came.
    pub(super) plan: Value,
    pub(super) steps: Vec<Step>,
    pub(super) iterations: Vec<Iteration>,
    /// Meshes on the way to the one that is solved, as they were written.
    pub(super) rounds: Vec<Value>,
    /// As it was written; null for a run that was cut off.
    pub(super) summary: Value,
}

/// One increment.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Step {
    pub(super) step: i64,
    pub(super) increment: i64,
    #[serde(deserialize_with = "number")]
    pub(super) time: f64,
    #[serde(deserialize_with = "number")]
    pub(super) load: f64,
    pub(super) termination: String,
    pub(super) cause: Option<String>,
    pub(super) cause_site: Option<Value>,
    pub(super) snapped: Option<Value>,
    pub(super) warnings: Vec<Warning>,
    pub(super) sqp_iterations: i64,
    pub(super) krylov_iterations: i64,
    pub(super) cut_backs: i64,
    pub(super) attempts: Vec<Value>,
    pub(super) active_vertices: i64,
    pub(super) strain_energy: Option<f64>,
    pub(super) volume_ratio: Option<f64>,
    pub(super) min_jacobian: Option<f64>,
    pub(super) stability: Option<String>,
    pub(super) max_penetration: Option<f64>,
    pub(super) residuals: Option<Residuals>,
    #[serde(deserialize_with = "number")]
    pub(super) tolerance: f64,
    pub(super) obstacles: BTreeMap<String, Obstacle>,
    pub(super) supports: BTreeMap<String, Support>,
    pub(super) probes: BTreeMap<String, Probe>,
    pub(super) fluids: BTreeMap<String, Fluid>,
    pub(super) goals: BTreeMap<String, Goal>,
    pub(super) goals_refused: Option<String>,
    pub(super) contacts: BTreeMap<String, BodyContact>,
    pub(super) ties: BTreeMap<String, Tie>,
    pub(super) error_estimate: Option<f64>,
    pub(super) seconds: Seconds,
}

/// What a mechanic would doubt.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Warning {
    pub(super) kind: String,
    pub(super) subject: String,
    pub(super) message: String,
}

/// What an obstacle does to the body.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Obstacle {
    #[serde(deserialize_with = "numbers")]
    pub(super) force: Vec<f64>,
    pub(super) force_error: Option<f64>,
    #[serde(deserialize_with = "number")]
    pub(super) contact_area: f64,
    #[serde(deserialize_with = "number")]
    pub(super) max_pressure: f64,
    #[serde(deserialize_with = "numbers")]
    pub(super) centre_of_pressure: Vec<f64>,
    pub(super) deformed_contact_area: Option<f64>,
    pub(super) contact_width: Option<f64>,
    pub(super) contact_intervals: Vec<Interval>,
    pub(super) mean_pressure: Option<f64>,
    pub(super) peak_pressure: Option<f64>,
    #[serde(deserialize_with = "numbers")]
    pub(super) peak_pressure_place: Vec<f64>,
    pub(super) pose: Pose,
}

/// Contact without a break along a section.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(default)]
pub(super) struct Interval {
    #[serde(deserialize_with = "numbers")]
    pub(super) start: Vec<f64>,
    #[serde(deserialize_with = "numbers")]
    pub(super) end: Vec<f64>,
    pub(super) width: Option<f64>,
    #[serde(deserialize_with = "numbers")]
    pub(super) force: Vec<f64>,
}

/// Reaction of a support.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Support {
    #[serde(deserialize_with = "numbers")]
    pub(super) force: Vec<f64>,
    #[serde(deserialize_with = "numbers")]
    pub(super) moment: Vec<f64>,
    #[serde(deserialize_with = "numbers")]
    pub(super) translation: Vec<f64>,
    #[serde(deserialize_with = "numbers")]
    pub(super) rotation: Vec<f64>,
}

/// Values at a probe.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Probe {
    #[serde(deserialize_with = "numbers")]
    pub(super) displacement: Vec<f64>,
    pub(super) pressure: Option<f64>,
}

/// A contact between bodies, as the page shows it too.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(default)]
pub(super) struct BodyContact {
    #[serde(deserialize_with = "numbers")]
    pub(super) force: Vec<f64>,
    pub(super) contact_width: Option<f64>,
    pub(super) mean_pressure: Option<f64>,
    pub(super) peak_pressure: Option<f64>,
}

/// A tie between bodies, as the page shows it too.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(default)]
pub(super) struct Tie {
    #[serde(deserialize_with = "numbers")]
    pub(super) force: Vec<f64>,
    #[serde(deserialize_with = "numbers")]
    pub(super) moment: Vec<f64>,
    pub(super) peak_traction: Option<f64>,
}

/// A fluid.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Fluid {
    pub(super) pressure: Option<f64>,
    pub(super) tightness: String,
    pub(super) blow_off_low: Option<f64>,
    pub(super) blow_off_high: Option<f64>,
    pub(super) wet_area: Option<f64>,
    pub(super) flow_rate: Option<f64>,
    #[serde(deserialize_with = "numbers")]
    pub(super) force: Vec<f64>,
    pub(super) leak_path: Option<LeakPath>,
}

/// The path on which a fluid leaks first.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct LeakPath {
    pub(super) margin: Option<f64>,
    pub(super) margin_over_pressure: Option<f64>,
    pub(super) sealed_width: Option<f64>,
    pub(super) points: Vec<[f64; 3]>,
}

/// A goal with its error and its derivatives.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(default)]
pub(super) struct Goal {
    pub(super) value: Option<f64>,
    pub(super) derivatives: BTreeMap<String, Option<f64>>,
    pub(super) bound: Option<GoalBound>,
}

/// Parts of the bound of its error.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(default)]
pub(super) struct GoalBound {
    pub(super) total: Option<f64>,
    pub(super) mesh: Option<f64>,
    pub(super) solver: Option<f64>,
    pub(super) geometry: Option<f64>,
    pub(super) estimate: Option<f64>,
}

/// Where an obstacle is.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Pose {
    #[serde(deserialize_with = "numbers")]
    pub(super) translation: Vec<f64>,
}

/// The four criteria.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Residuals {
    equilibrium: Option<f64>,
    incompressibility: Option<f64>,
    complementarity: Option<f64>,
    gap: Option<f64>,
}

impl Residuals {
    /// The one that decides.
    pub(super) fn largest(&self) -> f64 {
        let all = [
            self.equilibrium,
            self.incompressibility,
            self.complementarity,
            self.gap,
        ];
        all.into_iter().flatten().fold(0.0, f64::max)
    }
}

/// Of an increment.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Seconds {
    #[serde(deserialize_with = "number")]
    pub(super) total: f64,
}

/// One iteration on the way.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Iteration {
    pub(super) step: i64,
    pub(super) increment: i64,
    pub(super) krylov_iterations: i64,
    pub(super) residuals: Option<Residuals>,
}

/// What was not finite is null in the lines.
fn number<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(from)?.unwrap_or_default())
}

fn numbers<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<f64>, D::Error> {
    let numbers = Vec::<Option<f64>>::deserialize(from)?;
    Ok(numbers.into_iter().map(Option::unwrap_or_default).collect())
}

/// The kind of a line.
#[derive(Deserialize)]
struct Head<'a> {
    #[serde(borrow)]
    event: std::borrow::Cow<'a, str>,
}

/// Reads result lines; a last line that was cut off is left out.
///
/// # Errors
/// The number of the first line that is none, and why.
pub(super) fn read(text: &str) -> Result<Lines, String> {
    let mut lines = Lines::default();
    let mut rest = text.lines().enumerate().peekable();
    while let Some((index, line)) = rest.next() {
        let is_cut = rest.peek().is_none() && !text.ends_with('\n');
        match lines.take(line) {
            Err(_) if is_cut => {}
            Err(error) => return Err(format!("line {} is no result line: {error}", index + 1)),
            Ok(()) => {}
        }
    }
    if lines.steps.is_empty() {
        Err("no increment has been finished".to_owned())
    } else {
        Ok(lines)
    }
}

impl Lines {
    fn take(&mut self, line: &str) -> serde_json::Result<()> {
        let head: Head<'_> = serde_json::from_str(line)?;
        match head.event.as_ref() {
            "plan" => self.plan = serde_json::from_str(line)?,
            "iteration" => self.iterations.push(serde_json::from_str(line)?),
            "round" => self.rounds.push(serde_json::from_str(line)?),
            "step" => self.steps.push(serde_json::from_str(line)?),
            "summary" => self.summary = serde_json::from_str(line)?,
            _ => {}
        }
        Ok(())
    }
}
