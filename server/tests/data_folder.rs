//! What the data folder is good for beside kills: refusals of the disk, damage, states
//! that travel, backups.

mod common;

use std::path::{Path, PathBuf};
use std::time::Duration;

use common::{Block, Process, Server, Stream, folder, open, press, reason};
use signorini_proto::v1::{self as wire, solve_response::Message};
use signorini_server::{Config, Copying, JournalError, backup, fsck, restore};
use tokio::sync::{Mutex, MutexGuard};
use tonic::Code;

/// Points of failure belong to the whole process.
static ALONE: Mutex<()> = Mutex::const_new(());

/// One test at a time, all points of failure off.
async fn alone() -> MutexGuard<'static, ()> {
    let guard = ALONE.lock().await;
    for point in [
        "journal-commit",
        "file-write",
        "file-sync",
        "file-rename",
        "folder-sync",
    ] {
        fail::remove(point);
    }
    guard
}

async fn on(data: &Path) -> Server {
    let config = Config {
        data: data.to_str().unwrap().to_owned(),
        ..Config::embedded()
    };
    Server::with(config).await
}

async fn stop(mut server: Server) {
    server.signal_stop();
    server.stopped().await.unwrap();
}

/// A server on `data` with a session pressed so many steps.
async fn pressed(data: &Path, steps: i64) -> (Server, String) {
    let (server, block) = (on(data).await, Block::new(1));
    server.upload(&block).await;
    let session = server.session(block.scene()).await;
    let mut stream = server.open(open(&session)).await;
    for sequence in 1..=steps {
        stream
            .step(sequence, press(0.01 * sequence as f64, 1))
            .await;
        assert!(stream.result().await.last);
    }
    (server, session)
}

/// A stream that writes to a session whose last stream may have ended just now, which the server
/// has perhaps not noticed yet.
async fn opened_again(server: &Server, session: &str) -> Stream {
    loop {
        let mut stream = server.stream(open(session)).await;
        match stream.try_next().await {
            Ok(Message::Opened(_)) => return stream,
            Ok(other) => panic!("{other:?} instead of `opened`"),
            Err(status) => assert_eq!(reason(&status), "SESSION_BUSY"),
        }
    }
}

/// Presses once more, as `sequence`.
async fn force(server: &Server, session: &str, sequence: i64) -> Vec<u64> {
    let mut stream = opened_again(server, session).await;
    stream.step(sequence, press(0.05, 1)).await;
    let report = stream.result().await.report.unwrap();
    assert_eq!(report.termination(), wire::Termination::Converged);
    report.obstacles["ball"]
        .force
        .iter()
        .map(|one| one.to_bits())
        .collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn a_server_that_was_stopped_goes_on_and_a_deleted_session_stays_away() {
    let _alone = alone().await;
    let data = folder("stopped").join("data");
    let (server, session) = pressed(&data, 3).await;
    let deleted = server.session(Block::new(1).scene()).await;
    let request = wire::DeleteSessionRequest {
        name: deleted.clone(),
    };
    server.sessions().delete_session(request).await.unwrap();
    let kept = server.read(&session, 2, 0).await;
    stop(server).await;
    let server = on(&data).await;
    assert_eq!(server.read(&session, 2, 0).await, kept);
    let request = wire::GetSessionRequest { name: deleted };
    let refused = server.sessions().get_session(request).await.unwrap_err();
    assert_eq!(reason(&refused), "SESSION_NOT_FOUND");
    let described = server.describe(&session).await;
    assert_eq!(described.last_finished_sequence, 3);
    force(&server, &session, 4).await;
    stop(server).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_full_disk_refuses_what_is_new_and_loses_nothing_that_was_answered() {
    let _alone = alone().await;
    let data = folder("full").join("data");
    let (server, session) = pressed(&data, 2).await;
    fail::cfg("journal-commit", "return").unwrap();
    let mut stream = opened_again(&server, &session).await;
    stream.step(3, press(0.04, 1)).await;
    let end = stream.end().await.expect("the stream cannot go on");
    assert_eq!(
        (end.code(), reason(&end).as_str()),
        (Code::Unavailable, "DATA_UNWRITABLE")
    );
    let request = wire::CreateSessionRequest {
        scene: Some(Block::new(1).scene()),
        ..Default::default()
    };
    let refused = server.sessions().create_session(request).await.unwrap_err();
    assert_eq!(reason(&refused), "DATA_UNWRITABLE");
    fail::remove("journal-commit");
    // The client asks for the same again, as after any break.
    let described = server.describe(&session).await;
    // Its result is made again where the disk had not taken it yet.
    assert_eq!(described.last_accepted_sequence, 2);
    force(&server, &session, 3).await;
    // What was answered can be read again.
    assert!(server.read(&session, 2, 0).await.0.last);
    stop(server).await;
    let server = on(&data).await;
    assert_eq!(server.describe(&session).await.last_accepted_sequence, 3);
    stop(server).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_mesh_whose_file_fails_is_refused_and_leaves_no_part() {
    let _alone = alone().await;
    let data = folder("torn").join("data");
    let (server, block) = (on(&data).await, Block::new(2));
    // An answer comes when the folder is open.
    let list = wire::ListMeshesRequest::default();
    server.meshes().list_meshes(list).await.unwrap();
    for point in ["file-write", "file-sync", "file-rename"] {
        fail::cfg(point, "return").unwrap();
        let parts = tokio_stream::iter(block.messages());
        let refused = server.meshes().upload_mesh(parts).await.unwrap_err();
        assert_eq!(reason(&refused), "DATA_UNWRITABLE");
        fail::remove(point);
        let left = std::fs::read_dir(data.join("meshes")).unwrap().count();
        assert_eq!(left, 0, "{point}");
    }
    server.upload(&block).await;
    stop(server).await;
    // What a kill leaves beside its place goes with the next start.
    std::fs::write(data.join("meshes/half.part"), b"half").unwrap();
    let server = on(&data).await;
    server.session(block.scene()).await;
    assert!(!data.join("meshes/half.part").exists());
    stop(server).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_mesh_on_its_way_is_found_by_nobody_and_is_entered_though_somebody_asks_for_it() {
    let _alone = alone().await;
    let data = folder("on-its-way").join("data");
    let (server, block) = (on(&data).await, Block::new(2));
    // An answer comes when the folder is open.
    let list = wire::ListMeshesRequest::default();
    server.meshes().list_meshes(list.clone()).await.unwrap();
    // The disk is slow when the file has its name already.
    fail::cfg("folder-sync", "sleep(1000)").unwrap();
    let (mut meshes, parts) = (server.meshes(), tokio_stream::iter(block.messages()));
    let upload = tokio::spawn(async move { meshes.upload_mesh(parts).await });
    let name = format!("meshes/{}", block.digest());
    while !data.join(&name).exists() {
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    let asked = wire::GetMeshRequest { name };
    let missing = server.meshes().get_mesh(asked).await.unwrap_err();
    assert_eq!(reason(&missing), "MESH_NOT_FOUND");
    let uploaded = upload.await.unwrap().unwrap().into_inner();
    assert!(!uploaded.already_present);
    fail::remove("folder-sync");
    stop(server).await;
    let server = on(&data).await;
    let listed = server.meshes().list_meshes(list).await.unwrap();
    assert_eq!(listed.into_inner().meshes.len(), 1);
    stop(server).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_damaged_page_is_refused_by_its_name_and_the_rest_serves() {
    let _alone = alone().await;
    let data = folder("damaged").join("data");
    let (server, session) = pressed(&data, 2).await;
    let other = server.session(Block::new(1).scene()).await;
    stop(server).await;
    assert_eq!(fsck(&data).unwrap().faults, Vec::<String>::new());
    // One byte inside a stored report, of which the seal is looked at whenever it is read.
    let path = data.join("journal.redb");
    let mut bytes = std::fs::read(&path).unwrap();
    let places: Vec<usize> = (0..bytes.len() - 8)
        .filter(|place| bytes[*place..].starts_with(b"\x0a\x04ball"))
        .collect();
    assert!(!places.is_empty());
    for place in places {
        bytes[place + 2] ^= 0x20;
    }
    std::fs::write(&path, bytes).unwrap();
    let found = fsck(&data).unwrap();
    assert!(!found.faults.is_empty());
    let server = on(&data).await;
    let request = wire::GetSessionRequest { name: session };
    let refused = server.sessions().get_session(request).await.unwrap_err();
    assert_eq!(
        (refused.code(), reason(&refused).as_str()),
        (Code::DataLoss, "SESSION_DAMAGED")
    );
    let _ = other;
    let parts = tokio_stream::iter(Block::new(1).messages());
    server.meshes().upload_mesh(parts).await.unwrap();
    stop(server).await;
}

#[test]
fn folders_that_do_not_serve_are_refused_with_what_is_wrong() {
    let tests = folder("refused");
    let runtime = tokio::runtime::Runtime::new().unwrap();
    let _alone = runtime.block_on(alone());
    std::fs::write(tests.join("server.toml"), "metrics_listen = \"\"\n").unwrap();
    // Not a folder.
    std::fs::write(tests.join("data"), b"a file").unwrap();
    assert!(
        Process::refusal(&tests).contains("data"),
        "names the folder"
    );
    std::fs::remove_file(tests.join("data")).unwrap();
    // Of another server.
    let data = tests.join("data");
    let server = runtime.block_on(on(&data));
    // Whoever is answered finds the folder open; a connection alone may be early.
    let list = wire::ListSessionsRequest::default();
    let answer = runtime.block_on(server.sessions().list_sessions(list));
    assert!(answer.is_ok());
    assert!(Process::refusal(&tests).contains("another server"));
    assert!(matches!(fsck(&data), Err(JournalError::InUse(_))));
    runtime.block_on(stop(server));
    // Of a later format.
    std::fs::write(data.join("FORMAT"), "signorini data 9\n").unwrap();
    assert!(Process::refusal(&tests).contains("signorini data 9"));
    std::fs::write(data.join("FORMAT"), "signorini data 1\n").unwrap();
    // No database at all.
    std::fs::write(data.join("journal.redb"), vec![7; 8192]).unwrap();
    assert!(!Process::refusal(&tests).contains("panicked"));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_state_travels_to_another_server_and_goes_on_with_the_same_bits() {
    let _alone = alone().await;
    let tests = folder("travels");
    let (here, session) = pressed(&tests.join("here"), 3).await;
    let bytes = export(&here, &session).await;
    let there = on(&tests.join("there")).await;
    let memory = Server::start().await;
    let expected = force(&here, &session, 4).await;
    for server in [&there, &memory] {
        server.upload(&Block::new(1)).await;
        let state = import(server, &bytes).await.unwrap();
        let request = wire::CreateSessionRequest {
            from_state: state,
            ..Default::default()
        };
        let made = server
            .sessions()
            .create_session(request)
            .await
            .unwrap()
            .into_inner();
        let name = made.session.unwrap().name;
        assert_eq!(force(server, &name, 1).await, expected);
    }
    // A session that began with a state comes back to it.
    let request = wire::ListSessionsRequest::default();
    let list = there.sessions().list_sessions(request).await.unwrap();
    let name = list.into_inner().sessions[0].name.clone();
    stop(there).await;
    let there = on(&tests.join("there")).await;
    assert_eq!(there.describe(&name).await.last_finished_sequence, 1);
    force(&there, &name, 2).await;
    stop(there).await;
    // And the one that was exported goes on from where it is.
    stop(here).await;
    let here = on(&tests.join("here")).await;
    assert_eq!(here.describe(&session).await.last_finished_sequence, 4);
    stop(here).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn foreign_and_damaged_states_are_refused() {
    let _alone = alone().await;
    let (server, session) = pressed(&folder("foreign").join("data"), 1).await;
    let bytes = export(&server, &session).await;
    let mut damaged = bytes.clone();
    damaged[40] ^= 1;
    for bad in [&damaged[..], b"no state", &bytes[..bytes.len() - 1]] {
        let refused = import(&server, bad).await.unwrap_err();
        assert_eq!(reason(&refused), "STATE_INVALID");
    }
    let state = import(&server, &bytes).await.unwrap();
    let other = Block::new(2);
    server.upload(&other).await;
    let mut stiffer = Block::new(1).scene();
    stiffer.obstacles[0].name = "hammer".into();
    for foreign in [other.scene(), stiffer] {
        let request = wire::CreateSessionRequest {
            scene: Some(foreign),
            from_state: state.clone(),
            ..Default::default()
        };
        let refused = server.sessions().create_session(request).await.unwrap_err();
        assert_eq!(reason(&refused), "STATE_INVALID", "{refused}");
    }
    let request = wire::CreateSessionRequest {
        from_state: format!("states/{}", "0".repeat(64)),
        ..Default::default()
    };
    let refused = server.sessions().create_session(request).await.unwrap_err();
    assert_eq!(reason(&refused), "STATE_NOT_FOUND");
    stop(server).await;
}

async fn export(server: &Server, session: &str) -> Vec<u8> {
    let request = wire::ExportStateRequest {
        name: session.into(),
    };
    let mut slices = server
        .sessions()
        .export_state(request)
        .await
        .unwrap()
        .into_inner();
    let mut bytes = Vec::new();
    while let Some(slice) = slices.message().await.unwrap() {
        assert_eq!(slice.offset, bytes.len() as i64);
        bytes.extend_from_slice(&slice.data);
        assert_eq!(slice.last, !slice.digest.is_empty());
    }
    bytes
}

async fn import(server: &Server, bytes: &[u8]) -> Result<String, tonic::Status> {
    use sha2::Digest as _;
    let digest = signorini_proto::digest::hex(&sha2::Sha256::digest(bytes).into());
    let slices: Vec<_> = bytes
        .chunks(1 << 20)
        .enumerate()
        .map(|(index, data)| wire::ImportStateRequest {
            digest: digest.clone(),
            offset: (index << 20) as i64,
            data: bytes::Bytes::copy_from_slice(data),
        })
        .collect();
    let mut client = server.sessions();
    let call = client.import_state(tokio_stream::iter(slices)).await;
    Ok(call?.into_inner().state)
}

/// What others than the owner may use of a folder.
fn open_to_others(folder: &Path) -> Vec<PathBuf> {
    use std::os::unix::fs::PermissionsExt as _;
    let is_open = |path: &Path| path.metadata().unwrap().permissions().mode() & 0o077 != 0;
    let mut found = Vec::from_iter(is_open(folder).then(|| folder.to_owned()));
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(open_to_others(&path))
        } else {
            found.extend(is_open(&path).then_some(path))
        }
    }
    found
}

#[tokio::test(flavor = "multi_thread")]
async fn a_backup_of_a_running_server_is_a_data_folder() {
    use std::os::unix::fs::PermissionsExt as _;
    let _alone = alone().await;
    let tests = folder("backup");
    // Made by hand, open to everybody.
    std::fs::create_dir(tests.join("data")).unwrap();
    let open = std::fs::Permissions::from_mode(0o755);
    std::fs::set_permissions(tests.join("data"), open).unwrap();
    let (server, session) = pressed(&tests.join("data"), 2).await;
    // The socket of backups comes with the server.
    tokio::time::sleep(Duration::from_millis(50)).await;
    let (data, copy) = (tests.join("data"), tests.join("copy"));
    let from = data.clone();
    let made = tokio::task::spawn_blocking(move || backup(&from, &copy, Copying::Bytes)).await;
    made.unwrap().unwrap();
    let after = force(&server, &session, 3).await;
    stop(server).await;
    let found = restore(&tests.join("copy"), &tests.join("again")).unwrap();
    assert_eq!((found.sessions, found.results, found.meshes), (1, 2, 1));
    assert!(
        restore(&tests.join("copy"), &data).is_err(),
        "nothing is written over"
    );
    let server = on(&tests.join("again")).await;
    assert_eq!(force(&server, &session, 3).await, after);
    stop(server).await;
    for made in ["data", "copy", "again"] {
        assert_eq!(open_to_others(&tests.join(made)), Vec::<PathBuf>::new());
    }
    // And of one that has stopped.
    backup(&data, &tests.join("later"), Copying::Links).unwrap();
    assert_eq!(fsck(&tests.join("later")).unwrap().results, 3);
}
