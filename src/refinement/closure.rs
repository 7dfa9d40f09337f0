//! Bisection of marked cells, and of their neighbours until no vertex hangs on an edge.
//!
//! Passes: the marked cells are halved, then all cells with an edge that is halved already, and so
//! on. It ends in the plane since only edges of the mesh that the pass began with are ever halved;
//! in space since, from marks that agree on all facets, every uniform refinement of a multiple of
//! three bisections is conforming, which none of the cells of the closure is finer than (Arnold,
//! Mukherjee, Pouly, theorem 3.1). A limit of cells stands besides, for memory. The order of cells
//! and the numbers of vertices depend on the mesh and the marks alone. Cost: a pass looks at all
//! cells, with look-ups only of cells at halved edges; some ten passes on graded meshes.

use super::Limits;
use super::edges::Edges;
use super::error::RefinementError;
use super::marks::Marks;
use crate::mesh::{CellKind, Mesh};

/// A cell under bisection.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leaf {
    /// Its vertices, in an order of positive measure; the fourth of a triangle repeats its third.
    pub(super) vertices: [u32; 4],
    /// Its next bisections.
    pub(super) marks: Marks,
    /// The cell of the mesh at the start that it lies in.
    pub(super) origin: u32,
    /// The generation that it is asked to reach.
    goal: u16,
}

/// Cells and edges on the way.
pub(super) struct Closure<'a> {
    kind: CellKind,
    limits: Limits,
    /// Bytes that the finished mesh takes for each cell, and the way there.
    bytes_per_cell: u64,
    /// The cells at present.
    pub(super) leaves: Vec<Leaf>,
    /// Their edges, and those that are halved.
    pub(super) edges: Edges<'a>,
    /// Whether each vertex is an end of a halved edge.
    is_touched: Vec<bool>,
}

impl<'a> Closure<'a> {
    /// Of a mesh whose cells have those marks.
    pub(super) fn new(mesh: &'a Mesh, marks: &[Marks], limits: Limits) -> Self {
        let leaf = |(origin, &marks): (usize, &Marks)| {
            let cell = mesh.cell(origin);
            Leaf {
                vertices: std::array::from_fn(|i| cell[i.min(cell.len() - 1)]),
                marks,
                origin: origin as u32,
                goal: 0,
            }
        };
        let cells = mesh.cell_count() as u64;
        let on_the_way = (2 * size_of::<Leaf>() + 2 * size_of::<[u32; 8]>()) as u64;
        Self {
            kind: mesh.cell_kind(),
            limits,
            bytes_per_cell: mesh.bytes().div_ceil(cells.max(1)) + on_the_way,
            leaves: marks.iter().enumerate().map(leaf).collect(),
            edges: Edges::new(mesh),
            is_touched: vec![false; mesh.coordinates().len()],
        }
    }

    /// Bisects the cells of these numbers and their halves until they are `times` generations
    /// finer, and what their new vertices ask for. What the closure has bisected counts.
    ///
    /// # Errors
    /// [`RefinementError::TooManyCells`] or [`RefinementError::TooMuchMemory`].
    pub(super) fn run(&mut self, marked: &[u32], times: u16) -> Result<(), RefinementError> {
        for &cell in marked {
            let leaf = &mut self.leaves[cell as usize];
            leaf.goal = leaf.marks.generation.saturating_add(times);
        }
        loop {
            let mut next = self.coarse();
            if next.is_empty() {
                return Ok(());
            }
            while !next.is_empty() {
                for &leaf in &next {
                    self.check_room()?;
                    self.bisect(leaf);
                }
                next = self.hanging();
            }
        }
    }

    /// Cells that have not reached the generation that they are asked to, ascending.
    fn coarse(&self) -> Vec<usize> {
        let leaves = self.leaves.iter().enumerate();
        let coarse = leaves.filter(|(_, leaf)| leaf.marks.generation < leaf.goal);
        coarse.map(|(number, _)| number).collect()
    }

    /// Refuses one cell more than there is room for.
    fn check_room(&self) -> Result<(), RefinementError> {
        let cells = self.leaves.len() + 1;
        if cells > self.limits.cells {
            return Err(RefinementError::TooManyCells {
                limit: self.limits.cells,
            });
        }
        if (cells as u64).saturating_mul(self.bytes_per_cell) > self.limits.bytes {
            return Err(RefinementError::TooMuchMemory {
                limit: self.limits.bytes,
            });
        }
        Ok(())
    }

    /// Halves one cell over its edge; the first half takes its place, the other follows all.
    fn bisect(&mut self, number: usize) {
        let leaf = self.leaves[number];
        let [i, j] = leaf.marks.edge.map(usize::from);
        let ends = [leaf.vertices[i], leaf.vertices[j]];
        let Some(middle) = self.edges.halve(ends[0], ends[1]) else {
            return;
        };
        self.touch(ends, middle);
        for local in (0..self.kind.vertices()).filter(|&local| local != i && local != j) {
            // The edges of a cell are there.
            self.edges.join(middle, ends, leaf.vertices[local]);
        }
        let marks = leaf.marks.halves(self.kind);
        let halves = [(j, marks[0]), (i, marks[1])].map(|(replaced, marks)| {
            let mut vertices = leaf.vertices;
            vertices[replaced] = middle;
            if self.kind == CellKind::Triangle {
                vertices[3] = vertices[2];
            }
            Leaf {
                vertices,
                marks,
                ..leaf
            }
        });
        self.leaves[number] = halves[0];
        self.leaves.push(halves[1]);
    }

    /// Notes the ends of a halved edge.
    fn touch(&mut self, ends: [u32; 2], middle: u32) {
        let count = self.is_touched.len().max(middle as usize + 1);
        self.is_touched.resize(count, false);
        for end in ends {
            self.is_touched[end as usize] = true;
        }
    }

    /// Cells with a halved edge, ascending.
    fn hanging(&self) -> Vec<usize> {
        let leaves = self.leaves.iter().enumerate();
        let found = leaves.filter(|(_, leaf)| {
            let vertex = |local: usize| leaf.vertices[local];
            let is_touched = |local: usize| self.is_touched[vertex(local) as usize];
            let mut pairs = self.kind.edges().iter();
            pairs.any(|&(a, b)| {
                is_touched(a) && is_touched(b) && self.edges.middle(vertex(a), vertex(b)).is_some()
            })
        });
        found.map(|(number, _)| number).collect()
    }
}
