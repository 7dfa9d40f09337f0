//! Control calls while all solver threads work, and shares of two clients.

use std::time::{Duration, Instant};

use signorini_proto::v1;
use signorini_server::Config;

use crate::figures::percentiles;
use crate::server::{Scene, Server, ball, pressed, result};

const CLIENTS: u32 = 64;
/// Between two calls of one client.
const PAUSE: Duration = Duration::from_millis(100);

/// `count` calls of 64 clients, spread over the time, beside two solves without end.
pub(crate) async fn run(count: u32) {
    let server = Server::start(Config::embedded()).await;
    let scene = Scene::sphere(3);
    let mut busy = Vec::new();
    for _ in 0..2 {
        let session = server.session(&scene).await;
        let solve = pressed(&server.client, &session, 100_000).await;
        busy.push((session, solve));
    }
    for (what, pause) in [("paced", PAUSE), ("without a pause", Duration::ZERO)] {
        let mut calls = Vec::new();
        for number in 0..CLIENTS {
            let (client, name) = (server.sessions().await, busy[0].0.clone());
            let start = PAUSE * number / CLIENTS;
            calls.push(tokio::spawn(call(
                client,
                name,
                count / CLIENTS,
                start,
                pause,
            )));
        }
        let mut times = Vec::new();
        for one in calls {
            times.extend(one.await.unwrap());
        }
        percentiles(what, &mut times);
    }
}

async fn call(
    mut client: v1::session_service_client::SessionServiceClient<tonic::transport::Channel>,
    name: String,
    count: u32,
    start: Duration,
    pause: Duration,
) -> Vec<Duration> {
    tokio::time::sleep(start).await;
    let mut times = Vec::new();
    for index in 0..count.max(1) {
        let sent = Instant::now();
        match index % 3 {
            0 => drop(
                client
                    .get_session(v1::GetSessionRequest { name: name.clone() })
                    .await
                    .unwrap(),
            ),
            1 => drop(
                client
                    .list_sessions(v1::ListSessionsRequest::default())
                    .await
                    .unwrap(),
            ),
            _ => {
                let (name, sequence) = (name.clone(), 999);
                let request = v1::CancelStepRequest { name, sequence };
                drop(client.cancel_step(request).await.unwrap());
            }
        }
        times.push(sent.elapsed());
        tokio::time::sleep(pause).await;
    }
    times
}

/// Updates a second of one client: alone, and beside one that floods.
pub(crate) async fn flood(count: u32) {
    let server = Server::start(Config::embedded()).await;
    let scene = Scene::sphere(2);
    let alone = rate(&server, &scene, count).await;
    let mut flood = Vec::new();
    for _ in 0..16 {
        let session = server.session(&scene).await;
        let mut solve = pressed(&server.client, &session, 100_000).await;
        tokio::spawn(async move { while let Ok(Some(_)) = solve.events.next().await {} });
        flood.push((session, solve.updates));
    }
    let beside = rate(&server, &scene, count).await;
    println!(
        "alone {alone:.1} updates/s, beside a flood {beside:.1}: {:.0} %",
        100.0 * beside / alone
    );
}

async fn rate(server: &Server, scene: &Scene, count: u32) -> f64 {
    let client = server.connect().await;
    let session = server.session(scene).await;
    let mut solve = pressed(&client, &session, 1).await;
    let start = Instant::now();
    for index in 0..count {
        let depth = 0.05 * (1.0 + 0.01 * f64::from(index % 10));
        solve.updates.obstacle_update(ball(depth)).await.unwrap();
        result(&mut solve.events).await;
    }
    f64::from(count) / start.elapsed().as_secs_f64()
}
