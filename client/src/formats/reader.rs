//! The choice of the reader of a mesh file: by its content first, then by the extension of its
//! name.
//!
//! | format | content | extension |
//! |---|---|---|
//! | Gmsh ([`super::msh`]) | `$MeshFormat`, or `$Comments` before it | `.msh` |
//! | VTK ([`super::vtk`]) | `# vtk DataFile`, or XML with `<VTKFile` | `.vtk`, `.vtu` |
//! | Abaqus ([`super::inp`]) | a first line `*KEYWORD` or `** comment` | `.inp` |
//!
//! Cost: as the readers; the choice looks at the first kibibyte.

use std::path::Path;

use super::inp::{self, InpError, ReadBeside};
use super::mesh::MeshFile;
use super::msh::{self, MshError};
use super::vtk::{self, VtkError};

/// Bytes that the choice of a reader looks at.
const HEAD: usize = 1024;

/// Why a file gives no mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// A Gmsh file with a fault.
    #[error(transparent)]
    Msh(#[from] MshError),
    /// An Abaqus file with a fault.
    #[error(transparent)]
    Inp(#[from] InpError),
    /// A VTK file with a fault.
    #[error(transparent)]
    Vtk(#[from] VtkError),
    /// No format that is read here.
    #[error(
        "not a mesh that is read here: Gmsh (.msh), Abaqus (.inp) and VTK (.vtu, .vtk) are; others can be converted with `gmsh IN -0 -format msh41 -o OUT.msh` or `meshio convert IN OUT.vtu`"
    )]
    UnknownFormat,
}

/// Formats that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Gmsh MSH.
    Msh,
    /// Abaqus input.
    Inp,
    /// VTK, legacy or XML.
    Vtk,
}

impl Format {
    /// The format of some bytes; where they do not tell, that of the name of their file.
    pub fn of(bytes: &[u8], path: &Path) -> Option<Self> {
        Self::of_content(bytes).or_else(|| Self::of_extension(path))
    }

    fn of_content(bytes: &[u8]) -> Option<Self> {
        let head = bytes.get(..HEAD).unwrap_or(bytes).trim_ascii_start();
        let head = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head);
        if head.starts_with(b"$MeshFormat") || head.starts_with(b"$Comments") {
            return Some(Self::Msh);
        }
        let has_root = || head.windows(8).any(|word| word == b"<VTKFile");
        if head.starts_with(b"# vtk") || (head.starts_with(b"<") && has_root()) {
            return Some(Self::Vtk);
        }
        let keyword = |byte: &u8| byte.is_ascii_alphabetic() || *byte == b'*';
        match head {
            [b'*', next, ..] if keyword(next) => Some(Self::Inp),
            _ => None,
        }
    }

    fn of_extension(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "msh" => Some(Self::Msh),
            "inp" => Some(Self::Inp),
            "vtk" | "vtu" => Some(Self::Vtk),
            _ => None,
        }
    }
}

/// Judges a file by its first bytes, before the rest is read.
///
/// # Errors
/// [`ReadError`] for one that no reader takes.
pub fn check_head(head: &[u8], path: &Path) -> Result<(), ReadError> {
    let head = head.get(..HEAD).unwrap_or(head);
    let format = Format::of(head, path).ok_or(ReadError::UnknownFormat)?;
    let text = head.trim_ascii_start();
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
    let begins = match (format, text.first()) {
        (Format::Msh, Some(b'$')) | (Format::Inp, Some(b'*')) => true,
        (Format::Vtk, Some(b'#' | b'<')) => true,
        // An empty file is short enough for its reader.
        (_, first) => first.is_none() && head.len() < HEAD,
    };
    if begins {
        return Ok(());
    }
    // What its reader says to the first line.
    read(head, path, &mut |_| Ok(Vec::new())).map(drop)
}

/// Reads a mesh in any of the formats; `path` is the name of its file, and `beside` reads the
/// files that it includes by their paths below the folder of it.
///
/// # Errors
/// [`ReadError`]: the first fault that its reader finds.
pub fn read(bytes: &[u8], path: &Path, beside: &mut ReadBeside<'_>) -> Result<MeshFile, ReadError> {
    match Format::of(bytes, path).ok_or(ReadError::UnknownFormat)? {
        Format::Msh => Ok(msh::read(bytes)?),
        Format::Inp => Ok(inp::read_with(bytes, beside)?),
        Format::Vtk => Ok(vtk::read(bytes)?),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(bytes: &[u8], path: &str) -> Option<Format> {
        Format::of(bytes, Path::new(path))
    }

    #[test]
    fn content_tells_the_format_before_the_name_does() {
        assert_eq!(of(b"$MeshFormat\n4.1", "part.inp"), Some(Format::Msh));
        assert_eq!(of(b"$Comments\nby hand\n", "part"), Some(Format::Msh));
        assert_eq!(of(b"** made by X\n*NODE", "part.msh"), Some(Format::Inp));
        assert_eq!(of(b"\n*Heading\n", "part"), Some(Format::Inp));
        assert_eq!(of(b"# vtk DataFile Version 2.0", "a"), Some(Format::Vtk));
        let xml = b"\xef\xbb\xbf<?xml version=\"1.0\"?>\n<VTKFile type=";
        assert_eq!(of(xml, "a"), Some(Format::Vtk));
        assert_eq!(of(b"solid", "part.VTU"), Some(Format::Vtk));
        assert_eq!(of(b"solid", "part.stl"), None);
        assert_eq!(of(b"", "part"), None);
    }

    #[test]
    fn the_first_bytes_tell_what_is_no_mesh() {
        let zeros = vec![0; HEAD];
        for (path, head) in [
            ("part.msh", &zeros[..]),
            ("part.msh", b"solid part\n facet normal"),
            ("part.vtu", b"PK\x03\x04"),
            ("part.inp", b"hello\nworld\n"),
            ("part", b"hello"),
            ("part.step", b"ISO-10303-21;"),
        ] {
            assert!(check_head(head, Path::new(path)).is_err(), "{path}");
        }
        for (path, head) in [
            ("part.msh", &b"$MeshFormat\n4.1 0 8\n"[..]),
            ("part.msh", b"\n$PhysicalNames\n"),
            ("part", b"** made by X\n"),
            ("part.vtk", b"# vtk DataFile Version 2.0\n"),
        ] {
            assert_eq!(check_head(head, Path::new(path)), Ok(()), "{path}");
        }
    }

    #[test]
    fn an_unknown_format_is_answered_with_the_known_ones() {
        let error = read(b"solid", Path::new("part.stl"), &mut |_| Ok(Vec::new())).unwrap_err();
        assert!(error.to_string().contains(".inp"), "{error}");
    }
}
