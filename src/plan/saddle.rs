//! The method of the linear systems: which one, and why.
//!
//! Displacement forms without contact are symmetric positive definite: conjugate
//! gradients. Everything else is a saddle point: flexible GCR with the upper
//! block-triangular step, the fewest applications of the displacement
//! preconditioner. The others stand beside them for comparison.

/// What a preconditioner asks of the method around it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Demand {
    /// Nothing: it is a fixed symmetric positive definite map.
    None,
    /// It may change from call to call, or is not symmetric.
    Flexible,
}

/// Methods of the linear systems.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SaddleMethod {
    /// Conjugate gradients on the displacement.
    ConjugateGradients,
    /// The preconditioner on its own, on the displacement.
    Stationary,
    /// Flexible GCR, upper block-triangular step.
    Gcr,
    /// Flexible GCR, symmetric Arrow-Hurwicz step.
    ArrowHurwicz,
    /// Nested conjugate gradients on the pressure Schur complement.
    UzawaCg,
    /// MINRES, block-diagonal preconditioner.
    Minres,
}

/// A choice with its reason.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SaddleChoice {
    pub(crate) method: SaddleMethod,
    pub(super) reason: &'static str,
}

/// What the choice rests on.
#[derive(Clone, Copy, Debug)]
pub(super) struct SaddleNeeds {
    /// Whether the scene has a pressure or contact block.
    pub(super) has_multipliers: bool,
    /// What the displacement preconditioner and its P1 solver ask for.
    pub(super) demand: Demand,
}

/// Chooses; `asked` is the scene's `solver.saddle`.
pub(super) fn choose(asked: &str, needs: SaddleNeeds) -> SaddleChoice {
    let method = match asked {
        "cg" => SaddleMethod::ConjugateGradients,
        "stationary" => SaddleMethod::Stationary,
        "gcr" => SaddleMethod::Gcr,
        "arrow-hurwicz" => SaddleMethod::ArrowHurwicz,
        "uzawa-cg" => SaddleMethod::UzawaCg,
        "minres" => SaddleMethod::Minres,
        _ => return automatic(needs),
    };
    SaddleChoice {
        method,
        reason: "asked for",
    }
}

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
    pub(super) fn describe(self, has_multipliers: bool) -> &'static str {
        match self {
            Self::ConjugateGradients => "conjugate gradients",
            Self::Stationary => "stationary iteration",
            Self::Gcr if has_multipliers => "flexible GCR(10), upper block-triangular",
            Self::Gcr => "flexible GCR(10)",
            Self::ArrowHurwicz => "flexible GCR(10), symmetric Arrow-Hurwicz step",
            Self::UzawaCg => "Uzawa, nested conjugate gradients",
            Self::Minres => "MINRES, block-diagonal",
        }
    }

    /// Applications of the displacement preconditioner beside the automatic
    /// choice's.
    pub(super) fn relative_applications(self) -> f64 {
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

    fn chosen(asked: &str, has_multipliers: bool, demand: Demand) -> SaddleMethod {
        let needs = SaddleNeeds {
            has_multipliers,
            demand,
        };
        choose(asked, needs).method
    }

    #[test]
    fn conjugate_gradients_serve_only_fixed_symmetric_preconditioners() {
        let (cg, gcr) = (SaddleMethod::ConjugateGradients, SaddleMethod::Gcr);
        assert_eq!(chosen("auto", false, Demand::None), cg);
        assert_eq!(chosen("auto", false, Demand::Flexible), gcr);
        assert_eq!(chosen("auto", true, Demand::None), gcr);
    }

    #[test]
    fn the_scene_has_the_last_word() {
        for (name, method) in [
            ("stationary", SaddleMethod::Stationary),
            ("arrow-hurwicz", SaddleMethod::ArrowHurwicz),
            ("uzawa-cg", SaddleMethod::UzawaCg),
            ("minres", SaddleMethod::Minres),
        ] {
            assert_eq!(chosen(name, true, Demand::None), method);
        }
    }
}
