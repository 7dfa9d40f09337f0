//! Which cells share which facets, from the connectivity alone.
//!
//! Facets are matched vertex by vertex: those with the same lowest vertex are
//! sorted by the others, so n cells cost n log(valence) and no hashing, and no
//! table of all facets is ever held. The order of the results depends on the
//! connectivity only.

use super::BoundaryFacet;
use super::bits::Bits;
use super::cell::CellKind;

/// A facet of a cell, named by its opposite vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct FacetParent {
    /// The cell; the one with the lowest index where there are two.
    pub(crate) cell: u32,
    /// Local number of the cell's vertex that is not on the facet.
    pub(crate) opposite: u8,
    /// Whether the facet belongs to this cell only, so that it lies on the surface of
    /// the body.
    pub(crate) is_boundary: bool,
}

/// What the facets of all cells say.
#[derive(Debug)]
pub(super) struct Matched {
    /// Facets of exactly one cell, sorted by vertices.
    pub(super) boundary: Vec<BoundaryFacet>,
    /// The cell behind each uploaded facet; `None` where there is none.
    pub(super) parents: Vec<Option<FacetParent>>,
    /// Cells with the vertices of a cell of lower index.
    pub(super) duplicates: Bits,
    /// Cells at facets of which two cells of lower index have a share.
    pub(super) crowded: Bits,
}

/// One cell's share in a facet of the current lowest vertex.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Share {
    /// The higher vertices of the facet, packed so that shares of one facet compare as
    /// equal.
    rest: u64,
    /// Cell times vertices per cell, plus the local number of the vertex
    /// opposite the facet.
    place: u32,
}

/// Matches the facets of one lowest vertex after the other.
pub(super) struct FacetMatcher<'mesh, const WIDTH: usize> {
    /// Shape of all cells.
    kind: CellKind,
    /// Vertices of the cells `[cells]`, ascending or as uploaded; the local number
    /// tells the opposite vertex.
    cells: &'mesh [[u32; WIDTH]],
    /// Facets that the mesh came with, which look for their cells.
    uploaded: Uploaded<'mesh>,
    /// Shares in facets of the present lowest vertex, sorted by their higher vertices.
    shares: Vec<Share>,
    /// Vertex opposite the present facet and place of each of its shares: cells that
    /// agree in both are duplicates.
    apexes: Vec<(u32, u32)>,
    /// What has been found so far.
    matched: Matched,
}

impl<'mesh, const WIDTH: usize> FacetMatcher<'mesh, WIDTH> {
    /// For `cells` and the uploaded `facets`, flat `[facets, WIDTH - 1]`.
    pub(super) fn new(kind: CellKind, cells: &'mesh [[u32; WIDTH]], facets: &'mesh [u32]) -> Self {
        Self {
            kind,
            cells,
            uploaded: Uploaded::new(facets, WIDTH - 1),
            shares: Vec::new(),
            apexes: Vec::new(),
            matched: Matched {
                boundary: Vec::new(),
                parents: vec![None; facets.len() / (WIDTH - 1)],
                duplicates: Bits::new(cells.len()),
                crowded: Bits::new(cells.len()),
            },
        }
    }

    /// Matches the facets whose lowest vertex is `vertex`, above those before;
    /// `around` are the numbers of the cells that have it, ascending.
    pub(super) fn add(&mut self, vertex: u32, around: impl Iterator<Item = u32>) {
        self.shares.clear();
        for cell in around {
            let vertices = &self.cells[cell as usize];
            for opposite in 0..WIDTH {
                if let Some(rest) = rest_above(vertex, vertices, opposite) {
                    let place = cell * WIDTH as u32 + opposite as u32;
                    self.shares.push(Share { rest, place });
                }
            }
        }
        self.shares.sort_unstable();
        self.walk();
        self.find_uploaded(vertex);
    }

    /// What was found, all lowest vertices done; gives spare memory back.
    pub(super) fn finish(mut self) -> Matched {
        self.matched.boundary.shrink_to_fit();
        self.matched
    }

    /// Walks over the facets, each with the cells that share it.
    fn walk(&mut self) {
        let mut shares = std::mem::take(&mut self.shares);
        for sharing in shares.chunk_by(|first, second| first.rest == second.rest) {
            match sharing {
                [alone] => self.keep_boundary(alone.place),
                [first, second] => {
                    if self.apex(first.place) == self.apex(second.place) {
                        self.matched
                            .duplicates
                            .insert(cell_of::<WIDTH>(second.place));
                    }
                }
                crowd => self.judge_crowd(crowd),
            }
        }
        std::mem::swap(&mut self.shares, &mut shares);
    }

    /// Keeps a facet that one cell alone has, in the order in which the cell names its
    /// vertices.
    fn keep_boundary(&mut self, place: u32) {
        let (cell, opposite) = (cell_of::<WIDTH>(place), place as usize % WIDTH);
        let local = self.kind.facets()[opposite];
        let row = &self.cells[cell];
        self.matched.boundary.push(BoundaryFacet {
            vertices: [row[local[0]], row[local[1]], row[local[local.len() - 1]]],
            cell: cell as u32,
            opposite: opposite as u8,
        });
    }

    /// A facet of three or more cells: sorted by apex, so that many cells at one
    /// facet cost no more than elsewhere.
    fn judge_crowd(&mut self, crowd: &[Share]) {
        for share in &crowd[2..] {
            self.matched.crowded.insert(cell_of::<WIDTH>(share.place));
        }
        let mut apexes = std::mem::take(&mut self.apexes);
        apexes.clear();
        apexes.extend(crowd.iter().map(|one| (self.apex(one.place), one.place)));
        apexes.sort_unstable();
        for pair in apexes.windows(2) {
            if pair[0].0 == pair[1].0 {
                self.matched.duplicates.insert(cell_of::<WIDTH>(pair[1].1));
            }
        }
        self.apexes = apexes;
    }

    /// The vertex opposite the facet.
    fn apex(&self, place: u32) -> u32 {
        self.cells[cell_of::<WIDTH>(place)][place as usize % WIDTH]
    }

    /// Finds the cells of those uploaded facets whose lowest vertex is `vertex`.
    fn find_uploaded(&mut self, vertex: u32) {
        while let Some((facet, rest)) = self.uploaded.take(vertex) {
            let first = self.shares.partition_point(|share| share.rest < rest);
            let here = self.shares[first..].iter();
            let mut sharing = here.take_while(|share| share.rest == rest);
            self.matched.parents[facet] = sharing.next().map(|share| FacetParent {
                cell: cell_of::<WIDTH>(share.place) as u32,
                opposite: (share.place as usize % WIDTH) as u8,
                is_boundary: sharing.next().is_none(),
            });
        }
    }
}

/// The cell to which a place in the flat array of cells belongs.
fn cell_of<const WIDTH: usize>(place: u32) -> usize {
    place as usize / WIDTH
}

/// The other vertices of the facet opposite a local vertex, as a key; `None`
/// unless `vertex` is the facet's lowest.
fn rest_above<const WIDTH: usize>(
    vertex: u32,
    vertices: &[u32; WIDTH],
    opposite: usize,
) -> Option<u64> {
    let (mut low, mut high) = (u32::MAX, 0);
    if vertices[opposite] == vertex {
        return None;
    }
    for (local, &other) in vertices.iter().enumerate() {
        if local != opposite && other != vertex {
            low = low.min(other);
            high = high.max(other);
        }
    }
    (low > vertex).then_some(key(low, high))
}

/// Orders the vertices beside the lowest; both are the same for a line.
fn key(low: u32, high: u32) -> u64 {
    u64::from(low) << 32 | u64::from(high)
}

/// The uploaded facets, taken in order of their lowest vertices.
struct Uploaded<'mesh> {
    /// Vertices of the uploaded facets, flat `[facets, width]`.
    facets: &'mesh [u32],
    /// Vertices of one facet: 3 in space, 2 in the plane.
    width: usize,
    /// Lowest vertex and number of each facet, sorted by that vertex.
    order: Vec<(u32, u32)>,
    /// Position in `order` of the next facet; those before it are taken.
    next: usize,
}

impl<'mesh> Uploaded<'mesh> {
    /// Sorts the facets by their lowest vertices. Cost: one sort.
    fn new(facets: &'mesh [u32], width: usize) -> Self {
        let rows = facets.chunks_exact(width);
        let mut order: Vec<_> = rows.map(|facet| facet_key(facet).0).zip(0..).collect();
        order.sort_unstable();
        Self {
            facets,
            width,
            order,
            next: 0,
        }
    }

    /// The next facet whose lowest vertex is `vertex`, and the key of the others.
    fn take(&mut self, vertex: u32) -> Option<(usize, u64)> {
        let &(_, facet) = self.order.get(self.next).filter(|one| one.0 == vertex)?;
        self.next += 1;
        let row = &self.facets[facet as usize * self.width..][..self.width];
        Some((facet as usize, facet_key(row).1))
    }
}

/// Lowest vertex and the key of the others.
fn facet_key(vertices: &[u32]) -> (u32, u64) {
    let mut sorted = [vertices[0], vertices[1], vertices[vertices.len() - 1]];
    sorted.sort_unstable();
    match vertices.len() {
        2 => (sorted[0], key(sorted[2], sorted[2])),
        _ => (sorted[0], key(sorted[1], sorted[2])),
    }
}
