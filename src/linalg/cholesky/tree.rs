//! The elimination tree of a supernodal factor. Unknowns stand in the order of a walk that visits
//! children first, so that a branch is one piece of each vector. Memory: four bytes for each
//! unknown and each row of each supernode, and some hundred a supernode.

use std::collections::BinaryHeap;

/// Entries of a factor that are not worth a second thread.
pub(super) const ALONE: usize = 1 << 16;
/// Branches with less than this part of all entries are not split.
const FINEST: usize = 16;
/// Supernodes that may split branches; bounds how deep calls nest.
const MOST_SPLITS: usize = 64;
/// What stands for the parent of a root.
const NONE: usize = usize::MAX;

/// One supernode of a factor, in the factor's numbering.
pub(super) struct Supernode<'a> {
    /// Its first column.
    pub(super) first: usize,
    /// Its columns.
    pub(super) width: usize,
    /// Rows below them, ascending.
    pub(super) below: &'a [u32],
    /// Where its entries begin, column by column.
    pub(super) values: usize,
}

/// A supernode in the order of the walk.
#[derive(Clone, Debug)]
pub(super) struct Node {
    /// Where its entries begin.
    pub(super) values: usize,
    /// Place of its first unknown.
    pub(super) first: usize,
    /// Unknowns.
    pub(super) width: usize,
    /// Where its rows below begin among those of all.
    pub(super) below: usize,
    /// How many there are.
    pub(super) rows: usize,
    /// How many of them are unknowns of the parent; the others are below it too.
    pub(super) inner: usize,
    /// Its parent, or [`NONE`].
    pub(super) parent: usize,
    /// The first node of its branch.
    pub(super) begin: usize,
    /// Entries of the branch.
    pub(super) entries: usize,
    /// Its children are entries `[begin, end)` of [`Tree::children`].
    pub(super) children: std::ops::Range<usize>,
    /// Whether its children are branches of their own.
    pub(super) splits: bool,
}

/// The elimination tree of a factor.
#[derive(Clone, Debug)]
pub(super) struct Tree {
    /// Children before parents.
    pub(super) nodes: Vec<Node>,
    /// Children of all nodes, ascending for each, the roots after them.
    pub(super) children: Vec<usize>,
    /// Where the roots begin.
    pub(super) roots: usize,
    /// Of each row below a node, its place in the parent's unknowns and rows.
    pub(super) places: Vec<u32>,
    /// Unknown at each place `[size]`.
    pub(super) order: Vec<u32>,
}

impl Tree {
    /// The tree of a factor whose column k belongs to unknown `unknowns[k]`.
    pub(super) fn new(supernodes: &[Supernode<'_>], unknowns: &[u32]) -> Self {
        let parents = parents(supernodes, unknowns.len());
        let walk = walk(&parents);
        let mut number = vec![NONE; supernodes.len()];
        for (place, &index) in walk.iter().enumerate() {
            number[index] = place;
        }
        let mut tree = Self {
            nodes: Vec::with_capacity(walk.len()),
            children: Vec::new(),
            roots: 0,
            places: Vec::new(),
            order: Vec::with_capacity(unknowns.len()),
        };
        for &index in &walk {
            let parent = parents[index];
            tree.push(&supernodes[index], parent.map_or(NONE, |p| number[p]));
            let columns =
                supernodes[index].first..supernodes[index].first + supernodes[index].width;
            tree.order.extend_from_slice(&unknowns[columns]);
            if let Some(parent) = parent {
                tree.place(&supernodes[index], &supernodes[parent]);
            }
        }
        tree.connect();
        tree.split();
        tree
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> u64 {
        let words = self.places.len() + self.order.len();
        (4 * words + size_of::<Node>() * self.nodes.len() + 8 * self.children.len()) as u64
    }

    /// Adds a node after all others.
    fn push(&mut self, supernode: &Supernode<'_>, parent: usize) {
        self.nodes.push(Node {
            values: supernode.values,
            first: self.order.len(),
            width: supernode.width,
            below: self.places.len(),
            rows: supernode.below.len(),
            inner: 0,
            parent,
            begin: self.nodes.len(),
            entries: supernode.width * (supernode.width + supernode.below.len()),
            children: 0..0,
            splits: false,
        });
    }

    /// Finds the rows below the last node among its parent's.
    fn place(&mut self, own: &Supernode<'_>, parent: &Supernode<'_>) {
        let end = parent.first + parent.width;
        let inner = own.below.partition_point(|&row| (row as usize) < end);
        let places = own.below[..inner].iter();
        self.places
            .extend(places.map(|&row| row - parent.first as u32));
        let mut place = 0;
        for row in &own.below[inner..] {
            while parent.below[place] != *row {
                place += 1;
            }
            self.places.push((parent.width + place) as u32);
        }
        if let Some(node) = self.nodes.last_mut() {
            node.inner = inner;
        }
    }

    /// Lists the children of all nodes, and where branches begin.
    fn connect(&mut self) {
        let mut children = vec![Vec::new(); self.nodes.len()];
        let mut roots = Vec::new();
        for index in 0..self.nodes.len() {
            let (parent, begin) = (self.nodes[index].parent, self.nodes[index].begin);
            let entries = self.nodes[index].entries;
            match parent {
                NONE => roots.push(index),
                parent => {
                    children[parent].push(index);
                    let above = &mut self.nodes[parent];
                    above.begin = above.begin.min(begin);
                    above.entries += entries;
                }
            }
        }
        for (node, own) in self.nodes.iter_mut().zip(children) {
            node.children = self.children.len()..self.children.len() + own.len();
            self.children.extend(own);
        }
        self.roots = self.children.len();
        self.children.extend(roots);
    }

    /// Chooses the nodes whose children run on any threads: the largest branches are split until
    /// all are small. A choice by the factor alone.
    fn split(&mut self) {
        let nodes = &self.nodes;
        let with_entries = |&index: &usize| (nodes[index].entries, index);
        let roots = &self.children[self.roots..];
        let total: usize = roots.iter().map(|&root| nodes[root].entries).sum();
        let mut largest: BinaryHeap<_> = roots.iter().map(with_entries).collect();
        let least = ALONE.max(total / FINEST);
        let mut split = Vec::new();
        while let Some((_, index)) = largest.pop().filter(|&(entries, _)| entries > least)
            && split.len() < MOST_SPLITS
        {
            split.push(index);
            let children = &self.children[nodes[index].children.clone()];
            largest.extend(children.iter().map(with_entries));
        }
        for index in split {
            self.nodes[index].splits = true;
        }
    }
}

/// The parent of each supernode: that of the first row below it.
fn parents(supernodes: &[Supernode<'_>], size: usize) -> Vec<Option<usize>> {
    let mut owner = vec![NONE; size];
    for (index, supernode) in supernodes.iter().enumerate() {
        owner[supernode.first..supernode.first + supernode.width].fill(index);
    }
    let above = |s: &Supernode<'_>| s.below.first().map(|&row| owner[row as usize]);
    supernodes.iter().map(above).collect()
}

/// All supernodes, children before parents and branches in one piece.
fn walk(parents: &[Option<usize>]) -> Vec<usize> {
    let mut children = vec![Vec::new(); parents.len()];
    let mut open = Vec::new();
    for (index, parent) in parents.iter().enumerate() {
        match parent {
            Some(parent) => children[*parent].push(index),
            None => open.push(index),
        }
    }
    // Parents before children, the last first, and then all of it backwards.
    let mut walk = Vec::with_capacity(parents.len());
    while let Some(index) = open.pop() {
        walk.push(index);
        open.append(&mut children[index]);
    }
    walk.reverse();
    walk
}

#[cfg(test)]
impl Tree {
    /// How many nodes have branches of their own.
    pub(super) fn splits(&self) -> usize {
        self.nodes.iter().filter(|node| node.splits).count()
    }
}
