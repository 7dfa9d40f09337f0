//! Kills at random moments: no acknowledged step is lost, results are those of a server
//! that nobody killed, bit by bit.

mod common;

use std::path::Path;
use std::time::{Duration, Instant};

use common::{Block, Process, Server, Stream, bare, folder, open, press, reason};
use signorini_proto::v1::{self as wire, solve_response::Message};
use signorini_server::Config;
use tokio::time::timeout;
use tonic_types::StatusExt as _;

/// A checkpoint every 40 results, of which no more are kept.
const SETTINGS: &str = "maximum_in_flight = 16\nretained_results = 40\n";
/// Ends a test that would wait for ever.
const PATIENCE: Duration = Duration::from_secs(60);
/// Kills of the test; more are done by hand (`SIGNORINI_KILLS`).
const KILLS: usize = 20;
/// Steps of one round of the test.
const STEPS: i64 = 120;

/// The step of a sequence: to and fro, every seventh in parts.
fn step(sequence: i64) -> wire::LoadStep {
    let depth = 0.01 + 0.002 * ((sequence * 7) % 11) as f64;
    press(depth, if sequence % 7 == 0 { 3 } else { 1 })
}

/// Increments of a step.
fn parts(sequence: i64) -> i64 {
    i64::from(step(sequence).increments.unwrap())
}

/// A client that sends steps, a window at a time, and keeps what it is answered.
struct Client {
    session: String,
    results: Vec<wire::StepFinished>,
    fields: Vec<(i64, Vec<u8>)>,
}

impl Client {
    fn new(session: String) -> Self {
        Self {
            session,
            results: Vec::new(),
            fields: Vec::new(),
        }
    }

    /// The newest event whose fields have come too.
    fn seen(&self) -> i64 {
        self.results.last().map_or(0, |one| one.event)
    }

    /// The first sequence that is not answered wholly.
    fn next(&self) -> i64 {
        self.results
            .last()
            .map_or(1, |one| one.sequence + i64::from(one.last))
    }

    /// Goes on until `steps` are answered or the server is gone.
    async fn run(&mut self, server: &Server, steps: i64) -> Result<(), tonic::Status> {
        let open = wire::SolveOpen {
            last_seen_event: Some(self.seen()),
            fields: vec![wire::FieldName::Gap.into()],
            ..open(&self.session)
        };
        let mut stream = server.try_open(open).await?;
        let mut sent = self.next() - 1;
        while self.next() <= steps {
            while sent < steps && sent < self.next() + 8 {
                sent += 1;
                stream.try_step(sent, step(sent)).await?;
            }
            self.take(&mut stream).await?;
        }
        Ok(())
    }

    async fn take(&mut self, stream: &mut Stream) -> Result<(), tonic::Status> {
        match stream.try_next().await? {
            Message::StepFinished(result) => {
                let mut bytes = Vec::new();
                for _ in &result.fields {
                    loop {
                        let Message::Field(chunk) = stream.try_next().await? else {
                            panic!("a field is due");
                        };
                        bytes.extend_from_slice(&chunk.data);
                        if chunk.last {
                            break;
                        }
                    }
                }
                self.keep(result, bytes);
            }
            Message::Iteration(_) | Message::Heartbeat(_) => {}
            other @ (Message::Opened(_) | Message::Field(_) | Message::UpdateRejected(_)) => {
                panic!("no result: {other:?}")
            }
        }
        Ok(())
    }

    /// An update that was sent again is answered again, also in parts that came before.
    fn keep(&mut self, result: wire::StepFinished, bytes: Vec<u8>) {
        let (event, result) = (result.event, bare(result));
        let earlier = self.results.iter().position(|one| one.event == event);
        if let Some(earlier) = earlier {
            assert_eq!(self.results[earlier], result, "answered twice");
            assert_eq!(self.fields[earlier], (event, bytes), "answered twice");
            return;
        }
        assert_eq!(event, self.seen() + 1, "results are gapless");
        self.fields.push((event, bytes));
        self.results.push(result);
    }

    /// The session once it has all that was shown: a result may be shown before the disk has it.
    async fn made_again(&self, server: &Server) -> wire::Session {
        loop {
            let session = server.describe(&self.session).await;
            if session.last_finished_sequence >= self.next() - 1 {
                return session;
            }
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    }

    /// Asks for everything that is kept again, and compares.
    async fn check(&self, server: &Server) {
        let made = timeout(PATIENCE, self.made_again(server)).await;
        let session = made.expect("what was shown is made again from its update");
        let kept = session.first_retained_sequence;
        assert!(kept > 1 && kept < self.next());
        for (index, result) in self.results.iter().enumerate() {
            if result.sequence < kept {
                continue;
            }
            let increment = result.report.as_ref().unwrap().increment;
            let again = server.read(&self.session, result.sequence, increment).await;
            assert_eq!(bare(again.0), *result, "result {index}");
            assert_eq!(again.1, self.fields[index].1, "fields of result {index}");
        }
    }
}

async fn session(server: &Server, block: &Block, id: &str) -> String {
    let request = wire::CreateSessionRequest {
        scene: Some(scene(block)),
        session_id: id.into(),
        request_id: format!("request-{id}"),
        ttl: common::duration(3_600_000),
        ..Default::default()
    };
    let response = server.sessions().create_session(request).await.unwrap();
    response.into_inner().session.unwrap().name
}

fn scene(block: &Block) -> wire::Scene {
    let output = wire::Output {
        fields: vec![wire::FieldName::Gap.into()],
        ..Default::default()
    };
    wire::Scene {
        output: Some(output),
        ..block.scene()
    }
}

/// The results of a server that nobody kills.
async fn undisturbed(folder: &Path, block: &Block) -> Client {
    let calm = folder.join("calm");
    if calm.exists() {
        std::fs::remove_dir_all(&calm).unwrap();
    }
    std::fs::create_dir_all(&calm).unwrap();
    let process = Process::start(&calm, SETTINGS);
    let server = process.connect().await;
    server.upload(block).await;
    let mut client = Client::new(session(&server, block, "story").await);
    client.run(&server, STEPS).await.unwrap();
    client
}

/// Two clients on one server that is killed so often beneath them; then all their results
/// are those of `expected`, and can be read again.
async fn round(folder: &Path, block: &Block, expected: &Client, kills: usize) {
    let mut process = Process::start(folder, SETTINGS);
    let server = process.connect().await;
    server.upload(block).await;
    let mut one = Client::new(session(&server, block, "one-story").await);
    let mut other = Client::new(session(&server, block, "other-story").await);
    drop(server);
    for kill in 0..kills {
        let goal = STEPS * (kill as i64 + 1) / kills as i64;
        let server = process.connect().await;
        let life = Duration::from_millis(fastrand::u64(5..200));
        let both = async { tokio::join!(one.run(&server, goal), other.run(&server, goal)) };
        if let Ok((first, second)) = timeout(life, both).await {
            first.and(second).unwrap();
        }
        process.kill();
        process.restart();
        if fastrand::u8(..10) == 0 {
            // And once more while it starts.
            tokio::time::sleep(Duration::from_millis(fastrand::u64(..30))).await;
            process.kill();
            process.restart();
        }
    }
    let server = process.connect().await;
    for client in [&mut one, &mut other] {
        timeout(PATIENCE, client.run(&server, STEPS))
            .await
            .unwrap()
            .unwrap();
        client.check(&server).await;
        for (found, expected) in client.results.iter().zip(&expected.results) {
            assert_eq!(found, expected);
        }
        assert_eq!(client.fields, expected.fields);
        let increments: i64 = (1..=STEPS).map(parts).sum();
        assert_eq!(client.results.len() as i64, increments);
    }
    drop(process);
    assert_eq!(
        signorini_server::fsck(&folder.join("data")).unwrap().faults,
        Vec::<String>::new()
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn kills_at_random_moments_lose_nothing_and_change_no_bit() {
    let (folder, block) = (folder("kills"), Block::new(2));
    let expected = undisturbed(&folder, &block).await;
    round(&folder, &block, &expected, KILLS).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn ten_clients_whose_streams_break_over_a_killed_server_end_with_all_their_results() {
    const CLIENTS: usize = 10;
    const CUTS: usize = 7;
    let (folder, block) = (folder("cuts"), Block::new(1));
    let expected = undisturbed(&folder, &block).await;
    let mut process = Process::start(&folder, SETTINGS);
    let server = process.connect().await;
    server.upload(&block).await;
    let mut clients = Vec::new();
    for number in 0..CLIENTS {
        let name = session(&server, &block, &format!("cut-{number}")).await;
        clients.push(Client::new(name));
    }
    drop(server);
    let url = process.url();
    let mut work = tokio::task::JoinSet::new();
    for mut client in clients {
        let url = url.clone();
        work.spawn(async move {
            for _ in 0..CUTS {
                let life = Duration::from_millis(fastrand::u64(5..150));
                let server = Server::beside(&url).await;
                // Whether it is cut or the server goes is the same to it.
                let _broken = timeout(life, client.run(&server, STEPS)).await;
            }
            while client.next() <= STEPS {
                let server = Server::beside(&url).await;
                let ran = timeout(PATIENCE, client.run(&server, STEPS)).await;
                ran.expect("results come").ok();
            }
            client
        });
    }
    tokio::time::sleep(Duration::from_millis(300)).await;
    process.kill();
    process.restart();
    while let Some(client) = work.join_next().await {
        let client = client.unwrap();
        assert_eq!(client.results, expected.results);
        assert_eq!(client.fields, expected.fields);
    }
}

/// As many kills as `SIGNORINI_KILLS` says, in rounds; the log in the folder
/// `SIGNORINI_KILLS_DIR` counts them, so that a run that was stopped goes on.
#[tokio::test(flavor = "multi_thread")]
#[ignore = "by hand: hours"]
async fn many_kills_at_random_moments_lose_nothing_and_change_no_bit() {
    let number = |name| std::env::var(name).unwrap_or_default().parse();
    let wanted: usize = number("SIGNORINI_KILLS").unwrap_or(3000);
    let folder = std::env::var("SIGNORINI_KILLS_DIR").unwrap_or_else(|_| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("many-kills");
        folder.to_str().unwrap().to_owned()
    });
    let folder = Path::new(&folder);
    std::fs::create_dir_all(folder).unwrap();
    let log = folder.join("kills.log");
    let done = std::fs::read_to_string(&log).unwrap_or_default();
    let done: usize = done
        .lines()
        .filter(|line| line.ends_with("nothing lost"))
        .count();
    let block = Block::new(2);
    let expected = undisturbed(folder, &block).await;
    for number in done..wanted.div_ceil(KILLS) {
        let data = folder.join("round");
        if data.exists() {
            std::fs::remove_dir_all(&data).unwrap();
        }
        std::fs::create_dir_all(&data).unwrap();
        round(&data, &block, &expected, KILLS).await;
        let line = format!("{} kills: nothing lost\n", (number + 1) * KILLS);
        let mut file = std::fs::OpenOptions::new()
            .append(true)
            .create(true)
            .open(&log)
            .unwrap();
        std::io::Write::write_all(&mut file, line.as_bytes()).unwrap();
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn two_hundred_sessions_on_disk_hold_up_no_start_and_wake_when_they_are_called() {
    let (folder, block) = (folder("many"), Block::new(1));
    let mut process = Process::start(&folder, "");
    let server = process.connect().await;
    server.upload(&block).await;
    let mut clients = Vec::new();
    for number in 0..200 {
        let name = session(&server, &block, &format!("many-{number}")).await;
        if number % 20 == 0 {
            let mut client = Client::new(name);
            client.run(&server, 3).await.unwrap();
            clients.push(client);
        }
    }
    process.kill();
    let start = Instant::now();
    process.restart();
    let server = process.connect().await;
    let list = wire::ListSessionsRequest {
        page_size: 1000,
        ..Default::default()
    };
    let all = server
        .sessions()
        .list_sessions(list)
        .await
        .unwrap()
        .into_inner()
        .sessions;
    let ready = start.elapsed();
    assert_eq!(all.len(), 200);
    assert!(ready < Duration::from_secs(2), "{ready:?}");
    assert!(
        all.iter()
            .all(|one| one.state() == wire::SessionState::Asleep)
    );
    let client = &mut clients[1];
    timeout(PATIENCE, client.run(&server, 4))
        .await
        .unwrap()
        .unwrap();
    let awake = server.describe("sessions/many-20").await;
    assert_eq!(awake.last_finished_sequence, 4);
    // The request that made it finds it again.
    assert_eq!(session(&server, &block, "many-7").await, "sessions/many-7");
}

#[tokio::test]
async fn a_call_in_the_middle_of_a_shutdown_is_told_that_its_session_goes_on() {
    let data = folder("shutdown").join("data");
    let config = Config {
        data: data.to_str().unwrap().to_owned(),
        drain_seconds: 8,
        ..Config::embedded()
    };
    let mut server = Server::with(config).await;
    let block = Block::new(1);
    server.upload(&block).await;
    let session = server.session(block.scene()).await;
    // A stream that names no session is waited for.
    let (updates, outbound) = tokio::sync::mpsc::channel::<wire::SolveRequest>(1);
    let outbound = tokio_stream::wrappers::ReceiverStream::new(outbound);
    let nameless = server.sessions().solve(outbound).await.unwrap();
    server.signal_stop();
    let refused = loop {
        let request = wire::GetSessionRequest {
            name: session.clone(),
        };
        match server.sessions().get_session(request).await {
            Ok(_) => tokio::task::yield_now().await,
            Err(refused) => break refused,
        }
    };
    assert_eq!(reason(&refused), "SHUTTING_DOWN");
    let info = refused.get_details_error_info().unwrap();
    assert_eq!(info.metadata["resumes"], "true");
    drop((updates, nameless));
    server.stopped().await.unwrap();
}
