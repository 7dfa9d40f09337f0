//! The live page: one static file for a browser, and the data that it reads each second while
//! somebody looks.
//!
//! It asks nothing of elsewhere, which its policy holds it to: the style and the script of the
//! file itself, by their digests (Content Security Policy, level 3), and data of its own address.
//! Names come from clients: they travel as JSON and become text, never markup. Sizes in bytes,
//! times in seconds.

use std::net::IpAddr;
use std::sync::Arc;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use bytes::Bytes;
use hyper::StatusCode;
use hyper::header::{self, HeaderMap, HeaderName, HeaderValue, InvalidHeaderValue};
use hyper::http::uri::Authority;
use serde::Serialize;
use sha2::{Digest as _, Sha256};

use super::page::Answer;

const PAGE: &str = include_str!("page.html");

/// All that the page shows.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Live {
    pub(crate) version: &'static str,
    /// False while the server shuts down.
    pub(crate) takes_work: bool,
    pub(crate) slots: Slots,
    pub(crate) memory: Memory,
    /// What runs first, then by name.
    pub(crate) sessions: Vec<Session>,
    /// Sessions that the reader may see and that are left out.
    pub(crate) left_out: usize,
}

/// The solver slots and their queue.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Slots {
    pub(crate) count: usize,
    pub(crate) busy: usize,
    /// Jobs that wait for a slot.
    pub(crate) waiting: usize,
}

/// Memory of the process, and what of it is in the budget.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Memory {
    /// Resident; absent where the system does not tell.
    pub(crate) process_bytes: Option<u64>,
    /// That the system lets the process have.
    pub(crate) limit_bytes: Option<u64>,
    pub(crate) budget_bytes: u64,
    pub(crate) meshes: usize,
    pub(crate) mesh_bytes: u64,
    /// Prepared bodies that are held.
    pub(crate) prepared: usize,
    pub(crate) prepared_bytes: u64,
    pub(crate) session_bytes: u64,
}

/// One session.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Session {
    pub(crate) name: String,
    pub(crate) scene: String,
    pub(crate) mesh: String,
    /// The word of its state, such as `running`.
    pub(crate) state: String,
    pub(crate) age_seconds: f64,
    pub(crate) attached: bool,
    pub(crate) watchers: i32,
    pub(crate) memory_bytes: i64,
    pub(crate) prepared_bytes: i64,
    /// Whether other sessions have built what it shares.
    pub(crate) prepared_reused: bool,
    /// Updates accepted and finished, and those that wait behind the current one.
    pub(crate) accepted: i64,
    pub(crate) finished: i64,
    pub(crate) waiting: usize,
    /// Why it failed.
    pub(crate) failure: Option<String>,
    pub(crate) runs: Option<Runs>,
    pub(crate) latest: Option<Latest>,
}

/// The current update of a session.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Runs {
    pub(crate) sequence: i64,
    pub(crate) increments: u32,
    pub(crate) done: u32,
    pub(crate) iteration: Option<Iteration>,
}

/// The newest iteration of an update.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Iteration {
    pub(crate) step: i32,
    pub(crate) increment: i32,
    pub(crate) cut_backs: i32,
    /// Factor of the loads of the increment.
    pub(crate) load: f64,
    pub(crate) sqp_iteration: i32,
    pub(crate) krylov_iterations: i32,
    pub(crate) preconditioner_applications: i32,
    pub(crate) active_vertices: i32,
    pub(crate) seconds: f64,
    pub(crate) residuals: Residuals,
}

/// Relative residuals.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Residuals {
    pub(crate) equilibrium: f64,
    pub(crate) incompressibility: f64,
    pub(crate) complementarity: f64,
    pub(crate) gap: f64,
}

/// The last increment that a solver finished.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Latest {
    pub(crate) step: i32,
    pub(crate) increment: i32,
    pub(crate) load: f64,
    pub(crate) termination: String,
    pub(crate) cause: Option<String>,
    pub(crate) warnings: Vec<Warning>,
}

/// A warning of a result.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Warning {
    pub(crate) kind: String,
    pub(crate) subject: String,
    pub(crate) message: String,
}

/// The file with the headers that keep it to itself.
#[derive(Clone)]
pub(crate) struct LiveFile {
    policy: HeaderValue,
}

impl LiveFile {
    /// # Errors
    /// When the policy is no header, which no file of this program makes it.
    pub(crate) fn new() -> Result<Arc<Self>, InvalidHeaderValue> {
        let policy = HeaderValue::try_from(policy())?;
        Ok(Arc::new(Self { policy }))
    }

    /// The page.
    pub(crate) fn page(&self) -> Answer {
        let kind = "text/html; charset=utf-8";
        self.answer(kind, Bytes::from_static(PAGE.as_bytes()))
    }

    /// The data of the page.
    pub(crate) fn data(&self, live: &Live) -> Answer {
        match serde_json::to_vec(live) {
            Ok(text) => self.answer("application/json", text.into()),
            Err(error) => Answer::plain(StatusCode::INTERNAL_SERVER_ERROR, format!("{error}\n")),
        }
    }

    fn answer(&self, kind: &'static str, body: Bytes) -> Answer {
        let mut headers: HeaderMap = FIXED
            .into_iter()
            .map(|(name, value)| (name, HeaderValue::from_static(value)))
            .collect();
        headers.insert(header::CONTENT_TYPE, HeaderValue::from_static(kind));
        headers.insert(header::CONTENT_SECURITY_POLICY, self.policy.clone());
        Answer {
            status: StatusCode::OK,
            headers,
            body,
        }
    }
}

/// Nothing is kept, guessed, framed, or told to other pages.
const FIXED: [(HeaderName, &str); 5] = [
    (header::CACHE_CONTROL, "no-store"),
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (header::X_FRAME_OPTIONS, "DENY"),
    (header::REFERRER_POLICY, "no-referrer"),
    (
        HeaderName::from_static("cross-origin-resource-policy"),
        "same-origin",
    ),
];

/// The policy of the page: its own style and script by their digests, data of its own address.
fn policy() -> String {
    let digest = |tag| STANDARD.encode(Sha256::digest(between(PAGE, tag)));
    format!(
        "default-src 'none'; style-src 'sha256-{}'; script-src 'sha256-{}'; connect-src 'self'; \
         img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
        digest("style"),
        digest("script")
    )
}

/// What stands in the first element of that tag.
fn between<'a>(text: &'a str, tag: &str) -> &'a str {
    let inside = text.split_once(&format!("<{tag}>"));
    let inside = inside.and_then(|(_, rest)| rest.split_once(&format!("</{tag}>")));
    inside.map_or("", |(inside, _)| inside)
}

/// Whether a request calls this machine by an address or as `localhost`. A page of elsewhere
/// whose name was made to lead here calls it by that name.
pub(crate) fn is_called_by_address(headers: &HeaderMap) -> bool {
    let host = headers
        .get(header::HOST)
        .and_then(|host| host.to_str().ok());
    let Some(host) = host.and_then(|host| host.parse::<Authority>().ok()) else {
        return false;
    };
    let name = host.host().trim_start_matches('[').trim_end_matches(']');
    name.eq_ignore_ascii_case("localhost") || name.parse::<IpAddr>().is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_is_one_file_that_asks_nothing_of_elsewhere() {
        for tag in ["style", "script"] {
            assert_eq!(PAGE.matches(&format!("<{tag}>")).count(), 1, "{tag}");
            assert!(between(PAGE, tag).len() > 100, "{tag}");
        }
        // Only the name of the vocabulary of its drawings is an address, and nobody goes there.
        let addresses = PAGE.replace("http://www.w3.org/2000/svg", "");
        for never in ["http:", "https:", "//cdn", "@import", "src=", "url("] {
            assert!(!addresses.contains(never), "{never}");
        }
        let policy = policy();
        assert!(policy.starts_with("default-src 'none'; style-src 'sha256-"));
        assert!(
            !policy.contains("unsafe") && !policy.contains('*'),
            "{policy}"
        );
    }

    #[test]
    fn names_never_become_markup() {
        for never in [
            "innerHTML",
            "outerHTML",
            "insertAdjacent",
            "document.write",
            "eval(",
        ] {
            assert!(!PAGE.contains(never), "{never}");
        }
        // Nor does an attribute of the file hold style or script, which the policy would refuse.
        for never in [" style=", " onclick=", " onload=", "javascript:"] {
            assert!(!PAGE.contains(never), "{never}");
        }
    }

    #[test]
    fn a_name_that_leads_here_is_not_this_machine() {
        let called = |host: &'static str| {
            let host = HeaderValue::from_static(host);
            is_called_by_address(&[(header::HOST, host)].into_iter().collect())
        };
        for good in [
            "127.0.0.1:9464",
            "localhost:9464",
            "LOCALHOST",
            "[::1]:9464",
        ] {
            assert!(called(good), "{good}");
        }
        for bad in [
            "evil.example:9464",
            "127.0.0.1.evil.example",
            "",
            "localhost.",
            "a b",
        ] {
            assert!(!called(bad), "{bad}");
        }
        assert!(!is_called_by_address(&HeaderMap::new()));
    }

    #[test]
    fn numbers_that_are_none_are_left_out_of_the_data() {
        let residuals = Residuals {
            gap: f64::NAN,
            ..Residuals::default()
        };
        let text = serde_json::to_string(&residuals).unwrap();
        assert!(text.ends_with("\"gap\":null}"), "{text}");
    }
}
