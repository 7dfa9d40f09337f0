//! What the live page shows: who may look, and the figures of the moment.
//!
//! Each look asks the actors, which never compute, so that none waits for a solve; nothing is
//! gathered while nobody looks. At most [`MOST_SHOWN`] sessions with shortened texts, some
//! 600 KiB; one look at a time, in [`PATIENCE`] at most.

use std::sync::Arc;
use std::time::{Duration, SystemTime};

use hyper::StatusCode;
use hyper::header::{self, HeaderMap, HeaderValue, InvalidHeaderValue};
use signorini_proto::v1 as wire;
use signorini_proto::words;
use tokio::sync::Mutex;
use tokio::time::{Instant, timeout_at};

use crate::door::access::{Access, Caller};
use crate::process::limits;
use crate::registry::Registry;
use crate::session::{self, Glance, Services};
use crate::watch::live::{self, Live, LiveFile};
use crate::watch::page::Answer;

/// Sessions on the page.
const MOST_SHOWN: usize = 100;
/// Sessions that are looked at to find those that run.
const MOST_ASKED: usize = 1000;
/// Characters of one text of a client.
const LONGEST_TEXT: usize = 300;
/// After which a look goes without those who have not answered.
const PATIENCE: Duration = Duration::from_secs(1);

/// The live page of a server.
pub(crate) struct LivePage {
    file: Arc<LiveFile>,
    access: Access,
    /// Whether a private socket alone says who comes in.
    is_private: bool,
    limit: Option<u64>,
    /// Held by the one look that is under way.
    turn: Mutex<()>,
    services: Arc<Services>,
    registry: Arc<Registry>,
}

impl LivePage {
    pub(crate) fn new(
        services: &Arc<Services>,
        registry: &Arc<Registry>,
        access: &Access,
    ) -> Result<Arc<Self>, InvalidHeaderValue> {
        Ok(Arc::new(Self {
            file: LiveFile::new()?,
            is_private: services.config.is_private() && !access.asks(),
            access: access.clone(),
            limit: limits::memory_bytes(),
            turn: Mutex::default(),
            services: Arc::clone(services),
            registry: Arc::clone(registry),
        }))
    }

    /// The page itself, which holds nothing of the server.
    pub(crate) fn page(&self) -> Answer {
        self.file.page()
    }

    /// Its data, for those who may look.
    pub(crate) async fn data(&self, headers: &HeaderMap) -> Answer {
        let caller = match self.caller(headers) {
            Ok(caller) => caller,
            Err(refusal) => return refusal,
        };
        let _turn = self.turn.lock().await;
        self.file.data(&self.look(&caller).await)
    }

    /// Who looks. Names of sessions are told to those alone who could list them at the service.
    fn caller(&self, headers: &HeaderMap) -> Result<Caller, Answer> {
        if self.is_private {
            let why = "the service is at a private socket, this page is open to all users of the \
                       machine: set `tokens` and show one here, or ask `signorini session list`\n";
            return Err(Answer::plain(StatusCode::FORBIDDEN, why.to_owned()));
        }
        if !self.access.asks() && !live::is_called_by_address(headers) {
            let why = "call this page by an address, as 127.0.0.1, or set `tokens`\n";
            return Err(Answer::plain(StatusCode::FORBIDDEN, why.to_owned()));
        }
        self.access.reader(headers).map_err(|fault| {
            self.registry.refused(&fault);
            let mut refusal = Answer::plain(StatusCode::UNAUTHORIZED, format!("{fault}\n"));
            let scheme = HeaderValue::from_static("Bearer");
            refusal.headers.insert(header::WWW_AUTHENTICATE, scheme);
            refusal
        })
    }

    async fn look(&self, caller: &Caller) -> Live {
        let (sessions, left_out) = self.sessions(caller).await;
        let load = self.services.solvers.load();
        Live {
            version: env!("CARGO_PKG_VERSION"),
            takes_work: self.registry.check_open().is_ok(),
            slots: live::Slots {
                count: load.slots,
                busy: load.busy,
                waiting: load.waiting,
            },
            memory: self.memory(),
            sessions,
            left_out,
        }
    }

    fn memory(&self) -> live::Memory {
        let store = &self.services.store;
        let held = store.held();
        live::Memory {
            process_bytes: metrics_process::collector::collect().resident_memory_bytes,
            limit_bytes: self.limit,
            budget_bytes: store.budget(),
            meshes: held.meshes,
            mesh_bytes: held.mesh_bytes,
            prepared: held.prepared,
            prepared_bytes: held.prepared_bytes,
            session_bytes: held.session_bytes,
        }
    }

    /// The sessions that `caller` may see, those that run first, and how many are left out.
    async fn sessions(&self, caller: &Caller) -> (Vec<live::Session>, usize) {
        let end = Instant::now() + PATIENCE;
        let awake = self.registry.list(caller, "", MOST_ASKED);
        let asleep = self.registry.list_asleep(caller, "", MOST_ASKED);
        let count = awake.len() + asleep.len();
        let mut glances = Vec::with_capacity(awake.len());
        for (_, handle) in &awake {
            // One that ends meanwhile, or does not answer, is left out.
            if let Ok(Ok(glance)) = timeout_at(end, handle.glance()).await {
                glances.push(glance);
            }
        }
        glances.sort_by_key(|glance| glance.runs.is_none());
        let now = SystemTime::now();
        let shown = glances.iter().map(|glance| of_glance(glance, now));
        let shown = shown.chain(asleep.iter().map(|one| described(one, now)));
        let shown: Vec<_> = shown.take(MOST_SHOWN).collect();
        let left_out = count - shown.len();
        (shown, left_out)
    }
}

fn of_glance(glance: &Glance, now: SystemTime) -> live::Session {
    live::Session {
        waiting: glance.waiting,
        runs: glance.runs.as_ref().map(runs),
        latest: glance.latest.as_ref().map(latest),
        ..described(&glance.session, now)
    }
}

fn described(session: &wire::Session, now: SystemTime) -> live::Session {
    let created = session.create_time.map(SystemTime::try_from);
    let age = created.and_then(|created| now.duration_since(created.ok()?).ok());
    let failure = session.failure.as_ref();
    live::Session {
        name: short(&session.name),
        scene: short(&session.scene_name),
        mesh: short(&session.mesh),
        state: state(session.state()),
        age_seconds: age.unwrap_or_default().as_secs_f64(),
        attached: session.attached,
        watchers: session.watcher_count,
        memory_bytes: session.memory_bytes,
        prepared_bytes: session.prepared_memory_bytes,
        prepared_reused: session.prepared_reused,
        accepted: session.last_accepted_sequence,
        finished: session.last_finished_sequence,
        failure: failure.map(|why| short(&why.message)),
        ..live::Session::default()
    }
}

fn runs(runs: &session::Runs) -> live::Runs {
    live::Runs {
        sequence: runs.sequence,
        increments: runs.increments,
        done: runs.done,
        iteration: runs.iteration.as_ref().map(iteration),
    }
}

fn iteration(report: &wire::IterationReport) -> live::Iteration {
    let residuals = report.residuals.unwrap_or_default();
    live::Iteration {
        step: report.step,
        increment: report.increment,
        cut_backs: report.attempt,
        load: report.load,
        sqp_iteration: report.sqp_iteration,
        krylov_iterations: report.krylov_iterations,
        preconditioner_applications: report.preconditioner_applications,
        active_vertices: report.active_vertices,
        seconds: report.seconds,
        residuals: live::Residuals {
            equilibrium: residuals.equilibrium,
            incompressibility: residuals.incompressibility,
            complementarity: residuals.complementarity,
            gap: residuals.gap,
        },
    }
}

fn latest(latest: &session::Latest) -> live::Latest {
    let warnings = latest.warnings.iter().map(|one| live::Warning {
        kind: short(&one.kind),
        subject: short(&one.subject),
        message: short(&one.message),
    });
    live::Latest {
        step: latest.step,
        increment: latest.increment,
        load: latest.load,
        termination: words::termination(latest.termination),
        cause: words::cause(latest.cause),
        warnings: warnings.collect(),
    }
}

/// The word of a state, such as `running`.
fn state(state: wire::SessionState) -> String {
    let name = state.as_str_name();
    let word = name.strip_prefix("SESSION_STATE_").unwrap_or(name);
    word.to_ascii_lowercase()
}

fn short(text: &str) -> String {
    text.chars().take(LONGEST_TEXT).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_of_clients_are_cut_at_a_character() {
        let long = "\u{e9}".repeat(LONGEST_TEXT + 1);
        assert_eq!(short(&long).chars().count(), LONGEST_TEXT);
        assert_eq!(short("ring"), "ring");
    }

    #[test]
    fn states_are_words() {
        assert_eq!(state(wire::SessionState::Running), "running");
    }
}
