//! The used numbering: uploaded vertices without those that no cell has, in the
//! same order. One and a half bits per vertex; arrays are renumbered in place.

use super::bits::Bits;

/// Which uploaded vertices cells use.
pub(super) struct Numbering {
    /// The used vertices as a set.
    used: Bits,
    /// How many used vertices stand before each word of the set, so that a number is
    /// found at once.
    ranks: Vec<u32>,
    /// Number of used vertices.
    used_count: usize,
    /// Number of uploaded vertices.
    vertex_count: usize,
}

impl Numbering {
    /// Marks the vertices that cells name. Cost: one pass over the cells.
    pub(super) fn new(cells: &[u32], vertex_count: usize) -> Self {
        let mut used = Bits::new(vertex_count);
        for &vertex in cells {
            used.insert(vertex as usize);
        }
        Self {
            ranks: used.ranks(),
            used_count: used.count(),
            used,
            vertex_count,
        }
    }

    /// Whether every vertex is used, so that numbers stay as uploaded.
    fn is_identity(&self) -> bool {
        self.used_count == self.vertex_count
    }

    /// The coordinates of the used vertices, in their order.
    pub(super) fn select(&self, mut coordinates: Vec<[f64; 3]>) -> Vec<[f64; 3]> {
        if !self.is_identity() {
            let mut vertices = 0..self.vertex_count;
            coordinates.retain(|_| vertices.next().is_some_and(|one| self.used.contains(one)));
        }
        coordinates.shrink_to_fit();
        coordinates
    }

    /// An unused vertex becomes `u32::MAX`, which no cell has and so no facet
    /// lookup finds.
    pub(super) fn renumber(&self, mut vertices: Vec<u32>) -> Vec<u32> {
        if !self.is_identity() {
            for vertex in &mut vertices {
                let uploaded = *vertex as usize;
                *vertex = if self.used.contains(uploaded) {
                    self.used.rank(&self.ranks, uploaded)
                } else {
                    u32::MAX
                };
            }
        }
        vertices.shrink_to_fit();
        vertices
    }

    /// The used numbers of the ends of an edge, [`u32::MAX`] for an unused one; the order
    /// of vertices stays.
    pub(super) fn renumbered(&self, ends: [u32; 2]) -> [u32; 2] {
        ends.map(|vertex| {
            if self.used.contains(vertex as usize) {
                self.used.rank(&self.ranks, vertex as usize)
            } else {
                u32::MAX
            }
        })
    }

    /// Uploaded number of a used vertex, in linear time.
    pub(super) fn uploaded(&self, used: usize) -> Option<usize> {
        self.used.iter().nth(used)
    }

    /// Uploaded number of each used vertex, ascending.
    pub(super) fn into_used(self) -> Vec<u32> {
        let mut used = Vec::with_capacity(self.used_count);
        used.extend(self.used.iter().map(|vertex| vertex as u32));
        used
    }

    /// A sentence about vertices that are dropped, or none.
    pub(super) fn warnings(&self) -> Vec<String> {
        match self.vertex_count - self.used_count {
            0 => Vec::new(),
            1 => vec!["1 vertex belongs to no cell and is dropped".to_owned()],
            dropped => vec![format!(
                "{dropped} vertices belong to no cell and are dropped"
            )],
        }
    }
}
