//! Preconditioners of the displacement block.

super::named! {
    /// A preconditioner of the displacement block,
    /// `solver.displacement_preconditioner`. Its position in the list goes into the
    /// key of prepared data.
    pub enum DisplacementMethod {
        /// Chebyshev smoothing on P2 around a P1 solve.
        PMultigrid = "p-multigrid",
        /// P1, edges, P1.
        HierarchicalSsor = "hierarchical-ssor",
        /// P1, then edges.
        HierarchicalMultiplicative = "hierarchical-multiplicative",
        /// P1 and edges side by side.
        HierarchicalAdditive = "hierarchical-additive",
    }
}
