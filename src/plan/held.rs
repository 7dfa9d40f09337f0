//! Held unknowns: u = given on the facets of supports, u_x = 0 on the axis of a
//! body of revolution. One visit per node of a held facet.

use std::collections::BTreeMap;

use crate::mesh::Mesh;
use crate::plan::surfaces::vertices_of;
use crate::scene::validate::{ON_AXIS, Resolved, rotates};
use crate::scene::{SceneError, SceneKind, Step, Violation};
use crate::space::TaylorHood;

/// In the place of a support: the axis of a body of revolution, where u_x = 0.
pub(crate) const AXIS: u16 = u16::MAX;

/// Held unknowns; where supports overlap, the first one named holds, those that name components
/// before those that hold planes.
pub(crate) fn held_unknowns(
    resolved: &Resolved,
    mesh: &Mesh,
    space: &TaylorHood,
) -> Vec<(u32, u16)> {
    let mut held = BTreeMap::new();
    let c = space.components as u32;
    for (index, support) in resolved.supports.iter().enumerate() {
        for &facet in &support.facets {
            for node in space.facet_nodes(mesh.facet(facet as usize)) {
                for i in 0..space.components {
                    if support.displacement[i].is_some() {
                        held.entry(node * c + i as u32).or_insert(index as u16);
                    }
                }
            }
        }
    }
    for (index, support) in resolved.supports.iter().enumerate() {
        for plane in &support.planes {
            let facets = plane.facets.iter();
            for node in facets.flat_map(|&f| space.facet_nodes(mesh.facet(f as usize))) {
                let unknown = node * c + plane.axis as u32;
                held.entry(unknown).or_insert(index as u16);
            }
        }
    }
    if resolved.kind == SceneKind::Axisymmetric {
        for node in nodes_on_axis(mesh, space) {
            // Of all supports and the axis, the axis holds.
            held.insert(node * space.components as u32, AXIS);
        }
    }
    held.into_iter().collect()
}

/// Vertices on x = 0, and midpoints between two of them.
pub(crate) fn nodes_on_axis(mesh: &Mesh, space: &TaylorHood) -> Vec<u32> {
    let most = ON_AXIS * mesh.extent();
    let is_on_axis = |vertex: u32| mesh.coordinates()[vertex as usize][0] <= most;
    let vertices = (0..space.vertices as u32).filter(|&vertex| is_on_axis(vertex));
    let edges = space.edges.iter().zip(space.vertices as u32..);
    let edges = edges.filter(|([a, b], _)| is_on_axis(*a) && is_on_axis(*b));
    vertices.chain(edges.map(|(_, node)| node)).collect()
}

/// Relative difference of prescribed values that counts as none.
const SAME: f64 = 1e-9;

/// Supports that prescribe different values on shared vertices.
pub(crate) fn conflicts(resolved: &Resolved, mesh: &Mesh) -> Vec<String> {
    let mut holder: BTreeMap<(u32, usize), usize> = BTreeMap::new();
    let mut found: BTreeMap<(usize, usize), usize> = BTreeMap::new();
    let supports = &resolved.supports;
    for (index, support) in supports.iter().enumerate() {
        let at = |support: usize, vertex: u32, value: f64| {
            let point = mesh.coordinates()[vertex as usize];
            let profile = supports[support].profile.as_ref();
            profile.map_or(value, |profile| value * profile.at(point))
        };
        let vertices = vertices_of(mesh, std::iter::once(&support.facets));
        for (component, value) in support.displacement.into_iter().enumerate() {
            let Some(value) = value else { continue };
            for &vertex in &vertices {
                let first = *holder.entry((vertex, component)).or_insert(index);
                let held = supports[first].displacement[component];
                let differs = |held: f64| {
                    let difference = at(first, vertex, held) - at(index, vertex, value);
                    difference.abs() > SAME * held.abs().max(value.abs())
                };
                if held.is_some_and(differs) {
                    *found.entry((first, index)).or_default() += 1;
                }
            }
        }
    }
    let name = |index: usize| &supports[index].name;
    found
        .into_iter()
        .map(|((first, second), count)| {
            format!(
                "supports `{}` and `{}` prescribe different values {count} times; `{}` holds",
                name(first),
                name(second),
                name(first)
            )
        })
        .collect()
}

impl crate::plan::Plan {
    /// Refuses a step that rotates planes which are held as components.
    ///
    /// # Errors
    /// [`SceneError::Unsupported`] with the key.
    pub(crate) fn check_turned_planes(&self, step: &Step) -> Result<(), SceneError> {
        let supports = self.resolved.supports.iter();
        let mut held = supports.filter(|support| !support.planes.is_empty());
        match held.find(|support| rotates(step, &support.name)) {
            None => Ok(()),
            Some(support) => Err(SceneError::Unsupported(Violation {
                path: format!("step.support.{}.rotation", support.name),
                message: "its planes across an axis are held as components: give a step that \
                          rotates them with the scene"
                    .to_owned(),
            })),
        }
    }
}
