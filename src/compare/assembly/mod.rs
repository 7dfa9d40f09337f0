//! Assembled matrices that only comparison methods ask for: the edge block of the
//! hierarchical preconditioners, stiffness and divergence of the comparison elements.

pub(crate) mod edge_stiffness;
pub(crate) mod eliminated;
pub(crate) mod enriched;
