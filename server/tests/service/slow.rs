//! Clients that send too slowly, take nothing, or make the server reset their streams: each is
//! ended in a time that a setting names.

use std::time::{Duration, Instant};

use signorini_proto::v1 as wire;
use signorini_server::Config;

use crate::common::{Block, Server, open, page, press, reason, sample};
use crate::raw::Raw;

const GET_SESSION: &str = "/signorini.v1.SessionService/GetSession";
const LIST_SESSIONS: &str = "/signorini.v1.SessionService/ListSessions";
const PATIENCE: Duration = Duration::from_secs(20);
const WINDOW: u32 = 65_535;

async fn with(change: impl FnOnce(&mut Config)) -> Server {
    let mut config = Config::embedded();
    change(&mut config);
    Server::with(config).await
}

#[tokio::test]
async fn a_unary_call_whose_request_does_not_come_is_ended() {
    let server = with(|config| config.request_seconds = 1).await;
    let mut raw = Raw::connect(&server, WINDOW).await;
    let begun = Instant::now();
    // Nothing at all; a part of the prefix; a message without the end of the call.
    for (stream, bytes) in [(1, &[][..]), (3, &[0, 0][..]), (5, &[0; 5][..])] {
        assert!(raw.call(stream, LIST_SESSIONS).await);
        assert!(bytes.is_empty() || raw.data(stream, bytes).await);
    }
    // Byte by byte: a message of 200 bytes.
    assert!(raw.call(7, LIST_SESSIONS).await);
    let mut bytes = [0, 0, 0, 0, 200].into_iter().chain(std::iter::repeat(0));
    let mut open = vec![1, 3, 5, 7];
    while !open.is_empty() {
        assert!(begun.elapsed() < PATIENCE, "{open:?}");
        raw.data(7, &[bytes.next().unwrap()]).await;
        let part = Duration::from_millis(50);
        if let Ok(Some(frame)) = tokio::time::timeout(part, raw.next(PATIENCE)).await
            && frame.ends_stream()
        {
            assert!(begun.elapsed() >= Duration::from_secs(1));
            open.retain(|stream| *stream != frame.stream);
        }
    }
    // The connection is well.
    assert!(raw.call(9, LIST_SESSIONS).await && raw.end(9, &[0; 5]).await);
    while raw.next(PATIENCE).await.unwrap().stream != 9 {}
}

#[tokio::test]
async fn a_stream_that_rests_between_its_messages_goes_on() {
    let server = with(|config| config.request_seconds = 1).await;
    let block = Block::new(1);
    server.upload(&block).await;
    let mut stream = server
        .open(open(&server.session(block.scene()).await))
        .await;
    tokio::time::sleep(Duration::from_millis(1500)).await;
    stream.step(1, press(0.01, 1)).await;
    assert!(stream.result().await.last);
}

#[tokio::test]
async fn a_stream_that_nobody_reads_leaves_its_session_to_others() {
    let server = with(|config| config.unread_seconds = 5).await;
    let block = Block::new(3);
    server.upload(&block).await;
    let session = server.session(block.scene()).await;
    let opening = wire::SolveOpen {
        fields: vec![wire::FieldName::Displacement.into()],
        ..open(&session)
    };
    let mut unread = server.open(opening).await;
    // More than the transport holds of a stream.
    unread.step(1, press(0.05, 400)).await;
    let (other, begun) = (Server::beside(&server.url).await, Instant::now());
    let mut next = loop {
        match other.try_open(open(&session)).await {
            Ok(stream) => break stream,
            Err(status) => assert_eq!(reason(&status), "SESSION_BUSY"),
        }
        assert!(begun.elapsed() < Duration::from_secs(60));
        tokio::time::sleep(Duration::from_millis(50)).await;
    };
    // Who was away reads what was sent, and why no more was.
    let end = unread.end().await.expect("a status");
    assert_eq!(reason(&end), "STREAM_UNREAD");
    next.step(2, press(0.02, 1)).await;
    while next.result().await.sequence < 2 {}
}

#[tokio::test]
async fn a_connection_whose_answers_nobody_takes_is_closed() {
    let server = with(|config| {
        config.unread_seconds = 1;
        config.metrics_listen = "127.0.0.1:0".to_owned();
    })
    .await;
    // A client that lets nothing be sent, and one that takes everything.
    let mut raw = Raw::connect(&server, 0).await;
    let mut other = Raw::connect(&server, WINDOW).await;
    let begun = Instant::now();
    assert!(raw.call(1, LIST_SESSIONS).await && raw.end(1, &[0; 5]).await);
    while raw.next(PATIENCE).await.is_some() {}
    assert!(begun.elapsed() >= Duration::from_secs(2));
    let series = "signorini_connections_turned_away_total{reason=\"unread\"}";
    assert_eq!(
        sample(&page(server.metrics_url.as_ref().unwrap()).await, series),
        1
    );
    assert!(other.call(1, GET_SESSION).await && other.end(1, &[0; 5]).await);
    assert!(other.next(PATIENCE).await.is_some());
}

#[tokio::test]
async fn a_connection_whose_windows_overflow_is_closed() {
    let server = with(|_| {}).await;
    let mut raw = Raw::connect(&server, WINDOW).await;
    let mut sent = 0;
    // The most that a window may be, and then as much again.
    for stream in (1..4000).step_by(2) {
        if !raw.call(stream, LIST_SESSIONS).await || !raw.window(stream, 0x7fff_ffff).await {
            break;
        }
        sent += 1;
    }
    let mut resets = 0;
    while let Some(frame) = raw.next(PATIENCE).await {
        resets += usize::from(frame.ends_stream());
    }
    assert!(resets <= 300, "{resets} of {sent}");
}
