//! The surfaces that carry multipliers: candidate surfaces of obstacles, the carriers of contacts
//! between bodies, ties, then smooth patches of supports along their normal.
//!
//! ```text
//! linear:     hats at the vertices, one set of multipliers an obstacle
//! quadratic:  Bernstein functions at all nodes and sides; obstacles on neighbouring
//!             parts of one smooth surface share the multipliers of their common nodes
//! ```
//!
//! Contacts between bodies have quadratic functions.
//!
//! Without sharing the functions of two halves of a flat surface outnumber the motions of
//! their nodes. Obstacles with a common facet keep multipliers of their own: each of them
//! holds the facet. Cost: one sort of the sides of each surface.

use std::collections::{BTreeSet, HashSet};

use super::pairs::PlannedPair;
use super::ties::PlannedTie;
use crate::contact::layout::{Holding, Layout};
use crate::mesh::Mesh;
use crate::pairs::{self, Meets, creases};
use crate::scene::ContactSpace;
use crate::scene::validate::{Resolved, ResolvedObstacle};
use crate::space::TaylorHood;

/// The functions of one obstacle's surface and their multipliers among those of all
/// obstacles, ascending.
#[derive(Clone, Debug)]
pub(crate) struct ContactLayout {
    /// Functions and shares, multipliers numbered within the obstacle.
    pub(crate) layout: Layout,
    /// Multipliers of the obstacle among those of all obstacles, ascending.
    pub(crate) multipliers: Vec<u32>,
}

/// The surfaces of a scene, with their multipliers counted.
pub(super) struct Surfaces {
    /// Mesh vertices of all of them, ascending.
    pub(super) vertices: Vec<u32>,
    /// Layout of each obstacle's surface.
    pub(super) layouts: Vec<ContactLayout>,
    /// Layout of the carrier of each contact between bodies.
    pub(super) pair_layouts: Vec<ContactLayout>,
    /// Multipliers of obstacles and of contacts between bodies.
    pub(super) contacts: usize,
    /// Multipliers of supports along their normal, one a node of each patch, and of ties.
    pub(super) guided: usize,
}

/// What the surfaces lie on.
#[derive(Clone, Copy)]
pub(super) struct Body<'a> {
    /// The mesh.
    pub(super) mesh: &'a Mesh,
    /// Numbering of the displacement.
    pub(super) space: &'a TaylorHood,
    /// Held unknowns with their supports, ascending.
    pub(super) held: &'a [(u32, u16)],
}

impl Body<'_> {
    /// Whether supports hold a displacement unknown.
    fn holds(&self, unknown: u32) -> bool {
        let held = self.held.binary_search_by_key(&unknown, |(held, _)| *held);
        held.is_ok()
    }
}

/// What acts on them.
#[derive(Clone, Copy)]
pub(super) struct Acting<'a> {
    /// Tools.
    pub(super) obstacles: &'a [ResolvedObstacle],
    /// Contacts between bodies.
    pub(super) pairs: &'a [PlannedPair],
    /// Ties between bodies.
    pub(super) ties: &'a [PlannedTie],
}

impl Surfaces {
    /// Those of `obstacles` and of the supports of `resolved`.
    pub(super) fn of(
        body: Body<'_>,
        acting: Acting<'_>,
        resolved: &Resolved,
        space: ContactSpace,
    ) -> Self {
        let Acting {
            obstacles,
            pairs,
            ties,
        } = acting;
        let candidates = obstacles.iter().map(|obstacle| &obstacle.facets);
        let sides = pairs.iter().flat_map(|pair| [&pair.carrier, &pair.other]);
        let sides = sides.chain(ties.iter().flat_map(PlannedTie::sides));
        let supports = resolved.supports.iter();
        let patches = supports.flat_map(|support| &support.patches);
        let layouts = layouts(body, obstacles, space);
        let all = layouts.iter().flat_map(|layout| &layout.multipliers);
        let mut contacts = all.max().map_or(0, |&last| last as usize + 1);
        let of_pair = |pair: &PlannedPair| of_pair(body, pair, &mut contacts);
        Self {
            pair_layouts: pairs.iter().map(of_pair).collect(),
            vertices: vertices_of(body.mesh, candidates.chain(sides).chain(patches.clone())),
            contacts,
            layouts,
            guided: patches.map(|patch| nodes_of(body, patch)).sum::<usize>()
                + ties.iter().map(PlannedTie::multipliers).sum::<usize>(),
        }
    }
}

/// The layout of the carrier of a contact between bodies, its multipliers from `next` on.
fn of_pair(body: Body<'_>, pair: &PlannedPair, next: &mut usize) -> ContactLayout {
    let sides = [&pair.carrier[..], &pair.other[..]];
    let components = body.space.components as u32;
    let creases = match pair.meets {
        Meets::AnotherBody => BTreeSet::new(),
        Meets::ItsBody | Meets::Itself if components == 2 => creases(body.mesh, sides),
        Meets::ItsBody | Meets::Itself => pairs::space::creases((body.mesh, body.space), sides),
    };
    let is_held = |unknown: u32| body.holds(unknown) || creases.contains(&(unknown / components));
    let holding = Holding {
        is_held: &is_held,
        tools: &[],
    };
    let layout = Layout::by_sides(body.mesh, body.space, &pair.carrier, holding);
    let first = *next as u32;
    *next += layout.shares.multipliers();
    ContactLayout {
        layout,
        multipliers: (first..*next as u32).collect(),
    }
}

/// The layout of each obstacle.
fn layouts(
    body: Body<'_>,
    obstacles: &[ResolvedObstacle],
    space: ContactSpace,
) -> Vec<ContactLayout> {
    let mut found: Vec<Option<ContactLayout>> = vec![None; obstacles.len()];
    let mut next = 0;
    for group in groups(body, obstacles, space) {
        let facets: Vec<u32> = group
            .iter()
            .flat_map(|&index| obstacles[index].facets.iter().copied())
            .collect();
        let tools = group.iter().flat_map(|&index| {
            let obstacle = &obstacles[index];
            let shape = &obstacle.shape;
            let normal = shape.is_flat().then(|| shape.distance([0.0; 3]).normal);
            obstacle.facets.iter().map(move |_| normal)
        });
        let tools: Vec<Option<[f64; 3]>> = tools.collect();
        let whole = layout(body, (&facets, &tools), space);
        let mut first = 0;
        for &index in &group {
            let last = first + obstacles[index].facets.len();
            let (layout, mut multipliers) = whole.part(first..last);
            multipliers.iter_mut().for_each(|m| *m += next);
            found[index] = Some(ContactLayout {
                layout,
                multipliers,
            });
            first = last;
        }
        next += whole.shares.multipliers() as u32;
    }
    found.into_iter().flatten().collect()
}

/// The functions on some facets and the normals of the flat tools that they meet.
fn layout(
    body: Body<'_>,
    (facets, tools): (&[u32], &[Option<[f64; 3]>]),
    space: ContactSpace,
) -> Layout {
    let corners = |&facet: &u32| body.mesh.facet(facet as usize);
    match space {
        ContactSpace::Linear => {
            Layout::by_nodes(&facets.iter().map(corners).collect::<Vec<&[u32]>>())
        }
        ContactSpace::Quadratic => {
            let is_held = |unknown| body.holds(unknown);
            let holding = Holding {
                is_held: &is_held,
                tools,
            };
            Layout::by_sides(body.mesh, body.space, facets, holding)
        }
    }
}

/// Obstacles whose surfaces carry their multipliers together, in the order of their
/// first ones.
fn groups(body: Body<'_>, obstacles: &[ResolvedObstacle], space: ContactSpace) -> Vec<Vec<usize>> {
    let alone = |index: usize| vec![index];
    if space == ContactSpace::Linear {
        return (0..obstacles.len()).map(alone).collect();
    }
    let mut groups: Vec<Group> = Vec::new();
    for (index, obstacle) in obstacles.iter().enumerate() {
        let facets = obstacle.facets.iter();
        let nodes = facets
            .clone()
            .flat_map(|&facet| body.mesh.facet(facet as usize));
        let own = Group {
            obstacles: alone(index),
            facets: facets.copied().collect(),
            vertices: nodes.copied().collect(),
        };
        match groups.iter_mut().find(|group| group.takes(&own)) {
            Some(group) => group.join(own),
            None => groups.push(own),
        }
    }
    groups.into_iter().map(|group| group.obstacles).collect()
}

/// Obstacles on neighbouring facets.
struct Group {
    obstacles: Vec<usize>,
    facets: HashSet<u32>,
    vertices: HashSet<u32>,
}

impl Group {
    /// Whether `other` has a common vertex and no common facet.
    fn takes(&self, other: &Self) -> bool {
        self.facets.is_disjoint(&other.facets) && !self.vertices.is_disjoint(&other.vertices)
    }

    fn join(&mut self, other: Self) {
        self.obstacles.extend(other.obstacles);
        self.facets.extend(other.facets);
        self.vertices.extend(other.vertices);
    }
}

/// Number of displacement nodes on a patch.
fn nodes_of(body: Body<'_>, patch: &[u32]) -> usize {
    let facets = patch.iter();
    let mut nodes: Vec<u32> = facets
        .flat_map(|&facet| body.space.facet_nodes(body.mesh.facet(facet as usize)))
        .collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes.len()
}

/// The vertices of those facets, ascending and each once.
pub(super) fn vertices_of<'a>(mesh: &Mesh, facets: impl Iterator<Item = &'a Vec<u32>>) -> Vec<u32> {
    let mut vertices: Vec<u32> = facets
        .flatten()
        .flat_map(|&facet| mesh.facet(facet as usize).iter().copied())
        .collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices
}
