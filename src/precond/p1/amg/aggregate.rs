//! Greedy aggregation in node order: disjoint groups of strongly coupled nodes.
//!
//! 1. A node none of whose neighbours is taken founds a group with all of them.
//! 2. A node left over joins the group, founded in 1, of its strongest neighbour.
//! 3. What remains groups with its free neighbours.
//!
//! Sequential, so that groups depend on the numbering alone. O(couplings).

use super::block_rows::Pattern;

/// A node in no group: it carries no mode.
pub(super) const NONE: u32 = u32::MAX;

/// Groups of nodes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Aggregates {
    /// Group of each node, or [`NONE`] for nodes that couple strongly to nobody
    /// `[nodes]`.
    pub(super) of_node: Vec<u32>,
    /// Number of groups.
    pub(super) count: usize,
}

impl Aggregates {
    /// Nodes of each group, ascending.
    pub(super) fn members(&self) -> Pattern {
        let mut offsets = vec![0_u32; self.count + 1];
        for &group in self.of_node.iter().filter(|&&group| group != NONE) {
            offsets[group as usize + 1] += 1;
        }
        for group in 0..self.count {
            offsets[group + 1] += offsets[group];
        }
        let mut next = offsets.clone();
        let mut indices = vec![0; offsets[self.count] as usize];
        for (node, &group) in self.of_node.iter().enumerate() {
            if group != NONE {
                indices[next[group as usize] as usize] = node as u32;
                next[group as usize] += 1;
            }
        }
        Pattern { offsets, indices }
    }
}

/// The strong couplings: zero where there is none.
struct Graph<'a> {
    /// Which nodes are coupled at all.
    pattern: &'a Pattern,
    /// Strength of each stored coupling, relative to the diagonal blocks of its nodes;
    /// zero where it is weak.
    couplings: &'a [f32],
    /// Whether a node takes part: it has a component that no support holds `[nodes]`.
    takes_part: &'a [bool],
}

impl Graph<'_> {
    /// The strong neighbours of a node with the strength of their coupling, ascending
    /// by number.
    fn neighbours(&self, node: usize) -> impl Iterator<Item = (usize, f32)> {
        let range = self.pattern.range(node);
        let indices = &self.pattern.indices[range.clone()];
        indices
            .iter()
            .zip(&self.couplings[range])
            .map(|(&column, &coupling)| (column as usize, coupling))
            .filter(|&(column, coupling)| coupling > 0.0 && self.takes_part[column])
    }
}

/// Groups the nodes that take part.
pub(super) fn aggregate(pattern: &Pattern, couplings: &[f32], takes_part: &[bool]) -> Aggregates {
    let graph = Graph {
        pattern,
        couplings,
        takes_part,
    };
    let mut groups = Aggregates {
        of_node: vec![NONE; takes_part.len()],
        count: 0,
    };
    found_groups(&graph, &mut groups);
    join_neighbours(&graph, &mut groups);
    group_the_rest(&graph, &mut groups);
    groups
}

/// First pass: a free node whose strong neighbours are all free founds a group with
/// them.
fn found_groups(graph: &Graph<'_>, groups: &mut Aggregates) {
    for node in 0..groups.of_node.len() {
        let is_free = |node: usize| groups.of_node[node] == NONE;
        let mut neighbours = graph.neighbours(node).peekable();
        let founds = graph.takes_part[node]
            && is_free(node)
            && neighbours.peek().is_some()
            && neighbours.all(|(other, _)| is_free(other));
        if founds {
            let group = groups.count as u32;
            groups.of_node[node] = group;
            for (other, _) in graph.neighbours(node) {
                groups.of_node[other] = group;
            }
            groups.count += 1;
        }
    }
}

/// Second pass: nodes left over join the group of their strongest neighbour that the
/// first pass has grouped.
fn join_neighbours(graph: &Graph<'_>, groups: &mut Aggregates) {
    // By the groups of the first pass only: chains of joined nodes would grow long.
    let founded = groups.of_node.clone();
    for node in 0..founded.len() {
        if founded[node] != NONE || !graph.takes_part[node] {
            continue;
        }
        let mut strongest = 0.0;
        for (other, coupling) in graph.neighbours(node) {
            if founded[other] != NONE && coupling > strongest {
                strongest = coupling;
                groups.of_node[node] = founded[other];
            }
        }
    }
}

/// Third pass: nodes that are still left form groups with such neighbours as are left
/// too.
fn group_the_rest(graph: &Graph<'_>, groups: &mut Aggregates) {
    for node in 0..groups.of_node.len() {
        if groups.of_node[node] != NONE || !graph.takes_part[node] {
            continue;
        }
        let group = groups.count as u32;
        groups.of_node[node] = group;
        for (other, _) in graph.neighbours(node) {
            if groups.of_node[other] == NONE {
                groups.of_node[other] = group;
            }
        }
        groups.count += 1;
    }
}
