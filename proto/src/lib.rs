//! The wire format of the Signorini service: generated messages and services,
//! the codec of bulk arrays, the digest that names a mesh, the words of enum
//! values, and the axis of an obstacle's motion.
//!
//! No other logic lives here. Scenes and reports are plain messages; arrays travel as
//! little-endian, row-major bytes (see [`mod@array`]). The features `client` and
//! `server` add the two sides of the services to [`v1`], the feature `serde` lets
//! reports and plans be written as JSON.

#![cfg_attr(
    not(test),
    warn(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::indexing_slicing
    )
)]

pub mod array;
pub mod digest;
#[cfg(feature = "serde")]
mod serialised;
pub mod travel;
pub mod words;

/// Messages and services of the package `signorini.v1`; documented in the
/// `.proto` files.
#[allow(
    missing_docs,
    unreachable_pub,
    unused_qualifications,
    rustdoc::all,
    clippy::all,
    clippy::pedantic,
    clippy::wildcard_enum_match_arm,
    clippy::large_futures
)]
pub mod v1 {
    tonic::include_proto!("signorini.v1");
}

/// Encoded `FileDescriptorSet` of the package and all it imports, for reflection.
pub const FILE_DESCRIPTOR_SET: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/signorini.binpb"));

/// Largest `data` of one chunk message, bytes.
pub const CHUNK_BYTES: usize = 1 << 20;
