//! What a law in the two isochoric invariants must tell: its energy and the derivatives of it.

/// An energy and its derivatives at a pair of invariants, stress.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Derivatives {
    /// W.
    pub value: f64,
    /// W1 = dW/di1.
    pub first: f64,
    /// W2 = dW/di2.
    pub second: f64,
    /// W11.
    pub first_first: f64,
    /// W12.
    pub first_second: f64,
    /// W22.
    pub second_second: f64,
}

/// What a law in invariants must tell.
pub(super) trait Energy {
    /// W and its derivatives where i1 - 3 is `first` and i2 - 3 is `second`.
    fn at(&self, first: f64, second: f64) -> Derivatives;

    /// The law in units of `stress`.
    fn over(&self, stress: f64) -> Self
    where
        Self: Sized;

    /// Its name and its numbers, which tell laws apart.
    fn numbers(&self) -> (&'static str, Vec<f64>);
}
