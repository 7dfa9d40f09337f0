//! Modes that two blocks share, solved for together.
//!
//! A pattern of the first block's unknowns may act on the body as some pattern of
//! another block's do, so that neither metric alone knows the two: an even internal
//! pressure and an even contact pressure on a closed volume. With the Schur complement
//!
//! ```text
//! [ G   W   ]   of the amplitudes a of the patterns Z and of the block's multipliers x,
//! [ W^T ... ]   the metric of the block is its own part less W^T G^-1 W:
//! x = -M^-1 (r - W^T G^-1 Z^T r1),   a = -G^-1 W x - E Z^T r1
//! ```
//!
//! Shapes: Z `[modes, first block]`, W `[modes, block]`. Cost: two passes over each and four
//! over G's factor.

use crate::linalg::{DenseMatrix, GramFactor, LinearOperator, SparseRows, Workspace};

/// The modes that a block may share with the first one.
#[derive(Clone, Debug)]
pub struct SharedModes {
    /// Z: the patterns `[modes, first block]`.
    pub first: SparseRows,
    /// The patterns of the block that act alike `[modes, block]`.
    pub alike: SparseRows,
    /// W: what the block's constraints see of them `[modes, block]`.
    pub own: SparseRows,
    /// G: what their own constraints see of them, positive semi-definite `[modes, modes]`.
    pub work: DenseMatrix,
    /// Share of a mode that the block has to take up for both to be solved together.
    pub least_share: f64,
}

/// Those that it shares on a face.
#[derive(Clone, Debug)]
pub struct JointModes {
    first: SparseRows,
    own: SparseRows,
    factor: GramFactor,
}

impl SharedModes {
    /// The modes in `selected`, ascending, on a face where the multipliers have these `weights`
    /// `[block]`.
    pub fn on_face(&self, selected: &[usize], weights: &[f64]) -> JointModes {
        let mut own = self.own.selected(selected);
        own.scale_columns(weights);
        JointModes {
            first: self.first.selected(selected),
            own,
            factor: GramFactor::new(&self.work.principal(selected)),
        }
    }
}

impl JointModes {
    /// Takes off `r` `[block]` what the residual of the first block leaves there.
    pub(super) fn reduce(&self, r_first: &[f64], r: &mut [f64], work: &mut Workspace) {
        let mut amplitudes = work.zeros(self.first.rows());
        self.first.apply(r_first, &mut amplitudes, work);
        self.factor.solve(&mut amplitudes);
        self.own.add_transposed(-1.0, &amplitudes, r, work);
        work.give(amplitudes);
    }

    /// The amplitudes that follow the step `z` of the block `[modes]`.
    pub(super) fn behind(&self, z: &[f64], work: &mut Workspace) -> Vec<f64> {
        let mut amplitudes = work.zeros(self.first.rows());
        self.own.apply(z, &mut amplitudes, work);
        self.factor.solve(&mut amplitudes);
        amplitudes
            .iter_mut()
            .for_each(|amplitude| *amplitude = -*amplitude);
        amplitudes
    }

    /// Adds the patterns with these amplitudes.
    pub(super) fn add(&self, amplitudes: &[f64], z_first: &mut [f64], work: &mut Workspace) {
        self.first.add_transposed(1.0, amplitudes, z_first, work);
    }
}
