//! Estimates of the discretisation error.

super::named! {
    /// What replaces the usual estimate of the discretisation error,
    /// `solver.error_estimate`.
    pub enum ErrorEstimate {
        /// No estimate.
        Off = "off",
    }
}
