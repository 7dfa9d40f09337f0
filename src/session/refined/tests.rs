use super::*;
use crate::linalg::Workspace;
use crate::linalg::vector::{dot, norm, reproducible_noise};
use crate::mesh::samples;
use crate::model::evaluate::{Evaluation, evaluate};
use crate::model::held::mask;
use crate::model::state::State;
use crate::refinement::{Hierarchy, Limits, Refined};
use crate::report::{CancelToken, Seconds, Silent, StepReport, Termination};
use crate::saddle::Status;
use crate::scene::{
    Formulation, Material, MaterialModel, Modulus, Obstacle, ObstacleTarget, PenetrationPolicy,
    Profile, RubberModel, Scene, Shape, Step, Support, SurfaceGeometry,
};

fn rubber() -> MaterialModel {
    MaterialModel::Rubber {
        model: RubberModel::MooneyRivlin { c10: 0.4, c01: 0.1 },
        bulk_modulus: None,
        formulation: Formulation::Auto,
    }
}

fn linear() -> MaterialModel {
    MaterialModel::LinearElastic {
        modulus: Modulus::Shear(1.0),
        poisson_ratio: 0.5,
        formulation: Formulation::Auto,
    }
}

/// A cube or a square held below, with a tool above.
fn scene(model: MaterialModel, (shape, friction): (Shape, f64)) -> Scene {
    let is_plane = matches!(shape, Shape::Cylinder { .. });
    let [base, top] = if is_plane { ["y0", "y1"] } else { ["z0", "z1"] };
    let across = if is_plane { None } else { Some(0.0) };
    Scene {
        materials: vec![Material {
            group: "body".to_owned(),
            model,
        }],
        supports: vec![Support {
            name: "base".to_owned(),
            on: vec![base.to_owned()],
            normal: None,
            displacement: [Some(0.0), Some(0.0), across],
            profile: Profile::Constant,
            values: None,
            load: Default::default(),
        }],
        obstacles: vec![Obstacle {
            name: "tool".to_owned(),
            on: vec![top.to_owned()],
            shape,
            surface: SurfaceGeometry::default(),
            friction,
            tresca: None,
            initial_penetration: PenetrationPolicy::default(),
        }],
        ..Scene::default()
    }
}

fn plate() -> Shape {
    Shape::HalfSpace {
        point: [0.0, 0.0, 1.0],
        normal: [0.0, 0.0, -1.0],
    }
}

fn ball() -> Shape {
    Shape::Sphere {
        centre: [0.45, 0.55, 2.0],
        radius: 1.0,
    }
}

fn roll() -> Shape {
    Shape::Cylinder {
        point: [0.45, 1.8, 0.0],
        axis: [0.0, 0.0, 1.0],
        radius: 0.8,
    }
}

fn push(travel: [f64; 3]) -> Step {
    Step {
        obstacles: vec![ObstacleTarget {
            name: "tool".to_owned(),
            translation: Some(travel),
            ..ObstacleTarget::default()
        }],
        ..Step::default()
    }
}

fn session(scene: &Scene, mesh: &Arc<Mesh>) -> (Arc<Plan>, Arc<Prepared>, Session) {
    let plan = Plan::new(scene, &[push([0.0; 3])], mesh).expect("a valid scene");
    let plan = Arc::new(plan);
    let prepared = Prepared::build(&plan, mesh, &CancelToken::new()).expect("a solvable body");
    let prepared = Arc::new(prepared);
    let session = Session::new(plan.clone(), mesh.clone(), prepared.clone(), Reuse::Built);
    (plan, prepared, session)
}

fn solve(session: &mut Session, step: &Step) -> StepReport {
    let mut run = session.begin_step(step).expect("a valid step");
    let mut last = None;
    while let Some(report) = session.advance(&mut run, &mut Silent, &CancelToken::new()) {
        assert_eq!(
            report.termination,
            Termination::Converged,
            "{:?}",
            report.cause
        );
        last = Some(report);
    }
    last.expect("a step has an increment")
}

/// A solved session and the one on the refined mesh.
struct Pair {
    coarse: Session,
    fine: Session,
    refined: Refined,
    report: StepReport,
}

fn pair(scene: &Scene, mesh: Mesh, step: &Step) -> Pair {
    let mesh = Arc::new(mesh);
    let (_, _, mut coarse) = session(scene, &mesh);
    let report = solve(&mut coarse, step);
    let hierarchy = Hierarchy::new(mesh.clone());
    let marked: Vec<u32> = (0..mesh.cell_count() as u32).step_by(2).collect();
    let refined = hierarchy
        .refine(&marked, Limits::default())
        .expect("few cells");
    let fine_mesh = refined.hierarchy.mesh().clone();
    let (plan, prepared, _) = session(scene, &fine_mesh);
    let over = (fine_mesh, &refined.lineage);
    let fine = coarse.refined(plan, over, (prepared, Reuse::Reused));
    Pair {
        fine: fine.expect("the state of its own scene"),
        coarse,
        refined,
        report,
    }
}

fn evaluation(session: &Session) -> Evaluation {
    let mut seconds = Seconds::default();
    evaluate(
        &session.body.model(),
        &session.state,
        &mut seconds,
        &mut Workspace::new(),
    )
}

/// What the residuals of force and volume do on test functions of the coarse space, on either.
fn works(pair: &Pair) -> [[f64; 2]; 2] {
    let [coarse, fine] = [&pair.coarse, &pair.fine].map(evaluation);
    let model = pair.coarse.body.model();
    let mut test = reproducible_noise(coarse.force.len());
    mask(&model.prepared.held, &mut test);
    let on_fine = pair
        .refined
        .lineage
        .quadratic(&test, model.prepared.space.components);
    let pressures = reproducible_noise(coarse.constraint.len());
    let fine_pressures = pair.refined.lineage.linear(&pressures);
    [
        [dot(&coarse.force, &test), dot(&fine.force, &on_fine)],
        [
            dot(&coarse.constraint, &pressures),
            dot(&fine.constraint, &fine_pressures),
        ],
    ]
}

fn normal_pressures(session: &Session) -> &[f64] {
    let state: &State = &session.state;
    &state.multiplier[..session.plan().normal_multipliers()]
}

#[test]
fn the_old_solution_leaves_no_residual_in_old_test_functions() {
    let scene = scene(linear(), (plate(), 0.0));
    let pair = pair(&scene, samples::cube(2), &push([0.0, 0.0, -0.05]));
    let coarse = evaluation(&pair.coarse);
    for [before, after] in works(&pair) {
        assert!((before - after).abs() < 1e-12, "{before} {after}");
    }
    assert!(norm(&coarse.force) < 1e-6, "{}", norm(&coarse.force));
    let energies = [&pair.coarse, &pair.fine].map(|session| {
        let weights = session.body.model().interfaces.list[0]
            .surface
            .weights
            .clone();
        dot(&weights, normal_pressures(session))
    });
    assert!(
        (energies[0] - energies[1]).abs() < 1e-13 * energies[0],
        "{energies:?}"
    );
}

#[test]
fn contact_pressures_are_carried_as_functions_and_stay_above_zero() {
    for (scene, mesh, travel) in [
        (
            scene(linear(), (ball(), 0.0)),
            samples::cube(3),
            [0.0, 0.0, -0.04],
        ),
        (
            scene(rubber(), (ball(), 0.4)),
            samples::cube(2),
            [0.03, 0.0, -0.15],
        ),
        (
            scene(rubber(), (roll(), 0.3)),
            samples::rectangle(4, 4),
            [0.03, -0.1, 0.0],
        ),
    ] {
        let pair = pair(&scene, mesh, &push(travel));
        let (coarse, fine) = (normal_pressures(&pair.coarse), normal_pressures(&pair.fine));
        assert!(fine.iter().all(|l| *l >= 0.0) && fine.iter().any(|l| *l > 0.0));
        let weights = |session: &Session| {
            session.body.model().interfaces.list[0]
                .surface
                .weights
                .clone()
        };
        let [before, after] = [
            dot(&weights(&pair.coarse), coarse),
            dot(&weights(&pair.fine), fine),
        ];
        // int lambda dS over the undeformed surface.
        assert!((before - after).abs() < 1e-13 * before, "{before} {after}");
        let statuses = fine.iter().zip(&pair.fine.state.status);
        for (l, status) in statuses {
            assert_eq!(status.is_closed(), *l > 0.0);
        }
    }
}

#[test]
fn tractions_stay_in_their_cones_and_the_slip_of_a_point_is_kept() {
    let scene = scene(rubber(), (plate(), 0.4));
    let pair = pair(&scene, samples::cube(2), &push([0.05, 0.02, -0.08]));
    let (model, state) = (pair.fine.body.model(), &pair.fine.state);
    let friction = model.interfaces.friction.as_ref().expect("it rubs");
    let radii = friction
        .law(model.plan, &state.drive)
        .radii(&state.multiplier);
    let tractions = state.multiplier[friction.first..].chunks(2);
    for (traction, radius) in tractions.zip(radii) {
        assert!(norm(traction) <= radius * (1.0 + 1e-7) + 1e-14);
    }
    let slipping = state.status[friction.first..].iter();
    assert!(slipping.clone().any(|status| *status != Status::Open));
    assert_eq!(state.slip.travel.len(), 3 * friction.points.len());
    let [before, after] = [&pair.coarse, &pair.fine].map(|session| session.state.slip.total[0]);
    assert!((before - after).abs() < 1e-14 * before.abs());
}

#[test]
fn a_step_goes_on_upon_the_refined_mesh() {
    let scene = scene(rubber(), (ball(), 0.0));
    let mut pair = pair(&scene, samples::cube(2), &push([0.0, 0.0, -0.15]));
    let again = solve(&mut pair.fine, &push([0.0, 0.0, -0.15]));
    let [before, after] =
        [&pair.report, &again].map(|report| report.obstacles["tool"].force[2].abs());
    assert!((before - after).abs() < 0.1 * before, "{before} {after}");
    assert_eq!(again.step, 2);
    assert!(
        again.sqp_iterations <= pair.report.sqp_iterations,
        "{}",
        again.sqp_iterations
    );
}

#[test]
fn a_lineage_of_other_meshes_is_refused() {
    let scene = scene(linear(), (plate(), 0.0));
    let mesh = Arc::new(samples::cube(2));
    let (_, _, mut own) = session(&scene, &mesh);
    let other = Hierarchy::new(Arc::new(samples::cube(1)));
    let refined = other.refine(&[0], Limits::default()).expect("few cells");
    let (plan, prepared, _) = session(&scene, &mesh);
    let over = (mesh, &refined.lineage);
    let refused = own.refined(plan, over, (prepared, Reuse::Reused));
    assert_eq!(refused.err(), Some(NotCarried::Foreign("the mesh")));
}
