//! What fluids do to the body at a state, and the paths on which they leak first.
//!
//! The pressure between a body and what touches it at a node is that of contact and fluid together,
//!
//! ```text
//! t = sum over nodes of (l_j + q s_j) psi_j
//! ```
//!
//! s_j how much of it is wet, in the caller's units. Cost: two sorts of the surface's nodes an obstacle.

use std::borrow::Cow;
use std::collections::BTreeMap;

use crate::fluid::across::joined;
use crate::fluid::leak_path::{Barrier, LeakPath};
use crate::fluid::surface::FluidSurface;
use crate::geometry::vector3::{norm, scale, sub};
use crate::model::Model;
use crate::model::ending::Ending;
use crate::model::fluids::{barred, fluid_load};
use crate::model::nodal_contact::{NodalContact, OneContact, contacts};
use crate::model::open_gap;
use crate::model::state::State;
use crate::report::{FluidResult, LeakPathResult, Tightness};

/// Results of all fluids by name; none without fluids.
pub(crate) fn results(
    model: &Model<'_>,
    state: &State,
    ending: &Ending,
    rounds: u32,
) -> BTreeMap<String, FluidResult> {
    let fluids = &model.plan.problem.resolved.fluids;
    if fluids.is_empty() {
        return BTreeMap::new();
    }
    let contacts = contacts(model, state);
    let across = NodalContact::of(model, &contacts);
    let all = fluids.iter().enumerate().map(|(index, fluid)| {
        let one = One::new((model, state), index, (&contacts, &across));
        let leak = ending.leak.filter(|leak| leak.fluid == index);
        let units = &model.plan.problem.units;
        let (force, area) = fluid_load(model, state, index);
        let conductance = match leak {
            // Without an open way nobody knows yet what it will let through.
            Some(leak) => leak.conductance.filter(|flow| *flow > 0.0),
            None => open_gap::conductance(model, state, index),
        };
        let driving = leak.map_or(one.pressure, |leak| leak.pressures[1]);
        let result = FluidResult {
            pressure: one.pressure,
            tightness: leak.map_or(Tightness::Tight, |_| Tightness::Leaks),
            blow_off: leak.map(|leak| leak.pressures),
            wet_area: area * units.area(),
            force: scale(units.force(), force),
            leak_path: one.path(None),
            leak_paths: one.paths(),
            rounds,
            conductance,
            flow_rate: conductance.map(|flow| flow * driving),
        };
        (fluid.name.clone(), result)
    });
    all.collect()
}

fn scaled(mut values: Vec<f64>, factor: f64) -> Vec<f64> {
    values.iter_mut().for_each(|value| *value *= factor);
    values
}

/// One fluid on its surface; vectors `[nodes of the surface]` s_j how much of it is wet, in the caller's units.
struct One<'a> {
    /// Its parts joined by what lies across.
    surface: Cow<'a, FluidSurface>,
    wet: &'a [bool],
    /// Nodes that it must not reach.
    dry: Vec<bool>,
    /// Of the fluid.
    pressure: f64,
    /// Obstacles and bodies, each with its contact pressure at the nodes.
    contacts: Vec<(&'a str, Vec<f64>)>,
    /// Of contact and fluid together, at the nodes.
    total: Vec<f64>,
    /// Deformed places.
    places: Vec<[f64; 3]>,
}

impl<'a> One<'a> {
    fn new(
        (model, state): (&Model<'a>, &'a State),
        index: usize,
        (contacts, across): (&'a [OneContact<'a>], &NodalContact),
    ) -> Self {
        let units = &model.plan.problem.units;
        let surface = &model.plan.problem.fluid_surfaces[index];
        let wet = &state.wet[index];
        let pressure = state.drive.fluids[index].pressure;
        let shares = state.share_of_fluid(index).into_iter();
        let mut total: Vec<f64> = shares.map(|share| share * pressure).collect();
        let own = contacts.iter().map(|contact| {
            let own = scaled(surface.own(&contact.pressure), units.stress);
            total
                .iter_mut()
                .zip(&own)
                .for_each(|(sum, own)| *sum += own);
            (contact.name, surface.values(&own))
        });
        let contacts = own.collect();
        let places = open_gap::places(model, state, index).into_iter();
        Self {
            total: surface.values(&total),
            places: places.map(|place| scale(units.length, place)).collect(),
            surface: joined(surface, &across.across(surface)),
            wet,
            dry: barred(model, state, index),
            pressure,
            contacts,
        }
    }

    /// The path on which the fluid leaks first: past `obstacle` alone, or past any.
    fn path(&self, obstacle: Option<&str>) -> Option<LeakPathResult> {
        let others = self
            .contacts
            .iter()
            .filter(|(name, _)| obstacle.is_some_and(|own| own != *name));
        let others: Vec<&Vec<f64>> = others.map(|(_, own)| own).collect();
        let is_blocked = |place: usize| others.iter().any(|own| own[place] > 0.0);
        let pressure: Vec<f64> = (0..self.wet.len())
            .map(|place| {
                if is_blocked(place) {
                    f64::INFINITY
                } else {
                    self.total[place]
                }
            })
            .collect();
        let barrier = Barrier {
            surface: &self.surface,
            wet: self.wet,
            dry: &self.dry,
            pressure: &pressure,
        };
        barrier.path(&self.places).map(|path| self.result(&path))
    }

    /// The same for every obstacle that has such a path.
    fn paths(&self) -> BTreeMap<String, LeakPathResult> {
        let pressed = self
            .contacts
            .iter()
            .filter(|(_, own)| own.iter().any(|&l| l > 0.0));
        let paths = pressed.filter_map(|(name, _)| {
            let path = self.path(Some(name))?;
            Some(((*name).to_owned(), path))
        });
        paths.collect()
    }

    fn result(&self, path: &LeakPath) -> LeakPathResult {
        let points: Vec<[f64; 3]> = path.nodes.iter().map(|&place| self.places[place]).collect();
        let pressures: Vec<f64> = path.nodes.iter().map(|&place| self.total[place]).collect();
        LeakPathResult {
            margin: path.margin,
            margin_over_pressure: path.margin - self.pressure,
            sealed_width: width_above(&points, &pressures, self.pressure),
            points,
            pressures,
        }
    }
}

/// Length of a line along which the linear interpolant of `values` is above `least`.
fn width_above(points: &[[f64; 3]], values: &[f64], least: f64) -> f64 {
    let pairs = points.windows(2).zip(values.windows(2));
    let parts = pairs.map(|(ends, values)| {
        let [a, b] = [values[0] - least, values[1] - least];
        let share = match (a > 0.0, b > 0.0) {
            (true, true) => 1.0,
            (false, false) => 0.0,
            _ => a.max(b) / (a - b).abs(),
        };
        share * norm(sub(ends[1], ends[0]))
    });
    parts.sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_width_of_a_seal_ends_where_the_pressure_falls_to_that_of_the_fluid() {
        let points = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 2.0, 0.0], [1.0, 3.0, 0.0]];
        let width = width_above(&points, &[0.0, 4.0, 4.0, 1.0], 2.0);
        assert!((width - (0.5 + 2.0 + 2.0 / 3.0)).abs() < 1e-14, "{width}");
    }
}
