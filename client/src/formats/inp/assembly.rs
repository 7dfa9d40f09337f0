//! Parts and their instances in one deck.
//!
//! Each instance is a copy of its part: its nodes are placed by the translation and rotation of
//! the instance, and its numbers follow those before it, so that no two are alike. Its sets and
//! surfaces keep their names; those that something else has, too, become `INSTANCE.SET`.
//! Copies are held to a multiple of the size of the file, whatever it says.

use std::collections::{HashMap, HashSet};

use super::deck::{Deck, Entry, Surface};
use super::error::InpFault;
use super::frame::Frame;
use super::sets::{Allowance, Numbers, Order, Sets};

/// Where the numbers of an instance are in the deck.
#[derive(Clone, Copy, Debug)]
pub(super) struct Instance {
    pub(super) nodes: Numbers,
    pub(super) elements: Numbers,
}

impl Deck {
    /// Adds a part as an instance of a name.
    pub(super) fn place(
        &mut self,
        part: &Self,
        name: &str,
        frame: &Frame,
        allowance: &mut Allowance,
    ) -> Result<Instance, InpFault> {
        allowance.take(part.size()).map_err(InpFault::copies)?;
        part.check_numbers()?;
        let nodes = Numbers::after(self.largest.node, part.largest.node)?;
        let elements = Numbers::after(self.largest.element, part.largest.element)?;
        for (number, point) in &part.nodes {
            self.push_node(nodes.of(*number), frame.place(*point));
        }
        for element in &part.elements {
            let own: Vec<u64> = part
                .nodes_of(element)
                .iter()
                .map(|node| nodes.of(*node))
                .collect();
            self.push(elements.of(element.number), element.kind, &own);
        }
        let node_sets = self.node_sets.adopt(&part.node_sets, name, nodes);
        let sets = self.element_sets.adopt(&part.element_sets, name, elements);
        let moved = |index: &usize, by: &[usize]| by.get(*index).copied();
        for (of, made_of) in &part.nodes_of_elements {
            let pair = moved(of, &node_sets).zip(moved(made_of, &sets));
            self.nodes_of_elements.extend(pair);
        }
        for (set, material) in &part.sections {
            let section = moved(set, &sets).map(|set| (set, material.clone()));
            self.sections.extend(section);
        }
        for surface in &part.surfaces {
            let entries = surface.entries.iter().filter_map(|entry| {
                let of = match entry.of {
                    Ok(set) => Ok(moved(&set, &sets)?),
                    Err(number) => Err(elements.of(number)),
                };
                Some(Entry {
                    of,
                    ..entry.clone()
                })
            });
            self.surfaces.push(Surface {
                name: surface.name.clone(),
                owner: name.to_owned(),
                entries: entries.collect(),
            });
        }
        Ok(Instance { nodes, elements })
    }

    /// What a copy takes: nodes, elements with their nodes, and runs of sets.
    pub(super) fn size(&self) -> usize {
        let sets = self.node_sets.size() + self.element_sets.size();
        let entries: usize = self.surfaces.iter().map(|one| 1 + one.entries.len()).sum();
        let nodes: usize = self.elements.iter().map(|one| 1 + one.kind.nodes).sum();
        1 + self.nodes.len() + nodes + sets + entries
    }

    /// Faults in the numbers of the part itself.
    fn check_numbers(&self) -> Result<(), InpFault> {
        let nodes = Order::new(self.nodes.iter().map(|node| node.0));
        if let Some(number) = nodes.repeated() {
            return Err(InpFault::Mesh(super::MeshFault::DuplicateNode(number)));
        }
        let elements = Order::new(self.elements.iter().map(|element| element.number));
        if let Some(number) = elements.repeated() {
            return Err(InpFault::DuplicateElement(number));
        }
        for element in &self.elements {
            let mut own = self.nodes_of(element).iter();
            if let Some(&node) = own.find(|node| nodes.position(**node).is_none()) {
                let element = element.number;
                return Err(InpFault::UnknownNode { element, node });
            }
        }
        Ok(())
    }

    /// Gives the sets and surfaces of instances the name of their instance where another owner
    /// has the name, too.
    pub(super) fn qualify(&mut self) {
        let mut owners: HashMap<String, HashSet<String>> = HashMap::new();
        let surfaces = self.surfaces.iter().map(|one| (&one.name, &one.owner));
        let sets = self.node_sets.all.iter().chain(&self.element_sets.all);
        for (name, owner) in surfaces.chain(sets.map(|one| (&one.name, &one.owner))) {
            let owner = owner.to_ascii_uppercase();
            owners
                .entry(name.to_ascii_uppercase())
                .or_default()
                .insert(owner);
        }
        let settle = |name: &mut String, owner: &str| {
            let owners = owners.get(&name.to_ascii_uppercase());
            if !owner.is_empty() && owners.is_some_and(|owners| owners.len() > 1) {
                *name = format!("{owner}.{name}");
            }
        };
        for surface in &mut self.surfaces {
            settle(&mut surface.name, &surface.owner);
        }
        let sets = [&mut self.node_sets, &mut self.element_sets];
        for set in sets.into_iter().flat_map(|sets: &mut Sets| &mut sets.all) {
            settle(&mut set.name, &set.owner);
        }
    }
}
