//! What a fluid does to the body, and how near it is to a leak.

use std::collections::BTreeMap;

/// Whether a fluid stays where it may be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tightness {
    /// It has not reached what must stay dry.
    #[default]
    Tight,
    /// Under a little more load it reaches what must stay dry, or another fluid.
    Leaks,
}

impl Tightness {
    /// The name used on the wire and in result lines.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tight => "tight",
            Self::Leaks => "leaks",
        }
    }
}

/// One fluid at the end of an increment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FluidResult {
    /// Pressure of the fluid, stress.
    pub pressure: f64,
    /// Whether it is tight.
    pub tightness: Tightness,
    /// Pressure at the last tight equilibrium and the least at which it was seen to leak `[2]`,
    /// stress; none where no leak was met.
    pub blow_off: Option<[f64; 2]>,
    /// Area that it wets: deformed for bodies of finite strain, undeformed for linear ones; within
    /// the facets of the front the part that it presses on.
    pub wet_area: f64,
    /// Force that it exerts on the body `[3]`.
    pub force: [f64; 3],
    /// The path on which it leaks first; none where nothing must stay dry, or it cannot get there.
    pub leak_path: Option<LeakPathResult>,
    /// The same for paths that pass one obstacle or lead through one contact between bodies alone,
    /// by its name.
    pub leak_paths: BTreeMap<String, LeakPathResult>,
    /// Solutions of the increment between which fluids have advanced.
    pub rounds: u32,
    /// Volume that flows in a unit of time for a unit of its pressure, per thickness in the plane,
    /// through what is open: at the state, or where it leaks in the state in which that was
    /// seen; zero where all ways are closed and it is tight, none without a viscosity and of a leak through
    /// contact that the fluid opens only by entering it.
    pub conductance: Option<f64>,
    /// The same under its pressure, where it leaks the least at which that was seen.
    pub flow_rate: Option<f64>,
}

/// A path along the surface from what is wet to what must stay dry.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LeakPathResult {
    /// Largest pressure between body and obstacles on the path, stress: the margin of tightness.
    pub margin: f64,
    /// That less the pressure of the fluid.
    pub margin_over_pressure: f64,
    /// Length of the path along which that pressure is above the fluid's.
    pub sealed_width: f64,
    /// Its points in the deformed body `[points][3]`.
    pub points: Vec<[f64; 3]>,
    /// Pressure between body and obstacles at the points, stress `[points]`.
    pub pressures: Vec<f64>,
}
