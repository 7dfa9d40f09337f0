//! Many watchers of one session on one connection.

use std::time::Instant;

use signorini_client::solve::Attach;
use signorini_proto::v1::{self, watch_response::Message};
use signorini_server::Config;

use crate::figures::resident;
use crate::server::{Scene, Server, press, result};

const INCREMENTS: i32 = 20;

/// `count` watchers, all of which must see every result.
pub(crate) async fn run(count: u32) {
    let server = Server::start(Config::embedded()).await;
    let session = server.session(&Scene::sphere(1)).await;
    let mut solve = server
        .client
        .solve(&session, Attach::default())
        .await
        .unwrap();
    let before = resident();
    let client = server.sessions().await;
    let mut watchers = Vec::new();
    for _ in 0..count {
        let (mut client, name) = (client.clone(), session.clone());
        let request = v1::WatchRequest {
            name,
            ..Default::default()
        };
        let mut answers = client.watch(request).await.unwrap().into_inner();
        answers.message().await.unwrap().unwrap();
        watchers.push(tokio::spawn(async move {
            let (mut results, mut iterations) = (0, 0);
            while results < INCREMENTS {
                match answers.message().await {
                    Ok(Some(answer)) => match answer.message {
                        Some(Message::StepFinished(_)) => results += 1,
                        Some(Message::Iteration(_)) => iterations += 1,
                        _ => {}
                    },
                    Ok(None) | Err(_) => break,
                }
            }
            (results, iterations)
        }));
    }
    let opened = resident();
    let start = Instant::now();
    solve
        .updates
        .load_step(press(0.05, INCREMENTS))
        .await
        .unwrap();
    for _ in 0..INCREMENTS {
        result(&mut solve.events).await;
    }
    let writer = start.elapsed().as_secs_f64();
    let (mut whole, mut iterations) = (0, 0);
    for watcher in watchers {
        let (results, seen) = watcher.await.unwrap();
        whole += u32::from(results == INCREMENTS);
        iterations += seen;
    }
    println!(
        "{count} watchers: {whole} saw all {INCREMENTS} results, {} broken; writer {writer:.2} s, \
         last watcher {:.2} s, {iterations} iterations; {:.1} KiB resident each, client included",
        count - whole,
        start.elapsed().as_secs_f64(),
        1024.0 * (opened - before) / f64::from(count)
    );
}
