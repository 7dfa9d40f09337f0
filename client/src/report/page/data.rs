//! What the page is made of, as its script reads it.

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::Value;
use signorini_proto::v1;

use super::fluid::{self, Leak, Wet};
use super::lines::{
    BodyContact, Goal, Interval, Iteration, Lines, Obstacle, Step, Support, Tie, Warning,
};
use super::surface::Picture;
use crate::report::path_csv;
use crate::report::table::{self, cause};
use crate::report::travel::Travels;

/// Increments, and points of the residual, that a page shows at most.
const MOST_STEPS: usize = 500;
const MOST_POINTS: usize = 3000;
/// Points that it shows of the pressure along one interval at most.
const MOST_PATH_POINTS: usize = 1000;

/// Difference of equal times, in steps.
const SAME_TIME: f64 = 1e-9;

/// Rows along the surface by obstacle and interval.
type Paths = BTreeMap<(String, usize), Vec<path_csv::Row>>;

/// The whole page.
#[derive(Debug, Serialize)]
pub(super) struct Page {
    version: &'static str,
    plan: Value,
    summary: Value,
    /// The increments that are shown, the last one among them.
    steps: Vec<Row>,
    /// All increments of the run.
    step_count: usize,
    /// Each doubt once, with the first increment that has it.
    warnings: Vec<String>,
    convergence: Vec<Point>,
    /// Meshes on the way to this one.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    rounds: Vec<Value>,
    picture: Option<Picture>,
    /// Of the last increment with fields, the longest first.
    paths: Vec<Path>,
    /// Of the same increment.
    leaks: Vec<Leak>,
}

/// Contact pressure along an interval of contact.
#[derive(Debug, Serialize)]
struct Path {
    obstacle: String,
    interval: usize,
    length: f64,
    /// Arc length, pressure, place x, y.
    points: Vec<[f64; 4]>,
}

/// One increment.
#[derive(Debug, Serialize)]
struct Row {
    step: i64,
    increment: i64,
    time: f64,
    load: f64,
    termination: String,
    cause: Option<String>,
    why: Option<&'static str>,
    place: Option<Value>,
    snapped: Option<Value>,
    rounds: i64,
    iterations: i64,
    cut_backs: i64,
    attempts: Vec<Value>,
    touching: i64,
    energy: Option<f64>,
    volume_ratio: Option<f64>,
    min_jacobian: Option<f64>,
    stability: Option<String>,
    penetration: Option<f64>,
    residual: Option<f64>,
    tolerance: f64,
    error: Option<f64>,
    seconds: f64,
    obstacles: BTreeMap<String, Pressed>,
    supports: BTreeMap<String, Reaction>,
    probes: BTreeMap<String, (Vec<f64>, Option<f64>)>,
    fluids: BTreeMap<String, Wet>,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    goals: BTreeMap<String, Goal>,
    #[serde(skip_serializing_if = "Option::is_none")]
    goals_refused: Option<String>,
    contacts: BTreeMap<String, BodyContact>,
    ties: BTreeMap<String, Tie>,
}

/// An obstacle in one increment.
#[derive(Debug, Serialize)]
struct Pressed {
    /// Along its travel; its size where it stands still.
    along: f64,
    travel: Option<f64>,
    /// How far it is off the line of its travel.
    aside: f64,
    error: Option<f64>,
    force: Vec<f64>,
    area: f64,
    pressure: f64,
    centre: Vec<f64>,
    deformed_area: Option<f64>,
    width: Option<f64>,
    intervals: Vec<Interval>,
    mean: Option<f64>,
    peak: Option<f64>,
    /// Where the peak is; empty without contact.
    place: Vec<f64>,
}

/// What a support does to the body in one increment.
#[derive(Debug, Serialize)]
struct Reaction {
    force: Vec<f64>,
    moment: Vec<f64>,
    translation: Vec<f64>,
    rotation: Vec<f64>,
}

/// A point of the residual: iterations of the run so far, the residual, the increment.
type Point = (i64, f64, String);

/// The page of a run.
pub(super) fn of(lines: &Lines, picture: Option<Picture>, paths: Paths) -> Page {
    let travels = travels(&lines.steps);
    let time = shown(lines, picture.as_ref());
    let mut steps = lines.steps.iter().rev();
    let drawn = steps.find(|step| (step.time - time).abs() < SAME_TIME);
    Page {
        version: env!("CARGO_PKG_VERSION"),
        plan: lines.plan.clone(),
        summary: lines.summary.clone(),
        steps: thinned(&lines.steps, MOST_STEPS)
            .map(|step| row(step, &travels))
            .collect(),
        step_count: lines.steps.len(),
        warnings: warnings(lines),
        convergence: convergence(&lines.iterations),
        paths: longest_first(paths, time),
        leaks: drawn.map(fluid::leaks).unwrap_or_default(),
        rounds: lines.rounds.clone(),
        picture,
    }
}

/// Time of the increment whose fields are shown.
fn shown(lines: &Lines, picture: Option<&Picture>) -> f64 {
    let last = lines.steps.last().map_or(0.0, |step| step.time);
    picture.map_or(last, |picture| picture.time)
}

/// The paths of that time: none where contact had ended by then.
fn longest_first(mut paths: Paths, time: f64) -> Vec<Path> {
    paths.retain(|_, rows| rows.iter().all(|row| (row.time - time).abs() < SAME_TIME));
    let path = |((obstacle, interval), rows): ((String, usize), Vec<path_csv::Row>)| Path {
        obstacle,
        interval,
        length: rows.last().map_or(0.0, |row| row.arc_length)
            - rows.first().map_or(0.0, |row| row.arc_length),
        points: thinned(&rows, MOST_PATH_POINTS)
            .map(|row| [row.arc_length, row.pressure, row.x, row.y])
            .collect(),
    };
    let mut paths: Vec<Path> = paths.into_iter().map(path).collect();
    paths.sort_by(|a, b| b.length.total_cmp(&a.length));
    paths
}

/// At most so many, evenly, the last one always.
fn thinned<T>(all: &[T], most: usize) -> impl Iterator<Item = &T> {
    let stride = all.len().div_ceil(most).max(1);
    let last = all.len().saturating_sub(1) % stride;
    all.iter().skip(last).step_by(stride)
}

fn travels(steps: &[Step]) -> Travels {
    let mut travels = Travels::default();
    for (name, obstacle) in steps.iter().flat_map(|step| &step.obstacles) {
        travels.learn(name, &obstacle.pose.translation);
    }
    travels
}

fn row(step: &Step, travels: &Travels) -> Row {
    let known = |name: &String| v1::Cause::from_str_name(&format!("CAUSE_{}", name.to_uppercase()));
    Row {
        step: step.step,
        increment: step.increment,
        time: step.time,
        load: step.load,
        termination: step.termination.clone(),
        cause: step.cause.clone(),
        why: step.cause.as_ref().and_then(known).and_then(cause),
        place: step.cause_site.clone(),
        snapped: step.snapped.clone(),
        rounds: step.sqp_iterations,
        iterations: step.krylov_iterations,
        cut_backs: step.cut_backs,
        attempts: step.attempts.clone(),
        touching: step.active_vertices,
        energy: step.strain_energy,
        volume_ratio: step.volume_ratio,
        min_jacobian: step.min_jacobian,
        stability: step.stability.clone(),
        penetration: step.max_penetration,
        residual: step.residuals.map(|residuals| residuals.largest()),
        tolerance: step.tolerance,
        error: step.error_estimate,
        seconds: step.seconds.total,
        obstacles: step
            .obstacles
            .iter()
            .map(|(name, obstacle)| (name.clone(), pressed(name, obstacle, travels)))
            .collect(),
        supports: step
            .supports
            .iter()
            .map(|(name, support)| (name.clone(), reaction(support)))
            .collect(),
        probes: step
            .probes
            .iter()
            .map(|(name, probe)| (name.clone(), (probe.displacement.clone(), probe.pressure)))
            .collect(),
        fluids: fluid::wet(&step.fluids),
        goals: step.goals.clone(),
        goals_refused: step.goals_refused.clone(),
        contacts: step.contacts.clone(),
        ties: step.ties.clone(),
    }
}

fn reaction(support: &Support) -> Reaction {
    Reaction {
        force: support.force.clone(),
        moment: support.moment.clone(),
        translation: support.translation.clone(),
        rotation: support.rotation.clone(),
    }
}

fn pressed(name: &str, obstacle: &Obstacle, travels: &Travels) -> Pressed {
    let translation = obstacle.pose.translation.as_slice();
    let travel = travels.along(name, translation);
    let squared = |values: &[f64]| values.iter().map(|x| x * x).sum::<f64>();
    let aside = squared(translation) - travel.unwrap_or_default().powi(2);
    Pressed {
        along: travels
            .along(name, &obstacle.force)
            .unwrap_or_else(|| squared(&obstacle.force).sqrt()),
        travel,
        aside: aside.max(0.0).sqrt(),
        error: obstacle.force_error,
        force: obstacle.force.clone(),
        area: obstacle.contact_area,
        pressure: obstacle.max_pressure,
        centre: obstacle.centre_of_pressure.clone(),
        deformed_area: obstacle.deformed_contact_area,
        width: obstacle.contact_width,
        intervals: obstacle.contact_intervals.clone(),
        mean: obstacle.mean_pressure,
        peak: obstacle.peak_pressure,
        place: obstacle.peak_pressure_place.clone(),
    }
}

/// Texts under `warnings` of a line.
fn texts(line: &Value) -> impl Iterator<Item = String> {
    let warnings = line.get("warnings").and_then(Value::as_array);
    let texts = warnings.into_iter().flatten().filter_map(Value::as_str);
    texts.map(str::to_owned)
}

/// Doubts of the plan and of the run as a whole, then those of the increments, each kind of a
/// subject once.
fn warnings(lines: &Lines) -> Vec<String> {
    let mut told: Vec<String> = texts(&lines.plan).chain(texts(&lines.summary)).collect();
    let mut seen = std::collections::HashSet::new();
    for step in &lines.steps {
        for warning in step
            .warnings
            .iter()
            .filter(|one| is_open(one, &lines.steps))
        {
            if seen.insert((&warning.kind, &warning.subject)) {
                let (number, increment) = (step.step, step.increment);
                let message = &warning.message;
                told.push(format!("Step {number}, increment {increment}: {message}"));
            }
        }
    }
    told
}

/// Whether a doubt remains: an obstacle that is waited for is none once it has been met.
fn is_open(warning: &Warning, steps: &[Step]) -> bool {
    let mut met = steps
        .iter()
        .filter_map(|step| step.obstacles.get(&warning.subject));
    warning.kind != table::UNTOUCHED || !met.any(|obstacle| obstacle.contact_area > 0.0)
}

fn convergence(iterations: &[Iteration]) -> Vec<Point> {
    let mut before = 0;
    let mut last = (0, 0, 0);
    let mut points = Vec::new();
    for one in iterations {
        let increment = (one.step, one.increment);
        if (last.0, last.1) != increment {
            before += last.2;
        }
        last = (one.step, one.increment, one.krylov_iterations);
        let residual = one.residuals.map(|residuals| residuals.largest());
        if let Some(residual) = residual.filter(|residual| *residual > 0.0) {
            let name = format!("{}.{}", one.step, one.increment);
            points.push((before + one.krylov_iterations, residual, name));
        }
    }
    thinned(&points, MOST_POINTS).cloned().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_the_last() {
        let all: Vec<usize> = (0..2503).collect();
        let kept: Vec<usize> = thinned(&all, 1000).copied().collect();
        assert!(kept.len() <= 1000 && kept.len() > 800);
        assert_eq!(kept.last(), Some(&2502));
        let few: Vec<usize> = thinned(&all[..3], 1000).copied().collect();
        assert_eq!(few, [0, 1, 2]);
        assert_eq!(thinned(&all[..0], 1000).count(), 0);
    }

    /// An increment with an untouched obstacle `wall`, which presses on this area.
    fn waiting(increment: i64, area: f64) -> Step {
        let warning = Warning {
            kind: table::UNTOUCHED.to_owned(),
            subject: "wall".to_owned(),
            message: "it waits".to_owned(),
        };
        let obstacle = Obstacle {
            contact_area: area,
            ..Obstacle::default()
        };
        Step {
            increment,
            warnings: if area > 0.0 {
                Vec::new()
            } else {
                vec![warning]
            },
            obstacles: BTreeMap::from([("wall".to_owned(), obstacle)]),
            ..Step::default()
        }
    }

    #[test]
    fn an_obstacle_that_is_waited_for_is_doubted_until_it_is_met() {
        let mut lines = Lines {
            steps: vec![waiting(1, 0.0), waiting(2, 0.0)],
            ..Lines::default()
        };
        assert_eq!(warnings(&lines), ["Step 0, increment 1: it waits"]);
        lines.steps.push(waiting(3, 0.5));
        assert_eq!(warnings(&lines), [""; 0]);
        lines.summary = serde_json::json!({"warnings": ["in all"]});
        assert_eq!(warnings(&lines), ["in all"]);
    }

    #[test]
    fn iterations_count_on_from_increment_to_increment() {
        let residuals = serde_json::from_str(r#"{"equilibrium": 0.5, "gap": null}"#).unwrap();
        let iteration = |increment, krylov_iterations| Iteration {
            step: 1,
            increment,
            krylov_iterations,
            residuals: Some(residuals),
        };
        let points = convergence(&[iteration(1, 3), iteration(1, 9), iteration(2, 4)]);
        let counts: Vec<i64> = points.iter().map(|point| point.0).collect();
        assert_eq!(counts, [3, 9, 13]);
        assert_eq!((points[0].1, points[2].2.as_str()), (0.5, "1.2"));
    }
}
