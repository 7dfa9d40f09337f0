//! Plans, reports and iteration records onto the wire.

use signorini::ObstaclePose;
use signorini::plan::PlanReport;
use signorini::report::{
    Attempt, BodyContactResult, BodyFriction, Cause, CauseSite, ContactInterval, FluidResult,
    GoalReport, IterationRecord, LeakPathResult, ManufacturedErrors, ObstacleResult, ProbeResult,
    Residuals, Seconds, Snapped, Stability, StepReport, Strategy, SupportResult, Termination,
    TieResult, Tightness, Unknowns, Warning,
};
use signorini_proto::v1 as wire;

use super::{narrow, wide};

/// The report of one increment with the poses at its end.
pub(crate) fn step(report: StepReport, poses: Vec<ObstaclePose>) -> wire::StepReport {
    wire::StepReport {
        step: narrow(report.step),
        increment: narrow(report.increment),
        time: report.time,
        load: report.load,
        termination: termination(report.termination).into(),
        cause: report.cause.map_or(wire::Cause::Unspecified, cause).into(),
        sqp_iterations: narrow(report.sqp_iterations),
        krylov_iterations: narrow(report.krylov_iterations),
        preconditioner_applications: narrow(report.preconditioner_applications),
        eigenvalue_applications: narrow(report.eigenvalue_applications),
        compliance_columns: narrow(report.compliance_columns),
        contact_products: narrow(report.contact_products),
        active_set_changes: narrow(report.active_set_changes),
        newton_steps: narrow(report.newton_steps),
        threshold_passes: narrow(report.threshold_passes),
        cut_backs: narrow(report.cut_backs),
        attempts: report.attempts.into_iter().map(attempt).collect(),
        factorisations: narrow(report.factorisations),
        active_vertices: narrow(report.active_vertices),
        strain_energy: report.strain_energy,
        volume_ratio: report.volume_ratio,
        min_jacobian: report.min_jacobian,
        min_jacobian_bound: report.min_jacobian_bound,
        penalty: report.penalty,
        stability: report
            .stability
            .map_or(wire::Stability::Unspecified, stability)
            .into(),
        cause_site: report.cause_site.map(cause_site),
        snapped: report.snapped.map(snapped),
        warnings: report.warnings.into_iter().map(warning).collect(),
        max_penetration: report.max_penetration,
        residuals: Some(residuals(report.residuals)),
        tolerance: report.tolerance,
        obstacles: by_name(report.obstacles, obstacle),
        supports: by_name(report.supports, support),
        probes: by_name(report.probes, probe),
        fluids: by_name(report.fluids, fluid),
        goals: report.goals.into_iter().map(goal).collect(),
        goals_refused: report.goals_refused,
        contacts: by_name(report.contacts, between_bodies),
        ties: by_name(report.ties, tie),
        error_estimate: report.error_estimate,
        errors: report.errors.map(errors),
        seconds: Some(seconds(report.seconds)),
        unknowns: Some(unknowns(report.unknowns)),
        memory_bytes: wide(report.memory_bytes),
        reused: report.reused,
        instruction_set: report.instruction_set,
        left_out: report.left_out.into_iter().map(str::to_owned).collect(),
        verification: report.verification.map(residuals),
        obstacle_poses: poses.into_iter().map(pose).collect(),
    }
}

/// One iteration.
pub(crate) fn iteration(record: &IterationRecord) -> wire::IterationReport {
    wire::IterationReport {
        step: narrow(record.step),
        increment: narrow(record.increment),
        attempt: narrow(record.attempt),
        load: record.load,
        sqp_iteration: narrow(record.sqp_iteration),
        krylov_iterations: narrow(record.krylov_iterations),
        preconditioner_applications: narrow(record.preconditioner_applications),
        residuals: Some(residuals(record.residuals)),
        active_vertices: narrow(record.active_vertices),
        active_set_changes: narrow(record.active_set_changes),
        step_length: record.step_length,
        seconds: record.seconds,
    }
}

/// A plan.
pub(crate) fn plan(report: PlanReport) -> wire::Plan {
    let entries = report.decisions.into_iter().map(|entry| wire::PlanEntry {
        what: entry.what,
        choice: entry.choice,
        reason: entry.reason,
    });
    let omissions = report.left_out.into_iter().map(|entry| wire::PlanOmission {
        what: entry.what,
        reason: entry.reason,
    });
    wire::Plan {
        name: report.name,
        kind: scene_kind(report.kind).into(),
        unknowns: Some(unknowns(report.unknowns)),
        formulation: formulation(&report.formulation).into(),
        decisions: entries.collect(),
        left_out: omissions.collect(),
        predicted_bytes: wide(report.predicted_bytes),
        predicted_factor_flops: report.predicted_factor_flops,
        predicted_applications: narrow(report.predicted_applications),
        warnings: report.warnings.into_iter().take(100).collect(),
        constants: Vec::new(),
    }
}

/// The constants of the solver.
pub(crate) fn constants() -> Vec<wire::SolverConstant> {
    let constants = signorini::constants().into_iter();
    constants
        .map(|one| wire::SolverConstant {
            file: one.file.to_owned(),
            name: one.name.to_owned(),
            value: one.value,
            meaning: one.meaning,
        })
        .collect()
}

fn scene_kind(name: &str) -> wire::SceneKind {
    match name {
        "solid" => wire::SceneKind::Solid,
        "plane-strain" => wire::SceneKind::PlaneStrain,
        "plane-stress" => wire::SceneKind::PlaneStress,
        "axisymmetric" => wire::SceneKind::Axisymmetric,
        _ => wire::SceneKind::Unspecified,
    }
}

fn formulation(name: &str) -> wire::Formulation {
    match name {
        "mixed" => wire::Formulation::Mixed,
        "displacement" => wire::Formulation::Displacement,
        _ => wire::Formulation::Unspecified,
    }
}

fn termination(value: Termination) -> wire::Termination {
    match value {
        Termination::Converged => wire::Termination::Converged,
        Termination::NotConverged => wire::Termination::NotConverged,
        Termination::Cancelled => wire::Termination::Cancelled,
        Termination::DeadlineExceeded => wire::Termination::DeadlineExceeded,
        Termination::InternalError => wire::Termination::InternalError,
    }
}

fn cause(value: Cause) -> wire::Cause {
    match value {
        Cause::Stagnation => wire::Cause::Stagnation,
        Cause::IterationLimit => wire::Cause::IterationLimit,
        Cause::ActiveSetCycle => wire::Cause::ActiveSetCycle,
        Cause::StepTooSmall => wire::Cause::StepTooSmall,
        Cause::LineSearch => wire::Cause::LineSearch,
        Cause::NoEquilibrium => wire::Cause::NoEquilibrium,
        Cause::EnclosedVolume => wire::Cause::EnclosedVolume,
        Cause::NotFinite => wire::Cause::NotFinite,
        Cause::IndefiniteTangent => wire::Cause::IndefiniteTangent,
        Cause::LimitPoint => wire::Cause::LimitPoint,
        Cause::UnstableEquilibrium => wire::Cause::UnstableEquilibrium,
        Cause::NegativeJacobian => wire::Cause::NegativeJacobian,
        Cause::InsideOut => wire::Cause::InsideOut,
        Cause::Leaks => wire::Cause::Leaks,
    }
}

fn cause_site(value: CauseSite) -> wire::CauseSite {
    let list = |vector: Option<[f64; 3]>| vector.map_or(Vec::new(), Vec::from);
    wire::CauseSite {
        point: list(value.point),
        motion: list(value.motion),
        key: value.key.unwrap_or_default(),
    }
}

fn snapped(value: Snapped) -> wire::Snapped {
    wire::Snapped {
        energy_drop: value.energy_drop,
        largest_motion: value.largest_motion,
        point: value.point.to_vec(),
    }
}

fn attempt(value: Attempt) -> wire::Attempt {
    let followed_by = value.followed_by;
    wire::Attempt {
        strategy: strategy(value.strategy).into(),
        cause: value.cause.map_or(wire::Cause::Unspecified, cause).into(),
        preconditioner_applications: narrow(value.preconditioner_applications),
        followed_by: followed_by
            .map_or(wire::Strategy::Unspecified, strategy)
            .into(),
    }
}

fn strategy(value: Strategy) -> wire::Strategy {
    match value {
        Strategy::Part => wire::Strategy::Part,
        Strategy::SmallerPart => wire::Strategy::SmallerPart,
        Strategy::VolumePenalty => wire::Strategy::VolumePenalty,
        Strategy::SnapThrough => wire::Strategy::SnapThrough,
        Strategy::ProximalRest => wire::Strategy::ProximalRest,
    }
}

fn warning(value: Warning) -> wire::Warning {
    wire::Warning {
        kind: value.kind.name().to_owned(),
        subject: value.subject,
        value: value.value,
        message: value.message,
    }
}

fn stability(value: Stability) -> wire::Stability {
    match value {
        Stability::Minimum => wire::Stability::Minimum,
        Stability::Saddle => wire::Stability::Saddle,
        Stability::NotDetermined => wire::Stability::NotDetermined,
    }
}

fn by_name<D, W>(
    map: std::collections::BTreeMap<String, D>,
    convert: impl Fn(D) -> W,
) -> std::collections::BTreeMap<String, W> {
    map.into_iter()
        .map(|(name, value)| (name, convert(value)))
        .collect()
}

fn goal(value: GoalReport) -> (String, wire::GoalResult) {
    let bound = value.bound.map(|bound| wire::GoalBound {
        total: bound.total(),
        mesh: bound.discretisation,
        solver: bound.solver,
        geometry: bound.geometry,
        estimate: bound.estimate,
    });
    let result = wire::GoalResult {
        value: value.value,
        derivatives: value.derivatives.into_iter().collect(),
        borderline: narrow(value.borderline),
        solver_error: value.solver_error,
        bound,
        dual_residual: value.dual_residual,
        applications: narrow(value.applications),
        seconds: value.seconds,
    };
    (value.goal, result)
}

fn residuals(value: Residuals) -> wire::Residuals {
    wire::Residuals {
        equilibrium: value.equilibrium,
        incompressibility: value.incompressibility,
        complementarity: value.complementarity,
        gap: value.gap,
    }
}

fn obstacle(value: ObstacleResult) -> wire::ObstacleResult {
    wire::ObstacleResult {
        force: value.force.to_vec(),
        force_error: value.force_error,
        geometry_error: value.geometry_error,
        moment: value.moment.to_vec(),
        contact_area: value.contact_area,
        deformed_contact_area: value.deformed_contact_area,
        contact_width: value.contact_width,
        contact_intervals: value.contact_intervals.iter().map(interval).collect(),
        peak_pressure: value.peak_pressure,
        peak_pressure_place: value
            .peak_pressure_place
            .map(|place| place.to_vec())
            .unwrap_or_default(),
        mean_pressure: value.mean_pressure,
        max_pressure: value.max_pressure,
        max_pressure_deformed: value.max_pressure_deformed,
        max_pressure_undeformed: value.max_pressure_undeformed,
        centre_of_pressure: value.centre_of_pressure.to_vec(),
        stick_vertices: narrow(value.stick_vertices),
        slip_vertices: narrow(value.slip_vertices),
        open_vertices: narrow(value.open_vertices),
        max_slip: value.max_slip,
        stick_margin: value.stick_margin,
        tangential_force: value.tangential_force.to_vec(),
        dissipated_energy: value.dissipated_energy,
        dissipated_total: value.dissipated_total,
    }
}

fn interval(value: &ContactInterval) -> wire::ContactInterval {
    wire::ContactInterval {
        start: value.start.to_vec(),
        end: value.end.to_vec(),
        width: value.width,
        force: value.force.to_vec(),
    }
}

fn support(value: SupportResult) -> wire::SupportResult {
    wire::SupportResult {
        force: value.force.to_vec(),
        moment: value.moment.to_vec(),
        reference_point: value.reference_point.to_vec(),
        translation: value.translation.to_vec(),
        rotation: value.rotation.to_vec(),
    }
}

fn probe(value: ProbeResult) -> wire::ProbeResult {
    wire::ProbeResult {
        displacement: value.displacement.to_vec(),
        pressure: value.pressure,
    }
}

fn between_bodies(value: BodyContactResult) -> wire::BodyContactResult {
    let place = value.peak_pressure_place;
    wire::BodyContactResult {
        force: value.force.to_vec(),
        moment: value.moment.to_vec(),
        contact_area: value.contact_area,
        contact_width: value.contact_width,
        contact_intervals: value.contact_intervals.iter().map(interval).collect(),
        mean_pressure: value.mean_pressure,
        peak_pressure: value.peak_pressure,
        peak_pressure_place: place.map(|place| place.to_vec()).unwrap_or_default(),
        friction: value.friction.map(between_rough_bodies),
    }
}

fn between_rough_bodies(value: BodyFriction) -> wire::BodyFriction {
    wire::BodyFriction {
        tangential_force: value.tangential_force.to_vec(),
        stick_vertices: narrow(value.stick_vertices),
        slip_vertices: narrow(value.slip_vertices),
        open_vertices: narrow(value.open_vertices),
        max_slip: value.max_slip,
        stick_margin: value.stick_margin,
        dissipated_energy: value.dissipated_energy,
        dissipated_total: value.dissipated_total,
    }
}

fn tie(value: TieResult) -> wire::TieResult {
    wire::TieResult {
        force: value.force.to_vec(),
        moment: value.moment.to_vec(),
        area: value.area,
        gap: value.gap,
        peak_traction: value.peak_traction,
        peak_traction_place: value.peak_traction_place.to_vec(),
    }
}

fn fluid(value: FluidResult) -> wire::FluidResult {
    let tightness = match value.tightness {
        Tightness::Tight => wire::Tightness::Tight,
        Tightness::Leaks => wire::Tightness::Leaks,
    };
    wire::FluidResult {
        pressure: value.pressure,
        tightness: tightness.into(),
        blow_off_low: value.blow_off.map(|[low, _]| low),
        blow_off_high: value.blow_off.map(|[_, high]| high),
        wet_area: value.wet_area,
        force: value.force.to_vec(),
        leak_path: value.leak_path.map(leak_path),
        leak_paths: by_name(value.leak_paths, leak_path),
        rounds: narrow(value.rounds),
        conductance: value.conductance,
        flow_rate: value.flow_rate,
    }
}

fn leak_path(value: LeakPathResult) -> wire::LeakPath {
    wire::LeakPath {
        margin: value.margin,
        margin_over_pressure: value.margin_over_pressure,
        sealed_width: value.sealed_width,
        points: value.points.into_flattened(),
        pressures: value.pressures,
    }
}

fn errors(value: ManufacturedErrors) -> wire::ManufacturedErrors {
    wire::ManufacturedErrors {
        displacement_l2: value.displacement_l2,
        displacement_h1: value.displacement_h1,
        pressure_l2: value.pressure_l2,
        relative_energy: value.relative_energy,
    }
}

fn seconds(value: Seconds) -> wire::Seconds {
    wire::Seconds {
        prepare: value.prepare,
        assemble: value.assemble,
        factorise: value.factorise,
        krylov: value.krylov,
        contact: value.contact,
        stability: value.stability,
        total: value.total,
        error_norms: value.error_norms,
    }
}

fn unknowns(value: Unknowns) -> wire::Unknowns {
    wire::Unknowns {
        displacement: wide(value.displacement),
        pressure: wide(value.pressure),
        contact: wide(value.contact),
    }
}

fn pose(value: ObstaclePose) -> wire::ObstaclePose {
    wire::ObstaclePose {
        name: value.name,
        translation: value.translation.to_vec(),
        rotation: value.rotation.to_vec(),
    }
}
