//! What is tried where the plan's own method does not solve an increment, and the plans
//! that say so: the same decisions but for one.
//!
//! A scene that names a method keeps to it. The factor of the assembled saddle point is
//! there up to a bound on its work.

use super::contact::{ContactChoice, ContactSizes};
use super::{Plan, estimate};
use crate::report::Fallback;
use crate::scene::{ContactMethod, ElementKind, MetricKind};

/// How the linear systems of programs are solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Programs {
    /// By the methods that the plan names.
    AsPlanned,
    /// By a factor of the assembled saddle point.
    Factorised,
}

impl Plan {
    /// The rungs that there are for this scene, in the order in which they are tried.
    pub(crate) fn rungs(&self) -> Vec<Fallback> {
        let mut rungs = Fallback::ALL.to_vec();
        rungs.retain(|&rung| self.has_rung(rung));
        rungs
    }

    /// Whether a rung is there and other than what the plan does anyhow.
    fn has_rung(&self, rung: Fallback) -> bool {
        let contacts = self.normal_multipliers();
        let takes_turns = contacts > 0
            && !self.resolved.is_rubber()
            && !self.is_floating()
            && self.guided_multipliers == 0;
        self.leaves_methods_open()
            && match rung {
                Fallback::MassMetric => {
                    takes_turns
                        && self.contact.metric != MetricKind::Mass
                        && self
                            .contact_sizes()
                            .fits(ContactMethod::OneLevel, MetricKind::Mass)
                }
                Fallback::Mprgp => takes_turns && self.contact.method != ContactMethod::Mprgp,
                Fallback::Direct => {
                    estimate::saddle_factor(self.units.dimension, self.unknowns).1
                        <= estimate::MOST_FACTOR_FLOPS
                }
            }
    }

    /// Krylov iterations that cost as much as a factor of the body with the compliance of its
    /// contact; none of a linear body without contact, where the scene names a method or the factor
    /// is large.
    pub(crate) fn factor_cost(&self) -> Option<u32> {
        let has_programs = self.resolved.is_rubber() || self.unknowns.contact > 0;
        let takes_one = has_programs
            && self.element == ElementKind::TaylorHood
            && self.names_no_method()
            && self.contact.method == ContactMethod::OneLevel;
        let price = estimate::factor_cost(self.units.dimension, self.unknowns);
        price.filter(|_| takes_one)
    }

    /// Whether the scene leaves all methods to the plan.
    fn leaves_methods_open(&self) -> bool {
        self.element == ElementKind::TaylorHood && !self.has_friction() && self.names_no_method()
    }

    /// Whether the scene names no method of linear systems or contact.
    pub(super) fn names_no_method(&self) -> bool {
        let options = &self.scene.solver;
        options.contact.named().is_none()
            && options.contact_metric.named().is_none()
            && options.saddle.named().is_none()
            && options.p1_solver.named().is_none()
            && options.displacement_preconditioner.named().is_none()
    }

    fn contact_sizes(&self) -> ContactSizes {
        ContactSizes {
            dimension: self.units.dimension as u64,
            multipliers: self.unknowns.contact,
            vertices: self.contact_vertices.len() as u64,
            needs_one_level: false,
            is_rough: self.has_friction(),
            known: None,
        }
    }

    /// The plan on a rung.
    pub(crate) fn on_rung(&self, rung: Fallback) -> Self {
        let mut other = self.clone();
        let mut contact = |method, metric| {
            other.contact = ContactChoice {
                method,
                metric,
                reason: "second attempt".to_owned(),
            };
        };
        match rung {
            Fallback::MassMetric => {
                contact(ContactMethod::OneLevel, MetricKind::Mass);
            }
            Fallback::Mprgp => {
                let metric = match self.contact.metric {
                    MetricKind::Compliance => MetricKind::Compliance,
                    MetricKind::Mass | MetricKind::Fractional => MetricKind::Mass,
                };
                contact(ContactMethod::Mprgp, metric);
            }
            Fallback::Direct => other.programs = Programs::Factorised,
        }
        other
    }

    /// What is tried after the plan's own method, in words; none where nothing is.
    pub(super) fn second_attempt(&self) -> Option<String> {
        let words = self.rungs().into_iter().map(|rung| match rung {
            Fallback::MassMetric => "the mass metric".to_owned(),
            Fallback::Mprgp => "proportioning".to_owned(),
            Fallback::Direct => format!(
                "a factor of the saddle point ({:.1} GB while it is there)",
                1e-9 * estimate::saddle_factor(self.units.dimension, self.unknowns).0
            ),
        });
        let words: Vec<String> = words.collect();
        (!words.is_empty()).then(|| words.join(", then "))
    }
}
