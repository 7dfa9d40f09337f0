//! Commands about what a server holds, and those of libraries of other languages.

use std::path::PathBuf;

use clap::Subcommand;
use signorini_client::scene_file::Override;

use super::RemoteArguments;

#[derive(Debug, Subcommand)]
pub(crate) enum MeshCommand {
    /// Groups, sizes and quality of a mesh file; needs no server
    Info {
        /// Mesh file
        file: PathBuf,
        /// One JSON object
        #[arg(long)]
        json: bool,
    },
    /// Upload a mesh file and print its digest
    Put {
        /// Mesh file
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

/// What a library of another language may ask.
#[derive(Debug, Subcommand)]
pub(crate) enum EmbedCommand {
    /// Read a scene (TOML) from stdin, print the message; its `mesh`, and the files of tools,
    /// are paths; no mesh where bodies have their own
    Scene {
        /// Names the scene: its stem is the default name, its folder holds the mesh
        path: PathBuf,
        /// Change a key of the scene
        #[arg(long = "set", value_name = "PATH=VALUE")]
        overrides: Vec<Override>,
    },
    /// Read a scene whose bodies have meshes of their own from stdin, print the messages of the
    /// upload of all of them as one, each after its length
    Bodies {
        /// Names the scene: its folder holds the meshes
        path: PathBuf,
        /// Change a key of the scene
        #[arg(long = "set", value_name = "PATH=VALUE")]
        overrides: Vec<Override>,
    },
    /// Read a mesh file, print the messages of its upload, each after its length
    Mesh {
        /// The file
        path: PathBuf,
    },
    /// Read an STL file, print the messages of its upload, each after its length
    Surface {
        /// The file
        path: PathBuf,
        /// Distance of corners that are one vertex, over the diagonal of their box
        #[arg(long)]
        weld: Option<f64>,
    },
    /// Read a grid of heights or distances, print the messages of its upload
    Grid {
        /// The file
        path: PathBuf,
    },
    /// Serve until stdin ends
    Serve {
        /// Where to listen: HOST:PORT or unix:PATH
        listen: String,
    },
}
