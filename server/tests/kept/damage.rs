//! What is damaged or lost in a data folder is told as that, with what to do, and backups are
//! apart from what spoils it.

use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};

use crate::common::{Block, Server, folder, open, page, press, reason, sample};
use signorini_proto::v1 as wire;
use signorini_server::{Config, Copying, backup, fsck, restore};
use tonic::Code;

async fn on(data: &Path) -> Server {
    let config = Config {
        data: data.to_str().unwrap().to_owned(),
        metrics_listen: "127.0.0.1:0".to_owned(),
        ..Config::embedded()
    };
    Server::with(config).await
}

async fn stop(mut server: Server) {
    server.signal_stop();
    server.stopped().await.unwrap();
}

/// A stopped server's folder with a session pressed once, and the file of its mesh.
async fn pressed(data: &Path) -> (String, PathBuf) {
    let (server, block) = (on(data).await, Block::new(1));
    let mesh = server.upload(&block).await;
    let session = server.session(block.scene()).await;
    let mut stream = server.open(open(&session)).await;
    stream.step(1, press(0.01, 1)).await;
    assert!(stream.result().await.last);
    drop(stream);
    stop(server).await;
    (session, data.join(mesh))
}

async fn refused(server: &Server, session: &str) -> tonic::Status {
    let request = wire::GetSessionRequest {
        name: session.into(),
    };
    let answer = server.sessions().get_session(request).await;
    answer.expect_err("its mesh is damaged")
}

#[tokio::test(flavor = "multi_thread")]
async fn a_damaged_or_lost_mesh_is_told_as_that_and_mended_by_sending_it_again() {
    let data = folder("damage-mesh").join("data");
    let (session, file) = pressed(&data).await;
    let whole = std::fs::read(&file).unwrap();
    let mut flipped = whole.clone();
    flipped[whole.len() / 2] ^= 1;
    let cut = whole[..whole.len() / 2].to_vec();
    for damage in [Some(flipped), Some(cut), None] {
        match &damage {
            Some(bytes) => std::fs::write(&file, bytes).unwrap(),
            None => std::fs::remove_file(&file).unwrap(),
        }
        assert!(!fsck(&data).unwrap().faults.is_empty());
        let server = on(&data).await;
        let status = refused(&server, &session).await;
        assert_eq!(status.code(), Code::DataLoss);
        assert_eq!(reason(&status), "MESH_DAMAGED");
        assert!(status.message().contains("send it again"), "{status}");
        let url = server.metrics_url.clone().unwrap();
        let series = "signorini_damaged_total{kind=\"mesh\"}";
        assert_eq!(sample(&page(&url).await, series), 1);
        server.upload(&Block::new(1)).await;
        assert_eq!(server.describe(&session).await.last_finished_sequence, 1);
        stop(server).await;
        assert_eq!(fsck(&data).unwrap().faults, Vec::<String>::new());
        assert_eq!(std::fs::read(&file).unwrap(), whole);
    }
}

/// Exports the state of a session and imports it again; its name.
async fn imported(server: &Server, session: &str) -> String {
    use sha2::Digest as _;
    let request = wire::ExportStateRequest {
        name: session.into(),
    };
    let call = server.sessions().export_state(request).await;
    let mut slices = call.unwrap().into_inner();
    let mut bytes = Vec::new();
    while let Some(slice) = slices.message().await.unwrap() {
        bytes.extend_from_slice(&slice.data);
    }
    let digest = signorini_proto::digest::hex(&sha2::Sha256::digest(&bytes).into());
    let slice = wire::ImportStateRequest {
        digest,
        offset: 0,
        data: bytes.into(),
    };
    let call = server
        .sessions()
        .import_state(tokio_stream::iter([slice]))
        .await;
    call.unwrap().into_inner().state
}

#[tokio::test(flavor = "multi_thread")]
async fn a_state_that_is_lost_or_damaged_is_told() {
    let data = folder("damage-state").join("data");
    let (session, _) = pressed(&data).await;
    let server = on(&data).await;
    let state = imported(&server, &session).await;
    let file = data.join(&state);
    let mut bytes = std::fs::read(&file).unwrap();
    bytes[40] ^= 1;
    std::fs::write(&file, bytes).unwrap();
    let request = wire::CreateSessionRequest {
        from_state: state.clone(),
        ..Default::default()
    };
    let refused = server.sessions().create_session(request).await.unwrap_err();
    assert_eq!(
        (refused.code(), reason(&refused).as_str()),
        (Code::DataLoss, "STATE_DAMAGED")
    );
    stop(server).await;
    std::fs::remove_file(&file).unwrap();
    let faults = fsck(&data).unwrap().faults;
    assert_eq!(faults, [format!("{state}: its file is missing")]);
    let server = on(&data).await;
    let url = server.metrics_url.clone().unwrap();
    let series = "signorini_damaged_total{kind=\"state\"}";
    assert_eq!(sample(&page(&url).await, series), 1);
    stop(server).await;
    assert_eq!(fsck(&data).unwrap().faults, Vec::<String>::new());
}

#[tokio::test(flavor = "multi_thread")]
async fn what_spoils_a_data_folder_leaves_its_backup_sound() {
    let tests = folder("damage-backup");
    let data = tests.join("data");
    let (_, file) = pressed(&data).await;
    backup(&data, &tests.join("apart"), Copying::Bytes).unwrap();
    backup(&data, &tests.join("linked"), Copying::Links).unwrap();
    let names = |folder: &str| {
        let copy = tests.join(folder).join(file.strip_prefix(&data).unwrap());
        std::fs::metadata(copy).unwrap().nlink()
    };
    assert_eq!((names("apart"), names("linked")), (1, 2));
    // Eight bytes, in place.
    let mut bytes = std::fs::read(&file).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle..middle + 8].fill(7);
    std::fs::write(&file, bytes).unwrap();
    assert_eq!(
        fsck(&tests.join("apart")).unwrap().faults,
        Vec::<String>::new()
    );
    assert!(!fsck(&tests.join("linked")).unwrap().faults.is_empty());
    let restored = restore(&tests.join("apart"), &tests.join("again")).unwrap();
    assert_eq!((restored.sessions, restored.meshes), (1, 1));
    assert!(restore(&tests.join("linked"), &tests.join("never")).is_err());
    assert!(!tests.join("never").exists());
}
