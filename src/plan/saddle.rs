//! The method of the linear systems: which one, and why.
//!
//! Displacement forms without contact are symmetric positive definite: conjugate
//! gradients. Everything else is a saddle point: flexible GCR with the upper
//! block-triangular step, the fewest applications of the displacement
//! preconditioner. The others stand beside them for comparison.

use crate::scene::{Choice, SaddleMethod};

/// What a preconditioner asks of the method around it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Demand {
    /// Nothing: it is a fixed symmetric positive definite map.
    None,
    /// It may change from call to call, or is not symmetric.
    Flexible,
}

/// A choice with its reason.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SaddleChoice {
    /// The method of the linear systems.
    pub(crate) method: SaddleMethod,
    /// Why it was chosen, as a phrase that a plan shows.
    pub(crate) reason: &'static str,
}

/// What the choice rests on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SaddleNeeds {
    /// Whether the scene has a pressure or contact block.
    pub(crate) has_multipliers: bool,
    /// What the displacement preconditioner and its P1 solver ask for.
    pub(crate) demand: Demand,
}

/// Chooses; `asked` is the scene's `solver.saddle`.
pub(crate) fn choose(asked: Choice<SaddleMethod>, needs: SaddleNeeds) -> SaddleChoice {
    match asked {
        Choice::Auto => automatic(needs),
        Choice::Named(method) => SaddleChoice {
            method,
            reason: "asked for",
        },
    }
}

/// The usual method for what the scene's blocks and preconditioner ask for.
fn automatic(needs: SaddleNeeds) -> SaddleChoice {
    let (method, reason) = match (needs.has_multipliers, needs.demand) {
        (false, Demand::None) => (
            SaddleMethod::ConjugateGradients,
            "one preconditioner application per iteration",
        ),
        (false, Demand::Flexible) => (
            SaddleMethod::Gcr,
            "the preconditioner is not a fixed symmetric map",
        ),
        (true, Demand::None | Demand::Flexible) => (
            SaddleMethod::Gcr,
            "one preconditioner application per iteration",
        ),
    };
    SaddleChoice { method, reason }
}

impl SaddleMethod {
    /// The name in plans.
    pub(crate) fn describe(self, has_multipliers: bool) -> &'static str {
        match self {
            Self::ConjugateGradients => "conjugate gradients",
            Self::Stationary => "stationary iteration",
            Self::Gcr if has_multipliers => "flexible GCR, upper block-triangular",
            Self::Gcr => "flexible GCR",
            Self::ArrowHurwicz => "flexible GCR, symmetric Arrow-Hurwicz step",
            Self::UzawaCg => "Uzawa, nested conjugate gradients",
            Self::Minres => "MINRES, block-diagonal",
        }
    }

    /// Applications of the displacement preconditioner beside the automatic
    /// choice's.
    pub(crate) fn relative_applications(self) -> f64 {
        match self {
            Self::ConjugateGradients | Self::Gcr => 1.0,
            Self::Stationary => 4.0,
            Self::ArrowHurwicz => 2.0,
            Self::UzawaCg => 8.0,
            Self::Minres => 2.8,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Named;

    fn chosen(asked: Choice<SaddleMethod>, has_multipliers: bool, demand: Demand) -> SaddleMethod {
        let needs = SaddleNeeds {
            has_multipliers,
            demand,
        };
        choose(asked, needs).method
    }

    #[test]
    fn conjugate_gradients_serve_only_fixed_symmetric_preconditioners() {
        let (cg, gcr) = (SaddleMethod::ConjugateGradients, SaddleMethod::Gcr);
        assert_eq!(chosen(Choice::Auto, false, Demand::None), cg);
        assert_eq!(chosen(Choice::Auto, false, Demand::Flexible), gcr);
        assert_eq!(chosen(Choice::Auto, true, Demand::None), gcr);
    }

    #[test]
    fn the_scene_has_the_last_word() {
        for &method in SaddleMethod::ALL {
            assert_eq!(chosen(Choice::Named(method), true, Demand::None), method);
        }
    }
}
