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
//! For sets that lower bounds make; written above for those of contact. Norms and
//! projected steps in the lumped mass W, scaled so that W >= K about: the rate then
//! depends on the condition of W^-1 K alone. Z. Dostal and J. Schoeberl, Comput.
//! Optim. Appl. 30, 2005. With a dense metric the conjugate gradients are
//! preconditioned by its part on the free set (Kruzik and Horak 2025). One product
//! a step, two where it projects. Holds no dense matrix without a metric.

use super::blocks::ContactBlock;
use super::condensed::Condensed;
use super::{BlockIterate, InequalitySolver, QpIterate, QpOutcome, QpProblem, QpRun, QpStatus};
use crate::krylov::Outcome;
use std::sync::Arc;

use crate::linalg::vector::{dot, scale_and_add};
use crate::linalg::{PartFactor, Workspace};

/// Products per problem; a tenth of it is usual.
const MOST_PRODUCTS: u32 = 600;

/// The method on a problem.
pub struct Mprgp<'a> {
    /// The quadratic program; its contact set must be one of lower bounds.
    pub problem: QpProblem<'a>,
}

impl InequalitySolver for Mprgp<'_> {
    fn solve(&self, iterate: &mut QpIterate, run: &mut QpRun<'_, '_>) -> QpOutcome {
        let mut memory = Memory::default();
        Condensed::solve(
            &self.problem,
            run,
            MOST_PRODUCTS,
            iterate,
            |iterate, condensed| step(&mut memory, iterate, condensed),
        )
    }
}

/// What a step leaves to the next.
#[derive(Default)]
struct Memory {
    /// Inverse of the metric on the free set, kept as long as the set stays.
    preconditioner: InFace,
    /// The next direction of the multiplier; none after a projection, where conjugacy
    /// starts anew.
    conjugate: Option<Vec<f64>>,
}

/// The block of contact and the least admissible multipliers.
struct Bounded<'a> {
    /// The contact block with its metric and weights.
    block: ContactBlock<'a>,
    /// Least admissible value of each multiplier `[multipliers]`.
    least: Vec<f64>,
}

/// The gradient's parts.
struct Split {
    /// Part of the gradient at multipliers that are off their bounds `[multipliers]`;
    /// zero elsewhere.
    free: Vec<f64>,
    /// Part of the gradient that would push multipliers off their bounds
    /// `[multipliers]`; zero elsewhere.
    chopped: Vec<f64>,
    /// The free gradient that a projected unit step can use.
    reduced: Vec<f64>,
}

impl Split {
    /// Splits the gradient at an iterate by which multipliers are at their bounds.
    /// Cost: one pass.
    fn new(contact: &BlockIterate, bounded: &Bounded<'_>) -> Self {
        let select = |wanted: bool, value: f64| if wanted { value } else { 0.0 };
        let least = &bounded.least;
        let pairs = || contact.residual.iter().zip(&contact.multiplier).zip(least);
        let free: Vec<f64> = pairs()
            .map(|((g, l), least)| select(l > least, *g))
            .collect();
        let room = contact.multiplier.iter().zip(least);
        Self {
            reduced: free
                .iter()
                .zip(room.zip(bounded.block.weights))
                .map(|(f, ((l, least), w))| f.min((l - least) * w))
                .collect(),
            chopped: pairs()
                .map(|((g, l), least)| select(l <= least, g.min(0.0)))
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

/// One step.
fn step(
    memory: &mut Memory,
    iterate: &mut QpIterate,
    condensed: &mut Condensed<'_, '_, '_>,
) -> Result<(), QpStatus> {
    let (block, place) = (condensed.contact(), condensed.place());
    let least = block.set.lower_bounds().ok_or(QpStatus::Unsupported)?;
    let bounded = Bounded { block, least };
    let split = Split::new(&iterate.blocks[place], &bounded);
    let known = memory.conjugate.take();
    if !split.is_proportional(block.weights) {
        let pairs = split.chopped.iter().zip(block.weights);
        let direction = pairs.map(|(c, w)| -c / w).collect();
        return descend(iterate, condensed, direction).map(|_| ());
    }
    let preconditioner = &mut memory.preconditioner;
    let direction = match known {
        Some(direction) => direction,
        None => preconditioner.apply(&iterate.blocks[place], &bounded, &split.free)?,
    };
    match descend(iterate, condensed, direction)? {
        Descent::Minimum { direction, opening } => {
            let contact = &iterate.blocks[place];
            let free = Split::new(contact, &bounded).free;
            let mut next = preconditioner.apply(contact, &bounded, &free)?;
            let beta = -dot(&next, &opening) / dot(&direction, &opening);
            let scaled = std::mem::replace(&mut next, direction);
            scale_and_add(&mut next, beta, &scaled);
            memory.conjugate = Some(next);
            Ok(())
        }
        Descent::Edge => expand(iterate, condensed, &bounded),
    }
}

/// How a step along a direction ended.
enum Descent {
    /// The step reached the minimum of the energy along the direction.
    Minimum {
        direction: Vec<f64>,
        opening: Vec<f64>,
    },
    /// The step ended early, where a multiplier met its bound.
    Edge,
}

/// Minimises along `direction` within the set.
fn descend(
    iterate: &mut QpIterate,
    condensed: &mut Condensed<'_, '_, '_>,
    direction: Vec<f64>,
) -> Result<Descent, QpStatus> {
    let (set, place) = (condensed.contact().set, condensed.place());
    let slope = dot(&iterate.blocks[place].residual, &direction);
    let response = condensed.product(direction)?;
    let curvature = dot(&response.direction, &response.opening);
    if slope >= 0.0 || curvature.is_nan() || curvature <= 0.0 {
        return Err(QpStatus::Krylov(Outcome::Stagnation));
    }
    let length = -slope / curvature;
    let edge = set.longest_step(&iterate.blocks[place].multiplier, &response.direction);
    let (direction, opening) = (response.direction.clone(), response.opening.clone());
    if length < edge {
        condensed.advance(iterate, response, length);
        return Ok(Descent::Minimum { direction, opening });
    }
    condensed.advance(iterate, response, edge);
    set.project(&mut iterate.blocks[place].multiplier);
    Ok(Descent::Edge)
}

/// The projected step along the free gradient.
fn expand(
    iterate: &mut QpIterate,
    condensed: &mut Condensed<'_, '_, '_>,
    bounded: &Bounded<'_>,
) -> Result<(), QpStatus> {
    let place = condensed.place();
    let contact = &iterate.blocks[place];
    let split = Split::new(contact, bounded);
    let pairs = split.free.iter().zip(bounded.block.weights);
    let room = contact.multiplier.iter().zip(&bounded.least);
    let change: Vec<f64> = pairs
        .zip(room)
        .map(|((f, w), (l, least))| (-f / w).max(least - l))
        .collect();
    condensed.shift(iterate, &change)?;
    let set = bounded.block.set;
    set.project(&mut iterate.blocks[place].multiplier);
    Ok(())
}

/// The metric on the free set, factorised anew when the set changes.
#[derive(Default)]
struct InFace {
    /// Indices of the free multipliers that the factor stands for, ascending.
    selected: Vec<usize>,
    /// Factor of the metric's principal part on them; none before the first set and for
    /// an empty one.
    factor: Option<Arc<dyn PartFactor>>,
    /// Scratch of its solutions.
    work: Workspace,
}

impl InFace {
    /// Minus the preconditioned free gradient.
    fn apply(
        &mut self,
        contact: &BlockIterate,
        bounded: &Bounded<'_>,
        free: &[f64],
    ) -> Result<Vec<f64>, QpStatus> {
        let (matrix, weights) = (bounded.block.matrix, bounded.block.weights);
        if matrix.size() == 0 {
            let pairs = free.iter().zip(weights);
            return Ok(pairs.map(|(f, w)| -f / w).collect());
        }
        let is_free = |&i: &usize| contact.multiplier[i] > bounded.least[i];
        let selected: Vec<usize> = (0..free.len()).filter(is_free).collect();
        if self.factor.is_none() || selected != self.selected {
            self.factor = matrix.factor_of_part(&selected).ok();
            self.selected = selected;
        }
        let factor = self.factor.as_ref().ok_or(QpStatus::IndefiniteMetric)?;
        let mut small: Vec<f64> = self.selected.iter().map(|&i| -free[i]).collect();
        factor.solve_part(&mut small, &mut self.work);
        let mut direction = vec![0.0; free.len()];
        for (&index, value) in self.selected.iter().zip(small) {
            direction[index] = value;
        }
        Ok(direction)
    }
}
