//! The solver of the P1 block: which one, and why.
//!
//! Multigrid needs time and bytes in proportion to the vertices, a factor grows
//! faster but bears any contrast of stiffness. Both give the contact compliance, which
//! friction wants exact while the factor fits. A cycle that turns out weak is replaced by
//! the factor.

use super::estimate;
use crate::plan::saddle::Demand;
use crate::scene::{Choice, P1Solver};

/// Flops below which the factor takes less time than the multigrid saves.
const CHEAP_FACTOR: f64 = 1e9;
/// Bytes of the largest factor. Friction is worth any that fits: its faces follow from the
/// compliance, and with that of a cycle `mr-rough` takes twice the applications.
const LARGEST_FACTOR: f64 = 4e9;
/// Flops of a factor that contrast or poor cells are worth.
const DEAREST_FACTOR: f64 = 4e11;
/// Ratio of shear moduli up to which multigrid was seen to keep its counts, in
/// layers and in a ball across the mesh, stiff and soft.
const MODEST_CONTRAST: f64 = 1e6;
/// Mean quality of cells below which multigrid needs several times the steps.
const POOR_CELLS: f64 = 0.4;

impl P1Solver {
    /// The name in plans.
    pub(super) fn describe(self) -> &'static str {
        match self {
            Self::Direct => "sparse Cholesky",
            Self::Amg => "smoothed-aggregation multigrid, single precision",
            Self::IcCg => "incomplete Cholesky, conjugate gradients to a tolerance",
        }
    }

    /// The name of its data in reports of reuse.
    pub(crate) fn part(self) -> &'static str {
        match self {
            Self::Direct => "p1_factor",
            Self::Amg => "p1_multigrid",
            Self::IcCg => "p1_incomplete_factor",
        }
    }

    /// What it asks of the outer method.
    pub(super) fn demand(self) -> Demand {
        match self {
            Self::Direct | Self::Amg => Demand::None,
            Self::IcCg => Demand::Flexible,
        }
    }
}

/// A choice with its reason.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct P1Choice {
    /// The solver.
    pub(crate) solver: P1Solver,
    /// Why it was chosen, as a phrase that a plan shows.
    pub(crate) reason: String,
}

impl P1Choice {
    /// The solver with its reason.
    fn new(solver: P1Solver, reason: impl Into<String>) -> Self {
        Self {
            solver,
            reason: reason.into(),
        }
    }
}

/// What the choice rests on.
#[derive(Clone, Copy, Debug)]
pub(super) struct P1Sizes {
    /// Dimension of the body: 2 or 3.
    pub(super) dimension: usize,
    /// Number of mesh vertices.
    pub(super) vertices: u64,
    /// Whether obstacles have friction.
    pub(super) is_frictional: bool,
    /// Largest over smallest shear modulus of the scene.
    pub(super) contrast: f64,
    /// Mean quality of the cells, 1 for regular ones.
    pub(super) quality: f64,
}

/// Chooses; `asked` is the scene's `solver.p1_solver`.
pub(super) fn choose(asked: Choice<P1Solver>, sizes: P1Sizes) -> P1Choice {
    match asked {
        Choice::Auto => automatic(sizes),
        Choice::Named(solver) => P1Choice::new(solver, "asked for"),
    }
}

/// A sparse factor for small bodies, and where friction, contrast or stretched cells want
/// one that fits memory and work; multigrid otherwise.
fn automatic(sizes: P1Sizes) -> P1Choice {
    let (entries, flops) = estimate::factor(sizes.dimension, sizes.vertices);
    let cost = format!(
        "the factor takes {:.1} Gflop and {:.0} MB",
        1e-9 * flops,
        8e-6 * entries
    );
    let fits = 8.0 * entries <= LARGEST_FACTOR;
    let is_affordable = fits && flops <= DEAREST_FACTOR;
    if flops <= CHEAP_FACTOR {
        P1Choice::new(P1Solver::Direct, format!("small: {cost}"))
    } else if fits && sizes.is_frictional {
        let reason = format!("friction asks for the exact compliance; {cost}");
        P1Choice::new(P1Solver::Direct, reason)
    } else if !is_affordable {
        P1Choice::new(P1Solver::Amg, format!("large: {cost}"))
    } else if sizes.contrast > MODEST_CONTRAST {
        let reason = format!("shear moduli differ {:.0e} times; {cost}", sizes.contrast);
        P1Choice::new(P1Solver::Direct, reason)
    } else if sizes.quality < POOR_CELLS {
        let reason = format!("stretched cells, mean quality {:.2}; {cost}", sizes.quality);
        P1Choice::new(P1Solver::Direct, reason)
    } else {
        let reason = format!("{} vertices: {cost}", sizes.vertices);
        P1Choice::new(P1Solver::Amg, reason)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Named;

    /// A well-shaped homogeneous body.
    fn body(vertices: u64) -> P1Sizes {
        P1Sizes {
            dimension: 3,
            vertices,
            is_frictional: false,
            contrast: 1.0,
            quality: 0.7,
        }
    }

    #[test]
    fn the_scene_has_the_last_word() {
        for &solver in P1Solver::ALL {
            let asked = Choice::Named(solver);
            assert_eq!(choose(asked, body(100)).solver, solver);
            assert_eq!(choose(asked, body(1_000_000)).solver, solver);
        }
    }

    #[test]
    fn multigrid_takes_over_where_the_factor_is_dear() {
        assert_eq!(choose(Choice::Auto, body(1331)).solver, P1Solver::Direct);
        assert_eq!(choose(Choice::Auto, body(4913)).solver, P1Solver::Amg);
        let plane = P1Sizes {
            dimension: 2,
            ..body(20_000)
        };
        assert_eq!(choose(Choice::Auto, plane).solver, P1Solver::Direct);
    }

    #[test]
    fn friction_contrast_and_poor_cells_keep_the_factor_while_it_fits() {
        let hard = |vertices| {
            [
                P1Sizes {
                    is_frictional: true,
                    ..body(vertices)
                },
                P1Sizes {
                    contrast: 1e9,
                    ..body(vertices)
                },
                P1Sizes {
                    quality: 0.2,
                    ..body(vertices)
                },
            ]
        };
        for (sizes, word) in hard(20_000)
            .into_iter()
            .zip(["friction", "moduli", "quality"])
        {
            let choice = choose(Choice::Auto, sizes);
            assert_eq!(choice.solver, P1Solver::Direct);
            assert!(choice.reason.contains(word), "{}", choice.reason);
        }
        for sizes in hard(200_000) {
            assert_eq!(choose(Choice::Auto, sizes).solver, P1Solver::Amg);
        }
    }
}
