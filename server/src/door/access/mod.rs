//! Who may do what: transport security, tokens with roles, and whom things belong to.
//!
//! Without a token file nobody is asked: the socket's own permissions, or loopback, say who comes
//! in. With one every call proves a name, by a bearer token or by its connection's certificate;
//! `table` says which role each method needs, `layer` asks before a message is read and writes one
//! audit line for each call that changes something. A name sees its own sessions and uploads,
//! an administrator all. `reload` takes up changed files while the server runs.

mod audit;
mod caller;
mod files;
mod layer;
mod modes;
mod owners;
mod rate;
mod reload;
mod role;
mod table;
mod tls;
mod tokens;
mod validity;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use tokio::sync::watch;

use crate::config::Config;
use crate::watch::metrics::Metrics;
pub(crate) use audit::Who;
pub(crate) use caller::Caller;
pub(crate) use layer::Authorize;
pub(crate) use modes::loose;
pub(crate) use owners::Owners;
pub(crate) use rate::CallRates;
pub(crate) use reload::watch as watch_files;
pub use role::Role;
pub(crate) use tls::{Certificates, common_name};
pub use tokens::{Entry, NewToken, TokenFile};
pub use validity::{CertificateEnd, certificate_ends, certificate_names};

/// A file of tokens or certificates that cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("{path}: {why}")]
pub struct AccessError {
    path: String,
    why: String,
}

impl AccessError {
    fn new(path: &Path, why: impl ToString) -> Self {
        Self {
            path: path.display().to_string(),
            why: why.to_string(),
        }
    }
}

/// The token file, as it was read last.
struct Tokens {
    file: PathBuf,
    sender: watch::Sender<Arc<TokenFile>>,
}

/// What the settings say about who comes in, as of the last look at the files.
#[derive(Clone)]
pub(crate) struct Access {
    /// None where nobody is asked.
    tokens: Option<Arc<Tokens>>,
    /// None where the transport is open.
    certificates: Option<Arc<Certificates>>,
}

impl Access {
    /// Reads the files that `config` names.
    ///
    /// # Errors
    /// [`AccessError`] for the first that cannot be used.
    pub(crate) fn open(config: &Config) -> Result<Self, AccessError> {
        let read = |file: &Path| {
            let sender = watch::Sender::new(Arc::new(TokenFile::read(file)?));
            let file = file.to_owned();
            Ok(Arc::new(Tokens { file, sender }))
        };
        let certificates = |files| Certificates::read(files).map(Arc::new);
        Ok(Self {
            tokens: config.token_file().map(read).transpose()?,
            certificates: config.tls_files().map(certificates).transpose()?,
        })
    }

    /// Tells operators how long the certificates are good for.
    pub(crate) fn tell_ends(&self, metrics: &Metrics) {
        let Some(certificates) = &self.certificates else {
            return;
        };
        // One that cannot be read was told of where it was read.
        for found in certificates.ends().unwrap_or_default() {
            metrics.certificate_expiry(found.certificate, found.end);
            let (path, days) = (found.path.display().to_string(), found.days_left());
            if found.is_near() {
                tracing::warn!(
                    path,
                    days,
                    "a certificate ends soon: `signorini certs init` renews it"
                );
            } else {
                tracing::info!(path, days, "days that a certificate is good for");
            }
        }
    }

    pub(crate) fn certificates(&self) -> Option<Arc<Certificates>> {
        self.certificates.clone()
    }
}
