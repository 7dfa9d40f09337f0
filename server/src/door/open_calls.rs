//! A layer that bounds the calls which no session pays for: health, which everybody may ask who
//! reaches the address, and reflection.
//!
//! A call is open until its last byte is taken, so a client that watches health keeps some
//! kilobytes of the server for as long as it likes. There may be so many in all, of one client and of
//! one connection; the probes of an orchestrator and a client that watches the health of each of its connections
//! stay far below. `Check` has its own numbers: watchers do not keep probes out.

use std::collections::HashMap;
use std::hash::Hash;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use http_body_util::BodyExt as _;
use tonic::Status;
use tonic::body::Body;

use super::client_key::{ClientIdentity, ClientKey, Peer};
use super::layer::{Answer, AroundCall, Reply, Request};
use super::refusal;
use crate::fault::Fault;
use crate::watch::lines::Whose;
use crate::watch::metrics::Metrics;

/// Time in which the request of such a call has to be there.
const REQUEST: Duration = Duration::from_secs(10);

/// How many may be open.
#[derive(Clone, Copy, Debug)]
struct Most {
    all: usize,
    of_client: usize,
    of_connection: usize,
}

/// Some 6 kB each: 12 MB.
const STREAMS: Most = Most {
    all: 2048,
    of_client: 256,
    of_connection: 16,
};
const CHECKS: Most = Most {
    all: 4096,
    of_client: 512,
    of_connection: 64,
};

/// Open calls of one kind.
struct OpenCalls {
    /// What they are, in a refusal.
    what: &'static str,
    most: Most,
    open: Mutex<Open>,
}

#[derive(Default)]
struct Open {
    all: usize,
    clients: HashMap<ClientIdentity, usize>,
    connections: HashMap<ClientKey, usize>,
}

impl OpenCalls {
    fn new(what: &'static str, most: Most) -> Arc<Self> {
        let open = Mutex::default();
        Arc::new(Self { what, most, open })
    }

    /// Counts one more of `client` as long as the place lives.
    ///
    /// # Errors
    /// `MessageLimit` for one too many.
    fn enter(self: &Arc<Self>, client: ClientKey) -> Result<Place, Fault> {
        let mut open = self.lock();
        let of_client = open.clients.get(&client.identity).copied().unwrap_or(0);
        let of_connection = open.connections.get(&client).copied().unwrap_or(0);
        let counts = [
            ("of one connection", of_connection, self.most.of_connection),
            ("of one client", of_client, self.most.of_client),
            ("in all", open.all, self.most.all),
        ];
        if let Some((whose, _, most)) = counts.iter().find(|(_, count, most)| count >= most) {
            return Err(Fault::MessageLimit {
                what: format!("{} open at one time {whose}", self.what),
                limit: *most as u64,
            });
        }
        open.all += 1;
        open.clients.insert(client.identity, of_client + 1);
        open.connections.insert(client, of_connection + 1);
        let calls = Arc::clone(self);
        Ok(Place { calls, client })
    }

    fn lock(&self) -> MutexGuard<'_, Open> {
        self.open.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// One open call.
struct Place {
    calls: Arc<OpenCalls>,
    client: ClientKey,
}

impl Drop for Place {
    fn drop(&mut self) {
        let mut open = self.calls.lock();
        open.all -= 1;
        leave(&mut open.clients, self.client.identity);
        leave(&mut open.connections, self.client);
    }
}

fn leave<K: Eq + Hash>(counts: &mut HashMap<K, usize>, key: K) {
    if let Some(count) = counts.get_mut(&key) {
        *count -= 1;
        if *count == 0 {
            counts.remove(&key);
        }
    }
}

/// Bounds the calls of health and reflection.
#[derive(Clone)]
pub(crate) struct BoundOpenCalls {
    checks: Arc<OpenCalls>,
    watches: Arc<OpenCalls>,
    reflections: Arc<OpenCalls>,
    metrics: Arc<Metrics>,
}

impl BoundOpenCalls {
    pub(crate) fn new(metrics: &Arc<Metrics>) -> Self {
        Self {
            checks: OpenCalls::new("health checks", CHECKS),
            watches: OpenCalls::new("health watches", STREAMS),
            reflections: OpenCalls::new("reflection streams", STREAMS),
            metrics: Arc::clone(metrics),
        }
    }

    fn of(&self, path: &str) -> Option<&Arc<OpenCalls>> {
        match path {
            "/grpc.health.v1.Health/Check" => Some(&self.checks),
            "/grpc.health.v1.Health/Watch" => Some(&self.watches),
            path => path
                .starts_with("/grpc.reflection.")
                .then_some(&self.reflections),
        }
    }
}

impl AroundCall for BoundOpenCalls {
    fn call<F: Reply>(&self, request: Request, inner: impl FnOnce(Request) -> F) -> Answer {
        let Some(calls) = self.of(request.uri().path()) else {
            return Box::pin(inner(request));
        };
        let peer = request.extensions().get::<Peer>();
        let client = peer.unwrap_or(&Peer::UNKNOWN).client;
        let place = match calls.enter(client) {
            Ok(place) => place,
            Err(fault) => {
                refusal::record_of(Whose::Strangers, &self.metrics, &fault);
                return Box::pin(async move { Ok(Status::from(fault).into_http()) });
            }
        };
        let answer = tokio::time::timeout(REQUEST, inner(request));
        Box::pin(async move {
            let Ok(answer) = answer.await else {
                return Ok(Status::from(Fault::StreamDeadline).into_http());
            };
            let kept = move |frame| {
                let _open = &place;
                frame
            };
            Ok(answer?.map(|body| Body::new(body.map_frame(kept))))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::door::client_key::Strand;

    fn client(user: u32, process: i32) -> ClientKey {
        ClientKey {
            identity: ClientIdentity::User(user),
            strand: Strand::Process(process),
        }
    }

    #[test]
    fn calls_are_bounded_by_connection_by_client_and_in_all() {
        let most = Most {
            all: 5,
            of_client: 3,
            of_connection: 2,
        };
        let calls = OpenCalls::new("calls", most);
        let mut held = Vec::new();
        let mut enter = |user, process| match calls.enter(client(user, process)) {
            Ok(place) => held.push(place),
            Err(fault) => panic!("{fault}"),
        };
        enter(1, 1);
        enter(1, 1);
        let refused = calls.enter(client(1, 1)).err().unwrap().to_string();
        assert!(refused.contains("of one connection"), "{refused}");
        enter(1, 2);
        let refused = calls.enter(client(1, 3)).err().unwrap().to_string();
        assert!(refused.contains("of one client"), "{refused}");
        enter(2, 4);
        enter(2, 5);
        let refused = calls.enter(client(3, 6)).err().unwrap().to_string();
        assert!(refused.contains("in all"), "{refused}");
        held.clear();
        assert!(calls.enter(client(3, 6)).is_ok());
        let open = calls.lock();
        assert_eq!(
            (open.all, open.clients.len(), open.connections.len()),
            (0, 0, 0)
        );
    }
}
