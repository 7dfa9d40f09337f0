//! What two surfaces where they are have to tell of the gap between them, function by function.
//!
//! ```text
//! G_j,   dG_j / du,   sum_j factor_j Hess G_j
//! ```
//!
//! Shapes: `[functions]`, rows by displacement unknowns, held ones too. A variant for the plane and
//! about an axis, and one in space. Cost: see [`super::pair`] and [`super::space`].

/// Entries by unknown.
pub(super) type Row = Vec<(u32, f64)>;

/// Gaps and their first derivatives.
pub(super) struct Derivatives {
    /// G `[functions]`.
    pub(super) values: Vec<f64>,
    /// dG/du `[functions]`, columns ascending.
    pub(super) rows: Vec<Row>,
}

/// Raises shares `[functions]` to what a face has of its own, `[covered, whole]`.
pub(super) fn raise<const N: usize>(
    shares: &mut [f64],
    functions: &[u32; N],
    [covered, whole]: [&[f64; N]; 2],
) {
    for (&function, (covered, whole)) in functions.iter().zip(covered.iter().zip(whole)) {
        let share = &mut shares[function as usize];
        *share = share.max(covered / whole);
    }
}

/// The gap between two surfaces.
pub(super) trait Gaps {
    /// G `[functions]`.
    fn values(&self) -> Vec<f64>;

    /// G and dG/du.
    fn derivatives(&self) -> Derivatives;

    /// The same of linear bodies, by how the surfaces move against each other alone.
    fn at_rest(&self) -> Derivatives;

    /// Rows of sum_j factor_j Hess G_j of `factors` `[functions]`, entries of a column to be added up.
    fn curvature(&self, factors: &[f64]) -> Vec<Row>;

    /// int psi_j over what has a partner, and over all, by deformed area `[functions]`.
    fn covered(&self) -> [Vec<f64>; 2];

    /// The largest part of psi_j on a face that has a partner, over all of it there `[functions]`.
    fn shares(&self) -> Vec<f64>;

    /// The deepest penetration at a point of the rule.
    fn deepest(&self) -> f64;

    /// How far partners are looked for.
    fn reach(&self) -> f64;
}
