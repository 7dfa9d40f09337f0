//! The loop: solve, judge, halve, carry over or begin again.

use std::sync::Arc;
use std::time::Instant;

use super::accuracy::{Accuracy, Target};
use super::error::AdaptionError;
use super::judge::{self, Judge};
use super::round::{End, GoalRound, Round};
use crate::mesh::Mesh;
use crate::plan::Plan;
use crate::prepare::Prepared;
use crate::refinement::{Hierarchy, Limits, Refined, RefinementError};
use crate::report::{CancelToken, GoalReport, Observer, StepReport, Termination};
use crate::scene::{Scene, Step, SurfaceGeometry};
use crate::session::{Reuse, Session};

/// What is solved.
#[derive(Clone, Copy, Debug)]
pub struct Problem<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Its steps, at least one.
    pub steps: &'a [Step],
    /// The first mesh.
    pub mesh: &'a Arc<Mesh>,
}

/// Who follows the loop.
pub struct Watch<'a> {
    /// Called with each mesh when its goals are known.
    pub rounds: &'a mut dyn FnMut(&Round),
    /// Told of the iterations on all meshes.
    pub observer: &'a mut dyn Observer,
    /// Asked for the bytes that the present mesh and a finer one are predicted to take, before the
    /// finer one is prepared; the loop ends where there is no room.
    pub room: &'a mut dyn FnMut(u64) -> bool,
    /// Polled by all parts.
    pub cancel: &'a CancelToken,
}

/// The last mesh and what it gave.
#[derive(Debug)]
pub struct Adapted {
    /// The state at the end of the last step.
    pub session: Session,
    /// The scene on refined meshes: surfaces that were asked to be smooth are those of the mesh. Its
    /// questions are left out, also of the session: the loop asks its own, once a mesh.
    pub scene: Scene,
    /// The mesh, to be refined again.
    pub hierarchy: Hierarchy,
    /// All meshes, the last one last; none where the first one has no equilibrium.
    pub rounds: Vec<Round>,
    /// Why there is no finer one.
    pub end: End,
}

/// Solves `problem` on finer and finer meshes until the goals are known as well as `accuracy` asks,
/// or a limit ends it. Cost: some two solutions on the last mesh of the last state, of all steps where
/// the state depends on its way.
///
/// # Errors
/// [`AdaptionError`] where the scene is refused, goals have no error on the first mesh, or the caller
/// cancels it. Without an equilibrium on the first mesh there are no rounds. What fails on a refined mesh
/// ends the loop with what the one before gave, a deadline among it.
pub fn adapt(
    problem: Problem<'_>,
    accuracy: &Accuracy,
    mut watch: Watch<'_>,
) -> Result<Adapted, AdaptionError> {
    check(problem, accuracy)?;
    let mut judge = Judge::new(accuracy);
    let started = Instant::now();
    let mut present = match first(problem, &mut watch)? {
        (present, None) => present,
        (present, Some(end)) => return Ok(present.ended(Vec::new(), end)),
    };
    let stay = [Step::default()];
    let way = Way::of(present.session.plan(), (problem.steps, &stay));
    let mut answers = present.answers(accuracy, watch.cancel)?;
    let mut rounds: Vec<Round> = Vec::new();
    let end = loop {
        let round = present.round(rounds.len(), judge.goals(&answers), &answers);
        (watch.rounds)(&round);
        let goals = round.goals.clone();
        rounds.push(round);
        if let Some(end) = judge::end(&goals, &answers) {
            break end;
        }
        let left = Left {
            accuracy,
            rounds: &rounds,
            started,
            way,
        };
        let marked = judge::marks(&goals, &answers);
        match present.answered(&marked, &left, &mut watch) {
            Ok((finer, found)) => (present, answers) = (finer, found),
            Err(failure) => break left.failed(failure, watch.cancel)?,
        }
    };
    Ok(present.ended(rounds, end))
}

/// Refuses what no mesh can answer.
fn check(problem: Problem<'_>, accuracy: &Accuracy) -> Result<(), AdaptionError> {
    let is_usable = |tolerance: f64| tolerance.is_finite() && tolerance > 0.0;
    let is_repeated = |(place, one): (usize, &Target)| {
        let mut before = accuracy.targets.iter().take(place);
        before.any(|other| other.goal == one.goal)
    };
    if accuracy.targets.is_empty() {
        Err(AdaptionError::Malformed("it names no goal"))
    } else if !accuracy.targets.iter().all(|one| is_usable(one.tolerance)) {
        Err(AdaptionError::Malformed("tolerances must be above zero"))
    } else if accuracy.targets.iter().enumerate().any(is_repeated) {
        Err(AdaptionError::Malformed("it names a goal twice"))
    } else if problem.steps.is_empty() {
        Err(AdaptionError::Malformed("there is no step"))
    } else {
        Ok(())
    }
}

/// How the last state is reached on a finer mesh.
#[derive(Clone, Copy)]
enum Way<'a> {
    /// Carried over, and brought into equilibrium by a step that leaves what drives the body as it
    /// is: it does not depend on its way.
    Carried(&'a [Step]),
    /// By all steps from rest: friction counts slip from where increments began, fluids only advance, and multipliers between
    /// bodies belong to both of their meshes.
    Again(&'a [Step]),
}

impl<'a> Way<'a> {
    fn of(plan: &Plan, (steps, stay): (&'a [Step], &'a [Step])) -> Self {
        let scene = plan.scene();
        let is_between_bodies = !scene.contacts.is_empty() || !scene.ties.is_empty();
        if plan.has_friction() || is_between_bodies || !scene.fluids.is_empty() {
            Self::Again(steps)
        } else {
            Self::Carried(stay)
        }
    }

    fn steps(self) -> &'a [Step] {
        match self {
            Self::Carried(steps) | Self::Again(steps) => steps,
        }
    }
}

/// One mesh and the state on it.
struct Present {
    scene: Scene,
    hierarchy: Hierarchy,
    session: Session,
    unknowns: u64,
    /// Predicted for a step.
    bytes: u64,
    started: Instant,
}

/// Why there is no finer mesh.
enum Failure {
    End(End),
    Error(AdaptionError),
}

impl From<AdaptionError> for Failure {
    fn from(error: AdaptionError) -> Self {
        Self::Error(error)
    }
}

/// What is left of the limits.
struct Left<'a> {
    accuracy: &'a Accuracy,
    rounds: &'a [Round],
    started: Instant,
    way: Way<'a>,
}

/// All steps on the first mesh, up to one without an equilibrium.
fn first(
    problem: Problem<'_>,
    watch: &mut Watch<'_>,
) -> Result<(Present, Option<End>), AdaptionError> {
    let started = Instant::now();
    let scene = without_questions(problem.scene);
    let plan = Arc::new(Plan::new(&scene, problem.steps, problem.mesh)?);
    let prepared = Arc::new(Prepared::build(&plan, problem.mesh, watch.cancel)?);
    let mesh = plan.body_mesh(problem.mesh);
    let mut session = Session::new(plan.clone(), problem.mesh.clone(), prepared, Reuse::Built);
    let end = taken(&mut session, problem.steps, watch)?;
    let present = Present {
        scene: as_meshed(scene),
        hierarchy: Hierarchy::new(mesh),
        session,
        unknowns: unknowns(&plan),
        bytes: plan.first_bytes(),
        started,
    };
    Ok((present, end))
}

/// Takes `steps`; why there is no goal where one of them finds no equilibrium.
fn taken(
    session: &mut Session,
    steps: &[Step],
    watch: &mut Watch<'_>,
) -> Result<Option<End>, AdaptionError> {
    for step in steps {
        let StepReport {
            step, termination, ..
        } = take(session, step, watch)?;
        if termination != Termination::Converged {
            return Ok(Some(End::NoEquilibrium { step, termination }));
        }
    }
    Ok(None)
}

/// The scene that asks nothing of its increments.
fn without_questions(scene: &Scene) -> Scene {
    Scene {
        questions: Vec::new(),
        ..scene.clone()
    }
}

/// The scene where fitted arcs belong to the mesh.
fn as_meshed(mut scene: Scene) -> Scene {
    for obstacle in &mut scene.obstacles {
        obstacle.surface = SurfaceGeometry::AsMeshed;
    }
    scene
}

fn unknowns(plan: &Plan) -> u64 {
    let all = plan.unknowns();
    all.displacement + all.pressure + all.contact
}

/// Takes a step; its last report.
fn take(
    session: &mut Session,
    step: &Step,
    watch: &mut Watch<'_>,
) -> Result<StepReport, AdaptionError> {
    let mut run = session.begin_step(step)?;
    let mut last = StepReport::default();
    while let Some(report) = session.advance(&mut run, watch.observer, watch.cancel) {
        if report.termination == Termination::Cancelled {
            return Err(AdaptionError::Stopped(report.termination));
        }
        last = report;
    }
    Ok(last)
}

impl Present {
    /// What the loop gives.
    fn ended(self, rounds: Vec<Round>, end: End) -> Adapted {
        Adapted {
            session: self.session,
            scene: self.scene,
            hierarchy: self.hierarchy,
            rounds,
            end,
        }
    }

    fn answers(
        &self,
        accuracy: &Accuracy,
        cancel: &CancelToken,
    ) -> Result<Vec<GoalReport>, AdaptionError> {
        Ok(self.session.answer(&accuracy.questions(), cancel)?)
    }

    fn round(&self, before: usize, goals: Vec<GoalRound>, answers: &[GoalReport]) -> Round {
        Round {
            round: before as u32 + 1,
            cells: self.hierarchy.mesh().cell_count() as u64,
            unknowns: self.unknowns,
            goals,
            seconds: self.started.elapsed().as_secs_f64(),
            dual_seconds: answers.iter().map(|answer| answer.seconds).sum(),
        }
    }

    /// The state on the mesh where `marked` cells are halved, with its goals.
    fn answered(
        &mut self,
        marked: &[u32],
        left: &Left<'_>,
        watch: &mut Watch<'_>,
    ) -> Result<(Self, Vec<GoalReport>), Failure> {
        let finer = self.finer(marked, left, watch)?;
        let answers = finer.answers(left.accuracy, watch.cancel)?;
        Ok((finer, answers))
    }

    /// The state on the mesh where `marked` cells are halved.
    fn finer(
        &mut self,
        marked: &[u32],
        left: &Left<'_>,
        watch: &mut Watch<'_>,
    ) -> Result<Self, Failure> {
        let started = Instant::now();
        left.refuse_over()?;
        self.ask_room(self.least_bytes(marked), watch)?;
        let refined = self.hierarchy.halve(marked, left.of_mesh());
        let refined = refined.map_err(|error| left.refused(error))?;
        let scene = left.timed(&self.scene);
        let steps = left.way.steps();
        let plan =
            Plan::new(&scene, steps, refined.hierarchy.mesh()).map_err(AdaptionError::from)?;
        left.refuse_too_large(&plan)?;
        self.ask_room(plan.first_bytes(), watch)?;
        let over = (left.way, watch.cancel);
        let mut finer = self.on_finer((Arc::new(plan), started), refined, over)?;
        for step in steps {
            left.refuse_late()?;
            let ending = take(&mut finer.session, step, watch)?.termination;
            if ending != Termination::Converged {
                return Err(Failure::End(left.ended(ending)));
            }
        }
        Ok(finer)
    }

    /// What a mesh of the cells that there are with those that are marked, halved, takes at the least.
    fn least_bytes(&self, marked: &[u32]) -> u64 {
        let cells = self.hierarchy.mesh().cell_count().max(1) as u64;
        let added = u128::from(self.bytes) * marked.len() as u128 / u128::from(cells);
        self.bytes
            .saturating_add(u64::try_from(added).unwrap_or(u64::MAX))
    }

    /// Asks for what a finer mesh takes beside the present one.
    fn ask_room(&self, needed: u64, watch: &mut Watch<'_>) -> Result<(), Failure> {
        if (watch.room)(self.bytes.saturating_add(needed)) {
            Ok(())
        } else {
            Err(Failure::End(End::NoRoom { needed }))
        }
    }

    /// Where a refined mesh begins: at the present state, or at rest.
    fn on_finer(
        &mut self,
        (plan, started): (Arc<Plan>, Instant),
        refined: Refined,
        (way, cancel): (Way<'_>, &CancelToken),
    ) -> Result<Self, AdaptionError> {
        let mesh = refined.hierarchy.mesh().clone();
        let prepared = Arc::new(Prepared::build(&plan, &mesh, cancel)?);
        let (unknowns, bytes) = (unknowns(&plan), plan.first_bytes());
        let session = match way {
            Way::Carried(_) => {
                let over = (mesh, &refined.lineage);
                self.session.refined(plan, over, (prepared, Reuse::Built))?
            }
            Way::Again(_) => Session::new(plan, mesh, prepared, Reuse::Built),
        };
        Ok(Self {
            scene: self.scene.clone(),
            hierarchy: refined.hierarchy,
            session,
            unknowns,
            bytes,
            started,
        })
    }
}

impl Left<'_> {
    /// Seconds left; none where any number will do.
    fn seconds(&self) -> Option<f64> {
        let most = self.accuracy.limits.seconds?;
        Some((most - self.started.elapsed().as_secs_f64()).max(0.0))
    }

    /// The scene with a limit for what is solved next.
    fn timed(&self, scene: &Scene) -> Scene {
        let mut scene = scene.clone();
        let limit = &mut scene.solver.max_wall_time;
        *limit = match (*limit, self.seconds()) {
            (Some(own), Some(left)) => Some(own.min(left)),
            (own, left) => own.or(left),
        };
        scene
    }

    /// Why there is no equilibrium on the next mesh: of several limits of time the one that is used up.
    fn ended(&self, termination: Termination) -> End {
        let is_late = termination == Termination::DeadlineExceeded
            && self.seconds().is_some_and(|left| left <= 0.0);
        let most = self.accuracy.limits.seconds.filter(|_| is_late);
        most.map_or(End::NotConverged(termination), |most| End::Time { most })
    }

    /// The end that a failure is: the mesh before has its answers. A caller who stops gets none.
    fn failed(&self, failure: Failure, cancel: &CancelToken) -> Result<End, AdaptionError> {
        match (failure, cancel.stopped()) {
            (Failure::End(end), _) => Ok(end),
            (Failure::Error(error), Some(Termination::Cancelled)) => Err(error),
            (Failure::Error(_), Some(stopped)) => Ok(self.ended(stopped)),
            (Failure::Error(error), None) => Ok(End::Failed(error.to_string())),
        }
    }

    fn refuse_over(&self) -> Result<(), Failure> {
        self.over().map_or(Ok(()), |end| Err(Failure::End(end)))
    }

    /// Ends a way that would go on after the time that it has.
    fn refuse_late(&self) -> Result<(), Failure> {
        match (self.accuracy.limits.seconds, self.seconds()) {
            (Some(most), Some(left)) if left <= 0.0 => Err(Failure::End(End::Time { most })),
            _ => Ok(()),
        }
    }

    fn refuse_too_large(&self, plan: &Plan) -> Result<(), Failure> {
        let found = self.too_large(plan);
        found.map_or(Ok(()), |end| Err(Failure::End(end)))
    }

    /// Whether rounds or time are used up.
    fn over(&self) -> Option<End> {
        let limits = &self.accuracy.limits;
        if self.rounds.len() as u64 >= u64::from(limits.rounds) {
            return Some(End::Rounds(limits.rounds));
        }
        let (most, left) = (limits.seconds?, self.seconds()?);
        // The next mesh is larger than the last one.
        let last = self.rounds.last().map_or(0.0, |round| round.seconds);
        (last > left).then_some(End::Time { most })
    }

    /// Limits of the mesh: a cell has less unknowns than there are in all.
    fn of_mesh(&self) -> Limits {
        let most = self.accuracy.limits.unknowns;
        let most = most.map(|most| usize::try_from(most).unwrap_or(usize::MAX));
        Limits {
            cells: most.map_or(Limits::default().cells, |most| most.saturating_mul(4)),
            bytes: self.accuracy.limits.bytes.unwrap_or(u64::MAX),
        }
    }

    /// A mesh that was not made.
    fn refused(&self, error: RefinementError) -> Failure {
        let limits = &self.accuracy.limits;
        let end = match error {
            RefinementError::TooManyCells { limit } => End::Unknowns {
                needed: None,
                most: limits.unknowns.unwrap_or(limit as u64),
            },
            RefinementError::TooMuchMemory { limit } => End::Memory {
                needed: None,
                most: limit,
            },
            RefinementError::NoSuchCell { .. } | RefinementError::NoMesh(_) => {
                return Failure::Error(error.into());
            }
        };
        Failure::End(end)
    }

    /// Whether a plan passes a limit.
    fn too_large(&self, plan: &Plan) -> Option<End> {
        let limits = &self.accuracy.limits;
        let (needed, bytes) = (unknowns(plan), plan.first_bytes());
        if let Some(most) = limits.unknowns.filter(|most| needed > *most) {
            let needed = Some(needed);
            return Some(End::Unknowns { needed, most });
        }
        let most = limits.bytes.filter(|most| bytes > *most)?;
        Some(End::Memory {
            needed: Some(bytes),
            most,
        })
    }
}
