//! Hexahedra, wedges, pyramids and quadrangles as tetrahedra and triangles.
//!
//! The diagonal of a face of four corners goes through the smallest node number, so that both
//! cells at a face split it alike (J. Dompierre, P. Labbe, M.-G. Vallet, R. Camarero, *How to
//! subdivide pyramids, prisms and hexahedra into tetrahedra*, 8th International Meshing
//! Roundtable, 1999). A cell is the cone from its own smallest node to the triangles of the
//! faces that do not meet it (the pulling triangulation): six tetrahedra of a hexahedron, three
//! of a wedge, two of a pyramid. Nodes that are named twice, as in collapsed cells, leave out
//! the simplices that have no volume. Inside a quadrangle of the plane both diagonals conform:
//! the other one is taken where the first leaves next to nothing of a triangle.

use super::raw::ElementKind;

/// Simplices of an element, at most: those of a hexahedron.
const MOST: usize = 6;
/// What a triangle of a quadrangle has of its area at least, else the other diagonal is tried.
const LEAST: f64 = 0.1;
/// What a tetrahedron has of the volume of its cell at least.
const FLAT: f64 = 1e-9;
/// No node.
const NONE: u64 = u64::MAX;

/// Simplices of one element by node numbers; those of the plane and the surface fill up with
/// the largest number.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Simplices {
    all: [[u64; 4]; MOST],
    count: usize,
}

impl Simplices {
    /// Those of an element.
    pub(crate) fn of(kind: ElementKind, nodes: &[u64]) -> Self {
        let corners = nodes.get(..kind.vertices()).unwrap_or(nodes);
        let mut simplices = Self {
            all: [[NONE; 4]; MOST],
            count: 0,
        };
        match (kind.dimension, corners) {
            (2, &[a, b, c, d]) => {
                let [first, second] = halves([a, b, c, d]);
                simplices.push(&first);
                simplices.push(&second);
            }
            (3, [_, _, _, _, _, ..]) => simplices.pull(kind, corners),
            _ => simplices.keep(corners),
        }
        simplices
    }

    /// Those of a cell whose nodes are at places, turned so that all have a positive size;
    /// none where they have not the same sign, or one has next to no size.
    pub(super) fn placed(
        kind: ElementKind,
        nodes: &[u64],
        place: impl Fn(u64) -> [f64; 3],
    ) -> Option<Self> {
        let mut simplices = Self::of(kind, nodes);
        let mut least = simplices.least(&place);
        if let (&[a, b, c, d, ..], 4, 2) = (nodes, kind.vertices(), simplices.count)
            && kind.dimension == 2
            && least.1 < LEAST
        {
            let other = simplices.with_other_diagonal([a, b, c, d]);
            let of_other = other.least(&place);
            if of_other.1 > least.1 {
                (simplices, least) = (other, of_other);
            }
        }
        if least.1 <= FLAT || simplices.count == 0 {
            return None;
        }
        if least.0 < 0.0 {
            let all = simplices.all.iter_mut();
            all.for_each(|[a, b, _, _]| std::mem::swap(a, b));
        }
        Some(simplices)
    }

    /// The triangles of a quadrangle whose other diagonal these have.
    fn with_other_diagonal(&self, [a, b, c, d]: [u64; 4]) -> Self {
        let mut other = Self {
            all: [[NONE; 4]; MOST],
            count: 0,
        };
        let is_through_a = self.all.first().is_some_and(|[first, ..]| *first == a);
        let [a, b, c, d] = if is_through_a {
            [b, c, d, a]
        } else {
            [a, b, c, d]
        };
        other.push(&[a, b, c]);
        other.push(&[a, c, d]);
        other
    }

    /// Size of all together, and the part of it that the smallest one has.
    fn least(&self, place: impl Fn(u64) -> [f64; 3]) -> (f64, f64) {
        let sizes = || self.iter().map(|nodes| size(*nodes, &place));
        let whole: f64 = sizes().sum();
        let parts = sizes().map(|size| size / whole);
        let least = parts.fold(
            1.0,
            |least: f64, part| if part >= least { least } else { part },
        );
        (whole, least)
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &[u64; 4]> {
        self.all.iter().take(self.count)
    }

    /// The cone from the smallest corner.
    fn pull(&mut self, kind: ElementKind, corners: &[u64]) {
        let apex = corners.iter().min().copied().unwrap_or(NONE);
        let faces = kind.faces().iter().map(|face| picked(corners, face));
        for [a, b, c, d] in faces.filter(|face| !face.contains(&apex)) {
            for [a, b, c] in triangles([a, b, c, d]) {
                self.push(&[a, b, c, apex]);
            }
        }
    }

    /// Adds a simplex unless a node is in it twice.
    fn push(&mut self, nodes: &[u64]) {
        let mut rest = nodes;
        while let Some((first, others)) = rest.split_first() {
            if others.contains(first) {
                return;
            }
            rest = others;
        }
        self.keep(nodes);
    }

    fn keep(&mut self, nodes: &[u64]) {
        if let Some(row) = self.all.get_mut(self.count) {
            row.iter_mut()
                .zip(nodes)
                .for_each(|(slot, node)| *slot = *node);
            self.count += 1;
        }
    }
}

/// Nodes of a face; a triangle fills up with the largest number.
pub(crate) fn picked(nodes: &[u64], face: &[usize]) -> [u64; 4] {
    let mut found = [NONE; 4];
    for (slot, at) in found.iter_mut().zip(face) {
        *slot = nodes.get(*at).copied().unwrap_or(NONE);
    }
    found
}

/// The triangles of a face of three or four corners, without those of two corners.
pub(crate) fn triangles(face: [u64; 4]) -> impl Iterator<Item = [u64; 3]> {
    let [a, b, c, d] = face;
    let both = if d == NONE {
        [[a, b, c], [NONE; 3]]
    } else {
        halves(face)
    };
    both.into_iter()
        .filter(|[a, b, c]| a != b && b != c && a != c)
}

/// The triangles of a quadrangle, the diagonal through its smallest node.
fn halves([a, b, c, d]: [u64; 4]) -> [[u64; 3]; 2] {
    if a.min(c) <= b.min(d) {
        [[a, b, c], [a, c, d]]
    } else {
        [[b, c, d], [b, d, a]]
    }
}

/// Twice the area of a triangle of the plane, six times the volume of a tetrahedron.
fn size([a, b, c, d]: [u64; 4], place: impl Fn(u64) -> [f64; 3]) -> f64 {
    let from = place(a);
    let [b, c] = [b, c].map(|node| minus(place(node), from));
    let normal = cross(b, c);
    if d == NONE {
        let [_, _, area] = normal;
        area
    } else {
        dot(normal, minus(place(d), from))
    }
}

fn minus([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [a - x, b - y, c - z]
}

fn cross([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}

fn dot([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> f64 {
    a * x + b * y + c * z
}

#[cfg(test)]
mod tests;
