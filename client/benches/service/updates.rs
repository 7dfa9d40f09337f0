//! Obstacle updates on one stream, and what the way to the solver costs.

use std::time::Instant;

use signorini_client::solve::Attach;
use signorini_server::Config;

use crate::figures::{percentiles, resident};
use crate::server::{Scene, Server, ball, press, result};

/// `count` updates of about 1 % each, at three tolerances.
pub(crate) async fn run(count: u32) {
    for tolerance in [1e-6, 1e-8, 1e-10] {
        let server = Server::start(Config::embedded()).await;
        let scene = Scene::sphere(1).tolerance(tolerance);
        let session = server.session(&scene).await;
        let attach = Attach::default();
        let mut solve = server.client.solve(&session, attach).await.unwrap();
        solve.updates.load_step(press(0.05, 1)).await.unwrap();
        let first = result(&mut solve.events).await;
        let unknowns = first.report.unknowns.unwrap_or_default();
        let (mut times, mut applications) = (Vec::new(), 0);
        let (start, mut early) = (Instant::now(), resident());
        for index in 0..count {
            let depth = 0.05 * (1.0 + 0.01 * f64::from(index % 10));
            let sent = Instant::now();
            solve.updates.obstacle_update(ball(depth)).await.unwrap();
            let report = result(&mut solve.events).await.report;
            times.push(sent.elapsed());
            applications += report.preconditioner_applications;
            if index == count / 4 {
                early = resident();
            }
        }
        let rate = f64::from(count) / start.elapsed().as_secs_f64();
        println!(
            "tolerance {tolerance:.0e}, {} + {} + {} unknowns: {rate:.1} updates/s, {:.1} \
             applications each, resident {early:.1} MiB after a quarter, {:.1} MiB at the end",
            unknowns.displacement,
            unknowns.pressure,
            unknowns.contact,
            f64::from(applications) / f64::from(count),
            resident()
        );
        percentiles("  update", &mut times);
    }
}

/// The time beside the solver's own, for solves of about a second.
pub(crate) async fn overhead(count: u32) {
    let server = Server::start(Config::embedded()).await;
    let scene = Scene::large("hertz-sphere.toml");
    let session = server.session(&scene).await;
    let mut solve = server
        .client
        .solve(&session, Attach::default())
        .await
        .unwrap();
    solve.updates.load_step(press(0.01, 1)).await.unwrap();
    result(&mut solve.events).await;
    for index in 1..=count {
        let start = Instant::now();
        let depth = 0.01 + 0.005 * f64::from(index);
        solve.updates.load_step(press(depth, 1)).await.unwrap();
        let report = result(&mut solve.events).await.report;
        let (all, own) = (start.elapsed().as_secs_f64(), report.seconds.unwrap().total);
        println!(
            "solve {own:.3} s, client {all:.3} s: overhead {:.2} %",
            100.0 * (all / own - 1.0)
        );
    }
}
