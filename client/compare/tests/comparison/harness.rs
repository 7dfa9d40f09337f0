//! The run of a scene on the library with the methods of this crate.

use std::sync::Arc;

use crate::common::{assert_converged, take};
use signorini::{
    CancelToken, Mesh, Plan, Prepared, Reuse, Scene, SceneError, Session, Step, StepReport,
};
use signorini_compare::Methods;

/// The plan of a scene that may name them.
pub(crate) fn plan(scene: &Scene, mesh: &Mesh) -> Result<Plan, SceneError> {
    Plan::with_comparisons(scene, &[], mesh, Some(Arc::new(Methods)))
}

/// The prepared data of a plan.
pub(crate) fn prepared(plan: &Plan, mesh: &Arc<Mesh>) -> Prepared {
    Prepared::build(plan, mesh, &CancelToken::new()).expect("a solvable scene")
}

/// A session of `scene` on data of its own.
pub(crate) fn open(scene: &Scene, mesh: &Arc<Mesh>) -> Session {
    let plan = Arc::new(plan(scene, mesh).expect("a valid scene"));
    let prepared = Arc::new(prepared(&plan, mesh));
    Session::new(plan, mesh.clone(), prepared, Reuse::Built)
}

/// The session behind all steps, and a report an increment.
pub(crate) fn run(scene: &Scene, steps: &[Step], mesh: &Arc<Mesh>) -> (Session, Vec<StepReport>) {
    let mut session = open(scene, mesh);
    let steps = steps.iter();
    let reports = steps.flat_map(|step| take(&mut session, step)).collect();
    (session, reports)
}

/// The single report of a step of one increment, which must converge, and the session behind.
pub(crate) fn run_one(scene: &Scene, step: &Step, mesh: &Arc<Mesh>) -> (Session, StepReport) {
    let (session, mut reports) = run(scene, std::slice::from_ref(step), mesh);
    assert_eq!(reports.len(), 1);
    let report = reports.remove(0);
    assert_converged(&report);
    (session, report)
}
