use std::sync::Arc;

use proptest::prelude::*;

use super::*;
use crate::geometry::rigid_motion::multiply;
use crate::geometry::vector3::{add, dot, norm, scale, sub};

fn vector(limit: f64) -> impl Strategy<Value = [f64; 3]> {
    prop::array::uniform3(-limit..limit)
}

/// Directions away from zero, of length 0.5 to 2.
fn direction() -> impl Strategy<Value = [f64; 3]> {
    let long_enough = |v: &[f64; 3]| (0.5..2.0).contains(&norm(*v));
    vector(2.0).prop_filter("length", long_enough)
}

fn shape() -> impl Strategy<Value = Arc<dyn Obstacle>> {
    (0..3, vector(1.0), direction(), 0.2..2.0).prop_map(|(kind, place, along, radius)| {
        let built: Arc<dyn Obstacle> = match kind {
            0 => Arc::new(HalfSpace::new(place, along).expect("valid")),
            1 => Arc::new(Sphere::new(place, radius).expect("valid")),
            _ => Arc::new(Cylinder::new(place, along, radius).expect("valid")),
        };
        built
    })
}

fn moved() -> impl Strategy<Value = Moving> {
    let parts = (shape(), vector(2.0), vector(7.0));
    parts.prop_map(|(shape, translation, rotation)| Moving::new(shape, translation, rotation))
}

fn shifted(point: [f64; 3], axis: usize, by: f64) -> [f64; 3] {
    let mut point = point;
    point[axis] += by;
    point
}

/// Central differences of the distance and of the normal.
fn difference_errors(obstacle: &dyn Obstacle, point: [f64; 3]) -> (f64, f64) {
    let step = 1e-5;
    let here = obstacle.distance(point);
    let (mut normal_error, mut curvature_error) = (0.0_f64, 0.0_f64);
    for axis in 0..3 {
        let ahead = obstacle.distance(shifted(point, axis, step));
        let behind = obstacle.distance(shifted(point, axis, -step));
        let slope = (ahead.distance - behind.distance) / (2.0 * step);
        normal_error = normal_error.max((slope - here.normal[axis]).abs());
        let bend = scale(0.5 / step, sub(ahead.normal, behind.normal));
        let column = here.curvature.map(|row| row[axis]);
        curvature_error = curvature_error.max(norm(sub(bend, column)));
    }
    (normal_error, curvature_error)
}

proptest! {
    #[test]
    fn normal_and_curvature_are_derivatives_of_the_distance(
        obstacle in moved(), point in vector(4.0),
    ) {
        // Differences need room: curvature changes fast near a centre or axis.
        let sharpest = obstacle.distance(point).curvature.as_flattened().iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        prop_assume!(sharpest < 5.0);
        let (normal_error, curvature_error) = difference_errors(&obstacle, point);
        prop_assert!(normal_error < 1e-8, "normal {normal_error:e}");
        prop_assert!(curvature_error < 1e-7, "curvature {curvature_error:e}");
    }

    #[test]
    fn normal_is_unit_and_leads_to_the_surface(obstacle in moved(), point in vector(4.0)) {
        let here = obstacle.distance(point);
        prop_assert!((norm(here.normal) - 1.0).abs() < 1e-13);
        let foot = sub(point, scale(here.distance, here.normal));
        prop_assert!(obstacle.distance(foot).distance.abs() < 1e-12);
        prop_assert!(norm(multiply(&here.curvature, here.normal)) < 1e-10 * (1.0 + 1.0 / norm(here.normal)));
    }

    #[test]
    fn moved_obstacle_is_the_still_one_seen_from_its_frame(
        shape in shape(), translation in vector(2.0), rotation in vector(7.0), point in vector(4.0),
    ) {
        let moving = Moving::new(Arc::clone(&shape), translation, rotation);
        let still = shape.distance(point);
        let carried = moving.distance(moving.motion().apply(point));
        prop_assert!((carried.distance - still.distance).abs() < 1e-12);
        let moved_reference = add(shape.reference_point(), translation);
        prop_assert!(norm(sub(moving.reference_point(), moved_reference)) < 1e-14);
    }
}

#[test]
fn distances_are_positive_on_the_free_side() {
    let plane = HalfSpace::new([0.0, 0.0, 1.0], [0.0, 0.0, 2.0]).expect("valid");
    assert!((plane.distance([5.0, 5.0, 1.5]).distance - 0.5).abs() < 1e-15);
    let ball = Sphere::new([1.0, 0.0, 0.0], 0.5).expect("valid");
    assert!((ball.distance([3.0, 0.0, 0.0]).distance - 1.5).abs() < 1e-15);
    assert!((ball.distance([1.2, 0.0, 0.0]).distance + 0.3).abs() < 1e-15);
    let roller = Cylinder::new([0.0; 3], [0.0, 3.0, 0.0], 1.0).expect("valid");
    assert!((roller.distance([3.0, 100.0, 4.0]).distance - 4.0).abs() < 1e-13);
}

#[test]
fn centre_and_axis_have_finite_values_and_a_fixed_normal() {
    let ball = Sphere::new([1.0, 2.0, 3.0], 0.5).expect("valid");
    let roller = Cylinder::new([1.0, 2.0, 3.0], [0.0, 0.0, 1.0], 0.5).expect("valid");
    let shapes: [&dyn Obstacle; 2] = [&ball, &roller];
    for shape in shapes {
        let here = shape.distance([1.0, 2.0, 3.0]);
        assert!((here.distance + 0.5).abs() < 1e-15);
        assert!(norm(sub(here.normal, [1.0, 0.0, 0.0])) < 1e-15);
        assert!(
            here.curvature
                .as_flattened()
                .iter()
                .all(|entry| entry.is_finite())
        );
    }
    let tilted = Cylinder::new([0.0; 3], [3.0, 1.0, 2.0], 0.5).expect("valid");
    let normal = tilted.distance([0.0; 3]).normal;
    assert!(dot(normal, [3.0, 1.0, 2.0]).abs() < 1e-14);
    assert!((norm(normal) - 1.0).abs() < 1e-14);
}

#[test]
fn probing_many_points_equals_probing_each() {
    let ball = Sphere::new([0.1, 0.2, 0.3], 0.5).expect("valid");
    let moving = Moving::new(Arc::new(ball), [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]);
    let points = [[0.0; 3], [1.0, 2.0, 3.0], [1.1, 0.2, 0.3]];
    let mut out = [Contact::default(); 3];
    moving.probe(&points, &mut out);
    assert_eq!(out, points.map(|point| moving.distance(point)));
}

#[test]
fn faulty_parameters_are_named() {
    let zero = [0.0; 3];
    let along = [0.0, 0.0, 1.0];
    let broken = [0.0, f64::NAN, 0.0];
    let name = |error: ObstacleError| error.parameter();
    assert_eq!(
        HalfSpace::new(zero, zero).map_err(name).err(),
        Some("normal")
    );
    assert_eq!(
        HalfSpace::new(broken, along).map_err(name).err(),
        Some("point")
    );
    assert_eq!(Sphere::new(broken, 1.0).map_err(name).err(), Some("centre"));
    for radius in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(
            Sphere::new(zero, radius).map_err(name).err(),
            Some("radius")
        );
        assert_eq!(
            Cylinder::new(zero, along, radius).map_err(name).err(),
            Some("radius")
        );
    }
    assert_eq!(
        Cylinder::new(zero, zero, 1.0).map_err(name).err(),
        Some("axis")
    );
    let error = Sphere::new(zero, -1.0).expect_err("negative");
    assert_eq!(error.to_string(), "radius must be above zero, not -1");
}
