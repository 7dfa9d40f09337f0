//! What drives fluids: their pressures, which ramp as all of a drive does, by the rule of a step
//!
//! ```text
//! pressure = (1 - s) start + s end,   0 <= s <= 1
//! ```
//!
//! in the order of the plan. Pressures are in the caller's units.

use crate::plan::Plan;
use crate::scene::{FluidLoad, Step};

/// What drives one fluid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct FluidDrive {
    /// Its pressure, the caller's stress.
    pub(crate) pressure: f64,
    /// Whether the step looks for the pressure at which it leaks.
    pub(crate) to_blow_off: bool,
}

impl FluidDrive {
    /// At that pressure.
    fn at(pressure: f64) -> Self {
        Self {
            pressure,
            to_blow_off: false,
        }
    }
}

/// Where the first step leads fluids when it names none.
pub(crate) fn of_scene(plan: &Plan) -> Vec<FluidDrive> {
    let fluids = plan.problem.resolved.fluids.iter();
    fluids.map(|fluid| FluidDrive::at(fluid.pressure)).collect()
}

/// Fluids at the end of a step that starts from `before`.
pub(crate) fn after(before: &[FluidDrive], plan: &Plan, step: &Step) -> Vec<FluidDrive> {
    let all = before.iter().zip(&plan.problem.resolved.fluids);
    let ends = all.map(|(before, fluid)| {
        let target = step.fluids.iter().rfind(|one| one.name == fluid.name);
        let load = target.map_or(FluidLoad::To(before.pressure), |one| one.load);
        FluidDrive {
            pressure: load.pressure(),
            to_blow_off: matches!(load, FluidLoad::ToBlowOff(_)),
        }
    });
    ends.collect()
}

/// Fluids a fraction of the way to `end`.
pub(crate) fn towards(start: &[FluidDrive], end: &[FluidDrive], fraction: f64) -> Vec<FluidDrive> {
    let pairs = start.iter().zip(end);
    let mixed = pairs.map(|(start, end)| FluidDrive {
        pressure: start.pressure + fraction * (end.pressure - start.pressure),
        ..*end
    });
    mixed.collect()
}
