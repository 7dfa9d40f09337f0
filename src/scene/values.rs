//! Values of another code: one row a node, facet or cell of what they act on.
//!
//! Nodes are numbered as those of the displacement: vertices as uploaded, then the middles of
//! the edges of all cells, as (low, high) pairs of vertices in lexicographic order. Facets and
//! cells are numbered as uploaded. All numbers are from 0.

/// What the rows of values belong to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ValuePlace {
    /// Vertices, and edges or not; without edges their middles have the means of the ends.
    #[default]
    Nodes,
    /// Facets, constant on each.
    Facets,
    /// Cells, constant on each.
    Cells,
}

impl ValuePlace {
    /// The word for one of them.
    pub fn name(self) -> &'static str {
        match self {
            Self::Nodes => "node",
            Self::Facets => "facet",
            Self::Cells => "cell",
        }
    }
}

/// Rows of values `[rows, 3]`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Values {
    /// What the rows belong to.
    pub place: ValuePlace,
    /// Number of the node, facet or cell of each row, each once; empty: those of what the
    /// values act on in ascending order.
    pub numbers: Vec<u32>,
    /// The values, units as the key that they stand beside: all nodes, or all vertices, all
    /// facets or all cells of what they act on have a row.
    pub rows: Vec<[f64; 3]>,
}
