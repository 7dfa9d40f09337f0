//! Cancels at random moments: every one is answered, no slot is lost.
//!
//! `SIGNORINI_CANCELS` sets their number.

use std::time::Duration;

use crate::common::{Block, Server, open, press};
use signorini_proto::v1 as wire;

/// Ends a test that would wait for ever.
const PATIENCE: Duration = Duration::from_secs(60);

fn count() -> u64 {
    let asked = std::env::var("SIGNORINI_CANCELS").ok();
    asked.and_then(|count| count.parse().ok()).unwrap_or(300)
}

#[tokio::test(flavor = "multi_thread")]
async fn cancels_at_random_moments_are_all_answered_and_no_slot_is_lost() {
    let server = Server::start().await;
    let blocks = [1, 2, 3, 4].map(Block::new);
    for block in &blocks {
        server.upload(block).await;
    }
    let mut random = fastrand::Rng::with_seed(7);
    let mut endings = std::collections::BTreeMap::new();
    for _ in 0..count() {
        let block = &blocks[random.usize(..blocks.len())];
        let session = server.session(block.scene()).await;
        let mut stream = server.open(open(&session)).await;
        stream.step(1, press(0.05, random.i32(1..4))).await;
        // From preparation to the end of the step, by the clock of the solver.
        for _ in 0..random.u32(..200) {
            tokio::task::yield_now().await;
        }
        server.cancel(&session).await;
        let last = async { while !stream.result().await.last {} };
        tokio::time::timeout(PATIENCE, last)
            .await
            .expect("an answer");
        let request = wire::DeleteSessionRequest { name: session };
        server.sessions().delete_session(request).await.unwrap();
        *endings.entry(block.cells.len()).or_insert(0) += 1;
    }
    assert_eq!(endings.len(), blocks.len());
    // Every slot still takes a step: as many sessions as there are slots, at once.
    let mut streams = Vec::new();
    for _ in 0..2 {
        let session = server.session(blocks[3].scene()).await;
        let stream = server.open(open(&session)).await;
        stream.step(1, press(0.05, 1)).await;
        streams.push(stream);
    }
    for mut stream in streams {
        let finished = tokio::time::timeout(PATIENCE, stream.result()).await;
        let report = finished.expect("a free slot").report.unwrap();
        assert_eq!(report.termination(), wire::Termination::Converged);
    }
}
