//! Which edge of a cell is halved next, and the rules by which its halves inherit that.
//!
//! ```text
//! triangle:     the edge opposite the new vertex (newest vertex)
//! tetrahedron:  one edge of the cell, and one of each facet; facets that contain the edge of the
//!               cell have that one. Halves over m, the middle of (i, j), with k and l:
//!                 facet of the parent kept whole    keeps its edge, which is that of the half
//!                 facet cut by m                    its edge opposite m
//!                 facet between the halves          (k, l); of a flagged planar parent the edge
//!                                                   from m to the edge of the half
//!                 flag                              of the halves of an unflagged planar parent
//! ```
//!
//! A cell is planar where its edge and those of its other two facets lie in one facet. Two cells
//! agree on their common facet, at the start since all take the longest edge by one order of all
//! edges, and by the rules ever after. References: W. F. Mitchell, ACM Trans. Math. Software 15
//! (1989); D. N. Arnold, A. Mukherjee, L. Pouly, Locally adapted tetrahedral meshes using
//! bisection, SIAM J. Sci. Comput. 22 (2000), whose theorem 3.2 bounds the classes of similar
//! cells. Cost: a few operations a cell.

use crate::geometry::vector3::{dot, sub};
use crate::mesh::{CellKind, Mesh};

/// Two local vertices of a cell, ascending.
pub(super) type Pair = [u8; 2];

/// What a cell knows of its next bisections.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Marks {
    /// Local ends of the edge that is halved next.
    pub(super) edge: Pair,
    /// Local ends of the edge that halves the facet opposite each vertex first; of triangles not
    /// read.
    pub(super) facets: [Pair; 4],
    /// Set in the halves of planar cells without it.
    is_flagged: bool,
    /// Number of bisections since the mesh was not refined.
    pub(super) generation: u16,
}

/// In ascending order.
fn pair(a: u8, b: u8) -> Pair {
    [a.min(b), a.max(b)]
}

/// The end of an edge that is not `end`; none where `end` is no end of it.
fn other_end(edge: Pair, end: u8) -> Option<u8> {
    match edge {
        [a, b] if a == end => Some(b),
        [a, b] if b == end => Some(a),
        _ => None,
    }
}

/// Edges in the one order of all: by length, then by their ends.
pub(super) struct Longest<'a>(pub(super) &'a Mesh);

impl Longest<'_> {
    /// The longest edge between some of the `vertices` of a cell, by their local numbers.
    fn among(&self, vertices: &[u32], locals: &[u8]) -> Pair {
        let key = |&[a, b]: &Pair| {
            let ends = [a, b].map(|local| vertices[usize::from(local)]);
            let [from, to] = [ends[0].min(ends[1]), ends[0].max(ends[1])];
            (square(self.0, [from, to]), from, to)
        };
        let pairs = (0..locals.len())
            .flat_map(|i| (i + 1..locals.len()).map(move |j| pair(locals[i], locals[j])));
        let longer = |one: &Pair, other: &Pair| {
            let (one, other) = (key(one), key(other));
            let by_length = one.0.total_cmp(&other.0);
            by_length.then_with(|| (one.1, one.2).cmp(&(other.1, other.2)))
        };
        pairs.max_by(longer).unwrap_or([0, 1])
    }

    /// The marks of a cell before any bisection.
    pub(super) fn of_cell(&self, vertices: &[u32]) -> Marks {
        let all: Vec<u8> = (0..vertices.len() as u8).collect();
        let of_facet = |opposite: u8| {
            let own: Vec<u8> = all.iter().copied().filter(|&v| v != opposite).collect();
            self.among(vertices, &own)
        };
        Marks {
            edge: self.among(vertices, &all),
            facets: std::array::from_fn(|opposite| of_facet(opposite as u8)),
            is_flagged: false,
            generation: 0,
        }
    }
}

/// Square of the distance of two vertices.
fn square(mesh: &Mesh, [a, b]: [u32; 2]) -> f64 {
    let [a, b] = [a, b].map(|end| mesh.coordinates()[end as usize]);
    let way = sub(b, a);
    dot(way, way)
}

impl Marks {
    /// Those of the two halves: the first keeps the first end of the edge, and has the new vertex
    /// in the place of the second; the other the other way round.
    pub(super) fn halves(&self, kind: CellKind) -> [Self; 2] {
        let [i, j] = self.edge;
        [[i, j], [j, i]].map(|[kept, replaced]| match kind {
            CellKind::Triangle => self.half_of_triangle(kept),
            CellKind::Tetrahedron => self.half_of_tetrahedron(kept, replaced),
        })
    }

    /// The half that keeps `kept`: its edge lies opposite the new vertex.
    fn half_of_triangle(&self, kept: u8) -> Self {
        // The local numbers 0, 1 and 2 sum to three.
        let third = 3 - self.edge[0] - self.edge[1];
        Self {
            edge: pair(kept, third),
            generation: self.generation.saturating_add(1),
            ..*self
        }
    }

    /// The half with the new vertex in the place of `replaced`.
    fn half_of_tetrahedron(&self, kept: u8, replaced: u8) -> Self {
        let mut others = (0..4).filter(|local| !self.edge.contains(local));
        let [k, l] = [others.next().unwrap_or(2), others.next().unwrap_or(3)];
        let edge = self.facets[usize::from(replaced)];
        let plane = self.planar();
        let between = match plane.filter(|_| self.is_flagged) {
            Some(common) => pair(replaced, common),
            None => pair(k, l),
        };
        let mut facets = [edge; 4];
        facets[usize::from(k)] = pair(kept, l);
        facets[usize::from(l)] = pair(kept, k);
        facets[usize::from(kept)] = between;
        Self {
            edge,
            facets,
            is_flagged: plane.is_some() && !self.is_flagged,
            generation: self.generation.saturating_add(1),
        }
    }

    /// Of a planar cell the third vertex of the facet that has all its edges.
    fn planar(&self) -> Option<u8> {
        let [i, j] = self.edge;
        let [at_i, at_j] = [j, i].map(|opposite| self.facets[usize::from(opposite)]);
        let common = other_end(at_i, i)?;
        (other_end(at_j, j) == Some(common)).then_some(common)
    }
}
