//! A drawing on its way to a file.

/// A picture and the stem of its file name.
#[derive(Clone, Debug)]
pub(crate) struct Figure {
    pub(crate) name: String,
    pub(crate) svg: String,
}
