//! Sets of nodes become groups of the outer faces whose corners are all in the set.

use std::collections::HashSet;

use super::build::{Builder, parts};
use super::deck::{Entry, Face};
use super::error::InpFault;
use super::gather::{Corners, Marks, sorted};
use super::sets::{Order, Set, Visibility};
use crate::formats::mesh::split::picked;

/// Names that a warning spells out.
const SPELLED: usize = 5;

impl Builder {
    /// Outer faces of the cells, whole ones where all their parts are outer, in ascending order
    /// of their sorted nodes.
    fn outer_faces(&self) -> Vec<[u64; 4]> {
        let outer: HashSet<[u64; 3]> = self
            .outer_facets()
            .chunks_exact(self.dimension)
            .map(sorted)
            .collect();
        let is_outer = |facet: &[u64; 3]| outer.contains(&sorted(facet));
        let mut faces = Vec::new();
        let elements = self.deck.elements.iter();
        for element in elements.filter(|element| element.kind.dimension == self.dimension) {
            let nodes = self.deck.nodes_of(element);
            for local in element.kind.faces() {
                let face = picked(nodes, local);
                let parts = || parts(face, self.dimension);
                if parts().all(|facet| is_outer(&facet)) {
                    faces.push(face);
                } else {
                    let alone = parts().filter(is_outer);
                    faces.extend(alone.map(|[a, b, c]| [a, b, c, u64::MAX]));
                }
            }
        }
        faces.sort_by_cached_key(|face| {
            let mut key = *face;
            key.sort_unstable();
            key
        });
        faces
    }

    /// Sets of nodes: outer facets with all corners in the set.
    pub(super) fn node_sets(&mut self) -> Result<(), InpFault> {
        let sets = std::mem::take(&mut self.deck.node_sets);
        let is_group = |set: &&Set| set.visibility == Visibility::Group;
        if !sets.all.iter().any(|set| is_group(&set)) {
            return Ok(());
        }
        let order = Order::new(self.deck.nodes.iter().map(|(number, _)| *number));
        let corners = Corners::new(&self.outer_faces(), &order);
        let mut marks = Marks::new(self.deck.nodes.len());
        let mut without = Vec::new();
        for (index, set) in sets.all.iter().enumerate().filter(|(_, set)| is_group(set)) {
            if self.has_group(self.dimension - 1, &set.name) {
                continue;
            }
            let mut members = order.members(set, &mut self.allowance)?;
            self.add_nodes_of_elements(index, &order, &mut members)?;
            // Sets of reference points alone.
            if members.is_empty() && set.is_empty() {
                continue;
            }
            marks.set(&members);
            let found = corners.within(&members, &marks);
            if found.is_empty() {
                without.push(set.name.as_str());
                continue;
            }
            let group = self.group(self.dimension - 1, &set.name);
            for face in found {
                let number = |at: u32| self.deck.nodes.get(at as usize).map(|node| node.0);
                let face = face.map(|at| number(at).unwrap_or(u64::MAX));
                for facet in parts(face, self.dimension) {
                    self.facets.add(&facet, group, &mut self.lists);
                }
            }
        }
        self.warn_without_facets(&without);
        Ok(())
    }

    /// Adds the nodes of the sets of elements that a set of nodes is made of.
    fn add_nodes_of_elements(
        &mut self,
        set: usize,
        order: &Order,
        members: &mut Vec<u32>,
    ) -> Result<(), InpFault> {
        let pairs = self.deck.nodes_of_elements.iter();
        let elements: Vec<usize> = pairs
            .filter(|(of, _)| *of == set)
            .map(|pair| pair.1)
            .collect();
        for elements in elements {
            members.extend(self.nodes_of_set(elements, order)?);
        }
        members.sort_unstable();
        members.dedup();
        Ok(())
    }

    fn warn_without_facets(&mut self, names: &[&str]) {
        if names.is_empty() {
            return;
        }
        let spelled: Vec<&str> = names.iter().take(SPELLED).copied().collect();
        let more = match names.len().saturating_sub(SPELLED) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        self.deck.warnings.push(format!(
            "sets of nodes that hold no whole facet of the surface are left out: {}{more}",
            spelled.join(", ")
        ));
    }

    /// Positions of the nodes of a set of elements.
    fn nodes_of_set(&mut self, set: usize, order: &Order) -> Result<Vec<u32>, InpFault> {
        let entry = Entry {
            of: Ok(set),
            face: Face::Outer,
        };
        let mut positions = Vec::new();
        for element in self.elements_of(&entry)? {
            let nodes = self.deck.nodes_of(&element);
            self.allowance.take(nodes.len())?;
            positions.extend(nodes.iter().filter_map(|node| order.position(*node)));
        }
        Ok(positions)
    }
}
