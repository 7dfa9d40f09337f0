//! The boundary of a body in space at rest: what a ray meets first.
//!
//! Cost: one tree of the boundary; a few faces a ray.

use super::patch::{At, NODES, Patch};
use super::rays::{Hit, Ray, hit};
use crate::geometry::vector3::{norm, scale};
use crate::mesh::Mesh;
use crate::pairs::tree::{Bounds, BoxTree};
use crate::space::TaylorHood;

/// By how much a ray may miss a face at its edge, in face coordinates: rays along the edges of a regular
/// mesh meet one of both faces; for rounding.
const BESIDE: f64 = 1e-9;

/// All faces of the boundary.
pub(super) struct Shell {
    /// Displacement nodes of each `[faces][6]`.
    pub(super) nodes: Vec<[u32; NODES]>,
    patches: Vec<Patch>,
    tree: BoxTree,
}

/// What a ray meets.
#[derive(Clone, Copy, Debug)]
pub(super) struct Met {
    /// Number of the face.
    pub(super) face: usize,
    /// Where.
    pub(super) hit: Hit,
}

/// Where a node of a mesh is at rest: of an edge what its middle is off the mean of its ends.
pub(super) fn place_at_rest((mesh, space): (&Mesh, &TaylorHood), node: u32) -> [f64; 3] {
    match (node as usize).checked_sub(space.vertices) {
        None => mesh.coordinates()[node as usize],
        Some(edge) => mesh.offset_of(edge),
    }
}

impl Shell {
    /// Of a body at rest.
    pub(super) fn new((mesh, space): (&Mesh, &TaylorHood)) -> Self {
        let facets = mesh.boundary_facets().iter();
        let nodes = facets.map(|facet| {
            let mut nodes = [facet.vertices[0]; NODES];
            let own = space.facet_nodes(&facet.vertices);
            nodes
                .iter_mut()
                .zip(own)
                .for_each(|(node, own)| *node = own);
            nodes
        });
        let nodes: Vec<[u32; NODES]> = nodes.collect();
        let patches: Vec<Patch> = nodes
            .iter()
            .map(|nodes| Patch {
                nodes: nodes.map(|node| place_at_rest((mesh, space), node)),
            })
            .collect();
        let boxes = patches.iter().map(|patch| Bounds::of(patch.hull()));
        Self {
            tree: BoxTree::new(boxes.collect()),
            patches,
            nodes,
        }
    }

    /// The first face that `ray` meets farther than `off`.
    pub(super) fn first(&self, ray: Ray, off: f64) -> Option<Met> {
        let near = self.tree.meeting_where(&|bounds| passes(ray, bounds));
        let met = near.into_iter().filter_map(|face| {
            let face = face as usize;
            let hit = hit(&self.patches[face], ray)?;
            (is_on(hit.at) && hit.gap * norm(ray.along) > off).then_some(Met { face, hit })
        });
        met.min_by(|a, b| a.hit.gap.total_cmp(&b.hit.gap).then(a.face.cmp(&b.face)))
    }

    /// The first face behind a place of `patch`, a face of the boundary; `off` over its size.
    pub(super) fn behind(&self, patch: &Patch, at: At, off: f64) -> Option<Met> {
        let normal = patch.area_vector(at);
        let size = norm(normal);
        let ray = Ray {
            from: patch.point(at),
            along: scale(-size.recip(), normal),
        };
        self.first(ray, off * size.sqrt())
    }
}

fn is_on([s, t]: At) -> bool {
    s >= -BESIDE && t >= -BESIDE && s + t <= 1.0 + BESIDE
}

/// Whether a ray passes bounds, in front of where it begins.
fn passes(ray: Ray, bounds: &Bounds) -> bool {
    let slack = BESIDE * bounds.diagonal();
    let (mut first, mut last) = (0.0_f64, f64::INFINITY);
    for i in 0..3 {
        let ends = [bounds.low[i] - slack, bounds.high[i] + slack];
        if ray.along[i] == 0.0 {
            if ray.from[i] < ends[0] || ray.from[i] > ends[1] {
                return false;
            }
            continue;
        }
        let [a, b] = ends.map(|end| (end - ray.from[i]) / ray.along[i]);
        first = first.max(a.min(b));
        last = last.min(a.max(b));
    }
    first <= last
}
