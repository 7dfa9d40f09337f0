//! Uploads of surfaces into the library's arrays, triangulated or as grids, and what is stored
//! of them.

mod file;
mod reading;

use std::sync::Arc;
use std::time::SystemTime;

use signorini::obstacle::surface::TriangulatedSurface;
use signorini_proto::digest::{hex, surface_digest};
use signorini_proto::v1 as wire;

use super::grid::{GridUpload, WholeGrid};
use super::mesh::{Indices, Points, limit, size};
use super::uploaded::Surface;
use super::wide;
use crate::fault::Fault;
pub(crate) use file::{predicted_bytes as bytes_of_file, read as from_file, write as to_file};
pub(crate) use reading::messages;

const MAXIMUM_VERTICES: i64 = 10_000_000;
const MAXIMUM_FACETS: i64 = 20_000_000;
const PREFIX: &str = "surfaces/";
const DIGITS: usize = 64;
/// Arrays of the upload, those of the surface, and the patches of its tools, which take more than
/// checking it does.
const BYTES_OF_VERTEX: u64 = 24 + 24;
const BYTES_OF_FACET: u64 = 12 + 24 + 240;

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
            Some(wire::shape::Kind::HeightField(field)) => Some(field.grid.clone()),
            Some(wire::shape::Kind::DistanceGrid(distances)) => Some(distances.grid.clone()),
            Some(_) | None => None,
        }
    };
    shapes.filter_map(name).collect()
}

/// A surface, still growing.
pub(crate) struct Upload {
    /// What the header says; none where the upload leaves it to the server.
    pub(crate) digest: Option<String>,
    arrays: Arrays,
}

/// The arrays.
enum Arrays {
    Triangulated {
        vertices: usize,
        facets: usize,
        coordinates: Points,
        corners: Indices,
    },
    Grid(GridUpload),
}

impl Upload {
    /// Checks a header.
    ///
    /// # Errors
    /// `RequestInvalid` with the field, `SurfaceInvalid` for counts that no grid has,
    /// `MessageLimit` for a size beyond its maximum.
    pub(crate) fn new(header: wire::SurfaceHeader) -> Result<Self, Fault> {
        let arrays = arrays(&header)?;
        let digest = match header.digest.as_str() {
            "" => None,
            digest if is_digest(digest) => Some(header.digest),
            _ => {
                let text = "must be empty or 64 hexadecimal digits";
                return Err(Fault::request("header.digest", text));
            }
        };
        Ok(Self { digest, arrays })
    }

    /// Bytes that the upload and the surface take at most.
    pub(crate) fn predicted_bytes(&self) -> u64 {
        match &self.arrays {
            Arrays::Triangulated {
                vertices, facets, ..
            } => BYTES_OF_VERTEX * *vertices as u64 + BYTES_OF_FACET * *facets as u64,
            Arrays::Grid(grid) => grid.predicted_bytes(),
        }
    }

    /// Takes one chunk.
    ///
    /// # Errors
    /// `RequestInvalid` that names the array, `MessageLimit` for a chunk of more than 1 MiB.
    pub(crate) fn push(&mut self, chunk: &wire::SurfaceChunk) -> Result<(), Fault> {
        use wire::SurfaceArray as Array;
        let (offset, data) = (chunk.offset_elements, &chunk.data);
        match (&mut self.arrays, Array::try_from(chunk.array)) {
            (Arrays::Triangulated { coordinates, .. }, Ok(Array::Coordinates)) => {
                coordinates.push("coordinates", offset, data)
            }
            (Arrays::Triangulated { corners, .. }, Ok(Array::Facets)) => {
                corners.push("facets", offset, data)
            }
            (Arrays::Grid(grid), Ok(Array::Values)) => grid.push(offset, data),
            (Arrays::Triangulated { .. } | Arrays::Grid(_), _) => {
                let text = "names no array of this surface";
                Err(Fault::request("chunk.array", text))
            }
        }
    }

    /// All arrays, with the digest that they have.
    ///
    /// # Errors
    /// `RequestInvalid` when an array is incomplete or has another digest.
    pub(crate) fn finish(self) -> Result<Whole, Fault> {
        let arrays = match self.arrays {
            Arrays::Triangulated {
                coordinates,
                corners,
                ..
            } => WholeArrays::Triangulated {
                vertices: coordinates.finish("coordinates")?,
                corners: corners.finish("facets")?,
            },
            Arrays::Grid(grid) => WholeArrays::Grid(grid.finish()?),
        };
        let digest = arrays.digest();
        match self.digest.filter(|declared| *declared != digest) {
            Some(declared) => {
                let text = format!("the arrays have the digest {digest}, not {declared}");
                Err(Fault::request("header.digest", text))
            }
            None => Ok(Whole { digest, arrays }),
        }
    }
}

/// An upload that is complete.
pub(crate) struct Whole {
    pub(crate) digest: String,
    arrays: WholeArrays,
}

enum WholeArrays {
    Triangulated {
        vertices: Vec<[f64; 3]>,
        corners: Vec<u32>,
    },
    Grid(WholeGrid),
}

impl WholeArrays {
    fn digest(&self) -> String {
        match self {
            Self::Triangulated { vertices, corners } => {
                let signed: Vec<i32> = corners.iter().map(|corner| corner.cast_signed()).collect();
                hex(&surface_digest(vertices.as_flattened(), &signed))
            }
            Self::Grid(grid) => grid.digest(),
        }
    }
}

impl Whole {
    /// The surface of the arrays.
    ///
    /// # Errors
    /// `SurfaceInvalid` with the facet or the node.
    pub(crate) fn surface(self) -> Result<Surface, Fault> {
        match self.arrays {
            WholeArrays::Triangulated { vertices, corners } => {
                let facets = corners.as_chunks::<3>().0.to_vec();
                let surface = TriangulatedSurface::new(vertices, facets);
                let surface = surface.map_err(|error| Fault::SurfaceInvalid(error.to_string()))?;
                Ok(Surface::Triangulated(Arc::new(surface)))
            }
            WholeArrays::Grid(grid) => grid.surface(),
        }
    }
}

/// Room for the arrays of a header.
fn arrays(header: &wire::SurfaceHeader) -> Result<Arrays, Fault> {
    if let Some(grid) = &header.grid {
        if (header.vertex_count, header.facet_count) != (0, 0) {
            let text = "stands in place of vertices and facets";
            return Err(Fault::request("header.grid", text));
        }
        return Ok(Arrays::Grid(GridUpload::new(grid)?));
    }
    let vertices = size(header.vertex_count, MAXIMUM_VERTICES, "header.vertex_count")?;
    let facets = size(header.facet_count, MAXIMUM_FACETS, "header.facet_count")?;
    let corners = facets
        .checked_mul(3)
        .ok_or_else(|| limit("header.facet_count", MAXIMUM_FACETS))?;
    Ok(Arrays::Triangulated {
        vertices,
        facets,
        coordinates: Points::new(vertices),
        corners: Indices::new(corners),
    })
}

/// A surface that came at a time.
pub(crate) fn surface(digest: &str, surface: &Surface, created: SystemTime) -> wire::StoredSurface {
    let (vertices, facets) = surface.counts();
    wire::StoredSurface {
        name: name(digest),
        digest: digest.to_owned(),
        vertex_count: wide(vertices as u64),
        facet_count: wide(facets as u64),
        memory_bytes: wide(surface.bytes()),
        create_time: Some(created.into()),
        grid_counts: surface.grid_counts(),
    }
}
