//! Pressures with the tractions of dry friction that they allow:
//!
//! ```text
//! n_i >= 0,   |t_i| <= r_i(n_i),   r = mu n (Coulomb), or a given bound where n > 0 (Tresca)
//! ```
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
            Self::Tresca(bound) if pressure > 0.0 => bound,
            Self::Tresca(_) => 0.0,
        }
    }

    /// Growth of the largest traction with a pressure that is there.
    pub fn slope(self) -> f64 {
        match self {
            Self::Coulomb(coefficient) => coefficient,
            Self::Tresca(_) => 0.0,
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
