//! Reads back the VTK XML files that this tool writes: raw appended arrays of known
//! types. Not for files of others; nothing in them is trusted all the same.

use std::collections::BTreeMap;

const MARK: &[u8] = b"<AppendedData encoding=\"raw\">\n_";

/// Arrays of a file by section and name.
#[derive(Debug, Default)]
pub(super) struct Arrays(BTreeMap<(String, String), Array>);

/// One array, its values as doubles.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Array {
    /// Values a row.
    pub(super) components: usize,
    /// Flat.
    pub(super) values: Vec<f64>,
}

impl Array {
    /// Rows.
    pub(super) fn rows(&self) -> usize {
        self.values.len() / self.components.max(1)
    }
}

impl Arrays {
    /// The array of a section, such as `Points` of `Points`.
    pub(super) fn get(&self, section: &str, name: &str) -> Option<&Array> {
        self.0.get(&(section.to_owned(), name.to_owned()))
    }

    /// The arrays of a section by name.
    pub(super) fn section<'a>(
        &'a self,
        section: &'a str,
    ) -> impl Iterator<Item = (&'a str, &'a Array)> {
        let all = self.0.iter();
        let own = all.filter(move |((of, _), _)| of == section);
        own.map(|((_, name), array)| (name.as_str(), array))
    }
}

/// The arrays of a file; none when it is not one of ours.
pub(super) fn read(bytes: &[u8]) -> Option<Arrays> {
    let start = bytes
        .windows(MARK.len())
        .position(|window| window == MARK)?;
    let header = std::str::from_utf8(bytes.get(..start)?).ok()?;
    let data = bytes.get(start + MARK.len()..)?;
    let mut arrays = Arrays::default();
    let mut section = "";
    for tag in header.split('<').skip(1) {
        let (name, attributes) = tag.split_once([' ', '>']).unwrap_or((tag, ""));
        match name {
            "DataArray" => {
                let (name, array) = array(attributes, data)?;
                arrays.0.insert((section.to_owned(), name), array);
            }
            // What an array's unit is called.
            "InformationKey" => {}
            _ if name.starts_with('/') => {}
            _ => section = name,
        }
    }
    Some(arrays)
}

fn array(attributes: &str, data: &[u8]) -> Option<(String, Array)> {
    let offset: usize = attribute(attributes, "offset")?.parse().ok()?;
    let components: usize = attribute(attributes, "NumberOfComponents")?.parse().ok()?;
    let length = u64::from_le_bytes(data.get(offset..)?.first_chunk()?.to_owned());
    let first = offset.checked_add(8)?;
    let end = first.checked_add(usize::try_from(length).ok()?)?;
    let block = data.get(first..end)?;
    let values = match attribute(attributes, "type")? {
        "Float64" => block
            .as_chunks()
            .0
            .iter()
            .map(|x| f64::from_le_bytes(*x))
            .collect(),
        "Int64" => {
            let whole = block.as_chunks().0.iter();
            whole.map(|x| i64::from_le_bytes(*x) as f64).collect()
        }
        "UInt8" => block.iter().map(|x| f64::from(*x)).collect(),
        _ => return None,
    };
    let array = Array { components, values };
    Some((attribute(attributes, "Name")?.to_owned(), array))
}

fn attribute<'a>(attributes: &'a str, name: &str) -> Option<&'a str> {
    let (_, rest) = attributes.split_once(&format!("{name}=\""))?;
    Some(rest.split_once('"')?.0)
}

/// The files of a series as (time, part, file).
pub(super) fn series(text: &str) -> Vec<(f64, usize, String)> {
    let tags = text.split("<DataSet ").skip(1);
    let entry = |tag: &str| {
        let time = attribute(tag, "timestep")?.parse().ok()?;
        let part = attribute(tag, "part")?.parse().ok()?;
        Some((time, part, attribute(tag, "file")?.to_owned()))
    };
    tags.filter_map(entry).collect()
}
