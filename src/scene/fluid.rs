//! Fluids that creep in between a body and its obstacles, and how steps drive them.

/// A fluid beside the body: its pressure acts, along the deformed outward normal, on what it has
/// reached of the surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Fluid {
    /// Name of the fluid, unique among fluids; steps and results refer to it.
    pub name: String,
    /// Names of the surface groups that it can reach, candidates for contact and free ones.
    pub on: Vec<String>,
    /// Names of the surface groups that are wet from the start.
    pub from: Vec<String>,
    /// Names of the surface groups that it must not reach.
    pub dry: Vec<String>,
    /// Pressure at the end of the first step, where that names none; stress, at least zero.
    pub pressure: f64,
    /// Contact pressure below which it enters from a wet neighbour.
    pub threshold: FluidThreshold,
    /// What becomes of it where the contact closes again.
    pub film: Film,
    /// Relative width to which the pressure at which it leaks is bracketed, in (0, 1/2].
    pub blow_off_tolerance: f64,
    /// Dynamic viscosity, stress times time: what flows through open gaps is told; none where it is not
    /// asked for.
    pub viscosity: Option<f64>,
}

impl Fluid {
    /// Blow-off is bracketed to this, relative, where a scene says nothing else.
    pub const BLOW_OFF_TOLERANCE: f64 = 0.01;
}

impl Default for Fluid {
    fn default() -> Self {
        Self {
            name: String::new(),
            on: Vec::new(),
            from: Vec::new(),
            dry: Vec::new(),
            pressure: 0.0,
            threshold: FluidThreshold::default(),
            film: Film::default(),
            blow_off_tolerance: Self::BLOW_OFF_TOLERANCE,
            viscosity: None,
        }
    }
}

/// Contact pressure below which a fluid enters.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum FluidThreshold {
    /// Its own pressure.
    #[default]
    Fluid,
    /// That pressure, stress; at zero it enters only where contact is lost.
    Pressure(f64),
}

/// What becomes of a fluid that is pressed more than it presses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Film {
    /// It stays where it has been.
    #[default]
    Stays,
    /// It leaves what is pressed on all sides.
    SqueezedOut,
}

impl Film {
    /// The name used in scenes.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stays => "stays",
            Self::SqueezedOut => "squeezed-out",
        }
    }
}

/// What a fluid shall do by the end of a step.
#[derive(Clone, Debug, PartialEq)]
pub struct FluidTarget {
    /// Name of the fluid.
    pub name: String,
    /// Where its pressure leads.
    pub load: FluidLoad,
}

/// Where the pressure of a fluid leads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FluidLoad {
    /// To that pressure, stress; the step fails where the fluid leaks before.
    To(f64),
    /// Up to the pressure at which it leaks, which ends the step well, or to that one at most.
    ToBlowOff(f64),
}

impl FluidLoad {
    /// The pressure at the end of the step, unless the fluid leaks before.
    pub fn pressure(self) -> f64 {
        match self {
            Self::To(pressure) | Self::ToBlowOff(pressure) => pressure,
        }
    }
}
