//! Uploads of triangulated surfaces into the library's arrays, and what is stored of them.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::SystemTime;

use signorini::obstacle::surface::TriangulatedSurface;
use signorini_proto::digest::{hex, surface_digest};
use signorini_proto::v1 as wire;

use super::mesh::{Indices, Points, limit, size};
use super::wide;
use crate::fault::Fault;

const MAXIMUM_VERTICES: i64 = 10_000_000;
const MAXIMUM_FACETS: i64 = 20_000_000;
const PREFIX: &str = "surfaces/";
const DIGITS: usize = 64;
/// Arrays of the upload, those of the surface, and what checking them holds.
const BYTES_OF_VERTEX: u64 = 24 + 24;
const BYTES_OF_FACET: u64 = 12 + 24 + 200;

/// Surfaces that a scene names, by their names.
pub(crate) type SurfacesByName = HashMap<String, Arc<TriangulatedSurface>>;

/// The digest in `surfaces/{digest}`.
///
/// # Errors
/// For another form; `path` names the field.
pub(crate) fn digest_of(name: &str, path: &str) -> Result<String, Fault> {
    let digest = name.strip_prefix(PREFIX).filter(|digest| is_digest(digest));
    digest
        .map(str::to_owned)
        .ok_or_else(|| Fault::request(path, "must be `surfaces/` and 64 hexadecimal digits"))
}

fn is_digest(text: &str) -> bool {
    let is_digit = |byte: u8| byte.is_ascii_digit() || (b'a'..=b'f').contains(&byte);
    text.len() == DIGITS && text.bytes().all(is_digit)
}

/// `surfaces/{digest}`.
pub(crate) fn name(digest: &str) -> String {
    format!("{PREFIX}{digest}")
}

/// Names of surfaces in a scene.
pub(crate) fn names(scene: &wire::Scene) -> Vec<String> {
    let shapes = scene.obstacles.iter().filter_map(|one| one.shape.as_ref());
    let name = |shape: &wire::Shape| -> Option<String> {
        match &shape.kind {
            Some(wire::shape::Kind::Surface(surface)) => Some(surface.surface.clone()),
            Some(_) | None => None,
        }
    };
    shapes.filter_map(name).collect()
}

/// The arrays, still growing.
pub(crate) struct Upload {
    /// What the header says; none where the upload leaves it to the server.
    pub(crate) digest: Option<String>,
    vertices: usize,
    facets: usize,
    coordinates: Points,
    corners: Indices,
}

impl Upload {
    /// Checks a header.
    ///
    /// # Errors
    /// `RequestInvalid` with the field, `MessageLimit` for a size beyond its maximum.
    pub(crate) fn new(header: wire::SurfaceHeader) -> Result<Self, Fault> {
        let digest = match header.digest.as_str() {
            "" => None,
            digest if is_digest(digest) => Some(header.digest),
            _ => {
                let text = "must be empty or 64 hexadecimal digits";
                return Err(Fault::request("header.digest", text));
            }
        };
        let vertices = size(header.vertex_count, MAXIMUM_VERTICES, "header.vertex_count")?;
        let facets = size(header.facet_count, MAXIMUM_FACETS, "header.facet_count")?;
        let corners = facets
            .checked_mul(3)
            .ok_or_else(|| limit("header.facet_count", MAXIMUM_FACETS))?;
        Ok(Self {
            digest,
            vertices,
            facets,
            coordinates: Points::new(vertices),
            corners: Indices::new(corners),
        })
    }

    /// Bytes that the upload and the surface take at most.
    pub(crate) fn predicted_bytes(&self) -> u64 {
        BYTES_OF_VERTEX * self.vertices as u64 + BYTES_OF_FACET * self.facets as u64
    }

    /// Takes one chunk.
    ///
    /// # Errors
    /// `RequestInvalid` that names the array, `MessageLimit` for a chunk of more than 1 MiB.
    pub(crate) fn push(&mut self, chunk: &wire::SurfaceChunk) -> Result<(), Fault> {
        let (offset, data) = (chunk.offset_elements, &chunk.data);
        match wire::SurfaceArray::try_from(chunk.array) {
            Ok(wire::SurfaceArray::Coordinates) => {
                self.coordinates.push("coordinates", offset, data)
            }
            Ok(wire::SurfaceArray::Facets) => self.corners.push("facets", offset, data),
            Ok(wire::SurfaceArray::Unspecified) | Err(_) => {
                let text = "names no array of a surface";
                Err(Fault::request("chunk.array", text))
            }
        }
    }

    /// The surface and its digest.
    ///
    /// # Errors
    /// `RequestInvalid` when an array is incomplete or has another digest, `SurfaceInvalid` with
    /// the facet.
    pub(crate) fn finish(self) -> Result<(String, TriangulatedSurface), Fault> {
        let vertices = self.coordinates.finish("coordinates")?;
        let corners = self.corners.finish("facets")?;
        let signed: Vec<i32> = corners.iter().map(|corner| corner.cast_signed()).collect();
        let digest = hex(&surface_digest(vertices.as_flattened(), &signed));
        if let Some(declared) = self.digest.filter(|declared| *declared != digest) {
            let text = format!("the arrays have the digest {digest}, not {declared}");
            return Err(Fault::request("header.digest", text));
        }
        let facets = corners.as_chunks::<3>().0.to_vec();
        let surface = TriangulatedSurface::new(vertices, facets);
        let invalid = |error: signorini::obstacle::surface::SurfaceError| {
            Fault::SurfaceInvalid(error.to_string())
        };
        Ok((digest, surface.map_err(invalid)?))
    }
}

/// A surface that came at a time.
pub(crate) fn surface(
    digest: &str,
    surface: &TriangulatedSurface,
    created: SystemTime,
) -> wire::StoredSurface {
    wire::StoredSurface {
        name: name(digest),
        digest: digest.to_owned(),
        vertex_count: wide(surface.vertices().len() as u64),
        facet_count: wide(surface.facets().len() as u64),
        memory_bytes: wide(surface.bytes()),
        create_time: Some(created.into()),
    }
}
