//! File formats: meshes of Gmsh, Abaqus and VTK, surfaces and grids of tools in, VTK files for
//! ParaView and surfaces out.
//!
//! Readers take bytes and never trust a count in them; writers produce bytes.
//! Neither opens a file. Work and memory are linear in the size of the data.

pub mod contact_patch;
pub mod derived;
pub mod grid;
pub mod inp;
pub mod leak_path;
pub mod mesh;
pub mod msh;
pub mod pvd;
pub mod reader;
pub mod stl;
pub mod values;
pub mod vtk;
pub mod vtp;
pub mod vtu;

mod vtk_xml;

pub use vtk_xml::Notes;
