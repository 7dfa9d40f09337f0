//! What supports hold of a vector of nodes: entries, and directions of nodes that are no axes,
//!
//! ```text
//! P x = x - sum over held e (e . x) e,   A -> P A P + (1 - P)
//! ```
//!
//! The directions of a node are orthonormal and orthogonal to its held entries. A vector may be that
//! of the first nodes only, or have other unknowns after those of the nodes. Cost: one visit of
//! what is held.

use std::sync::Arc;

use super::{LinearOperator, Scalar, SparseRows, SparseRowsBuilder};

/// Directions of a node that are held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldNode {
    /// The node.
    pub node: u32,
    /// Orthonormal `[count][3]`.
    pub directions: [[f64; 3]; 3],
    /// How many.
    pub count: u8,
}

impl HeldNode {
    /// The directions.
    pub fn directions(&self) -> &[[f64; 3]] {
        &self.directions[..usize::from(self.count)]
    }

    /// P of a row of the node.
    pub fn project<R: Scalar>(&self, row: &mut [R]) {
        for direction in self.directions() {
            let part: f64 = row.iter().zip(direction).map(|(x, n)| x.widen() * n).sum();
            for (x, n) in row.iter_mut().zip(direction) {
                *x = R::narrow(x.widen() - part * n);
            }
        }
    }

    /// P B P + s (1 - P) of a block of the node `[components, components]`, row by row, s being
    /// `stiffness`.
    pub fn project_block(&self, block: &mut [f64], components: usize, stiffness: f64) {
        for row in block.chunks_exact_mut(components) {
            self.project(row);
        }
        for j in 0..components {
            let mut column: [f64; 3] = [0.0; 3];
            (0..components).for_each(|i| column[i] = block[i * components + j]);
            self.project(&mut column[..components]);
            (0..components).for_each(|i| block[i * components + j] = column[i]);
        }
        for direction in self.directions() {
            for i in 0..components {
                for j in 0..components {
                    block[i * components + j] += stiffness * direction[i] * direction[j];
                }
            }
        }
    }
}

/// All that is held.
#[derive(Clone, Debug)]
pub struct Held {
    /// Entries of a node.
    pub components: usize,
    /// Ascending indices of held entries.
    pub entries: Arc<[u32]>,
    /// Nodes with directions that are no axes, ascending.
    pub nodes: Arc<[HeldNode]>,
}

impl Held {
    /// Entries alone.
    pub fn of_entries(components: usize, entries: impl Into<Arc<[u32]>>) -> Self {
        Self {
            components,
            entries: entries.into(),
            nodes: Arc::new([]),
        }
    }

    /// x -> P x.
    pub fn mask<R: Scalar>(&self, x: &mut [R]) {
        let inside = self
            .entries
            .partition_point(|&entry| (entry as usize) < x.len());
        for &index in &self.entries[..inside] {
            x[index as usize] = R::default();
        }
        self.mask_nodes(x);
    }

    /// The same for directions alone.
    pub fn mask_nodes<R: Scalar>(&self, x: &mut [R]) {
        for one in self.nodes.iter() {
            let first = one.node as usize * self.components;
            if let Some(row) = x.get_mut(first..first + self.components) {
                one.project(row);
            }
        }
    }

    /// Adds `factor` (1 - P) x to `y`.
    pub fn add_held<R: Scalar>(&self, factor: f64, x: &[R], y: &mut [R]) {
        for &index in self.entries.iter() {
            let index = index as usize;
            y[index] = R::narrow(y[index].widen() + factor * x[index].widen());
        }
        for one in self.nodes.iter() {
            let own = one.node as usize * self.components..;
            let row = &x[own.clone()][..self.components];
            for direction in one.directions() {
                let part: f64 = row.iter().zip(direction).map(|(x, n)| x.widen() * n).sum();
                let target = y[own.clone()].iter_mut().zip(direction);
                for (y, n) in target.take(self.components) {
                    *y = R::narrow(y.widen() + factor * part * n);
                }
            }
        }
    }

    /// Squares of the parts along what is held.
    pub fn square<R: Scalar>(&self, x: &[R]) -> f64 {
        let entries = self
            .entries
            .iter()
            .map(|&index| x[index as usize].widen().powi(2));
        let along = self.nodes.iter().flat_map(|one| {
            let row = &x[one.node as usize * self.components..];
            one.directions().iter().map(move |direction| {
                let terms = row.iter().zip(direction).take(self.components);
                terms.map(|(x, n)| x.widen() * n).sum::<f64>().powi(2)
            })
        });
        entries.chain(along).sum()
    }

    /// A row of a matrix with its columns projected; columns ascend, and of a node all are there or
    /// none.
    fn project_row(&self, row: &mut [(u32, f64)]) {
        let c = self.components as u32;
        let mut place = 0;
        while place < row.len() {
            let node = row[place].0 / c;
            let end = place
                + row[place..]
                    .iter()
                    .take_while(|entry| entry.0 / c == node)
                    .count();
            if let Ok(found) = self.nodes.binary_search_by_key(&node, |one| one.node) {
                let mut values = [0.0; 3];
                for &(column, value) in &row[place..end] {
                    values[(column % c) as usize] = value;
                }
                self.nodes[found].project(&mut values[..self.components]);
                for (column, value) in &mut row[place..end] {
                    *value = values[(*column % c) as usize];
                }
            }
            place = end;
        }
    }

    /// P M P of a matrix of the nodes, entries that are held left out already.
    pub fn project_matrix(&self, matrix: SparseRows) -> SparseRows {
        let columns_done = self.project_columns(matrix);
        if self.nodes.is_empty() {
            columns_done
        } else {
            self.project_columns(columns_done.transposed()).transposed()
        }
    }

    /// M P.
    pub fn project_columns(&self, matrix: SparseRows) -> SparseRows {
        if self.nodes.is_empty() {
            return matrix;
        }
        let mut builder = SparseRowsBuilder::new(matrix.columns());
        for row in 0..matrix.rows() {
            let (columns, values) = matrix.row(row);
            let mut entries: Vec<(u32, f64)> = columns
                .iter()
                .copied()
                .zip(values.iter().copied())
                .collect();
            self.complete(&mut entries);
            self.project_row(&mut entries);
            builder.push_row(&mut entries);
        }
        builder.finish()
    }

    /// Puts zeros at missing components of held nodes.
    fn complete(&self, row: &mut Vec<(u32, f64)>) {
        let c = self.components as u32;
        let mut nodes: Vec<u32> = row.iter().map(|entry| entry.0 / c).collect();
        nodes.dedup();
        let is_bound = |node: &u32| {
            self.nodes
                .binary_search_by_key(node, |one| one.node)
                .is_ok()
        };
        for node in nodes.into_iter().filter(is_bound) {
            for i in 0..c {
                let column = node * c + i;
                if let Err(place) = row.binary_search_by_key(&column, |entry| entry.0) {
                    row.insert(place, (column, 0.0));
                }
            }
        }
    }
}
