//! Pressures with the tractions of dry friction that they allow:
//!
//! ```text
//! n_i >= 0,   |t_i| <= r_i(n_i),   r = mu n (Coulomb), or min(b, k n) of a given bound b (Tresca)
//! ```
//!
//! Tresca's bound acts where there is pressure. A step from zero to b has no state where the
//! point opens under b and closes without; with a steep k, which stands for any, it has one with
//! next to no pressure, and a traction in between that opposes the slip.
//!
//! The pressures come first, then the tractions, those of a point side by side; a pressure
//! without friction has no point. Pressure and traction answer to residuals of their own, gap
//! and slip: the slip is against the traction and lifts nothing off, so that the law is not
//! that of the cone's normals, and the problem over the set has no energy.

use crate::linalg::vector::norm;

use super::{
    Admissible, AdmissibleSet, Components, Discs, Kind, NonNegative, SetPart, SetPoint, Status,
};

/// Share of the radius below which a traction is not on the edge.
const INSIDE: f64 = 1.0 - 1e-8;

/// k, the bound over the pressure that makes all of it: a billionth of the bound is next to none.
const STEEPNESS: f64 = 1e9;

/// How far a traction may go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FrictionBound {
    /// That many times the pressure.
    Coulomb(f64),
    /// That much wherever there is pressure, in the unit of the multipliers.
    Tresca(f64),
}

impl FrictionBound {
    /// Largest traction under a pressure.
    pub fn radius(self, pressure: f64) -> f64 {
        match self {
            Self::Coulomb(coefficient) => coefficient * pressure.max(0.0),
            Self::Tresca(bound) => bound.min(STEEPNESS * pressure.max(0.0)),
        }
    }

    /// Growth of the largest traction with a pressure that is there.
    pub fn slope(self, pressure: f64) -> f64 {
        match self {
            Self::Coulomb(coefficient) => coefficient,
            Self::Tresca(_) if self.is_between(pressure) => STEEPNESS,
            Self::Tresca(_) => 0.0,
        }
    }

    /// Whether a pressure is next to none, so that it makes less than the bound.
    pub fn is_between(self, pressure: f64) -> bool {
        match self {
            Self::Coulomb(_) => false,
            Self::Tresca(bound) => pressure > 0.0 && STEEPNESS * pressure < bound,
        }
    }

    /// The pressure after a change by `change` of largest traction and pressure together, one
    /// after the other: where there is next to no pressure the traction moves the gap.
    /// `traction` tells a pressure below zero that next to none has led to, which is off.
    pub fn moved(self, (pressure, traction): (f64, f64), change: f64) -> f64 {
        let Self::Tresca(bound) = self else {
            return pressure + change;
        };
        let most = bound / STEEPNESS;
        let is_pressed = pressure >= most || traction < -0.5 * STEEPNESS * pressure;
        let from = if is_pressed {
            bound + (pressure - most)
        } else {
            STEEPNESS * pressure
        };
        let to = from + change;
        if to < bound {
            to / STEEPNESS
        } else {
            most + (to - bound)
        }
    }
}

/// Pressures and tractions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cones<'a> {
    /// Number of pressures.
    pub normals: usize,
    /// The pressure of each point `[points]`.
    pub partners: &'a [u32],
    /// How far the traction of each point may go `[points]`.
    pub bounds: &'a [FrictionBound],
    /// Numbers of a point's traction.
    pub components: Components,
}

impl<'a> Cones<'a> {
    /// Largest traction of each point under `pressures` `[points]`.
    pub fn radii(&self, pressures: &[f64]) -> Vec<f64> {
        let points = self.partners.iter().zip(self.bounds);
        let radius = |(&partner, bound): (&u32, &FrictionBound)| {
            // Compared first, so that what is not a number stays so.
            let pressure = pressures[partner as usize];
            if pressure.is_nan() {
                f64::NAN
            } else {
                bound.radius(pressure)
            }
        };
        points.map(radius).collect()
    }

    /// Each point with its pressure, its bound and the first of its multipliers.
    pub fn points(&self) -> impl Iterator<Item = (usize, FrictionBound, usize)> + 'a {
        let (first, width) = (self.normals, self.components.count());
        let points = self.partners.iter().zip(self.bounds).enumerate();
        points.map(move |(point, (&partner, &bound))| {
            (partner as usize, bound, first + point * width)
        })
    }

    /// Pressures and tractions apart, the tractions on discs of given `radii` `[points]`.
    pub fn with_given(&self, radii: &'a [f64]) -> [SetPart<'a>; 2] {
        let discs = AdmissibleSet::Discs(self.discs(radii));
        [
            SetPart {
                size: self.normals,
                set: AdmissibleSet::NonNegative,
            },
            SetPart {
                size: radii.len() * self.components.count(),
                set: discs,
            },
        ]
    }

    /// The discs of the tractions under given pressures.
    fn discs<'r>(&self, radii: &'r [f64]) -> Discs<'r> {
        Discs {
            radii,
            components: self.components,
        }
    }
}

impl Admissible for Cones<'_> {
    fn project(&self, x: &mut [f64]) {
        let (normal, tangential) = x.split_at_mut(self.normals);
        NonNegative.project(normal);
        let radii = self.radii(normal);
        self.discs(&radii).project(tangential);
    }

    fn status(&self, x: &[f64], status: &mut [Status]) {
        let (normal, tangential) = x.split_at(self.normals);
        let (of_normal, of_tangential) = status.split_at_mut(self.normals);
        NonNegative.status(normal, of_normal);
        let radii = self.radii(normal);
        self.discs(&radii).status(tangential, of_tangential);
    }

    /// A status that the bounds do not bear out, since they or the pressures have changed,
    /// leaves all of the slip.
    fn misfit(&self, at: SetPoint<'_>, misfit: &mut [f64]) {
        let (normal, tangential) = at.split(self.normals);
        let (of_normal, of_tangential) = misfit.split_at_mut(self.normals);
        NonNegative.misfit(normal, of_normal);
        let radii = self.radii(normal.multiplier);
        self.discs(&radii).misfit(tangential, of_tangential);
        let width = self.components.count();
        for (point, &radius) in radii.iter().enumerate() {
            let own = point * width..(point + 1) * width;
            let is_inside = norm(&tangential.multiplier[own.clone()]) < radius * INSIDE;
            if is_inside && tangential.status[own.start] != Status::Stick {
                of_tangential[own.clone()].copy_from_slice(&tangential.residual[own]);
            }
        }
    }

    /// With the discs of the present pressures.
    fn longest_step(&self, x: &[f64], direction: &[f64]) -> f64 {
        let (normal, tangential) = x.split_at(self.normals);
        let (of_normal, of_tangential) = direction.split_at(self.normals);
        let radii = self.radii(normal);
        let step = self.discs(&radii).longest_step(tangential, of_tangential);
        step.min(NonNegative.longest_step(normal, of_normal))
    }

    fn kind(&self) -> Kind<'_> {
        Kind::Cones(*self)
    }
}
