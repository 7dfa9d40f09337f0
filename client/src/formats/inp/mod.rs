//! Reads meshes of Abaqus input files (`.inp`), as Abaqus, Gmsh, CalculiX and most
//! preprocessors write them.
//!
//! | in the file | in the mesh |
//! |---|---|
//! | `*NODE` | vertices, in the order of their numbers; middle nodes give the curved edges |
//! | `*ELEMENT` C3D4, C3D10; CPE3, CPE6, CAX3, CAX6 (CPS3, CPS6), with suffixes H, M, ... | cells |
//! | hexahedra, wedges, pyramids (C3D8, C3D20, C3D6, C3D15, C3D5, C3D13), quadrangles (CPE4, CAX8, ...) | cells, split ([`super::mesh`]) |
//! | `*ELEMENT` of shells, membranes, beams and trusses | facets of the groups of their sets |
//! | `*ELSET`, `ELSET=` | groups of cells |
//! | `MATERIAL=` of `*SOLID SECTION` | groups of cells |
//! | `*SURFACE` of faces (S1 to S6, or none for all outer ones) | groups of facets |
//! | `*NSET`, `NSET=`, `*SURFACE, TYPE=NODE` | groups of the facets of the surface whose corners are all in the set |
//! | `*PART`, `*INSTANCE` | a copy of the part for each instance, moved and turned; names that several have become `INSTANCE.NAME` |
//! | `*SYSTEM`, `*NODE, SYSTEM=C` | local and cylindrical coordinates of nodes |
//! | springs, masses, dashpots, connectors; beams and trusses beside solids; shells and rigid elements that are no faces of cells | left out with a warning |
//! | `*MPC`, `*EQUATION`, `*COUPLING` | not read, with a warning |
//! | `*INCLUDE`, `INPUT=` | the file beside the deck ([`read_with`]) |
//!
//! Where nothing names cells they are the group `body`, and where nothing names facets the
//! whole surface is the group `boundary`. Sets marked `INTERNAL` are no groups. Everything
//! else is left out: the scene says materials, supports and loads. Files have no units.
//! Ties are left out with a warning: the bodies stay separate. Files that make nodes or elements
//! (`*NGEN`, `*ELGEN`, ...) are refused.
//!
//! Cost: one pass, one sort of the element numbers, and one of the outer facets where
//! sets of nodes or no surface are in the file. Memory is bounded by a multiple of the
//! size of the file, whatever its sets declare.

mod assembly;
mod build;
mod cards;
mod deck;
mod element;
mod error;
mod fields;
mod frame;
mod gather;
mod include;
mod keywords;
mod members;
mod node_sets;
mod reader;
pub mod scene;
mod sets;

#[cfg(test)]
mod tests;
#[cfg(test)]
mod tests_of_assemblies;
#[cfg(test)]
mod tests_of_features;

use super::mesh::{MeshFault, MeshFile};
use include::Expanded;
use reader::Includes;
use scene::DeckScene;

pub use error::{InpError, InpFault};
pub use include::ReadBeside;
pub use keywords::OF_THE_FILE;

/// Reads a mesh file that includes no other.
///
/// # Errors
/// The first fault found, with its keyword and line, or with the number of its element.
pub fn read(bytes: &[u8]) -> Result<MeshFile, InpError> {
    mesh(bytes, Includes::Refused)
}

/// Reads a mesh file with the files that it includes, which `beside` reads by their paths below
/// the folder of the deck.
///
/// # Errors
/// As [`read`], with the file of the line; and a file that cannot be included.
pub fn read_with(bytes: &[u8], beside: &mut ReadBeside<'_>) -> Result<MeshFile, InpError> {
    let names_files = bytes
        .windows(5)
        .any(|word| word.eq_ignore_ascii_case(b"INPUT"));
    if !names_files {
        return read(bytes);
    }
    let expanded = Expanded::of(bytes, beside)?;
    mesh(&expanded.bytes, Includes::Expanded).map_err(|error| expanded.located(error))
}

/// Reads what a deck says beside its mesh, with the files that it includes.
///
/// # Errors
/// As [`read_with`], for what is read here.
pub fn read_scene(bytes: &[u8], beside: &mut ReadBeside<'_>) -> Result<DeckScene, InpError> {
    let expanded = Expanded::of(bytes, beside)?;
    scene::scene(&expanded.bytes).map_err(|error| expanded.located(error))
}

fn mesh(bytes: &[u8], includes: Includes) -> Result<MeshFile, InpError> {
    let deck = reader::deck(bytes, includes)?;
    // Real files name an element in a handful of sets.
    build::mesh(deck, 4 * bytes.len())
}
