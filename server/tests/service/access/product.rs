//! Every method, with every role, on every way that does not let in; and with what belongs to
//! another client.

use crate::quotas::tetrahedron;
use signorini_proto::v1 as wire;
use signorini_server::{Config, Role};
use tonic::transport::{Certificate, Channel, ClientTlsConfig, Endpoint, Identity};
use tonic_types::StatusExt as _;

use super::owners::refusal;
use super::roles::{methods, refused};
use super::transport::{Authority, config, text};
use super::{Client, Tokens};
use crate::common::{Block, Server, reason};

const ROLES: [Role; 3] = [Role::Read, Role::Solve, Role::Admin];

/// A way to the port of `url`, tried anew by each call.
fn way(url: &str, trusted: Option<&Authority>, own: Option<(String, String)>) -> Channel {
    let (_, port) = url.rsplit_once(':').unwrap();
    let Some(trusted) = trusted else {
        let endpoint = Endpoint::new(format!("http://127.0.0.1:{port}")).unwrap();
        return endpoint.connect_lazy();
    };
    let mut tls = ClientTlsConfig::new().ca_certificate(Certificate::from_pem(&trusted.pem));
    if let Some((certificate, key)) = own {
        tls = tls.identity(Identity::from_pem(certificate, key));
    }
    let endpoint = Endpoint::new(format!("https://localhost:{port}")).unwrap();
    endpoint.tls_config(tls).unwrap().connect_lazy()
}

/// A server that asks for certificates, whose names are those of the roles.
async fn asked(tokens: &mut Tokens, own: &Authority) -> Server {
    own.serve(tokens.folder());
    for role in ROLES {
        tokens.add_certificate(role.name(), role);
        tokens.add_certificate(&format!("{role}-gone"), role);
    }
    let authority = tokens.folder().join("ca.pem");
    std::fs::write(&authority, &own.pem).unwrap();
    let server = Server::listening(Config {
        tls_client_ca: text(authority),
        ..config(tokens)
    });
    server.await
}

#[tokio::test(flavor = "multi_thread")]
async fn every_method_is_closed_to_every_role_on_every_wrong_way() {
    let mut tokens = Tokens::new("product");
    let [own, foreign] = ["own", "foreign"].map(Authority::new);
    let server = asked(&mut tokens, &own).await;
    let bearers = ROLES.map(|role| tokens.add(&format!("{role}-bearer"), role));
    for role in ROLES {
        tokens.revoke(&format!("{role}-gone"));
    }
    // A second, so that the server has taken up the file.
    tokio::time::sleep(std::time::Duration::from_millis(1500)).await;
    for (role, bearer) in ROLES.into_iter().zip(bearers) {
        let name = role.name();
        let gone = format!("{name}-gone");
        let ways = [
            ("no security", None, None),
            ("no certificate", Some(&own), None),
            (
                "a foreign certificate",
                Some(&own),
                Some(foreign.sign(name, 4000)),
            ),
            (
                "an expired certificate",
                Some(&own),
                Some(own.sign(name, 2001)),
            ),
            (
                "a foreign server",
                Some(&foreign),
                Some(own.sign(name, 4000)),
            ),
        ];
        // A good token does not make up for a wrong way.
        let closed = ways.map(|(what, trusted, shown)| {
            let channel = way(&server.url, trusted, shown);
            let token = Some(bearer.clone());
            (what, Client { channel, token })
        });
        let revoked = Client {
            channel: way(&server.url, Some(&own), Some(own.sign(&gone, 4000))),
            token: None,
        };
        let good = Client {
            channel: way(&server.url, Some(&own), Some(own.sign(name, 4000))),
            token: None,
        };
        for (path, needed) in methods() {
            for (what, client) in &closed {
                let broken = client.first::<(), ()>(&path, ()).await.unwrap_err();
                // No service has answered: every refusal of theirs has a reason.
                let is_answer = broken.get_details_error_info().is_some();
                assert!(!is_answer, "{path} as {role}, {what}: {broken}");
            }
            let said = refused(&revoked, &path).await;
            assert_eq!(said.as_deref(), Some("UNAUTHENTICATED"), "{path} as {role}");
            let said = refused(&good, &path).await;
            let expected = (role < needed).then_some("PERMISSION_DENIED");
            assert_eq!(said.as_deref(), expected, "{path} as {role}");
        }
    }
}

/// Methods that name what belongs to a client: by its kind, the reason where it is not there.
pub(super) const NAMING: [(&str, &str, &[&str]); 3] = [
    (
        "Session",
        "SESSION_NOT_FOUND",
        &[
            "GetSession",
            "Watch",
            "CancelStep",
            "ReadStep",
            "ExportState",
            "SaveState",
            "RestoreState",
            "DeleteSession",
        ],
    ),
    (
        "Mesh",
        "MESH_NOT_FOUND",
        &["GetMesh", "ReadMesh", "DeleteMesh"],
    ),
    (
        "Surface",
        "SURFACE_NOT_FOUND",
        &["GetSurface", "ReadSurface", "DeleteSurface"],
    ),
];

/// A tool of triangles; its name.
async fn tool(client: &Client) -> String {
    let path = "/signorini.v1.SurfaceService/UploadSurface";
    let made = client.call(path, tetrahedron(1.0)).await;
    let made: Option<wire::UploadSurfaceResponse> = made.unwrap().message().await.unwrap();
    made.unwrap().surface.unwrap().name
}

#[tokio::test(flavor = "multi_thread")]
async fn what_belongs_to_another_is_there_for_an_administrator_alone() {
    let mut tokens = Tokens::new("others");
    let mine = tokens.add("mine", Role::Solve);
    let others = ROLES.map(|role| (role, tokens.add(role.name(), role)));
    let server = Server::with(tokens.config()).await;
    let (mine, block) = (Client::of(&server, &mine), Block::new(1));
    let names = [
        mine.upload(&block).await.unwrap().mesh.unwrap().name,
        mine.create(&block, "mine-1").await.unwrap(),
        tool(&mine).await,
    ];
    let named = |kind: &str| {
        let prefix = kind.to_lowercase();
        let begins = |name: &&String| name.starts_with(&prefix[..4]);
        names.iter().find(begins).unwrap().clone()
    };
    let needed: std::collections::HashMap<_, _> = methods().into_iter().collect();
    for (role, token) in &others {
        let client = Client::of(&server, token);
        for (kind, not_found, methods) in NAMING {
            for method in methods.iter().filter(|one| !one.starts_with("Delete")) {
                let path = format!("/signorini.v1.{kind}Service/{method}");
                let said = refusal(&client, &path, &named(kind)).await;
                match (*role < needed[&path], role) {
                    (true, _) => {
                        assert_eq!(said.as_deref(), Some("PERMISSION_DENIED"), "{path} {role}");
                    }
                    (false, Role::Read | Role::Solve) => {
                        assert_eq!(said.as_deref(), Some(not_found), "{path} {role}");
                    }
                    (false, Role::Admin) => assert_ne!(said.as_deref(), Some(not_found), "{path}"),
                }
            }
        }
    }
    deletions(&server, &others, named).await;
}

/// The last calls, because they take away what the others name.
async fn deletions(server: &Server, others: &[(Role, String)], named: impl Fn(&str) -> String) {
    for (kind, not_found, _) in [&NAMING[0], &NAMING[1], &NAMING[2]] {
        let path = format!("/signorini.v1.{kind}Service/Delete{kind}");
        for (role, token) in others {
            let client = Client::of(server, token);
            let said = refusal(&client, &path, &named(kind)).await;
            let expected = match role {
                Role::Read => Some("PERMISSION_DENIED"),
                Role::Solve => Some(*not_found),
                Role::Admin => None,
            };
            assert_eq!(said.as_deref(), expected, "{path} {role}");
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_session_on_the_tool_of_another_is_refused() {
    let mut tokens = Tokens::new("tools-of-others");
    let [mine, others] = ["mine", "others"].map(|name| tokens.add(name, Role::Solve));
    let server = Server::with(tokens.config()).await;
    let [mine, others] = [mine, others].map(|token| Client::of(&server, &token));
    let (surface, block) = (tool(&mine).await, Block::new(1));
    let mut scene = block.scene();
    let kind = wire::shape::Kind::Surface(wire::SurfaceShape {
        surface,
        ..Default::default()
    });
    scene.obstacles[0].shape.get_or_insert_default().kind = Some(kind);
    for (client, is_there) in [(&mine, true), (&others, false)] {
        client.upload(&block).await.unwrap();
        let request = wire::CreateSessionRequest {
            scene: Some(scene.clone()),
            validate_only: true,
            ..Default::default()
        };
        let answer = client
            .first::<_, wire::CreateSessionResponse>(super::CREATE, request)
            .await;
        let said = answer.err().map(|status| reason(&status));
        assert_eq!(
            said.as_deref() == Some("SURFACE_NOT_FOUND"),
            !is_there,
            "{said:?}"
        );
    }
}
