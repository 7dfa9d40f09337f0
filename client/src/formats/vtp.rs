//! Writes the surface of a rigid obstacle in its current pose as VTP.
//!
//! The pose is x -> R (x - c) + c + t with the reference point c of the shape, the
//! translation t and the rotation vector of R. What a shape looks like in its initial
//! pose is said where its keys are read. Cost: some thousand triangles, whatever the
//! scene.

use super::vtk_xml::Writer;

/// A point or a direction `[3]`.
pub(crate) type Vector = [f64; 3];

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

    /// Distance between the two corners.
    pub(crate) fn diagonal(&self) -> f64 {
        length(subtract(self.high, self.low))
    }

    /// Half way between its corners.
    pub(crate) fn centre(&self) -> Vector {
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

/// A shape as it is drawn in its initial pose.
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    /// The surface, or the piece of it that the body can meet.
    pub surface: Triangulation,
    /// The point that rotations leave in place.
    pub reference: Vector,
}

impl Outline {
    /// The surface in another pose.
    pub fn posed(&self, pose: &Pose) -> Triangulation {
        let mut drawn = self.surface.clone();
        for point in &mut drawn.points {
            let turned = rotate(subtract(*point, self.reference), pose.rotation);
            *point = add(add(turned, self.reference), pose.translation);
        }
        drawn
    }
}

/// The bytes of a VTP file with the outline in its pose.
pub fn write(outline: &Outline, pose: &Pose) -> Vec<u8> {
    let surface = outline.posed(pose);
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

/// Rows of quadrilaterals, closed around, each cut in two.
pub(crate) fn grid(
    rows: usize,
    columns: usize,
    place: impl Fn(usize, usize) -> Vector,
) -> Triangulation {
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
pub(crate) fn tangents(normal: Vector) -> (Vector, Vector) {
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

/// a + b.
pub(crate) fn add(a: Vector, b: Vector) -> Vector {
    map2(a, b, |a, b| a + b)
}

/// a - b.
pub(crate) fn subtract(a: Vector, b: Vector) -> Vector {
    map2(a, b, |a, b| a - b)
}

/// `factor` a.
pub(crate) fn scale(a: Vector, factor: f64) -> Vector {
    a.map(|value| value * factor)
}

/// a . b.
pub(crate) fn dot(a: Vector, b: Vector) -> f64 {
    map2(a, b, |a, b| a * b).iter().sum()
}

fn length(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

/// a / |a|; +z for the zero vector.
pub(crate) fn unit(a: Vector) -> Vector {
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
    use std::f64::consts::PI;

    use super::*;

    fn distance(a: Vector, b: Vector) -> f64 {
        length(subtract(a, b))
    }

    #[test]
    fn a_quarter_turn_about_z_takes_x_to_y() {
        let turned = rotate([1.0, 0.0, 0.0], [0.0, 0.0, PI / 2.0]);
        assert!(distance(turned, [0.0, 1.0, 0.0]) < 1e-15);
    }

    fn triangle() -> Outline {
        Outline {
            surface: Triangulation {
                points: vec![[2.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 0.0, 1.0]],
                triangles: vec![[0, 1, 2]],
            },
            reference: [1.0, 0.0, 0.0],
        }
    }

    #[test]
    fn an_outline_turns_about_its_reference_point_and_shifts() {
        let pose = Pose {
            translation: [0.0, 0.0, 5.0],
            rotation: [0.0, 0.0, PI / 2.0],
        };
        let drawn = triangle().posed(&pose);
        let expected = [[1.0, 1.0, 5.0], [0.0, 0.0, 5.0], [1.0, 0.0, 6.0]];
        for (found, expected) in drawn.points.iter().zip(expected) {
            assert!(distance(*found, expected) < 1e-15);
        }
    }

    #[test]
    fn file_is_well_formed_around_its_data() {
        let bytes = write(&triangle(), &Pose::default());
        assert!(bytes.starts_with(b"<?xml"));
        assert!(bytes.ends_with(b"</VTKFile>\n"));
    }
}
