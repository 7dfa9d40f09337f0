//! What operators rely on: metrics, log, health, reflection, shutdown, Unix sockets.

use std::io::Read as _;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use crate::common::{Block, Server, answer, open, page, press, reason, sample};
use signorini_proto::v1 as wire;
use signorini_server::Config;
use tonic_health::pb::health_client::HealthClient;
use tonic_health::pb::{HealthCheckRequest, health_check_response::ServingStatus};

/// Ends a test that would wait for ever.
const PATIENCE: Duration = Duration::from_secs(30);

async fn list(server: &Server) -> Vec<wire::Session> {
    let request = wire::ListSessionsRequest::default();
    let response = server.sessions().list_sessions(request).await.unwrap();
    response.into_inner().sessions
}

async fn health(server: &Server, service: &str) -> ServingStatus {
    let request = HealthCheckRequest {
        service: service.into(),
    };
    let mut client = HealthClient::new(server.channel.clone());
    client.check(request).await.unwrap().into_inner().status()
}

#[tokio::test]
async fn the_metrics_page_counts_what_happened_and_has_no_summaries() {
    let config = Config {
        metrics_listen: "127.0.0.1:0".into(),
        ..Config::embedded()
    };
    let (server, block) = (Server::with(config).await, Block::new(1));
    server.upload(&block).await;
    for _ in 0..2 {
        let session = server.session(block.scene()).await;
        let mut stream = server.open(open(&session)).await;
        stream.step(1, press(0.02, 2)).await;
        while !stream.result().await.last {}
    }
    let page = page(server.metrics_url.as_ref().unwrap()).await;
    assert!(!page.contains(" summary"));
    assert_eq!(
        sample(&page, "signorini_steps_total{termination=\"converged\"}"),
        2
    );
    assert_eq!(
        sample(
            &page,
            "signorini_increments_total{termination=\"converged\"}"
        ),
        4
    );
    assert_eq!(
        sample(&page, "signorini_cache_hits_total{kind=\"prepared\"}"),
        1
    );
    assert_eq!(
        sample(&page, "signorini_cache_misses_total{kind=\"prepared\"}"),
        1
    );
    assert_eq!(sample(&page, "signorini_sessions"), 2);
    assert_eq!(sample(&page, "signorini_meshes"), 1);
    assert!(sample(&page, "signorini_iterations_total") > 0);
    assert!(sample(&page, "signorini_memory_bytes{kind=\"prepared\"}") > 0);
    assert_eq!(sample(&page, "signorini_krylov_iterations_count"), 4);
    let slots = Config::default().solver_slots as u64;
    assert_eq!(sample(&page, "signorini_slots"), slots);
    // Nothing runs any more.
    assert_eq!(sample(&page, "signorini_residual{slot=\"0\"}"), 0);
}

/// Series of a method, without those of its codes.
fn method(metric: &str, service: &str, name: &str, kind: &str) -> String {
    format!("{metric}{{grpc_service=\"{service}\",grpc_method=\"{name}\",grpc_type=\"{kind}\"")
}

#[tokio::test]
async fn calls_are_counted_by_method_and_code_with_their_bytes() {
    let config = Config {
        metrics_listen: "127.0.0.1:0".into(),
        ..Config::embedded()
    };
    let (server, block) = (Server::with(config).await, Block::new(1));
    server.upload(&block).await;
    let session = server.session(block.scene()).await;
    let request = wire::GetSessionRequest {
        name: "sessions/none".into(),
    };
    server.sessions().get_session(request).await.unwrap_err();
    let mut stream = server.open(open(&session)).await;
    stream.half_close();
    assert!(stream.end().await.is_none());
    health(&server, "").await;
    let page = page(server.metrics_url.as_ref().unwrap()).await;
    let sessions = "signorini.v1.SessionService";
    let handled = |service, name, kind, code: &str| {
        let start = method("grpc_server_handled_total", service, name, kind);
        sample(&page, &format!("{start},grpc_code=\"{code}\"}}"))
    };
    assert_eq!(handled(sessions, "GetSession", "unary", "NotFound"), 1);
    assert_eq!(handled(sessions, "GetSession", "unary", "OK"), 0);
    assert_eq!(handled(sessions, "CreateSession", "unary", "OK"), 1);
    assert_eq!(handled(sessions, "Solve", "bidi_stream", "OK"), 1);
    let meshes = "signorini.v1.MeshService";
    assert_eq!(handled(meshes, "UploadMesh", "client_stream", "OK"), 1);
    assert_eq!(handled("grpc.health.v1.Health", "Check", "unary", "OK"), 1);
    assert_eq!(handled("other", "other", "unary", "Unimplemented"), 0);
    let watch = method(
        "grpc_server_started_total",
        sessions,
        "Watch",
        "server_stream",
    );
    assert_eq!(sample(&page, &format!("{watch}}}")), 0);
    let create = method(
        "grpc_server_handling_seconds_count",
        sessions,
        "CreateSession",
        "unary",
    );
    assert_eq!(sample(&page, &format!("{create},grpc_code=\"OK\"}}")), 1);
    // The mesh went in: its coordinates alone are 8 corners of three numbers.
    assert!(sample(&page, "signorini_received_bytes_total") > 8 * 24);
    assert!(sample(&page, "signorini_sent_bytes_total") > 0);
    let is_series = |line: &&str| {
        ["signorini_", "grpc_", "process_"]
            .iter()
            .any(|prefix| line.starts_with(prefix))
    };
    let series = page.lines().filter(is_series);
    let series = series.count();
    assert!(series < 1660, "{series} series");
}

#[tokio::test]
async fn the_page_helps_those_who_come_by_and_answers_probes() {
    let config = Config {
        metrics_listen: "127.0.0.1:0".into(),
        ..Config::embedded()
    };
    let server = Server::with(config).await;
    let url = server.metrics_url.clone().unwrap();
    let get = |path| answer(&url, "GET", path);
    let help = get("/").await;
    assert!(help.starts_with("HTTP/1.1 200"), "{help}");
    assert!(
        help.contains("/metrics") && help.contains(&server.url),
        "{help}"
    );
    let health = get("/healthz").await;
    assert!(
        health.starts_with("HTTP/1.1 200") && health.ends_with("ok\n"),
        "{health}"
    );
    assert!(get("/livez").await.ends_with("ok\n"));
    assert!(get("/metric").await.starts_with("HTTP/1.1 404"));
    let head = answer(&url, "HEAD", "/metrics").await;
    assert!(
        head.starts_with("HTTP/1.1 200") && head.ends_with("\r\n\r\n"),
        "{head}"
    );
    let post = answer(&url, "POST", "/metrics").await;
    assert!(
        post.starts_with("HTTP/1.1 405") && post.contains("allow: GET, HEAD"),
        "{post}"
    );
}

/// Number of the user who runs the tests.
fn own_user() -> u32 {
    use std::os::unix::fs::MetadataExt as _;
    std::fs::metadata("/proc/self").unwrap().uid()
}

/// A server program; killed when a test fails before it has stopped.
struct Program(Child);

impl Drop for Program {
    fn drop(&mut self) {
        // It has ended already when the test succeeds.
        let _ended = self.0.kill();
    }
}

/// Solves one step, has one request refused, stops a server program of that log
/// format, and returns its log.
async fn log_of(format: &str) -> String {
    let folder = std::env::temp_dir().join(format!("signorini-log-{}", std::process::id()));
    let socket = format!("unix:{}-{format}.sock", folder.display());
    let arguments = ["--listen", &socket, "--metrics-listen", "", "--log-format"];
    let mut program = Program(
        Command::new(env!("CARGO_BIN_EXE_signorini-server"))
            .args(arguments)
            .arg(format)
            .env_remove("RUST_LOG")
            .stderr(Stdio::piped())
            .spawn()
            .unwrap(),
    );
    let server = Server::beside(&socket).await;
    let block = Block::new(1);
    server.upload(&block).await;
    let scene = wire::Scene {
        name: "a \"quoted\" red".into(),
        ..block.scene()
    };
    let session = server.session(scene).await;
    let mut stream = server.open(open(&session)).await;
    stream.step(1, press(0.02, 2)).await;
    while !stream.result().await.last {}
    let request = wire::GetSessionRequest {
        name: "sessions/\u{1b}[2J\nnone".into(),
    };
    server.sessions().get_session(request).await.unwrap_err();
    drop((stream, server));
    let id = program.0.id().to_string();
    assert!(Command::new("kill").arg(id).status().unwrap().success());
    let mut log = String::new();
    let mut stderr = program.0.stderr.take().unwrap();
    stderr.read_to_string(&mut log).unwrap();
    assert!(program.0.wait().unwrap().success(), "{log}");
    log
}

#[tokio::test]
async fn the_log_tells_of_addresses_sessions_steps_and_refusals() {
    let log = log_of("text").await;
    let line = |what: &str| {
        let mut found = log.lines().filter(|line| line.contains(what));
        let first = found
            .next()
            .unwrap_or_else(|| panic!("no `{what}` in\n{log}"));
        assert!(found.next().is_none(), "`{what}` twice in\n{log}");
        first.to_owned()
    };
    assert!(line(" serving ").contains("url=\"unix:"));
    assert!(line("session started").contains("scene=\"a \\\"quoted\\\" red\""));
    let step = line("step finished");
    for part in [
        "termination=\"converged\"",
        "increments=2",
        "krylov_iterations=",
        "seconds=",
    ] {
        assert!(step.contains(part), "{part} in {step}");
    }
    let user = format!("user {}", own_user());
    for (what, outcome) in [
        ("\"MeshService/UploadMesh\"", "outcome=\"Ok\""),
        ("\"SessionService/CreateSession\"", "outcome=\"Ok\""),
        // Its client and the server end together: either may be first.
        ("\"SessionService/Solve\"", "outcome="),
    ] {
        let call = line(what);
        for part in ["INFO audit: call", &user, "about=\"", outcome] {
            assert!(call.contains(part), "{part} in {call}");
        }
    }
    assert!(!log.contains("audit: call who=unknown"), "{log}");
    let refusal = line("SESSION_NOT_FOUND");
    assert!(refusal.contains("request refused"), "{refusal}");
    assert!(line("session ended").contains("ending=\"shut_down\""));
    assert!(!log.contains('\u{1b}'), "{log}");
}

#[tokio::test]
async fn the_log_of_programs_is_one_object_a_line() {
    let log = log_of("json").await;
    let lines: Vec<serde_json::Value> = log
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    let step = lines.iter().find(|line| line["message"] == "step finished");
    let step = step.unwrap_or_else(|| panic!("no step in\n{log}"));
    assert_eq!(step["termination"], "converged");
    assert_eq!(step["sequence"], 1);
    assert!(step["seconds"].as_f64().unwrap() > 0.0);
    assert!(
        step["span"]["id"]
            .as_str()
            .unwrap()
            .starts_with("sessions/")
    );
}

#[tokio::test]
async fn health_knows_the_services() {
    let server = Server::start().await;
    for service in [
        "",
        "signorini.v1.MeshService",
        "signorini.v1.SessionService",
    ] {
        assert_eq!(
            health(&server, service).await,
            ServingStatus::Serving,
            "{service}"
        );
    }
}

#[tokio::test]
async fn shutdown_delivers_the_last_state_ends_the_streams_and_returns() {
    let (mut server, block) = (Server::start().await, Block::new(2));
    server.upload(&block).await;
    let session = server.session(block.scene()).await;
    let mut stream = server.open(open(&session)).await;
    stream.step(1, press(0.05, 100_000)).await;
    stream.result().await;
    server.signal_stop();
    let last = loop {
        let finished = stream.result().await;
        if finished.last {
            break finished.report.unwrap();
        }
    };
    assert_eq!(last.termination(), wire::Termination::Cancelled);
    assert_eq!(reason(&stream.end().await.unwrap()), "SHUTTING_DOWN");
    server.stopped().await.unwrap();
}

#[tokio::test]
async fn a_server_that_shuts_down_is_not_ready_and_lives() {
    let mut server = Server::start().await;
    let watch = async |service: &str| {
        let request = HealthCheckRequest {
            service: service.to_owned(),
        };
        let call = HealthClient::new(server.channel.clone());
        let mut answers = call.clone().watch(request).await.unwrap().into_inner();
        let first = answers.message().await.unwrap().unwrap();
        assert_eq!(first.status(), ServingStatus::Serving, "{service}");
        answers
    };
    let (mut ready, mut live) = (watch("").await, watch("liveness").await);
    server.signal_stop();
    let changed = ready.message().await.unwrap().unwrap();
    assert_eq!(changed.status(), ServingStatus::NotServing);
    server.stopped().await.unwrap();
    // No other word; the connection may outlive the server.
    let last = tokio::time::timeout(Duration::from_millis(100), live.message()).await;
    assert!(!matches!(last, Ok(Ok(Some(_)))), "{last:?}");
}

#[tokio::test]
async fn a_unix_socket_serves_the_same() {
    let path = std::env::temp_dir().join(format!("signorini-op-{}.sock", std::process::id()));
    let listen = format!("unix:{}", path.display());
    let config = Config {
        listen: listen.clone(),
        ..Config::embedded()
    };
    let server = Server::with(config).await;
    assert_eq!(server.url, listen);
    server.upload(&Block::new(1)).await;
}

#[tokio::test]
async fn reflection_lists_the_services() {
    use tonic_reflection::pb::v1::server_reflection_client::ServerReflectionClient;
    use tonic_reflection::pb::v1::server_reflection_request::MessageRequest;
    use tonic_reflection::pb::v1::server_reflection_response::MessageResponse;
    let server = Server::start().await;
    let request = tonic_reflection::pb::v1::ServerReflectionRequest {
        host: String::new(),
        message_request: Some(MessageRequest::ListServices(String::new())),
    };
    let mut client = ServerReflectionClient::new(server.channel.clone());
    let answers = client
        .server_reflection_info(tokio_stream::iter([request]))
        .await
        .unwrap();
    let answer = answers.into_inner().message().await.unwrap().unwrap();
    let Some(MessageResponse::ListServicesResponse(list)) = answer.message_response else {
        panic!("a list of services is due");
    };
    let names: Vec<_> = list
        .service
        .into_iter()
        .map(|service| service.name)
        .collect();
    assert!(
        names.contains(&"signorini.v1.SessionService".to_owned()),
        "{names:?}"
    );
}

#[tokio::test]
async fn sessions_expire_when_nobody_uses_them() {
    let (server, block) = (Server::start().await, Block::new(1));
    server.upload(&block).await;
    let request = wire::CreateSessionRequest {
        scene: Some(block.scene()),
        ttl: Some(prost_types::Duration {
            seconds: 0,
            nanos: 50_000_000,
        }),
        ..Default::default()
    };
    let created = server
        .sessions()
        .create_session(request)
        .await
        .unwrap()
        .into_inner();
    let name = created.session.unwrap().name;
    // Asked again and again: listing renews no session.
    let gone = async {
        while !list(&server).await.is_empty() {
            tokio::task::yield_now().await;
        }
    };
    tokio::time::timeout(PATIENCE, gone)
        .await
        .expect("the session expires");
    let request = wire::GetSessionRequest { name };
    let status = server.sessions().get_session(request).await.unwrap_err();
    assert_eq!(reason(&status), "SESSION_EXPIRED");
}
