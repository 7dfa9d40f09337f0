//! Coulomb friction by iteration on its threshold, as the seed has it:
//!
//! ```text
//! r^0 = mu n^0,   (u, n, t)^k+1: contact with |t| <= r^k given,   r^k+1 = mu n^k+1
//! ```
//!
//! Each pass is a problem of given thresholds (Tresca's), which has an energy and one solution;
//! the passes are a fixed point that contracts where friction is weak (A. Fortin and M. El
//! Maliki, "There is also another iteration on the threshold"). What is compared is that one
//! level solves pressures and tractions together. Cost: a problem of contact a pass.

use signorini::inequality::dense_cone::cones;
use signorini::inequality::{
    InequalitySolver, OneLevel, QpIterate, QpOutcome, QpProblem, QpRun, QpStatus,
};
use signorini::krylov::Outcome;
use signorini::linalg::vector::largest;
use signorini::saddle::{AdmissibleSet, Cones, MultiplierBlock, ProductSet, SetPart};

/// Passes on one problem at most.
const MOST_PASSES: u32 = 100;

/// The method on a problem.
pub(crate) struct ThresholdIteration<'a> {
    /// The quadratic program; without friction one pass solves it.
    pub(crate) problem: QpProblem<'a>,
}

impl InequalitySolver for ThresholdIteration<'_> {
    fn solve(&self, iterate: &mut QpIterate, run: &mut QpRun<'_, '_>) -> QpOutcome {
        let set = self.problem.blocks.last().map(|block| block.set);
        match set.and_then(|set| cones(&set).zip(Some(set))) {
            None => OneLevel::new(self.problem).solve(iterate, run),
            Some(((cones, first), set)) => self.iterate(iterate, run, (cones, first, set)),
        }
    }
}

impl ThresholdIteration<'_> {
    /// Passes until the thresholds stay.
    fn iterate(
        &self,
        iterate: &mut QpIterate,
        run: &mut QpRun<'_, '_>,
        (cones, first, set): (Cones<'_>, usize, ProductSet<'_>),
    ) -> QpOutcome {
        let mut outcome = QpOutcome::new(QpStatus::Krylov(Outcome::IterationLimit));
        let mut radii = thresholds(cones, first, iterate);
        for _ in 0..MOST_PASSES {
            let pass = self.pass(iterate, run, (cones, &radii, set));
            outcome.add(&pass);
            outcome.threshold_passes += 1;
            if pass.status != QpStatus::Solved {
                outcome.status = pass.status;
                return outcome;
            }
            let next = thresholds(cones, first, iterate);
            let change = next.iter().zip(&radii).map(|(a, b)| (a - b).abs());
            let change = change.fold(0.0, f64::max);
            radii = next;
            if change <= run.targets.level * largest(&radii) {
                outcome.status = QpStatus::Solved;
                return outcome;
            }
        }
        outcome
    }

    /// Contact with given thresholds.
    fn pass(
        &self,
        iterate: &mut QpIterate,
        run: &mut QpRun<'_, '_>,
        (cones, radii, set): (Cones<'_>, &[f64], ProductSet<'_>),
    ) -> QpOutcome {
        let parts: Vec<SetPart<'_>> = (set.parts().iter())
            .flat_map(|part| {
                if matches!(part.set, AdmissibleSet::Cones(_)) {
                    cones.with_given(radii).to_vec()
                } else {
                    vec![*part]
                }
            })
            .collect();
        let mut blocks: Vec<MultiplierBlock<'_>> = self.problem.blocks.to_vec();
        if let Some(contact) = blocks.last_mut() {
            contact.set = ProductSet::Parts(&parts);
        }
        let problem = QpProblem {
            blocks: &blocks,
            ..self.problem
        };
        OneLevel::new(problem).solve(iterate, run)
    }
}

/// The largest tractions under the present pressures `[points]`.
fn thresholds(cones: Cones<'_>, first: usize, iterate: &QpIterate) -> Vec<f64> {
    let contact = iterate.blocks.last();
    let multipliers = contact.map_or(&[][..], |block| &block.multiplier);
    cones.radii(&multipliers[first..])
}
