//! VTK XML files with raw appended data: the header names arrays by their byte
//! offset, the bytes follow it, little-endian, each with a 64-bit length.
//!
//! Raw appended data cost one copy of each array; ParaView, meshio and pyvista
//! read them.

use std::collections::BTreeMap;
use std::fmt::Write as _;

/// A value that VTK can store.
pub(super) trait Scalar: Copy {
    const TYPE: &'static str;
    fn put(self, out: &mut Vec<u8>);
}

macro_rules! scalar {
    ($number:ty, $name:literal) => {
        impl Scalar for $number {
            const TYPE: &'static str = $name;

            fn put(self, out: &mut Vec<u8>) {
                out.extend_from_slice(&self.to_le_bytes());
            }
        }
    };
}

scalar!(f64, "Float64");
scalar!(i64, "Int64");
scalar!(u8, "UInt8");

/// What a file says about itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Notes {
    /// Time of the result, as field data: ParaView and pyvista show it.
    pub time: Option<f64>,
    /// Texts by name, as comments for people.
    pub texts: Vec<(String, String)>,
    /// What the units of arrays are called, by the names of the arrays: VTK keeps them as
    /// `vtkDataArray::UNITS_LABEL`.
    pub units: BTreeMap<String, String>,
}

/// A file under construction: XML text, and the data its arrays refer to.
pub(super) struct Writer {
    xml: String,
    data: Vec<u8>,
    units: BTreeMap<String, String>,
}

impl Writer {
    /// Opens a file of a VTK type such as `UnstructuredGrid`.
    pub(super) fn new(kind: &str) -> Self {
        let xml = format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"{kind}\" version=\"1.0\" \
             byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
        );
        Self {
            xml,
            data: Vec::new(),
            units: BTreeMap::new(),
        }
    }

    /// Appends a line of XML.
    pub(super) fn line(&mut self, line: &str) {
        self.xml.push_str(line);
        self.xml.push('\n');
    }

    /// Appends an array of `components` values a row.
    pub(super) fn array<S: Scalar>(&mut self, name: &str, components: usize, values: &[S]) {
        self.put(name, components, "", values);
    }

    /// Appends an array whose columns have names.
    pub(super) fn named_array<S: Scalar>(&mut self, name: &str, columns: &[&str], values: &[S]) {
        let mut attributes = String::new();
        for (index, column) in columns.iter().enumerate() {
            let column = escape(column);
            attributes.push_str(&format!(" ComponentName{index}=\"{column}\""));
        }
        self.put(name, columns.len(), &attributes, values);
    }

    /// Appends an array of which `attributes` say more.
    fn put<S: Scalar>(&mut self, name: &str, components: usize, attributes: &str, values: &[S]) {
        let (kind, offset) = (S::TYPE, self.data.len());
        let end = match self.units.get(name) {
            Some(unit) => format!(
                "><InformationKey name=\"UNITS_LABEL\" location=\"vtkDataArray\">{}\
                 </InformationKey></DataArray>",
                escape(unit)
            ),
            None => "/>".to_owned(),
        };
        let name = escape(name);
        // Writing to a string cannot fail.
        let _infallible = writeln!(
            self.xml,
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\"\
             {attributes} format=\"appended\" offset=\"{offset}\"{end}"
        );
        let bytes = size_of_val(values) as u64;
        self.data.extend_from_slice(&bytes.to_le_bytes());
        for value in values {
            value.put(&mut self.data);
        }
    }

    /// Appends what a file says about itself: the time as field data, texts as comments,
    /// for arrays of text are no numbers to meshio and others. Units go with the arrays that
    /// follow.
    pub(super) fn notes(&mut self, notes: &Notes) {
        self.units.clone_from(&notes.units);
        for (name, text) in &notes.texts {
            let comment = format!("{name}: {text}").replace("--", "- -");
            self.line(&format!("<!-- {} -->", escape(&comment)));
        }
        if let Some(time) = notes.time {
            self.line("<FieldData>");
            self.put("TimeValue", 1, " NumberOfTuples=\"1\"", &[time]);
            self.line("</FieldData>");
        }
    }

    /// The bytes of the file.
    pub(super) fn finish(mut self, kind: &str) -> Vec<u8> {
        self.line(&format!("</{kind}>"));
        self.xml.push_str("<AppendedData encoding=\"raw\">\n_");
        let mut bytes = self.xml.into_bytes();
        bytes.append(&mut self.data);
        bytes.extend_from_slice(b"\n</AppendedData>\n</VTKFile>\n");
        bytes
    }
}

/// Text that may stand inside an attribute.
pub(super) fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            other => escaped.push(other),
        }
    }
    escaped
}
