//! Results do not depend on whether a server has a data folder.

use std::path::Path;

use crate::common::{Block, Server, bare, folder, open, press};
use signorini_proto::v1 as wire;
use signorini_server::Config;

const STEPS: i64 = 40;

/// Presses to and fro on a server that writes checkpoints often, or would.
async fn pressed(data: Option<&Path>) -> Vec<wire::StepFinished> {
    let config = Config {
        data: data.map_or_else(String::new, |data| data.to_str().unwrap().to_owned()),
        maximum_in_flight: 8,
        retained_results: 9,
        ..Config::embedded()
    };
    let (server, block) = (Server::with(config).await, Block::new(2));
    server.upload(&block).await;
    let session = server.session(block.scene()).await;
    let mut stream = server.open(open(&session)).await;
    let mut results = Vec::new();
    for sequence in 1..=STEPS {
        let depth = 0.01 + 0.003 * ((sequence * 7) % 11) as f64;
        stream.step(sequence, press(depth, 1)).await;
        results.push(bare(stream.result().await));
    }
    results
}

#[tokio::test(flavor = "multi_thread")]
async fn a_data_folder_changes_no_bit_of_a_result() {
    let data = folder("same-bits").join("data");
    let (with, without) = (pressed(Some(&data)).await, pressed(None).await);
    for (with, without) in with.iter().zip(&without) {
        assert_eq!(with, without);
    }
    assert_eq!(with.len() as i64, STEPS);
}
