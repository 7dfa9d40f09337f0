//! How long certificates are good for, and under which names: what operators are told before
//! clients find out.

use std::net::{Ipv4Addr, Ipv6Addr};
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use tokio_rustls::rustls::pki_types::CertificateDer;
use tokio_rustls::rustls::pki_types::pem::PemObject as _;
use x509_parser::extensions::GeneralName;
use x509_parser::parse_x509_certificate;

use super::{AccessError, files};
use crate::config::{Config, TlsFiles};

/// Longest file of certificates, bytes.
pub(super) const LONGEST_FILE: u64 = 4 << 20;
const DAY: i64 = 24 * 3600;
/// Fewer days than this and a start warns.
pub(super) const SOON: i64 = 21;

/// A file of certificates, and when it is good no more.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CertificateEnd {
    /// The file.
    pub path: PathBuf,
    /// `server` or `client_authority`.
    pub certificate: &'static str,
    /// Unix seconds.
    pub end: i64,
}

impl CertificateEnd {
    /// Whole days from now on; negative for one that has ended.
    pub fn days_left(&self) -> i64 {
        (self.end - now()).div_euclid(DAY)
    }

    /// Whether somebody should renew it now.
    pub fn is_near(&self) -> bool {
        self.days_left() < SOON
    }
}

/// When the certificates end that settings name; none where the transport is open.
///
/// # Errors
/// [`AccessError`] for a file that cannot be read, or is good no more.
pub fn certificate_ends(config: &Config) -> Result<Vec<CertificateEnd>, AccessError> {
    config
        .tls_files()
        .map_or(Ok(Vec::new()), |files| ends(&files))
}

/// The ends of all files.
pub(super) fn ends(files: &TlsFiles) -> Result<Vec<CertificateEnd>, AccessError> {
    let end = |path: &Path, certificate, all: Vec<i64>, choose: fn(Vec<i64>) -> Option<i64>| {
        let end = choose(all).ok_or_else(|| AccessError::new(path, "holds no certificate"))?;
        let path = path.to_owned();
        checked(CertificateEnd {
            path,
            certificate,
            end,
        })
    };
    // A chain is good as long as all of it is, an authority as long as one of them.
    let chain = ends_of(&files.certificate)?;
    let first = |all: Vec<i64>| all.into_iter().min();
    let last = |all: Vec<i64>| all.into_iter().max();
    let mut found = vec![end(&files.certificate, "server", chain, first)?];
    if let Some(path) = &files.client_authority {
        found.push(end(path, "client_authority", ends_of(path)?, last)?);
    }
    Ok(found)
}

fn checked(found: CertificateEnd) -> Result<CertificateEnd, AccessError> {
    if found.end > now() {
        return Ok(found);
    }
    let days = -found.days_left();
    let why = format!("has expired (less than {days} days ago): `signorini certs init` renews it");
    Err(AccessError::new(&found.path, why))
}

fn ends_of(path: &Path) -> Result<Vec<i64>, AccessError> {
    let all = certificates(path)?;
    let end = |one: &CertificateDer<'_>| match parse_x509_certificate(one) {
        Ok((_, parsed)) => Ok(parsed.validity().not_after.timestamp()),
        Err(error) => Err(AccessError::new(path, error)),
    };
    all.iter().map(end).collect()
}

/// All certificates of a file.
pub(super) fn certificates(path: &Path) -> Result<Vec<CertificateDer<'static>>, AccessError> {
    let text = files::read(path, LONGEST_FILE)?;
    let all: Result<Vec<_>, _> = CertificateDer::pem_slice_iter(text.as_bytes()).collect();
    let all = all.map_err(|error| AccessError::new(path, error))?;
    if all.is_empty() {
        Err(AccessError::new(path, "holds no certificate"))
    } else {
        Ok(all)
    }
}

/// The names and addresses that the first certificate of a file is for.
///
/// # Errors
/// [`AccessError`] for a file that holds no certificate.
pub fn certificate_names(path: &Path) -> Result<Vec<String>, AccessError> {
    let all = certificates(path)?;
    let none = || AccessError::new(path, "holds no certificate");
    let first = all.first().ok_or_else(none)?;
    let wrong = |why: String| AccessError::new(path, why);
    let (_, parsed) = parse_x509_certificate(first).map_err(|error| wrong(error.to_string()))?;
    let names = parsed.subject_alternative_name();
    let names = names.map_err(|error| wrong(error.to_string()))?;
    let names = names.map_or(&[][..], |names| &names.value.general_names);
    Ok(names.iter().filter_map(host).collect())
}

/// A name that clients ask for.
fn host(name: &GeneralName<'_>) -> Option<String> {
    if let GeneralName::DNSName(name) = name {
        return Some((*name).to_owned());
    }
    let GeneralName::IPAddress(bytes) = name else {
        return None;
    };
    let four = <[u8; 4]>::try_from(*bytes).map(|bytes| Ipv4Addr::from(bytes).to_string());
    let six = <[u8; 16]>::try_from(*bytes).map(|bytes| Ipv6Addr::from(bytes).to_string());
    four.or(six).ok()
}

fn now() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    since.map_or(0, |since| since.as_secs().cast_signed())
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use rcgen::{CertificateParams, KeyPair};

    use super::*;

    /// A certificate that is good for so many seconds, in a file of its own.
    fn file(name: &str, seconds: i64) -> PathBuf {
        let names = ["solver.example", "192.0.2.7", "::1"].map(str::to_owned);
        let mut params = CertificateParams::new(names).unwrap();
        let moved = Duration::from_secs(seconds.unsigned_abs());
        let now = SystemTime::now();
        params.not_before = (now - Duration::from_secs(100_000_000)).into();
        let end = if seconds < 0 {
            now - moved
        } else {
            now + moved
        };
        params.not_after = end.into();
        let made = params.self_signed(&KeyPair::generate().unwrap()).unwrap();
        let name = format!("signorini-validity-{name}-{}.pem", std::process::id());
        let path = std::env::temp_dir().join(name);
        std::fs::write(&path, made.pem()).unwrap();
        path
    }

    fn ends_with(seconds: i64) -> Result<Vec<CertificateEnd>, AccessError> {
        let path = file(&format!("{seconds}"), seconds);
        let found = ends(&TlsFiles {
            certificate: path.clone(),
            key: path.clone(),
            client_authority: None,
        });
        std::fs::remove_file(path).unwrap();
        found
    }

    #[test]
    fn days_are_told_and_one_that_has_ended_is_refused_with_the_cure() {
        let found = ends_with(30 * DAY + 60).unwrap();
        assert_eq!((found[0].days_left(), found[0].is_near()), (30, false));
        let found = ends_with(20 * DAY + 60).unwrap();
        assert_eq!((found[0].days_left(), found[0].is_near()), (20, true));
        let refused = ends_with(-60).unwrap_err().to_string();
        assert!(refused.contains("has expired") && refused.contains("certs init"));
    }

    #[test]
    fn names_and_addresses_are_read() {
        let path = file("names", DAY);
        let names = certificate_names(&path).unwrap();
        std::fs::remove_file(path).unwrap();
        assert_eq!(names, ["solver.example", "192.0.2.7", "::1"]);
    }
}
