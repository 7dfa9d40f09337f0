//! `certs init` and `certs client`: an authority and what it signs, for a server and its clients.

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

const SERVER: &str = "server.pem";
const DAY: Duration = Duration::from_secs(24 * 3600);
const AUTHORITY_DAYS: u32 = 3650;
/// Clocks that are behind.
const MARGIN: Duration = Duration::from_secs(3600);
/// Under which a server is always reached on its own machine.
const OWN_HOSTS: [&str; 3] = ["localhost", "127.0.0.1", "::1"];

pub(super) fn run(command: CertsCommand) -> Result<Exit, Failure> {
    let folder = match command {
        CertsCommand::Init {
            folder,
            hosts,
            clients,
            days,
        } => {
            fs::create_dir_all(&folder).map_err(|error| Failure::unwritable(&folder, &error))?;
            let issuer = authority(&folder)?;
            let is_for_clients = hosts.is_empty() && !clients.is_empty();
            if !is_for_clients || !folder.join(SERVER).exists() {
                server(&folder, &issuer, (hosts, days))?;
            }
            sign_clients(&folder, &issuer, (&clients, days))?;
            folder
        }
        CertsCommand::Client {
            folder,
            names,
            days,
        } => {
            if !folder.join("ca.key").exists() {
                let text = format!(
                    "{}: has no authority; `signorini certs init` makes one",
                    folder.display()
                );
                return Err(Failure::new(Exit::Usage, text));
            }
            sign_clients(&folder, &authority(&folder)?, (&names, days))?;
            folder
        }
    };
    print(&format!("{}\n", folder.display()))?;
    Ok(Exit::Ok)
}

/// Signs the server's certificate: under the names that it has and new ones, with the key that
/// it has.
fn server(
    folder: &Path,
    issuer: &Issuer<'_, KeyPair>,
    (hosts, days): (Vec<String>, u32),
) -> Result<(), Failure> {
    let (certificate, key) = (folder.join(SERVER), folder.join("server.key"));
    let mut names = OWN_HOSTS.map(str::to_owned).to_vec();
    if certificate.exists() {
        let wrong =
            |error: signorini_server::AccessError| Failure::new(Exit::Usage, error.to_string());
        names.extend(signorini_server::certificate_names(&certificate).map_err(wrong)?);
    }
    names.extend(hosts);
    let mut known = std::collections::HashSet::new();
    names.retain(|name| known.insert(name.clone()));
    let pair = if key.exists() {
        KeyPair::from_pem(&read(&key)?).map_err(|error| unusable(&key, &error))?
    } else {
        KeyPair::generate().map_err(failed)?
    };
    let made = signed(issuer, pair, (names, "signorini"), days)?;
    keep(folder, "server", &made)
}

fn sign_clients(
    folder: &Path,
    issuer: &Issuer<'_, KeyPair>,
    (clients, days): (&[signorini_server::ClientName], u32),
) -> Result<(), Failure> {
    for client in clients {
        let pair = KeyPair::generate().map_err(failed)?;
        let made = signed(issuer, pair, (Vec::new(), client.as_str()), days)?;
        keep(folder, &format!("client-{client}"), &made)?;
    }
    Ok(())
}

fn read(path: &Path) -> Result<String, Failure> {
    fs::read_to_string(path)
        .map_err(|error| Failure::new(Exit::Usage, format!("{}: {error}", path.display())))
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
    pair: KeyPair,
    (hosts, name): (Vec<String>, &str),
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

    /// A folder of one test, and what is in its files.
    fn fresh(name: &str) -> std::path::PathBuf {
        let name = format!("signorini-certs-{name}-{}", std::process::id());
        let folder = std::env::temp_dir().join(name);
        // Of an earlier process of the same number.
        drop(fs::remove_dir_all(&folder));
        folder
    }

    fn renew(folder: &Path, hosts: &[&str], clients: &[&str]) {
        let done = run(CertsCommand::Init {
            folder: folder.to_owned(),
            hosts: hosts.iter().map(|&one| one.to_owned()).collect(),
            clients: clients.iter().map(|one| one.parse().unwrap()).collect(),
            days: 9,
        });
        assert_eq!(done, Ok(Exit::Ok));
    }

    #[test]
    fn a_server_keeps_its_names_and_its_key_when_it_is_renewed() {
        let folder = fresh("renewed");
        assert_eq!(init(&folder, &[]), Ok(Exit::Ok));
        let names = || signorini_server::certificate_names(&folder.join(SERVER)).unwrap();
        let first = (names(), read(&folder.join("server.key")));
        assert!(first.0.contains(&"solver.example".to_owned()));
        let certificate = read(&folder.join(SERVER));
        renew(&folder, &[], &[]);
        assert_eq!((names(), read(&folder.join("server.key"))), first);
        assert_ne!(read(&folder.join(SERVER)), certificate);
        renew(&folder, &["other.example"], &[]);
        let last = names().pop();
        assert_eq!(
            (names().len(), last.as_deref()),
            (first.0.len() + 1, Some("other.example"))
        );
        fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn a_certificate_of_a_client_leaves_that_of_the_server_alone() {
        let folder = fresh("client");
        assert_eq!(init(&folder, &[]), Ok(Exit::Ok));
        let before = (read(&folder.join(SERVER)), read(&folder.join("server.key")));
        renew(&folder, &[], &["line-1"]);
        let client = |names: &[&str]| {
            run(CertsCommand::Client {
                folder: folder.clone(),
                names: names.iter().map(|one| one.parse().unwrap()).collect(),
                days: 9,
            })
        };
        assert_eq!(client(&["line-2", "line-3"]), Ok(Exit::Ok));
        let after = (read(&folder.join(SERVER)), read(&folder.join("server.key")));
        assert_eq!(before, after);
        let made = ["line-1", "line-2", "line-3"].map(|one| format!("client-{one}.pem"));
        assert!(made.iter().all(|name| folder.join(name).exists()));
        fs::remove_dir_all(&folder).unwrap();
        assert!(client(&["line-4"]).is_err(), "there is no authority");
        assert!(!folder.exists());
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
