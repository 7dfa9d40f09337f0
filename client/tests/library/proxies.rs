//! The settings of `deploy/haproxy` and `deploy/nginx`, tried with the programs where they are there.
#![cfg(feature = "embedded")]

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::common::server::{Server, connect, load, reason, result};
use crate::common::{folder, signorini};
use signorini_client::solve::Attach;
use signorini_client::{Client, NewSession, session_id};

/// Sessions on three servers.
const SESSIONS: usize = 12;

/// A program that ends with the test.
struct Proxy {
    url: String,
    process: Child,
}

impl Drop for Proxy {
    fn drop(&mut self) {
        self.process.kill().unwrap();
        self.process.wait().unwrap();
    }
}

fn free_port() -> u16 {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    listener.local_addr().unwrap().port()
}

/// The settings of a folder of `deploy`, with the servers of the test in their place.
fn settings(file: &str, servers: &[Server], into: &Path) -> (PathBuf, String) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../deploy")
        .join(file);
    let mut text = std::fs::read_to_string(path).unwrap();
    for (index, server) in servers.iter().enumerate() {
        let address = server.url.strip_prefix("http://").unwrap();
        text = text.replace(&format!("127.0.0.1:{}", 7001 + index), address);
    }
    let address = format!("127.0.0.1:{}", free_port());
    text = text.replace("127.0.0.1:7200", &address);
    let into = into.join("settings");
    std::fs::write(&into, text).unwrap();
    (into, format!("http://{address}"))
}

/// The program, where it is there and will do.
fn program(name: &str) -> Option<String> {
    let variable = format!("SIGNORINI_{}", name.to_uppercase());
    let program = std::env::var(variable).unwrap_or_else(|_| name.to_owned());
    let judged = signorini()
        .args(["doctor", "--proxy", &program])
        .output()
        .unwrap();
    let told = String::from_utf8(judged.stdout).unwrap();
    let line = told.lines().last().unwrap();
    if line.starts_with("ok ") {
        return Some(program);
    }
    eprintln!("left out: {line}");
    None
}

async fn started(mut command: Command, url: String) -> Proxy {
    let process = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn();
    let proxy = Proxy {
        url,
        process: process.unwrap(),
    };
    let until = Instant::now() + Duration::from_secs(10);
    while Client::connect(&proxy.url.parse().unwrap()).await.is_err() {
        assert!(Instant::now() < until, "the proxy starts");
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    proxy
}

/// Sessions stay where they are, for every client, and what a server says comes through.
async fn leads_sessions_to_their_servers(proxy: &Proxy, servers: &[Server]) {
    let (one, other) = (connect(&proxy.url).await, connect(&proxy.url).await);
    let (scene, mesh) = load("hertz-plane.toml");
    let mut names = Vec::new();
    for _ in 0..SESSIONS {
        let session_id = session_id();
        one.of_session(&session_id)
            .upload_mesh(mesh.clone())
            .await
            .unwrap();
        // One that is there already is refused early, without a fault.
        other
            .of_session(&session_id)
            .upload_mesh(mesh.clone())
            .await
            .unwrap();
        let new = NewSession {
            scene: scene.clone(),
            session_id,
            ..Default::default()
        };
        names.push(one.create_session(new).await.unwrap().0.name);
    }
    for name in &names {
        let mut solve = one.solve(name, Attach::default()).await.unwrap();
        let second = other.solve(name, Attach::default()).await.unwrap_err();
        assert_eq!(reason(&second), "SESSION_BUSY");
        solve
            .updates
            .load_step(scene.steps[0].clone())
            .await
            .unwrap();
        result(&mut solve.events).await;
        assert_eq!(other.get_session(name).await.unwrap().name, *name);
    }
    let missing = other.get_session("none-of-them").await.unwrap_err();
    assert_eq!(reason(&missing), "SESSION_NOT_FOUND");
    let mut counts = Vec::new();
    for server in servers {
        counts.push(server.client.list_sessions().await.unwrap().len());
    }
    assert_eq!(counts.iter().sum::<usize>(), SESSIONS);
    assert!(
        counts.iter().filter(|count| **count > 0).count() > 1,
        "{counts:?}"
    );
    for name in names {
        other.delete_session(&name).await.unwrap();
    }
}

async fn three() -> [Server; 3] {
    [
        Server::start().await,
        Server::start().await,
        Server::start().await,
    ]
}

#[tokio::test(flavor = "multi_thread")]
async fn haproxy_leads_sessions_to_their_servers() {
    let Some(program) = program("haproxy") else {
        return;
    };
    let (folder, servers) = (folder("haproxy"), three().await);
    let (file, url) = settings("haproxy/haproxy.cfg", &servers, &folder);
    let mut command = Command::new(program);
    command.arg("-db").arg("-f").arg(file);
    let proxy = started(command, url).await;
    // Until the checks have found them all.
    tokio::time::sleep(Duration::from_millis(500)).await;
    leads_sessions_to_their_servers(&proxy, &servers).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn nginx_leads_sessions_to_their_servers() {
    let Some(program) = program("nginx") else {
        return;
    };
    let (folder, servers) = (folder("nginx"), three().await);
    let (file, url) = settings("nginx/nginx.conf", &servers, &folder);
    let mut command = Command::new(program);
    command.arg("-p").arg(&folder).arg("-c").arg(file);
    command.args([
        "-g",
        "daemon off; master_process off; pid nginx.pid; error_log stderr;",
    ]);
    let proxy = started(command, url).await;
    leads_sessions_to_their_servers(&proxy, &servers).await;
}
