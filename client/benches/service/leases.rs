//! Sessions that are opened, used and abandoned without a word.

use std::time::Duration;

use signorini_client::NewSession;
use signorini_client::solve::Attach;
use signorini_server::Config;

use crate::figures::resident;
use crate::server::{Scene, Server, press, result};

/// `count` sessions, abandoned in the middle of a step.
pub(crate) async fn run(count: u32) {
    let server = Server::start(Config::embedded()).await;
    let scene = Scene::sphere(1);
    server.client.upload_mesh(scene.mesh.clone()).await.unwrap();
    let mut early = f64::NAN;
    for index in 0..count {
        let client = server.connect().await;
        let new = NewSession {
            scene: scene.message.clone(),
            ttl: Some(Duration::from_millis(500)),
            ..Default::default()
        };
        let Ok((session, _)) = client.create_session(new).await else {
            // All sessions are in use until some expire.
            tokio::time::sleep(Duration::from_millis(50)).await;
            continue;
        };
        let mut solve = client
            .solve(&session.name, Attach::default())
            .await
            .unwrap();
        solve.updates.load_step(press(0.05, 2)).await.unwrap();
        if index % 2 == 0 {
            result(&mut solve.events).await;
        }
        drop((solve, client));
        if index == count / 10 {
            early = settled(&server).await;
        }
    }
    let end = settled(&server).await;
    println!(
        "{count} sessions abandoned: resident {early:.1} MiB after a tenth, {end:.1} MiB at the \
         end ({:+.1} %)",
        100.0 * (end / early - 1.0)
    );
}

/// Resident memory when every session is gone.
async fn settled(server: &Server) -> f64 {
    while !server.client.list_sessions().await.unwrap().is_empty() {
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    resident()
}
