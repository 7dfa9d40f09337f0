//! Directions of the multipliers at the contact vertices: the normal of the surface,
//! of every surface where several that differ meet.
//!
//! One direction a vertex is enough where the surfaces there face the same way; where
//! a corner is pressed from two sides, or slides along two guides, the metric needs
//! both. Several directions of a vertex are made orthogonal. Cost: some 100 flops a
//! facet.

use std::collections::HashSet;

use super::bodies::P1Body;
use crate::contact::patches::smooth_patches;
use crate::contact::surface::vertex_normals;
use crate::geometry::vector3::{dot, norm, normalised, scale, sub};
use crate::mesh::Mesh;
use crate::plan::Plan;
use crate::plan::ties::PlannedTie;
use crate::scene::ContactSpace;

/// Least cosine between normals that count as one direction: 30 degrees.
const SAME: f64 = 0.866;
/// Length that a direction must keep beside the others of its vertex.
const INDEPENDENT: f64 = 0.1;

/// Vertices and directions of `precond::p1::Traces`.
#[derive(Clone, Debug, Default)]
pub(crate) struct TraceDirections {
    /// Ascending, as often as a vertex has directions `[traces]`.
    pub(crate) vertices: Vec<u32>,
    /// Unit vectors, zero in held components `[traces]`.
    pub(crate) directions: Vec<[f64; 3]>,
}

impl TraceDirections {
    /// Those of all candidate and guided surfaces of `plan`.
    pub(crate) fn new(plan: &Plan, body: P1Body<'_>) -> Self {
        let together = plan.surfaces().collect::<Vec<&[u32]>>().concat();
        let surfaces = sides(plan, body.mesh);
        let means = normals(plan, body, &together);
        let own: Vec<_> = match surfaces.len() {
            0 | 1 => Vec::new(),
            _ => surfaces
                .iter()
                .map(|own| normals(plan, body, own))
                .collect(),
        };
        let frictional = pushed_all_ways(plan, body.mesh);
        let mut traces = Self::default();
        for (index, &vertex) in plan.decisions.contact_vertices.iter().enumerate() {
            let mut apart = apart(own.iter().map(|normals| normals[index]));
            if frictional.contains(&vertex) {
                // Tractions act in all directions.
                apart.insert(0, means[index]);
                apart.extend([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
            }
            match apart.len() {
                0 | 1 => traces.push(body, vertex, means[index]),
                _ => traces.push_several(body, vertex, &apart),
            }
        }
        traces
    }

    fn push(&mut self, body: P1Body<'_>, vertex: u32, direction: [f64; 3]) {
        self.vertices.push(vertex);
        self.directions.push(free_part(body, vertex, direction));
    }

    /// The same span by orthogonal directions.
    fn push_several(&mut self, body: P1Body<'_>, vertex: u32, directions: &[[f64; 3]]) {
        let first = self.directions.len();
        for &direction in directions {
            let mut rest = free_part(body, vertex, direction);
            for earlier in &self.directions[first..] {
                rest = sub(rest, scale(dot(rest, *earlier), *earlier));
            }
            if let Some(unit) = normalised(rest).filter(|_| norm(rest) > INDEPENDENT) {
                self.vertices.push(vertex);
                self.directions.push(unit);
            }
        }
        if self.directions.len() == first {
            self.push(body, vertex, [0.0; 3]);
        }
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> u64 {
        24 * self.directions.len() as u64 + 4 * self.vertices.len() as u64
    }
}

/// Vertices that may touch frictional obstacles, or other bodies with friction, or are tied.
fn pushed_all_ways(plan: &Plan, mesh: &Mesh) -> HashSet<u32> {
    let frictional = plan
        .problem
        .obstacles
        .iter()
        .filter(|obstacle| obstacle.is_frictional);
    let facets = frictional.flat_map(|obstacle| &obstacle.facets);
    let pairs = plan.problem.pairs.iter();
    let pairs = pairs.filter(|pair| pair.is_frictional());
    let sides = pairs.flat_map(|pair| pair.carrier.iter().chain(&pair.other));
    let facets = facets.chain(sides);
    let ties = plan.problem.ties.iter().flat_map(PlannedTie::sides);
    let facets = facets.chain(ties.flatten());
    let corners = facets.flat_map(|&facet| mesh.facet(facet as usize));
    corners.copied().collect()
}

/// The surfaces whose normals may differ at a vertex: quadratic functions are told
/// apart where a surface turns sharply, hats are not.
fn sides(plan: &Plan, mesh: &Mesh) -> Vec<Vec<u32>> {
    let surfaces = plan.surfaces();
    match plan.problem.contact_space {
        ContactSpace::Linear => surfaces.map(<[u32]>::to_vec).collect(),
        ContactSpace::Quadratic => surfaces
            .flat_map(|facets| smooth_patches(mesh, facets))
            .collect(),
    }
}

/// Normals that differ, of those at one vertex; zero where a surface is elsewhere.
fn apart(normals: impl Iterator<Item = [f64; 3]>) -> Vec<[f64; 3]> {
    let mut found: Vec<[f64; 3]> = Vec::new();
    for normal in normals.filter(|normal| norm(*normal) > 0.0) {
        if found.iter().all(|other| dot(*other, normal) < SAME) {
            found.push(normal);
        }
    }
    found
}

/// Normals of the surface of `facets` at the contact vertices, zero elsewhere; where
/// the body is when it is deformed.
fn normals(plan: &Plan, body: P1Body<'_>, facets: &[u32]) -> Vec<[f64; 3]> {
    let unit = plan.problem.units.coordinate_scale;
    let c = body.space.components;
    let position = |vertex: u32| {
        let mut at = body.mesh.coordinates()[vertex as usize].map(|x| unit * x);
        let moved = body
            .moved
            .get(vertex as usize * c..(vertex as usize + 1) * c);
        for (x, by) in at.iter_mut().zip(moved.unwrap_or_default()) {
            *x += by;
        }
        at
    };
    let facets = facets.iter();
    vertex_normals(
        position,
        facets.map(|&facet| body.mesh.facet(facet as usize)),
        &plan.decisions.contact_vertices,
    )
}

/// `direction` with held components zero.
fn free_part(body: P1Body<'_>, vertex: u32, mut direction: [f64; 3]) -> [f64; 3] {
    let c = body.space.components as u32;
    for (component, unknown) in direction.iter_mut().zip(vertex * c..(vertex + 1) * c) {
        if body.held.entries.binary_search(&unknown).is_ok() {
            *component = 0.0;
        }
    }
    if let Ok(place) = body
        .held
        .nodes
        .binary_search_by_key(&vertex, |one| one.node)
    {
        body.held.nodes[place].project(&mut direction);
    }
    direction
}
