//! A deformed body of finite strain, as what is built about it reads it.

use std::sync::Arc;

use crate::assembly::strain::{Linearised, StrainGrid};

/// A deformed state with its cells.
#[derive(Clone, Copy)]
pub(crate) struct Deformed<'a> {
    pub(crate) cells: &'a Arc<StrainGrid>,
    pub(crate) at: &'a Arc<Linearised>,
    pub(crate) displacement: &'a [f64],
    pub(crate) pressure: &'a [f64],
}
