//! How a linear body answers the motion of its obstacles.

super::named! {
    /// How increments of a linear body are solved, `solver.response`.
    pub enum ResponseMethod {
        /// By its response at the contact surface, from a factor of the whole body.
        Condensed = "condensed",
        /// By Krylov iterations.
        Iterative = "iterative",
    }
}
