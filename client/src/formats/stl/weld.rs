//! One vertex of corners that are near each other; the first one gives the place.
//!
//! Corners with all the bits of an earlier one, as files of programs have them, are found part by
//! part, so that the table of each stays small; others are looked for in a grid whose cells are
//! larger than what is welded. Cost: some 200 bytes a facet while it works.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use super::{SurfaceFile, pick};

/// Cells of the grid, in what is welded: most points are near one cell only.
const CELL: f64 = 8.0;
/// Parts of the points.
const PARTS: usize = 256;
/// No vertex.
const NONE: u32 = u32::MAX;

/// The surface of facets with these corners, those nearer than `tolerance` of the diagonal of their
/// box being one.
pub(super) fn weld(corners: &[[[f64; 3]; 3]], tolerance: f64) -> SurfaceFile {
    let points = corners.as_flattened();
    let (low, high) = points.iter().fold(
        ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]),
        |(low, high), point| (pick(low, *point, f64::min), pick(high, *point, f64::max)),
    );
    let extent = pick(high, low, |high, low| high - low);
    let diagonal = extent.iter().map(|x| x * x).sum::<f64>().sqrt();
    let mut welder = Welder {
        near: (tolerance * diagonal).max(f64::MIN_POSITIVE),
        low,
        cells: HashMap::with_capacity_and_hasher(points.len() / 5, BuildHasherDefault::default()),
        earlier: Vec::with_capacity(points.len() / 5),
        vertices: Vec::with_capacity(points.len() / 5),
    };
    let mut vertices = Vec::with_capacity(points.len());
    for (index, (&first, point)) in first_alike(points).iter().zip(points).enumerate() {
        let known = vertices.get(first).copied().filter(|_| first < index);
        vertices.push(known.unwrap_or_else(|| welder.vertex(*point)));
    }
    SurfaceFile {
        facets: vertices.as_chunks::<3>().0.to_vec(),
        vertices: welder.vertices,
    }
}

/// For each point the first one with the same bits, maybe itself.
fn first_alike(points: &[[f64; 3]]) -> Vec<usize> {
    let mut parts: Vec<Vec<([u64; 3], usize)>> = Vec::new();
    parts.resize_with(PARTS, || Vec::with_capacity(points.len() / PARTS));
    for (index, point) in points.iter().enumerate() {
        let bits = point.map(f64::to_bits);
        let mut mixer = Mixer::default();
        bits.into_iter().for_each(|word| mixer.write_u64(word));
        // Tables take the bits at both ends.
        if let Some(part) = parts.get_mut((mixer.0 >> 40) as usize % PARTS) {
            part.push((bits, index));
        }
    }
    let mut first: Vec<usize> = (0..points.len()).collect();
    for part in parts {
        let mut known: HashMap<[u64; 3], usize, BuildHasherDefault<Mixer>> = HashMap::default();
        for (bits, index) in part {
            let earliest = *known.entry(bits).or_insert(index);
            if let Some(first) = first.get_mut(index) {
                *first = earliest;
            }
        }
    }
    first
}

/// Multiplies and turns: keys are coordinates of a file of the user's own, nobody's to choose.
#[derive(Default)]
struct Mixer(u64);

impl Hasher for Mixer {
    fn write(&mut self, bytes: &[u8]) {
        for chunk in bytes.chunks(8) {
            let word = chunk
                .iter()
                .rev()
                .fold(0, |word, &byte| word << 8 | u64::from(byte));
            self.write_u64(word);
        }
    }

    fn write_u64(&mut self, word: u64) {
        self.0 = (self.0.rotate_left(5) ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    }

    fn write_i64(&mut self, word: i64) {
        self.write_u64(word.cast_unsigned());
    }

    fn finish(&self) -> u64 {
        // The table takes the low bits, which products leave poor.
        self.0 ^ self.0 >> 32
    }
}

/// Vertices by the cells of a grid.
struct Welder {
    near: f64,
    low: [f64; 3],
    /// The last vertex of each cell.
    cells: HashMap<[i64; 3], u32, BuildHasherDefault<Mixer>>,
    /// The vertex before each in its cell `[vertices]`.
    earlier: Vec<u32>,
    vertices: Vec<[f64; 3]>,
}

impl Welder {
    /// The first vertex that is near, else a new one.
    fn vertex(&mut self, point: [f64; 3]) -> u32 {
        let cell_of = |shift: f64| {
            let cell = |x: f64, low: f64| ((x - low + shift) / (CELL * self.near)).floor();
            pick(point, self.low, cell).map(|x| x as i64)
        };
        let (own, [first, last]) = (cell_of(0.0), [-self.near, self.near].map(cell_of));
        let beside =
            || (first[0]..=last[0]).flat_map(|x| (first[1]..=last[1]).map(move |y| (x, y)));
        let cells = || beside().flat_map(|(x, y)| (first[2]..=last[2]).map(move |z| [x, y, z]));
        let vertices = cells().flat_map(|cell| self.in_cell(cell));
        let near = vertices.filter(|&vertex| self.is_near(vertex, point)).min();
        near.unwrap_or_else(|| self.add(point, own))
    }

    fn add(&mut self, point: [f64; 3], cell: [i64; 3]) -> u32 {
        let index = u32::try_from(self.vertices.len()).unwrap_or(NONE);
        self.vertices.push(point);
        let earlier = self.cells.insert(cell, index);
        self.earlier.push(earlier.unwrap_or(NONE));
        index
    }

    fn in_cell(&self, cell: [i64; 3]) -> impl Iterator<Item = u32> {
        let last = self.cells.get(&cell).copied();
        let before = |&vertex: &u32| {
            let earlier = self.earlier.get(vertex as usize);
            earlier.copied().filter(|&earlier| earlier != NONE)
        };
        std::iter::successors(last, before)
    }

    fn is_near(&self, vertex: u32, point: [f64; 3]) -> bool {
        let Some(other) = self.vertices.get(vertex as usize) else {
            return false;
        };
        let offset = pick(*other, point, |a, b| a - b);
        offset.iter().map(|x| x * x).sum::<f64>() <= self.near * self.near
    }
}
