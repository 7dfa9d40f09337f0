//! Finite elements of displacement and pressure.

super::named! {
    /// A pair of finite element spaces, `solver.element`.
    pub enum ElementKind {
        /// P2 displacement; P1 pressure where the scene is mixed.
        TaylorHood = "taylor-hood",
    }
}
