//! What shapes of obstacles look like.
//!
//! Each is drawn as the piece near a given box: a half-space as a square, a sphere as a cap, a
//! cylinder as a strip as long as the diagonal, a cone up to the far side of the box, the others
//! whole.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use signorini_proto::v1;
use signorini_proto::v1::shape::Kind;

use crate::formats::vtp::{
    BoundingBox, Outline, Pose, Triangulation, Vector, add, cross, dot, scale, sheet, subtract,
    tangents, unit,
};

/// Rows and half the columns of the facets of a sphere; a third of the facets around a
/// cylinder.
const DIVISIONS: usize = 32;

/// What of a moved shape is in a box; none where the shape cannot be drawn.
pub fn drawn_near(shape: &v1::Shape, pose: &Pose, near: &BoundingBox) -> Option<Triangulation> {
    let reference = outline(shape, near)?.reference;
    let seen = near.seen_from(pose, reference);
    Some(outline(shape, &seen)?.posed(pose).within(near))
}

/// What a shape looks like near a box in its initial pose; none where it cannot be drawn.
pub fn outline(shape: &v1::Shape, body: &BoundingBox) -> Option<Outline> {
    let (surface, reference) = match shape.kind.as_ref()? {
        Kind::HalfSpace(shape) => {
            let point = three(&shape.point);
            (square(point, three(&shape.normal), body), point)
        }
        Kind::Sphere(shape) => {
            let centre = three(&shape.centre);
            (globe(centre, shape.radius?, body), centre)
        }
        Kind::Cylinder(shape) => {
            let point = three(&shape.point);
            (tube(point, three(&shape.axis), shape.radius?, body), point)
        }
        Kind::CappedCylinder(shape) => {
            let from = three(&shape.from);
            (capped(shape, from)?, from)
        }
        Kind::Box(shape) => {
            let centre = three(&shape.centre);
            (cuboid(shape, centre)?, centre)
        }
        Kind::Torus(shape) => {
            let centre = three(&shape.centre);
            (ring(shape, centre)?, centre)
        }
        Kind::Cone(shape) => {
            let apex = three(&shape.apex);
            (cone(shape, apex, body)?, apex)
        }
        // What they look like is in their files.
        Kind::Surface(_) | Kind::HeightField(_) | Kind::DistanceGrid(_) => return None,
    };
    Some(Outline { surface, reference })
}

fn three(values: &[f64]) -> Vector {
    values.try_into().unwrap_or_default()
}

/// A square around the body's centre, as wide as its diagonal.
fn square(point: Vector, normal: Vector, body: &BoundingBox) -> Triangulation {
    let normal = unit(normal);
    let (first, second) = tangents(normal);
    let middle = body.centre();
    let foot = subtract(middle, scale(normal, dot(subtract(middle, point), normal)));
    let half = 0.5 * body.diagonal();
    let corner = |a: f64, b: f64| add(foot, add(scale(first, a * half), scale(second, b * half)));
    Triangulation {
        points: vec![
            corner(-1.0, -1.0),
            corner(1.0, -1.0),
            corner(1.0, 1.0),
            corner(-1.0, 1.0),
        ],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    }
}

/// The angle at the centre of a circle, from the direction to a box on, within which the
/// circle comes near the box.
fn reach(radius: f64, distance: f64, body: &BoundingBox) -> f64 {
    let range = body.diagonal();
    let cosine =
        (distance * distance + radius * radius - range * range) / (2.0 * distance * radius);
    if cosine.is_finite() {
        cosine.clamp(-1.0, 1.0).acos()
    } else {
        PI
    }
}

/// Meridians and parallels around the direction to the body; around z on a whole sphere.
fn globe(centre: Vector, radius: f64, body: &BoundingBox) -> Triangulation {
    let towards = subtract(body.centre(), centre);
    let reach = reach(radius, dot(towards, towards).sqrt(), body);
    let pole = if reach < PI {
        unit(towards)
    } else {
        [0.0, 0.0, 1.0]
    };
    let (first, second) = tangents(pole);
    let columns = 2 * DIVISIONS;
    let point = |row: usize, column: usize| {
        let polar = reach * row as f64 / DIVISIONS as f64;
        let around = TAU * column as f64 / columns as f64;
        let ring = add(
            scale(first, polar.sin() * around.cos()),
            scale(second, polar.sin() * around.sin()),
        );
        let direction = add(ring, scale(pole, polar.cos()));
        add(centre, scale(direction, radius))
    };
    sheet(DIVISIONS, columns, point)
}

/// A tube around the point of its axis nearest to the body's centre: its strip near the body.
fn tube(point: Vector, axis: Vector, radius: f64, body: &BoundingBox) -> Triangulation {
    let axis = unit(axis);
    let offset = subtract(body.centre(), point);
    let along = dot(offset, axis);
    let towards = subtract(offset, scale(axis, along));
    let distance = dot(towards, towards).sqrt();
    let reach = reach(radius, distance, body);
    let (mut first, mut second) = tangents(axis);
    if reach < PI {
        first = unit(towards);
        second = cross(axis, first);
    }
    let extent = body.diagonal();
    let columns = 3 * DIVISIONS;
    let place = |row: usize, column: usize| {
        let around = reach * (2.0 * column as f64 / columns as f64 - 1.0);
        let ring = add(
            scale(first, radius * around.cos()),
            scale(second, radius * around.sin()),
        );
        let offset = along + extent * (row as f64 - 0.5);
        add(point, add(ring, scale(axis, offset)))
    };
    sheet(1, columns, place)
}

/// The surface that a line of points `[radius, height]` sweeps around an axis.
fn turned(origin: Vector, axis: Vector, line: &[[f64; 2]]) -> Triangulation {
    let axis = unit(axis);
    let (first, second) = tangents(axis);
    let columns = 2 * DIVISIONS;
    let place = |row: usize, column: usize| {
        let [radius, height] = line.get(row).copied().unwrap_or_default();
        let around = TAU * column as f64 / columns as f64;
        let ring = add(
            scale(first, radius * around.cos()),
            scale(second, radius * around.sin()),
        );
        add(origin, add(ring, scale(axis, height)))
    };
    sheet(line.len().saturating_sub(1), columns, place)
}

/// Points of a circle `[radius, height]` between two angles from the radius.
fn arc(centre: [f64; 2], radius: f64, (from, to): (f64, f64)) -> Vec<[f64; 2]> {
    let steps = DIVISIONS / 2;
    let angle = |step: usize| from + (to - from) * step as f64 / steps as f64;
    let at = |step: usize| {
        let (sine, cosine) = angle(step).sin_cos();
        [
            (centre[0] + radius * cosine).max(0.0),
            centre[1] + radius * sine,
        ]
    };
    (0..=steps).map(at).collect()
}

/// A cylinder with its caps.
fn capped(shape: &v1::CappedCylinder, from: Vector) -> Option<Triangulation> {
    let along = subtract(three(&shape.to), from);
    let length = dot(along, along).sqrt();
    let (radius, rounding) = (shape.radius?, shape.rounding.unwrap_or_default());
    let corner = |height: f64, angles| arc([radius - rounding, height], rounding, angles);
    let mut line = vec![[0.0, 0.0]];
    line.extend(corner(rounding, (-FRAC_PI_2, 0.0)));
    line.extend(corner(length - rounding, (0.0, FRAC_PI_2)));
    line.push([0.0, length]);
    Some(turned(from, along, &line))
}

/// A torus.
fn ring(shape: &v1::Torus, centre: Vector) -> Option<Triangulation> {
    let (low, high) = (arc_of(shape, -PI, 0.0)?, arc_of(shape, 0.0, PI)?);
    Some(turned(centre, three(&shape.axis), &[low, high].concat()))
}

/// Half the section of a torus.
fn arc_of(shape: &v1::Torus, from: f64, to: f64) -> Option<Vec<[f64; 2]>> {
    Some(arc([shape.radius?, 0.0], shape.tube_radius?, (from, to)))
}

/// A cone up to the far side of the body.
fn cone(shape: &v1::Cone, apex: Vector, body: &BoundingBox) -> Option<Triangulation> {
    let (angle, rounding) = (shape.angle?, shape.rounding.unwrap_or_default());
    let offset = subtract(body.centre(), apex);
    let extent = dot(offset, offset).sqrt() + body.diagonal();
    let middle = [0.0, rounding / angle.sin()];
    let mut line = arc(middle, rounding, (-FRAC_PI_2, -angle));
    line.push([extent * angle.sin(), extent * angle.cos()]);
    Some(turned(apex, three(&shape.axis), &line))
}

/// A box with rounded edges: a ball whose octants are moved apart.
fn cuboid(shape: &v1::BoxShape, centre: Vector) -> Option<Triangulation> {
    let rounding = shape.rounding.unwrap_or_default();
    let core = three(&shape.half_sizes).map(|half| half - rounding);
    // Angles of rows and columns; each end of an octant's range belongs to the next octant, too.
    let steps = DIVISIONS / 8;
    let octant = |first: f64| -> Vec<(f64, f64)> {
        let angle = |step: usize| first + FRAC_PI_2 * step as f64 / steps as f64;
        (0..=steps)
            .map(|step| (angle(step), first + 0.5 * FRAC_PI_2))
            .collect()
    };
    let polar = [octant(0.0), octant(FRAC_PI_2)].concat();
    let mut around: Vec<(f64, f64)> = (0..4)
        .flat_map(|q| octant(f64::from(q) * FRAC_PI_2))
        .collect();
    around.extend(around.first().copied());
    let rows = polar.len() + 1;
    let place = |row: usize, column: usize| {
        let (across, side) = around.get(column).copied().unwrap_or_default();
        let Some((down, half)) = row.checked_sub(1).and_then(|row| polar.get(row)) else {
            let end = if row == 0 { 1.0 } else { -1.0 };
            return add(centre, [0.0, 0.0, end * (core[2] + rounding)]);
        };
        let direction = [
            down.sin() * across.cos(),
            down.sin() * across.sin(),
            down.cos(),
        ];
        let [x, y, z] = direction.map(|length| rounding * length);
        let [left, behind, below] = [side.cos(), side.sin(), half.cos()].map(f64::signum);
        let [a, b, c] = core;
        add(centre, [left * a + x, behind * b + y, below * c + z])
    };
    Some(sheet(rows, around.len() - 1, place))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene_file::keys::{Faults, Keys};
    use crate::scene_file::shape::shape;

    const BODY: BoundingBox = BoundingBox {
        low: [0.0; 3],
        high: [1.0, 2.0, 2.0],
    };

    fn drawn(kind: Kind) -> Outline {
        let shape = v1::Shape {
            kind: Some(kind),
            inside: false,
        };
        outline(&shape, &BODY).expect("a shape that is drawn")
    }

    fn distance(a: Vector, b: Vector) -> f64 {
        let offset = subtract(a, b);
        dot(offset, offset).sqrt()
    }

    #[test]
    fn sphere_points_lie_on_the_moved_sphere() {
        let sphere = drawn(Kind::Sphere(v1::Sphere {
            centre: vec![1.0, 2.0, 3.0],
            radius: Some(0.5),
        }));
        let pose = Pose {
            translation: [0.0, 0.0, -1.0],
            rotation: [0.3, 0.2, 9.0],
        };
        for point in sphere.posed(&pose).points {
            assert!((distance(point, [1.0, 2.0, 2.0]) - 0.5).abs() < 1e-14);
        }
    }

    #[test]
    fn a_large_ball_is_drawn_as_its_cap_and_a_far_one_not_at_all() {
        let ball = |x: f64| v1::Shape {
            kind: Some(Kind::Sphere(v1::Sphere {
                centre: vec![x, 1.0, 1.0],
                radius: Some(1000.0),
            })),
            inside: false,
        };
        let pose = Pose {
            translation: [-5.0, 0.0, 0.0],
            rotation: [0.0, 2.0, 1.0],
        };
        let near = BODY.neighbourhood();
        let cap = drawn_near(&ball(1005.5), &pose, &near).unwrap();
        assert!(cap.triangles.len() > 100);
        for point in &cap.points {
            // Facets are as far inside the ball as their size asks for.
            let depth = 1000.0 - distance(*point, [1000.5, 1.0, 1.0]);
            assert!((-1e-9..1e-3).contains(&depth), "{depth}");
        }
        assert!(
            drawn_near(&ball(2000.0), &pose, &near)
                .unwrap()
                .points
                .is_empty()
        );
    }

    fn named(kind: &str, keys: &str) -> v1::Shape {
        let text = format!("kind = \"{kind}\"\n{keys}");
        let table: toml::Table = text.parse().expect("TOML");
        let faults = Faults::default();
        let known: Vec<&str> = table.keys().map(String::as_str).collect();
        let read = shape(&Keys::new(String::new(), &table, &known, &faults));
        faults.finish().expect("a shape");
        read
    }

    /// Largest distance of a drawn point from the surface.
    fn off_surface(shape: &v1::Shape, distance: impl Fn(Vector) -> f64) -> f64 {
        let drawn = outline(shape, &BODY).expect("drawn").surface;
        assert!(drawn.triangles.len() > 20);
        let off = |point: &Vector| distance(*point).abs();
        drawn.points.iter().map(off).fold(0.0, f64::max)
    }

    #[test]
    fn rounded_tools_are_drawn_on_their_surface() {
        let half = [0.5, 0.4, 0.3];
        let cuboid = named(
            "box",
            "centre = [1, 2, 3]\nhalf_sizes = [0.5, 0.4, 0.3]\nrounding = 0.1",
        );
        let rounded = |point: Vector| {
            let offset = subtract(point, [1.0, 2.0, 3.0]);
            let beyond = [0, 1, 2].map(|i: usize| (offset[i].abs() - (half[i] - 0.1)).max(0.0));
            let flat = (0..3)
                .map(|i: usize| offset[i].abs() - half[i])
                .fold(f64::MIN, f64::max);
            if flat < -1e-12 {
                distance(beyond, [0.0; 3]) - 0.1
            } else {
                flat
            }
        };
        assert!(off_surface(&cuboid, rounded) < 1e-14);
        let torus = named(
            "torus",
            "centre = [1, 0, 0]\naxis = [0, 0, 2]\nradius = 2\ntube_radius = 0.5",
        );
        let tube = |[x, y, z]: Vector| ((x - 1.0).hypot(y) - 2.0).hypot(z) - 0.5;
        assert!(off_surface(&torus, tube) < 1e-14);
        let cone = named(
            "cone",
            "apex = [0, 0, 0]\naxis = [0, 0, 1]\nangle = 0.7\nrounding = 0.2",
        );
        let tip = 0.2 / 0.7_f64.sin();
        let side = |[x, y, z]: Vector| {
            let (radius, above) = (x.hypot(y), z - tip);
            if radius * 0.7_f64.sin() + above * 0.7_f64.cos() > -1e-12 {
                radius * 0.7_f64.cos() - above * 0.7_f64.sin() - 0.2
            } else {
                radius.hypot(above) - 0.2
            }
        };
        assert!(off_surface(&cone, side) < 1e-13);
        let rod = named(
            "capped-cylinder",
            "from = [0, 0, 0]\nto = [0, 0, 2]\nradius = 1\nrounding = 0.25",
        );
        let pin = |[x, y, z]: Vector| {
            let beyond = [x.hypot(y) - 0.75, (z - 1.0).abs() - 0.75];
            let flat = beyond[0].max(beyond[1]) - 0.25;
            if beyond[0] > 0.0 && beyond[1] > 0.0 {
                beyond[0].hypot(beyond[1]) - 0.25
            } else {
                flat
            }
        };
        assert!(off_surface(&rod, pin) < 1e-14);
    }

    #[test]
    fn plane_is_a_square_of_the_body_diagonal_on_the_plane() {
        let plane = drawn(Kind::HalfSpace(v1::HalfSpace {
            point: vec![5.0, 5.0, -1.0],
            normal: vec![0.0, 0.0, 2.0],
        }));
        assert_eq!(plane.surface.triangles.len(), 2);
        for point in &plane.surface.points {
            assert!((point[2] + 1.0).abs() < 1e-14);
            let from_centre = distance(*point, [0.5, 1.0, -1.0]);
            assert!((from_centre - 1.5 * 2.0_f64.sqrt()).abs() < 1e-12);
        }
    }

    #[test]
    fn cylinder_points_keep_the_radius_from_the_turned_axis() {
        let cylinder = drawn(Kind::Cylinder(v1::Cylinder {
            point: vec![0.0; 3],
            axis: vec![1.0, 0.0, 0.0],
            radius: Some(2.0),
        }));
        let pose = Pose {
            translation: [0.0; 3],
            rotation: [0.0, 0.0, PI / 2.0],
        };
        for [x, _, z] in cylinder.posed(&pose).points {
            assert!((x.hypot(z) - 2.0).abs() < 1e-14);
        }
    }
}
