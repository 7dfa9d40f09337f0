//! Fluids, and where steps lead their pressures.

use signorini_proto::v1;
use signorini_proto::v1::fluid_target::Load;

use super::body::name_of;
use super::keys::Keys;

const FLUID: &[&str] = &[
    "name",
    "on",
    "from",
    "dry",
    "pressure",
    "threshold",
    "film",
    "blow_off_tolerance",
    "viscosity",
];

const FILMS: &[(&str, v1::Film)] = &[
    ("stays", v1::Film::Stays),
    ("squeezed-out", v1::Film::SqueezedOut),
];

/// The word of the threshold that is the fluid's own pressure.
const OWN: &[(&str, ())] = &[("fluid", ())];

/// The word of a pressure that rises until the fluid leaks.
const TO_BLOW_OFF: &str = "to blow-off";

pub(super) fn fluids(scene: &Keys<'_>) -> Vec<v1::Fluid> {
    let tables = scene.tables("fluid", FLUID);
    let fluid = |(index, keys): (usize, &Keys<'_>)| v1::Fluid {
        name: name_of(keys, "fluid", index),
        on: keys.required_names("on"),
        from: keys.required_names("from"),
        dry: keys.names("dry"),
        pressure: keys.number("pressure"),
        threshold: threshold(keys),
        film: keys.choice("film", FILMS).map_or(0, i32::from),
        blow_off_tolerance: keys.number("blow_off_tolerance"),
        viscosity: keys.number("viscosity"),
    };
    tables.iter().enumerate().map(fluid).collect()
}

/// A number; none where it is the fluid's own pressure.
fn threshold(keys: &Keys<'_>) -> Option<f64> {
    if keys.has_text("threshold") {
        keys.choice("threshold", OWN);
        None
    } else {
        keys.number("threshold")
    }
}

/// Where a step leads the pressures of fluids.
pub(super) fn targets(step: &Keys<'_>) -> Vec<v1::FluidTarget> {
    let tables = step.named_tables("fluid");
    let target = |(name, keys): (String, Keys<'_>)| {
        keys.check(&["pressure", "up_to"]);
        let load = load(&keys);
        v1::FluidTarget { name, load }
    };
    tables.into_iter().map(target).collect()
}

fn load(keys: &Keys<'_>) -> Option<Load> {
    keys.require("pressure");
    if !keys.has_text("pressure") {
        if keys.has("up_to") {
            let message = format!("goes with pressure = \"{TO_BLOW_OFF}\" only; leave it out");
            keys.fault("up_to", message);
        }
        return keys.number("pressure").map(Load::Pressure);
    }
    keys.choice("pressure", &[(TO_BLOW_OFF, ())])?;
    if !keys.has("up_to") {
        let message = "required key is missing: the pressure at which the step ends where the \
                       fluid does not leak before";
        keys.fault("up_to", message);
    }
    keys.number("up_to").map(Load::ToBlowOff)
}
