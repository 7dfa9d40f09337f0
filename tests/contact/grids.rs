//! Tools given by numbers on a grid beside the same tools in closed form.

use std::sync::Arc;

use crate::common::meshes::{cube, file, mesh};
use crate::common::scenes::{bonded_cube, hertz_sphere, push};
use crate::common::{assert_converged, close, solve};
use crate::tools::difference;
use signorini::StepReport;
use signorini::obstacle::grid::{DistanceGrid, HeightField, Lattice};
use signorini::report::ObstacleResult;
use signorini::scene::Shape;

/// One number a node, the last axis fastest.
pub(crate) fn values<const N: usize>(
    lattice: &Lattice<N>,
    of: impl Fn([f64; N]) -> f64,
) -> Vec<f64> {
    let nodes = lattice.nodes().expect("a grid");
    let place = |index: usize| {
        let mut rest = index;
        let mut place = lattice.origin;
        for axis in (0..N).rev() {
            place[axis] += (rest % lattice.counts[axis]) as f64 * lattice.spacing[axis];
            rest /= lattice.counts[axis];
        }
        place
    };
    (0..nodes).map(|index| of(place(index))).collect()
}

/// The ball of `hertz_sphere` by distances at nodes 0.1 apart, in a box that holds it whole.
fn ball_of_distances() -> Shape {
    let lattice = Lattice {
        counts: [25, 25, 26],
        origin: [-1.15, -1.25, -0.2],
        spacing: [0.1; 3],
    };
    let distance = |[x, y, z]: [f64; 3]| x.hypot(y).hypot(z - 1.0) - 1.0;
    let grid = DistanceGrid::new(lattice, &values(&lattice, distance)).expect("a ball");
    Shape::DistanceGrid(Arc::new(grid))
}

/// Its lower cap by heights, the solid above them.
fn cap_of_heights() -> Shape {
    let lattice = Lattice {
        counts: [25, 25],
        origin: [-0.58, -0.6],
        spacing: [0.05; 2],
    };
    let height = |[x, y]: [f64; 2]| 1.0 - (1.0 - x * x - y * y).sqrt();
    let grid = HeightField::new(lattice, &values(&lattice, height)).expect("a cap");
    Shape::Cavity(Shape::HeightField(Arc::new(grid)).into())
}

/// The quarter block under a tool that comes down by 0.05.
fn pressed(shape: Option<Shape>, name: &str) -> Vec<StepReport> {
    let (mut scene, _) = hertz_sphere(0.5);
    if let Some(shape) = shape {
        scene.obstacles[0].shape = shape;
    }
    let mut step = push("ball", [0.0, 0.0, -0.05]);
    step.increments = 2;
    solve(&scene, &[step], &file(name))
}

fn one(report: &StepReport) -> &ObstacleResult {
    report.obstacles.values().next().expect("a tool")
}

fn assert_alike(found: &[StepReport], exact: &[StepReport]) {
    assert_eq!(found.len(), exact.len());
    for (found, exact) in found.iter().zip(exact) {
        assert_converged(found);
        let (a, b) = (one(found), one(exact));
        let force = difference(a.force, b.force);
        assert!(force < 1e-4, "force {force:e}");
        assert!(close(a.max_pressure, b.max_pressure, 1e-3));
        assert!(found.sqp_iterations <= exact.sqp_iterations + 2);
    }
}

#[test]
fn a_ball_of_distances_or_heights_presses_as_the_ball_does() {
    for mesh in ["indent_l2", "indent_l1"] {
        let exact = pressed(None, mesh);
        assert_alike(&pressed(Some(ball_of_distances()), mesh), &exact);
        assert_alike(&pressed(Some(cap_of_heights()), mesh), &exact);
    }
}

#[test]
fn a_plane_of_heights_or_distances_is_the_half_space() {
    let (scene, step) = bonded_cube();
    let mesh = mesh(cube(3));
    let plane = solve(&scene, std::slice::from_ref(&step), &mesh);
    let flat = Lattice {
        counts: [4, 5],
        origin: [-0.5; 2],
        spacing: [1.0, 0.5],
    };
    let heights = HeightField::new(flat, &[1.0; 20]).expect("a plane");
    let space = Lattice {
        counts: [4; 3],
        origin: [-0.5, -0.5, 0.25],
        spacing: [1.0, 1.0, 0.3],
    };
    let below = |[_, _, z]: [f64; 3]| 1.0 - z;
    let distances = DistanceGrid::new(space, &values(&space, below)).expect("a plane");
    let shapes = [
        Shape::Cavity(Shape::HeightField(Arc::new(heights)).into()),
        Shape::DistanceGrid(Arc::new(distances)),
    ];
    for shape in shapes {
        let mut other = scene.clone();
        other.obstacles[0].shape = shape;
        let found = solve(&other, std::slice::from_ref(&step), &mesh);
        assert_eq!(found.len(), plane.len());
        for (found, plane) in found.iter().zip(&plane) {
            assert_converged(found);
            let force = difference(one(found).force, one(plane).force);
            assert!(force < 1e-8, "force {force:e}");
            assert!(close(found.strain_energy, plane.strain_energy, 1e-8));
        }
    }
}
