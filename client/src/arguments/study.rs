//! Arguments of studies and their workers.

use std::path::PathBuf;

use clap::Args;
use signorini_client::ServerAddress;
use signorini_client::scene_file::Override;

use super::AccessArguments;

pub(super) const STUDY_EXAMPLES: &str = "\
Examples:
  signorini study radii.toml --check
  signorini study radii.toml --out radii.csv --workers 4
  signorini study radii.toml --out radii.csv --workers 4 --resume

A study names a scene and what varies of it: [[grid]] lists and ranges of a key, [list] a CSV table
whose columns are keys, [sobol] points that fill a box. Each case is a row, failed ones with their
cause; exit code 3 when there are such. Ctrl-C keeps the rows so far, and --resume goes on.";

pub(super) const WORKER_EXAMPLES: &str = "\
Examples:
  nats-server --jetstream --store_dir /var/lib/nats &
  signorini worker --queue nats://127.0.0.1:4222 &
  signorini study radii.toml --out radii.csv --queue nats://127.0.0.1:4222

Start as many workers as there are machines and cores. Ctrl-C once gives the case that runs back to
the queue, twice quits; a worker that dies loses nothing.";

/// Cases that one process solves at one time at most.
const MOST_WORKERS: usize = 1024;

/// Seconds that a worker waits at most: 30 days.
const LONGEST_IDLE: u64 = 30 * 24 * 3600;

#[derive(Args, Debug)]
pub(crate) struct StudyArguments {
    /// Study file (TOML)
    pub(crate) study: PathBuf,
    /// Change a key of the scene of every case
    #[arg(long = "set", value_name = "PATH=VALUE")]
    pub(crate) overrides: Vec<Override>,
    /// Table of the cases, ending in .csv or .parquet; default: the study's name, ending in
    /// .results.csv. Its log lies beside it
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    /// Write the fields of each case for ParaView into a folder of this one
    #[arg(long, value_name = "DIR")]
    pub(crate) fields: Option<PathBuf>,
    /// Cases that are solved at one time; default: one for each core
    #[arg(long, value_name = "N", value_parser = workers)]
    pub(crate) workers: Option<usize>,
    #[command(flatten)]
    pub(crate) threads: ThreadArguments,
    /// Times that a case is begun at most
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(crate) tries: u32,
    /// Go on with an interrupted run: cases that have a row are not solved again
    #[arg(long)]
    pub(crate) resume: bool,
    /// Number of cases, the first of them, every fault of keys and table; solve nothing
    #[arg(long, visible_alias = "dry-run", conflicts_with = "resume")]
    pub(crate) check: bool,
    #[command(flatten)]
    pub(crate) queue: QueueArguments,
    /// No progress, no counts
    #[arg(long)]
    pub(crate) quiet: bool,
    /// Server to use: HOST:PORT, http(s)://HOST:PORT or unix:PATH; default: one in this process
    #[arg(long, value_name = "URL", env = "SIGNORINI_SERVER")]
    pub(crate) server: Option<ServerAddress>,
    #[command(flatten)]
    pub(crate) access: AccessArguments,
}

#[derive(Args, Debug)]
pub(crate) struct WorkerArguments {
    #[command(flatten)]
    pub(crate) queue: QueueArguments,
    /// Cases that are solved at one time; one keeps a case that ends the process from others
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = workers)]
    pub(crate) workers: usize,
    #[command(flatten)]
    pub(crate) threads: ThreadArguments,
    /// Write the fields of each case into a folder of this one, for studies that ask for fields
    #[arg(long, value_name = "DIR")]
    pub(crate) fields: Option<PathBuf>,
    /// End when no case has come for so long; default: never
    #[arg(long, value_name = "SECONDS", value_parser = clap::value_parser!(u64).range(1..=LONGEST_IDLE))]
    pub(crate) idle: Option<u64>,
    /// Show metrics for Prometheus at http://ADDRESS/metrics, such as 127.0.0.1:9465
    #[arg(long, value_name = "ADDRESS")]
    pub(crate) metrics: Option<std::net::SocketAddr>,
    /// Tell when a case begins
    #[arg(long)]
    pub(crate) verbose: bool,
    /// Server to use: HOST:PORT, http(s)://HOST:PORT or unix:PATH; default: one in this process
    #[arg(long, value_name = "URL", env = "SIGNORINI_SERVER")]
    pub(crate) server: Option<ServerAddress>,
    #[command(flatten)]
    pub(crate) access: AccessArguments,
}

/// Scenes that a server solves at one time, and the threads of each.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(not(feature = "embedded"), allow(dead_code))]
pub(crate) struct Slots {
    pub(crate) count: usize,
    pub(crate) threads: usize,
}

/// How a server of this process solves.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct ThreadArguments {
    /// Threads of each case, in a server of this process; default: its share of the cores
    #[arg(long, value_name = "N", value_parser = workers)]
    threads: Option<usize>,
}

impl ThreadArguments {
    /// For so many cases at one time.
    pub(crate) fn slots(self, count: usize) -> Slots {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let share = (cores / count.max(1)).max(1);
        Slots {
            count,
            threads: self.threads.unwrap_or(share),
        }
    }
}

/// Where cases of studies wait.
#[derive(Args, Debug)]
pub(crate) struct QueueArguments {
    /// NATS with JetStream: nats://HOST:PORT or tls://HOST:PORT, several with commas (feature `fleet`)
    #[arg(long, value_name = "URL", env = "SIGNORINI_QUEUE")]
    pub(crate) queue: Option<String>,
    /// Credentials file to show it
    #[arg(long, value_name = "FILE", env = "SIGNORINI_QUEUE_CREDENTIALS")]
    pub(crate) queue_credentials: Option<PathBuf>,
}

/// A number of workers.
fn workers(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(count @ 1..=MOST_WORKERS) => Ok(count),
        Ok(_) | Err(_) => Err(format!("a number from 1 to {MOST_WORKERS} is expected")),
    }
}
