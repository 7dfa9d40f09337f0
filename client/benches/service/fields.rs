//! Fields of kept results, read again and again.

use std::time::Instant;

use signorini_client::solve::Attach;
use signorini_proto::v1::{self, read_step_response::Message};
use signorini_server::Config;

use crate::server::{Scene, Server, result};

/// Reads one result's fields `count` times.
pub(crate) async fn run(count: u32) {
    let server = Server::start(Config::embedded()).await;
    let scene = Scene::large("cube-bend.toml");
    let session = server.session(&scene).await;
    let fields = [
        v1::FieldName::Displacement,
        v1::FieldName::Pressure,
        v1::FieldName::Stress,
        v1::FieldName::Jacobian,
    ];
    let attach = Attach {
        fields: fields.to_vec(),
        ..Default::default()
    };
    let mut solve = server.client.solve(&session, attach).await.unwrap();
    solve
        .updates
        .load_step(v1::LoadStep::default())
        .await
        .unwrap();
    result(&mut solve.events).await;
    let mut client = server.sessions().await;
    let request = v1::ReadStepRequest {
        name: session.clone(),
        sequence: 1,
        fields: fields.map(i32::from).to_vec(),
        ..Default::default()
    };
    let (start, mut bytes) = (Instant::now(), 0);
    for _ in 0..count {
        let answers = client.read_step(request.clone()).await.unwrap();
        let mut answers = answers.into_inner();
        while let Some(answer) = answers.message().await.unwrap() {
            if let Some(Message::Field(chunk)) = answer.message {
                bytes += chunk.data.len();
            }
        }
    }
    rate("read", bytes, start);
    let (start, mut bytes) = (Instant::now(), 0);
    for _ in 0..count {
        let results = server.client.read_step(&session, 1, &fields).await.unwrap();
        let fields = results.iter().flat_map(|one| &one.fields);
        bytes += fields.map(|field| 8 * field.values.len()).sum::<usize>();
    }
    rate("read and put together as numbers", bytes, start);
}

fn rate(what: &str, bytes: usize, start: Instant) {
    let seconds = start.elapsed().as_secs_f64();
    let mebibytes = bytes as f64 / f64::from(1 << 20);
    println!(
        "{what}: {mebibytes:.0} MiB in {seconds:.2} s, {:.0} MB/s",
        bytes as f64 / 1e6 / seconds
    );
}
