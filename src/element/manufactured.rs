//! Analytic fields for verification: −div(2μ ε(u) − p I) = f, div u = 0.
//!
//! Each field is smooth and divergence-free on the whole space, so that
//! f = −μ Δu + ∇p with Δu and ∇p in closed form. Lengths and displacements are
//! numbers of order one; plane fields have no third component and do not
//! depend on z. `A1m` is the field of the benchmark of that name, `vortex` and
//! `trigonometric` are classic ones, and `polynomial` (u quadratic, p linear)
//! lies in the Taylor-Hood space. Cost: a few sines per value.

use std::f64::consts::PI;

use crate::geometry::Matrix3;

/// A vector or a point with three components; the third is zero in the plane.
type Vector = [f64; 3];

/// A named analytic field.
#[derive(Clone, Copy, Debug)]
pub struct Manufactured(&'static Formulas);

/// The functions of one field, at a position in the unit body; all derivatives are by
/// hand.
#[derive(Debug)]
struct Formulas {
    /// Name by which scenes ask for the field.
    name: &'static str,
    /// Dimension of the bodies that the field is for: 2 or 3.
    dimension: usize,
    /// Displacement `[3]` at a position; its divergence is zero.
    displacement: fn(Vector) -> Vector,
    /// Gradient of the displacement at a position: row i holds the derivatives of
    /// component i.
    gradient: fn(Vector) -> Matrix3,
    /// Laplacian of each component of the displacement `[3]`.
    laplacian: fn(Vector) -> Vector,
    /// Internal pressure at a position, positive in compression.
    pressure: fn(Vector) -> f64,
    /// Gradient of the pressure at a position `[3]`.
    pressure_gradient: fn(Vector) -> Vector,
}

/// All fields, in the order in which error messages list them.
static FIELDS: [Formulas; 5] = [
    Formulas {
        name: "A1m",
        dimension: 3,
        displacement: a1m::displacement,
        gradient: a1m::gradient,
        laplacian: a1m::laplacian,
        pressure: |[x, y, z]| (PI * x).cos() * y * z,
        pressure_gradient: |[x, y, z]| {
            let (sine, cosine) = (PI * x).sin_cos();
            [-PI * sine * y * z, cosine * z, cosine * y]
        },
    },
    Formulas {
        name: "polynomial",
        dimension: 3,
        displacement: |[x, y, z]| {
            [
                x * x + 2.0 * y * y + y * z - x * z,
                y * y - 2.0 * x * y + 3.0 * z * z - x * z,
                0.5 * z * z - 2.0 * y * z + x * x + x * y,
            ]
        },
        gradient: |[x, y, z]| {
            [
                [2.0 * x - z, 4.0 * y + z, y - x],
                [-2.0 * y - z, 2.0 * y - 2.0 * x, 6.0 * z - x],
                [2.0 * x + y, x - 2.0 * z, z - 2.0 * y],
            ]
        },
        laplacian: |_| [6.0, 8.0, 3.0],
        pressure: |[x, y, z]| 1.0 + 2.0 * x - 3.0 * y + z,
        pressure_gradient: |_| [2.0, -3.0, 1.0],
    },
    Formulas {
        name: "polynomial",
        dimension: 2,
        displacement: |[x, y, _]| {
            [
                x * x + 2.0 * y * y + x * y,
                x * x - 2.0 * x * y - 0.5 * y * y,
                0.0,
            ]
        },
        gradient: |[x, y, _]| {
            [
                [2.0 * x + y, 4.0 * y + x, 0.0],
                [2.0 * x - 2.0 * y, -2.0 * x - y, 0.0],
                [0.0; 3],
            ]
        },
        laplacian: |_| [6.0, 1.0, 0.0],
        pressure: |[x, y, _]| 1.0 + 2.0 * x - 3.0 * y,
        pressure_gradient: |_| [2.0, -3.0, 0.0],
    },
    Formulas {
        name: "vortex",
        dimension: 2,
        displacement: vortex::displacement,
        gradient: vortex::gradient,
        laplacian: vortex::laplacian,
        pressure: |[x, y, _]| (PI * x).sin() * (PI * y).cos(),
        pressure_gradient: |[x, y, _]| {
            let ((sine_x, cosine_x), (sine_y, cosine_y)) = ((PI * x).sin_cos(), (PI * y).sin_cos());
            [PI * cosine_x * cosine_y, -PI * sine_x * sine_y, 0.0]
        },
    },
    Formulas {
        name: "trigonometric",
        dimension: 3,
        displacement: trigonometric::displacement,
        gradient: trigonometric::gradient,
        laplacian: |point| {
            trigonometric::displacement(point).map(|component| -3.0 * PI * PI * component)
        },
        pressure: |point| trigonometric::sines(point) - (2.0 / PI).powi(3),
        pressure_gradient: trigonometric::pressure_gradient,
    },
];

impl Manufactured {
    /// All names, each once.
    pub fn names() -> &'static [&'static str] {
        &["A1m", "polynomial", "vortex", "trigonometric"]
    }

    /// The field of this name in 2 or 3 dimensions; `None` if there is none.
    pub fn from_name(name: &str, dimension: usize) -> Option<Self> {
        let mut fields = FIELDS.iter();
        let found = fields.find(|field| field.name == name && field.dimension == dimension);
        found.map(Self)
    }

    /// The name in scenes.
    pub fn name(&self) -> &'static str {
        self.0.name
    }

    /// 2 or 3.
    pub fn dimension(&self) -> usize {
        self.0.dimension
    }

    /// u(x) `[3]`.
    pub fn displacement(&self, point: [f64; 3]) -> [f64; 3] {
        (self.0.displacement)(point)
    }

    /// ∂u_i/∂x_j `[3, 3]`, row i, column j; its trace is zero.
    pub fn gradient(&self, point: [f64; 3]) -> Matrix3 {
        (self.0.gradient)(point)
    }

    /// p(x), positive in compression.
    pub fn pressure(&self, point: [f64; 3]) -> f64 {
        (self.0.pressure)(point)
    }

    /// f = −μ Δu + ∇p `[3]`, force per volume.
    pub fn body_force(&self, point: [f64; 3], shear_modulus: f64) -> [f64; 3] {
        let laplacian = (self.0.laplacian)(point);
        let slope = (self.0.pressure_gradient)(point);
        [0, 1, 2].map(|axis| slope[axis] - shear_modulus * laplacian[axis])
    }

    /// σ = 2μ ε(u) − p I `[3, 3]`.
    pub fn stress(&self, point: [f64; 3], shear_modulus: f64) -> Matrix3 {
        let gradient = self.gradient(point);
        let pressure = self.pressure(point);
        let mut stress = [[0.0; 3]; 3];
        for row in 0..3 {
            for column in 0..3 {
                stress[row][column] =
                    shear_modulus * (gradient[row][column] + gradient[column][row]);
            }
            stress[row][row] -= pressure;
        }
        stress
    }

    /// σ n `[3]`, force per area on a surface of unit normal n.
    pub fn traction(&self, point: [f64; 3], normal: [f64; 3], shear_modulus: f64) -> [f64; 3] {
        let stress = self.stress(point, shear_modulus);
        stress.map(|row| row[0] * normal[0] + row[1] * normal[1] + row[2] * normal[2])
    }
}

/// u = curl(0, x³ y z², x³ sin(πy) cos z), p = cos(πx) y z.
mod a1m {
    use super::{Matrix3, PI, Vector};

    /// Displacement of the field; polynomial in x, of waves in y and z.
    pub(super) fn displacement([x, y, z]: Vector) -> Vector {
        let (sine, cosine) = (PI * y).sin_cos();
        [
            PI * x.powi(3) * cosine * z.cos() - 2.0 * x.powi(3) * y * z,
            -3.0 * x * x * sine * z.cos(),
            3.0 * x * x * y * z * z,
        ]
    }

    /// Gradient of that displacement: row i holds the derivatives of component i.
    pub(super) fn gradient([x, y, z]: Vector) -> Matrix3 {
        let ((sine_y, cosine_y), (sine_z, cosine_z)) = ((PI * y).sin_cos(), z.sin_cos());
        let (square, cube) = (x * x, x.powi(3));
        [
            [
                3.0 * square * (PI * cosine_y * cosine_z - 2.0 * y * z),
                -cube * (PI * PI * sine_y * cosine_z + 2.0 * z),
                -cube * (PI * cosine_y * sine_z + 2.0 * y),
            ],
            [
                -6.0 * x * sine_y * cosine_z,
                -3.0 * PI * square * cosine_y * cosine_z,
                3.0 * square * sine_y * sine_z,
            ],
            [
                6.0 * x * y * z * z,
                3.0 * square * z * z,
                6.0 * square * y * z,
            ],
        ]
    }

    /// Laplacian of each component of that displacement.
    pub(super) fn laplacian([x, y, z]: Vector) -> Vector {
        let ((sine, cosine), cosine_z) = ((PI * y).sin_cos(), z.cos());
        let cube = x.powi(3);
        [
            PI * (6.0 * x - (PI * PI + 1.0) * cube) * cosine * cosine_z - 12.0 * x * y * z,
            3.0 * ((PI * PI + 1.0) * x * x - 2.0) * sine * cosine_z,
            6.0 * y * (z * z + x * x),
        ]
    }
}

/// u = π (sin²(πx) sin(2πy), −sin(2πx) sin²(πy)), p = sin(πx) cos(πy).
mod vortex {
    use super::{Matrix3, PI, Vector};

    /// Displacement of the vortex, the curl of a squared stream function: zero on the
    /// boundary of the unit square.
    pub(super) fn displacement([x, y, _]: Vector) -> Vector {
        let square = |value: f64| (PI * value).sin().powi(2);
        let double = |value: f64| (2.0 * PI * value).sin();
        [PI * square(x) * double(y), -PI * double(x) * square(y), 0.0]
    }

    /// Gradient of that displacement: row i holds the derivatives of component i.
    pub(super) fn gradient([x, y, _]: Vector) -> Matrix3 {
        let square = |value: f64| (PI * value).sin().powi(2);
        let double = |value: f64| (2.0 * PI * value).sin_cos();
        let ((sine_x, cosine_x), (sine_y, cosine_y)) = (double(x), double(y));
        let factor = PI * PI;
        let stretch = factor * sine_x * sine_y;
        [
            [stretch, 2.0 * factor * square(x) * cosine_y, 0.0],
            [-2.0 * factor * cosine_x * square(y), -stretch, 0.0],
            [0.0; 3],
        ]
    }

    /// Laplacian of each component of that displacement.
    pub(super) fn laplacian([x, y, _]: Vector) -> Vector {
        let double = |value: f64| (2.0 * PI * value).sin_cos();
        let ((sine_x, cosine_x), (sine_y, cosine_y)) = (double(x), double(y));
        let factor = 2.0 * PI.powi(3);
        [
            factor * sine_y * (2.0 * cosine_x - 1.0),
            -factor * sine_x * (2.0 * cosine_y - 1.0),
            0.0,
        ]
    }
}

/// u = (s_x c_y c_z, c_x s_y c_z, −2 c_x c_y s_z), p = s_x s_y s_z − (2/π)³
/// with s and c the sine and cosine of π times the coordinate.
mod trigonometric {
    use super::{Matrix3, PI, Vector};

    /// Sines and cosines of pi times each coordinate.
    fn waves(point: Vector) -> (Vector, Vector) {
        (
            point.map(|value| (PI * value).sin()),
            point.map(|value| (PI * value).cos()),
        )
    }

    /// The product of the sines of pi times the coordinates: the pressure of several
    /// fields.
    pub(super) fn sines(point: Vector) -> f64 {
        waves(point).0.iter().product()
    }

    /// Displacement of products of waves; the derivatives along the axes cancel in the
    /// divergence.
    pub(super) fn displacement(point: Vector) -> Vector {
        let ([sx, sy, sz], [cx, cy, cz]) = waves(point);
        [sx * cy * cz, cx * sy * cz, -2.0 * cx * cy * sz]
    }

    /// Gradient of that displacement: row i holds the derivatives of component i.
    pub(super) fn gradient(point: Vector) -> Matrix3 {
        let ([sx, sy, sz], [cx, cy, cz]) = waves(point);
        let (all, xy, xz, yz) = (cx * cy * cz, sx * sy * cz, sx * cy * sz, cx * sy * sz);
        [
            [PI * all, -PI * xy, -PI * xz],
            [-PI * xy, PI * all, -PI * yz],
            [2.0 * PI * xz, 2.0 * PI * yz, -2.0 * PI * all],
        ]
    }

    /// Gradient of the product of sines.
    pub(super) fn pressure_gradient(point: Vector) -> Vector {
        let ([sx, sy, sz], [cx, cy, cz]) = waves(point);
        [PI * cx * sy * sz, PI * sx * cy * sz, PI * sx * sy * cz]
    }
}

#[cfg(test)]
mod tests;
