//! Tokens and settings that change while the server runs.

use std::io::{BufRead as _, BufReader};
use std::process::{Command, Stdio};

use signorini_proto::v1 as wire;
use signorini_server::Role;
use tonic::Code;

use super::{Client, Tokens, soon};
use crate::common::{Block, Process, Server, folder, reason};

#[tokio::test(flavor = "multi_thread")]
async fn a_revoked_token_ends_its_streams_and_a_new_one_works_without_a_restart() {
    let mut tokens = Tokens::new("revoked");
    let first = tokens.add("line-1", Role::Solve);
    let server = Server::with(tokens.config()).await;
    let (client, block) = (Client::of(&server, &first), Block::new(1));
    client.upload(&block).await.unwrap();
    let session = client.create(&block, "line-1-a").await.unwrap();
    let watch = wire::WatchRequest {
        name: session.clone(),
        until: wire::WatchEnd::Session.into(),
        ..Default::default()
    };
    let path = "/signorini.v1.SessionService/Watch";
    let mut watcher = client.call::<_, ()>(path, vec![watch]).await.unwrap();
    assert!(watcher.message().await.unwrap().is_some());

    let second = Client::of(&server, &tokens.add("line-1", Role::Solve));
    soon("the second token", async || second.sessions().await.is_ok()).await;
    assert_eq!(
        client.sessions().await.unwrap(),
        std::slice::from_ref(&session)
    );

    let id = tokens.file.entries()[0].id();
    tokens.file.revoke("line-1".parse().unwrap(), Some(&id));
    tokens.file.write(&tokens.path).unwrap();
    let ended = loop {
        match tokio::time::timeout(super::SOON, watcher.message()).await {
            Ok(Ok(Some(()))) => {}
            Ok(Ok(None)) => panic!("the stream ended well"),
            Ok(Err(status)) => break status,
            Err(_) => panic!("the stream of a revoked token goes on"),
        }
    };
    assert_eq!(reason(&ended), "UNAUTHENTICATED");
    let refused = client.sessions().await.unwrap_err();
    assert_eq!(refused.code(), Code::Unauthenticated);
    assert_eq!(second.sessions().await.unwrap(), [session]);

    // What cannot be read leaves what was there.
    std::fs::write(&tokens.path, "[[token]]\nname = 3").unwrap();
    tokio::time::sleep(std::time::Duration::from_millis(1200)).await;
    assert!(second.sessions().await.is_ok());
}

#[tokio::test]
async fn a_hangup_takes_up_the_level_of_the_log_and_a_faulty_file_leaves_it() {
    let folder = folder("log-level");
    let process = Process::start(&folder, "log_level = \"warn\"\n");
    let server = process.connect().await;
    server.upload(&Block::new(1)).await;
    let log = || std::fs::read_to_string(folder.join("log")).unwrap();
    // Who changed what is told at every level.
    assert!(
        log().contains("audit: call") && !log().contains("serving"),
        "{}",
        log()
    );
    let write = |text: &str| std::fs::write(folder.join("server.toml"), text).unwrap();
    let hang_up = || {
        let id = process.id().to_string();
        let sent = Command::new("kill").args(["-HUP", &id]).status();
        assert!(sent.unwrap().success());
    };
    write("metrics_listen = \"\"\nlog_level = \"info\"\n");
    hang_up();
    soon("the new level", async || {
        log().contains("level of the log set")
    })
    .await;
    write("log_levels = \"off\"\n");
    hang_up();
    soon("the fault", async || {
        log().contains("did you mean `log_level`")
    })
    .await;
}

#[tokio::test]
async fn a_hangup_of_a_server_that_has_nothing_to_reload_is_told_and_ends_nothing() {
    let folder = folder("hangup");
    for (log, why) in [(None, "no file of settings"), (Some("info"), "RUST_LOG")] {
        let socket = format!("unix:{}", folder.join("socket").display());
        let mut command = Command::new(env!("CARGO_BIN_EXE_signorini-server"));
        command.args(["--listen", &socket, "--metrics-listen", ""]);
        command.env_remove("RUST_LOG").stderr(Stdio::piped());
        command.envs(log.map(|log| ("RUST_LOG", log)));
        let mut process = command.spawn().unwrap();
        let server = Server::beside(&socket).await;
        let id = process.id().to_string();
        let send = |signal: &str| {
            Command::new("kill")
                .args([signal, id.as_str()])
                .status()
                .unwrap()
        };
        assert!(send("-HUP").success());
        let mut lines = BufReader::new(process.stderr.take().unwrap()).lines();
        let told = lines.find(|line| {
            line.as_ref()
                .unwrap()
                .contains("the level of the log stays")
        });
        assert!(told.unwrap().unwrap().contains(why));
        server
            .sessions()
            .list_sessions(wire::ListSessionsRequest::default())
            .await
            .unwrap();
        assert!(send("-TERM").success());
        assert!(process.wait().unwrap().success());
    }
}
