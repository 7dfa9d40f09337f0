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

/// Every kind of shape, solid; `share` of what its lengths leave room for is its rounding.
fn solid(kind: usize, (place, along): ([f64; 3], [f64; 3]), (radius, share): (f64, f64)) -> Shape {
    match kind {
        0 => Shape::HalfSpace {
            point: place,
            normal: along,
        },
        1 => Shape::Sphere {
            centre: place,
            radius,
        },
        2 => Shape::Cylinder {
            point: place,
            axis: along,
            radius,
        },
        3 => Shape::CappedCylinder {
            from: place,
            to: add(place, along),
            radius,
            rounding: share * radius.min(0.5 * norm(along)),
        },
        4 => {
            let half_sizes = along.map(|size| 0.2 + size.abs());
            let least = half_sizes.into_iter().fold(f64::INFINITY, f64::min);
            Shape::Box {
                centre: place,
                half_sizes,
                rounding: share * least,
            }
        }
        5 => Shape::Torus {
            centre: place,
            axis: along,
            radius,
            tube_radius: (0.1 + 0.8 * share) * radius,
        },
        _ => Shape::Cone {
            apex: place,
            axis: along,
            angle: 0.1 + 1.4 * share,
            rounding: radius,
        },
    }
}

fn shape() -> impl Strategy<Value = Arc<dyn Obstacle>> {
    let parts = (
        0..7_usize,
        vector(1.0),
        direction(),
        0.2..2.0,
        0.0..1.0,
        any::<bool>(),
    );
    parts.prop_map(|(kind, place, along, radius, share, is_cavity)| {
        let solid = solid(kind, (place, along), (radius, share));
        let shape = if is_cavity && kind > 0 {
            Shape::Cavity(solid.into())
        } else {
            solid
        };
        shape.build(1.0).expect("valid")
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

/// Bits that a probe leaves over what was there before.
fn probed(
    obstacle: &dyn Obstacle,
    points: &[[f64; 3]],
    derivatives: Derivatives,
) -> Vec<[u64; 13]> {
    let mut out = vec![UNTOUCHED; points.len()];
    obstacle.probe(points, derivatives, &mut out);
    out.iter().map(bits).collect()
}

/// Bits of what was asked for, beside what was there before.
fn asked(contacts: &[Contact], derivatives: Derivatives) -> Vec<[u64; 13]> {
    let part = |contact: &Contact| Contact {
        distance: contact.distance,
        normal: match derivatives {
            Derivatives::Gap => UNTOUCHED.normal,
            Derivatives::Normal | Derivatives::Curvature => contact.normal,
        },
        curvature: match derivatives {
            Derivatives::Gap | Derivatives::Normal => UNTOUCHED.curvature,
            Derivatives::Curvature => contact.curvature,
        },
    };
    contacts
        .iter()
        .map(|contact| bits(&part(contact)))
        .collect()
}

/// What stands in a result before it is filled.
const UNTOUCHED: Contact = Contact {
    distance: 7.0,
    normal: [8.0; 3],
    curvature: [[9.0; 3]; 3],
};

fn bits(contact: &Contact) -> [u64; 13] {
    let mut numbers = std::iter::once(&contact.distance)
        .chain(&contact.normal)
        .chain(contact.curvature.as_flattened());
    std::array::from_fn(|_| numbers.next().map_or(0, |x| x.to_bits()))
}

proptest! {
    #[test]
    fn normal_and_curvature_are_derivatives_of_the_distance(
        obstacle in moved(), point in vector(4.0),
    ) {
        // Differences need room: curvature changes fast near a centre or axis, and jumps where
        // faces, edges and corners of a shape meet.
        let here = obstacle.distance(point);
        let sharpest = here.curvature.as_flattened().iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        prop_assume!(sharpest < 5.0);
        let is_apart = |axis, by| {
            let there = obstacle.distance(shifted(point, axis, by));
            let bend = there.curvature.as_flattened().iter().zip(here.curvature.as_flattened());
            bend.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) > 1e-2
                || norm(sub(there.normal, here.normal)) > 1e-2
        };
        prop_assume!(!(0..3).any(|axis| is_apart(axis, 1e-4) || is_apart(axis, -1e-4)));
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
        // Exact distances change by the length of a step at most.
        let other = obstacle.distance(add(point, [0.3, -0.2, 0.1]));
        prop_assert!((other.distance - here.distance).abs() <= 0.14_f64.sqrt() + 1e-12);
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

    #[test]
    fn a_batch_has_the_bits_of_its_points_for_whatever_is_asked(
        shape in shape(), translation in vector(2.0), rotation in vector(7.0),
        points in prop::collection::vec(vector(4.0), 1..80),
    ) {
        let moving = Moving::new(Arc::clone(&shape), translation, rotation);
        // A place where no direction leads away from a ball or a roller.
        let mut points = points;
        points.push(shape.reference_point());
        points.push(moving.reference_point());
        let obstacles: [&dyn Obstacle; 2] = [&*shape, &moving];
        for obstacle in obstacles {
            let single: Vec<Contact> = points.iter().map(|&x| obstacle.distance(x)).collect();
            for derivatives in [Derivatives::Gap, Derivatives::Normal, Derivatives::Curvature] {
                prop_assert_eq!(probed(obstacle, &points, derivatives), asked(&single, derivatives));
            }
        }
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

/// Distances by hand.
#[test]
fn tools_have_their_distances_and_curvatures() {
    let near = |shape: Shape, point: [f64; 3], distance: f64, curvature: f64| {
        let found = shape.build(1.0).expect("valid").distance(point);
        assert!(
            (found.distance - distance).abs() < 1e-14,
            "{shape:?} {found:?}"
        );
        let sum: f64 = (0..3).map(|i| found.curvature[i][i]).sum();
        assert!((sum - curvature).abs() < 1e-13, "{shape:?} {found:?}");
    };
    let torus = || Shape::Torus {
        centre: [0.0, 0.0, 1.0],
        axis: [0.0, 0.0, 2.0],
        radius: 2.0,
        tube_radius: 0.5,
    };
    // Below the tube, outside, and in the hole, where the ring around the axis bends back.
    near(torus(), [0.0, 2.0, 0.0], 0.5, 1.0);
    near(torus(), [3.0, 0.0, 1.0], 0.5, 1.0 + 1.0 / 3.0);
    near(torus(), [0.0, 1.0, 1.0], 0.5, 1.0 - 1.0);
    near(Shape::Cavity(torus().into()), [0.0, 2.0, 1.2], 0.3, -5.0);
    let cuboid = |rounding| Shape::Box {
        centre: [0.0; 3],
        half_sizes: [1.0, 2.0, 3.0],
        rounding,
    };
    near(cuboid(0.5), [1.25, 0.0, 0.0], 0.25, 0.0);
    near(cuboid(0.5), [0.8, 1.9, 0.0], 0.0, 2.0);
    near(
        cuboid(0.5),
        [0.5 + 1.0, 1.5 + 1.0, 2.5 + 1.0],
        3.0_f64.sqrt() - 0.5,
        2.0 / 3.0_f64.sqrt(),
    );
    near(cuboid(0.0), [0.0, 0.5, 2.9], -0.1, 0.0);
    let rod = Shape::CappedCylinder {
        from: [0.0, 0.0, 1.0],
        to: [0.0, 0.0, 5.0],
        radius: 1.0,
        rounding: 0.25,
    };
    near(rod.clone(), [0.2, 0.0, 5.5], 0.5, 0.0);
    near(rod.clone(), [3.0, 0.0, 3.0], 2.0, 1.0 / 3.0);
    near(
        rod,
        [0.75 + 0.3, 0.0, 0.85],
        0.3 * 2.0_f64.sqrt() - 0.0 - 0.25 + (0.3_f64.hypot(0.4) - 0.3 * 2.0_f64.sqrt()),
        2.0 + 0.6 / 1.05,
    );
    let cone = Shape::Cone {
        apex: [0.0, 0.0, -1.0],
        axis: [0.0, 0.0, 1.0],
        angle: std::f64::consts::FRAC_PI_6,
        rounding: 0.5,
    };
    // The ball's centre is at the origin; its lowest point and a point of the side.
    near(cone.clone(), [0.0, 0.0, -1.0], 0.5, 2.0);
    near(
        cone,
        [2.0 * 3.0_f64.sqrt(), 0.0, 2.0],
        1.5,
        0.75_f64.sqrt() / (2.0 * 3.0_f64.sqrt()),
    );
}

#[test]
fn tools_without_room_are_refused_by_name() {
    let refused = |shape: Shape| shape.build(1.0).expect_err("refused").parameter();
    let rod = |to, rounding| Shape::CappedCylinder {
        from: [0.0; 3],
        to,
        radius: 1.0,
        rounding,
    };
    assert_eq!(refused(rod([0.0; 3], 0.0)), "to");
    assert_eq!(refused(rod([0.0, 0.0, 1.0], 0.6)), "rounding");
    assert_eq!(refused(rod([0.0, 0.0, 1.0], f64::NAN)), "rounding");
    let cuboid = |half_sizes, rounding| Shape::Box {
        centre: [0.0; 3],
        half_sizes,
        rounding,
    };
    assert_eq!(refused(cuboid([1.0, 0.0, 1.0], 0.0)), "half_sizes");
    assert_eq!(refused(cuboid([1.0; 3], -0.1)), "rounding");
    assert_eq!(refused(cuboid([1.0, 0.5, 1.0], 0.6)), "rounding");
    let torus = Shape::Torus {
        centre: [0.0; 3],
        axis: [0.0, 0.0, 1.0],
        radius: 1.0,
        tube_radius: 1.0,
    };
    assert_eq!(refused(torus), "tube_radius");
    let cone = |angle| Shape::Cone {
        apex: [0.0; 3],
        axis: [0.0, 0.0, 1.0],
        angle,
        rounding: 0.0,
    };
    for angle in [0.0, -1.0, 1.6, f64::NAN, f64::INFINITY] {
        assert_eq!(refused(cone(angle)), "angle");
    }
    let plane = half_space([0.0, 0.0, 1.0]);
    assert_eq!(refused(Shape::Cavity(plane.into())), "inside");
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
fn only_a_half_space_is_flat_wherever_it_moves() {
    let flat = [
        (half_space([0.0, 0.6, 0.8]), true),
        (ball([0.0; 3]), false),
        (roller([0.0, 0.0, 1.0]), false),
    ];
    for (shape, is_flat) in flat {
        let built = shape.build(2.0).expect("valid");
        assert_eq!(built.is_flat(), is_flat);
        assert_eq!(Moving::new(built, [1.0; 3], [0.5; 3]).is_flat(), is_flat);
    }
}

#[test]
fn a_shape_off_the_plane_names_the_parameter() {
    let cases = [
        (
            half_space([0.6, 0.8, 0.0]),
            half_space([0.6, 0.0, 0.8]),
            "normal",
        ),
        (ball([5.0, 1.0, 0.0]), ball([0.0, 0.0, 0.1]), "centre"),
        (roller([0.0, 0.0, -3.0]), roller([0.0, 1e-9, 1.0]), "axis"),
    ];
    for (inside, outside, key) in cases {
        let lies = |shape: &Shape| shape.build(1.0).expect("valid").lies_in_plane();
        assert_eq!(lies(&inside), Ok(()));
        let error = lies(&outside).expect_err("off the plane");
        assert_eq!(error.parameter(), key);
        assert!(error.to_string().starts_with("does not lie in the plane"));
    }
}

#[test]
fn a_shape_is_built_in_the_length_asked_for() {
    let place = [3.0, 1.0, -2.0];
    let shapes = [
        half_space([0.6, 0.0, 0.8]),
        ball([1.0; 3]),
        roller([0.0, 1.0, 0.5]),
    ];
    for shape in shapes {
        let [plain, in_units] = [1.0, 4.0].map(|length| shape.build(length).expect("valid"));
        let far = plain.distance(place).distance;
        let near = in_units.distance(scale(0.25, place)).distance;
        assert!((far - 4.0 * near).abs() < 1e-14, "{shape:?}");
    }
}

fn half_space(normal: [f64; 3]) -> Shape {
    let point = [0.5, 0.25, 0.125];
    Shape::HalfSpace { point, normal }
}

fn ball(centre: [f64; 3]) -> Shape {
    let radius = 0.75;
    Shape::Sphere { centre, radius }
}

fn roller(axis: [f64; 3]) -> Shape {
    Shape::Cylinder {
        point: [0.5, 0.25, 0.125],
        axis,
        radius: 0.75,
    }
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
