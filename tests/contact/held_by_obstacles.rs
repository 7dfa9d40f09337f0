//! Bodies that nothing but obstacles holds, and flat cells: the plan's own method or a factor of the
//! body solves them.

use std::sync::Arc;

use crate::common::meshes::{cube, mesh, moved};
use crate::common::scene_files::family;
use crate::common::scenes::{elastic, in_parts, obstacle, push, rollers};
use crate::common::{close, difference, open, run, solve_one, take, values};
use signorini::scene::Shape;
use signorini::{
    CancelToken, Cause, FieldName, IterationRecord, Mesh, Observer, Plan, Prepared, Reuse, Scene,
    Session, Step, StepReport, Termination,
};

fn plane(point: [f64; 3], normal: [f64; 3]) -> Shape {
    Shape::HalfSpace { point, normal }
}

/// A block of unit sides and that height that nothing but six planes holds, one of them at a
/// distance that it does not reach, and the step that presses it by a fiftieth.
fn groove(poisson_ratio: f64, height: f64) -> (Scene, Step, Arc<Mesh>) {
    let mut scene = elastic(poisson_ratio);
    scene.obstacles = vec![
        obstacle("floor", "z0", plane([0.0; 3], [0.0, 0.0, 1.0])),
        obstacle("left", "x0", plane([0.0; 3], [1.0, 0.0, 0.0])),
        obstacle("right", "x1", plane([1.0; 3], [-1.0, 0.0, 0.0])),
        obstacle("front", "y0", plane([0.0; 3], [0.0, 1.0, 0.0])),
        obstacle("back", "y1", plane([1.0, 1.05, 1.0], [0.0, -1.0, 0.0])),
        obstacle("press", "z1", plane([1.0, 1.0, height], [0.0, 0.0, -1.0])),
    ];
    let block = mesh(moved(cube(4), |[x, y, z]| [x, y, height * z]));
    (scene, push("press", [0.0, 0.0, -0.02 * height]), block)
}

/// Force and energy a unit of height of a block of shear modulus one between two walls,
/// pressed by the `strain` and free to the third side: homogeneous plane strain.
fn plane_strain(poisson_ratio: f64, strain: f64) -> (f64, f64) {
    let stiffness = 2.0 / (1.0 - poisson_ratio);
    (stiffness * strain, 0.5 * stiffness * strain * strain)
}

#[test]
fn a_block_that_obstacles_alone_hold_is_solved_whatever_its_cells() {
    let heights = [1.0, 0.5, 0.3, 0.15, 0.05];
    let all = heights.map(|height| [(0.3, height), (0.5, height)]);
    for (poisson_ratio, height) in all.into_iter().flatten() {
        let (scene, step, mesh) = groove(poisson_ratio, height);
        let report = solve_one(&scene, &step, &mesh);
        let (force, energy) = plane_strain(poisson_ratio, 0.02);
        for (name, axis, exact) in [
            ("floor", 2, force),
            ("press", 2, -force),
            ("left", 0, poisson_ratio * force * height),
            ("right", 0, -poisson_ratio * force * height),
            ("front", 1, 0.0),
            ("back", 1, 0.0),
        ] {
            let found = report.obstacles[name].force[axis];
            assert!(
                (found - exact).abs() < 1e-7 * force,
                "{name} {found} {exact}"
            );
        }
        assert!(close(report.strain_energy, energy * height, 1e-7));
    }
}

#[test]
fn the_same_cube_on_rollers_has_the_same_result() {
    let (mut scene, step, mesh) = groove(0.3, 1.0);
    scene.supports = rollers();
    scene
        .obstacles
        .retain(|one| ["right", "press"].contains(&one.name.as_str()));
    let report = solve_one(&scene, &step, &mesh);
    assert!(close(report.strain_energy, plane_strain(0.3, 0.02).1, 1e-7));
}

#[test]
fn a_load_that_nothing_holds_has_no_equilibrium() {
    // Nothing holds the body against this load, whatever the method.
    let (mut scene, _, mesh) = groove(0.3, 1.0);
    scene.tractions = vec![crate::common::scenes::traction("y1", [0.0, 1.0, 0.0])];
    scene.obstacles.retain(|one| one.name != "back");
    let (_, reports) = run(&scene, &[Step::default()], &mesh);
    assert_eq!(reports[0].cause, Some(Cause::NoEquilibrium));
}

/// A stiff top layer of one row of cells, which takes a factor.
fn stiff_top() -> (Scene, Step, Arc<Mesh>) {
    let (scene, steps, mesh) = family("stiff-top-2d");
    (scene, steps[0].clone(), mesh)
}

/// A session on data that another one may share.
fn ground(scene: &Scene, mesh: &Arc<Mesh>) -> (Arc<Plan>, Arc<Prepared>) {
    let plan = Arc::new(Plan::new(scene, &[], mesh).expect("a valid scene"));
    let prepared = Prepared::build(&plan, mesh, &CancelToken::new()).expect("a solvable scene");
    (plan, Arc::new(prepared))
}

#[test]
fn a_session_taken_elsewhere_after_a_factor_goes_on_with_the_same_bits() {
    let (scene, step, mesh) = stiff_top();
    let step = in_parts(step, 3);
    let (plan, prepared) = ground(&scene, &mesh);
    let mut here = Session::new(plan.clone(), mesh.clone(), prepared.clone(), Reuse::Reused);
    let mut run = here.begin_step(&step).expect("a valid step");
    let advance = |session: &mut Session, run: &mut signorini::StepRun| {
        let report = session.advance(run, &mut signorini::Silent, &CancelToken::new());
        report.expect("an increment").factorisations
    };
    assert!(advance(&mut here, &mut run) > 0);
    let bytes = here.export();
    let there = Session::import(plan, mesh, prepared, Reuse::Reused, &bytes);
    let mut there = there.expect("bytes of this build");
    let mut resumed = there.resume_step(3, 1).expect("a step under way");
    for _ in 0..2 {
        let here = advance(&mut here, &mut run);
        assert_eq!(here, advance(&mut there, &mut resumed));
    }
    let field = |session: &Session| values(session, FieldName::Displacement);
    assert!(difference(&field(&here), &field(&there)) == 0.0);
}

/// Cancels at an iteration.
struct CancelAt<'a> {
    token: &'a CancelToken,
    at: u32,
    seen: u32,
}

impl Observer for CancelAt<'_> {
    fn iteration(&mut self, _record: &IterationRecord) {
        self.seen += 1;
        if self.seen == self.at {
            self.token.cancel();
        }
    }
}

/// The first increment of a session that is cancelled at iteration `at`, and how many it
/// saw.
fn cancelled(session: &mut Session, step: &Step, at: u32) -> (StepReport, u32) {
    let token = CancelToken::new();
    let mut observer = CancelAt {
        token: &token,
        at,
        seen: 0,
    };
    let mut run = session.begin_step(step).expect("a valid step");
    let report = session.advance(&mut run, &mut observer, &token);
    (report.expect("an increment"), observer.seen)
}

#[test]
fn a_cancel_after_a_factor_leaves_the_state_before_the_increment() {
    let (scene, step, mesh) = stiff_top();
    let (whole, seen) = cancelled(&mut open(&scene, &mesh), &step, u32::MAX);
    assert!(whole.factorisations > 0);
    let mut session = open(&scene, &mesh);
    // The last iterations of all are those by the factor.
    let (report, _) = cancelled(&mut session, &step, seen - 1);
    assert_eq!(report.termination, Termination::Cancelled);
    let rest = values(&session, FieldName::Displacement);
    assert!(rest.iter().all(|&u| u == 0.0));
    let again = take(&mut session, &step);
    assert!(close(again[0].strain_energy, whole.strain_energy, 1e-9));
}

#[test]
fn flat_cells_under_a_plane_have_the_exact_layer() {
    for aspect in [10.0, 30.0] {
        let high = 1.0 / aspect;
        let layer = mesh(moved(cube(4), |[x, y, z]| [x, y, high * z]));
        let mut scene = elastic(0.3);
        scene.supports = rollers();
        scene.obstacles = vec![
            obstacle("right", "x1", plane([1.0; 3], [-1.0, 0.0, 0.0])),
            obstacle("press", "z1", plane([0.0, 0.0, high], [0.0, 0.0, -1.0])),
        ];
        let report = solve_one(&scene, &push("press", [0.0, 0.0, -0.02 * high]), &layer);
        let (force, energy) = plane_strain(0.3, 0.02);
        assert!(
            close(-report.obstacles["press"].force[2], force, 1e-6),
            "{aspect}"
        );
        assert!(close(report.strain_energy, energy * high, 1e-6), "{aspect}");
    }
}
