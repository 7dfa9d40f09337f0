//! Cancels at random moments of preparation and solve.

use std::time::{Duration, Instant};

use signorini_client::solve::Attach;
use signorini_proto::v1::Termination;
use signorini_server::Config;

use crate::figures::percentiles;
use crate::server::{Scene, Server, press, result};

/// `count` steps, each cancelled after a random time from a second connection.
pub(crate) async fn run(count: u32) {
    let server = Server::start(Config::embedded()).await;
    let scenes = [Scene::sphere(1), Scene::sphere(2), Scene::sphere(3)];
    let other = server.connect().await;
    let mut random = fastrand::Rng::with_seed(1);
    let (mut times, mut stopped) = (Vec::new(), 0);
    for index in 0..count {
        let scene = &scenes[random.usize(..scenes.len())];
        let session = server.session(scene).await;
        let mut solve = server
            .client
            .solve(&session, Attach::default())
            .await
            .unwrap();
        solve.updates.load_step(press(0.05, 3)).await.unwrap();
        tokio::time::sleep(Duration::from_micros(random.u64(..40_000))).await;
        let asked = Instant::now();
        other.cancel_step(&session, 0).await.unwrap();
        let mut last = result(&mut solve.events).await;
        while !last.last {
            last = result(&mut solve.events).await;
        }
        if last.report.termination() == Termination::Cancelled {
            stopped += 1;
            times.push(asked.elapsed());
        }
        drop(solve);
        server.client.delete_session(&session).await.unwrap();
        if index % 1000 == 999 {
            // The prepared data are built anew, so that cancels meet factorisations.
            for scene in &scenes {
                server
                    .client
                    .delete_mesh(scene.mesh.digest())
                    .await
                    .unwrap();
            }
        }
    }
    println!("{count} cancels, {stopped} before the end of the step");
    percentiles("answer", &mut times);
    let session = server.session(&scenes[0]).await;
    let mut solve = server
        .client
        .solve(&session, Attach::default())
        .await
        .unwrap();
    solve.updates.load_step(press(0.05, 1)).await.unwrap();
    let last = result(&mut solve.events).await;
    println!("the server still solves: {:?}", last.report.termination());
}
