//! Writes the surface of a rigid obstacle in its current pose as VTP: what of it is near
//! the body, so that a ball as large as a house does not fill the picture.
//!
//! The pose is x -> R (x - c) + c + t with the reference point c of the shape, the
//! translation t and the rotation vector of R. What a shape looks like in its initial
//! pose is said where its keys are read. Cost: some thousand triangles, whatever the
//! scene.

use super::vtk_xml::{Notes, Writer};

/// Part of the longest side of a body that counts as near it.
const NEAR: f64 = 0.25;

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

/// A box along the axes.
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

    /// The smallest box with some further points.
    #[must_use]
    pub fn with(&self, points: impl Iterator<Item = Vector>) -> Self {
        points.fold(*self, |bounds, point| Self {
            low: map2(bounds.low, point, f64::min),
            high: map2(bounds.high, point, f64::max),
        })
    }

    /// The box and a quarter of its longest side all around: what is near a body.
    #[must_use]
    pub fn neighbourhood(&self) -> Self {
        let longest = subtract(self.high, self.low)
            .into_iter()
            .fold(0.0, f64::max);
        let margin = [NEAR * longest; 3];
        Self {
            low: subtract(self.low, margin),
            high: add(self.high, margin),
        }
    }

    /// A box that holds this one as a moved shape sees it: where the shape was before `pose`
    /// moved it about `reference`.
    pub(crate) fn seen_from(&self, pose: &Pose, reference: Vector) -> Self {
        let offset = subtract(subtract(self.centre(), reference), pose.translation);
        let back = pose.rotation.map(|angle| -angle);
        let centre = add(rotate(offset, back), reference);
        let half = [0.5 * self.diagonal(); 3];
        Self {
            low: subtract(centre, half),
            high: add(centre, half),
        }
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

impl Triangulation {
    /// What of it is in a box; triangles across the sides are cut.
    #[must_use]
    pub fn within(&self, bounds: &BoundingBox) -> Self {
        let mut kept = Self::default();
        for triangle in &self.triangles {
            let corner = |index: &i64| {
                let index = usize::try_from(*index).ok()?;
                self.points.get(index).copied()
            };
            let mut polygon: Vec<Vector> = triangle.iter().filter_map(corner).collect();
            for axis in 0..3 {
                polygon = cut(&polygon, |point| above(point, bounds.low, axis));
                polygon = cut(&polygon, |point| -above(point, bounds.high, axis));
            }
            kept.add(&polygon);
        }
        kept
    }

    /// Adds a convex polygon.
    fn add(&mut self, polygon: &[Vector]) {
        let first = self.points.len() as i64;
        let fan = 1..(polygon.len() as i64 - 1).max(1);
        self.triangles
            .extend(fan.map(|next| [first, first + next, first + next + 1]));
        if polygon.len() > 2 {
            self.points.extend(polygon);
        }
    }
}

/// How far a point is above a side of a box.
fn above(point: Vector, side: Vector, axis: usize) -> f64 {
    let offset = subtract(point, side);
    offset.get(axis).copied().unwrap_or_default()
}

/// The part of a polygon where a linear function is not negative.
fn cut(polygon: &[Vector], height: impl Fn(Vector) -> f64) -> Vec<Vector> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    let next = polygon.iter().cycle().skip(1);
    for (&a, &b) in polygon.iter().zip(next) {
        let (at_a, at_b) = (height(a), height(b));
        if at_a >= 0.0 {
            kept.push(a);
        }
        if (at_a < 0.0) != (at_b < 0.0) {
            let along = at_a / (at_a - at_b);
            kept.push(add(a, scale(subtract(b, a), along)));
        }
    }
    kept
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

/// The bytes of a VTP file with a surface.
pub fn write(surface: &Triangulation, notes: &Notes) -> Vec<u8> {
    let points: Vec<f64> = surface.points.iter().flatten().copied().collect();
    let connectivity: Vec<i64> = surface.triangles.iter().flatten().copied().collect();
    let ends: Vec<i64> = (1..=surface.triangles.len() as i64)
        .map(|triangle| 3 * triangle)
        .collect();
    let mut file = Writer::new("PolyData");
    file.line("<PolyData>");
    file.notes(notes);
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

/// Rows of quadrilaterals, each cut in two.
pub(crate) fn sheet(
    rows: usize,
    columns: usize,
    place: impl Fn(usize, usize) -> Vector,
) -> Triangulation {
    let mut drawn = Triangulation::default();
    for row in 0..=rows {
        drawn
            .points
            .extend((0..=columns).map(|column| place(row, column)));
    }
    let index = |row: usize, column: usize| (row * (columns + 1) + column) as i64;
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

/// a x b.
pub(crate) fn cross(a: Vector, b: Vector) -> Vector {
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
    fn a_large_square_is_cut_to_the_box_around_the_body() {
        let corner = |x: f64, y: f64| [100.0 * x, 100.0 * y, 0.5];
        let square = Triangulation {
            points: vec![
                corner(-1.0, -1.0),
                corner(1.0, -1.0),
                corner(1.0, 1.0),
                corner(-1.0, 1.0),
            ],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
        };
        let body = BoundingBox::of(&[[0.0; 3], [2.0, 1.0, 1.0]]);
        let near = body.neighbourhood();
        assert!(
            distance(near.low, [-0.5; 3]) < 1e-15 && distance(near.high, [2.5, 1.5, 1.5]) < 1e-15
        );
        let cut = square.within(&near);
        let area: f64 = cut
            .triangles
            .iter()
            .map(|corners| {
                let [a, b, c] = corners.map(|corner| cut.points[corner as usize]);
                0.5 * length(cross(subtract(b, a), subtract(c, a)))
            })
            .sum();
        assert!((area - 6.0).abs() < 1e-12, "{area}");
        let far = Triangulation {
            points: square
                .points
                .iter()
                .map(|point| add(*point, [0.0, 0.0, 9.0]))
                .collect(),
            ..square
        };
        assert_eq!(far.within(&near), Triangulation::default());
    }

    #[test]
    fn a_box_seen_from_a_moved_shape_moves_the_other_way() {
        let pose = Pose {
            translation: [5.0, 0.0, 0.0],
            rotation: [0.0, 0.0, PI / 2.0],
        };
        let seen = BoundingBox::of(&[[6.0, 2.0, 0.0]]).seen_from(&pose, [1.0, 1.0, 0.0]);
        assert!(distance(seen.centre(), [2.0, 1.0, 0.0]) < 1e-14);
    }

    #[test]
    fn file_is_well_formed_around_its_data() {
        let bytes = write(&triangle().surface, &Notes::default());
        assert!(bytes.starts_with(b"<?xml"));
        assert!(bytes.ends_with(b"</VTKFile>\n"));
    }
}
