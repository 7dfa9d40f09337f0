//! Puts the parts together, serves until told to stop, then drains.
//!
//! Shutdown: health says NOT_SERVING, new work is refused, running steps are
//! cancelled and their last good states delivered, streams end, threads join.
//! `upkeep` is what a server does by itself meanwhile, `live` what it shows of that.

mod live;
mod upkeep;

use std::future::Future;
use std::io;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use signorini::assembly::simd::InstructionSet;
use signorini_proto::FILE_DESCRIPTOR_SET;
use signorini_proto::v1::mesh_service_server::MeshServiceServer;
use signorini_proto::v1::session_service_server::SessionServiceServer;
use signorini_proto::v1::surface_service_server::SurfaceServiceServer;
use tokio::sync::oneshot;
use tokio::task::JoinHandle;
use tokio::time::{Instant, timeout_at};
use tonic::transport::Server;
use tonic::transport::server::Router;
use tonic_health::ServingStatus;
use tonic_health::server::HealthReporter;
use tower::Layer as _;
use tower::layer::util::{Identity, Stack};

use crate::compute::SolverThreads;
use crate::config::{Config, ConfigError};
use crate::data::states::States;
use crate::door::accept::{self, Door, Source};
use crate::door::access::{self, Access, AccessError, Authorize, CallRates, Certificates};
use crate::door::calls::{CountCalls, Methods};
use crate::door::gates::{GateMessages, Gates, WINDOW_BYTES};
use crate::door::layer::CallLayer;
use crate::door::listen::{ListenError, Listener, Socket};
use crate::door::open_calls::BoundOpenCalls;
use crate::door::request_id::IdentifyCalls;
use crate::door::transport::GiveReasons;
use crate::door::untaken::WatchAnswers;
use crate::fleet::Fleet;
use crate::journal::{Journal, JournalError, Presence};
use crate::process::hangup::Hangups;
use crate::process::limits::MESSAGE_BYTES;
use crate::process::users;
use crate::registry::Registry;
use crate::service::mesh::Meshes;
use crate::service::session::Sessions;
use crate::service::surface::SurfaceDoor;
use crate::session::Services;
use crate::uploads::store::Store;
use crate::uploads::surfaces::Surfaces;
use crate::watch::metrics::{COMMIT, Metrics};
use crate::watch::traces::Traces;
use live::LivePage;
use upkeep::Page;

/// The layers around all services, the innermost first.
type Layers = Stack<
    CallLayer<GateMessages>,
    Stack<
        CallLayer<BoundOpenCalls>,
        Stack<
            CallLayer<Authorize>,
            Stack<
                CallLayer<CountCalls>,
                Stack<CallLayer<IdentifyCalls>, Stack<CallLayer<WatchAnswers>, Identity>>,
            >,
        >,
    >,
>;

const CONNECTION_WINDOW_BYTES: u32 = 4 << 20;
/// Of one connection. A gateway that brings every watcher of a busy server opens more connections;
/// a call that is refused costs some 1.4 kB until its answer is taken: 4096 of each of 74
/// connections took 440 MB.
const STREAMS_PER_CONNECTION: u32 = 1024;
/// Of one connection, for frames that HTTP/2 forbids: each costs as much as a call, and does not
/// count among those that are open.
const RESETS_PER_CONNECTION: usize = 256;
const KEEPALIVE: Duration = Duration::from_secs(30);
const KEEPALIVE_ANSWER: Duration = Duration::from_secs(10);
/// Name in gRPC health that says SERVING as long as the process answers, also in shutdown.
const LIVENESS: &str = "liveness";
/// Connections that only watch the health service get this long to leave.
const LAST_CALL: Duration = Duration::from_secs(1);

/// Why a server could not run.
#[derive(Debug, thiserror::Error)]
pub enum ServeError {
    /// A setting is out of range.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// The system gave no threads.
    #[error("cannot start the solver threads: {0}")]
    Threads(io::Error),
    /// A part of the server that needs no input failed to start.
    #[error("cannot set up {what}: {why}")]
    Setup {
        /// The part.
        what: &'static str,
        /// Its message.
        why: String,
    },
    /// An address cannot be served.
    #[error(transparent)]
    Address(#[from] ListenError),
    /// Tokens or certificates cannot be used.
    #[error(transparent)]
    Access(#[from] AccessError),
    /// The data folder cannot be used.
    #[error(transparent)]
    Data(#[from] JournalError),
    /// The transport failed.
    #[error("the transport failed: {0}")]
    Transport(#[from] tonic::transport::Error),
}

/// Checks settings as a start does, short of taking addresses and the data folder: ranges, tokens,
/// certificates, and whether the address needs them.
///
/// # Errors
/// [`ServeError`] for the first that keeps a server from starting.
pub fn check(config: &Config) -> Result<(), ServeError> {
    config.check()?;
    Access::open(config)?;
    Ok(Listener::check(config)?)
}

/// What an operator should mend, though a server starts with it: files with secrets that others
/// may read, users that nothing tells apart.
pub fn doubts(config: &Config) -> Vec<String> {
    let mut doubts = access::loose(config);
    let asks_nobody = !config.is_private() && config.token_file().is_none();
    if asks_nobody && !users::are_told_apart() {
        let alike = "this user namespace does not tell the users of the machine apart: they are one \
                     client, with one share and one set of limits; `tokens` gives each a name, or \
                     run without `PrivateUsers=yes`, or not in a rootless container";
        doubts.push(alike.to_owned());
    }
    doubts
}

/// Serves on `listener` until `shutdown` completes; then drains and returns.
///
/// # Errors
/// [`ServeError`] when a part cannot start or the transport fails.
pub async fn serve(
    listener: Listener,
    config: Config,
    shutdown: impl Future<Output = ()>,
) -> Result<(), ServeError> {
    let signals = (shutdown, Hangups::none());
    serve_and_tell(listener, config, signals, |_| ()).await
}

/// As [`serve`], reading files of tokens and certificates again at hangups, too; `ready` gets the address once nothing is in the way of serving it.
///
/// # Errors
/// As those of [`serve`].
pub async fn serve_and_tell(
    listener: Listener,
    config: Config,
    (shutdown, hangups): (impl Future<Output = ()>, Hangups),
    ready: impl FnOnce(&str),
) -> Result<(), ServeError> {
    config.check()?;
    let drain_time = config.drain();
    let access = Access::open(&config)?;
    let services = services(config, listener.url()).await?;
    let registry = Registry::new(&services)?;
    let (health, router) = router(&services, &registry, &access).await?;
    log_start(&services, &listener);
    for doubt in doubts(&services.config) {
        tracing::warn!("{doubt}");
    }
    ready(listener.url());
    let page = Page {
        metrics: Arc::clone(&services.metrics),
        registry: Arc::clone(&registry),
        service: listener.url().into(),
        live: LivePage::new(&services, &registry, &access)
            .map_err(|error| setup("the live page", &error))?,
    };
    let mut helpers = upkeep::start(page, &services, &registry, listener.metrics);
    helpers.push(tokio::spawn(Arc::clone(&registry).keep_leases()));
    helpers.push(tokio::spawn(Arc::clone(&registry).grant_wishes()));
    let watch = upkeep::watch_folder(Arc::clone(&services), health.clone());
    helpers.push(tokio::spawn(watch));
    helpers.push(tokio::spawn(access::watch_files(
        access.clone(),
        hangups,
        Arc::clone(&services.metrics),
    )));
    let (stop, stopped) = oneshot::channel();
    let door = Door::new(&services.config, &services.metrics);
    let incoming = (listener.socket, access.certificates());
    let mut server = tokio::spawn(run(router, incoming, door, stopped));
    tokio::select! {
        ended = &mut server => {
            abort(&helpers);
            return joined(ended);
        }
        () = shutdown => {}
    }
    tracing::info!("shutting down");
    set_health(&health, ServingStatus::NotServing).await;
    // One clock for all of it: what comes first leaves something for what follows.
    let end = Instant::now() + drain_time;
    let delivered = end - LAST_CALL.min(drain_time / 4);
    if timeout_at(delivered, registry.drain()).await.is_err() {
        tracing::warn!("sessions did not stop in time");
    }
    if timeout_at(delivered, registry.streams_gone())
        .await
        .is_err()
    {
        tracing::warn!("some streams did not take their last results in time");
    }
    drop(stop);
    let left = end.saturating_duration_since(Instant::now());
    let ended = tokio::time::timeout(LAST_CALL.min(left / 2), &mut server).await;
    abort(&helpers);
    registry.close();
    close(&services, end).await;
    match ended {
        Ok(ended) => joined(ended),
        Err(_) => {
            server.abort();
            Ok(())
        }
    }
}

/// Where the server is found, what it is and what it may use.
fn log_start(services: &Services, listener: &Listener) {
    let config = &services.config;
    tracing::info!(
        url = listener.url(),
        metrics = listener.metrics_url(),
        version = env!("CARGO_PKG_VERSION"),
        commit = COMMIT,
        instruction_set = InstructionSet::of_this_machine().name(),
        slots = config.solver_slots,
        threads_per_slot = config.threads(),
        memory_budget_bytes = services.store.budget(),
        data = match config.data.as_str() {
            "" => "none: nothing outlives this server",
            folder => folder,
        },
        "serving"
    );
}

async fn services(config: Config, url: &str) -> Result<Arc<Services>, ServeError> {
    let metrics = Metrics::new().map_err(|error| setup("metrics", &error))?;
    let solvers = SolverThreads::start(config.slots(), &metrics).map_err(ServeError::Threads)?;
    // Asked once: with a limit of the address space it is less with every thread.
    let budget = config.budget();
    let gates = Gates::new(budget, config.request_time(), &metrics);
    let journal = match config.data.as_str() {
        "" => None,
        folder => {
            let store = Path::new(&config.fleet_store);
            Some(Arc::new(
                Journal::open(Path::new(folder), &metrics)?.sharing(store)?,
            ))
        }
    };
    let presence = journal
        .as_ref()
        .map(|_| Arc::new(Presence::of(Path::new(&config.data))));
    let joined = Fleet::join(&config, url, journal.as_ref(), &metrics).await;
    let fleet = joined.map_err(|why| ServeError::Setup {
        what: "the fleet",
        why,
    })?;
    Ok(Arc::new(Services {
        fleet,
        gates: gates.map_err(|error| setup("the descriptors", &error))?,
        journal,
        presence,
        store: Store::new(budget, &metrics),
        surfaces: Surfaces::default(),
        traces: Traces::start(&config.otlp_endpoint).map_err(|why| ServeError::Setup {
            what: "traces",
            why,
        })?,
        config,
        metrics,
        solvers,
    }))
}

async fn router(
    services: &Arc<Services>,
    registry: &Arc<Registry>,
    access: &Access,
) -> Result<(HealthReporter, Router<Layers>), ServeError> {
    let (health, health_service) = tonic_health::server::health_reporter();
    set_health(&health, ServingStatus::Serving).await;
    // Of the process, not of its readiness: a probe that restarts it asks for this.
    health
        .set_service_status(LIVENESS, ServingStatus::Serving)
        .await;
    let meshes = Meshes {
        services: Arc::clone(services),
        registry: Arc::clone(registry),
    };
    let sessions = Sessions {
        services: Arc::clone(services),
        registry: Arc::clone(registry),
        states: States::default(),
    };
    let surfaces = SurfaceDoor {
        services: Arc::clone(services),
        registry: Arc::clone(registry),
    };
    let surfaces = SurfaceServiceServer::new(surfaces).max_decoding_message_size(MESSAGE_BYTES);
    let meshes = MeshServiceServer::new(meshes).max_decoding_message_size(MESSAGE_BYTES);
    let sessions = SessionServiceServer::new(sessions).max_decoding_message_size(MESSAGE_BYTES);
    let reflection = || {
        tonic_reflection::server::Builder::configure()
            .register_encoded_file_descriptor_set(FILE_DESCRIPTOR_SET)
            .register_encoded_file_descriptor_set(tonic_health::pb::FILE_DESCRIPTOR_SET)
    };
    let wrong = |error| setup("reflection", &error);
    let methods = Methods::new(&services.metrics).map_err(|error| setup("metrics", &error))?;
    let config = &services.config;
    let health_service = config.health.then_some(health_service);
    let (v1, v1alpha) = if config.reflection {
        (
            Some(reflection().build_v1()),
            Some(reflection().build_v1alpha()),
        )
    } else {
        (None, None)
    };
    let (v1, v1alpha) = (
        v1.transpose().map_err(wrong)?,
        v1alpha.transpose().map_err(wrong)?,
    );
    let reasoned = CallLayer(GiveReasons(Arc::clone(&services.metrics)));
    let router = Server::builder()
        .layer(CallLayer(WatchAnswers))
        .layer(CallLayer(IdentifyCalls))
        .layer(CallLayer(CountCalls(Arc::new(methods))))
        .layer(CallLayer(Authorize {
            access: access.clone(),
            rates: Arc::new(CallRates::new(
                services.config.maximum_client_calls_per_second,
            )),
            metrics: Arc::clone(&services.metrics),
        }))
        .layer(CallLayer(BoundOpenCalls::new(&services.metrics)))
        .layer(CallLayer(GateMessages(Arc::clone(&services.gates.decode))))
        .initial_stream_window_size(WINDOW_BYTES)
        .initial_connection_window_size(CONNECTION_WINDOW_BYTES)
        .max_concurrent_streams(STREAMS_PER_CONNECTION)
        .http2_max_local_error_reset_streams(Some(RESETS_PER_CONNECTION))
        .http2_keepalive_interval(Some(KEEPALIVE))
        .http2_keepalive_timeout(Some(KEEPALIVE_ANSWER))
        .add_optional_service(health_service)
        .add_optional_service(v1)
        .add_optional_service(v1alpha)
        .add_service(reasoned.layer(meshes))
        .add_service(reasoned.layer(surfaces))
        .add_service(reasoned.layer(sessions));
    Ok((health, router))
}

async fn set_health(health: &HealthReporter, status: ServingStatus) {
    let names = ["", mesh_name(), surface_name(), session_name()];
    for name in names {
        health.set_service_status(name, status).await;
    }
}

fn mesh_name() -> &'static str {
    service_name::<MeshServiceServer<Meshes>>()
}

fn surface_name() -> &'static str {
    service_name::<SurfaceServiceServer<SurfaceDoor>>()
}

fn session_name() -> &'static str {
    service_name::<SessionServiceServer<Sessions>>()
}

fn service_name<S: tonic::server::NamedService>() -> &'static str {
    S::NAME
}

async fn run(
    router: Router<Layers>,
    (socket, certificates): (Socket, Option<Arc<Certificates>>),
    door: Arc<Door>,
    stopped: oneshot::Receiver<()>,
) -> Result<(), tonic::transport::Error> {
    let stopped = async {
        // Dropping the sender is the signal.
        let _signal = stopped.await;
    };
    let (source, _file) = match socket {
        Socket::Tcp(listener) => match certificates {
            Some(certificates) => (Source::Tls(listener, certificates), None),
            None => (Source::Tcp(listener), None),
        },
        Socket::Unix(listener, file) => (Source::Unix(listener), Some(file)),
    };
    let incoming = accept::incoming(source, door);
    router.serve_with_incoming_shutdown(incoming, stopped).await
}

fn abort(helpers: &[JoinHandle<()>]) {
    for helper in helpers {
        helper.abort();
    }
}

/// Joins the solver threads; one that cannot be interrupted is left behind, in a
/// thread that no runtime waits for.
async fn close(services: &Arc<Services>, end: Instant) {
    let services = Arc::clone(services);
    let (closed, joined) = oneshot::channel();
    let joiner = std::thread::Builder::new().spawn(move || {
        services.solvers.close();
        if let Some(journal) = &services.journal {
            journal.close();
        }
        services.traces.close();
        // Nobody waits any more when it took too long.
        let _late = closed.send(());
    });
    let joined = timeout_at(end, joined).await;
    if joiner.is_err() || joined.is_err() {
        tracing::warn!("a solver thread did not stop in time");
    }
}

fn joined(
    ended: Result<Result<(), tonic::transport::Error>, tokio::task::JoinError>,
) -> Result<(), ServeError> {
    match ended {
        Ok(outcome) => Ok(outcome?),
        Err(error) => Err(setup("the transport", &error)),
    }
}

fn setup(what: &'static str, error: &dyn std::error::Error) -> ServeError {
    ServeError::Setup {
        what,
        why: error.to_string(),
    }
}
