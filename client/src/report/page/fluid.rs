//! Fluids as the page shows them.

use std::collections::BTreeMap;

use serde::Serialize;

use super::lines::{Fluid, Step};

/// Points of a leak path that the picture draws at most.
const MOST_POINTS: usize = 2000;

/// A fluid in one increment.
#[derive(Debug, Serialize)]
pub(super) struct Wet {
    pressure: Option<f64>,
    leaks: bool,
    /// Pressures between which it leaks.
    bracket: Option<[f64; 2]>,
    margin: Option<f64>,
    over: Option<f64>,
    width: Option<f64>,
    area: Option<f64>,
    force: Vec<f64>,
    flow: Option<f64>,
}

/// A leak path of the increment that the picture shows.
#[derive(Debug, Serialize)]
pub(super) struct Leak {
    fluid: String,
    /// In the deformed body `[points][3]`.
    points: Vec<[f64; 3]>,
}

/// What the fluids do in one increment.
pub(super) fn wet(fluids: &BTreeMap<String, Fluid>) -> BTreeMap<String, Wet> {
    fluids
        .iter()
        .map(|(name, fluid)| (name.clone(), one(fluid)))
        .collect()
}

fn one(fluid: &Fluid) -> Wet {
    let path = fluid.leak_path.as_ref();
    Wet {
        pressure: fluid.pressure,
        leaks: fluid.tightness == "leaks",
        bracket: fluid
            .blow_off_low
            .zip(fluid.blow_off_high)
            .map(<[f64; 2]>::from),
        margin: path.and_then(|path| path.margin),
        over: path.and_then(|path| path.margin_over_pressure),
        width: path.and_then(|path| path.sealed_width),
        area: fluid.wet_area,
        force: fluid.force.clone(),
        flow: fluid.flow_rate,
    }
}

/// The leak paths of an increment; one that is too long to draw is left out.
pub(super) fn leaks(step: &Step) -> Vec<Leak> {
    let paths = step.fluids.iter().filter_map(|(name, fluid)| {
        let points = &fluid.leak_path.as_ref()?.points;
        (2..=MOST_POINTS).contains(&points.len()).then(|| Leak {
            fluid: name.clone(),
            points: points.clone(),
        })
    });
    paths.collect()
}
