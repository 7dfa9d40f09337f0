//! A vector of all unknowns, such as a dual solution or its residual: displacement, pressure and
//! multipliers, non-dimensional.

use crate::inequality::QpNorms;
use crate::linalg::vector::{add_scaled, norm};

/// A vector of all unknowns.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Fields {
    /// `[displacement]`.
    pub(crate) displacement: Vec<f64>,
    /// `[pressures]`.
    pub(crate) pressure: Vec<f64>,
    /// `[multipliers]`.
    pub(crate) multiplier: Vec<f64>,
}

impl Fields {
    /// Zeros, as many as `other` has.
    pub(crate) fn zeros_like(other: &Self) -> Self {
        Self {
            displacement: vec![0.0; other.displacement.len()],
            pressure: vec![0.0; other.pressure.len()],
            multiplier: vec![0.0; other.multiplier.len()],
        }
    }

    pub(super) fn add(&mut self, other: &Self) {
        self.add_multiple(1.0, other);
    }

    /// Adds `factor` times `other`.
    pub(super) fn add_multiple(&mut self, factor: f64, other: &Self) {
        add_scaled(&mut self.displacement, factor, &other.displacement);
        add_scaled(&mut self.pressure, factor, &other.pressure);
        add_scaled(&mut self.multiplier, factor, &other.multiplier);
    }

    /// Whether it has as many numbers as `other`.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        let sizes = |one: &Self| {
            [
                one.displacement.len(),
                one.pressure.len(),
                one.multiplier.len(),
            ]
        };
        sizes(self) == sizes(other)
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> u64 {
        8 * (self.displacement.len() + self.pressure.len() + self.multiplier.len()) as u64
    }

    pub(super) fn norms(&self) -> QpNorms {
        QpNorms {
            force: norm(&self.displacement),
            constraint: norm(&self.pressure),
            gap: norm(&self.multiplier),
        }
    }
}
