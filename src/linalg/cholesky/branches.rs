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
//! with the same bits. Memory: one number for each unknown and each row of each supernode. Cost: one
//! reading of L for each of the two.

use super::tree::{ALONE, Node, Tree};
use super::triangle::{Factor, solve_lower, solve_upper};
use crate::linalg::Workspace;

impl Tree {
    /// Solves L L^T x = b for one right-hand side `[size]` in place, `values` being the entries of
    /// the factor.
    pub(super) fn solve<T: Factor>(&self, values: &[T], b: &mut [f64], work: &mut Workspace) {
        let mut x = T::take(work, self.order.len());
        let mut updates = T::take(work, self.places.len());
        for (x, &unknown) in x.iter_mut().zip(&self.order) {
            *x = T::narrow(b[unknown as usize]);
        }
        let solve = Solve { tree: self, values };
        let roots = &self.children[self.roots..];
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

/// Unknowns of branches that lie one after the other, and what they hand on.
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
        &self.values[node.values..node.values + node.width * (node.width + node.rows)]
    }

    /// The nodes below `node`.
    fn children(&self, node: &Node) -> &[usize] {
        &self.tree.children[node.children.clone()]
    }

    /// Where the unknowns and the rows of a branch begin.
    fn start(&self, branch: usize) -> (usize, usize) {
        let first = &self.tree.nodes[self.tree.nodes[branch].begin];
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

    /// Runs both halves of `branches`, on any threads where they are worth it.
    fn both(&self, branches: &[usize], low: impl FnOnce() + Send, high: impl FnOnce() + Send) {
        let entries = branches
            .iter()
            .map(|&branch| self.tree.nodes[branch].entries);
        if entries.sum::<usize>() > ALONE {
            rayon::join(low, high);
        } else {
            low();
            high();
        }
    }

    /// L y = b on `branches`, which `pieces` belong to.
    fn forward_all(&self, branches: &[usize], pieces: Pieces<'_, T>) {
        match branches {
            [] => (),
            [branch] => self.forward(*branch, pieces),
            branches => {
                let [low, high] = self.halves(branches, pieces);
                self.both(
                    branches,
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
            for node in &self.tree.nodes[node.begin..=branch] {
                self.forward_at(node, start, &mut pieces);
            }
            return;
        }
        let own = (node.first - start.0, node.below - start.1);
        self.forward_all(self.children(node), pieces.reborrow().split_at(own).0);
        self.forward_at(node, start, &mut pieces);
    }

    /// L y = b at one node, whose children are done; `start` is where `pieces` begin.
    fn forward_at(&self, node: &Node, start: (usize, usize), pieces: &mut Pieces<'_, T>) {
        let x = &mut pieces.x[node.first - start.0..][..node.width];
        let (done, below) = pieces.updates.split_at_mut(node.below - start.1);
        let below = &mut below[..node.rows];
        below.fill(T::default());
        for &kid in self.children(node) {
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
                self.both(
                    branches,
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
        let (children, own) = pieces.split_at((node.first - start.0, node.below - start.1));
        self.backward_at(node, (own.x, own.updates), above);
        if node.splits {
            self.backward_all(self.children(node), children, (own.x, own.updates));
            return;
        }
        for index in (node.begin..branch).rev() {
            let node = &self.tree.nodes[index];
            let parent = &self.tree.nodes[node.parent];
            let (x, later_x) = children.x.split_at_mut(node.first + node.width - start.0);
            let (below, later) = children
                .updates
                .split_at_mut(node.below + node.rows - start.1);
            let x = &mut x[node.first - start.0..];
            let below = &mut below[node.below - start.1..];
            let above = if node.parent == branch {
                (&*own.x, &*own.updates)
            } else {
                (
                    &later_x[parent.first - node.first - node.width..][..parent.width],
                    &later[parent.below - node.below - node.rows..][..parent.rows],
                )
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
