//! Scenes that cannot be solved, in a loop.

use std::time::{Duration, Instant};

use signorini_client::NewSession;
use signorini_client::solve::{Attach, Event};
use signorini_proto::v1;
use signorini_server::Config;

use crate::figures::resident;
use crate::server::{Scene, Server, press};

/// Diverging, inverted, not a number and too large, for `seconds`.
pub(crate) async fn run(seconds: u32) {
    let config = Config {
        memory_budget_bytes: 12 << 20,
        ..Config::embedded()
    };
    let server = Server::start(config).await;
    let scene = Scene::sphere(1);
    let large = Scene::sphere(3);
    for scene in [&scene, &large] {
        server.client.upload_mesh(scene.mesh.clone()).await.unwrap();
    }
    let end = Instant::now() + Duration::from_secs(seconds.into());
    let (mut rounds, mut outcomes) = (0, std::collections::BTreeMap::new());
    let mut early = f64::NAN;
    while Instant::now() < end {
        for (what, scene, step) in cases(&scene.message, &large.message, rounds) {
            let outcome = attempt(&server, scene, step).await;
            *outcomes.entry((what, outcome)).or_insert(0_u32) += 1;
        }
        rounds += 1;
        if rounds == 20 {
            early = resident();
        }
    }
    for ((what, outcome), count) in outcomes {
        println!("  {what}: {outcome} ({count} times)");
    }
    println!(
        "{rounds} rounds, resident {early:.1} MiB after 20, {:.1} MiB at the end",
        resident()
    );
}

fn cases(
    scene: &v1::Scene,
    large: &v1::Scene,
    round: u32,
) -> Vec<(&'static str, v1::Scene, v1::LoadStep)> {
    let wild = [0.4, 0.7, 1.0, 1.5, 10.0, 1e9][round as usize % 6];
    let with = |change: &dyn Fn(&mut v1::Scene)| {
        let mut scene = scene.clone();
        change(&mut scene);
        scene
    };
    let hurried = |scene: &mut v1::Scene| {
        scene.solver.get_or_insert_default().max_wall_time = Some(0.2);
    };
    vec![
        ("too large", large.clone(), press(0.05, 1)),
        ("pressed through the body", with(&hurried), press(wild, 1)),
        (
            "tolerance out of reach",
            with(&|scene| {
                hurried(scene);
                scene.solver.get_or_insert_default().tolerance = Some(1e-14);
            }),
            press(0.05, 1),
        ),
        (
            "turned inside out",
            with(&|scene| {
                hurried(scene);
                scene.mesh_scale = Some(-1.0);
            }),
            press(0.05, 1),
        ),
        (
            "tiny",
            with(&|scene| {
                hurried(scene);
                scene.mesh_scale = Some(1e-300);
            }),
            press(0.05, 1),
        ),
        (
            "not a number in the scene",
            with(&|scene| {
                scene.probes.push(v1::Probe {
                    name: "p".to_owned(),
                    point: vec![f64::NAN, 0.0, 0.0],
                });
            }),
            press(0.05, 1),
        ),
        (
            "not a number in the step",
            scene.clone(),
            press(f64::NAN, 1),
        ),
        ("infinite step", scene.clone(), press(f64::INFINITY, 1)),
        (
            "nothing holds it",
            with(&|scene| {
                hurried(scene);
                scene.supports.clear();
            }),
            press(0.05, 1),
        ),
    ]
}

async fn attempt(server: &Server, scene: v1::Scene, step: v1::LoadStep) -> String {
    let new = NewSession {
        scene,
        ..Default::default()
    };
    let session = match server.client.create_session(new).await {
        Ok((session, _)) => session.name,
        Err(error) => return format!("refused, {}", reason(&error)),
    };
    let mut solve = server
        .client
        .solve(&session, Attach::default())
        .await
        .unwrap();
    solve.updates.load_step(step).await.unwrap();
    let outcome = loop {
        match solve.events.next().await {
            Ok(Some(Event::Increment(increment))) if increment.last => {
                let report = &increment.report;
                break format!(
                    "{} {}",
                    report.termination().as_str_name(),
                    report.cause().as_str_name()
                );
            }
            Ok(Some(Event::Rejected { refusal, .. })) => {
                break format!("rejected, {}", refusal.reason);
            }
            Ok(Some(_)) => {}
            Ok(None) => break "no answer".to_owned(),
            Err(error) => break format!("broken, {}", reason(&error)),
        }
    };
    drop(solve);
    server.client.delete_session(&session).await.unwrap();
    outcome
}

fn reason(error: &signorini_client::ClientError) -> String {
    error
        .refusal()
        .map_or_else(|| error.to_string(), |refusal| refusal.reason.clone())
}
