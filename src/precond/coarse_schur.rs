//! The metric of the internal pressure in a thin body: beside the mass, which knows nothing of
//! shape, the pressures along the body that hardly change a volume,
//!
//! ```text
//! M^-1 + Z L^-T E L^-1 Z^T,   E_k = max(0, 1 - 1 / N_k),   N = L^-1 Z^T M Z L^-T
//! ```
//!
//! G = L L^T the Schur complement B Y B^T + S between the columns z of Z
//! ([`super::volume_modes`]).
//! In a layer bonded on both sides G over the mass falls like the square of thickness over
//! wave length, and the iterations with the mass alone grow like length over thickness.
//! Additive, as in two-level Schwarz methods (A. Toselli and O. Widlund, Domain
//! Decomposition Methods, 2005, section 2). Shapes `[pressures]`. Cost: two passes over each z
//! and over L.

use super::schur::ChebyshevMass;
use super::volume_modes::VolumeModes;
use crate::linalg::{
    GramFactor, LinearOperator, Preconditioner, SparseRows, SparseRowsBuilder, Workspace,
};

/// M^-1 with the pressures that it overestimates.
pub struct CoarseSchur<'a> {
    /// M^-1.
    fine: &'a ChebyshevMass,
    /// z `[modes, pressures]`.
    patterns: SparseRows,
    /// L.
    factor: GramFactor,
    /// E `[modes]`.
    correction: Vec<f64>,
}

impl<'a> CoarseSchur<'a> {
    /// `fine` with those of `volumes` that change less than it says.
    pub fn new(fine: &'a ChebyshevMass, volumes: &VolumeModes, work: &mut Workspace) -> Self {
        let masses = masses(fine, &volumes.pressures, work);
        let correction = (0..volumes.count()).map(|mode| {
            // One of the orthonormal pressures in the patterns.
            let mut own = vec![0.0; volumes.count()];
            own[mode] = 1.0;
            volumes.factor.backward(&mut own);
            let known = own.iter().enumerate();
            let weighed = |(other, &share): (usize, &f64)| {
                if share == 0.0 {
                    0.0
                } else {
                    share * masses.row_product(other, &own)
                }
            };
            let correction = 1.0 - known.map(weighed).sum::<f64>().recip();
            if correction > 0.0 && correction.is_finite() {
                correction
            } else {
                0.0
            }
        });
        Self {
            correction: correction.collect(),
            fine,
            patterns: volumes.pressures.clone(),
            factor: volumes.factor.clone(),
        }
    }
}

/// Z^T M Z `[modes, modes]`.
fn masses(fine: &ChebyshevMass, patterns: &SparseRows, work: &mut Workspace) -> SparseRows {
    let mut builder = SparseRowsBuilder::new(patterns.rows());
    let mut pattern = work.zeros(patterns.columns());
    let mut weighed = work.zeros(patterns.columns());
    let mut row = work.zeros(patterns.rows());
    for mode in 0..patterns.rows() {
        pattern.fill(0.0);
        patterns.add_row(mode, 1.0, &mut pattern);
        fine.mass().apply(&pattern, &mut weighed, work);
        patterns.apply(&weighed, &mut row, work);
        builder.push_dense(&row, 0.0);
    }
    [pattern, weighed, row]
        .into_iter()
        .for_each(|vector| work.give(vector));
    builder.finish()
}

impl Preconditioner for CoarseSchur<'_> {
    fn apply(&self, r: &[f64], z: &mut [f64], work: &mut Workspace) {
        self.fine.apply(r, z, work);
        let mut shares = work.zeros(self.correction.len());
        self.patterns.apply(r, &mut shares, work);
        self.factor.forward(&mut shares);
        let pairs = shares.iter_mut().zip(&self.correction);
        pairs.for_each(|(share, correction)| *share *= correction);
        self.factor.backward(&mut shares);
        self.patterns.add_transposed(1.0, &shares, z, work);
        work.give(shares);
    }
}
