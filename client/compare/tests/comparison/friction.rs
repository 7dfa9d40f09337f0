//! Coulomb friction by the seed's methods: the same forces as one level, for many more
//! applications.

use crate::common::meshes::{cube, mesh, square};
use crate::common::scenes::{HELD, elastic, obstacle, plane, support, travel};
use crate::common::{assert_converged, take};
use crate::harness::open;
use signorini::scene::{Choice, ContactMethod, ContactSpace, Shape};
use signorini::{Scene, Step, StepReport, Termination};

/// A body that touches one rough obstacle, with the functions of the references.
fn rough(mut scene: Scene, (name, on): (&str, &str), shape: Shape, friction: f64) -> Scene {
    let mut floor = obstacle(name, on, shape);
    floor.friction = friction;
    scene.obstacles = vec![floor];
    scene.solver.tolerance = 1e-10;
    scene.solver.contact_space = Choice::Named(ContactSpace::Linear);
    scene
}

/// A block, bonded below, under a plate that presses and slides.
fn slide_block() -> (Scene, [Step; 2]) {
    let mut scene = elastic(0.5);
    scene.supports = vec![support("y0", [Some(0.0), Some(0.0), None])];
    let shape = plane([0.0, 1.0, 0.0], [0.0, -1.0, 0.0]);
    let slide = |increments, x| travel("plate", increments, [x, -0.02, 0.0], [0.0; 3]);
    let steps = [slide(2, 0.0), slide(6, 0.12)];
    (rough(scene, ("plate", "y1"), shape, 0.1), steps)
}

#[test]
fn the_iteration_on_the_threshold_ends_where_one_level_does() {
    assert_slower_agreement(ContactMethod::ThresholdIteration);
}

#[test]
fn springs_on_the_slip_end_where_one_level_does() {
    assert_slower_agreement(ContactMethod::RegularisedFriction);
}

/// In space, where directions of slip are unknown too.
#[test]
fn springs_on_the_slip_know_directions() {
    let forces = [ContactMethod::OneLevel, ContactMethod::RegularisedFriction].map(|method| {
        let mut scene = elastic(0.3);
        scene.supports = vec![support("z0", HELD)];
        let shape = Shape::Sphere {
            centre: [0.45, 0.6, 1.5],
            radius: 0.5,
        };
        let mut scene = rough(scene, ("tool", "z1"), shape, 0.3);
        scene.solver.contact = Choice::Named(method);
        let mut session = open(&scene, &mesh(cube(4)));
        let step = travel("tool", 1, [0.03, 0.01, -0.06], [0.0; 3]);
        let report = take(&mut session, &step).remove(0);
        assert_eq!(report.termination, Termination::Converged, "{report:?}");
        report.obstacles["tool"].force
    });
    let [a, b] = forces;
    for axis in 0..3 {
        assert!((a[axis] - b[axis]).abs() < 1e-6 * a[2].abs(), "{a:?} {b:?}");
    }
    assert!(a[0].abs() > 0.01 * a[2].abs());
}

fn assert_slower_agreement(other: ContactMethod) {
    let runs = [ContactMethod::OneLevel, other].map(|method| {
        let (mut scene, steps) = slide_block();
        scene.solver.contact = Choice::Named(method);
        let mut session = open(&scene, &mesh(square(8)));
        steps
            .iter()
            .flat_map(|step| take(&mut session, step))
            .collect::<Vec<StepReport>>()
    });
    let [one_level, passes] = &runs;
    for (a, b) in one_level.iter().zip(passes) {
        assert_converged(a);
        assert_converged(b);
        assert!(a.newton_steps <= 20, "{}", a.newton_steps);
        assert_eq!((a.threshold_passes, b.newton_steps), (0, 0));
        assert!(b.threshold_passes > b.sqp_iterations || b.sqp_iterations == 0);
        let [x, y] = [a, b].map(|report| report.obstacles["plate"].force);
        let whole = x[0].hypot(x[1]);
        assert!(
            (x[0] - y[0]).hypot(x[1] - y[1]) < 1e-7 * whole,
            "{x:?} {y:?}"
        );
    }
    let counts = runs.map(|run| {
        run.iter()
            .map(|report| report.preconditioner_applications)
            .sum::<u32>()
    });
    assert!(2 * counts[0] < counts[1], "{counts:?}");
}
