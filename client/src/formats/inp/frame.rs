//! Where nodes are: local systems of coordinates (`*SYSTEM`), cylindrical coordinates
//! (`*NODE, SYSTEM=C`), and the translation and rotation of instances. Lengths are those of the
//! file, angles degrees.

type Point = [f64; 3];

/// How the numbers of a node are meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Coordinates {
    Cartesian,
    /// Radius, angle from the first axis, height.
    Cylindrical,
}

impl Coordinates {
    pub(super) fn cartesian(self, [a, b, c]: Point) -> Point {
        match self {
            Self::Cartesian => [a, b, c],
            Self::Cylindrical => {
                let (sine, cosine) = b.to_radians().sin_cos();
                [a * cosine, a * sine, c]
            }
        }
    }
}

/// An origin and three axes, which are rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame {
    origin: Point,
    axes: [Point; 3],
}

impl Default for Frame {
    fn default() -> Self {
        Self {
            origin: [0.0; 3],
            axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        }
    }
}

impl Frame {
    /// By its origin, a point of the first axis and one of the plane of the first two; none where
    /// they lie on a line.
    pub(super) fn through(origin: Point, first: Point, plane: Point) -> Option<Self> {
        let x = unit(minus(first, origin))?;
        let z = unit(cross(x, minus(plane, origin)))?;
        let axes = [x, cross(z, x), z];
        Some(Self { origin, axes })
    }

    /// The local system of a surface that is swept from its origin towards a point: its third axis
    /// points the other way. None where the three points lie on a line.
    pub(super) fn swept(origin: Point, first: Point, towards: Point) -> Option<Self> {
        let across = cross(minus(first, origin), minus(towards, origin));
        Self::through(origin, first, plus(origin, across))
    }

    /// Within another frame, in which its origin and axes are given.
    pub(super) fn within(self, outer: &Self) -> Self {
        Self {
            origin: outer.place(self.origin),
            axes: self.axes.map(|axis| outer.turn(axis)),
        }
    }

    /// Moved by the origin alone.
    pub(super) fn at(origin: Point) -> Self {
        Self {
            origin,
            ..Self::default()
        }
    }

    /// Turned about the axis from a to b by an angle after being moved by `self`; none where a and
    /// b are one point.
    pub(super) fn turned(self, a: Point, b: Point, degrees: f64) -> Option<Self> {
        let axis = unit(minus(b, a))?;
        let (sine, cosine) = degrees.to_radians().sin_cos();
        let turn = |vector: Point| {
            let across = cross(axis, vector);
            let along = dot(axis, vector) * (1.0 - cosine);
            [0, 1, 2].map(|i| {
                let at = |point: Point| point.get(i).copied().unwrap_or_default();
                at(vector) * cosine + at(across) * sine + at(axis) * along
            })
        };
        let origin = plus(a, turn(minus(self.origin, a)));
        let axes = self.axes.map(turn);
        Some(Self { origin, axes })
    }

    /// Where a point of the frame is.
    pub(super) fn place(&self, point: Point) -> Point {
        plus(self.origin, self.turn(point))
    }

    /// A vector of the frame.
    fn turn(&self, [x, y, z]: Point) -> Point {
        let [a, b, c] = self.axes;
        let scaled = |by: f64, axis: Point| axis.map(|one| by * one);
        plus(plus(scaled(x, a), scaled(y, b)), scaled(z, c))
    }
}

fn unit(vector: Point) -> Option<Point> {
    let length = dot(vector, vector).sqrt();
    (length > 0.0 && length.is_finite()).then(|| vector.map(|x| x / length))
}

fn plus([a, b, c]: Point, [x, y, z]: Point) -> Point {
    [a + x, b + y, c + z]
}

fn minus([a, b, c]: Point, [x, y, z]: Point) -> Point {
    [a - x, b - y, c - z]
}

fn cross([a, b, c]: Point, [x, y, z]: Point) -> Point {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}

fn dot([a, b, c]: Point, [x, y, z]: Point) -> f64 {
    a * x + b * y + c * z
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(found: Point, expected: Point) {
        let off = minus(found, expected);
        assert!(dot(off, off) < 1e-24, "{found:?} {expected:?}");
    }

    #[test]
    fn frames_place_points_by_origin_axes_and_turns() {
        let frame = Frame::through([1.0, 0.0, 0.0], [1.0, 2.0, 0.0], [0.0, 5.0, 0.0]).unwrap();
        // The first axis is y, the second -x.
        near(frame.place([1.0, 2.0, 3.0]), [-1.0, 1.0, 3.0]);
        let turned = Frame::at([1.0, 0.0, 0.0]).turned([0.0; 3], [0.0, 0.0, 2.0], 90.0);
        near(turned.unwrap().place([1.0, 0.0, 4.0]), [0.0, 2.0, 4.0]);
        let about = Frame::default().turned([1.0, 1.0, 0.0], [1.0, 1.0, 1.0], 180.0);
        near(about.unwrap().place([0.0; 3]), [2.0, 2.0, 0.0]);
        near(
            Coordinates::Cylindrical.cartesian([2.0, 30.0, 7.0]),
            [3.0_f64.sqrt(), 1.0, 7.0],
        );
        assert_eq!(
            Frame::through([0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]),
            None
        );
    }

    #[test]
    fn surfaces_are_swept_against_their_third_axis_in_the_frame_around_them() {
        let frame = Frame::swept([0.0; 3], [3.0, 0.0, 0.0], [0.0, -2.0, 0.0]).unwrap();
        near(frame.place([1.0, 0.0, 0.0]), [1.0, 0.0, 0.0]);
        near(frame.place([0.0, 1.0, 0.0]), [0.0, 0.0, -1.0]);
        near(frame.place([0.0, 0.0, 1.0]), [0.0, 1.0, 0.0]);
        let outer = Frame::at([5.0, 0.0, 0.0]).turned([0.0; 3], [0.0, 0.0, 1.0], 90.0);
        let inner = Frame::at([1.0, 2.0, 3.0]).within(&outer.unwrap());
        near(inner.place([1.0, 0.0, 0.0]), [-2.0, 7.0, 3.0]);
    }

    #[test]
    fn without_a_turn_places_are_kept_to_the_bit() {
        let frame = Frame::at([2.0, 0.5, 0.0]);
        assert_eq!(
            frame.place([0.1, 0.2, 0.3]).map(f64::to_bits),
            [2.1, 0.7, 0.3].map(f64::to_bits)
        );
        let point = [0.1, -0.2, 1e-300];
        assert_eq!(
            Frame::default().place(point).map(f64::to_bits),
            point.map(f64::to_bits)
        );
    }
}
