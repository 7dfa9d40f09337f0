//! What probes are told of a data folder that is gone, or that cannot be written.

mod common;

use std::time::Duration;

use common::{Block, Server, answer, folder, open, page, press, reason, sample};
use signorini_proto::v1 as wire;
use signorini_server::Config;
use tokio::sync::{Mutex, MutexGuard};
use tokio::time::{Instant, sleep};
use tonic_health::pb::health_check_response::ServingStatus;
use tonic_health::pb::{HealthCheckRequest, health_client::HealthClient};

/// Points of failure belong to the whole process.
static ALONE: Mutex<()> = Mutex::const_new(());

async fn alone() -> MutexGuard<'static, ()> {
    ALONE.lock().await
}

async fn stop(mut server: Server) {
    server.signal_stop();
    server.stopped().await.unwrap();
}

#[tokio::test]
async fn a_folder_that_was_moved_away_is_noticed_and_nothing_is_taken_until_it_is_back() {
    let _alone = alone().await;
    let folder = folder("moved-away");
    let [data, away] = ["data", "away"].map(|name| folder.join(name));
    let server = Server::with(Config {
        data: data.to_str().unwrap().to_owned(),
        metrics_listen: "127.0.0.1:0".to_owned(),
        ..Config::embedded()
    })
    .await;
    let block = Block::new(1);
    server.upload(&block).await;
    let session = server.session(block.scene()).await;
    let mut stream = server.open(open(&session)).await;
    stream.step(1, press(0.01, 1)).await;
    assert!(stream.result().await.last);
    let url = server.metrics_url.clone().unwrap();
    let is_gone = async |wanted: u64| {
        let end = Instant::now() + Duration::from_secs(10);
        while sample(&page(&url).await, "signorini_data_folder_gone") != wanted {
            assert!(Instant::now() < end, "not within 10 s");
            sleep(Duration::from_millis(100)).await;
        }
    };
    is_gone(0).await;
    std::fs::rename(&data, &away).unwrap();
    is_gone(1).await;
    stream.step(2, press(0.02, 1)).await;
    let rejected = stream.rejection().await;
    assert_eq!(rejected.sequence, 2);
    let why = rejected.status.unwrap().message;
    assert!(why.contains(data.to_str().unwrap()), "{why}");
    let readiness = answer(&url, "GET", "/healthz").await;
    assert!(readiness.starts_with("HTTP/1.1 503"), "{readiness}");
    std::fs::rename(&away, &data).unwrap();
    is_gone(0).await;
    stream.step(2, press(0.02, 1)).await;
    assert!(stream.result().await.last);
    drop(stream);
    stop(server).await;
}

/// A server with an uploaded mesh on a folder of its own, and the address of its page.
async fn ready(name: &str) -> (Server, Block, String) {
    let server = Server::with(Config {
        data: folder(name).join("data").to_str().unwrap().to_owned(),
        metrics_listen: "127.0.0.1:0".to_owned(),
        ..Config::embedded()
    })
    .await;
    let block = Block::new(1);
    server.upload(&block).await;
    let url = server.metrics_url.clone().unwrap();
    (server, block, url)
}

/// Whether both probes say so within 10 s.
async fn becomes(server: &Server, url: &str, is_ready: bool) {
    let mut health = HealthClient::new(server.channel.clone());
    let (page, service) = match is_ready {
        true => ("HTTP/1.1 200", ServingStatus::Serving),
        false => ("HTTP/1.1 503", ServingStatus::NotServing),
    };
    let end = Instant::now() + Duration::from_secs(10);
    loop {
        let shown = answer(url, "GET", "/healthz").await;
        let told = health.check(HealthCheckRequest::default()).await.unwrap();
        if shown.starts_with(page) && told.into_inner().status() == service {
            return;
        }
        assert!(Instant::now() < end, "not within 10 s: {shown}");
        sleep(Duration::from_millis(100)).await;
    }
}

#[tokio::test]
async fn probes_are_told_while_nothing_can_be_written_and_again_when_it_can() {
    let _alone = alone().await;
    let (server, block, url) = ready("not-ready").await;
    becomes(&server, &url, true).await;
    let points = ["journal-commit", "file-write"];
    for point in points {
        fail::cfg(point, "return").unwrap();
    }
    let request = wire::CreateSessionRequest {
        scene: Some(block.scene()),
        ..Default::default()
    };
    let refused = server.sessions().create_session(request).await.unwrap_err();
    assert_eq!(reason(&refused), "DATA_UNWRITABLE");
    becomes(&server, &url, false).await;
    let shown = page(&url).await;
    assert_eq!(sample(&shown, "signorini_data_unwritable"), 1);
    assert!(sample(&shown, "signorini_journal_failures_total") > 0);
    for point in points {
        fail::remove(point);
    }
    // Nobody asks for anything meanwhile.
    becomes(&server, &url, true).await;
    let shown = page(&url).await;
    assert_eq!(sample(&shown, "signorini_data_unwritable"), 0);
    let room = ["free", "size"].map(|what| sample(&shown, &format!("signorini_data_{what}_bytes")));
    assert!(0 < room[0] && room[0] < room[1], "{room:?}");
    stop(server).await;
}
