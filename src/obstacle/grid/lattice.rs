//! Nodes of a regular grid in `N` dimensions.

use super::error::GridError;

/// Most nodes of a grid: 256 along each of three axes.
pub const MOST_NODES: usize = 1 << 24;
/// Nodes that a cubic needs.
const FEWEST: usize = 4;

/// The nodes origin + i spacing, the last axis fastest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice<const N: usize> {
    /// Nodes along each axis, at least four.
    pub counts: [usize; N],
    /// The first node `[N]`, length.
    pub origin: [f64; N],
    /// Between nodes along each axis, length, above zero.
    pub spacing: [f64; N],
}

impl<const N: usize> Lattice<N> {
    /// Number of nodes.
    ///
    /// # Errors
    /// [`GridError::FewNodes`], [`GridError::ManyNodes`].
    pub fn nodes(&self) -> Result<usize, GridError> {
        let few = (0..N).find(|&axis| self.counts[axis] < FEWEST);
        if let Some(axis) = few {
            let count = self.counts[axis];
            return Err(GridError::FewNodes { axis, count });
        }
        let product = |all: usize, count: &usize| all.checked_mul(*count);
        let nodes = self.counts.iter().try_fold(1, product);
        let limit = MOST_NODES;
        nodes
            .filter(|nodes| *nodes <= limit)
            .ok_or(GridError::ManyNodes { limit })
    }

    /// Refuses what is no grid, or has not a finite value a node.
    pub(super) fn check(&self, values: &[f64]) -> Result<(), GridError> {
        let nodes = self.nodes()?;
        let there = values.len();
        if there != nodes {
            return Err(GridError::OtherCount { there, nodes });
        }
        for axis in 0..N {
            let spacing = self.spacing[axis];
            let end = self.origin[axis] + self.counts[axis] as f64 * spacing;
            if !end.is_finite() || !self.origin[axis].is_finite() {
                return Err(GridError::NotAPlace { axis });
            }
            // A spacing that the coordinates do not resolve is none.
            if spacing <= 4.0 * f64::EPSILON * self.origin[axis].abs() {
                return Err(GridError::Spacing { axis, spacing });
            }
        }
        match values.iter().position(|value| !value.is_finite()) {
            Some(index) => Err(GridError::NotFinite {
                node: self.node(index).to_vec(),
            }),
            None => Ok(()),
        }
    }

    /// Indices along the axes of a node.
    pub(super) fn node(&self, index: usize) -> [usize; N] {
        let mut rest = index;
        let mut node = [0; N];
        for axis in (0..N).rev() {
            node[axis] = rest % self.counts[axis];
            rest /= self.counts[axis];
        }
        node
    }

    /// A place in units of the spacing from the first node.
    pub(super) fn place(&self, units: [f64; N]) -> [f64; N] {
        std::array::from_fn(|k| self.origin[k] + units[k] * self.spacing[k])
    }

    /// The last node `[N]`.
    pub(super) fn end(&self) -> [f64; N] {
        self.place(self.counts.map(|count| (count - 1) as f64))
    }

    /// The largest spacing.
    pub(super) fn coarsest(&self) -> f64 {
        self.spacing.into_iter().fold(0.0, f64::max)
    }

    /// The smallest spacing.
    pub(super) fn finest(&self) -> f64 {
        self.spacing.into_iter().fold(f64::INFINITY, f64::min)
    }
}
