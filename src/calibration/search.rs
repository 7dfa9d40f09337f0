//! The constants of a law from measured values of any kind, one solve at a time: whoever solves says
//! what the law gives for the constants of each trial, and by how much that changes with them.
//!
//! ```text
//! (J^T J + d diag(J^T J)) s = -J^T r,   r_i = w_i (value_i - measured_i)
//! ```
//!
//! d falls tenfold with each trial that lowers the sum and rises tenfold with each that does not. Cost: one
//! solve of the caller a trial, some 5 to 10 in all.

use super::constants::{Constant, Size, constants, values, with_values};
use super::curve::{TestKind, nominal_stress};
use super::least_squares::{Minimum, Unknown, step};
use super::{Calibrated, CalibrationError, FLOOR, Weighting, fitted, unstable};
use crate::scene::RubberModel;
use crate::scene::validate::isochoric;

/// Most trials; chosen, fits take 5 to 10.
const TRIALS: u32 = 40;
/// Change of all constants, over their sizes, at which they are found, without unit: below what measurements tell; chosen.
const FOUND: f64 = 1e-7;
/// Damping at first, and above which there is no lower sum, without unit; chosen.
const DAMPING: [f64; 2] = [1e-3, 1e6];
/// Sum a value below which it falls by rounding alone, the square of 1e-7, without unit; chosen.
const ROUNDING: f64 = 1e-14;
/// Stretch less one by which the shear modulus of a law is taken, to 1e-6 of itself; chosen.
const SMALL: f64 = 1e-6;

/// A value that was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// Number of its curve: small values count by the largest of their curve.
    pub curve: usize,
    /// In the caller's unit.
    pub value: f64,
}

/// What a law gives for a trial.
#[derive(Clone, Debug, PartialEq)]
pub struct Modelled {
    /// In the order of what was measured.
    pub values: Vec<f64>,
    /// Derivatives by each constant `[constants][values]`.
    pub slopes: Vec<Vec<f64>>,
}

/// What is to be done after a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// Another trial is to be solved.
    Again,
    /// The constants are found.
    Found,
    /// No trial gives less, or too many were made.
    Stuck,
}

/// The best trial so far.
#[derive(Clone, Debug)]
struct Kept {
    at: Vec<f64>,
    /// Weighted.
    residuals: Vec<f64>,
    /// Weighted `[constants][values]`.
    slopes: Vec<Vec<f64>>,
    sum: f64,
}

/// A search for the constants of a law.
#[derive(Clone, Debug)]
pub struct Search {
    model: RubberModel,
    named: Vec<Constant>,
    unknowns: Vec<Unknown>,
    measured: Vec<f64>,
    weights: Vec<f64>,
    kept: Option<Kept>,
    trial: Vec<f64>,
    damping: f64,
    trials: u32,
}

impl Search {
    /// From the constants of `model`.
    ///
    /// # Errors
    /// [`CalibrationError`] of foams, of a law that is none, and of fewer values than constants.
    pub fn new(
        model: &RubberModel,
        measured: &[Measured],
        weighting: Weighting,
    ) -> Result<Self, CalibrationError> {
        let law = model.name();
        let compressible = CalibrationError::Compressible { law };
        let start = values(model);
        if start.is_empty() {
            return Err(compressible);
        }
        let stress = nominal_stress(&isochoric(model)?, TestKind::Uniaxial, 1.0 + SMALL);
        let size = Size {
            modulus: stress / (3.0 * SMALL),
            first: 0.0,
        };
        let named = constants(model, &start, size).ok_or(compressible)?;
        if measured.len() < named.len() {
            return Err(CalibrationError::TooFew {
                points: measured.len(),
                constants: named.len(),
            });
        }
        Ok(Self {
            unknowns: named.iter().map(|one| one.unknown).collect(),
            measured: measured.iter().map(|one| one.value).collect(),
            weights: weights(measured, weighting),
            model: model.clone(),
            named,
            kept: None,
            trial: start,
            damping: DAMPING[0],
            trials: 0,
        })
    }

    /// Keys of the constants, of lists with the place in brackets.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.named.iter().map(|one| one.name.as_str())
    }

    /// The law that is to be solved with next.
    pub fn trial(&self) -> RubberModel {
        with_values(&self.model, &self.trial)
    }

    /// Trials that were solved.
    pub fn trials(&self) -> u32 {
        self.trials
    }

    /// Takes what the trial gave; none where there was no solution.
    pub fn take(&mut self, modelled: Option<Modelled>) -> Progress {
        self.trials += 1;
        let taken = modelled.and_then(|modelled| self.weighted(modelled));
        let before = self.kept.as_ref().map_or(f64::INFINITY, |kept| kept.sum);
        let is_found = match taken {
            Some(taken) if taken.sum <= before => {
                let is_found = self.is_found(&taken);
                self.kept = Some(taken);
                self.damping = (0.1 * self.damping).max(f64::EPSILON);
                is_found
            }
            _ => {
                self.damping *= 10.0;
                false
            }
        };
        if is_found {
            return Progress::Found;
        }
        let next = self.next();
        match next.filter(|_| self.trials < TRIALS && self.damping <= DAMPING[1]) {
            Some(next) => {
                self.trial = next;
                Progress::Again
            }
            None => Progress::Stuck,
        }
    }

    /// The law with the best constants, their intervals, and where it is not stable.
    ///
    /// # Errors
    /// [`CalibrationError::NoFit`] where no trial had a solution.
    pub fn finish(self) -> Result<Calibrated, CalibrationError> {
        let law = self.model.name();
        let kept = self.kept.ok_or(CalibrationError::NoFit { law })?;
        let model = with_values(&self.model, &kept.at);
        let points = self.measured.len();
        let minimum = Minimum {
            at: kept.at,
            sum: kept.sum,
            slopes: kept.slopes,
        };
        let errors = kept.residuals.iter();
        Ok(Calibrated {
            constants: fitted(&self.named, &minimum, points),
            misfit: (minimum.sum / points.max(1) as f64).sqrt(),
            largest: errors.fold(0.0, |most, error| error.abs().max(most)),
            unstable: unstable(&isochoric(&model)?),
            model,
        })
    }

    fn weighted(&self, modelled: Modelled) -> Option<Kept> {
        let count = self.measured.len();
        let is_whole = |all: &[f64]| all.len() == count && all.iter().all(|x| x.is_finite());
        let columns = &modelled.slopes;
        let is_usable = is_whole(&modelled.values)
            && columns.len() == self.named.len()
            && columns.iter().all(|column| is_whole(column));
        if !is_usable {
            return None;
        }
        let weighted = |all: &[f64]| -> Vec<f64> {
            let pairs = all.iter().zip(&self.weights);
            pairs.map(|(value, weight)| value * weight).collect()
        };
        let errors = modelled.values.iter().zip(&self.measured);
        let errors: Vec<f64> = errors.map(|(value, measured)| value - measured).collect();
        let residuals = weighted(&errors);
        Some(Kept {
            at: self.trial.clone(),
            sum: residuals.iter().map(|r| r * r).sum(),
            residuals,
            slopes: columns.iter().map(|column| weighted(column)).collect(),
        })
    }

    /// Whether a lower trial is the last one.
    fn is_found(&self, taken: &Kept) -> bool {
        let Some(kept) = &self.kept else {
            return taken.sum == 0.0;
        };
        let moved = kept.at.iter().zip(&taken.at).zip(&self.unknowns);
        let changes = moved.map(|((x, y), one)| (y - x).abs() / y.abs().max(one.size));
        let is_still = changes.fold(0.0, f64::max) < FOUND;
        is_still || taken.sum <= ROUNDING * self.measured.len() as f64
    }

    /// The next trial from the best one.
    fn next(&self) -> Option<Vec<f64>> {
        let kept = self.kept.as_ref()?;
        let at = (&self.unknowns[..], &kept.at[..]);
        let step = step((&kept.slopes, &kept.residuals), at, self.damping)?;
        let moved = kept.at.iter().zip(step).zip(&self.unknowns);
        let moved = moved.map(|((x, s), one)| (x + s).clamp(one.bounds[0], one.bounds[1]));
        Some(moved.collect())
    }
}

/// What each error is multiplied by.
fn weights(measured: &[Measured], weighting: Weighting) -> Vec<f64> {
    let largest = |curve: usize| {
        let own = measured.iter().filter(|one| one.curve == curve);
        own.fold(0.0, |most: f64, one| most.max(one.value.abs()))
    };
    let weight = |one: &Measured| {
        let size = one.value.abs().max(FLOOR * largest(one.curve));
        if size > 0.0 { size.recip() } else { 1.0 }
    };
    match weighting {
        Weighting::Relative => measured.iter().map(weight).collect(),
        Weighting::Absolute => vec![1.0; measured.len()],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STRETCHES: [f64; 6] = [0.7, 0.9, 1.2, 1.5, 2.0, 2.5];

    /// Stresses of a law at the stretches, with central differences by its constants.
    fn modelled(model: &RubberModel) -> Option<Modelled> {
        let at = |constants: &[f64]| -> Option<Vec<f64>> {
            let law = isochoric(&with_values(model, constants)).ok()?;
            let all = STRETCHES.iter();
            Some(
                all.map(|l| nominal_stress(&law, TestKind::Uniaxial, *l))
                    .collect(),
            )
        };
        let own = values(model);
        let slope = |place: usize| {
            let [after, before] = [1e-6, -1e-6].map(|by| {
                let mut moved = own.clone();
                moved[place] += by;
                at(&moved)
            });
            let pairs = after?.into_iter().zip(before?);
            Some(pairs.map(|(a, b)| (a - b) / 2e-6).collect())
        };
        Some(Modelled {
            values: at(&own)?,
            slopes: (0..own.len()).map(slope).collect::<Option<_>>()?,
        })
    }

    fn measured(model: &RubberModel) -> Vec<Measured> {
        let values = modelled(model).expect("a law").values.into_iter();
        values.map(|value| Measured { curve: 0, value }).collect()
    }

    #[test]
    fn constants_come_back_in_few_trials_from_afar() {
        let exact = RubberModel::Yeoh {
            c10: 0.4,
            c20: -0.02,
            c30: 0.001,
        };
        let start = RubberModel::Yeoh {
            c10: 2.0,
            c20: 0.0,
            c30: 0.0,
        };
        let mut search =
            Search::new(&start, &measured(&exact), Weighting::Relative).expect("a search");
        assert_eq!(search.names().collect::<Vec<_>>(), ["c10", "c20", "c30"]);
        while search.take(modelled(&search.trial())) == Progress::Again {}
        assert!(search.trials() <= 10, "{}", search.trials());
        let found = search.finish().expect("a fit").constants;
        for (one, value) in found.iter().zip([0.4, -0.02, 0.001]) {
            assert!((one.value - value).abs() < 1e-7 * value.abs(), "{one:?}");
        }
    }

    #[test]
    fn trials_without_a_solution_are_shortened() {
        let exact = RubberModel::NeoHookean { shear_modulus: 0.5 };
        let start = RubberModel::NeoHookean { shear_modulus: 3.0 };
        let mut search =
            Search::new(&start, &measured(&exact), Weighting::Absolute).expect("a search");
        // Nothing is solved below a modulus of two thirds of the last one.
        let mut last = 3.0;
        loop {
            let RubberModel::NeoHookean { shear_modulus } = search.trial() else {
                unreachable!("the law of the start");
            };
            let told = (shear_modulus > 0.66 * last).then(|| modelled(&search.trial()));
            if told.is_some() {
                last = shear_modulus;
            }
            if search.take(told.flatten()) != Progress::Again {
                break;
            }
        }
        let found = &search.finish().expect("a fit").constants[0];
        assert!((found.value - 0.5).abs() < 1e-6, "{found:?}");
    }

    #[test]
    fn a_search_without_any_solution_and_one_of_too_few_values_are_told() {
        let law = RubberModel::MooneyRivlin { c10: 1.0, c01: 0.0 };
        let few = [Measured {
            curve: 0,
            value: 1.0,
        }];
        let error = Search::new(&law, &few, Weighting::Relative).expect_err("too few");
        assert_eq!(
            error,
            CalibrationError::TooFew {
                points: 1,
                constants: 2
            }
        );
        let mut search = Search::new(&law, &[few[0]; 3], Weighting::Relative).expect("a search");
        assert_eq!(search.take(None), Progress::Stuck);
        assert!(matches!(
            search.finish(),
            Err(CalibrationError::NoFit { .. })
        ));
    }
}
