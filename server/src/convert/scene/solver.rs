//! The options of the solver: methods by their names.

use signorini::scene::{Choice, Named, SolverOptions, ToleranceRule, UnknownName};
use signorini_proto::v1 as wire;

use super::super::Faults;

pub(super) fn solver(message: wire::SolverOptions, faults: &mut Faults) -> SolverOptions {
    let default = SolverOptions::default();
    let tolerance_rule = tolerance_rule(message.tolerance_rule, faults);
    SolverOptions {
        tolerance: message.tolerance.unwrap_or(default.tolerance),
        tolerance_rule,
        error_estimate: method(&message.error_estimate, "error_estimate", faults),
        element: method(&message.element, "element", faults),
        displacement_preconditioner: method(
            &message.displacement_preconditioner,
            "displacement_preconditioner",
            faults,
        ),
        p1_solver: method(&message.p1_solver, "p1_solver", faults),
        saddle: method(&message.saddle, "saddle", faults),
        contact: method(&message.contact, "contact", faults),
        contact_metric: method(&message.contact_metric, "contact_metric", faults),
        contact_space: method(&message.contact_space, "contact_space", faults),
        stability: method(&message.stability, "stability", faults),
        on_instability: method(&message.on_instability, "on_instability", faults),
        response: method(&message.response, "response", faults),
        report: method(&message.report, "report", faults),
        quadrature_degree: message.quadrature_degree.map(|degree| {
            // The library's range check names a negative degree as zero.
            u32::try_from(degree).unwrap_or(0)
        }),
        max_wall_time: message.max_wall_time,
        penalty: message.penalty,
        verify: message.verify,
    }
}

/// The method of that name; empty leaves the choice to the plan.
fn method<T: Named>(name: &str, key: &str, faults: &mut Faults) -> Choice<T> {
    let path = format!("solver.{key}");
    let name = faults.name(name, &path);
    if name.is_empty() {
        return Choice::Auto;
    }
    name.parse().unwrap_or_else(|unknown: UnknownName| {
        faults.misnamed(path, unknown.to_string());
        Choice::Auto
    })
}

fn tolerance_rule(number: i32, faults: &mut Faults) -> ToleranceRule {
    match wire::ToleranceRule::try_from(number) {
        Ok(wire::ToleranceRule::Unspecified) => ToleranceRule::Fixed,
        Ok(wire::ToleranceRule::Discretisation) => ToleranceRule::Discretisation,
        Err(_) => {
            let message = format!("rule number {number} is not known here");
            faults.later("solver.tolerance", message);
            ToleranceRule::Fixed
        }
    }
}

#[cfg(test)]
mod tests {
    use signorini::scene::ErrorEstimate;

    use super::*;
    use crate::fault::Fault;

    #[test]
    fn tolerance_rules_arrive_and_unknown_ones_are_refused() {
        let convert = |tolerance_rule: i32| {
            let message = wire::SolverOptions {
                tolerance_rule,
                error_estimate: "off".into(),
                ..Default::default()
            };
            let mut faults = Faults::default();
            let found = solver(message, &mut faults);
            faults.outcome().map(|()| found)
        };
        let fixed = convert(0).expect("the default rule");
        assert_eq!(fixed.tolerance_rule, ToleranceRule::Fixed);
        assert_eq!(fixed.error_estimate, Choice::Named(ErrorEstimate::Off));
        let other = convert(wire::ToleranceRule::Discretisation.into()).expect("a known rule");
        assert_eq!(other.tolerance_rule, ToleranceRule::Discretisation);
        assert!(matches!(convert(7), Err(Fault::Unsupported(_))));
    }
}
