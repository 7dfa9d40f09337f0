//! The stiffness of a program with its constraints as stiff terms,
//!
//! ```text
//! K_w = K + B^T (M / (w step mu) + S)^-1 B + w C_A^T H_A^-1 C_A,   K = A - curvature
//! ```
//!
//! M the mass of the pressures, S their volume compliance, both inverted by Chebyshev steps and
//! taken a hundredth too small for what these leave, H_A the compliance metric of the
//! multipliers that hold. On motions without change of
//! volume that keep all contacts it is K, and it is below what the constraints themselves add
//! elsewhere: where K_w is positive, K is so among the motions that the constraints admit. Rigid
//! motions that nothing resists are made stiff besides (`rigid_modes`).
//! `[displacement, displacement]`. Cost of a product: one of K, B, B^T, and a solve with the factor
//! of H_A.

use std::sync::Arc;

use super::QuadraticProgram;
use super::rigid_modes::RigidModes;
use crate::inequality::Augmented;
use crate::krylov::least_eigenvalue::{Least, LeastEigenvalue};
use crate::linalg::vector::add_scaled;
use crate::linalg::{
    FactoriseError, LinearOperator, PartFactor, Preconditioner, SparseRows, Workspace,
};
use crate::precond::Counted;
use crate::precond::schur::ChebyshevMass;
use crate::saddle::{EqualityBlock, Status};
use crate::sqp::run::Run;

constants! {
    /// Chebyshev steps of a product.
    const STEPS: usize = 6;
    /// What is left of an inverse by Chebyshev steps that is below the exact one for certain.
    const SLACK: f64 = 0.99;
}

/// K_w.
struct Penalised<'a> {
    /// A.
    stiffness: &'a dyn LinearOperator,
    /// What loads and contacts subtract from A, but for what vanishes where the contacts hold.
    geometric: Option<Box<dyn LinearOperator + 'a>>,
    /// What is added to that to make it symmetric; none where it is.
    skew: Option<SparseRows>,
    /// Internal pressure.
    volume: Option<Volume<'a>>,
    /// Contact.
    held: Option<Held<'a>>,
    /// w.
    weight: f64,
    /// Rigid motions; none where supports hold the body.
    rigid_modes: Option<RigidModes>,
}

/// A matrix of the program.
struct Borrowed<'a>(&'a SparseRows);

impl LinearOperator for Borrowed<'_> {
    fn rows(&self) -> usize {
        self.0.rows()
    }

    fn columns(&self) -> usize {
        self.0.columns()
    }

    fn apply(&self, x: &[f64], y: &mut [f64], work: &mut Workspace) {
        self.0.apply(x, y, work);
    }

    fn apply_transposed(&self, y: &[f64], x: &mut [f64], work: &mut Workspace) {
        self.0.apply_transposed(y, x, work);
    }
}

/// What the volume resists.
struct Volume<'a> {
    pressure: EqualityBlock<'a>,
    /// Inverse of M / (w step mu) + S.
    metric: ChebyshevMass,
}

impl Volume<'_> {
    /// Adds what the volume resists of the motion `x` to `y`.
    fn add(&self, (x, y): (&[f64], &mut [f64]), work: &mut Workspace) {
        let mut change = work.scratch(self.pressure.rows.rows());
        self.pressure.rows.apply(x, &mut change, work);
        let mut pressure = work.scratch(change.len());
        self.metric.apply(&change, &mut pressure, work);
        let columns = self.pressure.columns;
        columns.add_transposed(SLACK, &pressure, y, work);
        work.give(change);
        work.give(pressure);
    }
}

/// The multipliers that hold.
struct Held<'a> {
    /// C of all multipliers `[multipliers, displacement]`.
    rows: &'a SparseRows,
    /// Those that hold, ascending.
    selected: Vec<usize>,
    /// Factor of H_A.
    factor: Arc<dyn PartFactor>,
}

impl Held<'_> {
    /// Adds what contact resists of the motion `x` to `y`.
    fn add(&self, weight: f64, (x, y): (&[f64], &mut [f64]), work: &mut Workspace) {
        let mut gaps = work.scratch(self.rows.rows());
        self.rows.apply(x, &mut gaps, work);
        let mut pressures = work.zeros(gaps.len());
        let mut own: Vec<f64> = self.selected.iter().map(|&row| gaps[row]).collect();
        self.factor.solve_part(&mut own, work);
        for (&row, own) in self.selected.iter().zip(&own) {
            pressures[row] = weight * own;
        }
        self.rows.add_transposed(1.0, &pressures, y, work);
        work.give(gaps);
        work.give(pressures);
    }
}

impl LinearOperator for Penalised<'_> {
    fn rows(&self) -> usize {
        self.stiffness.rows()
    }

    fn columns(&self) -> usize {
        self.stiffness.columns()
    }

    fn apply(&self, x: &[f64], y: &mut [f64], work: &mut Workspace) {
        self.stiffness.apply(x, y, work);
        if let Some(geometric) = &self.geometric {
            let mut product = work.scratch(y.len());
            geometric.apply(x, &mut product, work);
            add_scaled(y, -1.0, &product);
            work.give(product);
        }
        if let Some(skew) = &self.skew {
            skew.subtract_product(x, y, work);
        }
        if let Some(volume) = &self.volume {
            volume.add((x, y), work);
        }
        if let Some(held) = &self.held {
            held.add(self.weight, (x, y), work);
        }
        if let Some(rigid_modes) = &self.rigid_modes {
            rigid_modes.add(x, y);
        }
    }

    fn apply_transposed(&self, y: &[f64], x: &mut [f64], work: &mut Workspace) {
        self.apply(y, x, work);
    }
}

impl QuadraticProgram<'_> {
    /// The sign of the least eigenvalue of K_w beside the approximate inverse, from `force`, in
    /// `steps` at most.
    pub(crate) fn least_eigenvalue(
        &self,
        run: &mut Run<'_>,
        force: Vec<f64>,
        (weight, steps): (f64, usize),
    ) -> Least {
        let Ok(held) = self.held(&run.state.status) else {
            return Least::Nothing;
        };
        let displacement = Counted::new(&*self.inverse.displacement);
        let mut operator = Penalised {
            stiffness: self.stiffness(),
            geometric: self.geometric_on_contact(&run.state.status),
            skew: self.skew(),
            volume: self.volume(weight),
            held,
            weight,
            rigid_modes: None,
        };
        let means: (&dyn LinearOperator, &dyn Preconditioner) = (&operator, &displacement);
        operator.rigid_modes = self.resisted_rigid_modes(run.state, means, run.work);
        let process = LeastEigenvalue {
            operator: &operator,
            preconditioner: &displacement,
            steps,
        };
        let Run {
            learned,
            watch,
            counters,
            work,
            ..
        } = run;
        learned.directions.clear(work);
        let stopped = || watch.stopped(counters).is_some();
        let least = process.solve(force, &stopped, work);
        counters.eigenvalue_applications += displacement.applications();
        least
    }

    /// What loads and contacts subtract from A, less what vanishes where the contacts of
    /// `status` hold.
    fn geometric_on_contact(&self, status: &[Status]) -> Option<Box<dyn LinearOperator + '_>> {
        let geometric = self.geometric.all();
        let coupling: &dyn LinearOperator = &self.now.coupling;
        let terms = self.augmentation.as_ref();
        let on_contact =
            terms.and_then(|terms| Augmented::new(terms, [coupling; 2], (status, &[]), geometric));
        match on_contact {
            Some(operator) => Some(Box::new(operator)),
            None => {
                geometric.map(|geometric| Box::new(Borrowed(geometric)) as Box<dyn LinearOperator>)
            }
        }
    }

    /// What the volume resists; none in displacement form.
    fn volume(&self, weight: f64) -> Option<Volume<'_>> {
        let block = self.model.prepared.pressure.as_ref()?;
        let dimension = self.model.plan.problem.units.dimension;
        Some(Volume {
            pressure: self.pressure()?,
            metric: block.softened(weight, STEPS, dimension),
        })
    }

    /// The multipliers that hold; none where nothing touches.
    ///
    /// # Errors
    /// Where the metric on them is not positive definite.
    fn held(&self, status: &[Status]) -> Result<Option<Held<'_>>, FactoriseError> {
        let holds = |&row: &usize| status[row] == Status::Stick;
        let selected: Vec<usize> = (0..status.len()).filter(holds).collect();
        if selected.is_empty() {
            return Ok(None);
        }
        Ok(Some(Held {
            factor: self.metric.matrix.factor_of_part(&selected)?,
            rows: &self.now.coupling,
            selected,
        }))
    }
}
