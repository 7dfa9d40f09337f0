//! File formats: Gmsh meshes in, VTK files for ParaView out.
//!
//! Readers take bytes and never trust a count in them; writers produce bytes.
//! Neither opens a file. Work and memory are linear in the size of the data.

pub mod msh;
pub mod pvd;
pub mod vtp;
pub mod vtu;

mod vtk_xml;
