//! What a solve takes from the heap: nothing inside an iteration, nothing for what
//! a scene does not have. The heap is counted, so the stories run one at a time.

mod common;

use std::alloc::System;
use std::sync::{Arc, Mutex, PoisonError};

use cap::Cap;
use common::meshes::{cube, file, mesh};
use common::scenes::{HELD, cube_bend, hertz_plane, obstacle, support};
use common::{assert_converged, open};
use signorini::contact::gap::{Deformed, Measure};
use signorini::contact::{ContactSurface, evaluate_gaps};
use signorini::element::quadrature::{Simplex, rule};
use signorini::obstacle::Sphere;
use signorini::scene::{Choice, MaterialModel, P1Solver, Shape};
use signorini::space::TaylorHood;
use signorini::{
    CancelToken, FieldName, GroupKind, Mesh, Scene, Session, Silent, Step, StepReport,
};

#[global_allocator]
static HEAP: Cap<System> = Cap::new(System, usize::MAX);

static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

/// Runs `story` on one thread while no other story runs: pools of threads keep
/// queues on the heap.
fn counted<T: Send>(story: impl FnOnce() -> T + Send) -> T {
    let guard = ONE_AT_A_TIME.lock();
    let _alone = guard.unwrap_or_else(PoisonError::into_inner);
    let pool = rayon_of_one();
    pool.install(story)
}

fn rayon_of_one() -> rayon::ThreadPool {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    pool.expect("a pool of one thread")
}

/// Takes the only increment of a step; the bytes that it asked the heap for.
fn bytes_of_step(session: &mut Session, step: &Step) -> (StepReport, usize) {
    let mut run = session.begin_step(step).expect("a valid step");
    let before = HEAP.total_allocated();
    let report = session.advance(&mut run, &mut Silent, &CancelToken::new());
    let bytes = HEAP.total_allocated() - before;
    (report.expect("one increment"), bytes)
}

/// Bytes asked for by each iteration beyond those of a looser tolerance.
fn bytes_of_an_iteration(scene: &Scene, step: &Step, mesh: &Arc<Mesh>) -> f64 {
    // Long solves of incompressible bodies without contact come to keep more directions.
    let tolerances = match scene.obstacles.is_empty() && !scene_is_compressible(scene) {
        true => [1e-4, 1e-8],
        false => [1e-5, 1e-11],
    };
    let solved = tolerances.map(|tolerance| {
        let mut scene = scene.clone();
        scene.solver.tolerance = tolerance;
        scene.solver.verify = false;
        let (report, bytes) = bytes_of_step(&mut open(&scene, mesh), step);
        assert_converged(&report);
        (f64::from(report.krylov_iterations), bytes as f64)
    });
    let [(few, loose), (many, tight)] = solved;
    // GCR has all five directions that it keeps before the looser solve ends.
    assert!(few > 5.0 || scene_is_compressible(scene), "{few}");
    assert!(many >= few + 8.0, "{few} {many}");
    (tight - loose) / (many - few)
}

fn scene_is_compressible(scene: &Scene) -> bool {
    scene.materials.iter().any(|material| match material.model {
        MaterialModel::LinearElastic { poisson_ratio, .. } => poisson_ratio < 0.45,
        MaterialModel::Stokes { .. } | MaterialModel::Rubber { .. } => false,
    })
}

/// Bytes of one displacement vector.
fn vector_bytes(session: &Session) -> f64 {
    let field = session.field(FieldName::Displacement);
    8.0 * field.expect("every scene has it").values.len() as f64
}

#[test]
fn an_iteration_of_an_incompressible_body_takes_no_vector_from_the_heap() {
    counted(|| {
        let (scene, mesh) = (cube_bend(0.5), mesh(cube(6)));
        let vector = vector_bytes(&open(&scene, &mesh));
        let bytes = bytes_of_an_iteration(&scene, &Step::default(), &mesh);
        assert!(
            bytes < 0.25 * vector,
            "{bytes} bytes, a vector has {vector}"
        );
    });
}

#[test]
fn an_iteration_with_multigrid_takes_nothing_from_the_heap() {
    counted(|| {
        let (mut scene, mesh) = (cube_bend(0.5), mesh(cube(6)));
        scene.solver.p1_solver = Choice::Named(P1Solver::Amg);
        let bytes = bytes_of_an_iteration(&scene, &Step::default(), &mesh);
        assert!(bytes < 600.0, "{bytes} bytes");
    });
}

#[test]
fn an_iteration_of_a_compressible_body_takes_no_vector_from_the_heap() {
    counted(|| {
        let (scene, mesh) = (cube_bend(0.3), mesh(cube(6)));
        let vector = vector_bytes(&open(&scene, &mesh));
        let bytes = bytes_of_an_iteration(&scene, &Step::default(), &mesh);
        assert!(
            bytes < 0.25 * vector,
            "{bytes} bytes, a vector has {vector}"
        );
    });
}

#[test]
fn an_iteration_of_a_contact_takes_no_vector_from_the_heap() {
    counted(|| {
        let (scene, step) = hertz_plane(0.5);
        let mesh = file("hemi_l1");
        let vector = vector_bytes(&open(&scene, &mesh));
        let bytes = bytes_of_an_iteration(&scene, &step, &mesh);
        // Each review of the face makes a factor of what is closed, with what volumes take off it.
        assert!(bytes < vector, "{bytes} bytes, a vector has {vector}");
    });
}

#[test]
fn a_contact_integral_takes_nothing_from_the_heap_for_a_point() {
    counted(|| {
        let mesh = mesh(cube(8));
        let space = TaylorHood::new(&mesh);
        let group = mesh.group("z1", GroupKind::Facets).expect("a side");
        let facets = group.members.iter();
        let facets: Vec<Vec<u32>> = facets.map(|&f| mesh.facet(f as usize).to_vec()).collect();
        let surface = ContactSurface::new(&mesh, &space, 1.0, &facets);
        let body = Deformed {
            mesh: &mesh,
            scale: 1.0,
            space: &space,
            displacement: &vec![0.0; space.displacement_unknowns()],
            rule: &rule(Simplex::Triangle, 8),
            measure: Measure::Undeformed,
        };
        let ball = Sphere::new([0.5, 0.5, 2.0], 1.0).expect("a ball");
        let before = HEAP.total_allocated();
        let (gaps, _) = evaluate_gaps(&body, &surface, &ball);
        let bytes = (HEAP.total_allocated() - before) as f64;
        // What each of three functions gains at each point is kept until it is summed.
        let kept = 8 * (facets.len() * (1 + 3 * body.rule.len()) + gaps.len());
        assert!(bytes < 1.3 * kept as f64, "{bytes} bytes, {kept} kept");
    });
}

/// Bytes that plan, prepared data and session hold, and those that they tell. A
/// mesh finds its edges once, for all who use it: that is not counted.
fn held_and_told(scene: &Scene, mesh: &Arc<Mesh>) -> (f64, f64) {
    drop(open(scene, mesh));
    let before = HEAP.allocated();
    let mut session = open(scene, mesh);
    let (report, _) = bytes_of_step(&mut session, &Step::default());
    let held = HEAP.allocated() - before;
    (held as f64, report.memory_bytes as f64)
}

#[test]
fn nothing_is_held_that_is_not_told() {
    counted(|| {
        let mesh = mesh(cube(8));
        for poisson_ratio in [0.3, 0.5] {
            let (held, told) = held_and_told(&cube_bend(poisson_ratio), &mesh);
            assert!(
                held < 1.25 * told,
                "{poisson_ratio}: {held} bytes held, {told} told"
            );
        }
    });
}

#[test]
fn a_compressible_body_holds_no_pressure() {
    counted(|| {
        let mesh = mesh(cube(8));
        let mut session = open(&cube_bend(0.3), &mesh);
        bytes_of_step(&mut session, &Step::default());
        assert!(session.field(FieldName::Pressure).is_none());
        drop(session);
        let (mixed, _) = held_and_told(&cube_bend(0.5), &mesh);
        let (plain, _) = held_and_told(&cube_bend(0.3), &mesh);
        // At the very least the directions that GCR keeps, of which conjugate gradients
        // have none: 2 x 10 vectors of displacement and pressure.
        let vectors = 20.0 * 8.0 * (3.0 * 17.0_f64.powi(3) + 9.0_f64.powi(3));
        assert!(mixed - plain > 0.9 * vectors, "{mixed} {plain} {vectors}");
    });
}

#[test]
fn a_scene_without_contact_holds_no_contact_matrix() {
    counted(|| {
        let mesh = mesh(cube(8));
        let free = cube_bend(0.5);
        let mut touching = free.clone();
        touching.supports = vec![support("x0", HELD)];
        let shape = Shape::HalfSpace {
            point: [0.0, 0.0, 9.0],
            normal: [0.0, 0.0, -1.0],
        };
        touching.obstacles = vec![obstacle("far", "z1", shape)];
        let (without, told) = held_and_told(&free, &mesh);
        let (with, _) = held_and_told(&touching, &mesh);
        // The inverse of the P1 stiffness on 9 x 9 candidates, three components each.
        let compliance = 8.0 * 243.0_f64.powi(2);
        assert!(with - without > compliance, "{with} {without} {compliance}");
        assert!(without < 1.25 * told, "{without} held, {told} told");
    });
}
