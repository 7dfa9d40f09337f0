//! Numeric constants of the solver's decisions, as they are compiled: name, value, meaning.
//!
//! The macro `constants` declares those of a file and lists them; the rooms that search and decide
//! hold their single numbers and arrays of numbers in it, so that a plan can print what is in force.

/// A numeric constant of the solver.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Constant {
    /// File that declares it, from the root of the package.
    pub file: &'static str,
    /// Its name there.
    pub name: &'static str,
    /// Its value, as Rust writes it.
    pub value: String,
    /// What it bounds or weighs, with unit and measurement.
    pub meaning: String,
}

/// Declares the numeric constants of a file, each with a documentation comment, and
/// `own_constants`, the list of them.
macro_rules! constants {
    ($($(#[doc = $meaning:literal])+ $visible:vis const $name:ident: $kind:ty = $value:expr;)+) => {
        $($(#[doc = $meaning])+ $visible const $name: $kind = $value;)+

        /// The numeric constants of this file.
        pub(crate) fn own_constants() -> Vec<$crate::constants::Constant> {
            vec![$($crate::constants::Constant {
                file: file!(),
                name: stringify!($name),
                value: format!("{:?}", $name),
                meaning: concat!($($meaning),+).trim().to_owned(),
            }),+]
        }
    };
}
