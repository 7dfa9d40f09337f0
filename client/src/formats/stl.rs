//! Triangulated surfaces from STL files, text or binary.
//!
//! A file repeats the corners of every facet: those nearer than a tolerance, [`WELD`] of the diagonal
//! of their box unless the caller has one, are one vertex. A text of several solids is one surface of all of them. Whether the surface is closed and oriented is for the service to say.
//! Normals of the file are not read. Cost: one pass, some 100 bytes a facet.

mod text;
mod weld;

use std::borrow::Cow;
use std::io::Cursor;

/// Distance of corners that are one vertex, over the diagonal of the surface's box.
pub const WELD: f64 = 1e-6;
/// The largest that a caller may ask for: beyond it vertices of the tool itself go.
pub const MOST_WELD: f64 = 0.01;
/// Bytes of a binary file before its facets: header and count.
const BINARY_HEADER: usize = 84;
/// Bytes of a facet in a binary file.
const BINARY_FACET: usize = 50;

/// A surface of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceFile {
    /// Vertices `[vertices][3]`, welded.
    pub vertices: Vec<[f64; 3]>,
    /// Corners of the facets, in the order of the file.
    pub facets: Vec<[u32; 3]>,
}

/// Why a file is no surface.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum StlError {
    /// The reader's words.
    #[error("facet {facet}: {said}")]
    Unreadable {
        /// Facet that could not be read, from 0.
        facet: usize,
        /// What is wrong.
        said: String,
    },
    /// Fewer facets than the file announces.
    #[error("{there} facets where {announced} are announced: the file is cut")]
    Cut {
        /// Facets that are there.
        there: usize,
        /// Facets of the header.
        announced: usize,
    },
    /// A corner that is NaN or infinite.
    #[error("facet {facet} has a corner that is not finite")]
    NotFinite {
        /// The facet.
        facet: usize,
    },
    /// No facet at all.
    #[error("has no facets; an STL file begins with `solid`, or is binary")]
    Empty,
}

/// The text of a file with a surface, all digits of its vertices: it is read as the same surface,
/// vertices in the order in which facets name them. Corners beyond the vertices are left out.
pub fn write(surface: &SurfaceFile) -> String {
    let corner = |corner: &u32| surface.vertices.get(*corner as usize).copied();
    let facets = surface.facets.iter().filter_map(|[a, b, c]| {
        let corners = [corner(a)?, corner(b)?, corner(c)?];
        Some(corners)
    });
    text::write(facets)
}

/// Reads a file.
///
/// # Errors
/// [`StlError`] with the facet.
pub fn read(bytes: &[u8]) -> Result<SurfaceFile, StlError> {
    read_within(bytes, WELD)
}

/// Reads a file whose corners are one vertex up to `weld` of the diagonal of their box, from 0 to
/// [`MOST_WELD`].
///
/// # Errors
/// [`StlError`] with the facet.
pub fn read_within(bytes: &[u8], weld: f64) -> Result<SurfaceFile, StlError> {
    let corners = match text_of(bytes) {
        Some(text) => text::corners(&text)?,
        None => binary(bytes)?,
    };
    let finite = |facet: &[[f64; 3]; 3]| facet.as_flattened().iter().all(|x| x.is_finite());
    if let Some(facet) = corners.iter().position(|facet| !finite(facet)) {
        return Err(StlError::NotFinite { facet });
    }
    if corners.is_empty() {
        Err(StlError::Empty)
    } else {
        Ok(weld::weld(&corners, weld.clamp(0.0, MOST_WELD)))
    }
}

/// The file as text, where it is one: binary files may begin with `solid`, too, but have zeros
/// where a text has words. Names may be in any encoding.
fn text_of(bytes: &[u8]) -> Option<Cow<'_, str>> {
    let start = bytes.trim_ascii_start().get(..5)?;
    let is_text = start.eq_ignore_ascii_case(b"solid") && !bytes.contains(&0);
    is_text.then(|| String::from_utf8_lossy(bytes))
}

fn binary(bytes: &[u8]) -> Result<Vec<[[f64; 3]; 3]>, StlError> {
    check_length(bytes)?;
    let unreadable = |facet: usize| {
        move |error: std::io::Error| StlError::Unreadable {
            facet,
            said: error.to_string(),
        }
    };
    // The library tells a text by its first word, which a binary header may have.
    let mut header_blank = bytes.to_vec();
    header_blank
        .iter_mut()
        .take(5)
        .for_each(|byte| *byte = b' ');
    let mut cursor = Cursor::new(header_blank);
    let reader = stl_io::create_stl_reader(&mut cursor).map_err(unreadable(0))?;
    let mut corners = Vec::new();
    for (facet, triangle) in reader.enumerate() {
        let triangle = triangle.map_err(unreadable(facet))?;
        corners.push(triangle.vertices.map(|vertex| vertex.0.map(f64::from)));
    }
    Ok(corners)
}

/// A binary file says how many facets it has.
fn check_length(bytes: &[u8]) -> Result<(), StlError> {
    let Some(count) = bytes.get(BINARY_HEADER - 4..BINARY_HEADER) else {
        return Err(StlError::Empty);
    };
    let count = count.try_into().map_or(0, u32::from_le_bytes);
    let there = (bytes.len() - BINARY_HEADER) / BINARY_FACET;
    let announced = count as usize;
    if announced <= there {
        Ok(())
    } else {
        Err(StlError::Cut { there, announced })
    }
}

fn pick(a: [f64; 3], b: [f64; 3], of: impl Fn(f64, f64) -> f64) -> [f64; 3] {
    let [x, y, z] = a;
    let [u, v, w] = b;
    [of(x, u), of(y, v), of(z, w)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tetrahedron as text.
    fn text() -> String {
        let corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]];
        let facets = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
        let mut text = "solid block\n".to_owned();
        for facet in facets {
            text += "facet normal 0 0 0\nouter loop\n";
            for corner in facet {
                let [x, y, z]: [i32; 3] = corners[corner];
                text += &format!("vertex {x} {y} {z}.0000001\n");
            }
            text += "endloop\nendfacet\n";
        }
        text + "endsolid block\n"
    }

    /// The same as bytes.
    fn binary() -> Vec<u8> {
        let read = read(text().as_bytes()).unwrap();
        let mut bytes = vec![0; 80];
        bytes.extend((read.facets.len() as u32).to_le_bytes());
        for facet in &read.facets {
            bytes.extend([0; 12]);
            for corner in facet {
                for x in read.vertices[*corner as usize] {
                    bytes.extend((x as f32).to_le_bytes());
                }
            }
            bytes.extend([0; 2]);
        }
        bytes
    }

    #[test]
    fn text_and_bytes_are_read_and_corners_welded() {
        let surface = read(text().as_bytes()).unwrap();
        assert_eq!(surface.facets.len(), 4);
        assert_eq!(surface.vertices.len(), 4);
        let of_bytes = read(&binary()).unwrap();
        assert_eq!(of_bytes.facets, surface.facets);
        // Bytes have seven digits.
        let both = of_bytes.vertices.iter().zip(&surface.vertices);
        for (a, b) in both {
            assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-7));
        }
    }

    #[test]
    fn corners_that_differ_by_the_rounding_of_a_program_are_one_within_a_tolerance_that_is_named() {
        // Every facet has rounded its corners for itself.
        let mut surface = read(text().as_bytes()).unwrap();
        let corners = surface.facets.as_flattened().iter().enumerate();
        let rounded = corners.map(|(index, corner)| {
            let off = 1e-5 * ((index * 7 % 5) as f64 - 2.0);
            surface.vertices[*corner as usize].map(|x| x + off)
        });
        surface.vertices = rounded.collect();
        surface.facets = (0..4)
            .map(|facet| [0, 1, 2].map(|k| 3 * facet + k))
            .collect();
        let file = write(&surface);
        let count = |weld: f64| read_within(file.as_bytes(), weld).unwrap().vertices.len();
        assert!(count(WELD) > 4 && read(file.as_bytes()).unwrap().vertices.len() == count(WELD));
        assert_eq!((count(1e-4), count(MOST_WELD), count(1.0)), (4, 4, 4));
        assert!(count(0.0) == count(f64::MIN_POSITIVE) && count(0.0) >= count(WELD));
    }

    #[test]
    fn what_is_written_is_read_as_the_same_surface() {
        let mut surface = read(text().as_bytes()).unwrap();
        for x in surface.vertices.as_flattened_mut() {
            *x = (*x - 0.3) / 7.0;
        }
        let written = write(&surface);
        assert_eq!(read(written.as_bytes()).unwrap(), surface);
        assert!(
            written.contains("facet normal 0.000000 0.000000 -1.000000"),
            "{written}"
        );
    }

    #[test]
    fn all_solids_of_a_text_are_read_with_or_without_a_name() {
        let one = text();
        let two = one.replace("vertex ", "vertex 5") + &one.to_uppercase();
        let surface = read(two.as_bytes()).unwrap();
        assert_eq!((surface.facets.len(), surface.vertices.len()), (8, 8));
        let nameless = format!("\r\n  {}", one.replace("solid block", "solid"));
        assert_eq!(read(nameless.as_bytes()).unwrap().facets.len(), 4);
    }

    #[test]
    fn a_binary_file_may_begin_like_a_text() {
        let mut bytes = binary();
        bytes[..10].copy_from_slice(b"solid part");
        assert_eq!(read(&bytes).unwrap().facets.len(), 4);
    }

    #[test]
    fn a_text_that_goes_wrong_names_its_facet_and_line() {
        let broken = text().replacen("endfacet", "facet", 2);
        let message = read(broken.as_bytes()).unwrap_err().to_string();
        assert!(message.contains("facet 0: line 8"), "{message}");
        let cut = &text()[..200];
        assert!(read(cut.as_bytes()).is_err());
    }

    #[test]
    fn a_cut_file_and_one_of_something_else_are_refused() {
        let bytes = binary();
        let cut = read(&bytes[..bytes.len() - 60]).unwrap_err();
        assert_eq!(
            cut,
            StlError::Cut {
                there: 2,
                announced: 4
            }
        );
        assert!(read(b"").is_err());
        assert!(read(b"solid nothing\nendsolid nothing\n").is_err());
        let broken = text().replace("vertex 0 1 0", "vertex 0 nan 0");
        assert!(read(broken.as_bytes()).is_err());
    }

    #[test]
    fn thirty_thousand_broken_files_are_read_or_refused() {
        let mut rng = fastrand::Rng::with_seed(18);
        let seeds = [text().into_bytes(), binary()];
        let (mut good, mut bad) = (0, 0);
        for round in 0..30_000 {
            let mut bytes = seeds[round % 2].clone();
            for _ in 0..rng.usize(1..6) {
                let place = rng.usize(..bytes.len());
                match rng.u8(..4) {
                    0 => bytes[place] = rng.u8(..),
                    1 => bytes.truncate(place.max(1)),
                    2 => bytes.insert(place, rng.u8(..)),
                    _ => drop(bytes.remove(place)),
                }
                if bytes.is_empty() {
                    bytes.push(b's');
                }
            }
            match read(&bytes) {
                Ok(_) => good += 1,
                Err(_) => bad += 1,
            }
        }
        assert!(good > 100 && bad > 100, "{good} {bad}");
    }
}
