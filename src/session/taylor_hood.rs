//! The solver's own body: Taylor-Hood, linear or of finite strain.
//!
//! It is immutable: what changes is in the increment that it is lent to. An increment is
//! one `Run` on it; the report is read from the state that follows.

use std::sync::Arc;

use super::body::{Advanced, Increment, Shared};
use crate::continuation;
use crate::diagnosis::site::locate;
use crate::goals::{self, Answers, GoalError};
use crate::linalg::Workspace;
use crate::mesh::Mesh;
use crate::model::Model;
use crate::model::conditions::Conditions;
use crate::model::counters::Counters;
use crate::model::drive::Drive;
use crate::model::friction::{SlipStart, note_slip};
use crate::model::interfaces::Interfaces;
use crate::model::lending::lend_anew;
use crate::model::loads::reference_load;
use crate::model::push::Applied;
use crate::model::remainder::Remainder;
use crate::model::state::{Start, State};
use crate::plan::Plan;
use crate::precond::p_multigrid::LANCZOS_STEPS;
use crate::prepare::TaylorHoodData;
use crate::report::{CancelToken, FieldData, FieldName, IterationRecord, Silent, StepReport};
use crate::results::coarse_turn::coarse_turns;
use crate::results::coarse_volume::coarse_volume;
use crate::results::contact_alone;
use crate::results::exerted::applied;
use crate::results::touch::Touch;
use crate::results::warnings::{coarse_facets, warnings};
use crate::results::{fields, step};
use crate::scene::GoalQuestions;
use crate::sqp::condensation::inside;
use crate::sqp::increment;
use crate::sqp::learned::Learned;
use crate::sqp::run::Run;
use crate::sqp::watch::Watch;
use crate::verify;

/// A body of Taylor-Hood elements.
#[derive(Debug)]
pub(crate) struct TaylorHoodBody {
    /// Decisions, resolved names and units of the scene.
    plan: Arc<Plan>,
    /// The checked mesh of the plan, undeformed.
    mesh: Arc<Mesh>,
    /// Operators and approximate inverses at rest, shared by all sessions.
    prepared: Arc<TaylorHoodData>,
    /// Surfaces with multipliers and what they meet.
    interfaces: Interfaces,
    /// Dead load at load factor one `[displacement unknowns]`.
    load: Vec<f64>,
}

impl TaylorHoodBody {
    /// The body of `plan` with its surfaces and loads.
    pub(crate) fn new(plan: Arc<Plan>, mesh: Arc<Mesh>, prepared: Arc<TaylorHoodData>) -> Self {
        Self {
            interfaces: Interfaces::new(&plan, &mesh, &prepared.space),
            load: reference_load(&plan, &mesh, &prepared),
            plan,
            mesh,
            prepared,
        }
    }

    /// The surfaces of `state` where these lend functions to each other; none where they are the body's own.
    pub(super) fn lending(&self, state: &State) -> Option<Interfaces> {
        self.interfaces.lending(&self.model(), state)
    }

    /// The body as it is without functions that are lent, at the tolerance of the scene.
    pub(super) fn model(&self) -> Model<'_> {
        Model {
            plan: &self.plan,
            mesh: &self.mesh,
            prepared: &self.prepared,
            interfaces: &self.interfaces,
            load: &self.load,
            conditions: self.conditions(None),
        }
    }

    /// Equilibrium as exact as the scene asks, with slip counted from `slip_start`.
    fn conditions(&self, slip_start: Option<Arc<SlipStart>>) -> Conditions {
        Conditions {
            slip_start,
            ..Conditions::to(self.plan.problem.settings.tolerance)
        }
    }

    /// The body as an increment or a report reads it, with the surfaces of [`Self::lending`].
    pub(super) fn model_with<'a>(&'a self, lending: &'a Option<Interfaces>) -> Model<'a> {
        Model {
            interfaces: lending.as_ref().unwrap_or(&self.interfaces),
            ..self.model()
        }
    }

    /// An increment on the body, at its begin, with the surfaces of [`Self::lending`].
    fn run<'a>(
        &'a self,
        increment: &'a mut Increment<'_>,
        lending: &'a Option<Interfaces>,
    ) -> Run<'a> {
        Run {
            model: self.model_with(lending),
            state: increment.state,
            learned: increment.learned,
            watch: increment.watch.shared(),
            counters: &mut increment.counters,
            work: &mut increment.work,
        }
    }
}

impl TaylorHoodBody {
    /// The plan that the body follows.
    pub(super) fn plan(&self) -> &Plan {
        &self.plan
    }

    /// The mesh of the plan.
    pub(super) fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// Bytes, seconds and names of the prepared data.
    pub(super) fn shared(&self) -> Shared {
        Shared {
            bytes: self.prepared.bytes(),
            seconds: self.prepared.seconds(),
            parts: self.prepared.parts(),
        }
    }

    /// Bytes that the body holds for this session alone.
    pub(super) fn bytes(&self) -> u64 {
        8 * self.load.len() as u64
    }

    /// Moves the state towards equilibrium under `goal`. An increment that something
    /// from outside stopped before any part of it converged leaves the state `before`.
    pub(super) fn advance<'a>(
        &'a self,
        mut increment: Increment<'a>,
        goal: &Drive,
        before: &State,
    ) -> Advanced {
        let lends = lend_anew(&self.model(), increment.state).then(|| increment.state.clone());
        let before = lends.as_ref().unwrap_or(before);
        let lending = self.lending(before);
        let mut run = self.run(&mut increment, &lending);
        let has_friction = self.interfaces.friction.is_some();
        run.model.conditions = self.conditions(has_friction.then(|| SlipStart::at(before).into()));
        run.state.remainder = Remainder::of(&run.model);
        let (mut ending, part) = continuation::advance(&mut run, goal);
        ending.site = ending.site.or_else(|| locate(&mut run, &ending, goal));
        if ending.is_stopped() {
            if part == 0.0 {
                run.state.clone_from(before);
            }
            increment::describe(&mut run, &mut ending);
        }
        note_slip(&run.model, run.state);
        Advanced {
            ending,
            part,
            start: start(&mut run, before),
            slip_start: run.model.conditions.slip_start.take(),
            counters: increment.counters,
            work: increment.work,
        }
    }

    /// Makes the state that of the whole body, and hands the scratch vectors back.
    pub(super) fn complete<'a>(&'a self, mut at: Increment<'a>) -> Workspace {
        let lending = self.lending(at.state);
        inside::complete(&mut self.run(&mut at, &lending));
        at.work
    }

    /// What obstacles exert on the body at `state`, and supports where `end` pushes them.
    pub(super) fn applied(&self, state: &State, end: &Drive) -> Applied {
        applied(&self.model_with(&self.lending(state)), state, end)
    }

    /// The report of an increment, without what only the session knows.
    pub(super) fn report(&self, state: &State, advanced: &mut Advanced) -> StepReport {
        let lending = self.lending(state);
        let model = Model {
            conditions: self.conditions(advanced.slip_start.clone()),
            ..self.model_with(&lending)
        };
        let Advanced {
            ending,
            start,
            counters,
            work,
            ..
        } = advanced;
        if !state.is_whole() {
            return contact_alone::report(&model, state, ending, counters);
        }
        let mut report = step::report(&model, state, ending, counters, work);
        let touches = Touch::all(&model, state);
        report.warnings = warnings(&model, (start, state), (ending, &touches));
        report.warnings.extend(coarse_facets(&report.obstacles));
        report.warnings.extend(coarse_turns(&model, state));
        let lost = coarse_volume(&model, state, &report);
        report.warnings.extend(lost);
        step::add_hidden_forces(&model, &touches, &mut report.obstacles);
        if self.plan.problem.settings.verify {
            report.verification = Some(verify::verify(&model, state, ending));
        }
        report
    }

    /// Adds to a report what building the prepared data took beside seconds.
    pub(super) fn count_preparation(&self, report: &mut StepReport) {
        report.eigenvalue_applications += LANCZOS_STEPS as u32;
        report.compliance_columns = self.prepared.at_rest.compliance.columns() as u32;
    }

    /// Answers questions about `state` with a copy of what the solver has learnt on the way there;
    /// `before` is where its increment began.
    ///
    /// # Errors
    /// [`GoalError`].
    pub(super) fn answer(
        &self,
        (before, state, learned): (Option<&State>, &State, &Learned),
        questions: &[GoalQuestions],
        cancel: &CancelToken,
    ) -> Result<Answers, GoalError> {
        let lending = self.lending(state);
        let whole = inside::completed(&self.model_with(&lending), state, learned);
        let mut increment = Increment {
            state: &mut whole.unwrap_or_else(|| state.clone()),
            learned: &mut learned.copy(),
            watch: Watch {
                observer: &mut Silent,
                cancel,
                seconds_left: None,
                record: IterationRecord::default(),
            },
            counters: Counters::new(),
            work: Workspace::new(),
        };
        let mut run = self.run(&mut increment, &lending);
        let start = before.filter(|_| self.interfaces.friction.is_some());
        run.model.conditions = self.conditions(start.map(|start| SlipStart::at(start).into()));
        goals::answer(&mut run, questions)
    }

    /// Parts of the cells over their undeformed volumes, in two dimensions over the areas of the
    /// section, in the caller's units.
    pub(super) fn over_volumes(&self, parts: Vec<f64>) -> Vec<f64> {
        let model = self.model();
        let (mesh, units) = (model.mesh, &model.plan.problem.units);
        let dimension = mesh.cell_kind().dimension() as i32;
        let unit = units.length.powi(dimension);
        let volumes = &model.prepared.geometry.volumes;
        let of_section = |cell: usize| {
            let area = mesh.cell_kind().signed_measure(&mesh.corners(cell));
            area * units.coordinate_scale.powi(dimension)
        };
        let size = |cell: usize| {
            if model.plan.is_axisymmetric() {
                of_section(cell)
            } else {
                volumes[cell]
            }
        };
        let of_cell = |(cell, part): (usize, f64)| part / (size(cell) * unit);
        parts.into_iter().enumerate().map(of_cell).collect()
    }

    /// A field of `state` with what the solver has learnt on the way there; none if the scene has
    /// no such field.
    pub(super) fn field(
        &self,
        (state, learned): (&State, &Learned),
        name: FieldName,
    ) -> Option<FieldData> {
        let lending = self.lending(state);
        let model = self.model_with(&lending);
        let whole = inside::completed(&model, state, learned);
        if whole.is_none() && !state.is_whole() {
            return None;
        }
        let mode = learned.lowest_mode.as_ref();
        let mode = mode.map(|mode| mode.motion.as_slice());
        fields::field(&model, (whole.as_ref().unwrap_or(state), mode), name)
    }
}

/// Where an increment began, as its report reads it: whole where that is.
fn start(run: &mut Run<'_>, before: &State) -> Start {
    if before.is_whole() || !run.state.is_whole() {
        return Start::at(before);
    }
    let behind = std::mem::replace(run.state, before.clone());
    inside::complete(run);
    Start::at(&std::mem::replace(run.state, behind))
}
