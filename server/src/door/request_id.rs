//! The identifier of a call, by which its lines in the log are found: the client's
//! `x-request-id` where that has one, else one of the server; the answer carries it back.

use std::hash::{BuildHasher as _, Hasher as _, RandomState};
use std::sync::Arc;

use tonic::codegen::http::{Extensions, HeaderName, HeaderValue};
use tracing::Instrument as _;

use super::layer::{Answer, AroundCall, Reply, Request};

const HEADER: HeaderName = HeaderName::from_static("x-request-id");
/// Of an identifier that a client chooses.
const LONGEST: usize = 64;

/// Identifies one call; clones are the same call.
#[derive(Clone, Debug)]
pub(crate) struct RequestId(Arc<str>);

impl RequestId {
    /// That of a request which has passed [`IdentifyCalls`].
    pub(crate) fn of(extensions: &Extensions) -> Self {
        let found = extensions.get::<Self>();
        found.map_or_else(Self::new, Clone::clone)
    }

    pub(crate) fn as_str(&self) -> &str {
        &self.0
    }

    fn new() -> Self {
        // Random keys of the standard hasher: enough to tell calls apart.
        let number = RandomState::new().build_hasher().finish();
        Self(format!("{number:016x}").into())
    }

    /// What a client chose, if a log can bear it.
    fn chosen(header: &HeaderValue) -> Option<Self> {
        let text = header.to_str().ok()?;
        let is_fit = (1..=LONGEST).contains(&text.len());
        let is_fit = is_fit && text.bytes().all(|byte| byte.is_ascii_graphic());
        is_fit.then(|| Self(text.into()))
    }
}

/// Gives each call its identifier.
#[derive(Clone)]
pub(crate) struct IdentifyCalls;

impl AroundCall for IdentifyCalls {
    fn call<F: Reply>(&self, mut request: Request, inner: impl FnOnce(Request) -> F) -> Answer {
        let chosen = request.headers().get(HEADER).and_then(RequestId::chosen);
        let id = chosen.unwrap_or_else(RequestId::new);
        request.extensions_mut().insert(id.clone());
        let span = tracing::info_span!("call", request = id.as_str());
        let answer = span.in_scope(|| inner(request));
        let answer = async move {
            let mut response = answer.await?;
            if let Ok(value) = HeaderValue::from_str(id.as_str()) {
                response.headers_mut().insert(HEADER, value);
            }
            Ok(response)
        };
        Box::pin(answer.instrument(span))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chosen(bytes: &[u8]) -> Option<String> {
        let header = HeaderValue::from_bytes(bytes).unwrap();
        RequestId::chosen(&header).map(|id| id.as_str().to_owned())
    }

    #[test]
    fn only_short_printable_identifiers_of_clients_are_taken() {
        assert_eq!(chosen(b"cell-7/42").as_deref(), Some("cell-7/42"));
        let longest = "x".repeat(LONGEST);
        assert_eq!(chosen(longest.as_bytes()), Some(longest.clone()));
        for bad in [
            &b""[..],
            b"a b",
            b"caf\xc3\xa9",
            b"tab\tbed",
            format!("{longest}x").as_bytes(),
        ] {
            assert_eq!(chosen(bad), None, "{bad:?}");
        }
    }

    #[test]
    fn identifiers_of_the_server_differ_and_are_fit() {
        let (one, other) = (RequestId::new(), RequestId::new());
        assert_ne!(one.as_str(), other.as_str());
        assert_eq!(
            chosen(one.as_str().as_bytes()).as_deref(),
            Some(one.as_str())
        );
    }
}
