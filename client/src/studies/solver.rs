//! Solves one case in a session of its own on a server that is warm.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use signorini_client::formats::mesh::MeshFile;
use signorini_client::solve::{Attach, Event, Events, Increment, Solve};
use signorini_client::study::{Gathered, Wanted};
use signorini_client::{Client, ClientError, NewSession};
use signorini_proto::v1;
use tokio::sync::{Mutex, watch};

use super::row::{REFUSED, Row, told};
use crate::report::results::{DEFAULT_FIELDS, Drawings, ResultFolder};
use crate::terminal::exit::Failure;

/// No statistics of iterations are wanted.
const NEVER: Duration = Duration::from_secs(24 * 3600);

/// Whether no further case is to be begun, and those that run are to end.
pub(crate) type Stop = watch::Receiver<bool>;

/// A case as a server takes it.
pub(crate) struct Job<'a> {
    pub(crate) case: u64,
    pub(crate) id: &'a str,
    pub(crate) scene: v1::Scene,
    pub(crate) wanted: &'a [Wanted],
}

/// How the work on a case ended.
#[derive(Debug)]
pub(crate) enum End {
    /// With its row.
    Row(Row),
    /// The server does not have what the scene names.
    Missing,
    /// The server takes no further work now.
    Busy,
    /// The server, or the session, went away.
    Lost(ClientError),
    /// It was told to stop.
    Stopped,
    /// This and every other case fails.
    Fault(Failure),
}

/// Where the fields of cases go, a folder for each.
#[derive(Debug)]
pub(crate) struct Fields {
    folder: PathBuf,
    /// The mesh that was used last, by its name.
    mesh: Mutex<Option<(String, Arc<MeshFile>)>>,
}

impl Fields {
    /// Into folders of this one.
    pub(crate) fn new(folder: PathBuf) -> Self {
        let mesh = Mutex::new(None);
        Self { folder, mesh }
    }

    async fn open(
        &self,
        client: &Client,
        job: &Job<'_>,
    ) -> Result<Result<ResultFolder, Failure>, ClientError> {
        let mesh = self.mesh(client, &job.scene.mesh).await?;
        let folder = self.folder.join(Path::new(job.id));
        let drawings = Drawings::new();
        Ok(ResultFolder::new(&folder, &job.scene, (&mesh, drawings)))
    }

    async fn mesh(&self, client: &Client, name: &str) -> Result<Arc<MeshFile>, ClientError> {
        let mut last = self.mesh.lock().await;
        if let Some((known, mesh)) = &*last
            && known == name
        {
            return Ok(Arc::clone(mesh));
        }
        let mesh = Arc::new(client.read_mesh(name).await?);
        *last = Some((name.to_owned(), Arc::clone(&mesh)));
        Ok(mesh)
    }
}

/// Solves a case; its fields are on the disk when it ends with a row.
pub(crate) async fn solve(
    client: &Client,
    mut job: Job<'_>,
    fields: Option<&Fields>,
    stop: &mut Stop,
) -> End {
    complete(&mut job.scene, fields);
    let refined = tokio::select! {
        refined = client.fine_enough(job.scene.clone()) => refined,
        _ = stop.wait_for(|stop| *stop) => return End::Stopped,
    };
    match refined {
        Ok(scene) => job.scene = scene,
        Err(error) => return meaning(job.case, job.id, error),
    }
    let new = NewSession {
        scene: job.scene.clone(),
        on_disconnect: v1::DisconnectPolicy::CancelStep,
        ..Default::default()
    };
    let session = match client.create_session(new).await {
        Ok((session, _)) => session.name,
        Err(error) => return meaning(job.case, job.id, error),
    };
    let end = run(client, &session, &job, fields, stop).await;
    // What is wanted of it is here; one that is gone is no fault.
    let _gone = client.delete_session(&session).await;
    end.unwrap_or_else(|error| meaning(job.case, job.id, error))
}

fn complete(scene: &mut v1::Scene, fields: Option<&Fields>) {
    if scene.steps.is_empty() {
        scene.steps.push(v1::LoadStep::default());
    }
    let output = scene.output.get_or_insert_default();
    match fields {
        None => output.fields.clear(),
        Some(_) if output.fields.is_empty() => {
            output.fields = DEFAULT_FIELDS.map(i32::from).to_vec();
        }
        Some(_) => {}
    }
}

async fn run(
    client: &Client,
    session: &str,
    job: &Job<'_>,
    fields: Option<&Fields>,
    stop: &mut Stop,
) -> Result<End, ClientError> {
    let mut folder = match fields {
        None => None,
        Some(fields) => match fields.open(client, job).await? {
            Ok(folder) => Some(folder),
            Err(failure) => return Ok(End::Fault(failure)),
        },
    };
    let attach = Attach {
        iteration_interval: Some(NEVER),
        on_disconnect: v1::DisconnectPolicy::CancelStep,
        ..Default::default()
    };
    let Solve {
        mut updates,
        mut events,
        ..
    } = client.solve(session, attach).await?;
    let mut row = Row::without(job.case, job.id, REFUSED);
    let mut gathered = Gathered::new(job.wanted);
    for step in &job.scene.steps {
        updates.load_step(step.clone()).await?;
        loop {
            let increment = tokio::select! {
                increment = increment(&mut events) => increment?,
                _ = stop.wait_for(|stop| *stop) => return Ok(End::Stopped),
            };
            row.see(&increment.report);
            gathered.see(&increment.report);
            if let Some(folder) = &mut folder
                && let Err(failure) = folder.add(&increment)
            {
                return Ok(End::Fault(failure));
            }
            match increment.report.termination() {
                // Nobody here has asked for it: the server is going.
                v1::Termination::Cancelled => return Err(ClientError::Closed),
                v1::Termination::Converged if !increment.last => {}
                v1::Termination::Converged => break,
                v1::Termination::NotConverged
                | v1::Termination::DeadlineExceeded
                | v1::Termination::InternalError
                | v1::Termination::Unspecified => return Ok(End::Row(row)),
            }
        }
    }
    row.results = gathered.finish();
    Ok(End::Row(row))
}

/// The next result.
async fn increment(events: &mut Events) -> Result<Box<Increment>, ClientError> {
    loop {
        match events.next().await? {
            Some(Event::Increment(increment)) => return Ok(increment),
            Some(Event::Rejected { refusal, .. }) => return Err(ClientError::Refused(refusal)),
            Some(
                Event::Iteration(_)
                | Event::Heartbeat(_)
                | Event::ConnectionLost { .. }
                | Event::Reconnected { .. },
            ) => {}
            None => return Err(ClientError::Closed),
        }
    }
}

/// What an error means for a case.
pub(crate) fn meaning(case: u64, id: &str, error: ClientError) -> End {
    let Some(refusal) = error.refusal() else {
        return End::Lost(error);
    };
    match refusal.reason.as_str() {
        // What is damaged is mended by sending it again.
        "MESH_NOT_FOUND" | "SURFACE_NOT_FOUND" | "MESH_DAMAGED" | "SURFACE_DAMAGED" => End::Missing,
        "QUEUE_FULL" | "SESSION_LIMIT" | "CALL_RATE" => End::Busy,
        "UNAUTHENTICATED" | "PERMISSION_DENIED" => End::Fault(error.into()),
        "SCENE_INVALID"
        | "REQUEST_INVALID"
        | "UNSUPPORTED_COMBINATION"
        | "SESSION_FAILED"
        | "REFINEMENT_FAILED"
        | "MESSAGE_LIMIT"
        | "INTERNAL"
        | "SESSION_DAMAGED"
        | "MESH_INVALID"
        | "SURFACE_INVALID" => {
            let (reason, text) = told(&error);
            End::Row(Row::without(case, id, REFUSED).because(&reason, text))
        }
        _ => End::Lost(error),
    }
}
