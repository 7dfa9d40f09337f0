//! What can be wrong with a mesh, whatever format it came in.

/// What is wrong with the nodes and elements of a file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshFault {
    /// A node number used twice.
    #[error("node {0} is defined twice")]
    DuplicateNode(u64),
    /// An element with a node that does not exist.
    #[error("an element refers to node {0}, which does not exist")]
    UnknownNode(u64),
    /// A coordinate that is infinite or not a number.
    #[error("node {0} has a coordinate that is not finite")]
    NotFinite(u64),
    /// A plane mesh outside the plane z = 0.
    #[error("a mesh of triangles must lie in the plane z = 0, but node {node} has z = {z}")]
    NotPlanar {
        /// Node number in the file.
        node: u64,
        /// Its z, as text.
        z: String,
    },
    /// Two elements of second order that put the middle of one edge apart.
    #[error(
        "the edge between the nodes {0} and {1} has its middle at two places: elements of second order must share the node, or its place"
    )]
    EdgeDisagrees(u64, u64),
    /// An edge whose middle is farther from the line than half its length.
    #[error(
        "the middle of the edge between the nodes {0} and {1} is farther away than half the edge: are the nodes of the element in the order that the format asks for?"
    )]
    EdgeTooFar(u64, u64),
    /// A cell whose split turns a tetrahedron or a triangle over, or leaves one flat.
    #[error(
        "the cell with the nodes {0} is bent so far, or its nodes are in such an order, that a tetrahedron or triangle of its split is flat or turned over: move its nodes, or mesh with tetrahedra or triangles"
    )]
    Folded(String),
    /// Nothing to solve on.
    #[error("no triangles, quadrangles, tetrahedra, hexahedra, wedges or pyramids")]
    NoCells,
    /// More vertices or elements than 32-bit indices reach.
    #[error("more than {0} vertices or elements")]
    TooLarge(u64),
}
