//! A deformed body of finite strain, as what is built about it reads it.

use std::sync::Arc;

use crate::assembly::strain::{Linearised, StrainGrid};
use crate::linalg::SparseRows;
use crate::precond::stiff_constraints::Pressed;

/// A deformed state with its cells.
#[derive(Clone, Copy)]
pub(crate) struct Deformed<'a> {
    pub(crate) cells: &'a Arc<StrainGrid>,
    pub(crate) at: &'a Arc<Linearised>,
    pub(crate) displacement: &'a [f64],
    pub(crate) pressure: &'a [f64],
    /// The closed gaps that hold the body; none where nothing presses.
    pub(crate) contact: Option<ClosedGaps<'a>>,
}

/// Gaps, and which of them press.
#[derive(Clone, Copy)]
pub(crate) struct ClosedGaps<'a> {
    /// What moves each gap `[multipliers, displacement]`.
    pub(crate) coupling: &'a SparseRows,
    /// Which are closed, and under what pressure.
    pub(crate) pressed: Pressed<'a>,
}
