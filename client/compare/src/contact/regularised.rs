//! Coulomb friction by a regularised tangential term, as the seed has it (its equation 17):
//!
//! ```text
//! (A + D^T M B) du + D_n^T dn = f - D^T b,   t = b + M (s^k - s),   |t| <= mu n^k,
//! ```
//!
//! s the slip, B its constraints, D the forces of tractions. A point that sticks is held by a
//! spring M = I / c; one that slips has the traction b on the edge, and M = r / (c (|y| - r))
//! across it, the derivative of the projection of y = t^k - s^k / c onto the disc of radius r. The
//! seed's form is the first pass from t = 0: what sticks creeps by c t. Each further pass moves
//! the springs' rest by what crept and the thresholds by what the pressures became (method of
//! multipliers, iteration on the threshold), so that the method ends where all others do and is
//! compared at equal error. c = eps K_ii, K_ii the compliance at the point. Cost: a problem of
//! contact without friction a pass, whose preconditioner does not know the springs.

use signorini::inequality::dense_cone::cones;
use signorini::inequality::{
    BlockIterate, InequalitySolver, OneLevel, QpIterate, QpOutcome, QpProblem, QpRun, QpStatus,
};
use signorini::krylov::Outcome;
use signorini::krylov::gcr::Directions;
use signorini::linalg::vector::{add_scaled, norm};
use signorini::linalg::{LinearOperator, SymmetricMatrix, Workspace};
use signorini::saddle::{
    AdmissibleSet, Cones, Metric, MultiplierBlock, ProductSet, SetPart, Status,
};

/// eps: compliance of the springs over that of the body at a point. Below one sets of stick and
/// slip return in space (hertz-sphere with friction: 0.3 never ends), above the rest creeps away
/// slowly.
const EPSILON: f64 = 2.0;
/// Passes on one problem at most.
const MOST_PASSES: u32 = 200;
/// Directions kept on one pass: every spring is an eigenvalue far from the others.
const KEPT: usize = 100;

/// The method on a problem.
pub(crate) struct RegularisedFriction<'a> {
    /// The quadratic program; without friction one level solves it.
    pub(crate) problem: QpProblem<'a>,
}

impl InequalitySolver for RegularisedFriction<'_> {
    fn solve(&self, iterate: &mut QpIterate, run: &mut QpRun<'_, '_>) -> QpOutcome {
        match Points::of(&self.problem) {
            None => OneLevel::new(self.problem).solve(iterate, run),
            Some(points) => self.iterate(&points, iterate, run),
        }
    }
}

impl RegularisedFriction<'_> {
    /// Passes until tractions and slips agree with the law.
    fn iterate(
        &self,
        points: &Points<'_>,
        iterate: &mut QpIterate,
        run: &mut QpRun<'_, '_>,
    ) -> QpOutcome {
        let mut outcome = QpOutcome::new(QpStatus::Krylov(Outcome::IterationLimit));
        for _ in 0..MOST_PASSES {
            let pass = self.pass(points, iterate, run);
            outcome.add(&pass);
            outcome.threshold_passes += 1;
            if pass.status != QpStatus::Solved {
                outcome.status = pass.status;
                return outcome;
            }
            let contact = contact_of(iterate);
            if points.misfit(contact) <= run.targets.level * run.scales.gap {
                outcome.status = QpStatus::Solved;
                break;
            }
        }
        if let Some(contact) = iterate.blocks.last_mut() {
            points.set_status(contact);
        }
        outcome
    }

    /// Contact without friction on the body with its springs.
    fn pass(
        &self,
        points: &Points<'_>,
        iterate: &mut QpIterate,
        run: &mut QpRun<'_, '_>,
    ) -> QpOutcome {
        let springs = points.springs(contact_of(iterate));
        let before = points.release(&springs, iterate, run.work);
        let stiffened = Stiffened {
            body: self.problem.stiffness,
            contact: points.block,
            springs: &springs,
        };
        let radii = vec![0.0; springs.len()];
        let parts = points.without_friction(&radii);
        let mut blocks: Vec<MultiplierBlock<'_>> = self.problem.blocks.to_vec();
        // A joint product has the body without springs in it.
        blocks.iter_mut().for_each(|block| block.joint = None);
        if let Some(contact) = blocks.last_mut() {
            contact.set = ProductSet::Parts(&parts);
        }
        let problem = QpProblem {
            stiffness: &stiffened,
            blocks: &blocks,
            ..self.problem
        };
        let mut directions = Directions::keeping(KEPT);
        let mut on_springs = QpRun {
            targets: run.targets,
            scales: run.scales,
            iterations: run.iterations,
            directions: &mut directions,
            progress: run.progress,
            work: run.work,
        };
        let outcome = OneLevel::new(problem).solve(iterate, &mut on_springs);
        directions.clear(run.work);
        hold(&springs, &before, iterate);
        outcome
    }
}

/// The iterate of contact, which is last.
fn contact_of(iterate: &QpIterate) -> &BlockIterate {
    let last = iterate.blocks.len() - 1;
    &iterate.blocks[last]
}

/// The points of friction of a problem.
struct Points<'a> {
    /// The block of contact.
    block: MultiplierBlock<'a>,
    /// The set of that block.
    set: ProductSet<'a>,
    /// Pressures and tractions.
    cones: Cones<'a>,
    /// The first multiplier of `cones`.
    first: usize,
    /// The compliance at each multiplier.
    metric: &'a dyn SymmetricMatrix,
}

/// A spring on the slip of one point.
struct Spring {
    /// First multiplier of the traction.
    first: usize,
    /// Numbers of the traction: one or two.
    width: usize,
    /// b: traction without further slip.
    base: [f64; 2],
    /// M: growth of the traction with what the slip loses.
    stiffness: [[f64; 2]; 2],
}

impl<'a> Points<'a> {
    /// Those of `problem`; none without friction.
    fn of(problem: &QpProblem<'a>) -> Option<Self> {
        let block = *problem.blocks.last()?;
        let (cones, first) = cones(&block.set)?;
        match block.metric {
            Metric::Dense { matrix, .. } => Some(Self {
                block,
                set: block.set,
                cones,
                first,
                metric: matrix,
            }),
            Metric::Inverse(_) => None,
        }
    }

    /// Places of the tractions, with the radius of each disc.
    fn tractions(&self, contact: &BlockIterate) -> Vec<(usize, usize, f64)> {
        let width = self.cones.components.count();
        let points = self.cones.points();
        let place = |(partner, bound, place): (usize, signorini::saddle::FrictionBound, usize)| {
            let pressure = contact.multiplier[self.first + partner];
            (self.first + place, width, bound.radius(pressure))
        };
        points.map(place).collect()
    }

    /// The springs that the law asks for at the iterate.
    fn springs(&self, contact: &BlockIterate) -> Vec<Spring> {
        let points = self.tractions(contact).into_iter();
        points
            .map(|(first, width, radius)| {
                let softness = self.softness(first);
                spring((first, width), radius, softness, contact)
            })
            .collect()
    }

    /// c of the point at that place.
    fn softness(&self, first: usize) -> f64 {
        EPSILON * self.metric.entry(first, first)
    }

    /// Takes the present tractions off the body and puts those of the springs at rest on;
    /// returns the slips they start from `[multipliers]`.
    fn release(
        &self,
        springs: &[Spring],
        iterate: &mut QpIterate,
        work: &mut Workspace,
    ) -> Vec<f64> {
        let place = iterate.blocks.len() - 1;
        let contact = &mut iterate.blocks[place];
        let mut change = work.zeros(contact.multiplier.len());
        for spring in springs {
            let own = spring.first..spring.first + spring.width;
            for ((change, now), base) in change[own.clone()]
                .iter_mut()
                .zip(&mut contact.multiplier[own.clone()])
                .zip(spring.base)
            {
                *change = base - std::mem::take(now);
            }
            contact.status[own].fill(Status::Open);
        }
        contact.slides.clear();
        let mut force = work.scratch(iterate.force.len());
        self.block
            .columns
            .apply_transposed(&change, &mut force, work);
        add_scaled(&mut iterate.force, -1.0, &force);
        work.give(force);
        work.give(change);
        contact.residual.clone()
    }

    /// The set of the block with no room for tractions.
    fn without_friction<'r>(&'r self, radii: &'r [f64]) -> Vec<SetPart<'r>> {
        let (cones, parts): (Cones<'r>, _) = (self.cones, self.set.parts().iter());
        parts
            .flat_map(|part| {
                if matches!(part.set, AdmissibleSet::Cones(_)) {
                    cones.with_given(radii).to_vec()
                } else {
                    vec![*part]
                }
            })
            .collect()
    }

    /// Norm of what slips and tractions lack to the law, as slips.
    fn misfit(&self, contact: &BlockIterate) -> f64 {
        let mut square = 0.0;
        for (first, width, radius) in self.tractions(contact) {
            let softness = self.softness(first);
            let (trial, length) = trial((first, width), softness, contact);
            let share = (radius / length).min(1.0);
            for i in 0..width {
                let wrong = softness * (share * trial[i] - contact.multiplier[first + i]);
                square += wrong * wrong;
            }
        }
        square.sqrt()
    }

    /// What each traction does.
    fn set_status(&self, contact: &mut BlockIterate) {
        for (first, width, radius) in self.tractions(contact) {
            let (_, length) = trial((first, width), self.softness(first), contact);
            let status = match (radius > 0.0, length <= radius) {
                (false, _) => Status::Open,
                (true, true) => Status::Stick,
                (true, false) => Status::Slip,
            };
            contact.status[first..first + width].fill(status);
        }
    }
}

/// y = t - s / c, and its length.
fn trial((first, width): (usize, usize), softness: f64, contact: &BlockIterate) -> ([f64; 2], f64) {
    let mut trial = [0.0; 2];
    for (i, trial) in trial.iter_mut().enumerate().take(width) {
        *trial = contact.multiplier[first + i] - contact.residual[first + i] / softness;
    }
    (trial, norm(&trial))
}

/// The spring of a point: the projection of y on its disc and the derivative of that, of
/// which what the radius follows is left to the next pass.
fn spring(
    (first, width): (usize, usize),
    radius: f64,
    softness: f64,
    contact: &BlockIterate,
) -> Spring {
    let (trial, length) = trial((first, width), softness, contact);
    let sticks = length <= radius && radius > 0.0;
    let direction = trial.map(|y| y / length);
    let mut stiffness = [[0.0; 2]; 2];
    if sticks {
        (0..width).for_each(|i| stiffness[i][i] = 1.0 / softness);
    } else if width == 2 && radius > 0.0 {
        // Of (r / |y|) (I - e e^T) with dy = dt - ds / c solved for dt, but no stiffer than
        // a point that sticks.
        let across = [-direction[1], direction[0]];
        let size = (radius / (length - radius)).min(1.0) / softness;
        stiffness = across.map(|a| across.map(|b| size * a * b));
    }
    Spring {
        first,
        width,
        base: match (sticks, radius > 0.0) {
            (true, _) => trial,
            (false, true) => direction.map(|e| radius * e),
            (false, false) => [0.0; 2],
        },
        stiffness,
    }
}

/// The tractions of the springs from the slips `before` and now.
fn hold(springs: &[Spring], before: &[f64], iterate: &mut QpIterate) {
    let place = iterate.blocks.len() - 1;
    let contact = &mut iterate.blocks[place];
    for spring in springs {
        let lost = |j: usize| before[spring.first + j] - contact.residual[spring.first + j];
        for i in 0..spring.width {
            let growth: f64 = (0..spring.width)
                .map(|j| spring.stiffness[i][j] * lost(j))
                .sum();
            contact.multiplier[spring.first + i] = spring.base[i] + growth;
        }
    }
}

/// A + D^T M B.
struct Stiffened<'a> {
    body: &'a dyn LinearOperator,
    contact: MultiplierBlock<'a>,
    springs: &'a [Spring],
}

impl Stiffened<'_> {
    /// `into += columns^T M rows from`.
    fn add_springs(
        &self,
        (rows, columns): (&dyn LinearOperator, &dyn LinearOperator),
        from: &[f64],
        into: &mut [f64],
        work: &mut Workspace,
    ) {
        let mut slips = work.zeros(rows.rows());
        rows.apply(from, &mut slips, work);
        let mut tractions = work.zeros(rows.rows());
        for spring in self.springs {
            for i in 0..spring.width {
                tractions[spring.first + i] = (0..spring.width)
                    .map(|j| spring.stiffness[i][j] * slips[spring.first + j])
                    .sum();
            }
        }
        columns.add_transposed(1.0, &tractions, into, work);
        work.give(tractions);
        work.give(slips);
    }
}

impl LinearOperator for Stiffened<'_> {
    fn rows(&self) -> usize {
        self.body.rows()
    }

    fn columns(&self) -> usize {
        self.body.columns()
    }

    fn apply(&self, x: &[f64], y: &mut [f64], work: &mut Workspace) {
        self.body.apply(x, y, work);
        self.add_springs((self.contact.rows, self.contact.columns), x, y, work);
    }

    fn apply_transposed(&self, y: &[f64], x: &mut [f64], work: &mut Workspace) {
        self.body.apply_transposed(y, x, work);
        self.add_springs((self.contact.columns, self.contact.rows), y, x, work);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A traction of two numbers with that slip.
    fn point(traction: [f64; 2], slip: [f64; 2]) -> BlockIterate {
        BlockIterate {
            multiplier: traction.to_vec(),
            residual: slip.to_vec(),
            ..BlockIterate::default()
        }
    }

    /// Traction of the spring when the slip has changed.
    fn pulled(spring: &Spring, change: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|i| {
            spring.base[i] - spring.stiffness[i][0] * change[0] - spring.stiffness[i][1] * change[1]
        })
    }

    #[test]
    fn springs_of_a_slipping_point_follow_the_law_to_second_order() {
        let (radius, softness, slip) = (0.7, 0.1, [-0.3, 0.4]);
        let law = |slip: [f64; 2]| slip.map(|s| -radius * s / norm(&slip));
        let spring = spring((0, 2), radius, softness, &point(law(slip), slip));
        for change in [[1e-4, 0.0], [0.0, 1e-4]] {
            let exact = law([slip[0] + change[0], slip[1] + change[1]]);
            let pulled = pulled(&spring, change);
            let error = (pulled[0] - exact[0]).hypot(pulled[1] - exact[1]);
            assert!(error < 1e-7, "{pulled:?} {exact:?}");
        }
    }

    #[test]
    fn a_point_within_its_disc_is_held_by_its_spring() {
        let spring = spring((0, 2), 1.0, 0.5, &point([0.1, 0.2], [0.05, 0.0]));
        let pulled = pulled(&spring, [0.1, -0.2]);
        let exact = [0.1 - 0.05 / 0.5 - 0.1 / 0.5, 0.2 + 0.2 / 0.5];
        let error = (pulled[0] - exact[0]).hypot(pulled[1] - exact[1]);
        assert!(error < 1e-14, "{pulled:?}");
    }

    #[test]
    fn nothing_holds_a_point_without_pressure() {
        let spring = spring((0, 2), 0.0, 0.5, &point([0.0; 2], [0.05, 0.0]));
        let left = pulled(&spring, [0.1, -0.2]);
        assert!(norm(&left) < f64::MIN_POSITIVE, "{left:?}");
    }
}
