//! Writes the surface of a rigid obstacle in its current pose as VTP.
//!
//! Infinite shapes are drawn as the piece that a body of the given bounding box
//! can meet: a half-space as a square, a cylinder as a tube as long as the
//! diagonal. The pose is x -> R (x - c) + c + t with the reference point c of
//! the shape, the translation t and the rotation vector of R. Cost: some
//! thousand triangles, whatever the scene.

use std::f64::consts::{PI, TAU};

use super::vtk_xml::Writer;

type Vector = [f64; 3];

/// Lines of latitude and half the lines of longitude of a sphere; a third of
/// the facets around a cylinder.
const DIVISIONS: usize = 32;

/// A shape that can be drawn, in its initial pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Surface {
    /// The plane that bounds a half-space.
    Plane {
        /// On the plane; reference point.
        point: Vector,
        /// Any length above zero.
        normal: Vector,
    },
    /// A sphere.
    Sphere {
        /// Reference point.
        centre: Vector,
        /// Length.
        radius: f64,
    },
    /// An infinite circular cylinder.
    Cylinder {
        /// On the axis; reference point.
        point: Vector,
        /// Any length above zero.
        axis: Vector,
        /// Length.
        radius: f64,
    },
}

/// Where a shape is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// From the initial pose, length.
    pub translation: Vector,
    /// Rotation vector about the reference point, radians.
    pub rotation: Vector,
}

/// The box that holds the undeformed body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundingBox {
    /// Smallest coordinates.
    pub low: Vector,
    /// Largest coordinates.
    pub high: Vector,
}

impl BoundingBox {
    /// The box of some points; all zero without points.
    pub fn of(points: &[Vector]) -> Self {
        let first = points.first().copied().unwrap_or_default();
        let start = Self {
            low: first,
            high: first,
        };
        points.iter().fold(start, |bounds, point| Self {
            low: map2(bounds.low, *point, f64::min),
            high: map2(bounds.high, *point, f64::max),
        })
    }

    fn diagonal(&self) -> f64 {
        length(subtract(self.high, self.low))
    }

    fn centre(&self) -> Vector {
        map2(self.low, self.high, |low, high| 0.5 * (low + high))
    }
}

/// Points and triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Triangulation {
    /// [points, 3].
    pub points: Vec<Vector>,
    /// Indices of points.
    pub triangles: Vec<[i64; 3]>,
}

/// The bytes of a VTP file with the surface in its pose.
pub fn write(surface: &Surface, pose: &Pose, body: &BoundingBox) -> Vec<u8> {
    let surface = triangulate(surface, pose, body);
    let points: Vec<f64> = surface.points.iter().flatten().copied().collect();
    let connectivity: Vec<i64> = surface.triangles.iter().flatten().copied().collect();
    let ends: Vec<i64> = (1..=surface.triangles.len() as i64)
        .map(|triangle| 3 * triangle)
        .collect();
    let mut file = Writer::new("PolyData");
    file.line("<PolyData>");
    file.line(&format!(
        "<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"{}\">",
        surface.points.len(),
        surface.triangles.len()
    ));
    file.line("<Points>");
    file.array("Points", 3, &points);
    file.line("</Points>");
    file.line("<Polys>");
    file.array("connectivity", 1, &connectivity);
    file.array("offsets", 1, &ends);
    file.line("</Polys>");
    file.line("</Piece>");
    file.finish("PolyData")
}

/// The surface in its pose, as triangles.
pub fn triangulate(surface: &Surface, pose: &Pose, body: &BoundingBox) -> Triangulation {
    let (mut drawn, reference) = match *surface {
        Surface::Plane { point, normal } => (plane(point, normal, body), point),
        Surface::Sphere { centre, radius } => (sphere(centre, radius), centre),
        Surface::Cylinder {
            point,
            axis,
            radius,
        } => (cylinder(point, axis, radius, body), point),
    };
    for point in &mut drawn.points {
        let turned = rotate(subtract(*point, reference), pose.rotation);
        *point = add(add(turned, reference), pose.translation);
    }
    drawn
}

/// A square around the body's centre, as wide as its diagonal.
fn plane(point: Vector, normal: Vector, body: &BoundingBox) -> Triangulation {
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

fn sphere(centre: Vector, radius: f64) -> Triangulation {
    let columns = 2 * DIVISIONS;
    let point = |row: usize, column: usize| {
        let polar = PI * row as f64 / DIVISIONS as f64;
        let around = TAU * column as f64 / columns as f64;
        let ring = polar.sin();
        let direction = [ring * around.cos(), ring * around.sin(), polar.cos()];
        add(centre, scale(direction, radius))
    };
    grid(DIVISIONS, columns, point)
}

/// A tube around the point of its axis nearest to the body's centre.
fn cylinder(point: Vector, axis: Vector, radius: f64, body: &BoundingBox) -> Triangulation {
    let axis = unit(axis);
    let (first, second) = tangents(axis);
    let along = dot(subtract(body.centre(), point), axis);
    let extent = body.diagonal();
    let columns = 3 * DIVISIONS;
    let place = |row: usize, column: usize| {
        let around = TAU * column as f64 / columns as f64;
        let ring = add(
            scale(first, radius * around.cos()),
            scale(second, radius * around.sin()),
        );
        let offset = along + extent * (row as f64 - 0.5);
        add(point, add(ring, scale(axis, offset)))
    };
    grid(1, columns, place)
}

/// Rows of quadrilaterals, closed around, each cut in two.
fn grid(rows: usize, columns: usize, place: impl Fn(usize, usize) -> Vector) -> Triangulation {
    let mut drawn = Triangulation::default();
    for row in 0..=rows {
        drawn
            .points
            .extend((0..columns).map(|column| place(row, column)));
    }
    let index = |row: usize, column: usize| (row * columns + column % columns) as i64;
    for row in 0..rows {
        for column in 0..columns {
            let (a, b) = (index(row, column), index(row, column + 1));
            let (c, d) = (index(row + 1, column + 1), index(row + 1, column));
            drawn.triangles.extend([[a, d, c], [a, c, b]]);
        }
    }
    drawn
}

/// Rodrigues' formula for a rotation vector.
fn rotate(point: Vector, rotation: Vector) -> Vector {
    let angle = length(rotation);
    if angle <= f64::MIN_POSITIVE {
        return point;
    }
    let axis = scale(rotation, 1.0 / angle);
    let (sine, cosine) = angle.sin_cos();
    let straight = scale(point, cosine);
    let turned = scale(cross(axis, point), sine);
    let kept = scale(axis, dot(axis, point) * (1.0 - cosine));
    add(add(straight, turned), kept)
}

/// Two unit vectors normal to a unit vector and to each other.
fn tangents(normal: Vector) -> (Vector, Vector) {
    let [x, y, z] = normal.map(f64::abs);
    let helper = if x <= y && x <= z {
        [1.0, 0.0, 0.0]
    } else if y <= z {
        [0.0, 1.0, 0.0]
    } else {
        [0.0, 0.0, 1.0]
    };
    let first = unit(cross(normal, helper));
    (first, cross(normal, first))
}

fn map2(a: Vector, b: Vector, combine: impl Fn(f64, f64) -> f64) -> Vector {
    let ([ax, ay, az], [bx, by, bz]) = (a, b);
    [combine(ax, bx), combine(ay, by), combine(az, bz)]
}

fn add(a: Vector, b: Vector) -> Vector {
    map2(a, b, |a, b| a + b)
}

fn subtract(a: Vector, b: Vector) -> Vector {
    map2(a, b, |a, b| a - b)
}

fn scale(a: Vector, factor: f64) -> Vector {
    a.map(|value| value * factor)
}

fn dot(a: Vector, b: Vector) -> f64 {
    map2(a, b, |a, b| a * b).iter().sum()
}

fn length(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

fn unit(a: Vector) -> Vector {
    let length = length(a);
    if length > 0.0 {
        scale(a, 1.0 / length)
    } else {
        [0.0, 0.0, 1.0]
    }
}

fn cross(a: Vector, b: Vector) -> Vector {
    let ([ax, ay, az], [bx, by, bz]) = (a, b);
    [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx]
}

#[cfg(test)]
mod tests {
    use super::*;

    const BODY: BoundingBox = BoundingBox {
        low: [0.0; 3],
        high: [1.0, 2.0, 2.0],
    };

    fn distance(a: Vector, b: Vector) -> f64 {
        length(subtract(a, b))
    }

    #[test]
    fn sphere_points_lie_on_the_moved_sphere() {
        let surface = Surface::Sphere {
            centre: [1.0, 2.0, 3.0],
            radius: 0.5,
        };
        let pose = Pose {
            translation: [0.0, 0.0, -1.0],
            rotation: [0.3, 0.2, 9.0],
        };
        let drawn = triangulate(&surface, &pose, &BODY);
        for point in drawn.points {
            assert!((distance(point, [1.0, 2.0, 2.0]) - 0.5).abs() < 1e-14);
        }
    }

    #[test]
    fn plane_is_a_square_of_the_body_diagonal_on_the_plane() {
        let surface = Surface::Plane {
            point: [5.0, 5.0, -1.0],
            normal: [0.0, 0.0, 2.0],
        };
        let drawn = triangulate(&surface, &Pose::default(), &BODY);
        assert_eq!(drawn.triangles.len(), 2);
        for point in &drawn.points {
            assert!((point[2] + 1.0).abs() < 1e-14);
            let from_centre = distance(*point, [0.5, 1.0, -1.0]);
            assert!((from_centre - 1.5 * 2.0_f64.sqrt()).abs() < 1e-12);
        }
    }

    #[test]
    fn cylinder_points_keep_the_radius_from_the_turned_axis() {
        let surface = Surface::Cylinder {
            point: [0.0; 3],
            axis: [1.0, 0.0, 0.0],
            radius: 2.0,
        };
        let pose = Pose {
            translation: [0.0; 3],
            rotation: [0.0, 0.0, PI / 2.0],
        };
        let drawn = triangulate(&surface, &pose, &BODY);
        for [x, _, z] in drawn.points {
            assert!((x.hypot(z) - 2.0).abs() < 1e-14);
        }
    }

    #[test]
    fn a_quarter_turn_about_z_takes_x_to_y() {
        let turned = rotate([1.0, 0.0, 0.0], [0.0, 0.0, PI / 2.0]);
        assert!(distance(turned, [0.0, 1.0, 0.0]) < 1e-15);
    }

    #[test]
    fn file_is_well_formed_around_its_data() {
        let surface = Surface::Sphere {
            centre: [0.0; 3],
            radius: 1.0,
        };
        let bytes = write(&surface, &Pose::default(), &BODY);
        assert!(bytes.starts_with(b"<?xml"));
        assert!(bytes.ends_with(b"</VTKFile>\n"));
    }
}
