//! Tools that were uploaded outlive the server, with the sessions that press with them.

use std::path::Path;
use std::time::Duration;

use crate::common::{Block, Process, Server, Tool, bare, folder, open, press, reason};
use signorini_proto::v1::surface_service_client::SurfaceServiceClient;
use signorini_proto::v1::{self as wire};
use signorini_server::{Copying, backup, fsck};
use tonic::transport::Channel;

/// Steps before a kill, and in all.
const BEFORE: i64 = 3;
const STEPS: i64 = 6;

fn surfaces(server: &Server) -> SurfaceServiceClient<Channel> {
    SurfaceServiceClient::new(server.channel.clone())
}

async fn upload(server: &Server, tool: Tool) -> wire::UploadSurfaceResponse {
    let parts = tokio_stream::iter(tool.messages());
    let made = surfaces(server).upload_surface(parts).await.unwrap();
    made.into_inner()
}

/// The name of a tool that was sent, and a session that presses with it.
async fn session(server: &Server, tool: Tool) -> (String, String) {
    let block = Block::new(2);
    server.upload(&block).await;
    let name = upload(server, tool).await.surface.unwrap().name;
    let mut scene = block.scene();
    scene.obstacles[0].shape = Some(tool.shape(name.clone()));
    (name, server.session(scene).await)
}

/// Presses so many steps from `first` on.
async fn pressed(server: &Server, session: &str, first: i64, last: i64) -> Vec<wire::StepFinished> {
    let open = wire::SolveOpen {
        // One result a step.
        last_seen_event: Some(first - 1),
        ..open(session)
    };
    let mut stream = server.open(open).await;
    let mut results = Vec::new();
    for sequence in first..=last {
        stream
            .step(sequence, press(0.01 * sequence as f64, 1))
            .await;
        let result = stream.result().await;
        let report = result.report.as_ref().unwrap();
        assert_eq!(report.termination(), wire::Termination::Converged);
        results.push(bare(result));
    }
    results
}

fn refused<T>(call: Result<T, tonic::Status>) -> String {
    reason(&call.err().expect("refused"))
}

async fn delete(server: &Server, name: &str) -> Result<(), tonic::Status> {
    let request = wire::DeleteSurfaceRequest { name: name.into() };
    surfaces(server).delete_surface(request).await.map(drop)
}

async fn delete_session(server: &Server, name: &str) {
    let request = wire::DeleteSessionRequest { name: name.into() };
    server.sessions().delete_session(request).await.unwrap();
}

/// What a server that nobody kills answers.
async fn undisturbed(folder: &Path, tool: Tool) -> Vec<wire::StepFinished> {
    std::fs::create_dir_all(folder).unwrap();
    let process = Process::start(folder, "");
    let server = process.connect().await;
    let (_, session) = session(&server, tool).await;
    pressed(&server, &session, 1, STEPS).await
}

#[tokio::test(flavor = "multi_thread")]
async fn a_session_with_an_uploaded_tool_outlives_a_kill_with_the_same_bits() {
    for tool in Tool::ALL {
        let tests = folder(&format!("tool-{tool:?}"));
        let expected = undisturbed(&tests.join("calm"), tool).await;
        let mut process = Process::start(&tests, "");
        let server = process.connect().await;
        let (_, session) = session(&server, tool).await;
        let mut found = pressed(&server, &session, 1, BEFORE).await;
        process.kill();
        process.restart();
        let server = process.connect().await;
        found.extend(pressed(&server, &session, BEFORE + 1, STEPS).await);
        assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(&expected) {
            assert_eq!(found, expected, "{tool:?}");
        }
        drop(process);
        let kept = fsck(&tests.join("data")).unwrap();
        assert_eq!((kept.surfaces, kept.faults), (1, Vec::new()));
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_stored_tool_is_listed_sent_once_and_stays_while_a_sleeping_session_needs_it() {
    let tests = folder("tool-kept");
    let mut process = Process::start(&tests, "");
    let server = process.connect().await;
    let (name, session) = session(&server, Tool::Plate).await;
    let list = || wire::ListSurfacesRequest::default();
    let before = surfaces(&server).list_surfaces(list()).await.unwrap();
    process.kill();
    process.restart();
    let server = process.connect().await;
    let after = surfaces(&server).list_surfaces(list()).await.unwrap();
    assert_eq!(after.into_inner(), before.into_inner());
    let mut again = Tool::Plate.messages();
    if let Some(wire::upload_surface_request::Part::Header(header)) = &mut again[0].part {
        header.digest = name.strip_prefix("surfaces/").unwrap().to_owned();
    }
    again.truncate(1);
    let made = surfaces(&server)
        .upload_surface(tokio_stream::iter(again))
        .await;
    assert!(made.unwrap().into_inner().already_present);
    assert_eq!(refused(delete(&server, &name).await), "SURFACE_IN_USE");
    delete_session(&server, &session).await;
    // The thread that woke the session may hold it a moment longer.
    while let Err(refused) = delete(&server, &name).await {
        assert_eq!(reason(&refused), "SURFACE_IN_USE");
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    assert_eq!(refused(delete(&server, &name).await), "SURFACE_NOT_FOUND");
    process.kill();
    process.restart();
    let server = process.connect().await;
    let list = surfaces(&server).list_surfaces(list()).await.unwrap();
    assert_eq!(list.into_inner().surfaces, []);
    let left = std::fs::read_dir(tests.join("data/surfaces")).unwrap();
    assert_eq!(left.count(), 0);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_backup_has_the_tools_and_a_lost_or_damaged_one_is_told() {
    let tests = folder("tool-backup");
    let mut process = Process::start(&tests, "");
    let server = process.connect().await;
    let (name, session) = session(&server, Tool::Cap).await;
    pressed(&server, &session, 1, 1).await;
    process.kill();
    let again = tests.join("again");
    std::fs::create_dir(&again).unwrap();
    backup(&tests.join("data"), &again.join("data"), Copying::Bytes).unwrap();
    let mut process = Process::start(&again, "");
    let server = process.connect().await;
    pressed(&server, &session, 2, 2).await;
    process.kill();
    let file = again.join("data").join(&name);
    let bytes = std::fs::read(&file).unwrap();
    let mut damaged = bytes.clone();
    damaged[bytes.len() / 2] ^= 1;
    std::fs::write(&file, &damaged).unwrap();
    let faults = fsck(&again.join("data")).unwrap().faults;
    assert!(
        faults.iter().any(|fault| fault.starts_with(&name)),
        "{faults:?}"
    );
    assert!(
        faults.iter().any(|fault| fault.contains("its tool")),
        "{faults:?}"
    );
    std::fs::remove_file(&file).unwrap();
    let faults = fsck(&again.join("data")).unwrap().faults;
    assert!(
        faults.iter().any(|fault| fault.contains("is missing")),
        "{faults:?}"
    );
    // Whoever has the tool sends it again, and all is well.
    process.restart();
    let server = process.connect().await;
    let call = wire::GetSessionRequest {
        name: session.clone(),
    };
    let gone = server.sessions().get_session(call).await;
    assert_eq!(refused(gone), "SURFACE_DAMAGED");
    upload(&server, Tool::Cap).await;
    pressed(&server, &session, 3, 3).await;
    process.kill();
    assert_eq!(
        fsck(&again.join("data")).unwrap().faults,
        Vec::<String>::new()
    );
}
