//! What the stories share: small meshes, scenes, and the run of a scene on the
//! library. Each story compiles its own copy and uses a part of it.
#![allow(dead_code)]

pub(crate) mod curved;
pub(crate) mod meshes;
pub(crate) mod prisms;
pub(crate) mod refusals;
pub(crate) mod rounded;
pub(crate) mod scene_files;
pub(crate) mod scenes;

use std::sync::Arc;

use signorini::{
    CancelToken, FieldName, Mesh, Plan, Prepared, Reuse, Scene, Session, Silent, Step, StepReport,
    Termination,
};

/// A session of `scene` on data of its own.
pub(crate) fn open(scene: &Scene, mesh: &Arc<Mesh>) -> Session {
    let plan = Arc::new(Plan::new(scene, &[], mesh).expect("a valid scene"));
    let prepared = Prepared::build(&plan, mesh, &CancelToken::new()).expect("a solvable scene");
    Session::new(plan, mesh.clone(), Arc::new(prepared), Reuse::Built)
}

/// Takes one step; one report per increment.
pub(crate) fn take(session: &mut Session, step: &Step) -> Vec<StepReport> {
    let mut run = session.begin_step(step).expect("a valid step");
    let mut reports = Vec::new();
    while let Some(report) = session.advance(&mut run, &mut Silent, &CancelToken::new()) {
        if session.plan().scene().solver.verify {
            check_verification(&report);
        }
        reports.push(report);
    }
    reports
}

/// Solves all steps (the default one where there is none) from the undeformed
/// state.
pub(crate) fn solve(scene: &Scene, steps: &[Step], mesh: &Arc<Mesh>) -> Vec<StepReport> {
    run(scene, steps, mesh).1
}

/// [`solve`], with the session for its fields.
pub(crate) fn run(scene: &Scene, steps: &[Step], mesh: &Arc<Mesh>) -> (Session, Vec<StepReport>) {
    Plan::new(scene, steps, mesh).expect("valid steps");
    let mut session = open(scene, mesh);
    let default = [Step::default()];
    let steps = if steps.is_empty() { &default } else { steps };
    let reports = steps
        .iter()
        .flat_map(|step| take(&mut session, step))
        .collect();
    (session, reports)
}

/// The single report of a scene of one increment, which must converge at the first attempt.
pub(crate) fn solve_one(scene: &Scene, step: &Step, mesh: &Arc<Mesh>) -> StepReport {
    run_one(scene, step, mesh).1
}

/// The same, whatever attempt converged.
pub(crate) fn solve_one_at_last(scene: &Scene, step: &Step, mesh: &Arc<Mesh>) -> StepReport {
    let mut reports = solve(scene, std::slice::from_ref(step), mesh);
    assert_eq!(reports.len(), 1);
    assert_converged_at_last(&reports[0]);
    reports.remove(0)
}

/// [`solve_one`], with the session for its fields.
pub(crate) fn run_one(scene: &Scene, step: &Step, mesh: &Arc<Mesh>) -> (Session, StepReport) {
    let (session, mut reports) = run(scene, std::slice::from_ref(step), mesh);
    assert_eq!(reports.len(), 1);
    let report = reports.remove(0);
    assert_converged(&report);
    (session, report)
}

/// Fails unless the increment converged at the first attempt: a second one that a story does not
/// ask for hides a wrong choice.
pub(crate) fn assert_converged(report: &StepReport) {
    assert_converged_at_last(report);
}

/// Fails unless the increment converged.
pub(crate) fn assert_converged_at_last(report: &StepReport) {
    assert_eq!(
        (report.termination, report.cause),
        (Termination::Converged, None),
        "{:?}",
        report.residuals
    );
}

/// The independent path must agree with a converged result.
fn check_verification(report: &StepReport) {
    let tolerance = report.tolerance;
    if report.termination == Termination::Converged {
        let verified = report
            .verification
            .expect("scenes of the stories ask for it");
        assert!(
            report.residuals.largest() <= tolerance
                && verified.largest() <= 1.05 * tolerance + 1e-12,
            "{:?}\n{verified:?}",
            report.residuals
        );
    }
}

/// Values of a field that the scene has.
pub(crate) fn values(session: &Session, name: FieldName) -> Vec<f64> {
    session
        .field(name)
        .expect("the scene has this field")
        .values
}

/// Position of each displacement node of the reported field [nodes].
pub(crate) fn node_positions(mesh: &Mesh) -> Vec<[f64; 3]> {
    let x = mesh.coordinates();
    let middle = |edge: &[u32; 2]| {
        let [a, b] = edge.map(|vertex| x[vertex as usize]);
        std::array::from_fn(|i| 0.5 * (a[i] + b[i]))
    };
    x.iter()
        .copied()
        .chain(mesh.edges().iter().map(middle))
        .collect()
}

/// Largest absolute difference.
pub(crate) fn difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max)
}

/// Whether two numbers agree relative to the second.
pub(crate) fn close(value: f64, expected: f64, relative: f64) -> bool {
    (value - expected).abs() <= relative * expected.abs()
}
