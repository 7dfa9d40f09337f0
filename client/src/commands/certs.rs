//! `certs init`: an authority and what it signs, for a server and its clients.

use std::fs::{self, OpenOptions};
use std::io::Write as _;
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::Path;
use std::time::{Duration, SystemTime};

use rcgen::{
    BasicConstraints, CertificateParams, DnType, ExtendedKeyUsagePurpose, IsCa, Issuer, KeyPair,
    KeyUsagePurpose,
};

use crate::arguments::CertsCommand;
use crate::terminal::exit::{Exit, Failure};
use crate::terminal::stdout::print;

const DAY: Duration = Duration::from_secs(24 * 3600);
const AUTHORITY_DAYS: u32 = 3650;
/// Clocks that are behind.
const MARGIN: Duration = Duration::from_secs(3600);
/// Under which a server is always reached on its own machine.
const OWN_HOSTS: [&str; 3] = ["localhost", "127.0.0.1", "::1"];

pub(super) fn run(command: CertsCommand) -> Result<Exit, Failure> {
    let CertsCommand::Init {
        folder,
        hosts,
        clients,
        days,
    } = command;
    fs::create_dir_all(&folder).map_err(|error| Failure::unwritable(&folder, &error))?;
    let issuer = authority(&folder)?;
    let own = OWN_HOSTS.map(str::to_owned).into_iter();
    let server = signed(&issuer, own.chain(hosts).collect(), "signorini", days)?;
    keep(&folder, "server", &server)?;
    for client in &clients {
        let made = signed(&issuer, Vec::new(), client.as_str(), days)?;
        keep(&folder, &format!("client-{client}"), &made)?;
    }
    print(&format!("{}\n", folder.display()))?;
    Ok(Exit::Ok)
}

/// A certificate and its key (PEM).
struct Made {
    certificate: String,
    key: String,
}

/// The authority of the folder, or a new one.
fn authority(folder: &Path) -> Result<Issuer<'static, KeyPair>, Failure> {
    let (certificate, key) = (folder.join("ca.pem"), folder.join("ca.key"));
    if certificate.exists() || key.exists() {
        let read = |path: &Path| {
            fs::read_to_string(path)
                .map_err(|error| Failure::new(Exit::Usage, format!("{}: {error}", path.display())))
        };
        let pair = KeyPair::from_pem(&read(&key)?).map_err(|error| unusable(&key, &error))?;
        let issuer = Issuer::from_ca_cert_pem(&read(&certificate)?, pair);
        return issuer.map_err(|error| unusable(&certificate, &error));
    }
    let pair = KeyPair::generate().map_err(failed)?;
    let mut params = params(Vec::new(), "Signorini authority", AUTHORITY_DAYS)?;
    params.is_ca = IsCa::Ca(BasicConstraints::Constrained(0));
    params.key_usages = vec![KeyUsagePurpose::KeyCertSign, KeyUsagePurpose::CrlSign];
    let made = Made {
        certificate: params.self_signed(&pair).map_err(failed)?.pem(),
        key: pair.serialize_pem(),
    };
    keep(folder, "ca", &made)?;
    Ok(Issuer::new(params, pair))
}

/// For a server under its hosts, or for a client, which has none.
fn signed(
    issuer: &Issuer<'_, KeyPair>,
    hosts: Vec<String>,
    name: &str,
    days: u32,
) -> Result<Made, Failure> {
    let purpose = if hosts.is_empty() {
        ExtendedKeyUsagePurpose::ClientAuth
    } else {
        ExtendedKeyUsagePurpose::ServerAuth
    };
    let mut params = params(hosts, name, days)?;
    params.key_usages = vec![KeyUsagePurpose::DigitalSignature];
    params.extended_key_usages = vec![purpose];
    params.use_authority_key_identifier_extension = true;
    let pair = KeyPair::generate().map_err(failed)?;
    let certificate = params.signed_by(&pair, issuer).map_err(failed)?;
    Ok(Made {
        certificate: certificate.pem(),
        key: pair.serialize_pem(),
    })
}

fn params(hosts: Vec<String>, name: &str, days: u32) -> Result<CertificateParams, Failure> {
    let wrong = |error: rcgen::Error| Failure::new(Exit::Usage, format!("--host: {error}"));
    let mut params = CertificateParams::new(hosts).map_err(wrong)?;
    params.distinguished_name = rcgen::DistinguishedName::new();
    params.distinguished_name.push(DnType::CommonName, name);
    let now = SystemTime::now();
    params.not_before = (now - MARGIN).into();
    params.not_after = (now + DAY * days).into();
    Ok(params)
}

/// Writes NAME.pem and NAME.key, over older ones: servers take them up while they run.
fn keep(folder: &Path, name: &str, made: &Made) -> Result<(), Failure> {
    write(&folder.join(format!("{name}.key")), &made.key, 0o600)?;
    write(
        &folder.join(format!("{name}.pem")),
        &made.certificate,
        0o644,
    )
}

/// Writes beside and renames, so that a reader sees the old file or the new one.
fn write(path: &Path, text: &str, mode: u32) -> Result<(), Failure> {
    let mut beside = path.as_os_str().to_owned();
    beside.push(format!(".{}.part", std::process::id()));
    let open = OpenOptions::new()
        .write(true)
        .create_new(true)
        .mode(mode)
        .open(&beside);
    let written = open
        .and_then(|mut file| {
            file.write_all(text.as_bytes())?;
            file.sync_all()
        })
        .and_then(|()| fs::rename(&beside, path));
    written.map_err(|error| Failure::unwritable(path, &error))
}

fn unusable(path: &Path, error: &rcgen::Error) -> Failure {
    Failure::new(Exit::Usage, format!("{}: {error}", path.display()))
}

fn failed(error: rcgen::Error) -> Failure {
    Failure::new(Exit::Server, format!("no certificate was made: {error}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn init(folder: &Path, clients: &[&str]) -> Result<Exit, Failure> {
        run(CertsCommand::Init {
            folder: folder.to_owned(),
            hosts: vec!["solver.example".to_owned(), "192.0.2.7".to_owned()],
            clients: clients.iter().map(|one| one.parse().unwrap()).collect(),
            days: 7,
        })
    }

    #[test]
    fn a_second_run_keeps_the_authority_and_renews_the_rest() {
        let folder = format!("signorini-certificates-{}", std::process::id());
        let folder = std::env::temp_dir().join(folder);
        let read = |name: &str| fs::read_to_string(folder.join(name)).unwrap();
        assert_eq!(init(&folder, &["line-1"]), Ok(Exit::Ok));
        let before = (
            read("ca.pem"),
            read("server.pem"),
            read("client-line-1.pem"),
        );
        assert_eq!(init(&folder, &[]), Ok(Exit::Ok));
        let after = (
            read("ca.pem"),
            read("server.pem"),
            read("client-line-1.pem"),
        );
        assert_eq!((&before.0, &before.2), (&after.0, &after.2));
        assert_ne!(before.1, after.1);
        use std::os::unix::fs::PermissionsExt as _;
        let mode = fs::metadata(folder.join("server.key"))
            .unwrap()
            .permissions()
            .mode();
        assert_eq!(mode & 0o777, 0o600);
        fs::write(folder.join("ca.key"), "no key").unwrap();
        assert!(init(&folder, &[]).is_err());
        fs::remove_dir_all(&folder).unwrap();
    }
}
