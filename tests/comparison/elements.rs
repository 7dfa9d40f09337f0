//! MINI and Bernardi-Raugel, the elements that Taylor-Hood is compared with:
//! orders, unknowns, counts, and what they refuse.

use crate::common::meshes::{cube, file, irregular, mesh, square};
use crate::common::scenes::{
    HELD, cube_bend, elastic, hertz_sphere, obstacle, push, support, traction,
};
use crate::common::{close, run_one, solve_one, values};
use signorini::scene::{Choice, DisplacementMethod, Profile, Shape, Support};
use signorini::{FieldName, MeshParts, Plan, Scene, SceneError, Step, StepReport};

const MINI: &str = "mini";
const BERNARDI_RAUGEL: &str = "bernardi-raugel";

/// `scene` on another element.
fn on(element: &str, mut scene: Scene) -> Scene {
    scene.solver.element = element.parse().expect("an element");
    scene.solver.verify = false;
    scene
}

fn manufactured(element: &str, field: &str, parts: MeshParts) -> StepReport {
    let mut scene = on(element, elastic(0.5));
    scene.supports = vec![support("x0", HELD)];
    scene.manufactured = Some(field.to_owned());
    solve_one(&scene, &Step::default(), &mesh(parts))
}

/// Errors of displacement in L2 and H1 and of pressure in L2.
fn errors(report: &StepReport) -> [f64; 3] {
    let errors = report.errors.expect("a manufactured scene has errors");
    let pressure = errors.pressure_l2.expect("a mixed element has a pressure");
    [errors.displacement_l2, errors.displacement_h1, pressure]
}

/// Orders of convergence when cells are halved.
fn orders(
    element: &str,
    field: &str,
    parts: impl Fn(usize) -> MeshParts,
    cells: usize,
) -> [f64; 3] {
    let coarse = errors(&manufactured(element, field, parts(cells)));
    let fine = errors(&manufactured(element, field, parts(2 * cells)));
    std::array::from_fn(|i| (coarse[i] / fine[i]).log2())
}

#[test]
fn mini_has_second_order_displacements_and_first_order_gradients() {
    let plane = orders(MINI, "vortex", |n| irregular(square(n), n), 32);
    assert!(
        plane[0] >= 1.95 && plane[1] >= 0.98 && plane[2] >= 1.0,
        "{plane:?}"
    );
    // Meshes of this size do not show the order of displacements in space yet.
    let solid = orders(MINI, "trigonometric", cube, 8);
    assert!(
        solid[0] >= 1.75 && solid[1] >= 0.98 && solid[2] >= 0.95,
        "{solid:?}"
    );
}

#[test]
fn bernardi_raugel_has_first_order_gradients_and_pressures() {
    let plane = orders(BERNARDI_RAUGEL, "vortex", |n| irregular(square(n), n), 32);
    assert!(
        plane[0] >= 1.95 && plane[1] >= 0.98 && plane[2] >= 0.98,
        "{plane:?}"
    );
    // Nor that of pressures.
    let solid = orders(BERNARDI_RAUGEL, "trigonometric", cube, 8);
    assert!(
        solid[0] >= 1.75 && solid[1] >= 0.97 && solid[2] >= 0.8,
        "{solid:?}"
    );
}

#[test]
fn iterations_do_not_grow_with_the_mesh() {
    let plane = |element, n| manufactured(element, "vortex", square(n)).krylov_iterations;
    let solid = |element, n| manufactured(element, "trigonometric", cube(n)).krylov_iterations;
    let flat = [
        [16, 32, 64].map(|n| plane(MINI, n)),
        [16, 32, 64].map(|n| plane(BERNARDI_RAUGEL, n)),
        [4, 8, 12].map(|n| solid(BERNARDI_RAUGEL, n)),
    ];
    for counts in flat {
        assert!(
            counts
                .iter()
                .all(|&n| n.abs_diff(counts[0]) <= 4 && n <= 36),
            "{counts:?}"
        );
    }
    // Bubbles of tetrahedra hold the pressure weakly: 40 at 4, 62 at 20 cells a side.
    let counts = [4, 8, 12].map(|n| solid(MINI, n));
    assert!(counts.iter().all(|&n| n <= 56), "{counts:?}");
}

#[test]
fn unknowns_per_vertex_are_those_of_the_elements() {
    let mesh = mesh(cube(8));
    let unknowns = |element: &str| {
        let plan = Plan::new(&on(element, cube_bend(0.5)), &[], &mesh).expect("a valid scene");
        (plan.unknowns().displacement, plan.unknowns().pressure)
    };
    let (vertices, cells) = (729, 6 * 512);
    assert_eq!(unknowns(MINI), (3 * vertices + 3 * cells, vertices));
    let facets = 12 * 512 + 6 * 64;
    assert_eq!(unknowns(BERNARDI_RAUGEL), (3 * vertices + facets, cells));
}

#[test]
fn a_bent_cube_nears_the_one_of_taylor_hood() {
    let mesh = mesh(cube(8));
    let best = solve_one(&cube_bend(0.5), &Step::default(), &mesh);
    for element in [MINI, BERNARDI_RAUGEL] {
        let scene = on(element, cube_bend(0.5));
        let (session, report) = run_one(&scene, &Step::default(), &mesh);
        let (tip, exact) = (&report.probes["corner"], &best.probes["corner"]);
        assert!(
            close(tip.displacement[2], exact.displacement[2], 0.12),
            "{element}: {tip:?}"
        );
        assert!(close(report.strain_energy, best.strain_energy, 0.12));
        // The support bears the whole load, and no volume is lost.
        assert!(close(report.supports["x0"].force[2], 1.0, 1e-7));
        assert!((report.volume_ratio - 1.0).abs() < 1e-8);
        let nodes = mesh.coordinates().len() + mesh.edges().len();
        assert_eq!(values(&session, FieldName::Displacement).len(), 3 * nodes);
        assert_eq!(
            values(&session, FieldName::Pressure).len(),
            mesh.coordinates().len()
        );
    }
}

#[test]
fn a_nearly_incompressible_cube_is_near_the_incompressible_one() {
    let mesh = mesh(cube(4));
    for element in [MINI, BERNARDI_RAUGEL] {
        let tip = |poisson_ratio| {
            let scene = on(element, cube_bend(poisson_ratio));
            solve_one(&scene, &Step::default(), &mesh).probes["corner"].displacement[2]
        };
        assert!(close(tip(0.499_999), tip(0.5), 1e-4));
        assert!(!close(tip(0.45), tip(0.5), 1e-3));
    }
}

#[test]
fn prescribed_flow_goes_through_every_facet_of_the_inlet() {
    // The bubbles of held facets carry what the vertices leave of the parabola.
    let plane = |on: &str, x: f64, profile| Support {
        profile,
        ..support(on, [Some(x), Some(0.0), None])
    };
    let mut scene = on(BERNARDI_RAUGEL, elastic(0.5));
    scene.supports = vec![
        plane("x0", 1.0, Profile::Parabolic),
        plane("y0", 0.0, Profile::Constant),
        plane("y1", 0.0, Profile::Constant),
        plane("x1", 1.0, Profile::Parabolic),
    ];
    let report = solve_one(&scene, &Step::default(), &mesh(square(6)));
    assert!((report.volume_ratio - 1.0).abs() < 1e-9);
}

#[test]
fn increments_of_a_linear_body_add_up() {
    let mesh = mesh(cube(3));
    for element in [MINI, BERNARDI_RAUGEL] {
        let scene = on(element, cube_bend(0.5));
        let step = Step {
            increments: 2,
            ..Step::default()
        };
        let reports = crate::common::solve(&scene, &[step], &mesh);
        let tip = |report: &StepReport| report.probes["corner"].displacement[2];
        assert!(close(2.0 * tip(&reports[0]), tip(&reports[1]), 1e-6));
        assert!((reports[0].time - 0.5).abs() < 1e-15);
    }
}

#[test]
fn what_the_comparison_elements_do_not_serve_is_refused_by_its_key() {
    let floor = Shape::HalfSpace {
        point: [0.0; 3],
        normal: [0.0, 0.0, 1.0],
    };
    let mut contact = on(BERNARDI_RAUGEL, cube_bend(0.5));
    contact.obstacles = vec![obstacle("floor", "z0", floor)];
    let mut verified = on(MINI, cube_bend(0.5));
    verified.solver.verify = true;
    let mut method = on(MINI, cube_bend(0.5));
    method.solver.displacement_preconditioner = Choice::Named(DisplacementMethod::PMultigrid);
    let cases = [
        (on(MINI, cube_bend(0.3)), "solver.element"),
        (contact, "obstacle.floor"),
        (verified, "solver.verify"),
        (method, "solver.displacement_preconditioner"),
    ];
    for (scene, path) in cases {
        match Plan::new(&scene, &[], &mesh(cube(2))) {
            Err(SceneError::Unsupported(violation)) => assert_eq!(violation.path, path),
            other => panic!("{path}: {other:?}"),
        }
    }
}

#[test]
fn tractions_and_body_forces_load_bubbles_too() {
    // A hydrostatic state: the pressure balances the load, nothing moves.
    let mut scene = elastic(0.5);
    scene.supports = vec![
        support("z0", HELD),
        support("x0", [Some(0.0), None, None]),
        support("x1", [Some(0.0), None, None]),
        support("y0", [None, Some(0.0), None]),
        support("y1", [None, Some(0.0), None]),
    ];
    scene.tractions = vec![traction("z1", [0.0, 0.0, -2.0])];
    for element in [MINI, BERNARDI_RAUGEL] {
        let scene = on(element, scene.clone());
        let (session, _) = run_one(&scene, &Step::default(), &mesh(irregular(cube(3), 3)));
        let still = values(&session, FieldName::Displacement);
        assert!(still.iter().all(|u| u.abs() < 1e-7), "{element}");
        for pressure in values(&session, FieldName::Pressure) {
            assert!((pressure - 2.0).abs() < 1e-6, "{element}: {pressure}");
        }
    }
}

/// The top of a block on three sliding sides, pressed down by a plane.
fn pressed_block(depth: f64) -> (Scene, Step) {
    let mut scene = on(MINI, elastic(0.5));
    scene.supports = vec![
        support("z0", [None, None, Some(0.0)]),
        support("x0", [Some(0.0), None, None]),
        support("y0", [None, Some(0.0), None]),
    ];
    let shape = Shape::HalfSpace {
        point: [0.0, 0.0, 1.0],
        normal: [0.0, 0.0, -1.0],
    };
    scene.obstacles = vec![obstacle("plate", "z1", shape)];
    (scene, push("plate", [0.0, 0.0, -depth]))
}

#[test]
fn mini_passes_the_contact_patch_test() {
    let depth = 0.01;
    let (scene, step) = pressed_block(depth);
    let (session, report) = run_one(&scene, &step, &mesh(irregular(cube(3), 3)));
    // Young's modulus of an incompressible body is three times its shear modulus.
    let exact = 3.0 * depth;
    assert!(close(report.obstacles["plate"].force[2], -exact, 1e-7));
    assert!(close(report.obstacles["plate"].contact_area, 1.0, 1e-12));
    let held = report.supports["z0"].force[2];
    assert!(close(held, exact, 1e-7), "{held}");
    let pressures = values(&session, FieldName::ContactPressure);
    let touching: Vec<f64> = pressures.into_iter().filter(|&l| l != 0.0).collect();
    assert_eq!(touching.len(), 16);
    assert!(
        touching.iter().all(|&l| close(l, exact, 1e-6)),
        "{touching:?}"
    );
}

#[test]
fn mini_finds_the_contact_of_a_sphere() {
    let mesh = file("indent_l2");
    let (mut scene, step) = hertz_sphere(0.5);
    scene.solver.tolerance = 1e-8;
    let best = solve_one(&scene, &step, &mesh);
    let report = solve_one(&on(MINI, scene), &step, &mesh);
    let force = |report: &StepReport| report.obstacles["ball"].force;
    assert!(
        close(force(&report)[2], force(&best)[2], 0.1),
        "{:?}",
        force(&report)
    );
    let sum: f64 = report.supports.values().map(|s| s.force[2]).sum();
    assert!((sum + force(&report)[2]).abs() < 1e-6 * sum.abs());
    assert!(report.active_vertices > 5 && report.residuals.largest() <= 1e-8);
}
