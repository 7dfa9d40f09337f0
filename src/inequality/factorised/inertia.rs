//! The motions that a problem's stiffness does not resist: the negative eigenvalues of
//!
//! ```text
//! K x = l N x,   B x = 0,   C x = 0 on the face,   K = A - G,   N = diag |K|
//! ```
//!
//! counted by Sylvester's law on a factor of the saddle point, as exact as the factor:
//!
//! ```text
//! n_-( [K + s N, B^T; B, -e] ) = (rows of B) + n_-( K + s N + B^T B / e )
//! ```
//!
//! s is so small that it decides only about rigid motions, which cost nothing. Reference:
//! J. Nocedal and S. Wright, Numerical Optimization, 16.3. Cost: one factor; where there are
//! such motions, one more for each eighth of the least eigenvalue.

use super::super::qp::QpStatus;
use super::circulation::crossings;
use super::system::{Matrices, System};
use crate::linalg::indefinite::SparseIndefinite;
use crate::linalg::vector::{dot, norm, scale};
use crate::linalg::{SparseRows, Workspace};
use crate::saddle::Status;

/// Shift over the diagonal below which a motion counts as free, not as soft: far below
/// what a body resists its longest wave with, (h / L)^2.
const FREE: f64 = 1e-9;
/// First shift that is tried to bring all eigenvalues above zero.
const FIRST_SHIFT: f64 = 1e-6;
/// Its growth.
const GROWTH: f64 = 8.0;
/// Above this no body is.
const MOST_SHIFT: f64 = 1e4;
/// Steps of inverse iteration after the one at which the sign of the least eigenvalue is
/// seen.
const STEPS: usize = 4;
/// Steps in all.
const MOST_STEPS: usize = 60;

/// What a factor says of a face.
#[derive(Clone, Debug)]
pub struct Inertia {
    /// Number of independent motions that lower the energy.
    pub unstable: usize,
    /// How many of these loads without a potential lead back; none where that is not known.
    pub led_back: Option<usize>,
    /// The motion of the least eigenvalue `[displacement]`, held entries zero.
    pub motion: Vec<f64>,
}

/// Counts the motions that lower the energy on `face`; `skew` is the skew part that loads
/// without a potential add to K, `start` where the search for the softest begins
/// `[displacement]`.
///
/// # Errors
/// [`QpStatus::TooLarge`] where the factor takes more than it may,
/// [`QpStatus::IndefiniteMetric`] where a matrix is singular.
pub fn inertia(
    (matrices, skew): (&Matrices<'_>, Option<&SparseRows>),
    face: &[Status],
    start: &[f64],
    work: &mut Workspace,
) -> Result<Inertia, QpStatus> {
    let system = System::new(matrices)?;
    let mut factor = system.shifted_factor(face, FREE)?;
    let unstable = system.unstable(&factor);
    let led_back = match skew.filter(|_| unstable > 0) {
        Some(skew) => crossings((&system, &factor), skew, work),
        None => Some(0),
    };
    let mut shift = FREE;
    while system.unstable(&factor) > 0 && shift < MOST_SHIFT {
        shift = FIRST_SHIFT.max(GROWTH * shift);
        factor = system.shifted_factor(face, shift)?;
    }
    // What counts as the sign of the least eigenvalue, over the diagonal.
    let bound = if unstable > 0 { 0.0 } else { f64::INFINITY };
    let motion = softest(
        &system,
        &Shifted {
            factor,
            shift,
            bound,
        },
        start,
        work,
    );
    Ok(Inertia {
        unstable,
        led_back,
        motion,
    })
}

/// A factor whose eigenvalues, moved by a shift, are all above zero.
struct Shifted {
    factor: SparseIndefinite,
    shift: f64,
    /// What the least eigenvalue without the shift is below.
    bound: f64,
}

/// The motion of the least eigenvalue by inverse iteration.
fn softest(system: &System, shifted: &Shifted, start: &[f64], work: &mut Workspace) -> Vec<f64> {
    let mut x = vec![0.0; system.scale.len()];
    let scaled = start.iter().zip(&system.scale);
    x.iter_mut().zip(scaled).for_each(|(x, (s, d))| *x = s / d);
    let mut left = STEPS;
    for _ in 0..MOST_STEPS {
        x[system.displacements..].fill(0.0);
        let length = norm(&x);
        if left == 0 || !(length > 0.0 && length.is_finite()) {
            break;
        }
        scale(&mut x, 1.0 / length);
        let before = x.clone();
        shifted.factor.solve(&mut x, work);
        let eigenvalue = dot(&before, &x).recip() - shifted.shift;
        left -= usize::from(eigenvalue < shifted.bound);
    }
    x.truncate(system.displacements);
    x.iter_mut().zip(&system.scale).for_each(|(x, d)| *x *= d);
    x
}
