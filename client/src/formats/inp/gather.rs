//! Facets and elements with lists of their groups.
//!
//! Elements of the same groups share one list, so that lists take no more memory than
//! the sets that they come from.

use std::collections::{HashMap, HashSet};

use super::sets::Order;

/// Lists of groups, each by the list before it and its last group; 0 is the empty list.
#[derive(Default)]
pub(super) struct Lists {
    parents: Vec<(u32, i64)>,
    index: HashMap<(u32, i64), u32>,
}

impl Lists {
    /// A list with one more group, unless it ends with this one.
    pub(super) fn with(&mut self, list: u32, group: i64) -> u32 {
        if self.last(list).is_some_and(|(_, last)| last == group) {
            return list;
        }
        let next = self.parents.len() as u32 + 1;
        let found = *self.index.entry((list, group)).or_insert(next);
        if found == next {
            self.parents.push((list, group));
        }
        found
    }

    fn last(&self, list: u32) -> Option<(u32, i64)> {
        self.parents.get((list as usize).checked_sub(1)?).copied()
    }

    /// The groups of a list.
    pub(super) fn groups(&self, mut list: u32) -> Vec<i64> {
        let mut groups = Vec::new();
        while let Some((before, group)) = self.last(list) {
            groups.push(group);
            list = before;
        }
        groups
    }
}

/// Facets with their groups, each once.
#[derive(Default)]
pub(super) struct Facets {
    index: HashMap<[u64; 3], usize>,
    /// Nodes of each; a segment fills up with the largest number.
    pub(super) nodes: Vec<[u64; 3]>,
    pub(super) lists: Vec<u32>,
}

impl Facets {
    pub(super) fn add(&mut self, facet: &[u64], group: i64, lists: &mut Lists) {
        let mut nodes = [u64::MAX; 3];
        nodes
            .iter_mut()
            .zip(facet)
            .for_each(|(slot, node)| *slot = *node);
        let mut key = nodes;
        key.sort_unstable();
        let next = self.nodes.len();
        let at = *self.index.entry(key).or_insert(next);
        if at == next {
            self.nodes.push(nodes);
            self.lists.push(0);
        }
        if let Some(list) = self.lists.get_mut(at) {
            *list = lists.with(*list, group);
        }
    }
}

/// Faces of cells, which elements of the surface have to be.
#[derive(Default)]
pub(super) struct OfCells {
    faces: HashSet<[u64; 3]>,
    apart: HashSet<[u64; 3]>,
}

impl OfCells {
    pub(super) fn add(&mut self, face: &[u64; 3]) {
        self.faces.insert(sorted(face));
    }

    /// Whether a facet is one of them; others are counted.
    pub(super) fn has(&mut self, facet: &[u64; 3]) -> bool {
        let key = sorted(facet);
        let is_one = self.faces.contains(&key);
        if !is_one {
            self.apart.insert(key);
        }
        is_one
    }

    /// Facets that were none.
    pub(super) fn apart(&self) -> usize {
        self.apart.len()
    }
}

/// What is equal for facets of the same nodes.
pub(super) fn sorted(facet: &[u64]) -> [u64; 3] {
    let mut key = [u64::MAX; 3];
    key.iter_mut()
        .zip(facet)
        .for_each(|(slot, node)| *slot = *node);
    key.sort_unstable();
    key
}

/// Outer faces by positions of their corners, in the order of the lowest one.
pub(super) struct Corners {
    /// Faces of fewer than four corners fill up with the largest number.
    faces: Vec<[u32; 4]>,
    lowest: Vec<(u32, u32)>,
}

impl Corners {
    pub(super) fn new(faces: &[[u64; 4]], order: &Order) -> Self {
        let position = |node: u64| order.position(node).unwrap_or(u32::MAX);
        let faces: Vec<[u32; 4]> = faces.iter().map(|face| face.map(position)).collect();
        let lowest = faces
            .iter()
            .map(|face| face.iter().min().copied().unwrap_or(u32::MAX));
        let mut lowest: Vec<(u32, u32)> = lowest.zip(0..).collect();
        lowest.sort_unstable();
        Self { faces, lowest }
    }

    /// Faces with all corners among some nodes, which are marked.
    pub(super) fn within(&self, nodes: &[u32], marks: &Marks) -> Vec<[u32; 4]> {
        let faces = nodes.iter().flat_map(|lowest| self.with_lowest(*lowest));
        let inside = |face: &[u32; 4]| {
            let mut corners = face.iter().filter(|corner| **corner != u32::MAX);
            corners.all(|corner| marks.has(*corner))
        };
        faces.filter(inside).collect()
    }

    /// Faces whose lowest corner this is.
    fn with_lowest(&self, corner: u32) -> impl Iterator<Item = [u32; 4]> {
        let from = self.lowest.partition_point(|(lowest, _)| *lowest < corner);
        let same = self
            .lowest
            .iter()
            .skip(from)
            .take_while(move |(lowest, _)| *lowest == corner);
        same.filter_map(|(_, row)| self.faces.get(*row as usize).copied())
    }
}

/// Nodes by position, of one set at a time.
pub(super) struct Marks {
    sets: Vec<u32>,
    current: u32,
}

impl Marks {
    pub(super) fn new(nodes: usize) -> Self {
        Self {
            sets: vec![0; nodes],
            current: 0,
        }
    }

    /// Marks these nodes and no others.
    pub(super) fn set(&mut self, nodes: &[u32]) {
        self.current += 1;
        for node in nodes {
            if let Some(mark) = self.sets.get_mut(*node as usize) {
                *mark = self.current;
            }
        }
    }

    fn has(&self, node: u32) -> bool {
        self.sets.get(node as usize) == Some(&self.current)
    }
}
