//! The tool as processes that a test starts and sends signals to.

use std::io::{BufRead as _, BufReader};
use std::process::{Child, Command, Stdio};

use super::{folder, signorini};

/// A process; killed when a test fails before it has stopped.
pub(crate) struct Process(pub(crate) Child);

impl Drop for Process {
    fn drop(&mut self) {
        // It has ended already when the test succeeds.
        let _ended = self.0.kill();
    }
}

impl Process {
    /// Sends a signal, such as `-TERM`.
    pub(crate) fn signal(&self, name: &str) {
        let id = self.0.id().to_string();
        let sent = Command::new("kill").args([name, &id]).status().unwrap();
        assert!(sent.success());
    }
}

/// Starts the tool with both outputs piped.
pub(crate) fn start<'a>(arguments: impl IntoIterator<Item = &'a str>) -> Process {
    let child = signorini()
        .args(arguments)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    Process(child)
}

/// Starts a server with more lines of configuration and reads where it listens.
pub(crate) fn serve(listen: &str, test: &str, more: &str) -> (Process, String) {
    serve_with_log(listen, test, more, Stdio::null())
}

/// As [`serve`], the log going to `log`.
pub(crate) fn serve_with_log(
    listen: &str,
    test: &str,
    more: &str,
    log: Stdio,
) -> (Process, String) {
    let config = folder(test).join("server.toml");
    std::fs::write(&config, format!("metrics_listen = \"\"\n{more}")).unwrap();
    let mut child = signorini()
        .args([
            "serve",
            "--config",
            config.to_str().unwrap(),
            "--listen",
            listen,
        ])
        .stdout(Stdio::piped())
        .stderr(log)
        .spawn()
        .unwrap();
    let mut url = String::new();
    BufReader::new(child.stdout.take().unwrap())
        .read_line(&mut url)
        .unwrap();
    (Process(child), url.trim().to_owned())
}
