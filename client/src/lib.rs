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
//! | room | what it is for | may import |
//! |---|---|---|
//! | `formats` | files of meshes, surfaces and grids | nothing |
//! | `library` | the service as a client sees it | `formats` |
//! | [`scene_file`] | scenes as TOML | `library`, `formats` |
//! | [`study`] | one scene for many values of its keys | `library`, `scene_file` |
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

pub mod formats;
mod library;
pub mod scene_file;
pub mod study;

pub use library::connect::{Client, ServerAddress};
pub use library::credentials::Credentials;
pub use library::error::{ClientError, Refusal, Violation};
pub use library::mesh::{Uploaded, WireMesh};
pub use library::read::StepResults;
pub use library::session::{NewSession, session_id};
pub use library::surface::WireSurface;
pub use library::{bounded_file, refine, result_line, solve};
