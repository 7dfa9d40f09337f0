//! Transport security: the server's certificate and, where the settings name an authority, the
//! certificates of clients. A connection keeps what its handshake saw; the next one sees what the
//! files hold then.

use std::path::{Path, PathBuf};
use std::sync::{Arc, PoisonError, RwLock};

use tokio_rustls::rustls::crypto::ring;
use tokio_rustls::rustls::pki_types::pem::PemObject as _;
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer};
use tokio_rustls::rustls::server::WebPkiClientVerifier;
use tokio_rustls::rustls::{RootCertStore, ServerConfig};
use x509_parser::parse_x509_certificate;

use super::{AccessError, CertificateEnd, files, validity};
use crate::config::TlsFiles;
use crate::door::client_name::ClientName;

/// What a connection speaks after its handshake.
const PROTOCOL: &[u8] = b"h2";

/// The certificates of a server, as they were read last.
pub(crate) struct Certificates {
    files: TlsFiles,
    current: RwLock<Arc<ServerConfig>>,
}

impl Certificates {
    /// Reads the files.
    ///
    /// # Errors
    /// [`AccessError`] for the first that cannot be used.
    pub(super) fn read(files: TlsFiles) -> Result<Self, AccessError> {
        let current = RwLock::new(Arc::new(configured(&files)?));
        Ok(Self { files, current })
    }

    /// Reads the files again; what was there stays when they cannot be used.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub(super) fn read_again(&self) -> Result<(), AccessError> {
        let fresh = Arc::new(configured(&self.files)?);
        *self.current.write().unwrap_or_else(PoisonError::into_inner) = fresh;
        Ok(())
    }

    /// What the next handshake uses.
    pub(crate) fn current(&self) -> Arc<ServerConfig> {
        let current = self.current.read().unwrap_or_else(PoisonError::into_inner);
        Arc::clone(&current)
    }

    /// When they end, by the files as they are now.
    ///
    /// # Errors
    /// [`AccessError`] for one that cannot be read or has ended.
    pub(super) fn ends(&self) -> Result<Vec<CertificateEnd>, AccessError> {
        validity::ends(&self.files)
    }

    pub(super) fn paths(&self) -> impl Iterator<Item = &Path> {
        let TlsFiles {
            certificate,
            key,
            client_authority,
        } = &self.files;
        let files = [Some(certificate), Some(key), client_authority.as_ref()];
        files.into_iter().flatten().map(PathBuf::as_path)
    }
}

fn configured(files: &TlsFiles) -> Result<ServerConfig, AccessError> {
    validity::ends(files)?;
    let provider = Arc::new(ring::default_provider());
    let chain = validity::certificates(&files.certificate)?;
    let key = key(&files.key)?;
    let versions = ServerConfig::builder_with_provider(Arc::clone(&provider))
        .with_safe_default_protocol_versions()
        .map_err(|error| AccessError::new(&files.certificate, error))?;
    let asking = match &files.client_authority {
        None => versions.with_no_client_auth(),
        Some(path) => {
            let wrong = |why: String| AccessError::new(path, why);
            let mut roots = RootCertStore::empty();
            for root in validity::certificates(path)? {
                roots.add(root).map_err(|error| wrong(error.to_string()))?;
            }
            let verifier = WebPkiClientVerifier::builder_with_provider(roots.into(), provider);
            let verifier = verifier.build().map_err(|error| wrong(error.to_string()))?;
            versions.with_client_cert_verifier(verifier)
        }
    };
    let config = asking.with_single_cert(chain, key);
    let mut config = config.map_err(|error| AccessError::new(&files.certificate, error))?;
    config.alpn_protocols = vec![PROTOCOL.to_vec()];
    Ok(config)
}

fn key(path: &Path) -> Result<PrivateKeyDer<'static>, AccessError> {
    let text = files::read(path, validity::LONGEST_FILE)?;
    PrivateKeyDer::from_pem_slice(text.as_bytes()).map_err(|error| AccessError::new(path, error))
}

/// The common name of a certificate, where that is a name of a client.
pub(crate) fn common_name(certificate: &CertificateDer<'_>) -> Option<ClientName> {
    let (_, certificate) = parse_x509_certificate(certificate).ok()?;
    let mut names = certificate.subject().iter_common_name();
    let name = names.next()?.as_str().ok()?.parse().ok();
    // More than one name proves none.
    names.next().is_none().then_some(name)?
}
