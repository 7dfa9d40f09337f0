//! What the command line asks for.
//!
//! | file | what it does |
//! |---|---|
//! | `access`, `fleet`, `objects`, `study` | arguments of groups of commands |
//! | `connection` | the server of a command: one that runs, or one in this process |
//! | `input` | files that a command names |
//! | `mesh_and_law` | a finer mesh and constants of a law for a scene |

mod access;
#[cfg(feature = "embedded")]
pub(crate) mod compared;
pub(crate) mod connection;
mod fleet;
pub(crate) mod input;
#[cfg(feature = "embedded")]
mod mesh_and_law;
mod objects;
mod study;

use std::path::PathBuf;

use clap::builder::Resettable;
use clap::{Args, CommandFactory as _, FromArgMatches as _, Parser, Subcommand};
use clap_complete::Shell;
use signorini_client::scene_file::Override;
use signorini_client::{Client, ServerAddress};

use crate::terminal::exit::Failure;
pub(crate) use access::AccessArguments;
#[cfg(feature = "embedded")]
pub(crate) use access::{CertsCommand, TokenCommand};
pub(crate) use fleet::FleetCommand;
#[cfg(feature = "embedded")]
use mesh_and_law::{FIT_EXAMPLES, REFINE_EXAMPLES};
#[cfg(feature = "embedded")]
pub(crate) use mesh_and_law::{FitArguments, RefineArguments};
pub(crate) use objects::{EmbedCommand, MeshCommand, SessionCommand};
#[cfg(feature = "fleet")]
pub(crate) use study::QueueArguments;
use study::{STUDY_EXAMPLES, WORKER_EXAMPLES};
pub(crate) use study::{Slots, StudyArguments, WorkerArguments};

/// Contact of nearly incompressible bodies, rubber included: solve scenes, serve, look at servers.
#[derive(Debug, Parser)]
#[command(name = "signorini", version, after_help = AFTER_HELP)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,
}

impl Arguments {
    /// Those of this process; prints what is asked for, or wrong, and ends it.
    pub(crate) fn of_process() -> Self {
        let matches = without_empty_variables(Self::command()).get_matches();
        Self::from_arg_matches(&matches).unwrap_or_else(|error| error.exit())
    }
}

/// Variables that are set to nothing, as scripts and units of systemd leave them, are unset.
fn without_empty_variables(command: clap::Command) -> clap::Command {
    let unset = |argument: clap::Arg| {
        let value = argument.get_env().and_then(std::env::var_os);
        match value.is_some_and(|value| value.is_empty()) {
            true => argument.env(Resettable::Reset),
            false => argument,
        }
    };
    command
        .mut_args(unset)
        .mut_subcommands(without_empty_variables)
}

const AFTER_HELP: &str = "\
Examples:
  signorini init ring.msh                    a commented scene for a mesh
  signorini check ring.toml                  every fault of it, solving nothing
  signorini solve ring.toml --out results    forces, report.html, files for ParaView

Units are yours: one set of lengths, forces and stresses throughout (mm, N and MPa, say).
Rotation vectors are in radians: a quarter turn is 1.5708.

Exit codes: 0 ok, 2 usage (or a name that the server does not know), 3 not converged (results kept),
4 invalid or unsupported scene or mesh, 5 no server, 6 refused (quota, queue, memory, size, in use,
token),
7 deadline, 8 server error, 9 no room on the disk, 10 server restarted (results kept),
11 not as accurate as asked (results kept), 130 interrupted";

const SOLVE_EXAMPLES: &str = "\
Examples:
  signorini solve ring.toml
  signorini solve ring.toml --out results --set step.0.increments=20
  signorini solve ring.toml --set material.rubber.c10=0.4 --json > lines.jsonl
  signorini solve ring.toml --server 127.0.0.1:50051 --detach --name ring-1

The force of an obstacle is told along its first travel, positive when it presses that way; of one
that never travels its size. What follows ± is the estimated error of the mesh. --out writes
report.html, results.csv, results.jsonl and a series for ParaView.";

const SESSION_EXAMPLES: &str = "\
Examples:
  export SIGNORINI_SERVER=127.0.0.1:50051
  signorini solve ring.toml --detach --name ring-1
  signorini watch ring-1
  signorini fetch ring-1 --out results";

const PLAN_EXAMPLES: &str = "\
Examples:
  signorini plan ring.toml
  signorini plan ring.toml --set solver.contact_space=linear --json";

const SERVE_EXAMPLES: &str = "\
Examples:
  signorini serve
  signorini serve --data /var/lib/signorini
  signorini serve --listen unix:/run/signorini.sock --metrics-listen ''
  signorini serve --config server.toml

Without a configuration it listens on 127.0.0.1:50051, and shows metrics on
http://127.0.0.1:9464/metrics. It prints its address once it listens.";

#[cfg(feature = "embedded")]
const CONFIG_EXAMPLES: &str = "\
Examples:
  signorini config check server.toml
  signorini config show --config server.toml --data /var/lib/signorini";

#[cfg(feature = "embedded")]
const DATA_EXAMPLES: &str = "\
Examples:
  signorini serve --data /var/lib/signorini
  signorini backup /var/lib/signorini monday
  signorini fsck monday
  signorini restore monday /var/lib/signorini-2";

#[cfg(feature = "embedded")]
const ACCESS_EXAMPLES: &str = "\
Examples:
  signorini certs init certificates --host solver.example
  signorini token add line-1 --role solve --tokens tokens.toml > line-1.token
  signorini session list --server https://solver.example:50051 --ca certificates/ca.pem \
    --token-file line-1.token
  signorini token revoke line-1 --tokens tokens.toml";

const MESH_EXAMPLES: &str = "\
Examples:
  signorini mesh info ring.msh
  signorini mesh put ring.msh --server 127.0.0.1:50051";

const INIT_EXAMPLES: &str = "\
Examples:
  signorini init ring.msh              writes ring.toml beside the mesh
  signorini init ring.msh study.toml";

/// Seconds that a server takes at most: 30 days.
const LONGEST_TTL: u64 = 30 * 24 * 3600;

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Solve a scene; without --server in a server of this process
    #[command(after_help = SOLVE_EXAMPLES)]
    Solve(SolveArguments),
    /// Solve one scene for many values of its keys: a row for each case
    #[command(after_help = STUDY_EXAMPLES)]
    Study(StudyArguments),
    /// Solve cases of studies from a queue
    #[command(after_help = WORKER_EXAMPLES)]
    Worker(WorkerArguments),
    /// Follow the results of a session, kept ones first
    #[command(after_help = SESSION_EXAMPLES)]
    Watch(WatchArguments),
    /// Fetch the kept results of a session as solve --out writes them
    #[command(after_help = SESSION_EXAMPLES)]
    Fetch(FetchArguments),
    /// Cancel a step of a session; its last good state is kept
    Cancel(CancelArguments),
    /// Check a scene and its mesh: every fault of it, exit code 4; solves nothing
    Check(CheckArguments),
    /// Print what a scene needs, what is left out and why
    #[command(after_help = PLAN_EXAMPLES)]
    Plan(PlanArguments),
    /// Write a commented scene for a mesh
    #[command(after_help = INIT_EXAMPLES)]
    Init {
        /// Mesh file
        mesh: PathBuf,
        /// Scene file to write, never over another; default: the mesh's name, ending in .toml
        scene: Option<PathBuf>,
    },
    /// Write a finer mesh for a scene: cells halved, groups and curved edges inherited
    #[command(after_help = REFINE_EXAMPLES)]
    #[cfg(feature = "embedded")]
    Refine(RefineArguments),
    /// Find the constants of a law of rubber from test curves
    #[command(after_help = FIT_EXAMPLES)]
    #[cfg(feature = "embedded")]
    Fit(FitArguments),
    /// Make the page report.html of a folder of results again
    Report {
        /// Folder that solve --out or fetch --out has written
        #[arg(value_name = "DIR")]
        folder: PathBuf,
    },
    /// Start a server
    #[command(after_help = SERVE_EXAMPLES)]
    Serve(ServeArguments),
    /// The settings of a server
    #[command(subcommand, after_help = CONFIG_EXAMPLES)]
    #[cfg(feature = "embedded")]
    Config(ConfigCommand),
    /// Copy the data folder of a server, which may be running
    #[command(after_help = DATA_EXAMPLES)]
    #[cfg(feature = "embedded")]
    Backup {
        /// Data folder
        #[arg(value_name = "DATA")]
        data: PathBuf,
        /// Folder to make
        #[arg(value_name = "DIR")]
        target: PathBuf,
        /// Give the files second names instead of copying them: at once and without room, and what
        /// spoils a file of the data folder spoils the backup
        #[arg(long)]
        link: bool,
    },
    /// Make a data folder from a backup without faults
    #[command(after_help = DATA_EXAMPLES)]
    #[cfg(feature = "embedded")]
    Restore {
        /// Folder that backup has made
        #[arg(value_name = "DIR")]
        backup: PathBuf,
        /// Data folder to make
        #[arg(value_name = "DATA")]
        data: PathBuf,
    },
    /// Check a data folder that no server uses: every fault of it, exit code 8
    #[command(after_help = DATA_EXAMPLES)]
    #[cfg(feature = "embedded")]
    Fsck {
        /// Data folder, or a backup
        #[arg(value_name = "DIR")]
        folder: PathBuf,
    },
    /// What this machine gives a server, and what will hold it up; exit code 8 where it cannot work
    #[cfg(feature = "embedded")]
    Doctor {
        /// Folder where a server shall keep its data
        #[arg(value_name = "DIR", default_value = ".")]
        folder: PathBuf,
        /// Program of the proxy that shall stand in front: haproxy or nginx; its version is judged
        #[arg(long, value_name = "PROGRAM")]
        proxy: Option<PathBuf>,
    },
    /// Tokens that a server asks for
    #[command(subcommand, after_help = ACCESS_EXAMPLES)]
    #[cfg(feature = "embedded")]
    Token(TokenCommand),
    /// Certificates for a server and its clients
    #[command(subcommand, after_help = ACCESS_EXAMPLES)]
    #[cfg(feature = "embedded")]
    Certs(CertsCommand),
    /// Measure error against run time: table, figures and a page
    #[cfg(feature = "bench")]
    Bench(signorini_bench::Arguments),
    /// A mesh file, and the meshes of a server
    #[command(subcommand, after_help = MESH_EXAMPLES)]
    Mesh(MeshCommand),
    /// Sessions of a server
    #[command(subcommand)]
    Session(SessionCommand),
    /// Sessions of several servers
    #[command(subcommand)]
    Fleet(FleetCommand),
    /// What a library of another language asks of this program
    #[command(subcommand, hide = true)]
    Embed(EmbedCommand),
    /// Print the version, as --version does
    #[command(hide = true)]
    Version,
    /// Print a completion script for a shell
    Completions {
        /// The shell
        shell: Shell,
    },
    /// Write manual pages into a folder
    Man {
        /// Folder, such as /usr/local/share/man/man1
        #[arg(value_name = "DIR")]
        folder: PathBuf,
    },
}

/// A scene and changes to it.
#[derive(Args, Clone, Debug)]
pub(crate) struct SceneArguments {
    /// Scene file (TOML)
    pub(crate) scene: PathBuf,
    /// Change a key of the scene, such as obstacle.ball.shape.radius=2
    #[arg(long = "set", value_name = "PATH=VALUE")]
    pub(crate) overrides: Vec<Override>,
    /// Server to use: HOST:PORT, http(s)://HOST:PORT or unix:PATH; default: one in this process
    #[arg(long, value_name = "URL", env = "SIGNORINI_SERVER")]
    pub(crate) server: Option<ServerAddress>,
    #[command(flatten)]
    pub(crate) access: AccessArguments,
}

#[derive(Args, Debug)]
pub(crate) struct SolveArguments {
    #[command(flatten)]
    pub(crate) scene: SceneArguments,
    /// Print result lines: one JSON object a line on stdout
    #[arg(long)]
    pub(crate) json: bool,
    /// Write a page, tables, result lines and files for ParaView into this folder
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Hand all steps to the server, print the session's name and leave
    #[arg(long, conflicts_with = "out")]
    pub(crate) detach: bool,
    /// Name of the detached session: 4 to 63 of a-z, 0-9 and -, a letter first
    #[arg(long, value_name = "NAME", requires = "detach")]
    pub(crate) name: Option<String>,
    /// Time to live of the detached session since its last use; default: one day
    #[arg(long, value_name = "SECONDS", requires = "detach",
        value_parser = clap::value_parser!(u64).range(1..=LONGEST_TTL))]
    pub(crate) ttl: Option<u64>,
    /// How long a broken connection is tried again, after which the server, too, cancels the step;
    /// default: 60
    #[arg(long, value_name = "SECONDS", conflicts_with = "detach",
        value_parser = clap::value_parser!(u64).range(..=LONGEST_TTL))]
    pub(crate) patience: Option<u64>,
    /// Bound the error of the force of every obstacle, along its motion where that is along an axis
    #[arg(long)]
    pub(crate) accuracy: bool,
    /// Recompute the residuals of each result by an independent path
    #[arg(long)]
    pub(crate) verify: bool,
    /// No progress, no warnings, no table
    #[arg(long)]
    pub(crate) quiet: bool,
    /// Tell also what the solver did and left out
    #[arg(long, conflicts_with = "quiet")]
    pub(crate) verbose: bool,
}

#[derive(Args, Debug)]
pub(crate) struct CheckArguments {
    #[command(flatten)]
    pub(crate) scene: SceneArguments,
}

#[derive(Args, Debug)]
pub(crate) struct PlanArguments {
    #[command(flatten)]
    pub(crate) scene: SceneArguments,
    /// One JSON object
    #[arg(long)]
    pub(crate) json: bool,
    /// The numbers, too, of the search for equilibrium, its stability and causes, and of force control
    #[arg(long)]
    pub(crate) constants: bool,
}

#[derive(Args, Clone, Debug)]
pub(crate) struct ServeArguments {
    #[cfg(feature = "embedded")]
    #[command(flatten)]
    pub(crate) flags: signorini_server::Flags,
}

#[cfg(feature = "embedded")]
#[derive(Debug, Subcommand)]
pub(crate) enum ConfigCommand {
    /// Check settings and the files that they name: the first fault, exit code 2
    Check {
        /// Configuration file (TOML)
        file: PathBuf,
    },
    /// Print what serve would use with the same flags, and where each value comes from
    Show {
        #[command(flatten)]
        serve: ServeArguments,
        /// Print where each value comes from, as is done anyway
        #[arg(long)]
        origin: bool,
    },
}

/// A server that runs already.
#[derive(Args, Debug)]
pub(crate) struct RemoteArguments {
    /// Server: HOST:PORT, http(s)://HOST:PORT or unix:PATH
    #[arg(long, value_name = "URL", env = "SIGNORINI_SERVER")]
    pub(crate) server: ServerAddress,
    #[command(flatten)]
    pub(crate) access: AccessArguments,
    /// One JSON object a line
    #[arg(long)]
    pub(crate) json: bool,
}

impl RemoteArguments {
    /// Connects with what the server may ask for.
    pub(crate) async fn connect(&self) -> Result<Client, Failure> {
        Ok(Client::connect_with(&self.server, &self.access.read()?).await?)
    }
}

#[derive(Args, Debug)]
pub(crate) struct WatchArguments {
    /// Name or identifier
    pub(crate) session: String,
    /// Go on when every step is answered, until the session ends
    #[arg(long)]
    pub(crate) follow: bool,
    /// Tell also what the solver did and left out
    #[arg(long)]
    pub(crate) verbose: bool,
    #[command(flatten)]
    pub(crate) remote: RemoteArguments,
}

#[derive(Args, Debug)]
pub(crate) struct FetchArguments {
    /// Name or identifier; or surfaces/DIGEST, a triangulated tool of the server
    pub(crate) session: String,
    /// Write a page, tables, result lines and files for ParaView into this folder; of a tool its STL file
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Tell also what the solver did and left out
    #[arg(long)]
    pub(crate) verbose: bool,
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

#[cfg(test)]
mod tests {
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
