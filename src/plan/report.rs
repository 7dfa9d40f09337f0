//! The plan as people and clients read it.

use super::p1::P1Solver;
use super::{Plan, estimate};
use crate::linalg::cholesky::Precision;
use crate::report::Unknowns;

/// One decision.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlanEntry {
    /// What was decided.
    pub what: String,
    /// The choice.
    pub choice: String,
    /// Why.
    pub reason: String,
}

/// One thing that this scene does not pay for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeftOut {
    /// What is absent.
    pub what: String,
    /// Why it is not needed.
    pub reason: String,
}

/// A printable plan.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanReport {
    /// Name of the scene.
    pub name: String,
    /// `solid` or `plane-strain`.
    pub kind: &'static str,
    /// Unknowns by kind.
    pub unknowns: Unknowns,
    /// `mixed` or `displacement`.
    pub formulation: String,
    /// Methods with reasons.
    pub decisions: Vec<PlanEntry>,
    /// What is absent.
    pub left_out: Vec<LeftOut>,
    /// Bytes of prepared data and state.
    pub predicted_bytes: u64,
    /// Floating point operations to build the P1 solver.
    pub predicted_factor_flops: f64,
    /// Displacement preconditioner applications per increment.
    pub predicted_applications: u32,
    /// Things the caller should know.
    pub warnings: Vec<String>,
}

impl Plan {
    /// The plan in words and numbers.
    pub fn report(&self) -> PlanReport {
        let vertices = self.vertices();
        PlanReport {
            name: self.scene.name.clone(),
            kind: self.resolved.kind.name(),
            unknowns: self.unknowns,
            formulation: if self.resolved.mixed {
                "mixed"
            } else {
                "displacement"
            }
            .to_owned(),
            decisions: self.decisions(),
            left_out: self.left_out(),
            predicted_bytes: estimate::bytes(self, vertices),
            predicted_factor_flops: estimate::p1_solver(self, vertices).1,
            predicted_applications: estimate::applications(self),
            warnings: self.warnings.clone(),
        }
    }

    fn vertices(&self) -> u64 {
        self.unknowns.displacement / self.units.dimension as u64 - self.edges as u64
    }

    fn decisions(&self) -> Vec<PlanEntry> {
        let mut entries = Vec::new();
        let mut push = |what: &str, choice: String, reason: &str| {
            entries.push(PlanEntry {
                what: what.to_owned(),
                choice,
                reason: reason.to_owned(),
            });
        };
        if self.resolved.mixed {
            let reason = "a material has a Poisson ratio of at least 0.45";
            push(
                "formulation",
                "Taylor-Hood: P2 displacement, P1 pressure".into(),
                reason,
            );
        } else {
            let reason = "every Poisson ratio is below 0.45";
            push("formulation", "P2 displacement".into(), reason);
        }
        let degree = self.smoother_degree;
        let reason = match degree {
            2 => "well-shaped cells",
            _ => "stretched cells or a stiff volume response",
        };
        let choice = match self.smooths_along_lines() {
            true => format!("p-multigrid, Chebyshev degree {degree}, along short edges"),
            false => format!("p-multigrid, Chebyshev degree {degree}"),
        };
        push("displacement_preconditioner", choice, reason);
        push("p1_solver", self.p1_name(), &self.p1.reason);
        let krylov = match (self.resolved.mixed, self.unknowns.contact) {
            (false, 0) => "conjugate gradients",
            _ => "flexible GCR(10), upper block-triangular",
        };
        push(
            "saddle",
            krylov.into(),
            "one preconditioner application per iteration",
        );
        if self.unknowns.contact > 0 {
            let reason = "pressure and contact pressure are solved together";
            push(
                "contact",
                "one level, dense compliance metric".into(),
                reason,
            );
        }
        if self.is_floating() {
            let reason = format!("supports leave {}", self.resolved.free_modes.join(", "));
            push("rigid modes", "shifted P1 factor".into(), &reason);
        }
        entries
    }

    /// The P1 solver with its number type.
    fn p1_name(&self) -> String {
        let bits = match self.factor_precision().0 {
            Precision::Single => 32,
            Precision::Double => 64,
        };
        match self.p1.solver {
            P1Solver::Direct => format!("{} in {bits} bits", self.p1.solver.describe()),
            P1Solver::Amg => self.p1.solver.describe().to_owned(),
        }
    }

    fn left_out(&self) -> Vec<LeftOut> {
        let mut entries = Vec::new();
        let mut push = |what: &str, reason: &str| {
            entries.push(LeftOut {
                what: what.to_owned(),
                reason: reason.to_owned(),
            });
        };
        if !self.resolved.mixed {
            push(
                "pressure unknowns, divergence, pressure metric",
                "compressible",
            );
        } else if self
            .resolved
            .materials
            .iter()
            .all(|m| m.is_incompressible())
        {
            push("volume compliance", "exactly incompressible");
        }
        if self.unknowns.contact == 0 {
            push("contact multipliers, compliance, SQP loop", "no obstacle");
        }
        push("friction multipliers", "no friction");
        push(
            "reassembly and refactorisation",
            "small strain, linear material",
        );
        if !self.has_body_force() && self.scene.manufactured.is_none() {
            push("body force", "none given");
        }
        if !self.is_floating() {
            push("rigid-mode shift", "supports hold the body");
        }
        entries
    }
}
