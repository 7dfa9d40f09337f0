//! Uploads of grids: heights over a plane, or signed distances in space.

use std::sync::Arc;

use signorini::obstacle::grid::{DistanceGrid, GridError, HeightField, Lattice, MOST_NODES};
use signorini_proto::digest::{grid_digest, hex};
use signorini_proto::v1 as wire;

use super::mesh::{Numbers, limit};
use super::surface::Surface;
use crate::fault::Fault;

/// Nodes that a spline adds along an axis: beyond both ends.
const ADDED: u64 = 8;
/// Bytes a node while a spline is made: values, coefficients, and those of the axis before.
const BYTES_OF_NODE: u64 = 32;

/// Nodes in a plane or in space.
enum AnyLattice {
    Plane(Lattice<2>),
    Space(Lattice<3>),
}

/// The values of a grid, still growing.
pub(super) struct GridUpload {
    lattice: AnyLattice,
    counts: Vec<usize>,
    values: Numbers,
}

impl GridUpload {
    /// Checks the nodes.
    ///
    /// # Errors
    /// `RequestInvalid` with the field, `SurfaceInvalid` for counts that no grid has,
    /// `MessageLimit` for too many nodes.
    pub(super) fn new(grid: &wire::Grid) -> Result<Self, Fault> {
        let negative = |_| Fault::request("header.grid.counts", "must not be negative");
        let count = |count: &i64| usize::try_from(*count).map_err(negative);
        let counts: Vec<usize> = grid.counts.iter().map(count).collect::<Result<_, _>>()?;
        let (lattice, nodes) = match counts.len() {
            2 => {
                let lattice = lattice(&counts, grid)?;
                (AnyLattice::Plane(lattice), lattice.nodes())
            }
            3 => {
                let lattice = lattice(&counts, grid)?;
                (AnyLattice::Space(lattice), lattice.nodes())
            }
            _ => {
                let text = "must be two of heights or three of distances";
                return Err(Fault::request("header.grid.counts", text));
            }
        };
        let nodes = nodes.map_err(|error| match error {
            GridError::ManyNodes { .. } => limit("header.grid.counts", MOST_NODES as i64),
            other => Fault::SurfaceInvalid(other.to_string()),
        })?;
        Ok(Self {
            lattice,
            counts,
            values: Numbers::new(nodes),
        })
    }

    /// Bytes that the upload and the spline take at most.
    pub(super) fn predicted_bytes(&self) -> u64 {
        let longer = self.counts.iter().map(|count| *count as u64 + ADDED);
        longer.fold(BYTES_OF_NODE, u64::saturating_mul)
    }

    /// Takes one chunk of the values.
    ///
    /// # Errors
    /// `RequestInvalid`, `MessageLimit`.
    pub(super) fn push(&mut self, offset: i64, data: &[u8]) -> Result<(), Fault> {
        self.values.push("values", offset, data)
    }

    /// The surface and its digest, which is checked first.
    ///
    /// # Errors
    /// `RequestInvalid` when values are missing, `SurfaceInvalid` with the node.
    pub(super) fn finish(
        self,
        check: impl FnOnce(&str) -> Result<(), Fault>,
    ) -> Result<(String, Surface), Fault> {
        let values = self.values.finish("values")?;
        let (origin, spacing) = match &self.lattice {
            AnyLattice::Plane(lattice) => (&lattice.origin[..], &lattice.spacing[..]),
            AnyLattice::Space(lattice) => (&lattice.origin[..], &lattice.spacing[..]),
        };
        let digest = hex(&grid_digest(&self.counts, (origin, spacing), &values));
        check(&digest)?;
        let surface = match self.lattice {
            AnyLattice::Plane(lattice) => {
                HeightField::new(lattice, &values).map(|grid| Surface::Heights(Arc::new(grid)))
            }
            AnyLattice::Space(lattice) => {
                DistanceGrid::new(lattice, &values).map(|grid| Surface::Distances(Arc::new(grid)))
            }
        };
        let surface = surface.map_err(|error| Fault::SurfaceInvalid(error.to_string()))?;
        Ok((digest, surface))
    }
}

/// The nodes of a header with `N` counts.
fn lattice<const N: usize>(counts: &[usize], grid: &wire::Grid) -> Result<Lattice<N>, Fault> {
    let one = |numbers: &[f64], path: &str| {
        let text = format!("needs {N} numbers, as `counts` has");
        <[f64; N]>::try_from(numbers).map_err(|_| Fault::request(path, text))
    };
    let mut lattice = Lattice {
        counts: [0; N],
        origin: one(&grid.origin, "header.grid.origin")?,
        spacing: one(&grid.spacing, "header.grid.spacing")?,
    };
    lattice.counts.copy_from_slice(counts);
    Ok(lattice)
}
