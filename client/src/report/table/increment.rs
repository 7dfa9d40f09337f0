//! The parts of one increment's result.

use signorini_proto::{v1, words};

use super::plan::unknowns;
use super::{Lines, cause};
use crate::report::travel::Travels;
use crate::terminal::text::{bytes, number, percent, vector, with_error};

/// How it ended, and why.
pub(super) fn outcome(lines: &mut Lines, report: &v1::StepReport) {
    lines.add("result", &ending(report));
    if let Some(why) = cause(report.cause()) {
        lines.add("why", why);
    }
    if let Some(site) = &report.cause_site {
        lines.add("where", &place(site));
    }
    if let Some(snapped) = &report.snapped {
        lines.add("snapped", &fall(snapped));
    }
    for attempt in &report.attempts {
        lines.add("failed", &tried(attempt));
    }
    for warning in &report.warnings {
        lines.add("warning", &warning.message);
    }
}

fn ending(report: &v1::StepReport) -> String {
    let termination = words::termination(report.termination());
    let cause = words::cause(report.cause());
    let cause = cause.map(|cause| format!(" ({cause})")).unwrap_or_default();
    let (step, increment, load) = (report.step, report.increment, number(report.load));
    format!("{termination}{cause}: step {step}, increment {increment}, load {load}")
}

/// Where a cause lies, in words.
fn place(site: &v1::CauseSite) -> String {
    let point = if site.point.is_empty() {
        "the whole body".to_owned()
    } else {
        format!("at {}", vector(&site.point))
    };
    let motion = if site.motion.is_empty() {
        String::new()
    } else {
        format!(", along {}", vector(&site.motion))
    };
    let key = if site.key.is_empty() {
        String::new()
    } else {
        format!(", nothing balances `{}`", site.key)
    };
    point + &motion + &key
}

/// An attempt that failed, and what followed, in words.
fn tried(attempt: &v1::Attempt) -> String {
    let spaced = |word: String| word.replace('_', " ");
    let strategy = words::strategy(attempt.strategy()).map_or_else(|| "?".to_owned(), spaced);
    let cause = words::cause(attempt.cause()).map_or_else(|| "no cause".to_owned(), spaced);
    let next = words::strategy(attempt.followed_by()).map_or_else(|| "the end".to_owned(), spaced);
    let applications = attempt.preconditioner_applications;
    format!("{strategy} ({cause}, {applications} applications), then {next}")
}

/// A fall to the next minimum in words.
fn fall(snapped: &v1::Snapped) -> String {
    format!(
        "to another equilibrium, up to {} at {}, energy {} less",
        number(snapped.largest_motion),
        vector(&snapped.point),
        number(snapped.energy_drop)
    )
}

/// What obstacles and supports do to the body, and the probes.
pub(super) fn loads(lines: &mut Lines, report: &v1::StepReport, travels: &Travels) {
    for (name, obstacle) in &report.obstacles {
        lines.add(
            &format!("obstacle {name}"),
            &pressed(name, obstacle, report, travels),
        );
        lines.add("", &patch(obstacle));
        if let Some(extent) = extent(obstacle) {
            lines.add("", &extent);
        }
    }
    lines.add_each("friction", report.obstacles.iter().filter_map(friction));
    let supports = report.supports.iter();
    lines.add_each(
        "support",
        supports.map(|(name, support)| (name.as_str(), reaction(support))),
    );
    let probes = report.probes.iter();
    lines.add_each(
        "probe",
        probes.map(|(name, probe)| (name.as_str(), probed(probe))),
    );
}

/// Force and moment of a support, and how it has moved where it has.
fn reaction(support: &v1::SupportResult) -> String {
    let (force, moment) = (vector(&support.force), vector(&support.moment));
    let motions = [
        ("translation", &support.translation),
        ("rotation", &support.rotation),
    ];
    let moved = motions
        .into_iter()
        .filter(|(_, values)| values.iter().any(|&x| x != 0.0));
    let moved = moved.map(|(name, values)| format!(", {name} {}", vector(values)));
    let moved: String = moved.collect();
    format!("force {force}, moment {moment}{moved}")
}

/// The force of an obstacle along its travel, and as a vector.
fn pressed(
    name: &str,
    obstacle: &v1::ObstacleResult,
    report: &v1::StepReport,
    travels: &Travels,
) -> String {
    let error = travels.force_error(name, report);
    let force = with_error(travels.force(name, obstacle), error);
    let along = match travels.distance(name, report) {
        Some(distance) => format!(" along its travel, of {} so far", number(distance)),
        None => String::new(),
    };
    format!("force {force}{along}: {}", vector(&obstacle.force))
}

/// Where and how hard it presses.
fn patch(obstacle: &v1::ObstacleResult) -> String {
    let (area, pressure) = (number(obstacle.contact_area), number(obstacle.max_pressure));
    let undeformed = obstacle.max_pressure_undeformed;
    let undeformed = undeformed.map(|p| format!(" ({} per undeformed area)", number(p)));
    let undeformed = undeformed.unwrap_or_default();
    format!("contact area {area}, pressure {pressure}{undeformed} at most")
}

/// How far contact extends over the deformed surface, and its peak; none without contact.
fn extent(obstacle: &v1::ObstacleResult) -> Option<String> {
    let (area, mean) = (
        number(obstacle.deformed_contact_area),
        number(obstacle.mean_pressure?),
    );
    let width = obstacle.contact_width.map(|width| {
        let count = obstacle.contact_intervals.len();
        let parts = if count > 1 {
            format!(" in {count} intervals")
        } else {
            String::new()
        };
        format!(", width {}{parts}", number(width))
    });
    let (peak, place) = (
        number(obstacle.peak_pressure),
        vector(&obstacle.peak_pressure_place),
    );
    let width = width.unwrap_or_default();
    Some(format!(
        "deformed area {area}{width}, mean pressure {mean}, peak {peak} at {place}"
    ))
}

/// What friction does on an obstacle; none without.
fn friction<'a>((name, obstacle): (&'a String, &v1::ObstacleResult)) -> Option<(&'a str, String)> {
    let counts = [
        obstacle.stick_vertices,
        obstacle.slip_vertices,
        obstacle.open_vertices,
    ];
    let [stick, slip, open] = counts;
    (counts != [0; 3]).then(|| {
        let force = vector(&obstacle.tangential_force);
        let (most, energy) = (
            number(obstacle.max_slip),
            number(obstacle.dissipated_total),
        );
        let value = format!(
            "force {force}, {stick} stick, {slip} slip by {most} at most, {open} open, {energy} dissipated"
        );
        (name.as_str(), value)
    })
}

fn probed(probe: &v1::ProbeResult) -> String {
    let pressure = probe.pressure.map(number);
    let pressure = pressure.map(|pressure| format!(", pressure {pressure}"));
    let displacement = vector(&probe.displacement);
    format!(
        "displacement {displacement}{}",
        pressure.unwrap_or_default()
    )
}

/// The state of the whole body.
pub(super) fn quantities(lines: &mut Lines, report: &v1::StepReport) {
    if let Some(error) = report.error_estimate {
        let error = percent(error);
        lines.add(
            "error estimate",
            &format!("{error} of the deformation, in energy: what the mesh leaves out"),
        );
    }
    if !report.obstacles.is_empty() {
        let depth = number(report.max_penetration);
        lines.add(
            "penetration",
            &format!("{depth} at most, between nodes: it shrinks with the mesh size"),
        );
    }
    if report.left_out.is_empty() {
        lines.add("strain energy", &number(report.strain_energy));
        lines.add("volume ratio", &format!("{:.9}", report.volume_ratio));
    } else {
        lines.add("left out", &report.left_out.join(", "));
    }
    if let Some(least) = report.min_jacobian {
        lines.add("det F", &jacobian(least, report.min_jacobian_bound));
    }
    if let Some(stability) = words::stability(report.stability()) {
        let is_reached = report.termination() == v1::Termination::Converged;
        let label = if is_reached {
            "equilibrium"
        } else {
            "last equilibrium"
        };
        lines.add(label, &equilibrium(&stability));
    }
    if report.penalty > 0.0 {
        lines.add(
            "penalty",
            &format!("{} mu on volume changes", number(report.penalty)),
        );
    }
    if let Some(errors) = &report.errors {
        lines.add("errors", &manufactured(errors));
    }
    if report.verification.is_some() {
        lines.add("verification", &residuals(report.verification.as_ref()));
    }
}

/// Least det F at quadrature points, and what it is nowhere below.
fn jacobian(least: f64, bound: Option<f64>) -> String {
    let bound = bound.map(|bound| format!(", nowhere below {}", number(bound)));
    format!("{} at least{}", number(least), bound.unwrap_or_default())
}

/// The kind of an equilibrium in words.
fn equilibrium(stability: &str) -> String {
    match stability {
        "not_determined" => "not checked for stability".to_owned(),
        known => format!("{known} of the energy"),
    }
}

fn manufactured(errors: &v1::ManufacturedErrors) -> String {
    let pressure = errors
        .pressure_l2
        .map(|error| format!(", pressure L2 {error:.6e}"));
    let (l2, h1) = (errors.displacement_l2, errors.displacement_h1);
    format!(
        "displacement L2 {l2:.6e}, H1 {h1:.6e}{}",
        pressure.unwrap_or_default()
    )
}

/// How long the increment took, for whom that is enough.
pub(super) fn time(lines: &mut Lines, report: &v1::StepReport) {
    let seconds = report.seconds.unwrap_or_default().total;
    lines.add("seconds", &format!("{seconds:.3}"));
}

/// What the solver did.
pub(super) fn solver(lines: &mut Lines, report: &v1::StepReport) {
    lines.add("iterations", &iterations(report));
    lines.add("residuals", &residuals(report.residuals.as_ref()));
    lines.add("seconds", &seconds(report.seconds.unwrap_or_default()));
    lines.add("unknowns", &unknowns(report.unknowns.as_ref()));
    lines.add("memory", &bytes(report.memory_bytes));
    if !report.reused.is_empty() {
        lines.add("reused", &report.reused.join(", "));
    }
}

fn iterations(report: &v1::StepReport) -> String {
    let friction: String = [
        (report.newton_steps, "Newton steps of friction"),
        (report.threshold_passes, "passes on the threshold"),
    ]
    .into_iter()
    .filter(|(count, _)| *count > 0)
    .map(|(count, what)| format!(", {count} {what}"))
    .collect();
    format!(
        "{} SQP, {} Krylov, {} preconditioner applications, {} active set changes{friction}, {} vertices in contact",
        report.sqp_iterations,
        report.krylov_iterations,
        report.preconditioner_applications,
        report.active_set_changes,
        report.active_vertices,
    )
}

fn residuals(residuals: Option<&v1::Residuals>) -> String {
    let residuals = residuals.copied().unwrap_or_default();
    format!(
        "equilibrium {:.1e}, incompressibility {:.1e}, complementarity {:.1e}, gap {:.1e}",
        residuals.equilibrium,
        residuals.incompressibility,
        residuals.complementarity,
        residuals.gap,
    )
}

fn seconds(seconds: v1::Seconds) -> String {
    format!(
        "{:.3} (prepare {:.3}, assemble {:.3}, factorise {:.3}, krylov {:.3}, contact {:.3}, stability {:.3})",
        seconds.total,
        seconds.prepare,
        seconds.assemble,
        seconds.factorise,
        seconds.krylov,
        seconds.contact,
        seconds.stability,
    )
}
