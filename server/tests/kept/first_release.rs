//! A data folder of the first release, which every later build goes on from.
//!
//! `first_release/` was written by a server of format 1 on AVX-512: `Block::new(1)` pressed by three
//! steps, with a saved state, and its exported state imported again.

use std::path::Path;

use crate::common::{Server, folder, open, press};
use signorini_proto::v1 as wire;
use signorini_server::{Config, fsck};

const SESSION: &str = "sessions/first-release";

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let (path, target) = (entry.path(), to.join(entry.file_name()));
        if path.is_dir() {
            copy(&path, &target);
        } else {
            std::fs::copy(&path, &target).unwrap();
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_data_folder_of_the_first_release_goes_on() {
    let data = folder("first-release").join("data");
    let written = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/kept/first_release");
    copy(&written, &data);
    let found = fsck(&data).unwrap();
    assert_eq!(found.faults, Vec::<String>::new());
    let counts = (found.sessions, found.results, found.meshes, found.states);
    assert_eq!(counts, (1, 3, 1, 1));
    let config = Config {
        data: data.to_str().unwrap().to_owned(),
        ..Config::embedded()
    };
    let mut server = Server::with(config).await;
    let described = server.describe(SESSION).await;
    assert_eq!(described.last_finished_sequence, 3);
    for sequence in 1..=3 {
        assert!(server.read(SESSION, sequence, 0).await.0.last);
    }
    let mut stream = server.open(open(SESSION)).await;
    stream.step(4, press(0.04, 1)).await;
    let report = stream.result().await.report.unwrap();
    assert_eq!(report.termination(), wire::Termination::Converged);
    drop(stream);
    let restore = wire::RestoreStateRequest {
        name: SESSION.into(),
        save: 1,
    };
    let restored = server.sessions().restore_state(restore).await;
    // A state keeps its bits, so that it goes on where they can be the same ones only.
    match report.instruction_set.as_str() {
        "avx512" => assert!(restored.is_ok(), "{restored:?}"),
        other => {
            let refused = restored
                .expect_err("a state of AVX-512")
                .message()
                .to_owned();
            assert!(refused.contains(&format!("here `{other}`")), "{refused}");
        }
    }
    server.signal_stop();
    server.stopped().await.unwrap();
    assert_eq!(fsck(&data).unwrap().results, 4);
}
