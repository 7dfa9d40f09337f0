//! What a program's factors are made of: its operators, found by products, and the motions that
//! lower its energy.

use super::QuadraticProgram;
use crate::inequality::{Inertia, Matrices, inertia};
use crate::linalg::{SparseRows, Workspace};
use crate::plan::estimate::MOST_FACTOR_FLOPS;
use crate::sqp::run::Run;
use crate::sqp::saddle_layout::SaddleLayout;

constants! {
    /// Entries of the skew part over the largest of the whole that are rounding.
    const SKEW: f64 = 1e-12;
}

impl QuadraticProgram<'_> {
    /// Counts the motions that lower the energy where the present contacts hold, and finds
    /// the softest one from `start`; none where it was stopped or the factor is too large.
    pub(crate) fn inertia(&self, run: &mut Run<'_>, start: &[f64]) -> Option<Inertia> {
        let Run {
            state,
            learned,
            watch,
            counters,
            work,
            ..
        } = run;
        let layout = learned.layout(&self.model);
        let stopped = || watch.stopped(counters).is_some();
        let matrices = Matrices {
            // Rigid modes are told from soft ones by a shift of its own.
            has_rigid_modes: false,
            ..self.matrices(self.geometric.all(), &layout, &stopped, work)?
        };
        let skew = self.skew();
        let problem = (&matrices, skew.as_ref());
        inertia(problem, &state.status, start, work).ok()
    }

    /// The skew part of the stiffness, of pressures on faces with a free edge; none where all
    /// loads have a potential.
    pub(crate) fn skew(&self) -> Option<SparseRows> {
        let geometric = self.geometric.all()?;
        let twice = geometric.transposed().plus_multiple(-1.0, geometric);
        let bound = SKEW * geometric.largest();
        (twice.largest() > bound).then(|| twice.scaled_above(0.5, bound))
    }

    /// The matrices of the program; none where it was stopped on the way.
    pub(super) fn matrices<'m>(
        &'m self,
        curvature: Option<&SparseRows>,
        layout: &SaddleLayout,
        stopped: &dyn Fn() -> bool,
        work: &mut Workspace,
    ) -> Option<Matrices<'m>> {
        let model = &self.model;
        let pressure = self.pressure();
        let operators = (self.stiffness(), pressure.as_ref().map(|block| block.rows));
        let (mut stiffness, coupling) = layout.stored(operators, stopped, work)?;
        if let Some(curvature) = curvature {
            // The part of a free edge under pressure is not symmetric; a factor of one triangle
            // would see it twice or not at all.
            let symmetric = curvature.plus(&curvature.transposed());
            stiffness = stiffness.plus_multiple(-0.5, &symmetric);
        }
        let block = model.prepared.pressure.as_ref();
        Some(Matrices {
            stiffness,
            coupling,
            stabilisation: block.and_then(|block| block.stabilisation.as_ref()),
            contact: &self.now.coupling,
            places: layout.places.clone(),
            has_rigid_modes: model.plan.is_shifted(),
            most_flops: MOST_FACTOR_FLOPS,
        })
    }
}
