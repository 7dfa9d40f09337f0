//! Reads meshes of VTK files: unstructured grids in XML (`.vtu`) and in the legacy form
//! (`.vtk`), in text and binary, appended raw or in base64, compressed with zlib or not.
//!
//! | in the file | in the mesh |
//! |---|---|
//! | triangles and tetrahedra, of first and second order | cells, of the highest dimension |
//! | quadrangles, hexahedra, wedges and pyramids (pixels and voxels), of these orders | cells, split ([`super::mesh`]) |
//! | cells of one dimension less | facets |
//! | middle points of second-order cells | curved edges of the surface |
//! | an integer cell array `group`, `gmsh:physical` or `medit:ref` | the group of each cell and facet |
//! | field data of two integers, `NAME` = [number, dimension] | names of groups (as meshio keeps them) |
//!
//! A group without a name is named by its number. Where nothing says the groups of cells
//! they are the group `body`; where no facets have groups the whole surface is the group
//! `boundary`. Other arrays are left out, and files of several pieces refused.
//!
//! Cost: one pass over the text before appended data, one copy of each array that is read.

mod dataset;
mod encoding;
mod error;
mod legacy;
mod scalar;
mod xml;

#[cfg(test)]
mod tests;

use super::mesh::MeshFile;

pub use error::{Place, VtkError, VtkFault};

/// The values of the first of the arrays `names` of the cells of a file in XML.
///
/// # Errors
/// The first fault found, with its array.
pub fn cell_values(bytes: &[u8], names: &[&'static str]) -> Result<Vec<f64>, VtkError> {
    xml::cell_values(bytes, names)
}

/// Reads a mesh file.
///
/// # Errors
/// The first fault found, with its line, array or cell.
pub fn read(bytes: &[u8]) -> Result<MeshFile, VtkError> {
    let start = bytes
        .strip_prefix(b"\xef\xbb\xbf")
        .unwrap_or(bytes)
        .trim_ascii_start();
    let dataset = if start.starts_with(b"# vtk") {
        legacy::dataset(start)?
    } else if start.starts_with(b"<") {
        xml::dataset(start)?
    } else {
        return Err(VtkFault::NotVtk.whole());
    };
    dataset.mesh()
}
