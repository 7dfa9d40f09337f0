//! Methods of the linear systems.

super::named! {
    /// A method of the linear systems, `solver.saddle`.
    pub enum SaddleMethod {
        /// Flexible GCR, upper block-triangular step.
        Gcr = "gcr",
        /// Conjugate gradients on the displacement.
        ConjugateGradients = "cg",
        /// The preconditioner on its own, on the displacement.
        Stationary = "stationary",
        /// Flexible GCR, symmetric Arrow-Hurwicz step.
        ArrowHurwicz = "arrow-hurwicz",
        /// Nested conjugate gradients on the pressure Schur complement.
        UzawaCg = "uzawa-cg",
        /// MINRES, block-diagonal preconditioner.
        Minres = "minres",
    }
}
