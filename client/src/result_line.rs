//! Result lines: one JSON object a line, the same content as the stream.
//!
//! `event` is `plan`, `iteration`, `step` or `summary`; `session` and `cancel`
//! answer single commands. The form is kept in
//! `client/result-lines.schema.json`; numbers are printed so that reading them
//! gives the same double. What is not finite becomes null.

use std::collections::BTreeMap;

use serde_json::{Map, Value, json};
use signorini_proto::v1;

/// The name of an enum value on the wire without its prefix, in lower case.
fn word(name: &str, prefix: &str) -> String {
    name.strip_prefix(prefix)
        .unwrap_or(name)
        .to_ascii_lowercase()
}

/// The name of a termination, such as `not_converged`.
pub fn termination(termination: v1::Termination) -> String {
    word(termination.as_str_name(), "TERMINATION_")
}

/// The name of a cause, such as `line_search`; none when it converged.
pub fn cause(cause: v1::Cause) -> Option<String> {
    let known = cause != v1::Cause::Unspecified;
    known.then(|| word(cause.as_str_name(), "CAUSE_"))
}

/// The name of a kind of equilibrium; none where it was not found out.
pub fn stability(stability: v1::Stability) -> Option<String> {
    let known = stability != v1::Stability::Unspecified;
    known.then(|| word(stability.as_str_name(), "STABILITY_"))
}

/// The name of a field, such as `contact_pressure`.
pub fn field(field: v1::FieldName) -> String {
    word(field.as_str_name(), "FIELD_NAME_")
}

/// The name of a kind of scene as scene files spell it.
pub fn kind(kind: v1::SceneKind) -> String {
    word(kind.as_str_name(), "SCENE_KIND_").replace('_', "-")
}

/// The name of a formulation.
pub fn formulation(formulation: v1::Formulation) -> String {
    word(formulation.as_str_name(), "FORMULATION_")
}

fn unknowns(unknowns: Option<&v1::Unknowns>) -> Value {
    let unknowns = unknowns.copied().unwrap_or_default();
    json!({
        "displacement": unknowns.displacement,
        "pressure": unknowns.pressure,
        "contact": unknowns.contact,
    })
}

fn residuals(residuals: Option<&v1::Residuals>) -> Value {
    residuals.map_or(Value::Null, |residuals| {
        json!({
            "equilibrium": residuals.equilibrium,
            "incompressibility": residuals.incompressibility,
            "complementarity": residuals.complementarity,
            "gap": residuals.gap,
        })
    })
}

/// The line of a plan.
pub fn plan(plan: &v1::Plan) -> Value {
    let decision = |entry: &v1::PlanEntry| json!({"what": entry.what, "choice": entry.choice, "reason": entry.reason});
    let omission = |entry: &v1::PlanOmission| json!({"what": entry.what, "reason": entry.reason});
    json!({
        "event": "plan",
        "name": plan.name,
        "kind": kind(plan.kind()),
        "unknowns": unknowns(plan.unknowns.as_ref()),
        "formulation": formulation(plan.formulation()),
        "decisions": plan.decisions.iter().map(decision).collect::<Vec<_>>(),
        "left_out": plan.left_out.iter().map(omission).collect::<Vec<_>>(),
        "predicted_bytes": plan.predicted_bytes,
        "predicted_factor_flops": plan.predicted_factor_flops,
        "predicted_applications": plan.predicted_applications,
        "warnings": plan.warnings,
    })
}

/// The line of an iteration.
pub fn iteration(statistics: &v1::IterationStatistics) -> Value {
    let report = statistics.report.unwrap_or_default();
    json!({
        "event": "iteration",
        "step": report.step,
        "increment": report.increment,
        "attempt": report.attempt,
        "load": report.load,
        "sqp_iteration": report.sqp_iteration,
        "krylov_iterations": report.krylov_iterations,
        "preconditioner_applications": report.preconditioner_applications,
        "residuals": residuals(report.residuals.as_ref()),
        "active_vertices": report.active_vertices,
        "active_set_changes": report.active_set_changes,
        "step_length": report.step_length,
        "seconds": report.seconds,
        "skipped": statistics.skipped_count,
    })
}

fn by_name<T>(items: &BTreeMap<String, T>, line: impl Fn(&T) -> Value) -> Value {
    let items = items.iter().map(|(name, item)| (name.clone(), line(item)));
    Value::Object(items.collect::<Map<_, _>>())
}

fn obstacle(result: &v1::ObstacleResult) -> Value {
    json!({
        "force": result.force,
        "force_error": result.force_error,
        "moment": result.moment,
        "contact_area": result.contact_area,
        "max_pressure": result.max_pressure,
        "max_pressure_deformed": result.max_pressure_deformed,
        "centre_of_pressure": result.centre_of_pressure,
        "stick_vertices": result.stick_vertices,
        "slip_vertices": result.slip_vertices,
    })
}

fn errors(errors: &v1::ManufacturedErrors) -> Value {
    json!({
        "displacement_l2": errors.displacement_l2,
        "displacement_h1": errors.displacement_h1,
        "pressure_l2": errors.pressure_l2,
        "relative_energy": errors.relative_energy,
    })
}

fn seconds(seconds: Option<&v1::Seconds>) -> Value {
    let seconds = seconds.copied().unwrap_or_default();
    json!({
        "prepare": seconds.prepare,
        "assemble": seconds.assemble,
        "factorise": seconds.factorise,
        "krylov": seconds.krylov,
        "contact": seconds.contact,
        "error_norms": seconds.error_norms,
        "total": seconds.total,
    })
}

fn poses(poses: &[v1::ObstaclePose]) -> Value {
    let poses = poses.iter().map(|pose| {
        let line = json!({"translation": pose.translation, "rotation": pose.rotation});
        (pose.name.clone(), line)
    });
    Value::Object(poses.collect::<Map<_, _>>())
}

/// The line of an increment's result.
pub fn step(report: &v1::StepReport) -> Value {
    let mut line = counts(report);
    let results = json!({
        "strain_energy": report.strain_energy,
        "volume_ratio": report.volume_ratio,
        "min_jacobian": report.min_jacobian,
        "min_jacobian_bound": report.min_jacobian_bound,
        "stability": stability(report.stability()),
        "penalty": report.penalty,
        "max_penetration": report.max_penetration,
        "residuals": residuals(report.residuals.as_ref()),
        "tolerance": report.tolerance,
        "obstacles": by_name(&report.obstacles, obstacle),
        "supports": by_name(&report.supports, |support| json!({"force": support.force})),
        "probes": by_name(&report.probes, |probe| {
            json!({"displacement": probe.displacement, "pressure": probe.pressure})
        }),
        "error_estimate": report.error_estimate,
        "errors": report.errors.as_ref().map(errors),
        "seconds": seconds(report.seconds.as_ref()),
        "unknowns": unknowns(report.unknowns.as_ref()),
        "memory_bytes": report.memory_bytes,
        "reused": report.reused,
        "instruction_set": report.instruction_set,
        "verification": residuals(report.verification.as_ref()),
        "poses": poses(&report.obstacle_poses),
    });
    if let (Value::Object(line), Value::Object(results)) = (&mut line, results) {
        line.extend(results);
    }
    line
}

fn counts(report: &v1::StepReport) -> Value {
    json!({
        "event": "step",
        "step": report.step,
        "increment": report.increment,
        "time": report.time,
        "load": report.load,
        "termination": termination(report.termination()),
        "cause": cause(report.cause()),
        "sqp_iterations": report.sqp_iterations,
        "krylov_iterations": report.krylov_iterations,
        "preconditioner_applications": report.preconditioner_applications,
        "eigenvalue_applications": report.eigenvalue_applications,
        "compliance_columns": report.compliance_columns,
        "contact_products": report.contact_products,
        "active_set_changes": report.active_set_changes,
        "cut_backs": report.cut_backs,
        "factorisations": report.factorisations,
        "active_vertices": report.active_vertices,
    })
}

/// The line of a session that was handed to a server.
pub fn session(name: &str) -> Value {
    json!({"event": "session", "name": name})
}

/// The line of a cancelled step; 0 when none was running, which gives null.
pub fn cancel(session: &str, sequence: i64) -> Value {
    let sequence = (sequence > 0).then_some(sequence);
    json!({"event": "cancel", "name": session, "sequence": sequence})
}

/// Sums over all increments of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Totals {
    increments: i64,
    converged: i64,
    sqp_iterations: i64,
    krylov_iterations: i64,
    preconditioner_applications: i64,
    active_set_changes: i64,
    cut_backs: i64,
    factorisations: i64,
    seconds: v1::Seconds,
    termination: v1::Termination,
    verification: Option<v1::Residuals>,
}

impl Totals {
    /// Adds the result of an increment.
    pub fn add(&mut self, report: &v1::StepReport) {
        self.increments += 1;
        self.converged += i64::from(report.termination() == v1::Termination::Converged);
        self.sqp_iterations += i64::from(report.sqp_iterations);
        self.krylov_iterations += i64::from(report.krylov_iterations);
        self.preconditioner_applications += i64::from(report.preconditioner_applications);
        self.active_set_changes += i64::from(report.active_set_changes);
        self.cut_backs += i64::from(report.cut_backs);
        self.factorisations += i64::from(report.factorisations);
        self.add_seconds(report.seconds.unwrap_or_default());
        self.termination = report.termination();
        self.verification = report.verification;
    }

    fn add_seconds(&mut self, seconds: v1::Seconds) {
        self.seconds.prepare += seconds.prepare;
        self.seconds.assemble += seconds.assemble;
        self.seconds.factorise += seconds.factorise;
        self.seconds.krylov += seconds.krylov;
        self.seconds.contact += seconds.contact;
        self.seconds.error_norms += seconds.error_norms;
        self.seconds.total += seconds.total;
    }

    /// How the last increment ended; unspecified before the first.
    pub fn termination(&self) -> v1::Termination {
        self.termination
    }

    /// The line that ends a run. `peak_memory_bytes` is that of the process,
    /// where the system tells.
    pub fn summary(&self, wall_seconds: f64, peak_memory_bytes: Option<u64>) -> Value {
        json!({
            "event": "summary",
            "wall_seconds": wall_seconds,
            "peak_memory_bytes": peak_memory_bytes,
            "verification": residuals(self.verification.as_ref()),
            "termination": (self.increments > 0).then(|| termination(self.termination)),
            "totals": {
                "increments": self.increments,
                "converged": self.converged,
                "sqp_iterations": self.sqp_iterations,
                "krylov_iterations": self.krylov_iterations,
                "preconditioner_applications": self.preconditioner_applications,
                "active_set_changes": self.active_set_changes,
                "cut_backs": self.cut_backs,
                "factorisations": self.factorisations,
                "seconds": seconds(Some(&self.seconds)),
            },
        })
    }
}
