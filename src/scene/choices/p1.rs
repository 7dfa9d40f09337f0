//! Solvers of the P1 block.

super::named! {
    /// A solver of the P1 block, `solver.p1_solver`. Its position in the list goes
    /// into the key of prepared data.
    pub enum P1Solver {
        /// Sparse Cholesky factor.
        Direct = "cholesky",
        /// Smoothed-aggregation multigrid.
        Amg = "amg",
        /// Conjugate gradients around an incomplete factor.
        IcCg = "ic-cg",
    }
}
