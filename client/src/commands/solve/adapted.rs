//! Meshes that are refined until goals are known as well as the scene asks (`[accuracy]`).
//!
//! The rounds are solved in this process; the last mesh is then that of the run, which gives all
//! increments and fields on it.

use std::collections::BTreeMap;
use std::sync::Arc;

use signorini::adapted::{
    Accuracy, AccuracyLimits, Adapted, AdaptionError, GoalRound, Problem, Round, Target, Watch,
    adapt,
};
use signorini::scene::{Scene, SceneError, Step};
use signorini::{CancelToken, GoalError, Mesh, PrepareError};
use signorini_client::WireMesh;
use signorini_client::formats::mesh::MeshFile;
use signorini_client::result_line;
use signorini_proto::v1;
use tokio::sync::mpsc;

use super::Known;
use super::accuracy::with_axis;
use crate::arguments::input::Input;
use crate::commands::Interrupts;
use crate::commands::library_mesh::{mesh, mesh_file};
use crate::report::record::Record;
use crate::terminal::exit::{Exit, Failure, panicked};

/// Lets the mesh of `input` be one on which the goals are known as well as its scene asks; tells
/// `record` of each mesh.
pub(super) async fn refine(input: &mut Input, record: &mut Record) -> Result<Known, Failure> {
    let Some(accuracy) = asked(&mut input.scene)? else {
        return Ok(Known::Enough);
    };
    let surfaces = input.surfaces.iter().map(|(_, surface)| surface.clone());
    let uploads = surfaces.map(|surface| surface.requests().collect());
    let read = signorini_server::scene_and_steps(input.scene.clone(), uploads.collect());
    let (scene, steps) = read.map_err(|error| refused(&error))?;
    let first = Arc::new(mesh(&input.mesh).map_err(|failure| failure.about(&input.mesh_path))?);
    let loading = Loading {
        scene,
        steps,
        mesh: first,
        accuracy,
    };
    let adapted = rounds(loading, record).await?;
    take_over(&adapted, input)?;
    record.refined(adapted.end.name(), &adapted.end.to_string());
    Ok(if adapted.end.is_reached() {
        Known::Enough
    } else {
        Known::LessWell
    })
}

/// What a scene asks for; the errors of its goals are told with the results, too.
fn asked(scene: &mut v1::Scene) -> Result<Option<Accuracy>, Failure> {
    let targets = scene.accuracy.iter_mut();
    let targets = targets.flat_map(|accuracy| std::mem::take(&mut accuracy.targets));
    let targets: Vec<v1::AccuracyTarget> = targets.collect();
    let mut named = Vec::new();
    for target in targets {
        named.push((with_axis(scene, &target.goal)?, target.tolerance));
    }
    let Some(message) = scene.accuracy.as_mut().filter(|_| !named.is_empty()) else {
        return Ok(None);
    };
    let limits = AccuracyLimits {
        unknowns: message.max_unknowns.take().map(i64::unsigned_abs),
        bytes: message.max_memory.take().map(i64::unsigned_abs),
        seconds: message.max_time.take(),
        rounds: message
            .max_rounds
            .take()
            .map_or(AccuracyLimits::default().rounds, i32::unsigned_abs),
    };
    let mut all = Vec::new();
    for (text, tolerance) in named {
        let goal = text.parse();
        let goal =
            goal.map_err(|error| Failure::new(Exit::Invalid, format!("accuracy: {error}")))?;
        if !message.bound.contains(&text) {
            message.bound.push(text);
        }
        all.push(Target { goal, tolerance });
    }
    Ok(Some(Accuracy {
        targets: all,
        limits,
    }))
}

/// What the rounds begin with.
struct Loading {
    scene: Scene,
    steps: Vec<Step>,
    mesh: Arc<Mesh>,
    accuracy: Accuracy,
}

impl Loading {
    /// All rounds, on this thread.
    fn solve(
        &self,
        cancel: &CancelToken,
        told: &mpsc::UnboundedSender<Round>,
    ) -> Result<Adapted, AdaptionError> {
        let problem = Problem {
            scene: &self.scene,
            steps: &self.steps,
            mesh: &self.mesh,
        };
        let watch = Watch {
            // Nobody listens once the command has ended.
            rounds: &mut |round| drop(told.send(round.clone())),
            cancel,
        };
        adapt(problem, &self.accuracy, watch)
    }
}

/// The rounds on a thread of their own, told as they come; the first interrupt stops them.
async fn rounds(loading: Loading, record: &mut Record) -> Result<Adapted, Failure> {
    let (told, mut rounds) = mpsc::unbounded_channel();
    let cancel = CancelToken::new();
    let of_work = cancel.clone();
    let work = tokio::task::spawn_blocking(move || loading.solve(&of_work, &told));
    let (mut interrupts, mut is_stopping) = (Interrupts::new()?, false);
    record.progress.phase("solving on the first mesh");
    loop {
        tokio::select! {
            round = rounds.recv() => match round {
                Some(round) => record.round(line(&round)),
                None => break,
            },
            () = interrupts.next() => {
                if std::mem::replace(&mut is_stopping, true) {
                    record.progress.clear();
                    std::process::exit(Exit::Interrupted as i32);
                }
                record.progress.note("stopping; press Ctrl-C again to quit at once");
                cancel.cancel();
            }
        }
    }
    let adapted = work.await.map_err(|error| panicked(&error))?;
    adapted.map_err(|error| failed(&error))
}

/// Lets the run go on with the last mesh.
fn take_over(adapted: &Adapted, input: &mut Input) -> Result<(), Failure> {
    input.mesh = MeshFile {
        warnings: std::mem::take(&mut input.mesh.warnings),
        ..mesh_file(adapted.hierarchy.mesh())
    };
    input.wire = WireMesh::new(&input.mesh)?;
    input.scene.mesh = input.wire.name();
    for obstacle in &mut input.scene.obstacles {
        if obstacle.surface() == v1::SurfaceGeometry::Smooth {
            // Arcs that were fitted belong to the mesh now.
            obstacle.surface = v1::SurfaceGeometry::AsMeshed.into();
        }
    }
    Ok(())
}

fn line(round: &Round) -> result_line::Round {
    let goal = |goal: &GoalRound| {
        let told = result_line::RoundGoal {
            value: goal.value,
            bound: goal.bound,
            estimate: goal.estimate,
            geometry: goal.geometry,
            tolerance: goal.tolerance,
        };
        (goal.goal.clone(), told)
    };
    result_line::Round {
        round: round.round,
        cells: round.cells,
        unknowns: round.unknowns,
        seconds: round.seconds,
        dual_seconds: round.dual_seconds,
        goals: round.goals.iter().map(goal).collect::<BTreeMap<_, _>>(),
        end: None,
        why: None,
    }
}

fn refused(error: &SceneError) -> Failure {
    Failure::new(Exit::Invalid, error.to_string())
}

/// Why there are no rounds.
fn failed(error: &AdaptionError) -> Failure {
    let exit = match error {
        AdaptionError::NotConverged { .. } => Exit::NotConverged,
        AdaptionError::Stopped(_)
        | AdaptionError::Prepare(PrepareError::Stopped(_))
        | AdaptionError::Goal(GoalError::Stopped(_)) => Exit::Interrupted,
        AdaptionError::Scene(_)
        | AdaptionError::Malformed(_)
        | AdaptionError::Prepare(_)
        | AdaptionError::Goal(_)
        | AdaptionError::Refinement(_)
        | AdaptionError::NotCarried(_)
        | _ => Exit::Invalid,
    };
    Failure::new(exit, error.to_string())
}
