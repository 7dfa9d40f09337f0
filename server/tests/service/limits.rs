//! Every list and size of a request has a maximum: what reaches it is taken,
//! one more is refused with a reason and the path of the key.

mod cases;
use crate::common::{Block, Server, open, paths, reason, watch};
use cases::{LISTS, NAMES, NUMBERS, word, words};
use signorini_proto::v1::{self as wire, upload_mesh_request::Part};
use tonic::{Code, Status};
use tonic_types::StatusExt;

const MONTH_SECONDS: i64 = 30 * 24 * 3600;

async fn planned(server: &Server, scene: wire::Scene) -> Result<(), Status> {
    let request = wire::CreateSessionRequest {
        scene: Some(scene),
        validate_only: true,
        ..Default::default()
    };
    server.sessions().create_session(request).await.map(drop)
}

/// Whether a status refuses the size of the key at `path`.
fn refuses_size(status: &Status, path: &str) -> bool {
    const RULES: [&str; 3] = ["entries, at most", "longer than", "must lie between"];
    let request = status.get_details_bad_request();
    let all = request.map(|request| request.field_violations);
    let rule = |text: &str| RULES.iter().any(|rule| text.contains(rule));
    all.unwrap_or_default()
        .iter()
        .any(|one| one.field == path && rule(&one.description))
}

#[tokio::test]
async fn every_list_name_and_number_of_a_scene_ends_at_its_maximum() {
    let (server, block) = (Server::start().await, Block::new(1));
    server.upload(&block).await;
    let with = |size: usize, set: fn(&mut wire::Scene, usize)| {
        let mut scene = block.scene();
        set(&mut scene, size);
        scene
    };
    for (path, maximum, set) in LISTS.into_iter().chain(NAMES).chain(NUMBERS) {
        // Other faults of so artificial a scene are none of this test's business.
        if let Err(status) = planned(&server, with(maximum, set)).await {
            assert!(!refuses_size(&status, path), "{path}: {status:?}");
        }
        let status = planned(&server, with(maximum + 1, set)).await.unwrap_err();
        assert_eq!(reason(&status), "SCENE_INVALID", "{path}");
        assert!(refuses_size(&status, path), "{path}: {:?}", paths(&status));
    }
}

#[tokio::test]
async fn names_of_supports_obstacles_and_probes_have_256_bytes() {
    let (server, block) = (Server::start().await, Block::new(1));
    server.upload(&block).await;
    let sets: [fn(&mut wire::Scene, String); 4] = [
        |scene, name| scene.supports[0].name = name,
        |scene, name| scene.obstacles[0].name = name,
        |scene, name| {
            scene.probes = vec![wire::Probe {
                name,
                point: vec![0.5, 0.5, 0.5],
            }];
        },
        |scene, name| scene.obstacles[0].on = vec!["top".into(), name],
    ];
    for (index, set) in sets.into_iter().enumerate() {
        let outcome = async |bytes| {
            let mut scene = block.scene();
            set(&mut scene, word(bytes));
            planned(&server, scene).await
        };
        let longest = outcome(256).await;
        let refusal = longest.err().map(|status| status.message().to_owned());
        assert!(
            !refusal.unwrap_or_default().contains("longer than"),
            "{index}"
        );
        let status = outcome(257).await.unwrap_err();
        assert!(
            status.message().contains("longer than 256 bytes"),
            "{index}"
        );
    }
}

#[tokio::test]
async fn a_scene_has_at_most_three_mebibytes() {
    let (server, block) = (Server::start().await, Block::new(1));
    server.upload(&block).await;
    let mut scene = block.scene();
    scene.supports[0].on = vec![word(3 << 20)];
    let status = planned(&server, scene).await.unwrap_err();
    assert_eq!(reason(&status), "MESSAGE_LIMIT");
}

#[tokio::test]
async fn of_very_many_faults_the_first_hundred_are_looked_for() {
    let (server, block) = (Server::start().await, Block::new(1));
    server.upload(&block).await;
    let mut scene = block.scene();
    scene.supports[0].on = words(100);
    scene.supports.resize(900, scene.supports[0].clone());
    let status = planned(&server, scene).await.unwrap_err();
    let info = status.get_details_error_info().unwrap();
    assert_eq!(info.metadata["violation_count"], "100");
}

/// Tries a size of a request that creates a session.
async fn creation(
    server: &Server,
    block: &Block,
    set: impl FnOnce(&mut wire::CreateSessionRequest),
) -> Result<(), Status> {
    let mut request = wire::CreateSessionRequest {
        scene: Some(block.scene()),
        ..Default::default()
    };
    set(&mut request);
    server.sessions().create_session(request).await.map(drop)
}

#[tokio::test]
async fn identifiers_and_lives_of_sessions_end_at_their_maxima() {
    let (server, block) = (Server::start().await, Block::new(1));
    server.upload(&block).await;
    let ttl = |seconds| Some(prost_types::Duration { seconds, nanos: 0 });
    for more in [0, 1] {
        let outcomes = [
            (
                "session_id",
                creation(&server, &block, |one| one.session_id = word(63 + more)).await,
            ),
            (
                "request_id",
                creation(&server, &block, |one| one.request_id = word(64 + more)).await,
            ),
            (
                "ttl",
                creation(&server, &block, |one| {
                    one.ttl = ttl(MONTH_SECONDS + more as i64)
                })
                .await,
            ),
        ];
        for (path, outcome) in outcomes {
            match outcome {
                Ok(()) => assert_eq!(more, 0, "{path}"),
                Err(status) => {
                    assert_eq!((more, reason(&status).as_str()), (1, "REQUEST_INVALID"));
                    assert_eq!(paths(&status), [path]);
                }
            }
        }
    }
}

/// Every outcome is refused as a request exactly when it asks for `more`.
fn check_requests(more: i32, outcomes: &[Result<(), Status>]) {
    for (index, outcome) in outcomes.iter().enumerate() {
        let refused = outcome.as_ref().err().map(reason);
        let invalid = refused.as_deref() == Some("REQUEST_INVALID");
        assert_eq!(invalid, more == 1, "{index}: {refused:?}");
    }
}

#[tokio::test]
async fn pages_end_at_their_maximum() {
    let server = Server::start().await;
    for more in [0, 1] {
        let (page_size, page_token) = (1000 + more, String::new());
        let meshes = wire::ListMeshesRequest {
            page_size,
            page_token: page_token.clone(),
        };
        let sessions = wire::ListSessionsRequest {
            page_size,
            page_token,
        };
        let outcomes = [
            server.meshes().list_meshes(meshes).await.map(drop),
            server.sessions().list_sessions(sessions).await.map(drop),
        ];
        check_requests(more, &outcomes);
    }
}

/// The first message that a watcher gets.
async fn watched(server: &Server, request: wire::WatchRequest) -> Result<(), Status> {
    let call = server.sessions().watch(request).await?;
    call.into_inner().message().await.map(drop)
}

#[tokio::test]
async fn lists_of_fields_and_unread_bytes_end_at_their_maxima() {
    let (server, block) = (Server::start().await, Block::new(1));
    server.upload(&block).await;
    let session = server.session(block.scene()).await;
    for more in [0, 1] {
        let fields = vec![1; 100 + more as usize];
        let max_unread_bytes = (1 << 30) + i64::from(more);
        let read = wire::ReadStepRequest {
            name: session.clone(),
            sequence: 1,
            fields: fields.clone(),
            ..Default::default()
        };
        let listed = wire::WatchRequest {
            fields: fields.clone(),
            ..watch(&session, wire::WatchEnd::Idle)
        };
        let unread = wire::WatchRequest {
            max_unread_bytes,
            ..watch(&session, wire::WatchEnd::Idle)
        };
        let opens = [
            wire::SolveOpen {
                fields,
                ..open(&session)
            },
            wire::SolveOpen {
                max_unread_bytes,
                ..open(&session)
            },
        ];
        let mut outcomes = vec![
            server.sessions().read_step(read).await.map(drop),
            watched(&server, listed).await,
            watched(&server, unread).await,
        ];
        for open in opens {
            outcomes.push(server.stream(open).await.try_next().await.map(drop));
        }
        check_requests(more, &outcomes);
    }
}

/// The refusal of an upload that is all header.
async fn header(server: &Server, set: impl FnOnce(&mut wire::MeshHeader)) -> Status {
    let mut header = Block::new(1).header();
    header.digest = "0".repeat(64);
    set(&mut header);
    let part = Some(Part::Header(header));
    let messages = tokio_stream::iter([wire::UploadMeshRequest { part }]);
    server.meshes().upload_mesh(messages).await.unwrap_err()
}

#[tokio::test]
async fn sizes_of_a_mesh_end_at_their_maxima() {
    let server = Server::start().await;
    let group = |name: String, member_count| wire::MeshGroup {
        name,
        kind: wire::GroupKind::Cells.into(),
        member_count,
    };
    for more in [0, 1] {
        let groups = words(4096 + more as usize)
            .into_iter()
            .map(|name| group(name, 1));
        let statuses = [
            header(&server, |one| one.vertex_count = 200_000_000 + more).await,
            header(&server, |one| one.cell_count = 400_000_000 + more).await,
            header(&server, |one| one.facet_count = 400_000_000 + more).await,
            header(&server, |one| one.groups = groups.collect()).await,
            header(&server, |one| {
                one.groups[0] = group(word(256 + more as usize), 1)
            })
            .await,
            header(&server, |one| {
                one.groups[0].member_count = 400_000_000 + more
            })
            .await,
        ];
        for (index, status) in statuses.into_iter().enumerate() {
            let limit = reason(&status) == "MESSAGE_LIMIT";
            assert_eq!(limit, more == 1, "{index}: {status:?}");
            assert_ne!(status.code(), Code::Internal, "{index}");
        }
    }
}
