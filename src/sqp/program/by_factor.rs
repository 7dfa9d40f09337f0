//! A program by a factor of its body, once iterations have cost as much:
//!
//! ```text
//! K = [ A - G  B^T ]   W = C K^-1 C^T   du = K^-1 (r - C^T dl),   l in its set by W
//!     [ B      -S  ]
//! ```
//!
//! K is the body about the state, without what held gaps cancel of its contact pressure
//! ([`crate::contact::curvature_where_held`]) and without the part that is not symmetric; motions
//! that lower its energy are turned. W is dense, so that one problem of the size of the contact
//! gives its sides, and GCR on the true operator starts from there and ends after some
//! iterations, as many as K is wrong in columns. Where the sides do not settle - the state is far
//! from equilibrium and the program has many solutions or none - the solution in W is the step:
//! that of a stable body.
//!
//! When (A. Karlin, M. Manasse, L. McGeoch and S. Owicki, Algorithmica 11, 1994: the
//! ski-rental rule): after as many iterations as the factor costs by the estimates of the plan, so
//! that no program costs more than twice the cheaper way. Later programs of a session begin with
//! it. Cost: products for the entries of A, a factor, a solution for each near multiplier.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use super::QuadraticProgram;
use super::contact_edges::contact_edges;
use super::geometric::curvature_between_bodies;
use super::step::{Step, step_from};
use crate::contact::area_change::Pressures;
use crate::contact::curvature_where_held;
use crate::inequality::{
    BodyFactor, Matrices, OneLevel, QpIterate, QpNorms, QpRun, QpScales, QpStatus, QpTargets,
    dense_cone, slides_of,
};
use crate::krylov::Verdict;
use crate::linalg::vector::add_scaled;
use crate::linalg::{LinearOperator, SparseRows, SparseRowsBuilder, SymmetricMatrix, Workspace};
use crate::model::Model;
use crate::model::counters::timed;
use crate::model::state::State;
use crate::saddle::{EqualityBlock, SaddleOperator, Status};
use crate::sqp::factored_body::FactoredBody;
use crate::sqp::near_compliance::NearCompliance;
use crate::sqp::run::Run;

constants! {
    /// Motions that lower the energy, at most: of a breast between plates fifteen, of an O-ring
    /// far from equilibrium fourteen, of a belt on a drum nine; each costs a column.
    const MOST_TURNED: usize = 32;
    /// Iterations on one face with a factor of the body: as many as motions are turned, and some more.
    const MOST_ON_FACE: u32 = 60;
}

/// What contact takes off A where the gaps hold what they can; none without contact.
fn curvature(model: &Model<'_>, state: &State) -> Option<SparseRows> {
    let under_pressure = state.multiplier.iter().any(|&l| l != 0.0);
    under_pressure.then(|| {
        let closed = |status: &Status| f64::from(u8::from(status.is_closed()));
        let closed: Vec<f64> = state.status.iter().map(closed).collect();
        let placed = model.placed(&state.drive);
        let placed: Vec<_> = placed.filter(|(one, _)| one.is_by_points()).collect();
        let own = placed.iter().map(|(interface, met)| {
            let pressures = [&state.multiplier, &closed].map(|all| interface.own(all));
            (&interface.surface, met, pressures)
        });
        let own: Vec<_> = own.collect();
        let surfaces = own.iter().map(|(surface, met, [contact, closed])| {
            let pressures = Pressures {
                contact,
                internal: &state.pressure,
                closed,
            };
            (*surface, *met, pressures)
        });
        let surfaces: Vec<_> = surfaces.collect();
        let body = model.deformed(&state.displacement);
        let mut own = curvature_where_held(&body, &surfaces, &model.prepared.is_held);
        if let Some(pairs) = curvature_between_bodies(model, state) {
            own = own.plus(&pairs);
        }
        model.prepared.held.project_matrix(own)
    })
}

impl QuadraticProgram<'_> {
    /// Takes the factor of an earlier program into use; whether there is one.
    pub(super) fn take_kept_factor(&mut self, run: &Run<'_>) -> bool {
        let kept = run.learned.factored.clone();
        if let Some(kept) = kept.filter(|kept| kept.compliance.size() == self.now.gap.len()) {
            self.factored = Some(kept);
        }
        self.factored.is_some()
    }

    /// Takes a factor of the body about the state into use; whether there is one. Without one no
    /// earlier factor stays in use.
    pub(super) fn take_factor(&mut self, run: &mut Run<'_>) -> bool {
        self.factored = self.factored(run).map(Arc::new);
        self.has_fresh_factor = self.factored.is_some();
        run.learned.factored.clone_from(&self.factored);
        run.state.by_factor |= self.has_fresh_factor;
        self.has_fresh_factor
    }

    /// The body about the state, without what the contact of the state takes off, and the
    /// compliance of its contact; none where it has no such factor or the increment is stopped.
    fn factored(&self, run: &mut Run<'_>) -> Option<FactoredBody> {
        let start = std::time::Instant::now();
        let factor = self.body_factor(run);
        run.counters.seconds.factorise += start.elapsed().as_secs_f64();
        let factor = factor?;
        run.counters.factorisations += 1;
        let at = (&run.model, &*run.state);
        let compliance = timed(&mut run.counters.seconds.contact, || {
            NearCompliance::new(&factor, at, &self.now, run.work)
        });
        Some(FactoredBody::new(factor, compliance))
    }

    /// K as a factor.
    fn body_factor(&self, run: &mut Run<'_>) -> Option<BodyFactor> {
        let layout = run.learned.layout(&run.model);
        let Run {
            state,
            learned,
            watch,
            counters,
            work,
            ..
        } = run;
        let stopped = || watch.stopped(counters).is_some();
        let held = self
            .tangent
            .as_ref()
            .and_then(|_| curvature(&self.model, state));
        let contact_edges = held
            .as_ref()
            .and_then(|_| contact_edges(&self.model, state));
        let all = [held, contact_edges, self.geometric.load.clone()];
        let taken = all.into_iter().flatten().reduce(|sum, one| sum.plus(&one));
        let all = self.matrices(taken.as_ref(), &layout, &stopped, work)?;
        let no_contact = SparseRowsBuilder::new(all.stiffness.rows()).finish();
        let matrices = Matrices {
            contact: &no_contact,
            ..all
        };
        let factor = BodyFactor::stable(&matrices, MOST_TURNED, work);
        learned.factor_is_too_large |= matches!(factor, Err(QpStatus::TooLarge));
        factor.ok()
    }

    /// The step to the solution in the compliance of the factor; none where that has none.
    pub(super) fn step_by_compliance(&self, run: &mut Run<'_>) -> Option<Step> {
        let mut iterate = self.first_iterate(self.geometric.all(), run);
        run.counters.applications += 2;
        let moved = self.move_by_compliance(&mut iterate, run.work);
        moved.map(|()| step_from(iterate, run.state))
    }

    /// Newton's step on the face of the solution in the compliance; none where that has none, or
    /// where iterations on the face do not come to an end.
    pub(super) fn step_on_face(&self, run: &mut Run<'_>, level: f64) -> Option<Step> {
        let body = self.factored.as_ref()?;
        body.begin();
        let mut iterate = self.first_iterate(self.geometric.all(), run);
        self.move_by_compliance(&mut iterate, run.work)?;
        let blocks = self.blocks();
        let step = self.block_step(&*self.inverse.displacement, run.work);
        let geometric = self.geometric.all();
        let problem = self.problem(geometric, &*self.inverse.displacement, &blocks, &*step);
        let Run {
            state,
            learned,
            watch,
            counters,
            work,
            ..
        } = run;
        learned.directions.clear(work);
        let mut progress = |_: &QpNorms, _: &QpScales, _: usize| match watch.stopped(counters) {
            Some(_) => Verdict::Stop,
            None => Verdict::Continue,
        };
        let mut solve = QpRun {
            targets: QpTargets {
                force_scale: self.force_scale,
                level,
                multiplier_error: None,
            },
            scales: &mut state.scales.clone(),
            iterations: MOST_ON_FACE,
            directions: &mut learned.directions,
            progress: &mut progress,
            work,
        };
        let status = OneLevel::new(problem).solve_on_face(&mut iterate, &mut solve);
        counters.applications += body.solutions.load(Ordering::Relaxed);
        status.is_none().then(|| step_from(iterate, run.state))
    }

    /// Moves the iterate to the solution in the compliance of the factor, its residuals with it;
    /// none, the iterate where it was, where that has no solution.
    pub(super) fn move_by_compliance(
        &self,
        iterate: &mut QpIterate,
        work: &mut Workspace,
    ) -> Option<()> {
        let body = self.factored.as_ref()?;
        let (contact, equalities) = iterate.blocks.split_last_mut()?;
        let volumes = equalities.first().map_or(&[][..], |block| &block.residual);
        let free = body.solve(&iterate.force, volumes, work);
        let mut linear = vec![0.0; contact.residual.len()];
        self.metric().product(&contact.multiplier, &mut linear);
        let gaps = linear.iter_mut().zip(&contact.residual);
        gaps.for_each(|(linear, gap)| *linear = gap - *linear);
        let unknowns = iterate.force.len();
        let rows = self.contact_rows();
        rows.subtract_product(&free[..unknowns], &mut linear, work);
        let near = (&contact.status[..], &contact.multiplier[..]);
        let set = self.now.contact_set();
        let mut solution = dense_cone::solve(self.metric(), &linear, set, near).ok()?;
        contact.slides = slides_of(&set, &mut solution, contact);
        let mut change = solution.values;
        add_scaled(&mut change, -1.0, &contact.multiplier);
        add_scaled(&mut contact.multiplier, 1.0, &change);
        contact.status = solution.status;
        let columns = &self.now.coupling;
        columns.add_transposed(-1.0, &change, &mut iterate.force, work);
        let step = body.solve(&iterate.force, volumes, work);
        self.move_body(&step, iterate, work);
        Some(())
    }

    /// Adds a step of displacement and pressure to the iterate and takes what it does off the
    /// residuals.
    fn move_body(&self, step: &[f64], iterate: &mut QpIterate, work: &mut Workspace) {
        let Some((contact, equalities)) = iterate.blocks.split_last_mut() else {
            return;
        };
        let blocks: Vec<EqualityBlock<'_>> = self.pressure().into_iter().collect();
        let operator = SaddleOperator {
            stiffness: self.stiffness(),
            geometric: self.geometric.all().map(|all| all as &dyn LinearOperator),
            blocks: &blocks,
        };
        let mut left = work.zeros(step.len());
        operator.apply(step, &mut left, work);
        let (du, dp) = step.split_at(iterate.force.len());
        let (force, volumes) = left.split_at(du.len());
        add_scaled(&mut iterate.displacement, 1.0, du);
        add_scaled(&mut iterate.force, -1.0, force);
        for pressure in equalities {
            add_scaled(&mut pressure.multiplier, 1.0, dp);
            add_scaled(&mut pressure.residual, -1.0, volumes);
        }
        let rows = self.contact_rows();
        rows.subtract_product(du, &mut contact.residual, work);
        work.give(left);
    }

    /// Whether the factor is that of the body.
    pub(super) fn has_exact_factor(&self) -> bool {
        let body = self.factored.as_ref();
        self.has_fresh_factor && body.is_some_and(|body| body.is_exact())
    }
}
