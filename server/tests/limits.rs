//! Every list and size of a request has a maximum: what reaches it is taken,
//! one more is refused with a reason and the path of the key.

mod common;

use common::{Block, Server, open, paths, press, reason, watch};
use signorini_proto::v1::{self as wire, upload_mesh_request::Part};
use tonic::{Code, Status};
use tonic_types::StatusExt;

const MONTH_SECONDS: i64 = 30 * 24 * 3600;

/// A key of the scene, its maximum, and how it is given a size.
type SceneCase = (&'static str, usize, fn(&mut wire::Scene, usize));

fn word(bytes: usize) -> String {
    "n".repeat(bytes)
}

fn words(count: usize) -> Vec<String> {
    (0..count).map(|index| format!("g{index}")).collect()
}

fn solver(scene: &mut wire::Scene) -> &mut wire::SolverOptions {
    scene.solver.get_or_insert_default()
}

fn ogden(terms: usize) -> Option<wire::material::Model> {
    Some(wire::material::Model::Ogden(wire::Ogden {
        mu: vec![1.0; terms],
        alpha: vec![2.0; terms.min(16)],
        bulk_modulus: None,
    }))
}

fn moved(name: String) -> wire::ObstacleTarget {
    wire::ObstacleTarget {
        name,
        ..Default::default()
    }
}

fn held(name: String) -> wire::SupportTarget {
    wire::SupportTarget {
        name,
        ..Default::default()
    }
}

const LISTS: [SceneCase; 14] = [
    ("material", 4096, |scene, n| {
        scene.materials.resize(n, scene.materials[0].clone());
    }),
    ("support", 4096, |scene, n| {
        scene.supports.resize(n, scene.supports[0].clone());
    }),
    ("traction", 4096, |scene, n| {
        scene.tractions.resize(n, wire::Traction::default());
    }),
    ("pressure", 4096, |scene, n| {
        scene.pressures.resize(n, wire::Pressure::default());
    }),
    ("obstacle", 1000, |scene, n| {
        scene.obstacles.resize(n, scene.obstacles[0].clone());
    }),
    ("probe", 10_000, |scene, n| {
        scene.probes.resize(n, wire::Probe::default());
    }),
    ("step", 10_000, |scene, n| {
        scene.steps.resize(n, wire::LoadStep::default());
    }),
    ("output.fields", 100, |scene, n| {
        scene.output.get_or_insert_default().fields = vec![1; n];
    }),
    ("support.base.on", 1000, |scene, n| {
        scene.supports[0].on = words(n)
    }),
    ("obstacle.ball.on", 1000, |scene, n| {
        scene.obstacles[0].on = words(n)
    }),
    ("traction[0].on", 1000, |scene, n| {
        let (on, value) = (words(n), vec![0.0; 3]);
        scene.tractions = vec![wire::Traction { on, value }];
    }),
    ("material.body.mu", 16, |scene, n| {
        scene.materials[0].model = ogden(n)
    }),
    ("step[0].obstacle", 1000, |scene, n| {
        let obstacles = words(n).into_iter().map(moved).collect();
        scene.steps = vec![wire::LoadStep {
            obstacles,
            ..Default::default()
        }];
    }),
    ("step[0].support", 1000, |scene, n| {
        let supports = words(n).into_iter().map(held).collect();
        scene.steps = vec![wire::LoadStep {
            supports,
            ..Default::default()
        }];
    }),
];

const NAMES: [SceneCase; 9] = [
    ("name", 256, |scene, n| scene.name = word(n)),
    ("material", 256, |scene, n| {
        scene.materials[0].group = word(n)
    }),
    ("manufactured.field", 256, |scene, n| {
        scene.manufactured = word(n)
    }),
    ("support.base.on", 256, |scene, n| {
        scene.supports[0].on = vec![word(n)]
    }),
    ("solver.saddle", 256, |scene, n| {
        solver(scene).saddle = word(n)
    }),
    ("solver.displacement_preconditioner", 256, |scene, n| {
        solver(scene).displacement_preconditioner = word(n);
    }),
    ("solver.p1_solver", 256, |scene, n| {
        solver(scene).p1_solver = word(n)
    }),
    ("solver.contact", 256, |scene, n| {
        solver(scene).contact = word(n)
    }),
    ("solver.contact_metric", 256, |scene, n| {
        solver(scene).contact_metric = word(n)
    }),
];

const NUMBERS: [SceneCase; 3] = [
    ("output.every", 100_000, |scene, n| {
        scene.output.get_or_insert_default().every = Some(n as i32);
    }),
    ("step[0].increments", 100_000, |scene, n| {
        scene.steps = vec![press(0.1, n as i32)];
    }),
    ("solver.quadrature_degree", 20, |scene, n| {
        solver(scene).quadrature_degree = Some(n as i32)
    }),
];

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
    scene.supports.resize(4000, scene.supports[0].clone());
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
            wire::Open {
                fields,
                ..open(&session)
            },
            wire::Open {
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
