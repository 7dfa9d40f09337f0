//! What the cells report of a state beside its forces.

/// What a state amounts to beside its forces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Response {
    /// int W, non-dimensional.
    pub energy: f64,
    /// int J - 1.
    pub volume_change: f64,
    /// Least J over all points.
    pub least_jacobian: f64,
}

impl Response {
    /// That of no cell at all.
    pub(super) const NONE: Self = Self {
        energy: 0.0,
        volume_change: 0.0,
        least_jacobian: f64::INFINITY,
    };

    /// The sum, and the least, of both.
    pub(super) fn with(self, other: Self) -> Self {
        Self {
            energy: self.energy + other.energy,
            volume_change: self.volume_change + other.volume_change,
            least_jacobian: self.least_jacobian.min(other.least_jacobian),
        }
    }
}
