//! The live page: what it tells while something runs, and what it keeps to itself.

use std::time::Duration;

use serde_json::Value;
use signorini_proto::v1 as wire;
use signorini_server::Config;

use crate::common::{Block, Server, answer, answer_to, folder, open, press};

/// Ends a test that would wait for ever.
const PATIENCE: Duration = Duration::from_secs(30);

fn with_page() -> Config {
    Config {
        metrics_listen: "127.0.0.1:0".into(),
        ..Config::embedded()
    }
}

/// What stands after the headers of an answer that went well.
pub(crate) fn data(answer: &str) -> Value {
    assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
    let (headers, body) = answer.split_once("\r\n\r\n").unwrap();
    assert!(
        headers.contains("content-type: application/json"),
        "{headers}"
    );
    serde_json::from_str(body).unwrap()
}

async fn look(server: &Server) -> Value {
    data(&answer(server.metrics_url.as_ref().unwrap(), "GET", "/live.json").await)
}

/// Looks until `is_so`.
async fn look_until(server: &Server, is_so: impl Fn(&Value) -> bool) -> Value {
    let end = tokio::time::Instant::now() + PATIENCE;
    loop {
        let live = look(server).await;
        if is_so(&live) {
            return live;
        }
        assert!(tokio::time::Instant::now() < end, "{live:#}");
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
}

/// A scene whose increments take iterations, each of them.
fn of_rubber(mut scene: wire::Scene) -> wire::Scene {
    let law = wire::NeoHookean {
        shear_modulus: Some(1.0),
        bulk_modulus: None,
    };
    scene.materials[0].model = Some(wire::material::Model::NeoHookean(law));
    scene
}

#[tokio::test]
async fn a_server_without_sessions_shows_none() {
    let server = Server::with(with_page()).await;
    let live = look(&server).await;
    assert_eq!(live["sessions"], serde_json::json!([]));
    assert_eq!(
        (&live["left_out"], &live["takes_work"]),
        (&0.into(), &true.into())
    );
    assert_eq!(live["slots"]["busy"], 0);
    assert_eq!(live["memory"]["prepared"], 0);
    assert!(live["memory"]["process_bytes"].as_u64().unwrap() > 1 << 20);
    assert!(live["memory"]["limit_bytes"].as_u64().unwrap() > 1 << 20);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_solve_is_seen_while_it_runs_and_its_results_after() {
    let (server, block) = (Server::with(with_page()).await, Block::new(2));
    server.upload(&block).await;
    let name = server.session(of_rubber(block.scene())).await;
    let mut stream = server.open(open(&name)).await;
    stream.step(1, press(0.3, 3000)).await;
    stream.step(2, press(0.04, 1)).await;
    // Somebody reads, so that the steps go on.
    let reading = tokio::spawn(async move {
        let mut ended = 0;
        while ended < 2 {
            ended += usize::from(stream.result().await.last);
        }
    });
    let runs = |live: &Value| {
        let one = &live["sessions"][0];
        !one["runs"]["iteration"].is_null() && !one["latest"].is_null() && one["waiting"] == 1
    };
    let live = look_until(&server, runs).await;
    let one = &live["sessions"][0];
    assert_eq!(
        (&one["name"], &one["scene"]),
        (&name.as_str().into(), &"block".into())
    );
    assert_eq!(
        (&one["state"], &one["attached"]),
        (&"running".into(), &true.into())
    );
    assert!(one["age_seconds"].as_f64().unwrap() < PATIENCE.as_secs_f64());
    assert!(one["memory_bytes"].as_u64().unwrap() > 0);
    assert_eq!((&one["accepted"], &one["finished"]), (&2.into(), &0.into()));
    assert_eq!(one["runs"]["increments"], 3000);
    let iteration = &one["runs"]["iteration"];
    assert_eq!(iteration["step"], 1);
    assert!(iteration["sqp_iteration"].as_u64().unwrap() >= 1);
    assert!(iteration["residuals"]["equilibrium"].is_number());
    assert_eq!(one["latest"]["termination"], "converged");
    assert_eq!(live["memory"]["prepared"], 1);
    assert!(live["memory"]["prepared_bytes"].as_u64().unwrap() > 0);
    let cancel = wire::CancelStepRequest {
        name: name.clone(),
        sequence: 1,
    };
    server.sessions().cancel_step(cancel).await.unwrap();
    reading.await.unwrap();
    let is_idle = |live: &Value| live["sessions"][0]["runs"].is_null();
    let live = look_until(&server, is_idle).await;
    assert_eq!(live["sessions"][0]["state"], "active");
    assert_eq!(live["sessions"][0]["finished"], 2);
}

#[tokio::test]
async fn looking_does_not_keep_a_session_alive() {
    let (server, block) = (Server::with(with_page()).await, Block::new(1));
    server.upload(&block).await;
    let request = wire::CreateSessionRequest {
        scene: Some(block.scene()),
        ttl: crate::common::duration(300),
        ..Default::default()
    };
    server.sessions().create_session(request).await.unwrap();
    let is_gone = |live: &Value| live["sessions"] == serde_json::json!([]);
    look_until(&server, is_gone).await;
}

#[tokio::test]
async fn names_of_clients_travel_as_text() {
    let (server, block) = (Server::with(with_page()).await, Block::new(1));
    server.upload(&block).await;
    let hostile = "</script><img src=x onerror=alert(1)>\"\u{202e}";
    let scene = wire::Scene {
        name: hostile.into(),
        ..block.scene()
    };
    server.session(scene).await;
    let url = server.metrics_url.as_ref().unwrap();
    let live = answer(url, "GET", "/live.json").await;
    assert!(live.contains("x-content-type-options: nosniff"), "{live}");
    assert_eq!(data(&live)["sessions"][0]["scene"], hostile);
    // The page itself holds nothing of the server.
    assert!(!answer(url, "GET", "/live").await.contains("onerror"));
}

#[tokio::test]
async fn the_page_comes_with_a_policy_that_lets_nothing_else_in() {
    let server = Server::with(with_page()).await;
    let url = server.metrics_url.as_ref().unwrap();
    for path in ["/live", "/live.json"] {
        let found = answer(url, "GET", path).await;
        let policy = "content-security-policy: default-src 'none'; style-src 'sha256-";
        for part in [policy, "cache-control: no-store", "x-frame-options: DENY"] {
            assert!(found.contains(part), "{part} in {found}");
        }
        assert!(!found.contains("access-control-allow"), "{found}");
    }
    assert!(answer(url, "GET", "/").await.contains("/live "));
    let post = answer(url, "POST", "/live.json").await;
    assert!(post.starts_with("HTTP/1.1 405"), "{post}");
}

#[tokio::test]
async fn there_is_no_page_where_there_are_no_metrics() {
    let server = Server::start().await;
    assert_eq!(server.metrics_url, None);
}

#[tokio::test]
async fn a_site_whose_name_was_made_to_lead_here_reads_nothing() {
    let server = Server::with(with_page()).await;
    let url = server.metrics_url.as_ref().unwrap();
    let asked = "GET /live.json";
    let refused = answer_to(url, asked, &[("Host", "evil.example:9464")]).await;
    assert!(refused.starts_with("HTTP/1.1 403"), "{refused}");
    let found = answer_to(url, asked, &[("Host", "localhost:9464")]).await;
    assert!(found.starts_with("HTTP/1.1 200"), "{found}");
}

#[tokio::test]
async fn what_a_private_socket_hides_the_page_does_not_tell() {
    let path = folder("live-socket").join("s.sock");
    let config = Config {
        listen: format!("unix:{}", path.display()),
        ..with_page()
    };
    let server = Server::with(config).await;
    let url = server.metrics_url.as_ref().unwrap();
    let refused = answer(url, "GET", "/live.json").await;
    assert!(refused.starts_with("HTTP/1.1 403"), "{refused}");
    assert!(refused.contains("`tokens`"), "{refused}");
}
