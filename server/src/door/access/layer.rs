//! The layer that asks each call who it is, before a message of it is read.

use std::sync::Arc;
use std::time::Instant;

use bytes::Bytes;
use http_body_util::BodyExt as _;
use hyper::body::Frame;
use tonic::Status;
use tonic::body::Body;
use tonic::codegen::http;

use super::audit::{Line, Who};
use super::table::{Effect, Need, rule};
use super::{Access, CallRates, Caller, Entry, Role, TokenFile};
use crate::door::client_key::{ClientIdentity, Peer};
use crate::door::client_name::ClientName;
use crate::door::layer::{Answer, AroundCall, Reply, Request, Response};
use crate::door::refusal;
use crate::door::request_id::RequestId;
use crate::fault::Fault;
use crate::watch::lines::Whose;
use crate::watch::metrics::Metrics;

const SCHEME: &str = "bearer ";

/// Lets only the right callers reach the services.
#[derive(Clone)]
pub(crate) struct Authorize {
    pub(crate) access: Access,
    pub(crate) rates: Arc<CallRates>,
    pub(crate) metrics: Arc<Metrics>,
}

impl AroundCall for Authorize {
    fn call<F: Reply>(&self, mut request: Request, inner: impl FnOnce(Request) -> F) -> Answer {
        if !is_grpc(request.headers()) {
            let mut refusal = http::Response::new(Body::default());
            *refusal.status_mut() = http::StatusCode::UNSUPPORTED_MEDIA_TYPE;
            return Box::pin(async move { Ok(refusal) });
        }
        let path = request.uri().path().to_owned();
        let (_, need, effect) = rule(&path);
        let admitted = self.admit(&mut request, need);
        let peer = request.extensions().get::<Peer>().copied();
        let client = peer.unwrap_or(Peer::UNKNOWN).client;
        let who = Who {
            id: RequestId::of(request.extensions()),
            client,
            caller: admitted
                .as_ref()
                .map_or_else(|_| Caller::nobody(), Clone::clone),
        };
        let line = || (effect == Effect::Changes).then(|| Line::new(who.clone(), &path));
        if let Err(fault) = admitted {
            let (refusal, is_told) = self.refuse(fault, client.identity);
            let line = if is_told { line() } else { None };
            return Box::pin(async move { Ok(audited(refusal, line)) });
        }
        let line = line();
        request.extensions_mut().insert(who);
        let answer = inner(request);
        Box::pin(async move { Ok(audited(answer.await?, line)) })
    }
}

impl Authorize {
    /// The caller of a request, which the request carries on; its share of the server is
    /// that of its name.
    fn admit(&self, request: &mut Request, need: Need) -> Result<Caller, Fault> {
        let caller = match (&self.access.tokens, need) {
            (None, _) => Caller::anybody(),
            (Some(_), Need::Nothing) => Caller::nobody(),
            (Some(tokens), Need::Role(needed)) => {
                let tokens = tokens.sender.subscribe();
                let found = entry(&tokens.borrow(), request);
                let entry = found.or_else(|fault| {
                    // Where it comes from is all that is known of it.
                    self.count(request)?;
                    Err(fault)
                })?;
                // Before the role is looked at: a refusal has a name, too.
                name(request, entry.name());
                check_role(&entry, needed)?;
                Caller::known(entry, tokens)
            }
        };
        if matches!(need, Need::Role(_)) {
            self.count(request)?;
        }
        request.extensions_mut().insert(caller.clone());
        Ok(caller)
    }

    /// Counts a call against the rate of its client.
    fn count(&self, request: &Request) -> Result<(), Fault> {
        let peer = request.extensions().get::<Peer>();
        let client = peer.unwrap_or(&Peer::UNKNOWN).client.identity;
        self.rates.count(client, Instant::now())
    }

    /// The refusal of a call, and whether the log says it: that of a stranger where it has room,
    /// that of a name always in its audit line.
    fn refuse(&self, fault: Fault, client: ClientIdentity) -> (Response, bool) {
        let is_named = matches!(client, ClientIdentity::Named(_));
        let is_stranger = self.access.asks() && !is_named;
        let whose = if is_stranger {
            Whose::Strangers
        } else {
            Whose::Clients
        };
        let is_told = refusal::record_of(whose, &self.metrics, &fault);
        (Status::from(fault).into_http(), is_told || !is_stranger)
    }
}

impl Access {
    /// Who looks, by plain HTTP, at what [`Role::Read`] may see: the bearer of a token, or
    /// anybody where nobody is asked.
    ///
    /// # Errors
    /// `Unauthenticated` without a token of the file.
    pub(crate) fn reader(&self, headers: &http::HeaderMap) -> Result<Caller, Fault> {
        let Some(tokens) = &self.tokens else {
            return Ok(Caller::anybody());
        };
        let tokens = tokens.sender.subscribe();
        let shown = headers.get(http::header::AUTHORIZATION).and_then(token);
        let found = shown.and_then(|token| tokens.borrow().of_token(token).cloned());
        let entry = found.ok_or(Fault::Unauthenticated)?;
        check_role(&entry, Role::Read)?;
        Ok(Caller::known(entry, tokens))
    }

    /// Whether callers have to prove who they are.
    pub(crate) fn asks(&self) -> bool {
        self.tokens.is_some()
    }
}

/// Refuses an entry whose role is below what is needed.
fn check_role(entry: &Entry, needed: Role) -> Result<(), Fault> {
    if entry.role() < needed {
        let (role, needed) = (entry.role().name(), needed.name());
        return Err(Fault::PermissionDenied { role, needed });
    }
    Ok(())
}

/// Whether a request is a call: `application/grpc`, with a kind of messages or parameters after
/// it or not (gRPC over HTTP/2). Pages of browsers post other types.
fn is_grpc(headers: &http::HeaderMap) -> bool {
    let kind = headers.get(http::header::CONTENT_TYPE);
    let kind = kind.and_then(|kind| kind.to_str().ok()).unwrap_or_default();
    let rest = kind.strip_prefix("application/grpc");
    rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(['+', ';']))
}

/// Gives the share of a name to a request that has proved it.
fn name(request: &mut Request, name: ClientName) {
    if let Some(peer) = request.extensions_mut().get_mut::<Peer>() {
        peer.client.identity = ClientIdentity::Named(name);
    }
}

/// The entry that a request proves: by its token, or without one by the certificate of its
/// connection.
fn entry(tokens: &TokenFile, request: &Request) -> Result<Entry, Fault> {
    let headers = request.headers();
    let found = match headers.get(http::header::AUTHORIZATION) {
        Some(header) => token(header).and_then(|token| tokens.of_token(token)),
        None => {
            let peer = request.extensions().get::<Peer>();
            let name = peer.and_then(|peer| peer.certificate);
            name.and_then(|name| tokens.of_certificate(name))
        }
    };
    found.cloned().ok_or(Fault::Unauthenticated)
}

/// The token of `Bearer TOKEN`; the scheme in letters of any case (RFC 9110, 11.1).
fn token(header: &http::HeaderValue) -> Option<&str> {
    let (scheme, token) = header.to_str().ok()?.split_at_checked(SCHEME.len())?;
    let is_bearer = scheme.eq_ignore_ascii_case(SCHEME);
    is_bearer.then(|| token.trim_start_matches(' '))
}

/// The response, which takes its line along until the outcome is seen.
fn audited(response: Response, line: Option<Line>) -> Response {
    let Some(mut line) = line else {
        return response;
    };
    line.see(response.headers());
    let see = move |frame: Frame<Bytes>| {
        if let Some(trailers) = frame.trailers_ref() {
            line.see(trailers);
        }
        frame
    };
    response.map(|body| Body::new(body.map_frame(see)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_grpc_is_a_call() {
        let asked = |kind: &'static str| {
            let kind = http::HeaderValue::from_static(kind);
            is_grpc(&[(http::header::CONTENT_TYPE, kind)].into_iter().collect())
        };
        for good in [
            "application/grpc",
            "application/grpc+proto",
            "application/grpc;x=y",
        ] {
            assert!(asked(good), "{good}");
        }
        for bad in ["", "text/html", "application/json", "application/grpc-web"] {
            assert!(!asked(bad), "{bad}");
        }
        assert!(!is_grpc(&http::HeaderMap::new()));
    }

    #[test]
    fn only_a_bearer_has_a_token() {
        let read = |text: &str| {
            let header = http::HeaderValue::from_bytes(text.as_bytes()).unwrap();
            token(&header).map(str::to_owned)
        };
        for good in ["Bearer abc", "bearer abc", "BEARER   abc"] {
            assert_eq!(read(good).as_deref(), Some("abc"), "{good}");
        }
        for bad in [
            "",
            "abc",
            "Bearer",
            "Basic abc",
            "Bearerabc",
            "Bearer\u{e9} abc",
        ] {
            assert_eq!(read(bad), None, "{bad}");
        }
    }

    #[test]
    fn no_bytes_of_a_header_make_a_token_of_another() {
        let mut random = fastrand::Rng::with_seed(5);
        for _ in 0..5000 {
            let bytes: Vec<u8> = (0..random.usize(..40)).map(|_| random.u8(..)).collect();
            let Ok(header) = http::HeaderValue::from_bytes(&bytes) else {
                continue;
            };
            if let Some(token) = token(&header) {
                assert!(bytes.ends_with(token.as_bytes()));
            }
        }
    }
}
