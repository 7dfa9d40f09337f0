//! Couplings of nodes as plain data: blocks of nodes and of pairs of nodes.
//!
//! Blocks are 3 x 3 in space and in the plane alike, in units of the smallest shear
//! modulus; the third row and column are zero in the plane.

/// A dense block, row-major.
pub type Block<const C: usize> = [[f64; C]; C];

/// Node blocks as they come from assembly, held components not yet eliminated.
#[derive(Clone, Copy, Debug)]
pub struct NodePairs<'a> {
    /// Diagonal block of each node `[nodes]`, padded to three components.
    pub diagonal: &'a [[[f64; 3]; 3]],
    /// Lower and upper node of each coupling, in lexicographic order.
    pub pairs: &'a [[u32; 2]],
    /// Block of each coupling: rows of the lower node, columns of the upper one.
    pub off: &'a [[[f64; 3]; 3]],
}
