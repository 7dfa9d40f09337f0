//! The client library against the server itself.
#![cfg(feature = "embedded")]

use std::time::Duration;

use crate::common::server::{Server, connect, load, lowered, reason, result, session};
use signorini_client::solve::{Attach, Event};
use signorini_proto::v1;

#[tokio::test(flavor = "multi_thread")]
async fn a_mesh_is_sent_once_listed_and_deleted() {
    let server = Server::start().await;
    let (_, mesh) = load("cube-bend.toml");
    let first = server.client.upload_mesh(mesh.clone()).await.unwrap();
    let second = server.client.upload_mesh(mesh.clone()).await.unwrap();
    assert!(!first.already_present && second.already_present);
    assert_eq!(
        (first.mesh.vertex_count, first.mesh.cell_count),
        (343, 1296)
    );
    let listed = server.client.list_meshes().await.unwrap();
    assert_eq!(
        listed
            .iter()
            .map(|mesh| mesh.digest.as_str())
            .collect::<Vec<_>>(),
        [mesh.digest()]
    );
    server.client.delete_mesh(mesh.digest()).await.unwrap();
    assert_eq!(server.client.find_mesh(mesh.digest()).await.unwrap(), None);
    let error = server.client.delete_mesh(mesh.digest()).await.unwrap_err();
    assert_eq!(reason(&error), "MESH_NOT_FOUND");
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn results_come_with_the_fields_that_were_asked_for() {
    let server = Server::start().await;
    let (session, steps) = session(&server, "hertz-plane.toml").await;
    let fields = vec![v1::FieldName::Displacement, v1::FieldName::ContactPressure];
    let attach = Attach {
        fields: fields.clone(),
        ..Default::default()
    };
    let mut solve = server.client.solve(&session.name, attach).await.unwrap();
    solve.updates.load_step(steps[0].clone()).await.unwrap();
    let increment = result(&mut solve.events).await;
    assert!(increment.last);
    assert_eq!(increment.report.termination(), v1::Termination::Converged);
    assert_eq!(
        increment
            .fields
            .iter()
            .map(|field| field.name)
            .collect::<Vec<_>>(),
        fields
    );
    assert_eq!(
        (
            increment.fields[0].components,
            increment.fields[0].values.len()
        ),
        (3, 7146)
    );
    // A quadratic pressure has a value at every node.
    assert_eq!(increment.fields[1].values.len(), 7146 / 3);
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn obstacle_updates_follow_a_step_without_a_factorisation() {
    let server = Server::start().await;
    let (session, steps) = session(&server, "hertz-plane.toml").await;
    let mut solve = server
        .client
        .solve(&session.name, Attach::default())
        .await
        .unwrap();
    solve.updates.load_step(steps[0].clone()).await.unwrap();
    let mut force = result(&mut solve.events).await.report.obstacles["floor"].force[2];
    for index in 1..=5 {
        let sequence = solve
            .updates
            .obstacle_update(lowered(0.05 + 1e-3 * f64::from(index)))
            .await
            .unwrap();
        let increment = result(&mut solve.events).await;
        assert_eq!(increment.sequence, sequence);
        assert_eq!(increment.report.factorisations, 0);
        let next = increment.report.obstacles["floor"].force[2];
        assert!(next > force, "{next} follows {force}");
        force = next;
    }
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_bad_update_is_rejected_and_its_sequence_is_free_again() {
    let server = Server::start().await;
    let (session, steps) = session(&server, "hertz-plane.toml").await;
    let mut solve = server
        .client
        .solve(&session.name, Attach::default())
        .await
        .unwrap();
    let mut bad = steps[0].clone();
    bad.obstacles[0].name = "roof".to_owned();
    let sequence = solve.updates.load_step(bad).await.unwrap();
    let Some(Event::Rejected {
        sequence: rejected,
        refusal,
    }) = solve.events.next().await.unwrap()
    else {
        unreachable!()
    };
    assert_eq!(
        (rejected, refusal.reason.as_str()),
        (sequence, "SCENE_INVALID")
    );
    assert!(
        refusal
            .violations
            .iter()
            .any(|violation| violation.path.contains("roof")),
        "{refusal:?}"
    );
    solve.updates.rejected(rejected);
    assert_eq!(
        solve.updates.load_step(steps[0].clone()).await.unwrap(),
        sequence
    );
    let increment = result(&mut solve.events).await;
    assert_eq!(increment.report.termination(), v1::Termination::Converged);
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn bad_scenes_name_their_keys_and_unknown_meshes_their_reason() {
    let server = Server::start().await;
    let (mut scene, mesh) = load("hertz-plane.toml");
    let error = server.client.plan(scene.clone()).await.unwrap_err();
    assert_eq!(reason(&error), "MESH_NOT_FOUND");
    server.client.upload_mesh(mesh).await.unwrap();
    scene.supports[0].on = vec!["roof".to_owned()];
    let error = server.client.plan(scene).await.unwrap_err();
    assert_eq!(reason(&error), "SCENE_INVALID");
    assert_eq!(
        error.refusal().unwrap().violations[0].path,
        "support.top.on"
    );
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_second_connection_cancels_and_the_first_gets_the_result() {
    let server = Server::start().await;
    let (session, mut steps) = session(&server, "hertz-plane.toml").await;
    steps[0].increments = Some(100_000);
    let mut solve = server
        .client
        .solve(&session.name, Attach::default())
        .await
        .unwrap();
    let sequence = solve.updates.load_step(steps[0].clone()).await.unwrap();
    let first = result(&mut solve.events).await;
    assert!(!first.last);
    let other = connect(&server.url).await;
    assert_eq!(other.cancel_step(&session.name, 0).await.unwrap(), sequence);
    let mut last = result(&mut solve.events).await;
    while !last.last {
        last = result(&mut solve.events).await;
    }
    assert_eq!(last.report.termination(), v1::Termination::Cancelled);
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_second_session_on_the_same_scene_shares_what_was_prepared() {
    let server = Server::start().await;
    let mut reused = Vec::new();
    for _ in 0..2 {
        let (session, steps) = session(&server, "hertz-plane.toml").await;
        let mut solve = server
            .client
            .solve(&session.name, Attach::default())
            .await
            .unwrap();
        solve.updates.load_step(steps[0].clone()).await.unwrap();
        reused.push(result(&mut solve.events).await.report.reused);
    }
    assert_eq!(server.client.list_sessions().await.unwrap().len(), 2);
    assert!(reused[0].is_empty() && !reused[1].is_empty(), "{reused:?}");
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn an_update_that_takes_longer_than_it_may_ends_with_its_last_state() {
    let server = Server::start().await;
    let (session, mut steps) = session(&server, "hertz-plane.toml").await;
    steps[0].increments = Some(100_000);
    let attach = Attach::default();
    let mut solve = server.client.solve(&session.name, attach).await.unwrap();
    let limit = Duration::from_millis(100);
    solve.updates.set_max_wall_time(Some(limit)).unwrap();
    solve.updates.load_step(steps[0].clone()).await.unwrap();
    let mut last = result(&mut solve.events).await;
    while !last.last {
        last = result(&mut solve.events).await;
    }
    let ended = last.report.termination();
    assert_eq!(ended, v1::Termination::DeadlineExceeded);
    assert!(last.report.time < 1.0);
    server.stop().await;
}
