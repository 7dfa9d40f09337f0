use std::sync::Arc;

use proptest::prelude::*;

use super::spline::{Beyond, Spline};
use super::*;
use crate::geometry::vector3::{add, norm, scale, sub};
use crate::obstacle::{Cavity, Contact, Derivatives, Obstacle, Shape, Sphere};

pub(super) fn values<const N: usize>(
    lattice: &Lattice<N>,
    of: impl Fn([f64; N]) -> f64,
) -> Vec<f64> {
    let nodes = 0..lattice.nodes().expect("a grid");
    let place = |index| lattice.place(lattice.node(index).map(|i| i as f64));
    nodes.map(|index| of(place(index))).collect()
}

pub(super) fn lattice<const N: usize>(count: usize, low: [f64; N], spacing: f64) -> Lattice<N> {
    Lattice {
        counts: [count; N],
        origin: low,
        spacing: [spacing; N],
    }
}

const CENTRE: [f64; 3] = [0.1, -0.2, 0.05];

/// A ball of radius 1 around `CENTRE`, in a cube of half its size 1.5.
fn ball(count: usize) -> DistanceGrid {
    let lattice = lattice(count, [-1.5; 3], 3.0 / (count - 1) as f64);
    let values = values(&lattice, |x| norm(sub(x, CENTRE)) - 1.0);
    DistanceGrid::new(lattice, &values).expect("a ball")
}

/// The lower cap of the same ball, over a square of half its size 0.6 below its centre.
fn cap(count: usize) -> HeightField {
    let [a, b, c] = CENTRE;
    let lattice = lattice(count, [a - 0.6, b - 0.6], 1.2 / (count - 1) as f64);
    let low = |[x, y]: [f64; 2]| c - (1.0 - (x - a).powi(2) - (y - b).powi(2)).sqrt();
    HeightField::new(lattice, &values(&lattice, low)).expect("a cap")
}

/// Waves of a smallest radius of about 1.
fn waves() -> HeightField {
    let lattice = lattice(33, [-2.0; 2], 0.125);
    let wave = |[x, y]: [f64; 2]| 0.2 * (1.7 * x).sin() * (1.3 * y + 0.4).cos() + 0.3 * x;
    HeightField::new(lattice, &values(&lattice, wave)).expect("waves")
}

fn built(shape: &Shape) -> Arc<dyn Obstacle> {
    shape.build(1.0).expect("valid")
}

fn distance_grid(grid: DistanceGrid) -> Shape {
    Shape::DistanceGrid(Arc::new(grid))
}

fn height_field(grid: HeightField) -> Shape {
    Shape::HeightField(Arc::new(grid))
}

#[test]
fn a_spline_through_a_cubic_is_the_cubic_up_to_the_border() {
    let lattice = Lattice {
        counts: [4, 7, 5],
        origin: [-1.0, 0.5, 2.0],
        spacing: [0.5, 0.25, 0.75],
    };
    let cubic = |x: f64| 1.0 + x - 0.5 * x * x + 0.25 * x.powi(3);
    let slope = |x: f64| 1.0 - x + 0.75 * x * x;
    let bend = |x: f64| -1.0 + 1.5 * x;
    let product = |[x, y, z]: [f64; 3]| cubic(x) * cubic(y) * cubic(z);
    let spline = Spline::new(lattice, &values(&lattice, product), Beyond::Clamped);
    for place in [
        [-1.0, 0.5, 2.0],
        [0.5, 2.0, 5.0],
        [0.31, 1.07, 3.3],
        [-0.9, 1.99, 4.8],
    ] {
        let [x, y, z] = place;
        let jet = spline.jet(place);
        assert!((jet.value - product(place)).abs() < 1e-11);
        let exact = [
            slope(x) * cubic(y) * cubic(z),
            cubic(x) * slope(y) * cubic(z),
            cubic(x) * cubic(y) * slope(z),
        ];
        assert!(norm(sub(jet.gradient, exact)) < 1e-10);
        let bent = [
            bend(x) * cubic(y) * cubic(z),
            slope(x) * slope(y) * cubic(z),
            cubic(x) * slope(y) * slope(z),
        ];
        assert!(
            norm(sub(
                [0, 1, 2].map(|k| jet.hessian[[0, 0, 1][k]][[0, 1, 2][k]]),
                bent
            )) < 1e-9
        );
    }
}

#[test]
fn heights_become_flat_over_three_cells_without_a_jump() {
    let lattice = lattice(6, [0.0; 2], 0.5);
    let spline = Spline::new(
        lattice,
        &values(&lattice, |[x, y]| 0.3 * x + 0.2 * x * y),
        Beyond::Flat,
    );
    let at = |x: f64| spline.jet([x, 1.2]);
    for x in [-20.0, -1.5, 4.0, 1e9] {
        let edge = at(if x < 0.0 { 0.0 } else { 2.5 }).value;
        assert!((at(x).value - edge).abs() < 1e-14);
        assert!(at(x).gradient[0].abs() < 1e-14 && at(x).hessian[0][0].abs() < 1e-14);
    }
    // The second derivative does not jump where the grid ends, nor where the rest begins.
    for x in [-1.5, -0.5, 0.0, 2.5, 3.0, 4.0] {
        let [before, after] = [-1e-9, 1e-9].map(|by| at(x + by).hessian);
        let jump = (before[0][0] - after[0][0]).abs() + (before[0][1] - after[0][1]).abs();
        assert!(jump < 1e-7, "{x}: {jump:e}");
    }
}

/// Largest differences of distance, normal and curvature from the ball's, near its surface.
fn errors(tool: &dyn Obstacle, inside_out: f64) -> [f64; 3] {
    let exact = Sphere::new(CENTRE, 1.0).expect("a ball");
    let mut worst = [0.0_f64; 3];
    for i in 0..200 {
        let turn = 2.4 * f64::from(i);
        let share = 0.4 * (f64::from(i) / 200.0).sqrt();
        let radius = 1.0 + 0.1 * turn.sin();
        let side = [share * turn.cos(), share * turn.sin()];
        let low = -(1.0 - side[0] * side[0] - side[1] * side[1]).sqrt();
        let x = add(CENTRE, scale(radius, [side[0], side[1], low]));
        let (a, b) = (tool.distance(x), exact.distance(x));
        let bent = |i: usize| norm(sub(a.curvature[i], scale(inside_out, b.curvature[i])));
        worst[0] = worst[0].max((a.distance - inside_out * b.distance).abs());
        worst[1] = worst[1].max(norm(sub(a.normal, scale(inside_out, b.normal))));
        worst[2] = worst[2].max(bent(0).max(bent(1)).max(bent(2)));
    }
    worst
}

#[test]
fn grids_of_a_ball_tend_to_it_with_the_fourth_order() {
    let grids = [21, 41].map(|count| errors(&*built(&distance_grid(ball(count))), 1.0));
    let caps = [13, 25].map(|count| {
        let cavity = Shape::Cavity(height_field(cap(count)).into());
        errors(&*built(&cavity), 1.0)
    });
    for ([coarse, fine], limits) in [(grids, [2e-6, 6e-5, 6e-3]), (caps, [2e-6, 6e-5, 6e-3])] {
        for k in 0..3 {
            assert!(fine[k] < limits[k], "{coarse:?} {fine:?}");
        }
        assert!(coarse[0] > 10.0 * fine[0], "{coarse:?} {fine:?}");
    }
}

#[test]
fn a_plane_is_the_half_space() {
    let flat = lattice(4, [-1.0, -2.0], 1.5);
    let plane = |[x, y]: [f64; 2]| 0.25 + 0.5 * x - 0.3 * y;
    let field = HeightField::new(flat, &values(&flat, plane)).expect("a plane");
    let half_space = Shape::HalfSpace {
        point: [0.0, 0.0, 0.25],
        normal: [-0.5, 0.3, 1.0],
    };
    let grid = lattice(5, [-2.0; 3], 1.0);
    let of_plane = built(&half_space);
    let distances = values(&grid, |x| of_plane.distance(x).distance);
    let grid = DistanceGrid::new(grid, &distances).expect("a plane");
    for tool in [height_field(field), distance_grid(grid)] {
        for point in [[0.3, 0.1, 0.9], [0.0, -0.4, -0.2], [0.7, 0.2, 0.5]] {
            let (a, b) = (built(&tool).distance(point), of_plane.distance(point));
            assert!((a.distance - b.distance).abs() < 1e-13, "{a:?} {b:?}");
            assert!(norm(sub(a.normal, b.normal)) < 1e-13);
            assert!(a.curvature.as_flattened().iter().all(|x| x.abs() < 1e-12));
        }
    }
}

#[test]
fn no_place_of_a_surface_is_nearer_than_the_distance() {
    let (waves, spline) = (built(&height_field(waves())), waves());
    for i in 0..60 {
        let turn = 2.4 * f64::from(i);
        let x = [
            1.2 * turn.cos(),
            1.1 * turn.sin(),
            0.02 * f64::from(i) - 0.5,
        ];
        let found = waves.distance(x).distance.abs();
        let mut least = f64::INFINITY;
        for row in -60..=60 {
            for column in -60..=60 {
                let [a, b] = [
                    x[0] + f64::from(row) / 50.0,
                    x[1] + f64::from(column) / 50.0,
                ];
                let height = -foot::Level::jet(&spline, [a, b, 0.0]).value;
                least = least.min(norm(sub(x, [a, b, height])));
            }
        }
        assert!(found <= least + 1e-12, "{x:?}: {found} {least}");
        assert!(least <= found.hypot(0.02), "{x:?}: {found} {least}");
    }
}

#[test]
fn far_points_are_far_and_all_is_finite() {
    let tools = [distance_grid(ball(21)), height_field(waves())].map(|shape| built(&shape));
    for tool in tools {
        for point in [[0.3, 40.0, 700.0], [-1e9, 3.0, 1e9], [1e150, 0.0, 1e150]] {
            let found = tool.distance(point);
            assert!(
                found.distance > 39.0 && found.distance.is_finite(),
                "{found:?}"
            );
            assert!((norm(found.normal) - 1.0).abs() < 1e-12);
        }
    }
    // Beyond the grid the distance is still that of the ball, and in its middle all is finite.
    let tool = built(&distance_grid(ball(41)));
    let beyond = tool.distance([3.0, 2.0, -2.5]).distance;
    let exact = norm(sub([3.0, 2.0, -2.5], CENTRE)) - 1.0;
    assert!((beyond - exact).abs() < 1e-5, "{beyond} {exact}");
    let middle = tool.distance(CENTRE);
    assert!(
        middle
            .curvature
            .as_flattened()
            .iter()
            .all(|x| x.is_finite())
    );
    assert!((middle.distance + 1.0).abs() < 0.1);
}

#[test]
fn a_tool_that_the_border_cuts_ends_near_it() {
    let lattice = lattice(5, [-2.0; 3], 1.0);
    let plate = DistanceGrid::new(lattice, &values(&lattice, |[_, _, z]| z)).expect("a plate");
    let plate = built(&distance_grid(plate));
    assert!((plate.distance([5.0, 0.0, -1.0]).distance - (3.0 - 1.0)).abs() < 1e-12);
    assert!(!plate.is_closed());
    let error = Cavity::new(plate).expect_err("no inside");
    assert_eq!(error.parameter(), "inside");
}

#[test]
fn grids_tell_their_ball_their_radius_and_their_inside() {
    let grid = built(&distance_grid(ball(41)));
    let inner = grid.inner_ball().expect("a ball");
    assert!((inner.radius - 1.0).abs() < 0.07 && norm(sub(inner.centre, CENTRE)) < 0.07);
    assert!((grid.sharpest_radius().expect("round") - 1.0).abs() < 0.01);
    assert!(grid.is_closed() && grid.is_smooth() && !grid.is_flat());
    let field = built(&height_field(cap(13)));
    assert_eq!((field.inner_ball(), field.sharpest_radius()), (None, None));
    assert!(field.lies_in_plane().is_err());
}

#[test]
fn a_grid_is_built_in_the_length_asked_for() {
    for shape in [distance_grid(ball(21)), height_field(waves())] {
        let [plain, in_units] = [1.0, 4.0].map(|length| shape.build(length).expect("valid"));
        let point = [0.4, 0.3, -0.9];
        let (a, b) = (plain.distance(point), in_units.distance(scale(0.25, point)));
        assert!((a.distance - 4.0 * b.distance).abs() < 1e-13);
        assert!(norm(sub(a.normal, b.normal)) < 1e-13);
        assert!(norm(sub(scale(4.0, a.curvature[0]), b.curvature[0])) < 1e-12);
    }
}

/// Central differences of distance and normal, over what they should be.
fn difference_errors(tool: &dyn Obstacle, point: [f64; 3]) -> (f64, f64) {
    let step = 1e-5;
    let here = tool.distance(point);
    let mut worst = (0.0_f64, 0.0_f64);
    for axis in 0..3 {
        let at = |by: f64| {
            let mut place = point;
            place[axis] += by;
            tool.distance(place)
        };
        let (ahead, behind) = (at(step), at(-step));
        let slope = (ahead.distance - behind.distance) / (2.0 * step);
        worst.0 = worst.0.max((slope - here.normal[axis]).abs());
        let bend = scale(0.5 / step, sub(ahead.normal, behind.normal));
        worst.1 = worst
            .1
            .max(norm(sub(bend, here.curvature.map(|row| row[axis]))));
    }
    worst
}

proptest! {
    #[test]
    fn normal_and_curvature_of_grids_are_derivatives_of_the_distance(
        x in -1.1..1.1, y in -1.1..1.1, off in -0.25..0.6, kind in 0..2,
    ) {
        let tool = match kind {
            0 => built(&distance_grid(ball(21))),
            _ => built(&height_field(waves())),
        };
        let length = norm([x, y, -1.5]);
        let point = match kind {
            0 => add(CENTRE, scale((1.0 + off) / length, [x, y, -1.5])),
            _ => [x, y, off],
        };
        let here = tool.distance(point);
        // Far on the hollow side of waves the nearest place is not unique.
        prop_assume!(here.curvature.as_flattened().iter().all(|x| x.abs() < 5.0));
        let (normal, curvature) = difference_errors(&*tool, point);
        prop_assert!(normal < 1e-8, "normal {normal:e}");
        // The third derivative of a spline jumps.
        prop_assert!(curvature < 2e-4, "curvature {curvature:e}");
        prop_assert!((norm(here.normal) - 1.0).abs() < 1e-13);
    }

    #[test]
    fn any_values_are_refused_or_finite_everywhere(
        counts in prop::array::uniform3(0..7_usize),
        spacing in prop::array::uniform3(prop_oneof![0.1..2.0, Just(1e-300), Just(1e300), Just(-1.0)]),
        numbers in prop::collection::vec(prop_oneof![-2.0..2.0, Just(0.0), Just(1e300)], 0..216),
        point in prop::array::uniform3(-20.0..20.0),
    ) {
        let nodes: usize = counts.iter().product();
        let values: Vec<f64> = (0..nodes).map(|i| numbers.get(i).copied().unwrap_or(0.25)).collect();
        let space = Lattice { counts, origin: [0.5; 3], spacing };
        let [nx, ny, _] = counts;
        let plane = Lattice { counts: [nx, ny], origin: [0.5; 2], spacing: [spacing[0], spacing[1]] };
        let tools = [
            DistanceGrid::new(space, &values).map(distance_grid),
            HeightField::new(plane, &values[..(nx * ny).min(nodes)]).map(height_field),
        ];
        for tool in tools.into_iter().flatten() {
            let found = built(&tool).distance(point);
            let numbers = found.normal.iter().chain(found.curvature.as_flattened());
            prop_assert!(numbers.chain([&found.distance]).all(|x| x.is_finite()));
        }
    }

    #[test]
    fn a_batch_of_a_grid_has_the_bits_of_its_points(
        points in prop::collection::vec(prop::array::uniform3(-2.0..2.0), 1..20),
    ) {
        for tool in [distance_grid(ball(21)), height_field(waves())] {
            let tool = built(&tool);
            let mut out = vec![Contact::default(); points.len()];
            tool.probe(&points, Derivatives::Curvature, &mut out);
            let mut gaps = vec![Contact::default(); points.len()];
            tool.probe(&points, Derivatives::Gap, &mut gaps);
            for ((out, gap), point) in out.iter().zip(&gaps).zip(&points) {
                prop_assert_eq!(*out, tool.distance(*point));
                prop_assert_eq!(out.distance.to_bits(), gap.distance.to_bits());
                prop_assert!(gap.normal.iter().all(|x| *x == 0.0));
            }
        }
    }
}
