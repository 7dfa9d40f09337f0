//! What is done about the stability of rubber's equilibria.

super::named! {
    /// How an equilibrium is certified, `solver.stability`.
    pub enum StabilityCheck {
        /// All unstable motions counted by a factor of the tangent.
        Exact = "exact",
        /// The sign of the least eigenvalue, by Lanczos steps.
        Follow = "follow",
        /// Not at all.
        Off = "off",
    }
}

super::named! {
    /// What follows where an equilibrium is a saddle, or is lost,
    /// `solver.on_instability`.
    pub enum OnInstability {
        /// Down the energy to the next minimum.
        Descend = "descend",
        /// The step ends with the last minimum.
        Stop = "stop",
        /// On along saddles, which are results like others.
        Continue = "continue",
    }
}
