//! Legacy files (`.vtk`): keywords and numbers as text, or numbers as big-endian bytes.
//!
//! Reads unstructured grids of the versions 1 to 5. No allocation is larger than the rest
//! of the file can fill, whatever it declares.

use super::dataset::{Dataset, GROUP_ARRAYS, GroupName};
use super::error::{Place, VtkError, VtkFault};
use super::scalar::{ByteOrder, Scalar};

#[derive(Clone, Copy, PartialEq, Eq)]
enum Encoding {
    Text,
    Binary,
}

/// Whose attributes follow.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Owner {
    File,
    Points,
    Cells,
}

/// A position in a file.
struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    encoding: Encoding,
}

/// The data set of a file.
pub(super) fn dataset(bytes: &[u8]) -> Result<Dataset, VtkError> {
    let mut cursor = Cursor {
        bytes,
        at: 0,
        encoding: Encoding::Text,
    };
    cursor.line();
    cursor.line();
    let encoding = cursor.word("ASCII or BINARY")?;
    cursor.encoding = match encoding.as_str() {
        "ASCII" => Encoding::Text,
        "BINARY" => Encoding::Binary,
        _ => return Err(cursor.unexpected("ASCII or BINARY", &encoding)),
    };
    let mut reader = Reader {
        cursor,
        dataset: Dataset::default(),
        owner: Owner::File,
        rows: 0,
    };
    while let Some(keyword) = reader.cursor.keyword() {
        reader.take(&keyword)?;
    }
    reader.finish()
}

impl<'a> Cursor<'a> {
    fn rest(&self) -> &'a [u8] {
        self.bytes.get(self.at..).unwrap_or_default()
    }

    fn error(&self, fault: VtkFault) -> VtkError {
        let before = self.bytes.get(..self.at).unwrap_or(self.bytes);
        let lines = before.iter().filter(|byte| **byte == b'\n').count();
        fault.at(Place::Line(1 + lines))
    }

    fn unexpected(&self, expected: &'static str, found: &str) -> VtkError {
        let found: String = found.chars().take(24).collect();
        let found = format!("\"{}\"", found.escape_debug());
        self.error(VtkFault::Unexpected { expected, found })
    }

    /// The rest of the line, the cursor after it.
    fn line(&mut self) -> &'a [u8] {
        let rest = self.rest();
        let length = rest.iter().position(|byte| *byte == b'\n');
        let length = length.unwrap_or(rest.len());
        self.at += (length + 1).min(rest.len());
        rest.get(..length).unwrap_or_default()
    }

    /// The next run of characters without blanks; empty at the end of the file.
    fn token(&mut self) -> &'a [u8] {
        let blank = |byte: &&u8| byte.is_ascii_whitespace();
        self.at += self.rest().iter().take_while(blank).count();
        let rest = self.rest();
        let length = rest.iter().take_while(|byte| !blank(byte)).count();
        self.at += length;
        rest.get(..length).unwrap_or_default()
    }

    fn word(&mut self, expected: &'static str) -> Result<String, VtkError> {
        match self.token() {
            [] => Err(self.error(VtkFault::Truncated(expected))),
            token => Ok(String::from_utf8_lossy(token).into_owned()),
        }
    }

    /// A keyword in capitals; none at the end of the file.
    fn keyword(&mut self) -> Option<String> {
        match self.token() {
            [] => None,
            token => Some(String::from_utf8_lossy(token).to_ascii_uppercase()),
        }
    }

    fn count(&mut self, expected: &'static str) -> Result<usize, VtkError> {
        let word = self.word(expected)?;
        word.parse().map_err(|_| self.unexpected(expected, &word))
    }

    fn scalar(&mut self) -> Result<Scalar, VtkError> {
        let name = self.word("a type of values")?;
        Scalar::of(&name.to_ascii_lowercase())
            .ok_or_else(|| self.error(VtkFault::Unsupported(format!("values of type {name}"))))
    }

    /// Words on the rest of the line.
    fn words(&mut self) -> Vec<String> {
        let line = String::from_utf8_lossy(self.line()).into_owned();
        line.split_ascii_whitespace().map(str::to_owned).collect()
    }

    /// The bytes of `count` values, which begin in the next line.
    fn block(&mut self, scalar: Scalar, count: usize) -> Result<&'a [u8], VtkError> {
        self.line();
        let bytes = count.checked_mul(scalar.size());
        let block = bytes.and_then(|bytes| self.rest().get(..bytes));
        let block = block.ok_or_else(|| {
            self.error(VtkFault::Count {
                declared: count as u64,
            })
        })?;
        self.at += block.len();
        Ok(block)
    }

    /// `count` values of text, each of at least one character and a blank.
    fn text<T: std::str::FromStr>(
        &mut self,
        count: usize,
        expected: &'static str,
    ) -> Result<Vec<T>, VtkError> {
        if count > self.rest().len() / 2 + 1 {
            return Err(self.error(VtkFault::Count {
                declared: count as u64,
            }));
        }
        let mut values = Vec::with_capacity(count);
        for _ in 0..count {
            let word = self.word(expected)?;
            let value = word.parse().map_err(|_| self.unexpected(expected, &word));
            values.push(value?);
        }
        Ok(values)
    }

    fn integers(&mut self, scalar: Scalar, count: usize) -> Result<Vec<i64>, VtkError> {
        match self.encoding {
            Encoding::Text => self.text(count, "a whole number"),
            Encoding::Binary => Ok(scalar.integers(self.block(scalar, count)?, ByteOrder::Big)),
        }
    }

    fn reals(&mut self, scalar: Scalar, count: usize) -> Result<Vec<f64>, VtkError> {
        match self.encoding {
            Encoding::Text => self.text(count, "a number"),
            Encoding::Binary => Ok(scalar.reals(self.block(scalar, count)?, ByteOrder::Big)),
        }
    }

    fn skip(&mut self, scalar: Scalar, count: usize) -> Result<(), VtkError> {
        if self.encoding == Encoding::Binary {
            return self.block(scalar, count).map(|_| ());
        }
        for _ in 0..count {
            if self.token().is_empty() {
                return Err(self.error(VtkFault::Truncated("a value")));
            }
        }
        Ok(())
    }

    /// What a keyword `METADATA` begins ends with an empty line.
    fn skip_metadata(&mut self) {
        self.line();
        while !self.rest().is_empty() && !self.line().trim_ascii().is_empty() {}
    }
}

struct Reader<'a> {
    cursor: Cursor<'a>,
    dataset: Dataset,
    owner: Owner,
    /// Rows of the attributes that follow.
    rows: usize,
}

impl Reader<'_> {
    fn take(&mut self, keyword: &str) -> Result<(), VtkError> {
        match keyword {
            "DATASET" => self.kind(),
            "POINTS" => self.points(),
            "CELLS" => self.cells(),
            "CELL_TYPES" => {
                let count = self.cursor.count("the number of cells")?;
                self.dataset.types = self.cursor.integers(Scalar::Signed(4), count)?;
                Ok(())
            }
            "CELL_DATA" => self.attributes(Owner::Cells),
            "POINT_DATA" => self.attributes(Owner::Points),
            "METADATA" => {
                self.cursor.skip_metadata();
                Ok(())
            }
            "FIELD" => self.field(),
            "SCALARS" => self.scalars(),
            "LOOKUP_TABLE" => self.lookup_table(),
            "COLOR_SCALARS" => self.color_scalars(),
            "TEXTURE_COORDINATES" => {
                self.cursor.word("a name")?;
                let components = self.cursor.count("the number of components")?;
                self.skip_values(components)
            }
            "VECTORS" | "NORMALS" => self.skip_named(3),
            "TENSORS" => self.skip_named(9),
            "TENSORS6" => self.skip_named(6),
            "GLOBAL_IDS" | "PEDIGREE_IDS" | "EDGE_FLAGS" => self.skip_named(1),
            other => Err(self.cursor.unexpected("a keyword", other)),
        }
    }

    fn kind(&mut self) -> Result<(), VtkError> {
        let kind = self.cursor.word("a kind of data set")?;
        match kind.to_ascii_uppercase().as_str() {
            "UNSTRUCTURED_GRID" => Ok(()),
            other => {
                let what = format!("{other}: an UNSTRUCTURED_GRID is expected");
                Err(self.cursor.error(VtkFault::Unsupported(what)))
            }
        }
    }

    fn points(&mut self) -> Result<(), VtkError> {
        let count = self.cursor.count("the number of points")?;
        let scalar = self.cursor.scalar()?;
        self.dataset.points = self.cursor.reals(scalar, count.saturating_mul(3))?;
        Ok(())
    }

    fn cells(&mut self) -> Result<(), VtkError> {
        let rows = self.cursor.count("the number of cells")?;
        let size = self.cursor.count("the number of values of the cells")?;
        let before = self.cursor.at;
        if self.cursor.token() == b"OFFSETS" {
            let scalar = self.cursor.scalar()?;
            let mut ends = self.cursor.integers(scalar, rows)?;
            // The first one is where the first cell begins.
            ends.drain(..ends.len().min(1));
            self.dataset.ends = ends;
            let connectivity = self.cursor.word("CONNECTIVITY")?;
            if connectivity != "CONNECTIVITY" {
                return Err(self.cursor.unexpected("CONNECTIVITY", &connectivity));
            }
            let scalar = self.cursor.scalar()?;
            self.dataset.connectivity = self.cursor.integers(scalar, size)?;
            return Ok(());
        }
        self.cursor.at = before;
        let values = self.cursor.integers(Scalar::Signed(4), size)?;
        self.counted_cells(rows, &values)
    }

    /// Cells that begin with the number of their points.
    fn counted_cells(&mut self, rows: usize, values: &[i64]) -> Result<(), VtkError> {
        let mut rest = values;
        let truncated = VtkFault::Truncated("the points of a cell");
        while let Some((count, tail)) = rest.split_first() {
            let points = usize::try_from(*count).ok();
            let split = points.and_then(|points| tail.split_at_checked(points));
            let Some((points, next)) = split else {
                return Err(self.cursor.error(truncated));
            };
            self.dataset.connectivity.extend(points);
            self.dataset
                .ends
                .push(self.dataset.connectivity.len() as i64);
            rest = next;
        }
        let found = self.dataset.ends.len();
        if found == rows {
            Ok(())
        } else {
            Err(self.cursor.error(VtkFault::Length {
                expected: rows,
                found,
            }))
        }
    }

    fn attributes(&mut self, owner: Owner) -> Result<(), VtkError> {
        self.owner = owner;
        self.rows = self.cursor.count("the number of rows")?;
        Ok(())
    }

    /// Arrays with names of their own: of the file, of points or of cells.
    fn field(&mut self) -> Result<(), VtkError> {
        self.cursor.word("the name of a field")?;
        for _ in 0..self.cursor.count("the number of arrays")? {
            let mut name = self.cursor.word("the name of an array")?;
            if name == "METADATA" {
                self.cursor.skip_metadata();
                name = self.cursor.word("the name of an array")?;
            }
            let components = self.cursor.count("the number of components")?;
            let rows = self.cursor.count("the number of rows")?;
            let kind = self.cursor.word("a type of values")?;
            let count = components.saturating_mul(rows);
            if kind == "string" {
                self.strings(count)?;
                continue;
            }
            let scalar = Scalar::of(&kind.to_ascii_lowercase()).ok_or_else(|| {
                let what = format!("values of type {kind}");
                self.cursor.error(VtkFault::Unsupported(what))
            })?;
            self.array(&decoded(&name), scalar, components, count)?;
        }
        Ok(())
    }

    /// Each on a line of its own.
    fn strings(&mut self, count: usize) -> Result<(), VtkError> {
        if self.cursor.encoding == Encoding::Binary {
            let what = "arrays of text in binary: write the file as text".to_owned();
            return Err(self.cursor.error(VtkFault::Unsupported(what)));
        }
        self.cursor.line();
        for _ in 0..count {
            if self.cursor.rest().is_empty() {
                return Err(self.cursor.error(VtkFault::Truncated("a text")));
            }
            self.cursor.line();
        }
        Ok(())
    }

    /// Takes an array if it says groups, or names one.
    fn array(
        &mut self,
        name: &str,
        scalar: Scalar,
        components: usize,
        count: usize,
    ) -> Result<(), VtkError> {
        let group = GROUP_ARRAYS.iter().position(|known| *known == name);
        let is_group = self.owner == Owner::Cells && components == 1;
        if let Some(position) = group.filter(|_| is_group) {
            return self.groups(position, scalar, count);
        }
        if self.owner == Owner::File && count == 2 && scalar.is_integer() {
            if let &[number, dimension] = self.cursor.integers(scalar, 2)?.as_slice() {
                self.dataset.names.push(GroupName {
                    name: name.to_owned(),
                    number,
                    dimension,
                });
            }
            return Ok(());
        }
        self.cursor.skip(scalar, count)
    }

    fn groups(&mut self, position: usize, scalar: Scalar, count: usize) -> Result<(), VtkError> {
        let Some(&name) = GROUP_ARRAYS.get(position) else {
            return Ok(());
        };
        if !scalar.is_integer() {
            self.dataset.warn_of_reals(name);
            return self.cursor.skip(scalar, count);
        }
        let values = self.cursor.integers(scalar, count)?;
        // The first of the known names counts, in whatever order they come.
        let known = self.dataset.groups.as_ref();
        let known = known.and_then(|(known, _)| GROUP_ARRAYS.iter().position(|one| one == known));
        if known.is_none_or(|known| position < known) {
            self.dataset.groups = Some((name, values));
        }
        Ok(())
    }

    fn scalars(&mut self) -> Result<(), VtkError> {
        let words = self.cursor.words();
        let mut words = words.iter();
        let name = words.next().map(|name| decoded(name));
        let name =
            name.ok_or_else(|| self.cursor.error(VtkFault::Missing("the name of an array")))?;
        let kind = words.next().map_or("no type", String::as_str);
        let scalar = Scalar::of(&kind.to_ascii_lowercase()).ok_or_else(|| {
            let what = format!("values of type {kind}");
            self.cursor.error(VtkFault::Unsupported(what))
        })?;
        let components = words.next().map_or(Ok(1), |count| {
            let wrong = |_| self.cursor.unexpected("the number of components", count);
            count.parse::<usize>().map_err(wrong)
        })?;
        let before = self.cursor.at;
        if self.cursor.token() == b"LOOKUP_TABLE" {
            self.cursor.word("the name of a table")?;
        } else {
            // The numbers begin right here; their line must not be taken.
            self.cursor.at = before.saturating_sub(1);
        }
        self.array(
            &name,
            scalar,
            components,
            self.rows.saturating_mul(components),
        )
    }

    /// A table of colours of its own: four values a row.
    fn lookup_table(&mut self) -> Result<(), VtkError> {
        self.cursor.word("the name of a table")?;
        let rows = self.cursor.count("the number of rows")?;
        self.cursor
            .skip(Scalar::Unsigned(1), rows.saturating_mul(4))
    }

    fn color_scalars(&mut self) -> Result<(), VtkError> {
        self.cursor.word("a name")?;
        let components = self.cursor.count("the number of components")?;
        let count = self.rows.saturating_mul(components);
        self.cursor.skip(Scalar::Unsigned(1), count)
    }

    fn skip_named(&mut self, components: usize) -> Result<(), VtkError> {
        self.cursor.word("a name")?;
        self.skip_values(components)
    }

    fn skip_values(&mut self, components: usize) -> Result<(), VtkError> {
        let scalar = self.cursor.scalar()?;
        let count = self.rows.saturating_mul(components);
        self.cursor.skip(scalar, count)
    }

    fn finish(self) -> Result<Dataset, VtkError> {
        let dataset = self.dataset;
        let parts = [
            ("POINTS", dataset.points.is_empty()),
            ("CELLS", dataset.ends.is_empty()),
            ("CELL_TYPES", dataset.types.is_empty()),
        ];
        match parts.iter().find(|(_, empty)| *empty) {
            Some((missing, _)) => Err(VtkFault::Missing(missing).whole()),
            None => Ok(dataset),
        }
    }
}

/// A name, in which other characters than letters and digits are %XX.
fn decoded(name: &str) -> String {
    let mut bytes = Vec::with_capacity(name.len());
    let mut rest = name.as_bytes();
    while let Some((first, tail)) = rest.split_first() {
        let code = tail
            .get(..2)
            .and_then(|code| std::str::from_utf8(code).ok());
        let code = code.and_then(|code| u8::from_str_radix(code, 16).ok());
        match code.filter(|_| *first == b'%') {
            Some(byte) => {
                bytes.push(byte);
                rest = tail.get(2..).unwrap_or_default();
            }
            None => {
                bytes.push(*first);
                rest = tail;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}
