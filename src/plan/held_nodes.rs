//! Nodes on planes that lie across no axis: n . u is held there, one to three normals a node.
//!
//! ```text
//! d_j = (n_j - sum over i < j (n_j . d_i) d_i) / |..|,   d_j . u = (w_j - sum (n_j . d_i) t_i) / |..| = t_j
//! ```
//!
//! the first d_i being components that are held there, with the values that u has already. Normals that
//! depend on what is held hold nothing: the first support named holds. Cost: one visit a node.

use std::collections::BTreeMap;

use crate::geometry::vector3::{dot, norm, scale, sub};
use crate::linalg::HeldNode;
use crate::mesh::Mesh;
use crate::scene::validate::Resolved;
use crate::space::TaylorHood;

/// Length of what is left of a normal that depends on others: of planes whose angle is less than a
/// thousandth the second holds nothing; chosen, no scene measures it.
const DEPENDENT: f64 = 1e-3;

/// A plane at a node.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HeldPlane {
    /// Outward unit normal.
    pub(crate) normal: [f64; 3],
    /// The support that holds it.
    pub(crate) support: u16,
}

/// A node that planes hold.
#[derive(Clone, Debug)]
pub(crate) struct HeldByPlanes {
    /// What is held of it beside its components.
    pub(crate) held: HeldNode,
    /// Its components that are held.
    pub(crate) axes: [bool; 3],
    /// The planes that hold it, as many as `held` has directions.
    pub(crate) planes: Vec<HeldPlane>,
}

impl HeldByPlanes {
    /// Of a node with these axes held; nothing yet.
    fn new(node: u32, axes: [bool; 3]) -> Self {
        Self {
            held: HeldNode {
                node,
                directions: [[0.0; 3]; 3],
                count: 0,
            },
            axes,
            planes: Vec::new(),
        }
    }

    /// A normal without its held components, and what its part along earlier directions is worth
    /// where these have the values `known`.
    fn rest(&self, normal: [f64; 3], known: &[f64]) -> ([f64; 3], f64) {
        let mut rest = normal;
        (0..3).for_each(|i| rest[i] *= if self.axes[i] { 0.0 } else { 1.0 });
        let mut worth = 0.0;
        for (direction, value) in self.held.directions().iter().zip(known) {
            let part = dot(rest, *direction);
            rest = sub(rest, scale(part, *direction));
            worth += part * value;
        }
        (rest, worth)
    }

    fn add(&mut self, plane: HeldPlane) {
        let (rest, _) = self.rest(plane.normal, &[0.0; 3]);
        let length = norm(rest);
        if length > DEPENDENT {
            self.held.directions[self.planes.len()] = scale(1.0 / length, rest);
            self.held.count += 1;
            self.planes.push(plane);
        }
    }

    /// d_j . u where the planes are to have the values `wanted` `[planes]` and the held components
    /// those of `u`.
    pub(crate) fn targets(&self, wanted: &[f64], u: [f64; 3]) -> Vec<f64> {
        let mut targets = Vec::new();
        for (plane, wanted) in self.planes.iter().zip(wanted) {
            let (rest, worth) = self.rest(plane.normal, &targets);
            let held = (0..3).filter(|&i| self.axes[i]);
            let along: f64 = held.map(|i| plane.normal[i] * u[i]).sum();
            // Later directions have no part in `rest` yet.
            targets.push((wanted - along - worth) / norm(rest));
        }
        targets
    }

    /// The force of each plane `[planes]` whose sum with that of the held components is `force`.
    pub(crate) fn forces(&self, force: [f64; 3]) -> Vec<[f64; 3]> {
        let mut left = force;
        (0..3).for_each(|i| left[i] *= if self.axes[i] { 0.0 } else { 1.0 });
        let mut found = vec![[0.0; 3]; self.planes.len()];
        for place in (0..self.planes.len()).rev() {
            let normal = self.planes[place].normal;
            let direction = self.held.directions[place];
            let free: [f64; 3] =
                std::array::from_fn(|i| if self.axes[i] { 0.0 } else { normal[i] });
            let size = dot(left, direction) / dot(free, direction);
            found[place] = scale(size, normal);
            left = sub(left, scale(size, free));
        }
        found
    }

    /// The reaction of each plane `[planes]` in `nodal` forces `[nodes, components]`: what a plane
    /// pushes along a held component is in the reaction of that.
    pub(crate) fn reactions(&self, components: usize, nodal: &[f64]) -> Vec<[f64; 3]> {
        let first = self.held.node as usize * components;
        let force = std::array::from_fn(|i| {
            if i < components {
                nodal.get(first + i).copied().unwrap_or(0.0)
            } else {
                0.0
            }
        });
        let mut forces = self.forces(force);
        for force in &mut forces {
            (0..3).for_each(|i| force[i] *= if self.axes[i] { 0.0 } else { 1.0 });
        }
        forces
    }
}

/// The nodes that planes hold, ascending; `held` are the components.
pub(super) fn held_nodes(
    resolved: &Resolved,
    (mesh, space): (&Mesh, &TaylorHood),
    held: &[(u32, u16)],
) -> Vec<HeldByPlanes> {
    let c = space.components as u32;
    let is_held = |unknown: u32| held.binary_search_by_key(&unknown, |one| one.0).is_ok();
    let axes = |node: u32| [0, 1, 2].map(|i| i >= c || is_held(node * c + i));
    let mut found: BTreeMap<u32, HeldByPlanes> = BTreeMap::new();
    for (index, support) in resolved.supports.iter().enumerate() {
        for plane in &support.oblique {
            let facets = plane.facets.iter();
            for node in facets.flat_map(|&f| space.facet_nodes(mesh.facet(f as usize))) {
                let one = found.entry(node);
                let one = one.or_insert_with(|| HeldByPlanes::new(node, axes(node)));
                let is_new = |other: &HeldPlane| norm(sub(other.normal, plane.normal)) > DEPENDENT;
                if one.planes.iter().all(is_new) {
                    one.add(HeldPlane {
                        normal: plane.normal,
                        support: index as u16,
                    });
                }
            }
        }
    }
    let mut all: Vec<HeldByPlanes> = found.into_values().collect();
    all.retain(|one| !one.planes.is_empty());
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::vector3::add;

    fn node() -> HeldByPlanes {
        let mut one = HeldByPlanes::new(3, [false, true, false]);
        for (normal, support) in [([0.6, 0.0, 0.8], 0), ([0.5, 0.5, 0.5_f64.sqrt()], 1)] {
            one.add(HeldPlane { normal, support });
        }
        one
    }

    #[test]
    fn targets_give_the_planes_their_values() {
        let one = node();
        let u = [0.3, -0.2, 0.9];
        let targets = one.targets(&[0.1, 0.7], u);
        let mut moved = u;
        for (direction, target) in one.held.directions().iter().zip(targets) {
            moved = add(moved, scale(target - dot(moved, *direction), *direction));
        }
        assert!((moved[1] - u[1]).abs() < 1e-16);
        for (plane, wanted) in one.planes.iter().zip([0.1, 0.7]) {
            assert!((dot(plane.normal, moved) - wanted).abs() < 1e-12);
        }
    }

    #[test]
    fn forces_of_planes_are_along_their_normals_and_leave_the_held_axes() {
        let one = node();
        let force = [0.4, 1.3, -0.7];
        let sum = one.forces(force).into_iter().fold([0.0; 3], add);
        assert!((sum[0] - force[0]).abs() < 1e-12 && (sum[2] - force[2]).abs() < 1e-12);
    }
}
