//! Power that goes while a file is written, of a mesh, a tool or a state: what was answered is there, whole, and what
//! was under way is there or not.
//!
//! At each step of a write the data folder is copied as a disk may have it when the power comes
//! back: bytes that nobody waited for are short, torn or zero, names that nobody waited for old,
//! new or none. The database has a model of its own.

mod common;

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use common::{Block, Server, Tool, folder, open, press, reason};
use signorini_proto::v1 as wire;
use signorini_proto::v1::surface_service_client::SurfaceServiceClient;
use signorini_server::{Config, fsck};

const SECTOR: usize = 512;
/// The steps of a write, in their order.
const POINTS: [&str; 5] = [
    "file-write",
    "file-sync",
    "file-rename",
    "folder-sync",
    "journal-commit",
];

/// The folders of files.
const PARTS: [&str; 3] = ["meshes", "states", "surfaces"];

/// What is known of the file that is being written.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Progress {
    Written,
    /// Its bytes were waited for.
    Synced,
    Named,
    /// Its name was waited for.
    Kept,
}

/// Takes pictures of a disk at each step of a write.
struct Camera {
    data: PathBuf,
    pictures: PathBuf,
    /// Files whose upload was answered, and the names by which clients ask for them.
    answered: Vec<(PathBuf, String)>,
    progress: Progress,
    taken: Vec<(PathBuf, &'static str, Vec<String>)>,
    random: fastrand::Rng,
}

impl Camera {
    /// Called before the step `point`.
    fn reach(&mut self, point: &'static str) {
        let is_part = |path: &PathBuf| path.extension().is_some_and(|end| end == "part");
        let parts = self.files().into_iter().any(|path| is_part(&path));
        match point {
            "file-write" => self.progress = Progress::Written,
            "folder-sync" => self.progress = Progress::Named,
            _ => {}
        }
        // A commit may be none of this.
        if parts || self.progress >= Progress::Named {
            self.take(point);
        }
        match point {
            "file-sync" => self.progress = Progress::Synced,
            "folder-sync" => self.progress = Progress::Kept,
            _ => {}
        }
    }

    /// The upload was answered: its file is there for good.
    fn answer(&mut self, name: String) {
        assert!(
            self.progress == Progress::Kept,
            "answered before the disk had it"
        );
        let (folder, digest) = name.split_once('/').unwrap();
        let path = Path::new(folder).join(digest);
        self.answered.push((path, name));
        self.take("answer");
        self.progress = Progress::Written;
    }

    /// Files of the folder, by their places in it.
    fn files(&self) -> Vec<PathBuf> {
        let mut found = Vec::new();
        for part in PARTS {
            for entry in fs::read_dir(self.data.join(part)).unwrap() {
                found.push(Path::new(part).join(entry.unwrap().file_name()));
            }
        }
        found
    }

    fn take(&mut self, point: &'static str) {
        let picture = self.pictures.join(self.taken.len().to_string());
        for part in PARTS {
            fs::create_dir_all(picture.join(part)).unwrap();
        }
        for file in ["FORMAT", "journal.redb"] {
            fs::copy(self.data.join(file), picture.join(file)).unwrap();
        }
        for path in self.files() {
            let is_safe = self.answered.iter().any(|(safe, _)| *safe == path);
            let bytes = fs::read(self.data.join(&path)).unwrap();
            if is_safe || self.progress == Progress::Kept {
                fs::write(picture.join(path), bytes).unwrap()
            } else {
                self.leave(&picture.join(path), bytes)
            }
        }
        let names = self.answered.iter().map(|(_, name)| name.clone()).collect();
        self.taken.push((picture, point, names));
    }

    /// What the disk may have of a file that nobody waited for wholly.
    fn leave(&mut self, path: &Path, bytes: Vec<u8>) {
        let bytes = match self.progress {
            Progress::Written => self.torn(bytes),
            Progress::Synced | Progress::Named | Progress::Kept => bytes,
        };
        match self.random.u8(..3) {
            // Neither name has come.
            0 => {}
            // The old one.
            1 => fs::write(path.with_file_name("0.part"), bytes).unwrap(),
            _ => fs::write(path, bytes).unwrap(),
        }
    }

    /// Some sectors came, the length came or not.
    fn torn(&mut self, mut bytes: Vec<u8>) -> Vec<u8> {
        for sector in bytes.chunks_mut(SECTOR) {
            match self.random.u8(..4) {
                0 => sector.fill(0),
                1 => self.random.fill(sector),
                _ => {}
            }
        }
        if self.random.bool() {
            bytes.truncate(self.random.usize(..=bytes.len() / SECTOR) * SECTOR);
        }
        bytes
    }
}

async fn on(data: &Path) -> Server {
    let config = Config {
        data: data.to_str().unwrap().to_owned(),
        ..Config::embedded()
    };
    let server = Server::with(config).await;
    // An answer comes when the folder is open.
    let list = wire::ListMeshesRequest::default();
    server.meshes().list_meshes(list).await.unwrap();
    server
}

async fn stop(mut server: Server) {
    server.signal_stop();
    server.stopped().await.unwrap();
}

async fn upload(server: &Server, block: &Block) -> Result<String, tonic::Status> {
    let parts = tokio_stream::iter(block.messages());
    let made = server.meshes().upload_mesh(parts).await?;
    Ok(made.into_inner().mesh.unwrap().name)
}

async fn send(server: &Server, tool: Tool) -> String {
    let mut surfaces = SurfaceServiceClient::new(server.channel.clone());
    let parts = tokio_stream::iter(tool.messages());
    let made = surfaces.upload_surface(parts).await.unwrap();
    made.into_inner().surface.unwrap().name
}

/// Whether a scene may name the tool, and what it is refused for else.
async fn knows(server: &Server, (block, tool, name): (&Block, Tool, &str)) -> Result<(), String> {
    let mut scene = block.scene();
    scene.obstacles[0].shape = Some(tool.shape(name.to_owned()));
    let request = wire::CreateSessionRequest {
        scene: Some(scene),
        validate_only: true,
        ..Default::default()
    };
    let found = server.sessions().create_session(request).await;
    found.map(drop).map_err(|refused| reason(&refused))
}

async fn import(server: &Server, bytes: &[u8]) -> String {
    use sha2::Digest as _;
    let slice = wire::ImportStateRequest {
        digest: signorini_proto::digest::hex(&sha2::Sha256::digest(bytes).into()),
        offset: 0,
        data: bytes::Bytes::copy_from_slice(bytes),
    };
    let mut sessions = server.sessions();
    let made = sessions.import_state(tokio_stream::iter([slice])).await;
    made.unwrap().into_inner().state
}

/// States of a session on the smallest block, one a step.
async fn states(steps: i64) -> Vec<Vec<u8>> {
    let (server, block) = (Server::start().await, Block::new(1));
    server.upload(&block).await;
    let session = server.session(block.scene()).await;
    let mut stream = server.open(open(&session)).await;
    let mut found = Vec::new();
    for sequence in 1..=steps {
        let depth = 0.01 * sequence as f64;
        stream.step(sequence, press(depth, 1)).await;
        stream.result().await;
        let request = wire::ExportStateRequest {
            name: session.clone(),
        };
        let slices = server.sessions().export_state(request).await.unwrap();
        let (mut slices, mut bytes) = (slices.into_inner(), Vec::new());
        while let Some(slice) = slices.message().await.unwrap() {
            bytes.extend_from_slice(&slice.data);
        }
        found.push(bytes);
    }
    found
}

/// Starts on a picture: everything that was answered is there, and what was under way
/// can be sent again.
async fn check(picture: &Path, what: &str, names: &[String], blocks: &[Block]) {
    let server = on(picture).await;
    for block in blocks {
        let name = format!("meshes/{}", block.digest());
        let request = wire::CreateSessionRequest {
            scene: Some(block.scene()),
            validate_only: true,
            ..Default::default()
        };
        let found = server.sessions().create_session(request).await;
        match found {
            Ok(_) => {}
            Err(refused) => {
                assert_eq!(reason(&refused), "MESH_NOT_FOUND", "{what}: {refused}");
                assert!(!names.contains(&name), "{what}: {name} is lost");
            }
        }
        assert_eq!(upload(&server, block).await.unwrap(), name, "{what}");
    }
    for tool in Tool::ALL {
        let sent = names.iter().find(|name| **name == tool.name());
        let known = knows(&server, (&blocks[0], tool, &tool.name())).await;
        match known {
            Ok(()) => {}
            Err(reason) => {
                assert_eq!(reason, "SURFACE_NOT_FOUND", "{what}");
                assert_eq!(sent, None, "{what}: a tool is lost");
            }
        }
        assert_eq!(send(&server, tool).await, tool.name(), "{what}");
    }
    for name in names.iter().filter(|name| name.starts_with("states/")) {
        let request = wire::CreateSessionRequest {
            from_state: name.clone(),
            ..Default::default()
        };
        let made = server.sessions().create_session(request).await;
        assert!(made.is_ok(), "{what}: {name}: {made:?}");
    }
    stop(server).await;
    let found = fsck(picture).unwrap();
    assert_eq!(found.faults, Vec::<String>::new(), "{what}");
}

#[tokio::test(flavor = "multi_thread")]
async fn power_that_goes_while_an_upload_or_a_state_is_written_loses_nothing_that_was_answered() {
    let tests = folder("power");
    let (blocks, states) = ([1, 4].map(Block::new), states(2).await);
    let server = on(&tests.join("data")).await;
    let camera = Arc::new(Mutex::new(Camera {
        data: tests.join("data"),
        pictures: tests.join("pictures"),
        answered: Vec::new(),
        progress: Progress::Written,
        taken: Vec::new(),
        random: fastrand::Rng::with_seed(17),
    }));
    let with = |work: &mut dyn FnMut(&mut Camera)| {
        work(&mut camera.lock().unwrap_or_else(PoisonError::into_inner));
    };
    for point in POINTS {
        let camera = Arc::clone(&camera);
        let reach = move || camera.lock().unwrap().reach(point);
        fail::cfg_callback(point, reach).unwrap();
    }
    for (block, bytes) in blocks.iter().zip(&states) {
        let name = upload(&server, block).await.unwrap();
        with(&mut |camera| camera.answer(name.clone()));
        let name = import(&server, bytes).await;
        with(&mut |camera| camera.answer(name.clone()));
    }
    for tool in Tool::ALL {
        let name = send(&server, tool).await;
        with(&mut |camera| camera.answer(name.clone()));
    }
    POINTS.into_iter().for_each(fail::remove);
    stop(server).await;
    let mut taken = Vec::new();
    with(&mut |camera| taken = std::mem::take(&mut camera.taken));
    for point in POINTS.iter().chain(&["answer"]) {
        let count = taken.iter().filter(|(_, at, _)| at == point).count();
        assert!(count >= 4, "{count} pictures at {point}");
    }
    for (picture, point, names) in &taken {
        let what = format!("{} at {point}", picture.display());
        check(picture, &what, names, &blocks).await;
    }
}
