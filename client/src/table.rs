//! Plans and results as text for people.

use std::collections::HashSet;
use std::fmt::Write as _;

use signorini_proto::{v1, words};

use crate::text::{bytes, number, vector};

/// Lines of a label and a value.
#[derive(Default)]
struct Lines(String);

impl Lines {
    fn add(&mut self, label: &str, value: &str) {
        // Writing to a string cannot fail.
        let _infallible = writeln!(self.0, "{label:<18} {value}");
    }

    fn add_each<'a>(&mut self, label: &str, values: impl Iterator<Item = (&'a str, String)>) {
        for (name, value) in values {
            self.add(&format!("{label} {name}"), &value);
        }
    }
}

/// A plan: what is built, what is left out and why.
pub(crate) fn plan(plan: &v1::Plan) -> String {
    let mut lines = Lines::default();
    let kind = words::scene_kind(plan.kind());
    let formulation = words::formulation(plan.formulation());
    lines.add("scene", &format!("{} ({kind}, {formulation})", plan.name));
    lines.add("unknowns", &unknowns(plan.unknowns.as_ref()));
    for entry in &plan.decisions {
        lines.add(&entry.what, &reasoned(&entry.choice, &entry.reason));
    }
    left_out(&mut lines, plan);
    lines.add("predicted memory", &bytes(plan.predicted_bytes));
    let gigaflop = plan.predicted_factor_flops * 1e-9;
    lines.add(
        "predicted work",
        &format!(
            "{} GFlop to factorise, {} preconditioner applications a step",
            number(gigaflop),
            plan.predicted_applications
        ),
    );
    lines.0
}

fn reasoned(choice: &str, reason: &str) -> String {
    if reason.is_empty() {
        choice.to_owned()
    } else {
        format!("{choice}: {reason}")
    }
}

fn left_out(lines: &mut Lines, plan: &v1::Plan) {
    for entry in &plan.left_out {
        lines.add("left out", &reasoned(&entry.what, &entry.reason));
    }
}

fn unknowns(unknowns: Option<&v1::Unknowns>) -> String {
    let unknowns = unknowns.copied().unwrap_or_default();
    let (displacement, pressure, contact) =
        (unknowns.displacement, unknowns.pressure, unknowns.contact);
    format!("{displacement} displacement, {pressure} pressure, {contact} contact")
}

/// The results of a run: one line an increment when there are several, the last
/// one in full, and what the plan left out.
pub(crate) fn results(plan: &v1::Plan, reports: &[v1::StepReport]) -> String {
    let mut lines = Lines::default();
    if reports.len() > 1 {
        lines.0.push_str(&increments(reports));
    }
    if let Some(last) = reports.last() {
        report(&mut lines, &plan.name, last);
    }
    for warning in earlier_warnings(reports) {
        lines.add("warning", &warning);
    }
    left_out(&mut lines, plan);
    lines.0
}

fn increments(reports: &[v1::StepReport]) -> String {
    let mut text =
        String::from("step increment  termination        sqp krylov  force          seconds\n");
    for report in reports {
        let force: Vec<f64> = report
            .obstacles
            .values()
            .map(|obstacle| length(&obstacle.force))
            .collect();
        // Writing to a string cannot fail.
        let _infallible = writeln!(
            text,
            "{:>4} {:>9}  {:<17} {:>4} {:>6}  {:<14} {:>7.3}",
            report.step,
            report.increment,
            words::termination(report.termination()),
            report.sqp_iterations,
            report.krylov_iterations,
            number(force.iter().sum()),
            report.seconds.unwrap_or_default().total,
        );
    }
    text.push('\n');
    text
}

/// What was doubted before the last increment and is not in the last one, once each, with the
/// first increment of it.
fn earlier_warnings(reports: &[v1::StepReport]) -> Vec<String> {
    let Some((last, earlier)) = reports.split_last() else {
        return Vec::new();
    };
    let about = |warning: &v1::Warning| (warning.kind.clone(), warning.subject.clone());
    let mut told: HashSet<_> = last.warnings.iter().map(about).collect();
    let mut lines = Vec::new();
    for report in earlier {
        for warning in &report.warnings {
            if told.insert(about(warning)) {
                let (step, increment) = (report.step, report.increment);
                let message = &warning.message;
                lines.push(format!("step {step}, increment {increment}: {message}"));
            }
        }
    }
    lines
}

fn length(vector: &[f64]) -> f64 {
    vector.iter().map(|value| value * value).sum::<f64>().sqrt()
}

fn report(lines: &mut Lines, name: &str, report: &v1::StepReport) {
    lines.add("scene", name);
    lines.add("result", &ending(report));
    if let Some(site) = &report.cause_site {
        lines.add("where", &place(site));
    }
    if let Some(rung) = words::fallback(report.fallback()) {
        lines.add("second attempt", &format!("solved by rung {rung}"));
    }
    loads(lines, report);
    if !report.obstacles.is_empty() {
        lines.add(
            "penetration",
            &format!("{} at most", number(report.max_penetration)),
        );
    }
    lines.add("strain energy", &number(report.strain_energy));
    lines.add("volume ratio", &format!("{:.9}", report.volume_ratio));
    if let Some(least) = report.min_jacobian {
        lines.add("det F", &jacobian(least, report.min_jacobian_bound));
    }
    if let Some(stability) = words::stability(report.stability()) {
        lines.add("equilibrium", &equilibrium(&stability));
    }
    if let Some(snapped) = &report.snapped {
        lines.add("snapped", &fall(snapped));
    }
    for warning in &report.warnings {
        lines.add("warning", &warning.message);
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
    lines.add("iterations", &iterations(report));
    lines.add("residuals", &residuals(report.residuals.as_ref()));
    if report.verification.is_some() {
        lines.add("verification", &residuals(report.verification.as_ref()));
    }
    lines.add("seconds", &seconds(report.seconds.unwrap_or_default()));
    lines.add("unknowns", &unknowns(report.unknowns.as_ref()));
    lines.add("memory", &bytes(report.memory_bytes));
    if !report.reused.is_empty() {
        lines.add("reused", &report.reused.join(", "));
    }
}

/// The kind of an equilibrium in words.
fn equilibrium(stability: &str) -> String {
    match stability {
        "not_determined" => "not checked for stability".to_owned(),
        known => format!("{known} of the energy"),
    }
}

/// Where a cause lies, in words.
fn place(site: &v1::CauseSite) -> String {
    let point = match site.point.is_empty() {
        true => "the whole body".to_owned(),
        false => format!("at {}", vector(&site.point)),
    };
    let motion = match site.motion.is_empty() {
        true => String::new(),
        false => format!(", along {}", vector(&site.motion)),
    };
    let size = site.mesh_size.map(number);
    let size = size.map(|size| format!(", faces there have to be smaller than {size}"));
    point + &motion + &size.unwrap_or_default()
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

/// Least det F at quadrature points, and what it is nowhere below.
fn jacobian(least: f64, bound: Option<f64>) -> String {
    let bound = bound.map(|bound| format!(", nowhere below {}", number(bound)));
    format!("{} at least{}", number(least), bound.unwrap_or_default())
}

fn ending(report: &v1::StepReport) -> String {
    let termination = words::termination(report.termination());
    let cause = words::cause(report.cause());
    let cause = cause.map(|cause| format!(" ({cause})")).unwrap_or_default();
    let (step, increment, load) = (report.step, report.increment, number(report.load));
    format!("{termination}{cause}: step {step}, increment {increment}, load {load}")
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

/// What obstacles and supports do to the body, and the probes.
fn loads(lines: &mut Lines, report: &v1::StepReport) {
    let obstacles = report.obstacles.iter().map(|(name, obstacle)| {
        let force = vector(&obstacle.force);
        let (area, pressure) = (number(obstacle.contact_area), number(obstacle.max_pressure));
        let deformed = obstacle.max_pressure_deformed;
        let deformed = deformed.map(|p| format!(" ({} per deformed area)", number(p)));
        let deformed = deformed.unwrap_or_default();
        let value =
            format!("force {force}, contact area {area}, pressure {pressure}{deformed} at most");
        (name.as_str(), value)
    });
    lines.add_each("obstacle", obstacles);
    lines.add_each("friction", report.obstacles.iter().filter_map(friction));
    let supports = report.supports.iter();
    lines.add_each(
        "support",
        supports
            .map(|(name, support)| (name.as_str(), format!("force {}", vector(&support.force)))),
    );
    let probes = report.probes.iter().map(|(name, probe)| {
        let pressure = probe
            .pressure
            .map(|pressure| format!(", pressure {}", number(pressure)));
        let displacement = vector(&probe.displacement);
        (
            name.as_str(),
            format!(
                "displacement {displacement}{}",
                pressure.unwrap_or_default()
            ),
        )
    });
    lines.add_each("probe", probes);
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
        "{:.3} (prepare {:.3}, assemble {:.3}, factorise {:.3}, krylov {:.3}, contact {:.3})",
        seconds.total,
        seconds.prepare,
        seconds.assemble,
        seconds.factorise,
        seconds.krylov,
        seconds.contact,
    )
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    fn report() -> v1::StepReport {
        let obstacle = v1::ObstacleResult {
            force: vec![0.0, 0.0, -0.0177],
            contact_area: 0.0375,
            max_pressure: 0.6,
            ..Default::default()
        };
        v1::StepReport {
            step: 1,
            increment: 2,
            termination: v1::Termination::NotConverged.into(),
            cause: v1::Cause::LineSearch.into(),
            obstacles: BTreeMap::from([("ball".to_owned(), obstacle)]),
            ..Default::default()
        }
    }

    fn omission() -> v1::Plan {
        let (what, reason) = ("friction".to_owned(), "no obstacle has it".to_owned());
        let left_out = vec![v1::PlanOmission { what, reason }];
        v1::Plan {
            name: "block".to_owned(),
            left_out,
            ..Default::default()
        }
    }

    #[test]
    fn the_table_names_force_area_pressure_cause_and_omissions() {
        let text = results(&omission(), &[report()]);
        for part in [
            "not_converged (line_search): step 1, increment 2",
            "obstacle ball      force (0, 0, -0.0177), contact area 0.0375, pressure 0.6 at most",
            "left out           friction: no obstacle has it",
        ] {
            assert!(text.contains(part), "{part}\n{text}");
        }
    }

    #[test]
    fn finite_strain_says_how_far_cells_are_from_turning_inside_out() {
        let mut report = report();
        assert!(!results(&omission(), &[report.clone()]).contains("det F"));
        report.min_jacobian = Some(0.9);
        report.min_jacobian_bound = Some(0.85);
        report.stability = v1::Stability::Minimum.into();
        let obstacle = report.obstacles.get_mut("ball").unwrap();
        obstacle.max_pressure_deformed = Some(0.55);
        let text = results(&omission(), &[report]);
        for part in [
            "det F              0.9 at least, nowhere below 0.85",
            "equilibrium        minimum of the energy",
            "pressure 0.6 (0.55 per deformed area) at most",
        ] {
            assert!(text.contains(part), "{part}\n{text}");
        }
    }

    #[test]
    fn warnings_of_all_increments_are_told_once() {
        let warned = |increment: i32, kinds: &[&str]| v1::StepReport {
            increment,
            warnings: kinds
                .iter()
                .map(|&kind| v1::Warning {
                    kind: kind.to_owned(),
                    message: format!("it {kind}"),
                    ..Default::default()
                })
                .collect(),
            ..report()
        };
        let reports = [
            warned(1, &["snapped"]),
            warned(2, &["snapped", "large_strain"]),
            warned(3, &["large_strain"]),
        ];
        let text = results(&omission(), &reports);
        let told: Vec<&str> = text.lines().filter(|l| l.starts_with("warning")).collect();
        let expected = [
            "warning            it large_strain",
            "warning            step 1, increment 1: it snapped",
        ];
        assert_eq!(told, expected, "{text}");
    }

    #[test]
    fn several_increments_have_a_line_each() {
        let text = results(&omission(), &[report(), report()]);
        assert_eq!(
            text.lines()
                .filter(|line| line.contains("not_converged  "))
                .count(),
            2,
            "{text}"
        );
    }
}
