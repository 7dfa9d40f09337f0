//! The method for contact and the metric of its pressure: which and why.
//!
//! One level in the compliance costs least wherever the compliance, a dense matrix
//! on all candidate vertices, can be made. Where it cannot, proportioning with the
//! lumped mass takes over, which holds nothing dense. Both rest on the number of
//! candidates alone.

use crate::scene::{ContactMethod, MetricKind, Named, SolverOptions, Violation};

/// Bytes of dense matrices that a metric may take.
const MOST_DENSE: f64 = 1.5e9;
/// Bytes of a metric, its part on a face and that part's factor, for each pair of rows.
const OWN_BYTES: f64 = 24.0;
/// Bytes of the inverse of A11 on the candidates beside its factor, for each pair of unknowns.
const INVERSE_BYTES: f64 = 16.0;
/// Candidates of the largest fractional metric, whose cost grows fastest.
const MOST_FRACTIONAL: u64 = 4000;
/// A choice with its reason.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct ContactChoice {
    /// The method for contact.
    pub(crate) method: ContactMethod,
    /// The metric in which the method steps the contact pressure.
    pub(crate) metric: MetricKind,
    /// Why these were chosen, as a phrase that a plan shows.
    pub(crate) reason: String,
}

/// What the choice rests on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactSizes {
    /// Dimension of the body: 2 or 3.
    pub(crate) dimension: u64,
    /// Number of contact multipliers of all obstacles.
    pub(crate) multipliers: u64,
    /// Number of vertices of candidate faces, each once.
    pub(crate) vertices: u64,
    /// Whether some multipliers have no bound: of supports along normals and of ties.
    pub(crate) has_guides: bool,
    /// Whether only one level serves: rigid modes that only contact holds, guides or friction.
    pub(crate) needs_one_level: bool,
    /// Whether tractions of friction are among the multipliers.
    pub(crate) is_frictional: bool,
    /// Vertices that the compliance knows where these are not all.
    pub(crate) known: Option<u64>,
}

impl ContactSizes {
    /// How many vertices the compliance may know where it cannot know all; none where it can,
    /// and with friction, whose tractions are asked for by entries.
    pub(crate) fn vertices_to_know(self) -> Option<usize> {
        let is_large = self.dense_bytes(MetricKind::Compliance) > MOST_DENSE;
        (is_large && !self.is_frictional).then(|| {
            let each = OWN_BYTES + INVERSE_BYTES * (self.dimension as f64).powi(2);
            (MOST_DENSE / each).sqrt() as usize
        })
    }

    /// Bytes of the dense matrices of a metric at their peak.
    pub(crate) fn dense_bytes(self, metric: MetricKind) -> f64 {
        if let (Some(known), MetricKind::Compliance) = (self.known, metric) {
            let side = self.dimension as f64;
            return (OWN_BYTES + INVERSE_BYTES * side * side) * (known as f64).powi(2);
        }
        let square = |n: u64| (n as f64).powi(2);
        // The metric, its part on a face and that part's factor; quadratic multipliers
        // without friction have theirs on the vertices.
        let is_split = !self.is_frictional && 2 * self.vertices <= self.multipliers;
        let rows = match metric {
            MetricKind::Compliance if is_split => self.vertices,
            MetricKind::Compliance | MetricKind::Mass | MetricKind::Fractional => self.multipliers,
        };
        let own = OWN_BYTES * square(rows);
        match metric {
            // And the inverse of A11 on the candidates beside its factor.
            MetricKind::Compliance => own + INVERSE_BYTES * square(self.dimension * self.vertices),
            MetricKind::Mass | MetricKind::Fractional => own,
        }
    }

    /// Whether the dense matrices of the method in that metric fit their bounds of
    /// memory and work.
    pub(super) fn fits(self, method: ContactMethod, metric: MetricKind) -> bool {
        let is_small = metric != MetricKind::Fractional || self.multipliers <= MOST_FRACTIONAL;
        !method.needs_dense(metric) || (is_small && self.dense_bytes(metric) <= MOST_DENSE)
    }
}

/// Chooses by what `options` ask for.
///
/// # Errors
/// When the metric is too large, with the numbers.
pub(crate) fn choose(
    options: &SolverOptions,
    sizes: ContactSizes,
) -> Result<ContactChoice, Violation> {
    let asked = options.contact.named();
    let asked_metric = options.contact_metric.named();
    if sizes.is_frictional {
        check_frictional(asked, asked_metric)?;
    }
    if sizes.has_guides {
        check_guided(asked, asked_metric)?;
    }
    let method = asked.unwrap_or(ContactMethod::OneLevel);
    let metric = asked_metric.unwrap_or(method.natural_metric());
    if sizes.fits(method, metric) {
        return Ok(ContactChoice {
            method,
            metric,
            reason: match sizes.known {
                Some(known) => format!(
                    "{}; the compliance knows the {known} vertices nearest to the tools",
                    reason(asked, asked_metric)
                ),
                None => reason(asked, asked_metric),
            },
        });
    }
    let cost = format!(
        "{} candidates: a dense {} metric takes {:.1} GB",
        sizes.multipliers,
        metric.name(),
        1e-9 * sizes.dense_bytes(metric)
    );
    let may_turn = matches!(asked, None | Some(ContactMethod::Mprgp));
    if may_turn && asked_metric.is_none() && !sizes.needs_one_level {
        return Ok(ContactChoice {
            method: ContactMethod::Mprgp,
            metric: MetricKind::Mass,
            reason: format!("{cost}, the lumped mass none"),
        });
    }
    let path = match (asked_metric, asked) {
        (Some(_), _) => "solver.contact_metric",
        (None, Some(_)) => "solver.contact",
        (None, None) => "obstacle",
    };
    Err(Violation {
        path: path.to_owned(),
        message: format!(
            "{cost}; `mprgp` in the metric `mass` takes none, on a body that supports hold"
        ),
    })
}

/// Whether a method solves for tractions of friction.
fn knows_friction(method: Option<ContactMethod>) -> bool {
    matches!(
        method,
        None | Some(
            ContactMethod::OneLevel
                | ContactMethod::ThresholdIteration
                | ContactMethod::RegularisedFriction
        )
    )
}

/// Friction is solved on one level in the compliance only.
///
/// # Errors
/// For any other method or metric.
fn check_frictional(
    method: Option<ContactMethod>,
    metric: Option<MetricKind>,
) -> Result<(), Violation> {
    let path = match (knows_friction(method), metric) {
        (true, None | Some(MetricKind::Compliance)) => return Ok(()),
        (true, Some(_)) => "solver.contact_metric",
        (false, _) => "solver.contact",
    };
    Err(Violation {
        path: path.to_owned(),
        message: "friction is solved by `one-level`, and to compare with by `threshold-iteration` and `regularised-friction`, in the metric `compliance` only".to_owned(),
    })
}

/// Refuses what stagnates where multipliers have no bound: steps of gradients and metrics that do not
/// know how stiff the body is.
fn check_guided(
    method: Option<ContactMethod>,
    metric: Option<MetricKind>,
) -> Result<(), Violation> {
    let path = match (method, metric) {
        (Some(ContactMethod::Mprgp), _) => "solver.contact",
        (_, Some(MetricKind::Mass | MetricKind::Fractional)) => "solver.contact_metric",
        _ => return Ok(()),
    };
    Err(Violation {
        path: path.to_owned(),
        message: "ties and supports along normals are solved by `one-level` in the metric `compliance` only".to_owned(),
    })
}

/// Why a choice that the scene made, in whole or in part, is what it is.
fn reason(asked: Option<ContactMethod>, metric: Option<MetricKind>) -> String {
    match (asked, metric) {
        (None, None) => "forces, volumes and contact in one iteration",
        (None, Some(_)) => "metric asked for",
        (Some(_), None) => "method asked for, in its usual metric",
        (Some(_), Some(_)) => "asked for",
    }
    .to_owned()
}

impl ContactChoice {
    /// Method and metric in words.
    pub(crate) fn describe(&self) -> String {
        let method = match self.method {
            ContactMethod::OneLevel => "one level",
            ContactMethod::ActiveSet => "primal-dual active set, each set solved to the end",
            ContactMethod::Nested => "nested, projected steps with secant corrections",
            ContactMethod::Mprgp => "nested, proportioning with reduced gradient projection",
            ContactMethod::ConjugateProjectedGradient => "nested, conjugate projected gradient",
            ContactMethod::ProjectedArrowHurwicz => "nested, projected Arrow-Hurwicz steps",
            ContactMethod::ThresholdIteration => {
                "one level, iteration on the threshold of friction"
            }
            ContactMethod::RegularisedFriction => "one level, friction by springs on the slip",
        };
        let is_dense = self.method.needs_dense(self.metric);
        let metric = match self.metric {
            MetricKind::Compliance => "dense compliance metric",
            MetricKind::Mass if is_dense => "consistent mass metric",
            MetricKind::Mass => "lumped mass metric",
            MetricKind::Fractional => "dense fractional metric",
        };
        format!("{method}, {metric}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A body with that many candidates, held by supports.
    fn body(multipliers: u64) -> ContactSizes {
        ContactSizes {
            dimension: 3,
            multipliers,
            vertices: multipliers,
            has_guides: false,
            needs_one_level: false,
            is_frictional: false,
            known: None,
        }
    }

    fn asked(contact: &str, contact_metric: &str) -> SolverOptions {
        SolverOptions {
            contact: contact.parse().expect("a method"),
            contact_metric: contact_metric.parse().expect("a metric"),
            ..SolverOptions::default()
        }
    }

    fn chosen(options: &SolverOptions, sizes: ContactSizes) -> (ContactMethod, MetricKind) {
        let choice = choose(options, sizes).expect("a choice");
        (choice.method, choice.metric)
    }

    #[test]
    fn one_level_in_the_compliance_serves_up_to_some_thousand_candidates() {
        let one_level = (ContactMethod::OneLevel, MetricKind::Compliance);
        for size in [0, 1, 500, 2500] {
            assert_eq!(chosen(&asked("auto", "auto"), body(size)), one_level);
        }
    }

    #[test]
    fn quadratic_multipliers_cost_what_their_vertices_do() {
        let quadratic = |vertices| ContactSizes {
            multipliers: 4 * vertices,
            ..body(vertices)
        };
        let one_level = (ContactMethod::OneLevel, MetricKind::Compliance);
        assert_eq!(chosen(&asked("auto", "auto"), quadratic(2900)), one_level);
        let frictional = ContactSizes {
            is_frictional: true,
            ..quadratic(2900)
        };
        assert!(frictional.dense_bytes(MetricKind::Compliance) > MOST_DENSE);
    }

    #[test]
    fn beyond_them_nothing_dense_is_held_and_the_plan_says_why() {
        for method in ["auto", "mprgp"] {
            for size in [5000, 20_000, u64::from(u32::MAX)] {
                let choice = choose(&asked(method, "auto"), body(size)).expect("a choice");
                assert!(!choice.method.needs_dense(choice.metric));
                assert!(choice.reason.contains("GB"), "{}", choice.reason);
                assert!(choice.describe().contains("lumped mass"));
            }
        }
    }

    #[test]
    fn a_dense_metric_that_does_not_fit_is_refused_with_its_size() {
        let cases = [
            (asked("one-level", "auto"), "solver.contact"),
            (asked("auto", "compliance"), "solver.contact_metric"),
            (asked("auto", "fractional"), "solver.contact_metric"),
            (asked("mprgp", "compliance"), "solver.contact_metric"),
            (asked("projected-arrow-hurwicz", "auto"), "solver.contact"),
        ];
        for (options, path) in cases {
            let fault = choose(&options, body(20_000)).expect_err("too large");
            assert_eq!(fault.path, path);
            assert!(fault.message.contains("GB"), "{}", fault.message);
        }
        let floating = ContactSizes {
            needs_one_level: true,
            ..body(20_000)
        };
        let fault = choose(&asked("auto", "auto"), floating).expect_err("too large");
        assert_eq!(fault.path, "obstacle");
    }

    #[test]
    fn ties_are_solved_in_the_compliance_only() {
        let tied = ContactSizes {
            has_guides: true,
            needs_one_level: true,
            ..body(100)
        };
        let cases = [
            (asked("mprgp", "auto"), "solver.contact"),
            (asked("auto", "mass"), "solver.contact_metric"),
            (asked("one-level", "fractional"), "solver.contact_metric"),
        ];
        for (options, path) in cases {
            let fault = choose(&options, tied).expect_err("refused");
            assert_eq!(fault.path, path);
        }
        assert!(choose(&asked("one-level", "compliance"), tied).is_ok());
    }

    #[test]
    fn every_method_has_a_metric_that_it_takes() {
        for &method in ContactMethod::ALL {
            let (taken, metric) = chosen(&asked(method.name(), "auto"), body(100));
            assert_eq!(taken, method);
            assert!(method.takes(metric));
        }
    }
}
