//! Modified proportioning with reduced gradient projections:
//!
//! ```text
//! free gradient      f_i = gap_i  where l_i > 0
//! chopped gradient   c_i = min(gap_i, 0)  where l_i = 0
//! |c| small against f:  conjugate gradients on the free set, or, where they would
//!                       leave l >= 0, to its edge and a projected step W^-1 f
//! else:                 steepest descent along c releases the set
//! ```
//!
//! Norms and projected steps in the lumped mass W, scaled so that W >= K about: the
//! rate then depends on the condition of W^-1 K alone. Z. Dostal and J. Schoeberl,
//! Comput. Optim. Appl. 30, 2005. With a dense metric the conjugate gradients are
//! preconditioned by its part on the free set (Kruzik and Horak 2025). One product
//! a step, two where it projects. Holds no dense matrix without a metric.

use super::condensed::Condensed;
use super::nested::longest;
use super::{InequalitySolver, QpIterate, QpOutcome, QpProblem, QpRun, QpStatus};
use crate::krylov::Outcome;
use crate::linalg::DenseCholesky;
use crate::linalg::vector::{dot, scale_and_add};

/// Products per problem; a tenth of it is usual.
const MOST_PRODUCTS: u32 = 600;

/// The method on a problem.
pub struct Mprgp<'a> {
    pub(super) problem: QpProblem<'a>,
}

impl InequalitySolver for Mprgp<'_> {
    fn solve(&self, iterate: &mut QpIterate, run: &mut QpRun<'_, '_>) -> QpOutcome {
        let mut preconditioner = InFace {
            problem: &self.problem,
            selected: Vec::new(),
            factor: None,
        };
        let mut conjugate = None;
        Condensed::solve(
            &self.problem,
            run,
            MOST_PRODUCTS,
            iterate,
            |iterate, condensed| step(&mut preconditioner, &mut conjugate, iterate, condensed),
        )
    }
}

/// The gradient's parts.
struct Split {
    free: Vec<f64>,
    chopped: Vec<f64>,
    /// The free gradient that a projected unit step can use.
    reduced: Vec<f64>,
}

impl Split {
    fn new(iterate: &QpIterate, weights: &[f64]) -> Self {
        let select = |wanted: bool, value: f64| if wanted { value } else { 0.0 };
        let pairs = || iterate.gap.iter().zip(&iterate.multiplier);
        let free: Vec<f64> = pairs().map(|(g, l)| select(*l > 0.0, *g)).collect();
        let room = iterate.multiplier.iter().zip(weights);
        Self {
            reduced: free
                .iter()
                .zip(room)
                .map(|(f, (l, w))| f.min(l * w))
                .collect(),
            chopped: pairs()
                .map(|(g, l)| select(*l <= 0.0, g.min(0.0)))
                .collect(),
            free,
        }
    }

    /// Whether the free set is worth further steps.
    fn is_proportional(&self, weights: &[f64]) -> bool {
        let product = |a: &[f64], b: &[f64]| -> f64 {
            let pairs = a.iter().zip(b).zip(weights);
            pairs.map(|((a, b), w)| a * b / w).sum()
        };
        product(&self.chopped, &self.chopped) <= product(&self.reduced, &self.free)
    }
}

/// One step; `conjugate` is the direction that the last one leaves to the next.
fn step(
    preconditioner: &mut InFace<'_, '_>,
    conjugate: &mut Option<Vec<f64>>,
    iterate: &mut QpIterate,
    condensed: &mut Condensed<'_, '_, '_>,
) -> Result<(), QpStatus> {
    let weights = preconditioner.problem.weights;
    let split = Split::new(iterate, weights);
    let known = conjugate.take();
    if !split.is_proportional(weights) {
        let pairs = split.chopped.iter().zip(weights);
        let direction = pairs.map(|(c, w)| -c / w).collect();
        return descend(iterate, condensed, direction).map(|_| ());
    }
    let direction = match known {
        Some(direction) => direction,
        None => preconditioner.apply(iterate, &split.free)?,
    };
    match descend(iterate, condensed, direction)? {
        Descent::Minimum { direction, opening } => {
            let free = Split::new(iterate, weights).free;
            let mut next = preconditioner.apply(iterate, &free)?;
            let beta = -dot(&next, &opening) / dot(&direction, &opening);
            let scaled = std::mem::replace(&mut next, direction);
            scale_and_add(&mut next, beta, &scaled);
            *conjugate = Some(next);
            Ok(())
        }
        Descent::Edge => expand(iterate, condensed, weights),
    }
}

/// How a step along a direction ended.
enum Descent {
    /// At the minimum of the energy along it.
    Minimum {
        direction: Vec<f64>,
        opening: Vec<f64>,
    },
    /// Where a multiplier became zero.
    Edge,
}

/// Minimises along `direction` within l >= 0.
fn descend(
    iterate: &mut QpIterate,
    condensed: &mut Condensed<'_, '_, '_>,
    direction: Vec<f64>,
) -> Result<Descent, QpStatus> {
    let slope = dot(&iterate.gap, &direction);
    let response = condensed.product(direction)?;
    let curvature = dot(&response.direction, &response.opening);
    if slope >= 0.0 || curvature.is_nan() || curvature <= 0.0 {
        return Err(QpStatus::Krylov(Outcome::Stagnation));
    }
    let length = -slope / curvature;
    let edge = longest(iterate, &response.direction);
    let (direction, opening) = (response.direction.clone(), response.opening.clone());
    if length < edge {
        condensed.advance(iterate, response, length);
        return Ok(Descent::Minimum { direction, opening });
    }
    condensed.advance(iterate, response, edge);
    iterate.multiplier.iter_mut().for_each(|l| *l = l.max(0.0));
    Ok(Descent::Edge)
}

/// The projected step along the free gradient.
fn expand(
    iterate: &mut QpIterate,
    condensed: &mut Condensed<'_, '_, '_>,
    weights: &[f64],
) -> Result<(), QpStatus> {
    let split = Split::new(iterate, weights);
    let pairs = split.free.iter().zip(weights).zip(&iterate.multiplier);
    let change: Vec<f64> = pairs.map(|((f, w), l)| (-f / w).max(-l)).collect();
    condensed.shift(iterate, &change)?;
    iterate.multiplier.iter_mut().for_each(|l| *l = l.max(0.0));
    Ok(())
}

/// The metric on the free set, factorised anew when the set changes.
struct InFace<'c, 'a> {
    problem: &'c QpProblem<'a>,
    selected: Vec<usize>,
    factor: Option<DenseCholesky>,
}

impl InFace<'_, '_> {
    /// Minus the preconditioned free gradient.
    fn apply(&mut self, iterate: &QpIterate, free: &[f64]) -> Result<Vec<f64>, QpStatus> {
        if self.problem.metric.rows() == 0 {
            let pairs = free.iter().zip(self.problem.weights);
            return Ok(pairs.map(|(f, w)| -f / w).collect());
        }
        let multiplier = &iterate.multiplier;
        let selected: Vec<usize> = (0..free.len()).filter(|&i| multiplier[i] > 0.0).collect();
        if self.factor.is_none() || selected != self.selected {
            let part = self.problem.metric.principal(&selected);
            self.factor = DenseCholesky::new(&part).ok();
            self.selected = selected;
        }
        let factor = self.factor.as_ref().ok_or(QpStatus::IndefiniteMetric)?;
        let mut small: Vec<f64> = self.selected.iter().map(|&i| -free[i]).collect();
        factor.solve(&mut small);
        let mut direction = vec![0.0; free.len()];
        for (&index, value) in self.selected.iter().zip(small) {
            direction[index] = value;
        }
        Ok(direction)
    }
}
