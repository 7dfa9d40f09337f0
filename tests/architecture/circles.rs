//! Circles of a graph: its strongly connected components of two nodes and more.
//! Reference: R. Tarjan, "Depth-first search and linear graph algorithms", 1972.

use std::collections::BTreeSet;

/// Sets of nodes that reach each other; `edges[i]` are the nodes that `i` leads to.
pub(crate) fn circles(edges: &[BTreeSet<usize>]) -> Vec<BTreeSet<usize>> {
    let mut search = Search {
        edges,
        number: vec![None; edges.len()],
        lowest: vec![0; edges.len()],
        open: Vec::new(),
        visited: 0,
        found: Vec::new(),
    };
    for node in 0..edges.len() {
        if search.number[node].is_none() {
            search.visit(node);
        }
    }
    search.found
}

struct Search<'a> {
    edges: &'a [BTreeSet<usize>],
    /// In order of the visits.
    number: Vec<Option<usize>>,
    /// Least number that a node is known to reach.
    lowest: Vec<usize>,
    /// Visited nodes whose component is not complete.
    open: Vec<usize>,
    visited: usize,
    found: Vec<BTreeSet<usize>>,
}

impl Search<'_> {
    fn visit(&mut self, node: usize) {
        let number = self.visited;
        self.visited += 1;
        self.number[node] = Some(number);
        self.lowest[node] = number;
        self.open.push(node);
        for &next in &self.edges[node] {
            match self.number[next] {
                None => {
                    self.visit(next);
                    self.lowest[node] = self.lowest[node].min(self.lowest[next]);
                }
                Some(earlier) if self.open.contains(&next) => {
                    self.lowest[node] = self.lowest[node].min(earlier);
                }
                Some(_) => {}
            }
        }
        if self.lowest[node] == number {
            self.close(node);
        }
    }

    /// Everything visited since `node` is one component.
    fn close(&mut self, node: usize) {
        let start = self.open.iter().position(|open| *open == node);
        let component: BTreeSet<usize> = self.open.drain(start.unwrap_or_default()..).collect();
        if component.len() > 1 {
            self.found.push(component);
        }
    }
}

#[test]
fn circles_are_found_and_ways_without_return_are_not() {
    let edges = [
        vec![1],
        vec![2, 3],
        vec![0],
        vec![4],
        vec![5],
        vec![4],
        vec![],
    ];
    let edges = edges.map(BTreeSet::from_iter);
    let found = circles(&edges);
    assert_eq!(found, [BTreeSet::from([4, 5]), BTreeSet::from([0, 1, 2])]);
}
