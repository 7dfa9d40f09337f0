//! Calibration of a law of rubber to test curves: its constants by least squares, how sure they
//! are, and where the law stops being stable.
//!
//! ```text
//! sum_i w_i^2 (T(l_i; constants) - T_i)^2 -> min,   w_i = 1 / max(|T_i|, 5 % of the largest) or one
//! half width at 95 %:  t sqrt(sum / (m - n)) sqrt((J^T J)^-1_kk)    m points, n constants
//! ```
//!
//! T in closed form for incompressible bodies ([`TestKind`]), by the stress of the law itself.
//! Stresses and constants in one unit, the caller's. From several starts the least sum counts.
//! Curves of whole scenes, whose values come with derivatives, are fitted by [`Search`].
//! Reference: G. A. F. Seber, C. J. Wild, Nonlinear Regression, 1989, section 5. Cost: some 10^4
//! stresses a point.

mod constants;
mod curve;
mod least_squares;
mod search;

pub use curve::TestKind;
pub use search::{Measured, Modelled, Progress, Search};

use thiserror::Error;

use crate::material::{Isochoric, stability};
use crate::scene::validate::isochoric;
use crate::scene::{RubberModel, SceneError};
use constants::{Constant, Size, constants, starts, values, with_values};
use curve::nominal_stress;
use least_squares::{Minimum, Unknown, minimise, variances};

/// Share of the largest stress of a kind of test below which errors are not relative; chosen,
/// without unit.
const FLOOR: f64 = 0.05;
/// Stretches that tests may have.
const STRETCHES: [f64; 2] = [0.01, 100.0];
/// 97.5 % of a normal distribution lie below.
const NORMAL: f64 = 1.959_963_984_540_054;

/// A point of a test curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Test {
    /// The deformation.
    pub kind: TestKind,
    /// Length over undeformed length.
    pub stretch: f64,
    /// Force over undeformed area.
    pub stress: f64,
}

/// What counts as an error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Weighting {
    /// The difference over the measured stress, of small stresses over 5 % of the largest.
    #[default]
    Relative,
    /// The difference itself.
    Absolute,
}

/// Why there is no fit.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum CalibrationError {
    /// Too few points.
    #[error("{points} points do not determine {constants} constants: give more, or another law")]
    TooFew {
        /// Points that are not at rest.
        points: usize,
        /// Constants of the law.
        constants: usize,
    },
    /// A point that is none.
    #[error("point {number}: a stretch from 0.01 to 100 and a finite stress are expected")]
    NoPoint {
        /// Its number, from 1.
        number: usize,
    },
    /// A foam.
    #[error(
        "{law} is a law of compressible bodies, and the closed forms hold for incompressible ones"
    )]
    Compressible {
        /// Name of the law.
        law: &'static str,
    },
    /// The law itself.
    #[error(transparent)]
    Law(#[from] SceneError),
    /// Stresses that no such law has.
    #[error(
        "no constants of {law} come near these stresses: their signs, or their columns, are wrong"
    )]
    NoFit {
        /// Name of the law.
        law: &'static str,
    },
}

/// A constant that was fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct Fitted {
    /// Its key in the scene; of lists with the place, from 0.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Half the width of its interval of 95 %; none at a bound, or where the tests do not determine
    /// it.
    pub half_width: Option<f64>,
}

/// Where a law stops being stable (D. C. Drucker).
#[derive(Clone, Debug, PartialEq)]
pub struct StabilityLimit {
    /// The way of deformation.
    pub way: &'static str,
    /// The first stretch on it that is not stable.
    pub stretch: f64,
}

/// A fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibrated {
    /// The law with its constants.
    pub model: RubberModel,
    /// The constants.
    pub constants: Vec<Fitted>,
    /// Root of the mean square of the weighted errors.
    pub misfit: f64,
    /// The largest weighted error, without sign.
    pub largest: f64,
    /// Where the law is not stable, between stretches of 0.1 and 10; empty where it is throughout.
    pub unstable: Vec<StabilityLimit>,
}

/// Nominal stress of an incompressible rubber in a test.
///
/// # Errors
/// [`CalibrationError::Law`] for constants that are none.
pub fn stress(model: &RubberModel, kind: TestKind, stretch: f64) -> Result<f64, CalibrationError> {
    Ok(nominal_stress(&isochoric(model)?, kind, stretch))
}

/// The constants of a law that are nearest to `tests`; those of `model` are one start among others.
///
/// # Errors
/// [`CalibrationError`], the first one found.
pub fn calibrate(
    model: &RubberModel,
    tests: &[Test],
    weighting: Weighting,
) -> Result<Calibrated, CalibrationError> {
    check(tests)?;
    let weights = weights(tests, weighting);
    let size = Size::of(tests, modulus(tests, &weights));
    let law = model.name();
    let named = constants(model, &values(model), size);
    let named = named.ok_or(CalibrationError::Compressible { law })?;
    let points = tests
        .iter()
        .filter(|test| (test.stretch - 1.0).abs() > 0.0)
        .count();
    if points < named.len() {
        let constants = named.len();
        return Err(CalibrationError::TooFew { points, constants });
    }
    let fits = starts(model, size).into_iter().filter_map(|start| {
        let named = constants(model, &start, size)?;
        let unknowns: Vec<Unknown> = named.iter().map(|one| one.unknown).collect();
        let residuals = |at: &[f64]| residuals(&with_values(model, at), tests, &weights);
        let minimum = minimise(&residuals, &unknowns, &start)?;
        Some((with_values(model, &minimum.at), named, minimum))
    });
    let best = fits.min_by(|one, other| one.2.sum.total_cmp(&other.2.sum));
    let (model, named, minimum) = best.ok_or(CalibrationError::NoFit { law })?;
    let law = isochoric(&model)?;
    let errors = residuals(&model, tests, &weights).unwrap_or_default();
    Ok(Calibrated {
        constants: fitted(&named, &minimum, points),
        misfit: (minimum.sum / points.max(1) as f64).sqrt(),
        largest: errors.iter().fold(0.0, |most, error| error.abs().max(most)),
        unstable: unstable(&law),
        model,
    })
}

/// Refuses points that are none.
fn check(tests: &[Test]) -> Result<(), CalibrationError> {
    let [least, most] = STRETCHES;
    let is_wrong =
        |test: &Test| !((least..=most).contains(&test.stretch) && test.stress.is_finite());
    match tests.iter().position(is_wrong) {
        Some(place) => Err(CalibrationError::NoPoint { number: place + 1 }),
        None => Ok(()),
    }
}

/// What each error is multiplied by `[tests]`.
fn weights(tests: &[Test], weighting: Weighting) -> Vec<f64> {
    let largest = |kind: TestKind| {
        let own = tests.iter().filter(|test| test.kind == kind);
        own.fold(0.0, |most: f64, test| most.max(test.stress.abs()))
    };
    let largest = TestKind::ALL.map(|kind| (kind, largest(kind)));
    let weight = |test: &Test| {
        let most = largest.iter().find(|one| one.0 == test.kind);
        let size = test.stress.abs().max(FLOOR * most.map_or(1.0, |one| one.1));
        if size > 0.0 { size.recip() } else { 1.0 }
    };
    match weighting {
        Weighting::Relative => tests.iter().map(weight).collect(),
        Weighting::Absolute => vec![1.0; tests.len()],
    }
}

/// Shear modulus of the neo-Hookean law that is nearest; one where none is above zero.
fn modulus(tests: &[Test], weights: &[f64]) -> f64 {
    let unit = RubberModel::NeoHookean { shear_modulus: 1.0 };
    let Ok(law) = isochoric(&unit) else {
        return 1.0;
    };
    let parts = tests.iter().zip(weights).map(|(test, weight)| {
        let stress = weight * nominal_stress(&law, test.kind, test.stretch);
        [stress * weight * test.stress, stress * stress]
    });
    let [work, square] = parts.fold([0.0; 2], |sum, part| [sum[0] + part[0], sum[1] + part[1]]);
    let modulus = work / square;
    if modulus.is_finite() && modulus > 0.0 {
        modulus
    } else {
        1.0
    }
}

/// Weighted errors `[tests]`; none where the law is none.
fn residuals(model: &RubberModel, tests: &[Test], weights: &[f64]) -> Option<Vec<f64>> {
    let law = isochoric(model).ok()?;
    let pairs = tests.iter().zip(weights);
    let error = |(test, weight): (&Test, &f64)| {
        weight * (nominal_stress(&law, test.kind, test.stretch) - test.stress)
    };
    Some(pairs.map(error).collect())
}

/// The constants with their intervals.
fn fitted(named: &[Constant], minimum: &Minimum, points: usize) -> Vec<Fitted> {
    let unknowns: Vec<Unknown> = named.iter().map(|one| one.unknown).collect();
    let freedom = points.saturating_sub(named.len());
    let spread = (minimum.sum / freedom.max(1) as f64).sqrt();
    let variances = variances(minimum, &unknowns);
    let all = named.iter().zip(&minimum.at).zip(variances);
    all.map(|((constant, &value), variance)| Fitted {
        name: constant.name.clone(),
        value,
        half_width: variance
            .filter(|_| freedom > 0)
            .map(|variance| student(freedom) * spread * variance.sqrt()),
    })
    .collect()
}

/// 97.5 % of Student's distribution with that many degrees of freedom lie below: the expansion
/// 26.7.5 of M. Abramowitz, I. A. Stegun, to 1 % from three degrees on.
fn student(freedom: usize) -> f64 {
    let (x, n) = (NORMAL, freedom as f64);
    let first = (x.powi(3) + x) / 4.0;
    let second = (5.0 * x.powi(5) + 16.0 * x.powi(3) + 3.0 * x) / 96.0;
    let third = (3.0 * x.powi(7) + 19.0 * x.powi(5) + 17.0 * x.powi(3) - 15.0 * x) / 384.0;
    match freedom {
        0 | 1 => 12.706,
        2 => 4.303,
        _ => x + first / n + second / n.powi(2) + third / n.powi(3),
    }
}

/// Where a law is not stable.
fn unstable(law: &Isochoric) -> Vec<StabilityLimit> {
    let found = stability::unstable(law).into_iter();
    found
        .map(|one| StabilityLimit {
            way: one.way,
            stretch: one.stretch,
        })
        .collect()
}
