//! XML files (`.vtu`): the tree of elements, and the data of its arrays in text, base64
//! or bytes after the tree.
//!
//! The text before the appended data is parsed by `roxmltree`; appended bytes are no text.

use roxmltree::{Document, Node, ParsingOptions};

use super::dataset::{Dataset, GROUP_ARRAYS, GroupName};
use super::encoding::{Compression, Packing, base64};
use super::error::{VtkError, VtkFault};
use super::scalar::{ByteOrder, Scalar};

/// Elements of a tree: a file has some dozens.
const MOST_NODES: u32 = 100_000;
const APPENDED: &[u8] = b"<AppendedData";

/// The data set of a file.
pub(super) fn dataset(bytes: &[u8]) -> Result<Dataset, VtkError> {
    open(bytes, |file, root| file.dataset(root))
}

/// The values of the first of some arrays of the cells.
pub(super) fn cell_values(bytes: &[u8], names: &[&'static str]) -> Result<Vec<f64>, VtkError> {
    open(bytes, |file, root| {
        let section = child(&piece(root)?, "CellData")?;
        let missing = || VtkFault::Missing("the array").in_array(&names.join(" or "));
        let mut arrays = names.iter().filter_map(|name| array(&section, name).ok());
        file.reals(&arrays.next().ok_or_else(missing)?)
    })
}

/// What `read` makes of a file and the root of its tree.
fn open<T>(
    bytes: &[u8],
    read: impl FnOnce(&File<'_>, &Node<'_, '_>) -> Result<T, VtkError>,
) -> Result<T, VtkError> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let found = bytes
        .windows(APPENDED.len())
        .position(|window| window == APPENDED);
    let (tree, rest) = match found {
        Some(at) => bytes.split_at_checked(at).unwrap_or((bytes, &[])),
        None => (bytes, &[][..]),
    };
    let xml = |text: String| VtkFault::Xml(text).whole();
    let tree = std::str::from_utf8(tree).map_err(|error| xml(error.to_string()))?;
    let closed = match found {
        Some(_) => format!("{tree}</VTKFile>"),
        None => tree.to_owned(),
    };
    let options = ParsingOptions {
        nodes_limit: MOST_NODES,
        ..ParsingOptions::default()
    };
    let document = Document::parse_with_options(&closed, options);
    let document = document.map_err(|error| xml(error.to_string()))?;
    let file = File {
        packing: packing(&document.root_element(), bytes.len())?,
        appended: Appended::of(rest)?,
    };
    read(&file, &document.root_element())
}

fn packing(root: &Node<'_, '_>, file_bytes: usize) -> Result<Packing, VtkError> {
    let unsupported = |what: String| Err(VtkFault::Unsupported(what).whole());
    match root.attribute("type") {
        Some("UnstructuredGrid") => {}
        other => {
            let kind = other.unwrap_or("no type");
            return unsupported(format!("{kind}: an UnstructuredGrid is expected"));
        }
    }
    let compression = match root.attribute("compressor") {
        None | Some("") => Compression::None,
        Some("vtkZLibDataCompressor") => Compression::Zlib,
        Some(other) => return unsupported(format!("compression by {other}: write it with zlib")),
    };
    Ok(Packing {
        order: match root.attribute("byte_order") {
            Some("BigEndian") => ByteOrder::Big,
            _ => ByteOrder::Little,
        },
        header_bytes: match root.attribute("header_type") {
            Some("UInt64") => 8,
            _ => 4,
        },
        compression,
        file_bytes,
    })
}

/// Data after the tree.
enum Appended<'a> {
    Raw(&'a [u8]),
    Base64(&'a [u8]),
}

impl<'a> Appended<'a> {
    fn of(bytes: &'a [u8]) -> Result<Self, VtkError> {
        if bytes.is_empty() {
            return Ok(Self::Raw(&[]));
        }
        let missing = || VtkFault::Missing("the mark _ before the appended data").whole();
        let end = bytes
            .iter()
            .position(|byte| *byte == b'>')
            .ok_or_else(missing)?;
        let (tag, rest) = bytes.split_at_checked(end + 1).ok_or_else(missing)?;
        let data = rest
            .trim_ascii_start()
            .strip_prefix(b"_")
            .ok_or_else(missing)?;
        if tag.windows(6).any(|word| word == b"base64") {
            let end = data.iter().position(|byte| *byte == b'<');
            return Ok(Self::Base64(
                data.get(..end.unwrap_or(data.len())).unwrap_or_default(),
            ));
        }
        Ok(Self::Raw(data))
    }
}

struct File<'a> {
    packing: Packing,
    appended: Appended<'a>,
}

/// Children of a name.
fn children<'a, 'b>(node: &Node<'a, 'b>, name: &'static str) -> impl Iterator<Item = Node<'a, 'b>> {
    node.children()
        .filter(move |child| child.has_tag_name(name))
}

fn child<'a, 'b>(node: &Node<'a, 'b>, name: &'static str) -> Result<Node<'a, 'b>, VtkError> {
    let found = children(node, name).next();
    found.ok_or_else(|| VtkFault::Missing(name).whole())
}

/// The array of a name in a section.
fn array<'a, 'b>(section: &Node<'a, 'b>, name: &'static str) -> Result<Node<'a, 'b>, VtkError> {
    let mut arrays = children(section, "DataArray");
    let found = arrays.find(|array| array.attribute("Name") == Some(name));
    found.ok_or_else(|| VtkFault::Missing("the array").in_array(name))
}

/// The one piece of a file.
fn piece<'a, 'b>(root: &Node<'a, 'b>) -> Result<Node<'a, 'b>, VtkError> {
    let grid = child(root, "UnstructuredGrid")?;
    let filled = |piece: &Node<'_, '_>| piece.attribute("NumberOfCells") != Some("0");
    let mut pieces = children(&grid, "Piece").filter(filled);
    let piece = pieces
        .next()
        .ok_or_else(|| VtkFault::Missing("Piece").whole())?;
    if pieces.next().is_some() {
        let what = "several pieces: merge them into one".to_owned();
        return Err(VtkFault::Unsupported(what).whole());
    }
    Ok(piece)
}

impl File<'_> {
    fn dataset(&self, root: &Node<'_, '_>) -> Result<Dataset, VtkError> {
        let grid = child(root, "UnstructuredGrid")?;
        let piece = piece(root)?;
        let points = child(&child(&piece, "Points")?, "DataArray")?;
        let cells = child(&piece, "Cells")?;
        let mut dataset = Dataset {
            points: self.reals(&points)?,
            connectivity: self.integers(&array(&cells, "connectivity")?)?,
            ends: self.integers(&array(&cells, "offsets")?)?,
            types: self.integers(&array(&cells, "types")?)?,
            ..Dataset::default()
        };
        self.groups(&piece, &mut dataset)?;
        self.names(&grid, &mut dataset)?;
        Ok(dataset)
    }

    fn groups(&self, piece: &Node<'_, '_>, dataset: &mut Dataset) -> Result<(), VtkError> {
        let Some(section) = children(piece, "CellData").next() else {
            return Ok(());
        };
        for name in GROUP_ARRAYS {
            let Ok(array) = array(&section, name) else {
                continue;
            };
            if !scalar(&array)?.is_integer() {
                dataset.warn_of_reals(name);
                continue;
            }
            dataset.groups = Some((name, self.integers(&array)?));
            return Ok(());
        }
        Ok(())
    }

    /// Field data of two integers, number and dimension, name groups.
    fn names(&self, grid: &Node<'_, '_>, dataset: &mut Dataset) -> Result<(), VtkError> {
        let Some(section) = children(grid, "FieldData").next() else {
            return Ok(());
        };
        for array in children(&section, "DataArray") {
            let is_pair = matches!(
                (
                    array.attribute("NumberOfTuples"),
                    array.attribute("NumberOfComponents")
                ),
                (Some("2"), None | Some("1")) | (Some("1"), Some("2"))
            );
            let (Some(name), true) = (array.attribute("Name"), is_pair) else {
                continue;
            };
            if !scalar(&array)?.is_integer() {
                continue;
            }
            if let &[number, dimension] = self.integers(&array)?.as_slice() {
                dataset.names.push(GroupName {
                    name: name.to_owned(),
                    number,
                    dimension,
                });
            }
        }
        Ok(())
    }

    fn integers(&self, array: &Node<'_, '_>) -> Result<Vec<i64>, VtkError> {
        let scalar = scalar(array)?;
        match array.attribute("format") {
            Some("binary" | "appended") => {
                Ok(scalar.integers(&self.bytes(array)?, self.packing.order))
            }
            _ => text_values(array, "a whole number"),
        }
    }

    fn reals(&self, array: &Node<'_, '_>) -> Result<Vec<f64>, VtkError> {
        let scalar = scalar(array)?;
        match array.attribute("format") {
            Some("binary" | "appended") => {
                Ok(scalar.reals(&self.bytes(array)?, self.packing.order))
            }
            _ => text_values(array, "a number"),
        }
    }

    fn bytes(&self, array: &Node<'_, '_>) -> Result<Vec<u8>, VtkError> {
        let unpacked = match array.attribute("format") {
            Some("appended") => self.appended_bytes(array),
            _ => self.decoded(text(array).as_bytes()),
        };
        unpacked.map_err(|fault| fault.in_array(name(array)))
    }

    fn appended_bytes(&self, array: &Node<'_, '_>) -> Result<Vec<u8>, VtkFault> {
        let offset = array
            .attribute("offset")
            .and_then(|offset| offset.parse().ok());
        let offset: usize = offset.ok_or(VtkFault::Missing("the offset"))?;
        let beyond = VtkFault::Count {
            declared: offset as u64,
        };
        match self.appended {
            Appended::Raw(data) => self.packing.unpack(data.get(offset..).ok_or(beyond)?),
            Appended::Base64(text) => {
                let text = text.get(offset..).ok_or(beyond)?;
                let next = self.next_offset(array, offset).unwrap_or(usize::MAX);
                let length = (next - offset).min(text.len());
                self.decoded(text.get(..length).unwrap_or_default())
            }
        }
    }

    /// Where the next array of the file begins.
    fn next_offset(&self, array: &Node<'_, '_>, offset: usize) -> Option<usize> {
        let all = array.document().descendants();
        let offsets = all.filter_map(|node| node.attribute("offset")?.parse::<usize>().ok());
        offsets.filter(|next| *next > offset).min()
    }

    /// Base64; compressed data have a header of their own.
    fn decoded(&self, text: &[u8]) -> Result<Vec<u8>, VtkFault> {
        self.packing.unpack(&base64(text)?)
    }
}

fn name<'a>(array: &Node<'a, '_>) -> &'a str {
    array.attribute("Name").unwrap_or("Points")
}

fn scalar(array: &Node<'_, '_>) -> Result<Scalar, VtkError> {
    let kind = array.attribute("type").unwrap_or("no type");
    Scalar::of(kind).ok_or_else(|| {
        let what = format!("values of type {kind}");
        VtkFault::Unsupported(what).in_array(name(array))
    })
}

/// The text of an array, which may have elements beside it.
fn text<'a>(array: &Node<'a, '_>) -> &'a str {
    let texts = array
        .children()
        .filter_map(|child| child.text().filter(|_| child.is_text()));
    let mut filled = texts.filter(|text| !text.trim().is_empty());
    filled.next().unwrap_or_default()
}

fn text_values<T: std::str::FromStr>(
    array: &Node<'_, '_>,
    expected: &'static str,
) -> Result<Vec<T>, VtkError> {
    let words = text(array).split_ascii_whitespace();
    let values = words.map(|word| {
        word.parse().map_err(|_| {
            let found = format!("\"{}\"", word.chars().take(24).collect::<String>());
            VtkFault::Unexpected { expected, found }.in_array(name(array))
        })
    });
    values.collect()
}
