//! Client of the Signorini service: connections, meshes, sessions, the solving
//! stream, and the files around them (Gmsh, Abaqus and VTK meshes and TOML scenes in,
//! VTK files and result lines out).
//!
//! A session in outline: [`formats::reader::read`] a mesh, [`Client::upload_mesh`]
//! it, [`scene_file::read`] a scene and name the mesh in it,
//! [`Client::create_session`], [`Client::solve`], send steps through
//! [`solve::Updates`] and take results from [`solve::Events`]. Others follow the
//! session with [`Client::watch`], read kept results with [`Client::read_step`]
//! and its mesh with [`Client::read_mesh`].
//!
//! The library knows the wire format only, never the solver. It prints nothing;
//! network errors and bad files are typed errors ([`ClientError`],
//! [`formats::reader::ReadError`], [`scene_file::SceneFileError`]). Cost beside the
//! server's: one copy of each mesh and field.
#![cfg_attr(
    not(test),
    warn(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::indexing_slicing
    )
)]

mod backoff;
pub mod bounded_file;
mod breaks;
mod connect;
mod credentials;
mod error;
pub mod formats;
mod mesh;
mod read;
pub mod result_line;
pub mod scene_file;
mod session;
pub mod solve;
pub mod study;
mod surface;

pub use connect::{Client, ServerAddress};
pub use credentials::Credentials;
pub use error::{ClientError, Refusal, Violation};
pub use mesh::{Uploaded, WireMesh};
pub use read::StepResults;
pub use session::{NewSession, session_id};
pub use surface::WireSurface;
