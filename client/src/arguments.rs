//! The arguments of the command line.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use clap_complete::Shell;
use signorini_client::ServerAddress;
use signorini_client::scene_file::Override;

use crate::commands::embed::EmbedCommand;

/// Contact of nearly incompressible bodies, rubber included: solve scenes, serve, look at servers.
#[derive(Debug, Parser)]
#[command(name = "signorini", version, after_help = EXIT_CODES)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,
}

const EXIT_CODES: &str = "Exit codes: 0 ok, 2 usage, 3 not converged (results kept), \
    4 invalid or unsupported scene or mesh, 5 no server, 6 refused (quota, queue, memory, size), \
    7 deadline, 8 server error, 130 interrupted";

/// Seconds that a server takes at most: 30 days.
const LONGEST_TTL: u64 = 30 * 24 * 3600;

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Solve a scene; without --server in a server of this process
    Solve(SolveArguments),
    /// Follow the results of a session, kept ones first
    Watch(WatchArguments),
    /// Fetch the kept results of a session as solve --out writes them
    Fetch(FetchArguments),
    /// Cancel a step of a session; its last good state is kept
    Cancel(CancelArguments),
    /// Print what a scene needs, what is left out and why
    Plan(PlanArguments),
    /// Start a server
    Serve(ServeArguments),
    /// Measure error against run time: table, figures and a page
    #[cfg(feature = "bench")]
    Bench(signorini_bench::Arguments),
    /// Meshes of a server
    #[command(subcommand)]
    Mesh(MeshCommand),
    /// Sessions of a server
    #[command(subcommand)]
    Session(SessionCommand),
    /// What a library of another language asks of this program
    #[command(subcommand, hide = true)]
    Embed(EmbedCommand),
    /// Print a completion script for a shell
    Completions {
        /// The shell
        shell: Shell,
    },
}

/// A scene and changes to it.
#[derive(Args, Debug)]
pub(crate) struct SceneArguments {
    /// Scene file (TOML)
    pub(crate) scene: PathBuf,
    /// Change a key of the scene, such as obstacle.ball.shape.radius=2
    #[arg(long = "set", value_name = "PATH=VALUE")]
    pub(crate) overrides: Vec<Override>,
    /// Server to use: http://HOST:PORT or unix:PATH; default: one in this process
    #[arg(long, value_name = "URL")]
    pub(crate) server: Option<ServerAddress>,
    /// Print result lines: one JSON object a line on stdout
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args, Debug)]
pub(crate) struct SolveArguments {
    #[command(flatten)]
    pub(crate) scene: SceneArguments,
    /// Write PVD, VTU and VTP files and result lines into this folder
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Hand all steps to the server, print the session's name and leave
    #[arg(long, conflicts_with = "out")]
    pub(crate) detach: bool,
    /// Time to live of the detached session since its last use; default: one day
    #[arg(long, value_name = "SECONDS", requires = "detach",
        value_parser = clap::value_parser!(u64).range(1..=LONGEST_TTL))]
    pub(crate) ttl: Option<u64>,
    /// Recompute the residuals of each result by an independent path
    #[arg(long)]
    pub(crate) verify: bool,
    /// No progress, no warnings, no table
    #[arg(long)]
    pub(crate) quiet: bool,
}

#[derive(Args, Debug)]
pub(crate) struct PlanArguments {
    #[command(flatten)]
    pub(crate) scene: SceneArguments,
}

#[derive(Args, Debug)]
pub(crate) struct ServeArguments {
    /// Configuration file (TOML)
    #[arg(long, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,
    /// Where to listen: HOST:PORT or unix:PATH; replaces the configured address
    #[arg(long, value_name = "ADDRESS")]
    pub(crate) listen: Option<String>,
    /// Where the metrics page is served: HOST:PORT, or empty for nowhere
    #[arg(long, value_name = "ADDRESS")]
    pub(crate) metrics_listen: Option<String>,
    /// How the log is written on stderr
    #[cfg(feature = "embedded")]
    #[arg(long, value_name = "FORMAT", env = "SIGNORINI_LOG_FORMAT")]
    pub(crate) log_format: Option<signorini_server::LogFormat>,
    /// The least important lines of the log; RUST_LOG goes before it
    #[cfg(feature = "embedded")]
    #[arg(long, value_name = "LEVEL", env = "SIGNORINI_LOG_LEVEL")]
    pub(crate) log_level: Option<signorini_server::LogLevel>,
}

/// A server that runs already.
#[derive(Args, Debug)]
pub(crate) struct RemoteArguments {
    /// Server: http://HOST:PORT or unix:PATH
    #[arg(long, value_name = "URL")]
    pub(crate) server: ServerAddress,
    /// One JSON object a line
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args, Debug)]
pub(crate) struct WatchArguments {
    /// Name or identifier
    pub(crate) session: String,
    /// Go on when every step is answered, until the session ends
    #[arg(long)]
    pub(crate) follow: bool,
    #[command(flatten)]
    pub(crate) remote: RemoteArguments,
}

#[derive(Args, Debug)]
pub(crate) struct FetchArguments {
    /// Name or identifier
    pub(crate) session: String,
    /// Write PVD, VTU and VTP files and result lines into this folder
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// One step only
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(i64).range(1..))]
    pub(crate) step: Option<i64>,
    #[command(flatten)]
    pub(crate) remote: RemoteArguments,
}

#[derive(Args, Debug)]
pub(crate) struct CancelArguments {
    /// Name or identifier
    pub(crate) session: String,
    /// The step, accepted or running; default: the one that runs
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(i64).range(1..))]
    pub(crate) sequence: Option<i64>,
    #[command(flatten)]
    pub(crate) remote: RemoteArguments,
}

#[derive(Debug, Subcommand)]
pub(crate) enum MeshCommand {
    /// Upload a mesh file and print its digest
    Put {
        /// Gmsh file
        file: PathBuf,
        #[command(flatten)]
        remote: RemoteArguments,
    },
    /// List meshes
    List {
        #[command(flatten)]
        remote: RemoteArguments,
    },
    /// Drop a mesh that no session uses
    Delete {
        /// Digest
        digest: String,
        #[command(flatten)]
        remote: RemoteArguments,
    },
}

#[derive(Debug, Subcommand)]
pub(crate) enum SessionCommand {
    /// List sessions
    List {
        #[command(flatten)]
        remote: RemoteArguments,
    },
    /// Show one session
    Show {
        /// Name or identifier
        session: String,
        #[command(flatten)]
        remote: RemoteArguments,
    },
    /// Cancel what runs and forget a session
    Delete {
        /// Name or identifier
        session: String,
        #[command(flatten)]
        remote: RemoteArguments,
    },
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory as _;

    use super::*;

    #[test]
    fn the_definition_of_arguments_is_consistent() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn a_build_without_the_bench_has_no_such_command() {
        let command = Arguments::command();
        let bench = command.find_subcommand("bench");
        assert_eq!(bench.is_some(), cfg!(feature = "bench"));
    }
}
