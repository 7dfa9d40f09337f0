//! How much of all that there is a bench runs.

/// How much a bench does by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Extent {
    /// Small meshes, two minutes at most.
    Quick,
    /// All levels and studies.
    Full,
}
