//! VTK XML files with raw appended data: the header names arrays by their byte
//! offset, the bytes follow it, little-endian, each with a 64-bit length.
//!
//! Raw appended data cost one copy of each array; ParaView, meshio and pyvista
//! read them.

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

/// A file under construction: XML text, and the data its arrays refer to.
pub(super) struct Writer {
    xml: String,
    data: Vec<u8>,
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
        }
    }

    /// Appends a line of XML.
    pub(super) fn line(&mut self, line: &str) {
        self.xml.push_str(line);
        self.xml.push('\n');
    }

    /// Appends an array of `components` values a row.
    pub(super) fn array<S: Scalar>(&mut self, name: &str, components: usize, values: &[S]) {
        let (kind, offset) = (S::TYPE, self.data.len());
        let name = escape(name);
        // Writing to a string cannot fail.
        let _infallible = writeln!(
            self.xml,
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" \
             format=\"appended\" offset=\"{offset}\"/>"
        );
        let bytes = size_of_val(values) as u64;
        self.data.extend_from_slice(&bytes.to_le_bytes());
        for value in values {
            value.put(&mut self.data);
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
