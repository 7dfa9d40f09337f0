//! The functions of a contact surface: which nodes carry one, which faces share it, and
//! which multipliers stand for it.
//!
//! Hats and guides have one function a node. Quadratic contact pressure has one a node
//! *and side*: where a surface turns by more than 30 degrees, the faces on either hand
//! have functions of their own, since their normals see different motions of the node.
//! A function whose node supports hold along the normals of its faces, or of the flat tool that
//! they meet, goes to the nearest free functions of these faces (`Shares`). Cost: one sort of the sides.

use std::collections::BTreeMap;
use std::ops::Range;

use super::patches::{SMOOTH, neighbours, outward};
use super::shares::Shares;
use crate::assembly::load::facet_measure;
use crate::geometry::vector3::{add, dot, norm, normalised, scale, sub};
use crate::mesh::Mesh;
use crate::space::TaylorHood;

/// Component of a unit normal that counts as one.
const HELD_ALONG: f64 = 1e-9;
/// Distances that differ by less, relative, are equal.
const AS_NEAR: f64 = 1e-6;

/// Functions of a surface with their nodes.
#[derive(Clone, Debug)]
pub struct Layout {
    /// Functions of each face, in the order of its nodes `[faces][functions of a face]`.
    pub faces: Vec<Vec<u32>>,
    /// Displacement node of each function, ascending `[functions]`.
    pub nodes: Vec<u32>,
    /// The multipliers of the functions.
    pub shares: Shares,
}

/// What holds the nodes of some facets.
#[derive(Clone, Copy)]
pub struct Holding<'a> {
    /// Whether supports hold a displacement unknown.
    pub is_held: &'a dyn Fn(u32) -> bool,
    /// Unit normal of the flat tool that each facet meets in its initial pose `[facets]`; none of other
    /// tools, empty without tools.
    pub tools: &'a [Option<[f64; 3]>],
}

impl Layout {
    /// One function a node, `nodes` `[faces]` being those that carry one.
    pub fn by_nodes(nodes: &[&[u32]]) -> Self {
        let mut carriers: Vec<u32> = nodes.concat();
        carriers.sort_unstable();
        carriers.dedup();
        let place = |node: &u32| carriers.partition_point(|other| other < node) as u32;
        let faces = nodes.iter();
        Self {
            faces: faces
                .map(|nodes| nodes.iter().map(place).collect())
                .collect(),
            shares: Shares::identity(carriers.len()),
            nodes: carriers,
        }
    }

    /// One function a node and side of `facets`.
    pub fn by_sides(mesh: &Mesh, space: &TaylorHood, facets: &[u32], holding: Holding<'_>) -> Self {
        let sides = Sides::new(mesh, space, facets);
        let layout = sides.functions();
        let held = sides.held(&layout, holding);
        layout.given_away(&sides, &held)
    }

    /// The same with a multiplier a function.
    pub fn of_sides(mesh: &Mesh, space: &TaylorHood, facets: &[u32]) -> Self {
        Sides::new(mesh, space, facets).functions()
    }

    /// The functions of `facets` with multipliers but for those that are lost `[functions]`, which
    /// the nearest others of their faces take over.
    pub fn taken_over(
        &self,
        (mesh, space, facets): (&Mesh, &TaylorHood, &[u32]),
        is_lost: &[bool],
    ) -> Self {
        let sides = Sides::new(mesh, space, facets);
        self.clone().given_away(&sides, is_lost)
    }

    fn given_away(mut self, sides: &Sides<'_>, is_lost: &[bool]) -> Self {
        let around = faces_around(&self);
        let functions = 0..self.nodes.len();
        let takers =
            functions.map(|k| is_lost[k].then(|| sides.nearest(&self, (k, &around[k]), is_lost)));
        let takers: Vec<Option<Vec<u32>>> = takers.collect();
        self.shares = Shares::new(&takers);
        self
    }
}

impl Layout {
    /// The part on some faces, and its multipliers among those of the whole, ascending.
    pub fn part(&self, faces: Range<usize>) -> (Self, Vec<u32>) {
        let mut functions: Vec<u32> = self.faces[faces.clone()].concat();
        functions.sort_unstable();
        functions.dedup();
        let place = |k: &u32| functions.partition_point(|other| other < k) as u32;
        let (shares, multipliers) = self.shares.of_some(&functions);
        let faces = self.faces[faces].iter();
        let part = Self {
            faces: faces.map(|own| own.iter().map(place).collect()).collect(),
            nodes: functions.iter().map(|&k| self.nodes[k as usize]).collect(),
            shares,
        };
        (part, multipliers)
    }
}

/// The faces of each function `[functions]`, ascending.
fn faces_around(layout: &Layout) -> Vec<Vec<u32>> {
    let mut around = vec![Vec::new(); layout.nodes.len()];
    for (face, functions) in (0..).zip(&layout.faces) {
        for &function in functions {
            around[function as usize].push(face);
        }
    }
    around
}

/// Faces with their nodes and outward normals.
struct Sides<'a> {
    mesh: &'a Mesh,
    space: &'a TaylorHood,
    facets: &'a [u32],
    /// Displacement nodes of each face: corners, then edges.
    nodes: Vec<Vec<u32>>,
    /// Outward unit normal of each face.
    normals: Vec<[f64; 3]>,
    /// Area of each face, in the caller's lengths.
    areas: Vec<f64>,
}

impl<'a> Sides<'a> {
    fn new(mesh: &'a Mesh, space: &'a TaylorHood, facets: &'a [u32]) -> Self {
        let measures = facets
            .iter()
            .map(|&facet| facet_measure(mesh, &outward(mesh, facet), 1.0));
        let (areas, normals) = measures.unzip();
        let nodes = facets.iter().map(|&facet| mesh.facet(facet as usize));
        Self {
            mesh,
            space,
            facets,
            nodes: nodes.map(|corners| space.facet_nodes(corners)).collect(),
            normals,
            areas,
        }
    }

    /// One function for every set of faces that meet smoothly at a node.
    fn functions(&self) -> Layout {
        let width = self.nodes.first().map_or(1, Vec::len);
        let mut label: Vec<usize> = (0..self.nodes.len() * width).collect();
        self.join_neighbours(width, &mut label);
        let mut at_nodes: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for slot in 0..label.len() {
            let node = self.nodes[slot / width][slot % width];
            at_nodes.entry(node).or_default().push(slot);
        }
        let mut layout = Layout {
            faces: self
                .nodes
                .iter()
                .map(|nodes| vec![0; nodes.len()])
                .collect(),
            nodes: Vec::new(),
            shares: Shares::identity(0),
        };
        for (node, slots) in at_nodes {
            for side in self.smooth_sets(&slots, width, &mut label) {
                let function = layout.nodes.len() as u32;
                layout.nodes.push(node);
                side.iter()
                    .for_each(|slot| layout.faces[slot / width][slot % width] = function);
            }
        }
        layout.shares = Shares::identity(layout.nodes.len());
        layout
    }

    /// Joins the slots of the nodes on sides where two faces meet smoothly.
    fn join_neighbours(&self, width: usize, label: &mut [usize]) {
        for (side, faces) in neighbours(self.mesh, self.facets) {
            for pair in faces.windows(2) {
                let [a, b] = [pair[0], pair[1]];
                if dot(self.normals[a], self.normals[b]) < SMOOTH {
                    continue;
                }
                let mut shared = side.clone();
                if let [from, to] = side[..] {
                    let edge = self.space.edge_between(from, to);
                    shared.extend(edge.map(|edge| (self.space.vertices + edge) as u32));
                }
                for node in shared {
                    let slot = |face: usize| {
                        let at = self.nodes[face].iter().position(|&other| other == node);
                        at.map(|at| face * width + at)
                    };
                    if let (Some(a), Some(b)) = (slot(a), slot(b)) {
                        super::patches::join(label, a, b);
                    }
                }
            }
        }
    }

    /// The slots of one node by function: sets that are joined already, and sets whose
    /// mean normals differ little though their faces share the node alone.
    fn smooth_sets(&self, slots: &[usize], width: usize, label: &mut [usize]) -> Vec<Vec<usize>> {
        let mut joined: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for &slot in slots {
            let root = super::patches::root(label, slot);
            joined.entry(root).or_default().push(slot);
        }
        let mut sets: Vec<(Vec<usize>, [f64; 3])> = Vec::new();
        for slots in joined.into_values() {
            let normal = self.mean_normal(&slots, width);
            let same = sets
                .iter_mut()
                .find(|(_, other)| dot(*other, normal) >= SMOOTH);
            match same {
                Some((set, _)) => set.extend(slots),
                None => sets.push((slots, normal)),
            }
        }
        sets.into_iter().map(|(slots, _)| slots).collect()
    }

    fn mean_normal(&self, slots: &[usize], width: usize) -> [f64; 3] {
        let faces = slots.iter().map(|slot| slot / width);
        let sum = faces.fold([0.0; 3], |sum, face| {
            add(sum, scale(self.areas[face], self.normals[face]))
        });
        normalised(sum).unwrap_or_default()
    }

    /// Which functions have a node that supports hold along the normals of all their faces, or of the
    /// tools that these meet: it has no gap that changes.
    fn held(&self, layout: &Layout, holding: Holding<'_>) -> Vec<bool> {
        let components = self.space.components;
        let is_held = |node: u32, normal: [f64; 3]| {
            let mut along = (0..components).filter(|&i| normal[i].abs() > HELD_ALONG);
            along.all(|i| (holding.is_held)(node * components as u32 + i as u32))
        };
        let mut held = vec![true; layout.nodes.len()];
        for (face, functions) in layout.faces.iter().enumerate() {
            let tool = holding.tools.get(face).copied().flatten();
            for (&function, &node) in functions.iter().zip(&self.nodes[face]) {
                held[function as usize] &= is_held(node, self.normals[face])
                    || tool.is_some_and(|normal| is_held(node, normal));
            }
        }
        held
    }

    /// The nearest free functions on the faces of function `k`.
    fn nearest(&self, layout: &Layout, (k, faces): (usize, &[u32]), held: &[bool]) -> Vec<u32> {
        let from = self.position(layout.nodes[k]);
        let mut found: Vec<(u32, f64)> = Vec::new();
        for &face in faces {
            for &function in &layout.faces[face as usize] {
                if !held[function as usize] {
                    let at = self.position(layout.nodes[function as usize]);
                    found.push((function, norm(sub(at, from))));
                }
            }
        }
        let least = found.iter().map(|&(_, distance)| distance);
        let least = least.fold(f64::INFINITY, f64::min);
        found.retain(|&(_, distance)| distance <= (1.0 + AS_NEAR) * least);
        found.sort_unstable_by_key(|&(function, _)| function);
        found.dedup_by_key(|&mut (function, _)| function);
        found.into_iter().map(|(function, _)| function).collect()
    }

    /// A displacement node in the undeformed body, in the caller's lengths.
    fn position(&self, node: u32) -> [f64; 3] {
        self.space.node_place(self.mesh, node)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{GroupKind, samples};

    fn facets(mesh: &Mesh, names: &[&str]) -> Vec<u32> {
        let groups = names.iter().map(|name| {
            let group = mesh.group(name, GroupKind::Facets).expect("a side");
            group.members.clone()
        });
        groups.flatten().collect()
    }

    fn layout(mesh: &Mesh, names: &[&str], is_held: &dyn Fn(u32) -> bool) -> Layout {
        let space = TaylorHood::new(mesh);
        let holding = Holding {
            is_held,
            tools: &[],
        };
        Layout::by_sides(mesh, &space, &facets(mesh, names), holding)
    }

    #[test]
    fn a_flat_side_has_one_function_a_node() {
        let mesh = samples::cube(2);
        let side = layout(&mesh, &["z1"], &|_| false);
        assert_eq!(side.nodes.len(), 25);
        assert!(side.nodes.is_sorted());
        assert_eq!(side.shares, Shares::identity(25));
    }

    #[test]
    fn sides_that_meet_at_a_sharp_edge_have_functions_of_their_own_there() {
        let mesh = samples::cube(2);
        let both = layout(&mesh, &["z1", "x1"], &|_| false);
        assert_eq!(both.nodes.len(), 2 * 25);
        let plane = samples::rectangle(3, 2);
        assert_eq!(layout(&plane, &["y1", "x1"], &|_| false).nodes.len(), 7 + 5);
    }

    #[test]
    fn functions_of_a_held_rim_go_to_the_nearest_free_ones() {
        let mesh = samples::cube(2);
        let space = TaylorHood::new(&mesh);
        // The normal components of all nodes on x = 0.
        let low = |node: u32| match (node as usize).checked_sub(space.vertices) {
            None => mesh.coordinates()[node as usize][0] == 0.0,
            Some(edge) => {
                let ends = space.edges[edge].map(|end| mesh.coordinates()[end as usize][0]);
                ends.iter().all(|x| x.abs() < 1e-12)
            }
        };
        let is_held = |unknown: u32| unknown % 3 == 2 && low(unknown / 3);
        let top = layout(&mesh, &["z1"], &is_held);
        assert_eq!((top.nodes.len(), top.shares.multipliers()), (25, 20));
        for function in 0..25 {
            let own: Vec<(u32, f64)> = top.shares.of(function).collect();
            let sum: f64 = own.iter().map(|(_, share)| share).sum();
            assert!((sum - 1.0).abs() < 1e-15 && own.iter().all(|(_, share)| *share > 0.0));
            assert!(own.len() == 1 || low(top.nodes[function as usize]));
        }
        // Held along another direction, nothing is held here.
        let along = layout(&mesh, &["z1"], &|unknown| unknown % 3 == 0);
        assert_eq!(along.shares, Shares::identity(25));
    }

    #[test]
    fn a_surface_without_free_nodes_has_no_multiplier() {
        let mesh = samples::rectangle(2, 1);
        let held = layout(&mesh, &["y1"], &|_| true);
        assert_eq!((held.nodes.len(), held.shares.multipliers()), (5, 0));
    }

    #[test]
    fn parts_of_a_surface_share_the_multipliers_between_them() {
        let mesh = samples::rectangle(2, 1);
        let whole = layout(&mesh, &["y1"], &|_| false);
        let (left, own) = whole.part(0..1);
        let (right, other) = whole.part(1..2);
        assert_eq!((left.nodes.len(), right.nodes.len()), (3, 3));
        let common: Vec<&u32> = own.iter().filter(|m| other.contains(m)).collect();
        assert_eq!(common.len(), 1);
        assert_eq!(whole.nodes[*common[0] as usize], 4);
    }
}
