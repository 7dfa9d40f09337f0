//! What a state says of contact, whatever the element: resultants of the obstacles,
//! and pressure, gap and state on the candidate surfaces, in the caller's units.

use std::collections::BTreeMap;

use super::constraints::{Interface, Interfaces};
use super::state::State;
use crate::contact::gap::{Deformed, evaluate_gaps};
use crate::contact::resultant::{Resultant, resultant};
use crate::obstacle::{Moving, Obstacle};
use crate::plan::Plan;
use crate::report::ObstacleResult;

/// Contact state of vertices that carry no multiplier.
const NOT_A_CANDIDATE: f64 = -1.0;

/// A body on its obstacles.
pub(super) struct Touching<'a> {
    pub(super) plan: &'a Plan,
    pub(super) interfaces: &'a Interfaces,
    pub(super) state: &'a State,
    /// With the trace of the displacement.
    pub(super) body: Deformed<'a>,
}

impl Touching<'_> {
    fn obstacles(&self) -> Vec<Moving> {
        let length = self.plan.units.length;
        self.interfaces.obstacles(&self.state.drive, length)
    }

    /// Results of all obstacles; `complete` adds what the element knows besides,
    /// given the number of the obstacle and what was found there.
    pub(super) fn results(
        &self,
        complete: impl Fn(usize, &Interface, &Resultant, &mut ObstacleResult),
    ) -> BTreeMap<String, ObstacleResult> {
        let obstacles = self.obstacles();
        let list = self.interfaces.list.iter().zip(&obstacles);
        list.enumerate()
            .map(|(index, (interface, obstacle))| {
                let found = self.resultant(interface, obstacle);
                let mut result = self.result(&found);
                complete(index, interface, &found, &mut result);
                (interface.name.clone(), result)
            })
            .collect()
    }

    fn resultant(&self, interface: &Interface, obstacle: &Moving) -> Resultant {
        resultant(
            &self.body,
            &interface.surface,
            obstacle,
            obstacle.reference_point(),
            &self.state.multiplier[interface.range()],
            &self.state.active[interface.range()],
        )
    }

    fn result(&self, found: &Resultant) -> ObstacleResult {
        let units = &self.plan.units;
        ObstacleResult {
            force: found.force.map(|x| x * units.force()),
            force_error: None,
            moment: found.moment.map(|x| x * units.energy()),
            contact_area: found.area * units.area(),
            max_pressure: found.max_pressure * units.stress,
            max_pressure_deformed: None,
            centre_of_pressure: found.centre.map(|x| x * units.length),
            stick_vertices: 0,
            slip_vertices: 0,
        }
    }

    /// Contact pressure on uploaded vertices.
    pub(super) fn pressure(&self) -> Vec<f64> {
        let multiplier = self.state.multiplier.iter();
        let scaled: Vec<f64> = multiplier.map(|l| l * self.plan.units.stress).collect();
        self.on_surface(&scaled, 0.0, f64::max)
    }

    /// One where a vertex touches, zero where it may, else [`NOT_A_CANDIDATE`].
    pub(super) fn contact_state(&self) -> Vec<f64> {
        let active = self.state.active.iter();
        let flags: Vec<f64> = active.map(|&a| f64::from(u8::from(a))).collect();
        self.on_surface(&flags, NOT_A_CANDIDATE, f64::max)
    }

    /// Weighted gap over nodal weight: a length.
    pub(super) fn gap(&self) -> Vec<f64> {
        let length = self.plan.units.length;
        let obstacles = self.obstacles();
        let mut gaps = Vec::with_capacity(self.state.multiplier.len());
        for (interface, obstacle) in self.interfaces.list.iter().zip(&obstacles) {
            let (weighted, _) = evaluate_gaps(&self.body, &interface.surface, obstacle);
            let weights = interface.surface.weights.iter();
            gaps.extend(weighted.iter().zip(weights).map(|(g, w)| g / w * length));
        }
        self.on_surface(&gaps, 0.0, f64::min)
    }

    /// Multiplier values on uploaded vertices; `merge` joins several obstacles.
    pub(super) fn on_surface(
        &self,
        values: &[f64],
        elsewhere: f64,
        merge: fn(f64, f64) -> f64,
    ) -> Vec<f64> {
        let mesh = self.body.mesh;
        let mut out = vec![None; mesh.vertex_count()];
        for interface in &self.interfaces.list {
            let vertices = interface.surface.vertices.iter();
            for (&vertex, &value) in vertices.zip(&values[interface.range()]) {
                let uploaded = mesh.used_vertices()[vertex as usize];
                let slot: &mut Option<f64> = &mut out[uploaded as usize];
                *slot = Some(slot.map_or(value, |old| merge(old, value)));
            }
        }
        out.into_iter()
            .map(|value| value.unwrap_or(elsewhere))
            .collect()
    }
}
