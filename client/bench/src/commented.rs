//! Tables in CSV whose lines of `#` are comments for readers.

/// A reader of CSV with comments.
pub(crate) fn reader<R: std::io::Read>(input: R) -> csv::Reader<R> {
    let mut builder = csv::ReaderBuilder::new();
    builder
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .flexible(true);
    builder.from_reader(input)
}
