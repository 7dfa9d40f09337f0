//! Whether fluids leak, and how bodies touch each other, in words.

use signorini_proto::v1;

use super::Lines;
use crate::terminal::text::{number, vector};

/// What each fluid does, and how near it is to a leak.
pub(super) fn fluids(lines: &mut Lines, report: &v1::StepReport) {
    for (name, fluid) in &report.fluids {
        lines.add(&format!("fluid {name}"), &verdict(fluid));
        if let Some(path) = &fluid.leak_path {
            lines.add("", &margin(path));
        }
        let (area, force) = (number(fluid.wet_area), vector(&fluid.force));
        let rounds = match fluid.rounds {
            0 | 1 => String::new(),
            more => format!(", its front found in {more} rounds"),
        };
        lines.add("", &format!("wet area {area}, force {force}{rounds}"));
        if let Some((rate, conductance)) = fluid.flow_rate.zip(fluid.conductance) {
            let told = [rate, conductance].map(number);
            lines.add(
                "",
                &format!("flow rate {}, {} for a unit of pressure", told[0], told[1]),
            );
        }
    }
}

/// What bodies do to each other.
pub(super) fn contacts(lines: &mut Lines, report: &v1::StepReport) {
    for (name, contact) in &report.contacts {
        let force = format!("force {}", vector(&contact.force));
        lines.add(&format!("contact {name}"), &force);
        let said = match contact.mean_pressure {
            None => "no contact".to_owned(),
            Some(mean) => format!(
                "width {}, mean pressure {}, largest {} at {}",
                number(contact.contact_width),
                number(mean),
                number(contact.peak_pressure),
                vector(&contact.peak_pressure_place)
            ),
        };
        lines.add("", &said);
        if let Some(friction) = &contact.friction {
            let said = format!(
                "friction force {}, {} stick, {} slip by {} at most, {} open, {} dissipated",
                vector(&friction.tangential_force),
                friction.stick_vertices,
                friction.slip_vertices,
                number(friction.max_slip),
                friction.open_vertices,
                number(friction.dissipated_total)
            );
            lines.add("", &said);
        }
    }
}

/// What ties carry.
pub(super) fn ties(lines: &mut Lines, report: &v1::StepReport) {
    for (name, tie) in &report.ties {
        let (force, moment) = (vector(&tie.force), vector(&tie.moment));
        lines.add(
            &format!("tie {name}"),
            &format!("force {force}, moment {moment}"),
        );
        let [peak, place] = [number(tie.peak_traction), vector(&tie.peak_traction_place)];
        lines.add("", &format!("largest traction {peak} at {place}"));
    }
}

/// `tight`, or the pressures between which it leaks.
pub(super) fn verdict(fluid: &v1::FluidResult) -> String {
    let pressure = number(fluid.pressure);
    match (fluid.tightness(), fluid.blow_off_low, fluid.blow_off_high) {
        (v1::Tightness::Leaks, Some(low), Some(high)) => {
            format!(
                "leaks between pressures {} and {}",
                number(low),
                number(high)
            )
        }
        (v1::Tightness::Leaks, _, _) => format!("leaks at pressure {pressure}"),
        (v1::Tightness::Tight | v1::Tightness::Unspecified, _, _) => {
            format!("tight at pressure {pressure}")
        }
    }
}

fn margin(path: &v1::LeakPath) -> String {
    let (margin, over) = (number(path.margin), number(path.margin_over_pressure));
    let width = number(path.sealed_width);
    format!(
        "margin {margin}, {over} above its pressure, which contact exceeds over a width of {width}"
    )
}
