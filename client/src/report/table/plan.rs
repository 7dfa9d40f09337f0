//! A plan: what is built, what is left out and why.

use signorini_proto::{v1, words};

use super::Lines;
use crate::terminal::text::{bytes, number};

/// The lines of a plan.
pub(crate) fn plan(plan: &v1::Plan) -> String {
    let mut lines = Lines::default();
    let kind = words::scene_kind(plan.kind());
    let formulation = words::formulation(plan.formulation());
    lines.add("scene", &format!("{} ({kind}, {formulation})", plan.name));
    lines.add("unknowns", &unknowns(plan.unknowns.as_ref()));
    for entry in &plan.decisions {
        lines.add(&entry.what, &reasoned(&entry.choice, &entry.reason));
    }
    left_out(&mut lines, plan);
    lines.add("predicted memory", &bytes(plan.predicted_bytes));
    let gigaflop = plan.predicted_factor_flops * 1e-9;
    lines.add(
        "predicted work",
        &format!(
            "{} GFlop to factorise, {} preconditioner applications a step",
            number(gigaflop),
            plan.predicted_applications
        ),
    );
    for one in &plan.constants {
        let file = one.file.trim_start_matches("src/").trim_end_matches(".rs");
        lines.add(
            &one.name,
            &format!("{}: {} ({file})", one.value, one.meaning),
        );
    }
    lines.0
}

fn reasoned(choice: &str, reason: &str) -> String {
    if reason.is_empty() {
        choice.to_owned()
    } else {
        format!("{choice}: {reason}")
    }
}

pub(super) fn left_out(lines: &mut Lines, plan: &v1::Plan) {
    for entry in &plan.left_out {
        lines.add("left out", &reasoned(&entry.what, &entry.reason));
    }
}

/// Unknowns by kind.
pub(super) fn unknowns(unknowns: Option<&v1::Unknowns>) -> String {
    let unknowns = unknowns.copied().unwrap_or_default();
    let (displacement, pressure, contact) =
        (unknowns.displacement, unknowns.pressure, unknowns.contact);
    format!("{displacement} displacement, {pressure} pressure, {contact} contact")
}
