//! Why a mesh is refused. Every message names the first offender by its
//! 0-based index in upload order, and how many there are.

use thiserror::Error;

use super::GroupKind;

/// A fault of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum CellFault {
    /// The cell names a vertex that does not exist.
    VertexOutOfRange,
    /// The cell names one vertex twice.
    RepeatedVertex,
    /// The cell has no volume (area) to speak of beside its edges.
    Degenerate,
    /// The cell has negative volume (area).
    Inverted,
    /// The cell has the same vertices as an earlier one.
    Duplicate,
    /// Is at least the third cell at one of its facets.
    CrowdedFacet,
}

impl CellFault {
    /// What is wrong, as the predicate of a sentence about the cell.
    fn description(self) -> &'static str {
        match self {
            Self::VertexOutOfRange => "names a vertex that does not exist",
            Self::RepeatedVertex => "names one vertex twice",
            Self::Degenerate => "is degenerate (no volume)",
            Self::Inverted => "is inverted (negative volume)",
            Self::Duplicate => "is a duplicate of an earlier cell",
            Self::CrowdedFacet => "shares a facet with two or more other cells",
        }
    }
}

/// A fault of a facet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FacetFault {
    /// The facet names a vertex that does not exist.
    VertexOutOfRange,
    /// The facet is not a facet of any cell.
    Detached,
}

impl FacetFault {
    /// What is wrong, as the predicate of a sentence about the facet.
    fn description(self) -> &'static str {
        match self {
            Self::VertexOutOfRange => "names a vertex that does not exist",
            Self::Detached => "is not a facet of any cell",
        }
    }
}

/// A fault of the offset of an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum EdgeFault {
    /// The vertices are no edge of any cell, lower one first.
    Detached,
    /// The edge does not come after the one before.
    Unordered,
    /// The offset is NaN or infinite.
    NotFinite,
    /// The offset leaves the plane of a triangle mesh.
    OffPlane,
    /// The offset is longer than half the edge.
    TooFar,
}

impl EdgeFault {
    /// What is wrong, as the predicate of a sentence about the offset.
    fn description(self) -> &'static str {
        match self {
            Self::Detached => "belongs to no edge of a cell (vertices ascending)",
            Self::Unordered => "does not come after the edge before",
            Self::NotFinite => "is not finite",
            Self::OffPlane => "leaves the plane z = 0 of a triangle mesh",
            Self::TooFar => "is longer than half its edge: the middle belongs to another edge",
        }
    }
}

/// A fault of a group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum GroupFault {
    /// The name of the group is empty.
    Unnamed,
    /// An earlier group of the same kind has the name.
    RepeatedName,
    /// A member names a cell or facet that does not exist.
    MemberOutOfRange,
    /// A cell or facet is in the group twice.
    RepeatedMember,
}

impl GroupFault {
    /// What is wrong, as the predicate of a sentence about the group.
    fn description(self) -> &'static str {
        match self {
            Self::Unnamed => "has no name",
            Self::RepeatedName => "has the name of an earlier group of the same kind",
            Self::MemberOutOfRange => "has a member that does not exist",
            Self::RepeatedMember => "holds a member twice",
        }
    }
}

/// A mesh that cannot be used.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum MeshError {
    /// The mesh has no cells: there is nothing to solve on.
    #[error("the mesh has no cells: neither triangles nor tetrahedra")]
    NoCells,
    /// A connectivity array is not a whole number of rows.
    #[error("the {array} array has {length} entries, which is no multiple of {row}")]
    ArrayLength {
        /// `cells` or `facets`.
        array: &'static str,
        /// Entries found.
        length: usize,
        /// Entries per row.
        row: usize,
    },
    /// An array has more entries than indices of 31 bits can name.
    #[error("the mesh has {count} {what}, more than {limit}")]
    TooLarge {
        /// `vertices`, `cells`, `facets`, `groups` or `edges`.
        what: &'static str,
        /// Number found.
        count: usize,
        /// Largest number possible.
        limit: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("vertex {first} has a coordinate that is not finite{}", others(*.count, "vertices"))]
    NotFinite {
        /// First such vertex.
        first: usize,
        /// Number of such vertices.
        count: usize,
    },
    /// A vertex of a triangle mesh leaves the plane z = 0.
    #[error("vertex {first} of a triangle mesh lies outside the plane z = 0{}", others(*.count, "vertices"))]
    OffPlane {
        /// First such vertex.
        first: usize,
        /// Number of such vertices.
        count: usize,
    },
    /// Some cells have a fault in common; the first and their number are named.
    #[error("cell {first} {}{}", .fault.description(), others(*.count, "cells"))]
    Cells {
        /// What is wrong.
        fault: CellFault,
        /// First such cell.
        first: usize,
        /// Number of such cells.
        count: usize,
    },
    /// Some facets have a fault in common; the first and their number are named.
    #[error("facet {first} {}{}", .fault.description(), others(*.count, "facets"))]
    Facets {
        /// What is wrong.
        fault: FacetFault,
        /// First such facet.
        first: usize,
        /// Number of such facets.
        count: usize,
    },
    /// Some offsets of edges have a fault in common; the first and their number are
    /// named.
    #[error("edge offset {first} {}{}", .fault.description(), others(*.count, "offsets"))]
    Edges {
        /// What is wrong.
        fault: EdgeFault,
        /// First such offset.
        first: usize,
        /// Number of such offsets.
        count: usize,
    },
    /// One group is faulty.
    #[error("{kind} group {index} \"{name}\" {}", .fault.description())]
    Group {
        /// What is wrong.
        fault: GroupFault,
        /// Position in the list of groups.
        index: usize,
        /// Name, cut to 64 characters.
        name: String,
        /// Cells or facets.
        kind: GroupKind,
    },
}

/// ` (5 such cells)` where there is more than the one named.
fn others(count: usize, noun: &str) -> String {
    if count > 1 {
        format!(" ({count} such {noun})")
    } else {
        String::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_name_the_first_and_the_count() {
        let fault = CellFault::Inverted;
        let cells = |count| {
            MeshError::Cells {
                fault,
                first: 7,
                count,
            }
            .to_string()
        };
        assert_eq!(cells(1), "cell 7 is inverted (negative volume)");
        assert_eq!(
            cells(3),
            "cell 7 is inverted (negative volume) (3 such cells)"
        );
    }

    #[test]
    fn group_messages_name_the_group() {
        let error = MeshError::Group {
            fault: GroupFault::MemberOutOfRange,
            index: 2,
            name: "top".to_owned(),
            kind: GroupKind::Facets,
        };
        assert_eq!(
            error.to_string(),
            "facet group 2 \"top\" has a member that does not exist"
        );
    }
}
