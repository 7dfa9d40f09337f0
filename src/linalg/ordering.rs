//! Fill-reducing elimination order by nested dissection: the vertices are cut
//! at the median of their longest extent, the vertices of the lower half that
//! touch the upper half form the separator and are eliminated last.
//!
//! Uses coordinates, which every mesh has; on meshes of bounded aspect ratio
//! the separators have the optimal O(n^(2/3)) size in 3D.
//! A. George, Nested dissection of a regular finite element mesh, 1973.
//! Cost O(n log^2 n).

/// Vertices that are ordered without further cuts.
const LEAF: usize = 48;

/// Adjacency of vertices: the neighbours of `v` are
/// `neighbours[offsets[v]..offsets[v + 1]]`.
#[derive(Clone, Debug, Default)]
pub struct Graph {
    /// `[vertices + 1]`
    pub offsets: Vec<usize>,
    /// Ascending within a vertex.
    pub neighbours: Vec<u32>,
}

impl Graph {
    /// The graph of undirected `edges` on `vertices` vertices.
    pub fn from_edges(vertices: usize, edges: &[[u32; 2]]) -> Self {
        let mut offsets = vec![0; vertices + 1];
        for edge in edges {
            offsets[edge[0] as usize + 1] += 1;
            offsets[edge[1] as usize + 1] += 1;
        }
        for vertex in 0..vertices {
            offsets[vertex + 1] += offsets[vertex];
        }
        let mut next = offsets.clone();
        let mut neighbours = vec![0; 2 * edges.len()];
        for &[a, b] in edges {
            for (from, to) in [(a, b), (b, a)] {
                neighbours[next[from as usize]] = to;
                next[from as usize] += 1;
            }
        }
        for vertex in 0..vertices {
            neighbours[offsets[vertex]..offsets[vertex + 1]].sort_unstable();
        }
        Self {
            offsets,
            neighbours,
        }
    }

    /// Neighbours of `vertex`, ascending.
    pub fn neighbours(&self, vertex: u32) -> &[u32] {
        let vertex = vertex as usize;
        &self.neighbours[self.offsets[vertex]..self.offsets[vertex + 1]]
    }
}

/// The elimination order (new to old) of all vertices; those in `last` come
/// after all others, in the given order.
pub fn nested_dissection(coordinates: &[[f64; 3]], graph: &Graph, last: &[u32]) -> Vec<u32> {
    let mut part = vec![0_u32; coordinates.len()];
    for &vertex in last {
        part[vertex as usize] = u32::MAX;
    }
    let mut vertices: Vec<u32> = (0..coordinates.len() as u32)
        .filter(|&vertex| part[vertex as usize] == 0)
        .collect();
    let mut cutter = Cutter {
        coordinates,
        graph,
        part,
        parts: 0,
        order: Vec::with_capacity(coordinates.len()),
    };
    cutter.dissect(&mut vertices);
    let mut order = cutter.order;
    order.extend_from_slice(last);
    order
}

struct Cutter<'a> {
    coordinates: &'a [[f64; 3]],
    graph: &'a Graph,
    /// Which piece a vertex belongs to at the moment.
    part: Vec<u32>,
    parts: u32,
    order: Vec<u32>,
}

impl Cutter<'_> {
    fn dissect(&mut self, vertices: &mut [u32]) {
        if vertices.len() <= LEAF {
            self.order.extend_from_slice(vertices);
            return;
        }
        let axis = self.longest_axis(vertices);
        let middle = vertices.len() / 2;
        let coordinates = self.coordinates;
        let position = |vertex: u32| coordinates[vertex as usize][axis];
        vertices.select_nth_unstable_by(middle, |&a, &b| {
            position(a).total_cmp(&position(b)).then(a.cmp(&b))
        });
        let (lower, upper) = vertices.split_at_mut(middle);
        // The median leaves the halves in an unspecified order; sorting makes
        // the result independent of the selection algorithm.
        lower.sort_unstable();
        upper.sort_unstable();
        let mark = self.mark(upper);
        let (mut inner, separator): (Vec<u32>, Vec<u32>) = lower
            .iter()
            .partition(|&&vertex| !self.touches(vertex, mark));
        self.dissect(&mut inner);
        self.dissect(upper);
        self.order.extend_from_slice(&separator);
    }

    fn mark(&mut self, vertices: &[u32]) -> u32 {
        self.parts += 1;
        for &vertex in vertices {
            self.part[vertex as usize] = self.parts;
        }
        self.parts
    }

    fn touches(&self, vertex: u32, mark: u32) -> bool {
        self.graph
            .neighbours(vertex)
            .iter()
            .any(|&other| self.part[other as usize] == mark)
    }

    fn longest_axis(&self, vertices: &[u32]) -> usize {
        let extent = |axis: usize| {
            let values = vertices.iter().map(|&v| self.coordinates[v as usize][axis]);
            let low = values.clone().fold(f64::INFINITY, f64::min);
            values.fold(f64::NEG_INFINITY, f64::max) - low
        };
        let extents = [extent(0), extent(1), extent(2)];
        (1..3).fold(0, |best, axis| {
            if extents[axis] > extents[best] * (1.0 + 1e-9) {
                axis
            } else {
                best
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_vertex_is_ordered_once_and_the_last_ones_come_last() {
        let n = 20_u32;
        let coordinates: Vec<[f64; 3]> = (0..n * n)
            .map(|v| [f64::from(v % n), f64::from(v / n), 0.0])
            .collect();
        let right = (0..n * n).filter(|v| v % n + 1 < n).map(|v| [v, v + 1]);
        let up = (0..n * (n - 1)).map(|v| [v, v + n]);
        let edges: Vec<[u32; 2]> = right.chain(up).collect();
        let graph = Graph::from_edges(400, &edges);
        let last = [7, 5, 399];
        let order = nested_dissection(&coordinates, &graph, &last);
        assert_eq!(order[397..], last);
        let mut sorted = order;
        sorted.sort_unstable();
        assert!(sorted.iter().copied().eq(0..400));
    }
}
