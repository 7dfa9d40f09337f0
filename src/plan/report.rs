//! The plan as people and clients read it.
//!
//! Decisions come with their reasons, what is left out with the reason why it is not
//! needed, memory as predicted bytes. The order is fixed, so that two plans can be compared
//! line by line.

use std::collections::HashSet;

use super::{Plan, estimate};
use crate::linalg::cholesky::Precision;
use crate::report::Unknowns;
use crate::scene::{AskedAt, Goal, MetricKind, P1Solver, Parameter, SceneKind, SurfaceGeometry};

/// One decision.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlanEntry {
    /// What was decided, as a key of the scene or a word.
    pub what: String,
    /// What was chosen.
    pub choice: String,
    /// Why it was chosen, as a phrase.
    pub reason: String,
}

/// One thing that this scene does not pay for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeftOut {
    /// What is absent, as a phrase.
    pub what: String,
    /// Why the scene does not need it, as a phrase.
    pub reason: String,
}

/// A printable plan.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanReport {
    /// Name of the scene, for people.
    pub name: String,
    /// Geometry of the scene: `solid`, `plane-strain`, `plane-stress` or `axisymmetric`.
    pub kind: &'static str,
    /// Number of unknowns by kind.
    pub unknowns: Unknowns,
    /// Which unknowns carry the volume constraint: `mixed` or `displacement`.
    pub formulation: String,
    /// Methods with the reasons for them.
    pub decisions: Vec<PlanEntry>,
    /// What this scene does not pay for, with the reasons.
    pub left_out: Vec<LeftOut>,
    /// Predicted bytes of prepared data and state, from models of their sizes.
    pub predicted_bytes: u64,
    /// The part of these that a session takes later than in its first step, if at all.
    pub later_bytes: Option<LaterBytes>,
    /// Floating point operations to build the P1 solver.
    pub predicted_factor_flops: f64,
    /// Displacement preconditioner applications per increment.
    pub predicted_applications: u32,
    /// Sentences about what the caller should know.
    pub warnings: Vec<String>,
}

/// Memory that a session takes from some step on: that of its body's response at the contact
/// surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LaterBytes {
    /// The first step that may take it, from 1.
    pub from_step: u32,
    /// Bytes at most.
    pub bytes: u64,
}

impl Plan {
    /// Predicted bytes of prepared data and of a session in its first step.
    pub fn first_bytes(&self) -> u64 {
        let later = self.later_bytes().map_or(0, |later| later.bytes);
        estimate::bytes(self, self.problem.vertices as u64).saturating_sub(later)
    }

    /// The plan in words and numbers.
    pub fn report(&self) -> PlanReport {
        let vertices = self.problem.vertices as u64;
        PlanReport {
            name: self.problem.scene.name.clone(),
            kind: self.problem.resolved.kind.name(),
            unknowns: self.problem.unknowns,
            formulation: if self.problem.resolved.mixed {
                "mixed"
            } else {
                "displacement"
            }
            .to_owned(),
            decisions: self.entries(),
            left_out: self.left_out(),
            predicted_bytes: estimate::bytes(self, vertices),
            later_bytes: self.later_bytes(),
            predicted_factor_flops: estimate::p1_solver(self, vertices).1,
            predicted_applications: estimate::applications(self),
            warnings: self.notes.warnings.clone(),
        }
    }

    /// All decisions of the plan, in the order in which they are shown.
    fn entries(&self) -> Vec<PlanEntry> {
        let mut entries = Vec::new();
        let mut push = |what: &str, choice: String, reason: &str| {
            entries.push(PlanEntry {
                what: what.to_owned(),
                choice,
                reason: reason.to_owned(),
            });
        };
        push(
            "formulation",
            self.formulation_name(),
            self.formulation_reason(),
        );
        self.push_measure(&mut push);
        self.push_rubber(&mut push);
        if let Some(price) = self.factor_cost() {
            push(
                "factor",
                format!("of all unknowns, where a quadratic program has taken {price} iterations"),
                "a direct solve costs no more by then; later programs begin with it",
            );
        }
        self.push_smoother(&mut push);
        push("p1_solver", self.p1_name(), &self.decisions.p1.reason);
        self.push_saddle(&mut push);
        if self.penalty() > 0.0 {
            let choice = format!("grad-div term of {} mu", self.penalty());
            push("penalty", choice, "asked for");
        }
        if self.problem.unknowns.contact > 0 {
            push(
                "contact",
                self.decisions.contact.describe(),
                &self.decisions.contact.reason,
            );
            self.push_surface(&mut push);
        }
        if let Some((words, reason)) = self.response_in_words() {
            push("response", words, reason);
        }
        for tool in &self.notes.tools {
            push(&tool.what, tool.choice.clone(), &tool.reason);
        }
        self.push_goals(&mut push);
        if self.is_shifted() {
            let resolved = &self.problem.resolved;
            let free = if self.is_floating() {
                &resolved.free_modes
            } else {
                &resolved.free_alone
            };
            let reason = format!("supports leave {}", free.join(", "));
            push("rigid modes", "shifted P1 factor".into(), &reason);
        }
        entries
    }

    /// What questions about goals will cost.
    fn push_goals(&self, push: &mut dyn FnMut(&str, String, &str)) {
        let questions = &self.problem.scene.questions;
        let parameters: HashSet<&Parameter> =
            questions.iter().flat_map(|one| &one.parameters).collect();
        let goals_at = |at: Option<AskedAt>| {
            let own = questions
                .iter()
                .filter(|one| at.is_none_or(|at| one.at == at));
            let goals: HashSet<&Goal> = own.flat_map(|one| &one.goals).collect();
            goals.len()
        };
        let goals = goals_at(None);
        if goals == 0 {
            return;
        }
        let each = u64::from(estimate::dual_applications(self));
        let often = goals_at(Some(AskedAt::Increments));
        let choice = format!(
            "{goals} goals by {} parameters, {} applications {}",
            parameters.len(),
            each * if often == 0 { goals } else { often } as u64,
            match (often, goals - often) {
                (0, _) => "a step".to_owned(),
                (_, 0) => "an increment".to_owned(),
                (_, rest) => format!("an increment, {} more a step", each * rest as u64),
            }
        );
        push(
            "goals",
            choice,
            "one dual solution a goal, two evaluations of terms of the residuals a parameter, four of constants and \
             supports where they are not linear in it",
        );
    }

    /// What forces, volumes and energies are measured over, where that is not the body.
    fn push_measure(&self, push: &mut dyn FnMut(&str, String, &str)) {
        let (choice, reason) = match self.problem.resolved.kind {
            SceneKind::Axisymmetric => (
                "the whole ring about the axis x = 0",
                "forces, volumes and energies are not per radian",
            ),
            SceneKind::PlaneStress => (
                "a sheet whose thickness is free at each point",
                "forces, energies and pressures are per thickness before deformation",
            ),
            SceneKind::Solid | SceneKind::PlaneStrain => return,
        };
        push("measure", choice.to_owned(), reason);
    }

    /// The method of the linear systems.
    fn push_saddle(&self, push: &mut dyn FnMut(&str, String, &str)) {
        let (unknowns, saddle) = (self.problem.unknowns, &self.decisions.saddle);
        let has_multipliers = unknowns.pressure + unknowns.contact > 0;
        let mut method = saddle.method.describe(has_multipliers).to_owned();
        if self.is_augmented() {
            method.push_str(", augmented");
        }
        push("saddle", method, saddle.reason);
    }

    /// The preconditioner of the displacement block, with its smoother.
    fn push_smoother(&self, push: &mut dyn FnMut(&str, String, &str)) {
        let (mut name, reason) = self.decisions.displacement.describe(self.smoothing());
        if self.smooths_along_lines() {
            name.push_str(", along short edges");
        }
        push("displacement_preconditioner", name, reason);
    }

    /// Which surface of the body contact sees, where it is not that of flat facets.
    fn push_surface(&self, push: &mut dyn FnMut(&str, String, &str)) {
        let mut surfaces = self
            .problem
            .obstacles
            .iter()
            .map(|obstacle| obstacle.surface);
        if surfaces.any(|surface| surface == SurfaceGeometry::Smooth) {
            push("surface", "arcs fitted over the facets".into(), "asked for");
        } else if self.problem.curved_edges > 0 {
            let choice = format!(
                "true surface: {} edges carry offsets",
                self.problem.curved_edges
            );
            push("surface", choice, "the mesh is of second order");
        }
    }

    /// The P1 solver with its number type.
    fn p1_name(&self) -> String {
        let bits = match self.factor_precision().0 {
            Precision::Single => 32,
            Precision::Double => 64,
        };
        match self.decisions.p1.solver {
            P1Solver::Direct => format!("{} in {bits} bits", self.decisions.p1.solver.describe()),
            P1Solver::Amg | P1Solver::IcCg => self.decisions.p1.solver.describe().to_owned(),
        }
    }

    /// Everything that this scene leaves out, in the order in which it is shown.
    fn left_out(&self) -> Vec<LeftOut> {
        let mut entries = Vec::new();
        let mut push = |what: &str, reason: &str| {
            entries.push(LeftOut {
                what: what.to_owned(),
                reason: reason.to_owned(),
            });
        };
        if !self.problem.resolved.mixed {
            push(
                "pressure unknowns, divergence, pressure metric",
                "compressible",
            );
        } else if self
            .problem
            .resolved
            .materials
            .iter()
            .all(|m| m.is_incompressible())
        {
            push("volume compliance", "exactly incompressible");
        }
        if self.problem.unknowns.contact == 0 {
            push("contact multipliers, compliance, SQP loop", "no obstacle");
        } else if self.decisions.contact.metric != MetricKind::Compliance {
            push("contact compliance", "the metric is another");
        }
        if self.problem.obstacles.len() > 1 && self.has_friction() {
            let smooth = self
                .problem
                .obstacles
                .iter()
                .filter(|one| !one.is_frictional);
            for obstacle in smooth {
                push(&format!("friction of {}", obstacle.name), "it has none");
            }
        }
        if !self.problem.resolved.is_nonlinear() {
            push(
                "reassembly and refactorisation",
                "small strain, linear material",
            );
        }
        let has_values = !self.problem.resolved.body_force_values.is_zero();
        let has_force = self.problem.resolved.has_body_force() || has_values;
        if !has_force && self.problem.resolved.manufactured.is_none() {
            push("body force", "none given");
        }
        if !self.is_shifted() {
            push("rigid-mode shift", "supports hold the body");
        }
        entries
    }
}
