//! Why numbers on a grid are no tool.

use thiserror::Error;

/// A grid without meaning as a tool.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum GridError {
    /// Too few nodes for a cubic.
    #[error("has {count} nodes along axis {axis}, a cubic spline needs 4")]
    FewNodes {
        /// The axis, from 0.
        axis: usize,
        /// Its nodes.
        count: usize,
    },
    /// More nodes than are taken.
    #[error("has more than {limit} nodes")]
    ManyNodes {
        /// The most.
        limit: usize,
    },
    /// As many numbers as nodes are needed.
    #[error("has {there} values for {nodes} nodes")]
    OtherCount {
        /// Values that are there.
        there: usize,
        /// Product of the counts.
        nodes: usize,
    },
    /// An origin or a spacing that is NaN or infinite.
    #[error("has an origin or a spacing along axis {axis} that is not finite")]
    NotAPlace {
        /// The axis, from 0.
        axis: usize,
    },
    /// A spacing that is not above zero, or lost beside the coordinates.
    #[error(
        "has a spacing of {spacing} along axis {axis}, it must be above zero and above the rounding of the coordinates"
    )]
    Spacing {
        /// The axis, from 0.
        axis: usize,
        /// What was given.
        spacing: f64,
    },
    /// A value that is NaN, infinite or too large to compute with.
    #[error("the value at node {node:?} is not finite or too large")]
    NotFinite {
        /// Indices of the node, from 0.
        node: Vec<usize>,
    },
    /// Distances of one sign have no surface between them.
    #[error("no value is {side} zero: there is no surface in the grid")]
    NoSurface {
        /// `above` or `below`.
        side: &'static str,
    },
    /// The values near zero do not change as distances do.
    #[error(
        "near node {node:?} the values change by {slope:.3} a length, distances change by 1 (between 1/2 and 2 are taken): are they distances, in the unit of the spacing?"
    )]
    NotADistance {
        /// First node of the cell.
        node: Vec<usize>,
        /// Length of the gradient on the surface.
        slope: f64,
    },
    /// The surface bends faster than the nodes tell.
    #[error(
        "near node {node:?} the surface has a radius of {radius:.3e}, less than three spacings of {spacing:.3e}: a finer grid, or rounder edges, are needed"
    )]
    Coarse {
        /// Node, or first node of the cell.
        node: Vec<usize>,
        /// Smallest radius of curvature there.
        radius: f64,
        /// Largest spacing.
        spacing: f64,
    },
}
