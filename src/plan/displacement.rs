//! The preconditioner of the displacement block: which one, and why.
//!
//! The p-multigrid takes half the iterations of the hierarchical methods, one P1
//! solve per application instead of two, and holds no assembled edge block; it is
//! the choice for every scene. The others stand beside it for comparison.

use crate::plan::saddle::Demand;
use crate::precond::p_multigrid::Smoothing;
use crate::scene::{Choice, DisplacementMethod};

/// Chooses; `asked` is the scene's `solver.displacement_preconditioner`.
pub(super) fn choose(asked: Choice<DisplacementMethod>) -> DisplacementMethod {
    match asked {
        Choice::Auto => DisplacementMethod::PMultigrid,
        Choice::Named(method) => method,
    }
}

impl DisplacementMethod {
    /// What it asks of the outer method.
    pub(crate) fn demand(self) -> Demand {
        match self {
            Self::HierarchicalMultiplicative => Demand::Flexible,
            Self::PMultigrid | Self::HierarchicalSsor | Self::HierarchicalAdditive => Demand::None,
        }
    }

    /// Whether the edge block is assembled.
    pub(crate) fn is_hierarchical(self) -> bool {
        match self {
            Self::PMultigrid => false,
            Self::HierarchicalSsor
            | Self::HierarchicalMultiplicative
            | Self::HierarchicalAdditive => true,
        }
    }

    /// The pressure step, in units of the shear modulus, that goes with it: the
    /// poorer the preconditioner, the shorter.
    pub(crate) fn pressure_step(self) -> f64 {
        if self.is_hierarchical() { 1.0 } else { 2.0 }
    }

    /// Applications beside those of p-multigrid at equal accuracy.
    pub(crate) fn relative_applications(self) -> f64 {
        match self {
            Self::PMultigrid => 1.0,
            Self::HierarchicalSsor => 1.9,
            Self::HierarchicalMultiplicative => 2.2,
            Self::HierarchicalAdditive => 3.5,
        }
    }

    /// The choice in words and why.
    pub(crate) fn describe(self, smoothing: Smoothing) -> (String, &'static str) {
        let name = match self {
            Self::PMultigrid => {
                let reason = match smoothing {
                    Smoothing::Around(2) | Smoothing::After(3) => "well-shaped cells",
                    Smoothing::Around(_) | Smoothing::After(_) => {
                        "stretched cells or a stiff volume response"
                    }
                };
                return (format!("p-multigrid, {smoothing}"), reason);
            }
            Self::HierarchicalSsor => "hierarchical block SSOR: P1, edges, P1",
            Self::HierarchicalMultiplicative => "hierarchical block Gauss-Seidel: P1, edges",
            Self::HierarchicalAdditive => "hierarchical block Jacobi: P1 beside edges",
        };
        (
            name.to_owned(),
            "asked for; edges by one Gauss-Seidel sweep",
        )
    }
}
