//! The object store of NATS beside a folder, for what is too large for a message. A measurement:
//! `cargo test --release -p signorini-client --features fleet --test stores -- --ignored --nocapture`.

mod common;

use std::fs::{self, File};
use std::io::{Cursor, Write as _};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use async_nats::jetstream::object_store::ObjectStore;
use async_nats::jetstream::{self, object_store};
use common::process::Process;
use tokio::io::AsyncReadExt as _;

const ROUNDS: usize = 5;
const SIZES: [usize; 4] = [1, 4, 16, 64];
const MIB: usize = 1 << 20;

async fn store(folder: &Path) -> Option<(Process, ObjectStore)> {
    let port = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = port.local_addr().unwrap().port();
    let command = ["-js", "-a", "127.0.0.1", "-p", &port.to_string(), "-sd"];
    let mut nats = Command::new("nats-server");
    nats.args(command).arg(folder.join("nats"));
    let nats = nats.stdout(Stdio::null()).stderr(Stdio::null()).spawn();
    let nats = Process(nats.ok()?);
    while TcpStream::connect(("127.0.0.1", port)).is_err() {
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    let client = async_nats::connect(format!("nats://127.0.0.1:{port}"));
    let config = object_store::Config {
        bucket: "measured".to_owned(),
        ..Default::default()
    };
    let context = jetstream::new(client.await.unwrap());
    let store = context.create_object_store(config).await.unwrap();
    Some((nats, store))
}

async fn put(store: &ObjectStore, name: &str, bytes: &[u8]) {
    store.put(name, &mut Cursor::new(bytes)).await.unwrap();
}

async fn get(store: &ObjectStore, name: &str) -> Vec<u8> {
    let (mut object, mut bytes) = (store.get(name).await.unwrap(), Vec::new());
    object.read_to_end(&mut bytes).await.unwrap();
    bytes
}

/// As the shared folder of a fleet is written.
fn write(folder: &Path, name: &str, bytes: &[u8]) {
    let (part, path) = (folder.join(format!("{name}.part")), folder.join(name));
    let mut file = File::create(&part).unwrap();
    file.write_all(bytes).unwrap();
    file.sync_all().unwrap();
    fs::rename(part, path).unwrap();
    File::open(folder).unwrap().sync_all().unwrap();
}

fn median(mut seconds: Vec<f64>) -> f64 {
    seconds.sort_by(f64::total_cmp);
    seconds[seconds.len() / 2]
}

#[tokio::test(flavor = "multi_thread")]
#[ignore = "measures"]
async fn an_object_store_beside_a_folder() {
    let folder = common::folder("stores");
    let Some((_nats, store)) = store(&folder).await else {
        eprintln!("left out: nats-server is not there");
        return;
    };
    eprintln!("MiB    put: store  folder    get: store  folder   (seconds, medians of {ROUNDS})");
    for size in SIZES {
        let mut seconds = [const { Vec::new() }; 4];
        for round in 0..ROUNDS {
            let mut bytes = vec![0; size * MIB];
            fastrand::Rng::with_seed(round as u64).fill(&mut bytes);
            let name = format!("{size}-{round}");
            let mut since = Instant::now();
            let mut lap = |number: usize| {
                seconds[number].push(since.elapsed().as_secs_f64());
                since = Instant::now();
            };
            put(&store, &name, &bytes).await;
            lap(0);
            write(&folder, &name, &bytes);
            lap(1);
            let found = get(&store, &name).await;
            lap(2);
            let read = fs::read(folder.join(&name)).unwrap();
            lap(3);
            assert!(found == bytes && read == bytes);
        }
        let [put, wrote, got, read] = seconds.map(median);
        eprintln!("{size:4}   {put:9.4}  {wrote:6.4}   {got:9.4}  {read:6.4}");
    }
}
