//! What an obstacle is to the faces that may touch it: how near, and where it presses.
//!
//! An obstacle inside the body where no function acts was missed by the contact integrals.
//! What force that hides is that of punches as large as the faces,
//!
//! ```text
//! F = sum over the missed faces of k_f d_f,   k_f = 2 E* sqrt(area_f / pi)
//! ```
//!
//! above that of any tool which fits into a face. Cost: 45 distances a face in space.

use crate::model::Model;
use crate::model::interfaces::Interface;
use crate::model::state::State;
use crate::obstacle::Obstacle;
use crate::proximity::{cells, faces};
use crate::results::estimate::{contact_modulus, punch_stiffness};

/// Depth over the size of a face from which on contact between its points was missed.
const MISSED: f64 = 1e-3;
/// The same beside faces that are pressed, whose rim overlaps a little on every mesh.
const MISSED_AT_THE_RIM: f64 = 0.02;
/// The same over the depth under faces that are pressed.
const BEYOND_THE_PRESSED: f64 = 1.5;
/// Depth under a pressed face over its size that is more than it bends by between its nodes.
const SUNK: f64 = 0.15;

/// An obstacle beside the faces that may touch it.
pub(crate) struct Touch<'t> {
    /// The faces.
    pub(crate) interface: &'t Interface,
    /// Least signed distance of each face, in units of the scaled body `[faces]`.
    pub(crate) distances: Vec<f64>,
    /// Whether some function acts on the face `[faces]`.
    pub(crate) acts: Vec<bool>,
    /// Whether the obstacle is curved.
    pub(crate) is_curved: bool,
    /// How deep the obstacle lies inside the body; of one that presses, inside the cells without
    /// a face that it may press. In units of the scaled body.
    pub(crate) inside: f64,
    /// How deep it lies inside the body where supports hold this against it.
    pub(crate) held_inside: f64,
    /// Number of dimensions of the body.
    dimension: usize,
}

impl<'t> Touch<'t> {
    /// All obstacles at a state.
    pub(crate) fn all(model: &Model<'t>, state: &State) -> Vec<Self> {
        let body = model.deformed(&state.displacement);
        let met = model.placed(&state.drive).filter_map(|(interface, met)| {
            let obstacle = met.obstacle()?;
            let acts = acts(interface, state);
            let distances = faces::distances(&body, &interface.surface, obstacle);
            let searched = if acts.contains(&true) {
                cells::beside(model.mesh, &interface.surface)
            } else {
                (0..model.mesh.cell_count()).collect()
            };
            let nearest = distances.iter().copied().fold(f64::INFINITY, f64::min);
            Some(Self {
                interface,
                distances,
                is_curved: !obstacle.is_flat(),
                inside: cells::depth_inside(&body, (obstacle, &searched), nearest),
                held_inside: cells::depth_where_held(
                    &body,
                    &model.prepared.is_held,
                    (obstacle, &interface.surface),
                ),
                acts,
                dimension: model.plan.problem.units.dimension,
            })
        });
        met.collect()
    }

    /// Depths at which the obstacle is inside the body where nothing presses: face, depth.
    fn missed(&self) -> impl Iterator<Item = (usize, f64)> {
        let least = if self.acts.contains(&true) {
            MISSED_AT_THE_RIM
        } else {
            MISSED
        };
        let usual = self.usual_depth();
        let power = 1.0 / (self.dimension as f64 - 1.0);
        (0..self.acts.len()).filter_map(move |face| {
            let size = self.interface.surface.faces[face].flat_area.powf(power);
            let depth = -self.distances[face];
            let is_missed = !self.acts[face] && depth > usual.max(least * size);
            is_missed.then_some((face, depth))
        })
    }

    /// Depth that is usual under pressure, between the points at which it acts.
    pub(crate) fn usual_depth(&self) -> f64 {
        let pressed = self.distances.iter().zip(&self.acts);
        let pressed = pressed.filter(|(_, acts)| **acts);
        let depths = pressed.map(|(distance, _)| -distance);
        BEYOND_THE_PRESSED * depths.fold(0.0, f64::max)
    }

    /// Deepest overlap where nothing presses, in units of the scaled body; zero without one.
    pub(crate) fn overlap(&self) -> f64 {
        self.missed().map(|(_, depth)| depth).fold(0.0, f64::max)
    }

    /// Deepest overlap between the points of a pressed face, where it is no small part of the
    /// face: depth and size, in units of the scaled body.
    pub(crate) fn sunk(&self) -> Option<(f64, f64)> {
        let power = 1.0 / (self.dimension as f64 - 1.0);
        let pressed = (0..self.acts.len()).filter(|&face| self.acts[face]);
        let sizes = pressed.map(|face| {
            let area = self.interface.surface.faces[face].flat_area;
            (-self.distances[face], area.powf(power))
        });
        let sunk = sizes.filter(|(depth, size)| *depth > SUNK * size);
        sunk.max_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Size of the largest face under pressure, in units of the scaled body.
    pub(crate) fn pressed_size(&self) -> f64 {
        let power = 1.0 / (self.dimension as f64 - 1.0);
        let faces = self.interface.surface.faces.iter().zip(&self.acts);
        let sizes = faces.filter(|(_, acts)| **acts);
        let sizes = sizes.map(|(face, _)| face.flat_area.powf(power));
        sizes.fold(0.0, f64::max)
    }

    /// Force that such overlaps hide at most, non-dimensional.
    pub(crate) fn hidden_force(&self, model: &Model<'_>) -> f64 {
        let modulus = contact_modulus(model, self.interface);
        let forces = self.missed().map(|(face, depth)| {
            let area = self.interface.surface.faces[face].area;
            depth * punch_stiffness(self.dimension, modulus, area)
        });
        forces.sum()
    }
}

/// Facets of the mesh under the faces that some function acts on.
pub(crate) fn pressed_facets(interface: &Interface, state: &State) -> Vec<u32> {
    let facets = interface.facets.iter().zip(acts(interface, state));
    let pressed = facets.filter(|(_, acts)| *acts);
    pressed.map(|(&facet, _)| facet).collect()
}

/// Whether some function acts on a face `[faces]`.
fn acts(interface: &Interface, state: &State) -> Vec<bool> {
    let flags = state
        .status
        .iter()
        .map(|status| f64::from(u8::from(status.is_closed())));
    let closed = interface.coefficients(&flags.collect::<Vec<_>>());
    let faces = interface.surface.faces.iter();
    let is_closed = |&function: &u32| closed[function as usize] > 0.0;
    faces
        .map(|face| face.functions.iter().any(is_closed))
        .collect()
}
