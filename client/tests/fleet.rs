//! Servers that share their sessions by NATS: a session goes on at another when its own is killed,
//! stopped or cut off, with the same bits, and never has two. Left out without `nats-server`.

mod common;

use std::net::{SocketAddr, TcpListener};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use common::process::{Process, serve_with_log};
use common::server::{load, lowered};
use prost::Message as _;
use signorini_client::solve::{Attach, Event, Events, Increment, WatchOptions};
use signorini_client::{Client, ClientError, NewSession};
use signorini_proto::v1;
use signorini_proto::v1::session_service_client::SessionServiceClient;
use tokio::net::TcpStream;
use tokio::sync::watch;
use tonic_types::StatusExt as _;

/// Short, so that a take-over is soon.
const LEASE: Duration = Duration::from_secs(2);
const MOVES: i32 = 60;
/// A result that is lost would be waited for without an end.
const LONGEST_WAIT: Duration = Duration::from_secs(60);

/// NATS with JetStream in a folder.
struct Nats {
    process: Option<Child>,
    port: u16,
    folder: PathBuf,
}

impl Nats {
    /// Starts it; none where it is not installed.
    fn start(folder: &Path) -> Option<Self> {
        let port = free_port();
        let mut nats = Self {
            process: None,
            port,
            folder: folder.join("nats"),
        };
        nats.run().then_some(nats)
    }

    fn run(&mut self) -> bool {
        let port = self.port.to_string();
        let mut command = Command::new("nats-server");
        command.args(["-js", "-a", "127.0.0.1", "-p", &port, "-sd"]);
        command
            .arg(&self.folder)
            .stdout(Stdio::null())
            .stderr(Stdio::null());
        let Ok(process) = command.spawn() else {
            eprintln!("left out: no nats-server here");
            return false;
        };
        self.process = Some(process);
        let until = Instant::now() + Duration::from_secs(10);
        while std::net::TcpStream::connect(("127.0.0.1", self.port)).is_err() {
            assert!(Instant::now() < until, "NATS starts");
            std::thread::sleep(Duration::from_millis(20));
        }
        true
    }

    fn url(&self) -> String {
        format!("nats://127.0.0.1:{}", self.port)
    }

    fn kill(&mut self) {
        if let Some(mut process) = self.process.take() {
            process.kill().unwrap();
            process.wait().unwrap();
        }
    }
}

impl Drop for Nats {
    fn drop(&mut self) {
        self.kill();
    }
}

fn free_port() -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    listener.local_addr().unwrap().port()
}

/// Servers of one fleet.
struct Fleet {
    nats: Nats,
    folder: PathBuf,
    servers: Vec<(Process, String)>,
}

impl Fleet {
    fn start(test: &str, count: usize) -> Option<Self> {
        let folder = common::folder(test);
        let nats = Nats::start(&folder)?;
        let mut fleet = Self {
            nats,
            folder,
            servers: Vec::new(),
        };
        for number in 0..count {
            let server = fleet.server(&format!("server-{number}"));
            fleet.servers.push(server);
        }
        Some(fleet)
    }

    fn server(&self, name: &str) -> (Process, String) {
        let own = self.folder.join(name);
        std::fs::create_dir_all(&own).unwrap();
        let settings = format!(
            "data = {data:?}\nfleet_nats = {nats:?}\nfleet_store = {store:?}\n\
             fleet_lease_seconds = {lease}\nfleet_name = {name:?}\nretained_results = 100\n",
            data = own.join("data"),
            nats = self.nats.url(),
            store = self.folder.join("store"),
            lease = LEASE.as_secs(),
        );
        let log = std::fs::File::create(own.join("log")).unwrap();
        let test = format!(
            "{}-{name}",
            self.folder.file_name().unwrap().to_str().unwrap()
        );
        serve_with_log("127.0.0.1:0", &test, &settings, log.into())
    }

    fn url(&self, number: usize) -> &str {
        &self.servers[number].1
    }

    fn addresses(&self) -> Vec<SocketAddr> {
        let urls = self.servers.iter();
        urls.map(|(_, url)| url.strip_prefix("http://").unwrap().parse().unwrap())
            .collect()
    }
}

/// Leads every connection to the first server that takes it.
struct Way {
    url: String,
    servers: Arc<Mutex<Vec<SocketAddr>>>,
    cuts: watch::Sender<()>,
}

impl Way {
    async fn to(servers: Vec<SocketAddr>) -> Self {
        let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
        let url = format!("http://{}", listener.local_addr().unwrap());
        let servers = Arc::new(Mutex::new(servers));
        let known = Arc::clone(&servers);
        let cuts = watch::Sender::new(());
        let own = cuts.clone();
        tokio::spawn(async move {
            loop {
                let (client, _) = listener.accept().await.unwrap();
                let servers = known.lock().unwrap().clone();
                tokio::spawn(carry(client, servers, own.subscribe()));
            }
        });
        Self { url, servers, cuts }
    }

    async fn client(&self) -> Client {
        Client::connect(&self.url.parse().unwrap()).await.unwrap()
    }

    /// The first becomes the last, as it does for a proxy whose checks find it silent.
    fn turn(&self) {
        self.servers.lock().unwrap().rotate_left(1);
        self.cuts.send_replace(());
    }
}

async fn carry(mut client: TcpStream, servers: Vec<SocketAddr>, mut cut: watch::Receiver<()>) {
    for server in servers {
        if let Ok(mut server) = TcpStream::connect(server).await {
            // Either side may leave at any time.
            return tokio::select! {
                _left = tokio::io::copy_bidirectional(&mut client, &mut server) => (),
                _cut = cut.changed() => (),
            };
        }
    }
}

async fn session(client: &Client, id: &str) -> v1::Session {
    let (mut scene, mesh) = load("hertz-plane.toml");
    scene.output.get_or_insert_default().fields = vec![v1::FieldName::Pressure.into()];
    let client = client.of_session(id);
    client.upload_mesh(mesh).await.unwrap();
    let new = NewSession {
        scene,
        session_id: id.to_owned(),
        ..Default::default()
    };
    client.create_session(new).await.unwrap().0
}

fn depth(number: i32) -> f64 {
    0.05 + 1e-3 * f64::from(number * 7 % 11)
}

/// What a result says, without the time that it took and what the session shares.
fn bits(increment: &Increment) -> (i64, Vec<u8>, Vec<u64>) {
    let report = v1::StepReport {
        seconds: None,
        memory_bytes: 0,
        reused: Vec::new(),
        factorisations: 0,
        eigenvalue_applications: 0,
        compliance_columns: 0,
        ..increment.report.clone()
    };
    let values = increment.fields.iter().flat_map(|field| &field.values);
    let values = values.map(|value| value.to_bits()).collect();
    (increment.event, report.encode_to_vec(), values)
}

type Bits = (i64, Vec<u8>, Vec<u64>);

async fn next(events: &mut Events) -> Result<Increment, ClientError> {
    loop {
        let event = tokio::time::timeout(LONGEST_WAIT, events.next()).await;
        match event.expect("a result")? {
            Some(Event::Increment(increment)) => return Ok(*increment),
            Some(Event::Rejected { refusal, .. }) => unreachable!("{refusal}"),
            Some(
                Event::Iteration(_)
                | Event::Heartbeat(_)
                | Event::ConnectionLost { .. }
                | Event::Reconnected { .. },
            ) => {}
            None => return Err(ClientError::Closed),
        }
    }
}

/// All moves, 8 ahead; `between` is told how many results are there.
async fn drive(client: &Client, name: &str, mut between: impl AsyncFnMut(i32)) -> Vec<Bits> {
    let mut solve = client.solve(name, Attach::default()).await.unwrap();
    let (mut sent, mut results) = (0, Vec::new());
    while results.len() < MOVES as usize {
        while sent < MOVES && sent < results.len() as i32 + 8 {
            sent += 1;
            let moved = lowered(depth(sent));
            solve.updates.obstacle_update(moved).await.unwrap();
        }
        let increment = next(&mut solve.events).await.unwrap();
        assert_eq!(
            increment.event,
            results.len() as i64 + 1,
            "each once, in order"
        );
        results.push(bits(&increment));
        between(results.len() as i32).await;
    }
    results
}

/// The results of a server that nobody disturbs.
async fn undisturbed() -> Vec<Bits> {
    let server = common::server::Server::start().await;
    let session = session(&server.client, "calm").await;
    let results = drive(&server.client, &session.name, async |_| ()).await;
    server.stop().await;
    results
}

fn epoch(fleet: &Fleet, id: &str) -> Option<(String, u64)> {
    let mut status = common::signorini();
    let output = status.args(["fleet", "status", "--json", "--nats", &fleet.nats.url()]);
    let output = String::from_utf8(output.output().unwrap().stdout).unwrap();
    let lines = output
        .lines()
        .map(|line| serde_json::from_str(line).unwrap());
    let mut held =
        lines.filter(|line: &serde_json::Value| line["session"] == format!("sessions/{id}"));
    let held = held.next()?;
    Some((held["server"].as_str()?.to_owned(), held["epoch"].as_u64()?))
}

#[tokio::test(flavor = "multi_thread")]
async fn a_session_goes_on_at_another_server_when_its_own_is_killed() {
    let Some(mut fleet) = Fleet::start("fleet-kill", 2) else {
        return;
    };
    let expected = undisturbed().await;
    let way = Way::to(fleet.addresses()).await;
    let client = way.client().await;
    let session = session(&client, "moved").await;
    let mut epochs = Vec::new();
    let (mut pause, mut before) = (Duration::ZERO, Instant::now());
    let results = drive(&client, &session.name, async |count| {
        pause = pause.max(before.elapsed());
        if count == 20 || count == 40 {
            tokio::time::sleep(LEASE / 2).await;
            let (server, epoch) = epoch(&fleet, "moved").unwrap();
            epochs.push(epoch);
            let number = usize::from(server == "server-1");
            let (process, _) = &mut fleet.servers[number];
            process.0.kill().unwrap();
            process.0.wait().unwrap();
            fleet.servers[number] = fleet.server(&server);
            *way.servers.lock().unwrap() = fleet.addresses();
        }
        before = Instant::now();
    })
    .await;
    assert!(results == expected, "the same bits");
    epochs.push(epoch(&fleet, "moved").unwrap().1);
    assert!(epochs.is_sorted_by(|one, other| one < other), "{epochs:?}");
    eprintln!("longest pause {pause:?}");
    client.delete_session("moved").await.unwrap();
    let gone = client.get_session("moved").await.unwrap_err();
    assert!(gone.is_reason("SESSION_NOT_FOUND"), "{gone}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_server_that_slept_beyond_its_lease_says_nothing_more() {
    let Some(fleet) = Fleet::start("fleet-stop", 2) else {
        return;
    };
    let expected = undisturbed().await;
    let way = Way::to(fleet.addresses()).await;
    let client = way.client().await;
    let session = session(&client, "slept").await;
    let direct = Client::connect(&fleet.url(0).parse().unwrap())
        .await
        .unwrap();
    let options = WatchOptions {
        patience: Duration::ZERO,
        ..Default::default()
    };
    let mut watch = direct.watch("slept", options).await.unwrap();
    let endpoint = tonic::transport::Endpoint::from_shared(fleet.url(0).to_owned()).unwrap();
    let asker = SessionServiceClient::new(endpoint.connect().await.unwrap());
    let mut questions = Vec::new();
    let mut seen = Vec::new();
    let results = drive(&client, &session.name, async |count| {
        if count == 20 {
            fleet.servers[0].0.signal("-STOP");
            way.turn();
        }
        if count == 40 {
            // Asked while it sleeps: read as soon as it wakes.
            for _ in 0..8 {
                let (mut asker, name) = (asker.clone(), session.name.clone());
                let request = v1::GetSessionRequest { name };
                questions.push(tokio::spawn(
                    async move { asker.get_session(request).await },
                ));
            }
            tokio::time::sleep(Duration::from_millis(100)).await;
            fleet.servers[0].0.signal("-CONT");
        }
    });
    let results = tokio::join!(results, async {
        loop {
            match next(&mut watch.events).await {
                Ok(increment) => seen.push(bits(&increment)),
                Err(error) => return error,
            }
        }
    });
    let (results, ended) = results;
    assert!(results == expected, "the same bits");
    assert!(ended.is_reason("SESSION_ELSEWHERE"), "{ended}");
    for question in questions {
        let refused = question.await.unwrap().unwrap_err();
        let info = refused.get_details_error_info().unwrap();
        assert_eq!(info.reason, "SESSION_ELSEWHERE", "{refused}");
    }
    assert!(seen.len() < 40, "{}", seen.len());
    assert!(
        seen == expected[..seen.len()],
        "what it said is what the others say"
    );
    let owner = epoch(&fleet, "slept").map(|held| held.0);
    assert_eq!(owner.as_deref(), Some("server-1"));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_server_without_the_session_names_the_one_that_has_it() {
    let Some(fleet) = Fleet::start("fleet-owner", 2) else {
        return;
    };
    let first = Client::connect(&fleet.url(0).parse().unwrap())
        .await
        .unwrap();
    let session = session(&first, "named").await;
    let url = fleet.url(1).to_owned();
    let endpoint = tonic::transport::Endpoint::from_shared(url).unwrap();
    let mut other = SessionServiceClient::new(endpoint.connect().await.unwrap());
    let request = v1::GetSessionRequest { name: session.name };
    let refused = other.get_session(request.clone()).await.unwrap_err();
    let info = refused.get_details_error_info().unwrap();
    assert_eq!(info.reason, "SESSION_ELSEWHERE");
    assert_eq!(info.metadata["owner"], "server-0");
    assert_eq!(info.metadata["resumes"], "true");
    let unknown = v1::GetSessionRequest {
        name: "sessions/unknown".to_owned(),
    };
    let missing = other.get_session(unknown).await.unwrap_err();
    assert_eq!(
        missing.get_details_error_info().unwrap().reason,
        "SESSION_NOT_FOUND"
    );
    // One that ends well gives its sessions back at once.
    fleet.servers[0].0.signal("-TERM");
    let asked = Instant::now();
    let found = loop {
        match other.get_session(request.clone()).await {
            Ok(found) => break found.into_inner().session.unwrap(),
            Err(refused) => {
                let info = refused.get_details_error_info().unwrap();
                assert_eq!(info.reason, "SESSION_ELSEWHERE");
                tokio::time::sleep(Duration::from_millis(20)).await;
            }
        }
    };
    assert!(asked.elapsed() < LEASE, "{:?}", asked.elapsed());
    assert_eq!(found.name, "sessions/named");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_restart_of_nats_within_the_lease_costs_nothing() {
    let Some(mut fleet) = Fleet::start("fleet-nats", 1) else {
        return;
    };
    let expected = undisturbed().await;
    let way = Way::to(fleet.addresses()).await;
    let client = way.client().await;
    let session = session(&client, "patient").await;
    let results = drive(&client, &session.name, async |count| {
        if count == 30 {
            fleet.nats.kill();
            fleet.nats.run();
        }
    })
    .await;
    assert!(results == expected, "the same bits");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_session_that_nobody_writes_to_goes_where_somebody_wants_to() {
    let Some(fleet) = Fleet::start("fleet-wish", 2) else {
        return;
    };
    let expected = undisturbed().await;
    let way = Way::to(fleet.addresses()).await;
    let client = way.client().await;
    let session = session(&client, "wished").await;
    let mut longest = Duration::ZERO;
    let mut before = Instant::now();
    let results = drive(&client, &session.name, async |count| {
        longest = longest.max(before.elapsed());
        before = Instant::now();
        // A proxy that has forgotten where the session is, with both servers alive.
        if count % 20 == 0 {
            way.turn();
        }
    })
    .await;
    assert!(results == expected, "the same bits");
    eprintln!("longest pause {longest:?}");
    // While somebody writes to it, it stays.
    let way_of_writer = client.solve("wished", Attach::default()).await.unwrap();
    let holder = epoch(&fleet, "wished").unwrap();
    let number = usize::from(holder.0 == "server-0");
    let endpoint = tonic::transport::Endpoint::from_shared(fleet.url(number).to_owned()).unwrap();
    let mut other = SessionServiceClient::new(endpoint.connect().await.unwrap());
    let open = v1::SolveOpen {
        session: session.name,
        ..Default::default()
    };
    let open = v1::SolveRequest {
        message: Some(v1::solve_request::Message::Open(open)),
    };
    let mut stream = other
        .solve(tokio_stream::iter([open]))
        .await
        .unwrap()
        .into_inner();
    let refused = stream.message().await.unwrap_err();
    assert_eq!(
        refused.get_details_error_info().unwrap().reason,
        "SESSION_ELSEWHERE"
    );
    assert_eq!(epoch(&fleet, "wished"), Some(holder));
    drop(way_of_writer);
}
