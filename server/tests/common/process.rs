//! The server as a process that a test kills.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use super::Server;

/// A server of its own process on a data folder, killed at the end.
pub(crate) struct Process {
    child: Child,
    folder: PathBuf,
    more: String,
}

impl Process {
    /// Starts on `folder`/data; `more` are further settings.
    pub(crate) fn start(folder: &Path, more: &str) -> Self {
        let (folder, more) = (folder.to_owned(), more.to_owned());
        std::fs::write(
            folder.join("server.toml"),
            format!("metrics_listen = \"\"\nlog_format = \"text\"\n{more}"),
        )
        .unwrap();
        let child = spawn(&folder);
        Self {
            child,
            folder,
            more,
        }
    }

    /// Where it listens, once it does.
    pub(crate) fn url(&self) -> String {
        format!("unix:{}", self.folder.join("socket").display())
    }

    pub(crate) async fn connect(&self) -> Server {
        Server::beside(&self.url()).await
    }

    pub(crate) fn id(&self) -> u32 {
        self.child.id()
    }

    /// Bytes in memory now.
    pub(crate) fn resident(&self) -> u64 {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.id())).unwrap();
        let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
        let kibibytes = line.and_then(|line| line.split_whitespace().next());
        1024 * kibibytes.unwrap().parse::<u64>().unwrap()
    }

    /// SIGKILL, and gone when this returns.
    pub(crate) fn kill(&mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    /// SIGTERM, and how it ended.
    pub(crate) fn terminate(&mut self) -> bool {
        let id = self.child.id().to_string();
        assert!(
            Command::new("kill")
                .args(["-TERM", &id])
                .status()
                .unwrap()
                .success()
        );
        self.child.wait().unwrap().success()
    }

    /// Starts again on the same data.
    pub(crate) fn restart(&mut self) {
        *self = Self::start(&self.folder.clone(), &self.more.clone());
    }

    /// What it said before it ended by itself.
    pub(crate) fn refusal(folder: &Path) -> String {
        let output = command(folder).stderr(Stdio::piped()).output().unwrap();
        assert!(!output.status.success());
        String::from_utf8(output.stderr).unwrap()
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // It may have been killed already.
        let _gone = self.child.kill();
        let _waited = self.child.wait();
    }
}

fn command(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_signorini-server"));
    let socket = format!("unix:{}", folder.join("socket").display());
    command
        .env_remove("RUST_LOG")
        .arg("--config")
        .arg(folder.join("server.toml"))
        .args(["--listen", &socket])
        .arg("--data")
        .arg(folder.join("data"));
    command
}

fn spawn(folder: &Path) -> Child {
    let path = folder.join("log");
    let log = std::fs::OpenOptions::new()
        .append(true)
        .create(true)
        .open(path)
        .unwrap();
    command(folder)
        .stderr(log)
        .stdout(Stdio::null())
        .spawn()
        .unwrap()
}

/// An empty folder for one test.
pub(crate) fn folder(test: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"))
        .join("durable")
        .join(test);
    if folder.exists() {
        std::fs::remove_dir_all(&folder).unwrap();
    }
    std::fs::create_dir_all(&folder).unwrap();
    folder
}
