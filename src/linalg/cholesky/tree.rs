//! Solves with a supernodal factor, branch by branch of its elimination tree. With the columns
//! of supernode s, the rows R_s below them, and L_s split likewise into a triangle and a rest:
//!
//! ```text
//! L y = b      (y_s, u_s) = (T_s^-1 (b_s + sums of u_c), sums of u_c - L_s y_s),   c the children of s
//! L^T x = y    x_s = T_s^-T (y_s - L_s^T x_R)
//! ```
//!
//! Every supernode hands what it takes off later rows to its parent (as in the multifrontal method:
//! J. Liu, SIAM Review 34, 1992), so that branches share nothing and run on any threads
//! with the same bits. Unknowns stand in the order of a walk that visits children first, and a
//! branch is one piece of each vector. Memory: four bytes for each row of each supernode. Cost: one
//! reading of L for each of the two.

use std::collections::BinaryHeap;

use super::triangle::{Factor, solve_lower, solve_upper};
use crate::linalg::Workspace;

/// Entries of a factor that are not worth a second thread.
const ALONE: usize = 1 << 16;
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
struct Node {
    /// Where its entries begin.
    values: usize,
    /// Place of its first unknown.
    first: usize,
    /// Unknowns.
    width: usize,
    /// Where its rows below begin among those of all.
    below: usize,
    /// How many there are.
    rows: usize,
    /// How many of them are unknowns of the parent; the others are below it too.
    inner: usize,
    /// Its parent, or [`NONE`].
    parent: usize,
    /// The first node of its branch.
    branch: usize,
    /// Its children are the nodes `kids[begin..end]`.
    kids: std::ops::Range<usize>,
    /// Whether its children are branches of their own.
    splits: bool,
}

/// The elimination tree of a factor.
#[derive(Clone, Debug)]
pub(super) struct Tree {
    /// Children before parents.
    nodes: Vec<Node>,
    /// Children of all nodes, ascending for each, the roots behind them.
    kids: Vec<usize>,
    /// Where the roots begin.
    roots: usize,
    /// Of each row below a node, its place in the parent's unknowns and rows.
    places: Vec<u32>,
    /// Unknown at each place `[size]`.
    order: Vec<u32>,
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
            kids: Vec::new(),
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
            match parent {
                Some(parent) => tree.place(&supernodes[index], &supernodes[parent]),
                None => debug_assert!(supernodes[index].below.is_empty()),
            }
        }
        tree.connect();
        tree.split();
        tree
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> u64 {
        let words = self.places.len() + self.order.len();
        (4 * words + size_of::<Node>() * self.nodes.len() + 8 * self.kids.len()) as u64
    }

    /// Adds a node behind all others.
    fn push(&mut self, supernode: &Supernode<'_>, parent: usize) {
        self.nodes.push(Node {
            values: supernode.values,
            first: self.order.len(),
            width: supernode.width,
            below: self.places.len(),
            rows: supernode.below.len(),
            inner: 0,
            parent,
            branch: self.nodes.len(),
            kids: 0..0,
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
        let mut kids = vec![Vec::new(); self.nodes.len()];
        let mut roots = Vec::new();
        for index in 0..self.nodes.len() {
            let (parent, branch) = (self.nodes[index].parent, self.nodes[index].branch);
            match parent {
                NONE => roots.push(index),
                parent => {
                    kids[parent].push(index);
                    self.nodes[parent].branch = self.nodes[parent].branch.min(branch);
                }
            }
        }
        for (node, own) in self.nodes.iter_mut().zip(kids) {
            node.kids = self.kids.len()..self.kids.len() + own.len();
            self.kids.extend(own);
        }
        self.roots = self.kids.len();
        self.kids.extend(roots);
    }

    /// Chooses the nodes whose children run on any threads: the largest branches are split until
    /// all are small. A choice by the factor alone.
    fn split(&mut self) {
        let mut entries: Vec<usize> = self.nodes.iter().map(Node::entries).collect();
        for index in 0..self.nodes.len() {
            if let Some(above) = entries.get(self.nodes[index].parent) {
                entries[self.nodes[index].parent] = above + entries[index];
            }
        }
        let with_entries = |&index: &usize| (entries[index], index);
        let roots = &self.kids[self.roots..];
        let total: usize = roots.iter().map(|&root| entries[root]).sum();
        let mut largest: BinaryHeap<_> = roots.iter().map(with_entries).collect();
        let least = ALONE.max(total / FINEST);
        for _ in 0..MOST_SPLITS {
            let Some((_, index)) = largest.pop().filter(|&(entries, _)| entries > least) else {
                break;
            };
            self.nodes[index].splits = true;
            largest.extend(
                self.kids[self.nodes[index].kids.clone()]
                    .iter()
                    .map(with_entries),
            );
        }
    }

    /// Solves L L^T x = b for one right-hand side `[size]` in place, `values` being the entries of
    /// the factor.
    pub(super) fn solve<T: Factor>(&self, values: &[T], b: &mut [f64], work: &mut Workspace) {
        let mut x = T::take(work, self.order.len());
        let mut updates = T::take(work, self.places.len());
        for (x, &unknown) in x.iter_mut().zip(&self.order) {
            *x = T::narrow(b[unknown as usize]);
        }
        let solve = Solve { tree: self, values };
        let roots = &self.kids[self.roots..];
        let mut all = Pieces {
            x: &mut x,
            updates: &mut updates,
        };
        solve.forward_all(roots, all.reborrow());
        solve.backward_all(roots, all, (&[], &[]));
        for (x, &unknown) in x.iter().zip(&self.order) {
            b[unknown as usize] = x.widen();
        }
        T::give(work, x);
        T::give(work, updates);
    }
}

impl Node {
    fn entries(&self) -> usize {
        self.width * (self.width + self.rows)
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
    let mut kids = vec![Vec::new(); parents.len()];
    let mut open = Vec::new();
    for (index, parent) in parents.iter().enumerate() {
        match parent {
            Some(parent) => kids[*parent].push(index),
            None => open.push(index),
        }
    }
    // Parents before children, the last first, and then all of it backwards.
    let mut walk = Vec::with_capacity(parents.len());
    while let Some(index) = open.pop() {
        walk.push(index);
        open.append(&mut kids[index]);
    }
    walk.reverse();
    walk
}

/// Unknowns of branches that lie one behind the other, and what they hand on.
struct Pieces<'v, T> {
    x: &'v mut [T],
    /// One for each row below their nodes.
    updates: &'v mut [T],
}

impl<'v, T> Pieces<'v, T> {
    fn split_at(self, (first, below): (usize, usize)) -> (Self, Self) {
        let (x, x_rest) = self.x.split_at_mut(first);
        let (updates, updates_rest) = self.updates.split_at_mut(below);
        let rest = Pieces {
            x: x_rest,
            updates: updates_rest,
        };
        (Pieces { x, updates }, rest)
    }

    fn reborrow(&mut self) -> Pieces<'_, T> {
        Pieces {
            x: self.x,
            updates: self.updates,
        }
    }
}

/// The entries of a factor with its tree.
struct Solve<'a, T> {
    tree: &'a Tree,
    values: &'a [T],
}

impl<T: Factor> Solve<'_, T> {
    fn entries(&self, node: &Node) -> &[T] {
        &self.values[node.values..node.values + node.entries()]
    }

    /// The nodes below `node`.
    fn kids(&self, node: &Node) -> &[usize] {
        &self.tree.kids[node.kids.clone()]
    }

    /// Where the unknowns and the rows of a branch begin.
    fn start(&self, branch: usize) -> (usize, usize) {
        let first = &self.tree.nodes[self.tree.nodes[branch].branch];
        (first.first, first.below)
    }

    /// `pieces` of `branches` in two halves; only for more than one.
    fn halves<'b, 'v>(
        &self,
        branches: &'b [usize],
        pieces: Pieces<'v, T>,
    ) -> [(&'b [usize], Pieces<'v, T>); 2] {
        let (low, high) = branches.split_at(branches.len() / 2);
        let (start, middle) = (self.start(low[0]), self.start(high[0]));
        let (below, above) = pieces.split_at((middle.0 - start.0, middle.1 - start.1));
        [(low, below), (high, above)]
    }

    /// L y = b on `branches`, which `pieces` belong to.
    fn forward_all(&self, branches: &[usize], pieces: Pieces<'_, T>) {
        match branches {
            [] => (),
            [branch] => self.forward(*branch, pieces),
            branches => {
                let [low, high] = self.halves(branches, pieces);
                rayon::join(
                    || self.forward_all(low.0, low.1),
                    || self.forward_all(high.0, high.1),
                );
            }
        }
    }

    /// L y = b on one branch.
    fn forward(&self, branch: usize, mut pieces: Pieces<'_, T>) {
        let node = &self.tree.nodes[branch];
        let start = self.start(branch);
        if !node.splits {
            for node in &self.tree.nodes[node.branch..=branch] {
                self.forward_at(node, start, &mut pieces);
            }
            return;
        }
        let own = (node.first - start.0, node.below - start.1);
        self.forward_all(self.kids(node), pieces.reborrow().split_at(own).0);
        self.forward_at(node, start, &mut pieces);
    }

    /// L y = b at one node, whose children are done; `start` is where `pieces` begin.
    fn forward_at(&self, node: &Node, start: (usize, usize), pieces: &mut Pieces<'_, T>) {
        let x = &mut pieces.x[node.first - start.0..][..node.width];
        let (done, below) = pieces.updates.split_at_mut(node.below - start.1);
        let below = &mut below[..node.rows];
        below.fill(T::default());
        for &kid in self.kids(node) {
            let kid = &self.tree.nodes[kid];
            let handed = &done[kid.below - start.1..][..kid.rows];
            let places = &self.tree.places[kid.below..][..kid.rows];
            let (inner, outer) = handed.split_at(kid.inner);
            for (value, &place) in inner.iter().zip(places) {
                x[place as usize] += *value;
            }
            for (value, &place) in outer.iter().zip(&places[kid.inner..]) {
                below[place as usize - node.width] += *value;
            }
        }
        solve_lower(self.entries(node), x, below);
    }

    /// L^T x = y on `branches`, which `pieces` belong to; `above` are the unknowns of their
    /// parent and of the rows below it.
    fn backward_all(&self, branches: &[usize], pieces: Pieces<'_, T>, above: (&[T], &[T])) {
        match branches {
            [] => (),
            [branch] => self.backward(*branch, pieces, above),
            branches => {
                let [low, high] = self.halves(branches, pieces);
                rayon::join(
                    || self.backward_all(low.0, low.1, above),
                    || self.backward_all(high.0, high.1, above),
                );
            }
        }
    }

    /// L^T x = y on one branch.
    fn backward(&self, branch: usize, pieces: Pieces<'_, T>, above: (&[T], &[T])) {
        let node = &self.tree.nodes[branch];
        let start = self.start(branch);
        let (kids, own) = pieces.split_at((node.first - start.0, node.below - start.1));
        self.backward_at(node, (own.x, own.updates), above);
        if node.splits {
            self.backward_all(self.kids(node), kids, (own.x, own.updates));
            return;
        }
        for index in (node.branch..branch).rev() {
            let node = &self.tree.nodes[index];
            let parent = &self.tree.nodes[node.parent];
            let (x, later_x) = kids.x.split_at_mut(node.first + node.width - start.0);
            let (below, later) = kids.updates.split_at_mut(node.below + node.rows - start.1);
            let x = &mut x[node.first - start.0..];
            let below = &mut below[node.below - start.1..];
            let above = match node.parent == branch {
                true => (&*own.x, &*own.updates),
                false => (
                    &later_x[parent.first - node.first - node.width..][..parent.width],
                    &later[parent.below - node.below - node.rows..][..parent.rows],
                ),
            };
            self.backward_at(node, (x, below), above);
        }
    }

    /// L^T x = y at one node, whose parent is done: its own unknowns and rows below from the
    /// parent's.
    fn backward_at(
        &self,
        node: &Node,
        (x, below): (&mut [T], &mut [T]),
        (parents_x, parents_rows): (&[T], &[T]),
    ) {
        let places = &self.tree.places[node.below..][..node.rows];
        let (inner, outer) = below.split_at_mut(node.inner);
        for (value, &place) in inner.iter_mut().zip(places) {
            *value = parents_x[place as usize];
        }
        for (value, &place) in outer.iter_mut().zip(&places[node.inner..]) {
            *value = parents_rows[place as usize - parents_x.len()];
        }
        solve_upper(self.entries(node), x, below);
    }
}

#[cfg(test)]
impl Tree {
    /// How many nodes have branches of their own.
    pub(super) fn splits(&self) -> usize {
        self.nodes.iter().filter(|node| node.splits).count()
    }
}
