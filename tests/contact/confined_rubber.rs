//! A block of rubber in a box without friction, its lid pressed down by a share of the height:
//! homogeneous, under up to 1e5 shear moduli of pressure. An obstacle does what a support does
//! there, and should cost about as much, though the surface under it is free until it presses.

use crate::common::meshes::{cube, mesh, moved, square};
use crate::common::scenes::{obstacle, pull, push, rubber, support};
use crate::common::{assert_converged, close, solve_one};
use signorini::geometry::{Matrix3, rotation_matrix};
use signorini::scene::{RubberModel, Shape, Support};
use signorini::{MeshParts, Scene, StepReport};

/// Applications under an obstacle over those under a support, and some more, at most.
const DEARER: f64 = 1.5;
const FEW: f64 = 6.0;

fn turn(rotation: &Matrix3, x: [f64; 3]) -> [f64; 3] {
    rotation.map(|row| (0..3).map(|i| row[i] * x[i]).sum())
}

/// The sides of the box around `parts` but for its lid, and the axes across them.
fn sides(parts: &MeshParts) -> &'static [(&'static str, usize)] {
    match parts.cell_kind.dimension() {
        2 => &[("x0", 0), ("x1", 0), ("y0", 1)],
        _ => &[("x0", 0), ("x1", 0), ("y0", 1), ("y1", 1), ("z0", 2)],
    }
}

/// Rubber with that bulk over the shear modulus on `supports`.
fn boxed(supports: Vec<Support>, bulk_modulus: f64) -> Scene {
    let model = RubberModel::NeoHookean { shear_modulus: 1.0 };
    let mut scene = rubber(model, Some(bulk_modulus));
    scene.supports = supports;
    scene
}

fn along_axis(&(on, axis): &(&str, usize)) -> Support {
    support(on, std::array::from_fn(|i| (i == axis).then_some(0.0)))
}

fn along_normal(&(on, _): &(&str, usize)) -> Support {
    Support {
        normal: Some(0.0),
        ..support(on, [None; 3])
    }
}

/// The direction of the lid's axis, and its name.
fn lid(parts: &MeshParts) -> (usize, &'static str) {
    let axis = parts.cell_kind.dimension() - 1;
    (axis, ["", "y1", "z1"][axis])
}

fn along(axis: usize, length: f64) -> [f64; 3] {
    std::array::from_fn(|i| if i == axis { length } else { 0.0 })
}

/// The block, turned, under an obstacle.
fn under_obstacle(
    parts: MeshParts,
    side: fn(&(&str, usize)) -> Support,
    (bulk, squeeze): (f64, f64),
    rotation: &Matrix3,
) -> StepReport {
    let (axis, on) = lid(&parts);
    let mut scene = boxed(sides(&parts).iter().map(side).collect(), bulk);
    let shape = Shape::HalfSpace {
        point: turn(rotation, along(axis, 1.0)),
        normal: turn(rotation, along(axis, -1.0)),
    };
    scene.obstacles = vec![obstacle("lid", on, shape)];
    let down = push("lid", turn(rotation, along(axis, -squeeze)));
    solve_one(&scene, &down, &mesh(moved(parts, |x| turn(rotation, x))))
}

/// The block under a support.
fn under_support(parts: MeshParts, (bulk, squeeze): (f64, f64)) -> StepReport {
    let (axis, on) = lid(&parts);
    let mut scene = boxed(sides(&parts).iter().map(along_axis).collect(), bulk);
    let held = |value| std::array::from_fn(|i| (i == axis).then_some(value));
    scene.supports.push(support(on, held(0.0)));
    solve_one(&scene, &pull(on, held(-squeeze), 1), &mesh(parts))
}

/// That the block under an obstacle is the one under a support.
fn assert_same(found: &StepReport, expected: &StepReport) {
    [expected, found].into_iter().for_each(assert_converged);
    assert!(close(found.strain_energy, expected.strain_energy, 1e-7));
}

/// The same at about its cost.
fn assert_no_dearer(parts: fn() -> MeshParts, pressed: (f64, f64)) {
    let expected = under_support(parts(), pressed);
    let standing = rotation_matrix([0.0; 3]);
    let found = under_obstacle(parts(), along_axis, pressed, &standing);
    assert_same(&found, &expected);
    assert_eq!(found.cut_backs, 0);
    let [found, expected] =
        [found, expected].map(|report| f64::from(report.preconditioner_applications));
    assert!(
        found <= DEARER * expected + FEW,
        "{pressed:?}: {found} against {expected} applications"
    );
}

#[test]
fn a_lid_that_is_an_obstacle_costs_what_one_that_is_a_support_does() {
    for bulk in [1e2, 1e4, 1e6] {
        for parts in [|| cube(4), || square(8)] {
            assert_no_dearer(parts, (bulk, 0.01));
            assert_no_dearer(parts, (bulk, 0.1));
        }
    }
    // Springs that are too weak for the pressure make thousands of this mesh.
    assert_no_dearer(|| cube(8), (1e5, 0.05));
}

#[test]
fn a_box_that_stands_obliquely_is_the_same_box() {
    let oblique = rotation_matrix([0.4, -0.7, 0.3]);
    for pressed in [(1e4, 0.1), (1e6, 0.05)] {
        let found = under_obstacle(cube(4), along_normal, pressed, &oblique);
        assert_same(&found, &under_support(cube(4), pressed));
    }
}
