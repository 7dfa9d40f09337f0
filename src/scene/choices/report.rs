//! What the report of an increment is about.

super::named! {
    /// What the report of an increment is about, `solver.report`.
    pub enum ReportScope {
        /// The whole body.
        Whole = "whole",
        /// Obstacles and the surface that they touch: what needs the body inside is left out.
        Contact = "contact",
    }
}
