//! Shapes of obstacles: their keys in scene files, and what they look like.
//!
//! Shapes are drawn as the piece near a given box: a half-space as a square, a sphere as
//! a cap, a cylinder as a strip as long as the diagonal, each whole where it is small. All
//! that the client knows of a shape is in this file.

use std::f64::consts::{PI, TAU};

use signorini_proto::v1;
use signorini_proto::v1::shape::Kind;

use super::keys::Keys;
use super::suggest::nearest;
use crate::formats::vtp::{
    BoundingBox, Outline, Pose, Triangulation, Vector, add, cross, dot, scale, sheet, subtract,
    tangents, unit,
};

/// Rows and half the columns of the facets of a sphere; a third of the facets around a
/// cylinder.
const DIVISIONS: usize = 32;

type ReadShape = fn(&Keys<'_>) -> Kind;

/// Each shape: its name, its keys beside `kind` and `inside`, its reader.
const SHAPES: &[(&str, &[&str], ReadShape)] = &[
    ("half-space", &["point", "normal"], half_space),
    ("sphere", &["centre", "radius"], sphere),
    ("cylinder", &["point", "axis", "radius"], cylinder),
    (
        "capped-cylinder",
        &["from", "to", "radius", "rounding"],
        capped_cylinder,
    ),
    ("box", &["centre", "half_sizes", "rounding"], cuboid),
    ("torus", &["centre", "axis", "radius", "tube_radius"], torus),
    ("cone", &["apex", "axis", "angle", "rounding"], cone),
    ("surface", &["file", "scale"], surface),
    ("height-field", &["file"], height_field),
    ("distance-grid", &["file"], distance_grid),
];

/// Shapes that are read, so that the service can say that it does not have them yet.
const LATER: &[&str] = &[
    "capped-cylinder",
    "box",
    "torus",
    "cone",
    "surface",
    "height-field",
    "distance-grid",
];

fn unknown_kind(keys: &Keys<'_>, name: &str) {
    let all = SHAPES.iter().map(|(known, _, _)| *known);
    if nearest(name, all.clone()).is_some() {
        return keys.unknown_word("kind", name, all);
    }
    let usable: Vec<&str> = all.filter(|known| !LATER.contains(known)).collect();
    let (usable, later) = (usable.join(", "), LATER.join(", "));
    keys.fault(
        "kind",
        format!("\"{name}\" is not known; known are {usable}; not supported yet: {later}"),
    );
}

/// The shape that `keys` describe.
pub(super) fn shape(keys: &Keys<'_>) -> v1::Shape {
    let name = keys.required_text("kind");
    let found = SHAPES.iter().find(|(known, _, _)| *known == name);
    let Some((_, own, read)) = found else {
        if keys.has("kind") {
            unknown_kind(keys, &name);
        }
        return v1::Shape::default();
    };
    let known: Vec<&str> = ["kind", "inside"]
        .into_iter()
        .chain(own.iter().copied())
        .collect();
    keys.check(&known);
    v1::Shape {
        inside: keys.boolean("inside").unwrap_or_default(),
        kind: Some(read(keys)),
    }
}

fn half_space(keys: &Keys<'_>) -> Kind {
    Kind::HalfSpace(v1::HalfSpace {
        point: keys.required_vector("point"),
        normal: keys.required_vector("normal"),
    })
}

fn sphere(keys: &Keys<'_>) -> Kind {
    Kind::Sphere(v1::Sphere {
        centre: keys.required_vector("centre"),
        radius: keys.required_number("radius"),
    })
}

fn cylinder(keys: &Keys<'_>) -> Kind {
    Kind::Cylinder(v1::Cylinder {
        point: keys.required_vector("point"),
        axis: keys.required_vector("axis"),
        radius: keys.required_number("radius"),
    })
}

fn capped_cylinder(keys: &Keys<'_>) -> Kind {
    Kind::CappedCylinder(v1::CappedCylinder {
        from: keys.required_vector("from"),
        to: keys.required_vector("to"),
        radius: keys.required_number("radius"),
        rounding: keys.number("rounding"),
    })
}

fn cuboid(keys: &Keys<'_>) -> Kind {
    Kind::Box(v1::BoxShape {
        centre: keys.required_vector("centre"),
        half_sizes: keys.required_vector("half_sizes"),
        rounding: keys.number("rounding"),
    })
}

fn torus(keys: &Keys<'_>) -> Kind {
    Kind::Torus(v1::Torus {
        centre: keys.required_vector("centre"),
        axis: keys.required_vector("axis"),
        radius: keys.required_number("radius"),
        tube_radius: keys.required_number("tube_radius"),
    })
}

fn cone(keys: &Keys<'_>) -> Kind {
    Kind::Cone(v1::Cone {
        apex: keys.required_vector("apex"),
        axis: keys.required_vector("axis"),
        angle: keys.required_number("angle"),
        rounding: keys.number("rounding"),
    })
}

fn surface(keys: &Keys<'_>) -> Kind {
    Kind::Surface(v1::SurfaceShape {
        surface: keys.required_text("file"),
        scale: keys.number("scale"),
    })
}

fn height_field(keys: &Keys<'_>) -> Kind {
    let grid = keys.required_text("file");
    Kind::HeightField(v1::HeightField { grid })
}

fn distance_grid(keys: &Keys<'_>) -> Kind {
    let grid = keys.required_text("file");
    Kind::DistanceGrid(v1::DistanceGrid { grid })
}

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
        Kind::CappedCylinder(_)
        | Kind::Box(_)
        | Kind::Torus(_)
        | Kind::Cone(_)
        | Kind::Surface(_)
        | Kind::HeightField(_)
        | Kind::DistanceGrid(_) => return None,
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
    match cosine.is_finite() {
        true => cosine.clamp(-1.0, 1.0).acos(),
        false => PI,
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

#[cfg(test)]
mod tests {
    use super::*;

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
