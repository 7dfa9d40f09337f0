//! Uploads of grids: heights over a plane, or signed distances in space.

use std::sync::Arc;

use signorini::obstacle::grid::{DistanceGrid, GridError, HeightField, Lattice, MOST_NODES};
use signorini_proto::digest::{grid_digest, hex};
use signorini_proto::v1 as wire;

use super::mesh::{Numbers, limit};
use super::uploaded::Surface;
use super::wide;
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
        let nodes = nodes.map_err(|error| {
            if matches!(error, GridError::ManyNodes { .. }) {
                limit("header.grid.counts", MOST_NODES as i64)
            } else {
                Fault::SurfaceInvalid(error.to_string())
            }
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

    /// The values, all of them.
    ///
    /// # Errors
    /// `RequestInvalid` when values are missing.
    pub(super) fn finish(self) -> Result<WholeGrid, Fault> {
        Ok(WholeGrid {
            values: self.values.finish("values")?,
            counts: self.counts,
            lattice: self.lattice,
        })
    }
}

/// A grid with all its values.
pub(super) struct WholeGrid {
    lattice: AnyLattice,
    counts: Vec<usize>,
    pub(super) values: Vec<f64>,
}

impl WholeGrid {
    /// The first node and the spacing, along each axis.
    fn nodes(&self) -> (&[f64], &[f64]) {
        match &self.lattice {
            AnyLattice::Plane(lattice) => (&lattice.origin, &lattice.spacing),
            AnyLattice::Space(lattice) => (&lattice.origin, &lattice.spacing),
        }
    }

    pub(super) fn digest(&self) -> String {
        hex(&grid_digest(&self.counts, self.nodes(), &self.values))
    }

    /// As its header has it.
    pub(super) fn described(&self) -> wire::Grid {
        let (origin, spacing) = self.nodes();
        wire::Grid {
            counts: self
                .counts
                .iter()
                .map(|count| wide(*count as u64))
                .collect(),
            origin: origin.to_vec(),
            spacing: spacing.to_vec(),
        }
    }

    /// The surface through the values.
    ///
    /// # Errors
    /// `SurfaceInvalid` with the node.
    pub(super) fn surface(self) -> Result<Surface, Fault> {
        let surface = match self.lattice {
            AnyLattice::Plane(lattice) => {
                HeightField::new(lattice, &self.values).map(|grid| Surface::Heights(Arc::new(grid)))
            }
            AnyLattice::Space(lattice) => DistanceGrid::new(lattice, &self.values)
                .map(|grid| Surface::Distances(Arc::new(grid))),
        };
        surface.map_err(|error| Fault::SurfaceInvalid(error.to_string()))
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

#[cfg(test)]
mod tests {
    use signorini_proto::array;

    use super::*;

    fn plane() -> wire::Grid {
        wire::Grid {
            counts: vec![4, 5],
            origin: vec![0.0, 1.0],
            spacing: vec![1.0, 0.5],
        }
    }

    fn refused(change: impl FnOnce(&mut wire::Grid)) -> Fault {
        let mut grid = plane();
        change(&mut grid);
        GridUpload::new(&grid).err().expect("refused")
    }

    fn is_named(fault: &Fault, path: &str) -> bool {
        format!("{fault:?}").contains(path)
    }

    #[test]
    fn a_header_that_is_no_grid_names_its_field() {
        let counts = "header.grid.counts";
        assert!(is_named(&refused(|one| one.counts = vec![4]), counts));
        assert!(is_named(&refused(|one| one.counts = vec![4; 4]), counts));
        assert!(is_named(&refused(|one| one.counts[1] = -1), counts));
        let origin = refused(|one| one.origin.truncate(1));
        assert!(is_named(&origin, "header.grid.origin"));
        let spacing = refused(|one| one.spacing.push(1.0));
        assert!(is_named(&spacing, "header.grid.spacing"));
        let few = refused(|one| one.counts[0] = 3);
        assert!(matches!(few, Fault::SurfaceInvalid(_)));
        let many = refused(|one| one.counts = vec![i64::MAX; 2]);
        assert!(matches!(many, Fault::MessageLimit { .. }));
    }

    #[test]
    fn values_make_a_grid_with_their_digest() {
        let heights: Vec<f64> = (0..20).map(|i| 0.01 * f64::from(i % 5)).collect();
        let mut upload = GridUpload::new(&plane()).unwrap();
        upload.push(0, &array::encode(&heights[..7])).unwrap();
        assert!(upload.push(8, &array::encode(&heights[8..])).is_err());
        upload.push(7, &array::encode(&heights[7..])).unwrap();
        let digest = hex(&grid_digest(&[4, 5], (&[0.0, 1.0], &[1.0, 0.5]), &heights));
        let whole = upload.finish().unwrap();
        assert_eq!(whole.digest(), digest);
        assert!(matches!(whole.surface(), Ok(Surface::Heights(_))));
        let mut short = GridUpload::new(&plane()).unwrap();
        short.push(0, &array::encode(&heights[..19])).unwrap();
        assert!(short.finish().is_err());
    }

    #[test]
    fn any_header_is_refused_or_holds_nothing_yet() {
        let mut rng = fastrand::Rng::with_seed(9);
        let (mut good, mut bad) = (0, 0);
        for _ in 0..10_000 {
            let axes = rng.usize(1..5);
            let count = |rng: &mut fastrand::Rng| match rng.u8(..8) {
                0 => rng.i64(..),
                1 => rng.i64(..4),
                _ => rng.i64(4..200),
            };
            let counts: Vec<i64> = (0..axes).map(|_| count(&mut rng)).collect();
            let numbers = vec![f64::from_bits(rng.u64(..)); axes];
            let (origin, spacing) = (numbers.clone(), numbers);
            let grid = wire::Grid {
                counts,
                origin,
                spacing,
            };
            match GridUpload::new(&grid) {
                Ok(upload) => {
                    assert!(upload.predicted_bytes() > 0);
                    assert!(upload.finish().is_err());
                    good += 1;
                }
                Err(_) => bad += 1,
            }
        }
        assert!(good > 1000 && bad > 1000, "{good} {bad}");
    }
}
