//! Transport security: addresses that need it, certificates that do and do not, rotation.

use std::path::{Path, PathBuf};

use rcgen::{BasicConstraints, CertificateParams, DnType, IsCa, Issuer, KeyPair, date_time_ymd};
use signorini_server::{Config, Listener, Role};
use tonic::transport::{Certificate, Channel, ClientTlsConfig, Endpoint, Identity};

use super::{Client, Tokens, soon};
use crate::common::{Server, page, sample};

/// An authority that signs for a test.
pub(super) struct Authority {
    issuer: Issuer<'static, KeyPair>,
    pub(super) pem: String,
}

impl Authority {
    pub(super) fn new(name: &str) -> Self {
        let mut params = CertificateParams::default();
        params.is_ca = IsCa::Ca(BasicConstraints::Constrained(0));
        params.distinguished_name.push(DnType::CommonName, name);
        let key = KeyPair::generate().unwrap();
        let pem = params.self_signed(&key).unwrap().pem();
        let issuer = Issuer::new(params, key);
        Self { issuer, pem }
    }

    /// Certificate and key; good until the end of `year`.
    pub(super) fn sign(&self, name: &str, year: i32) -> (String, String) {
        let mut params = CertificateParams::new(vec!["localhost".to_owned()]).unwrap();
        params.distinguished_name = rcgen::DistinguishedName::new();
        params.distinguished_name.push(DnType::CommonName, name);
        params.not_before = date_time_ymd(2000, 1, 1);
        params.not_after = date_time_ymd(year, 12, 31);
        let key = KeyPair::generate().unwrap();
        let certificate = params.signed_by(&key, &self.issuer).unwrap();
        (certificate.pem(), key.serialize_pem())
    }

    /// Puts a server's certificate into `folder`.
    pub(super) fn serve(&self, folder: &Path) {
        let (certificate, key) = self.sign("server", 4000);
        std::fs::write(folder.join("server.key"), key).unwrap();
        std::fs::write(folder.join("server.pem"), certificate).unwrap();
    }
}

pub(super) fn text(path: PathBuf) -> String {
    path.to_str().unwrap().to_owned()
}

pub(super) fn config(tokens: &Tokens) -> Config {
    Config {
        listen: "0.0.0.0:0".to_owned(),
        tls_certificate: text(tokens.folder().join("server.pem")),
        tls_key: text(tokens.folder().join("server.key")),
        ..tokens.config()
    }
}

/// A channel to the port of `url` that trusts `authority`.
async fn reach(
    url: &str,
    authority: &Authority,
    own: Option<&(String, String)>,
) -> Result<Channel, tonic::transport::Error> {
    let (_, port) = url.rsplit_once(':').unwrap();
    let trusted = Certificate::from_pem(&authority.pem);
    let mut tls = ClientTlsConfig::new().ca_certificate(trusted);
    if let Some((certificate, key)) = own {
        tls = tls.identity(Identity::from_pem(certificate, key));
    }
    let endpoint = Endpoint::new(format!("https://localhost:{port}")).unwrap();
    endpoint.tls_config(tls)?.connect().await
}

#[tokio::test]
async fn an_address_that_others_reach_needs_tokens_and_transport_security() {
    let mut tokens = Tokens::new("exposed");
    tokens.add("line-1", Role::Solve);
    Authority::new("one").serve(tokens.folder());
    let whole = config(&tokens);
    assert!(Listener::bind(&whole).await.is_ok());
    let without_tokens = Config {
        tokens: String::new(),
        ..whole.clone()
    };
    let without_security = Config {
        tls_certificate: String::new(),
        tls_key: String::new(),
        ..whole.clone()
    };
    for config in [without_tokens, without_security] {
        let why = Listener::bind(&config).await.unwrap_err().to_string();
        for told in [
            "0.0.0.0",
            "signorini certs init",
            "signorini token add",
            "unix:",
        ] {
            assert!(why.contains(told), "{why}");
        }
    }
    let page = Config {
        metrics_listen: "0.0.0.0:0".to_owned(),
        ..whole
    };
    let why = Listener::bind(&page).await.unwrap_err().to_string();
    assert!(
        why.contains("metrics page") && why.contains("127.0.0.1"),
        "{why}"
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn only_who_trusts_the_authority_gets_through_and_certificates_rotate() {
    let mut tokens = Tokens::new("rotation");
    let token = tokens.add("line-1", Role::Solve);
    let [first, second] = ["first", "second"].map(Authority::new);
    first.serve(tokens.folder());
    let server = Server::listening(Config {
        metrics_listen: "127.0.0.1:0".to_owned(),
        ..config(&tokens)
    })
    .await;
    let with = |channel| Client {
        channel,
        token: Some(token.clone()),
    };
    let before = with(reach(&server.url, &first, None).await.unwrap());
    assert!(before.sessions().await.is_ok());
    assert!(reach(&server.url, &second, None).await.is_err());
    let (_, port) = server.url.rsplit_once(':').unwrap();
    let plain = Endpoint::new(format!("http://127.0.0.1:{port}")).unwrap();
    if let Ok(channel) = plain.connect().await {
        assert!(with(channel).sessions().await.is_err());
    }
    let url = server.metrics_url.as_ref().unwrap();
    let turned = "signorini_connections_turned_away_total{reason=\"handshake\"}";
    let is_counted = async || sample(&page(url).await, turned) >= 2;
    soon("the count of failed handshakes", is_counted).await;

    second.serve(tokens.folder());
    let reached = async || reach(&server.url, &second, None).await.is_ok();
    soon("the second certificate", reached).await;
    let after = with(reach(&server.url, &second, None).await.unwrap());
    assert!(after.sessions().await.is_ok());
    assert!(before.sessions().await.is_ok());
    assert!(reach(&server.url, &first, None).await.is_err());
}

#[tokio::test(flavor = "multi_thread")]
async fn a_certificate_proves_its_common_name_and_a_wrong_one_nothing() {
    let mut tokens = Tokens::new("certificates");
    let token = tokens.add("line-1", Role::Solve);
    tokens.add_certificate("cell", Role::Read);
    let [own, foreign] = ["own", "foreign"].map(Authority::new);
    own.serve(tokens.folder());
    let authority = tokens.folder().join("ca.pem");
    std::fs::write(&authority, &own.pem).unwrap();
    let server = Server::listening(Config {
        tls_client_ca: text(authority),
        ..config(&tokens)
    })
    .await;
    let sessions = async |shown: Option<(String, String)>, token: Option<&str>| {
        let channel = reach(&server.url, &own, shown.as_ref()).await;
        let token = token.map(str::to_owned);
        let client = Client {
            channel: channel.map_err(|error| error.to_string())?,
            token,
        };
        client
            .sessions()
            .await
            .map_err(|status| format!("{:?}", status.code()))
    };
    let good = sessions(Some(own.sign("cell", 4000)), None).await;
    assert_eq!(good, Ok(Vec::new()));
    let unknown = sessions(Some(own.sign("nobody", 4000)), None).await;
    assert_eq!(unknown, Err("Unauthenticated".to_owned()));
    // A name with a token has no certificate.
    let other = sessions(Some(own.sign("line-1", 4000)), None).await;
    assert_eq!(other, Err("Unauthenticated".to_owned()));
    let both = sessions(Some(own.sign("nobody", 4000)), Some(&token)).await;
    assert_eq!(both, Ok(Vec::new()));
    for wrong in [
        None,
        Some(own.sign("cell", 2001)),
        Some(foreign.sign("cell", 4000)),
    ] {
        let refused = sessions(wrong, Some(&token)).await.unwrap_err();
        assert_ne!(refused, "Unauthenticated");
    }
}
