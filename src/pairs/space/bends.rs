//! Second derivatives of sum_j factor_j G_j of a face, some of its pieces with their borders at a time.
//!
//! Shapes: by vectors, the nodes and normals of the face, then the nodes of its partners, each once;
//! `[vectors][3][vectors][3]`: a face that meets many small ones has a bounded part of them at a time.
//! Cost: some 5 us a point, 1 us a point of a border.

use super::choice::Piece;
use super::kinks::{self, Border, Kink, borders};
use super::normals::Vector;
use super::pair::{Meeting, Placed};
use super::patch::{NODES, bernstein};
use super::point::{Bend, Block, OTHER, VECTORS, completed};
use super::rims::RimBend;
use crate::geometry::vector3::{add, scale};

/// Pieces whose second derivatives are summed at a time: some hundred vectors, .7 MB; chosen.
const TOGETHER: usize = 16;

/// Some pieces of a face.
pub(super) struct Part<'a> {
    pub(super) meeting: &'a Meeting,
    /// Borders with their lower number among the pieces.
    borders: Vec<Border>,
    pieces: std::ops::Range<usize>,
}

impl Part<'_> {
    /// Its pieces.
    pub(super) fn pieces(&self) -> &[Piece] {
        &self.meeting.pieces[self.pieces.clone()]
    }
}

/// All pieces of a meeting by parts.
pub(super) fn parts(meeting: &Meeting) -> Vec<Part<'_>> {
    parts_of(meeting, TOGETHER)
}

/// Parts of so many pieces.
pub(super) fn parts_of(meeting: &Meeting, together: usize) -> Vec<Part<'_>> {
    let all = borders(&meeting.pieces);
    let firsts = (0..meeting.pieces.len()).step_by(together.max(1));
    let part = |first: usize| {
        let pieces = first..meeting.pieces.len().min(first.saturating_add(together));
        let own = all
            .iter()
            .filter(|border| pieces.contains(&border.pieces[0]));
        Part {
            meeting,
            borders: own.copied().collect(),
            pieces,
        }
    };
    firsts.map(part).collect()
}

/// Second derivatives of a part of a face.
pub(super) struct FaceBend {
    /// Its vectors.
    pub(super) vectors: Vec<Vector>,
    /// By pairs of coordinates, three a vector.
    pub(super) entries: Vec<f64>,
    /// First derivatives by the three normals.
    pub(super) by_normals: [[f64; 3]; 3],
}

impl Placed<'_> {
    /// The vectors of a piece.
    pub(super) fn vectors(&self, face: usize, piece: &Piece) -> [Vector; VECTORS] {
        let own = &self.pair.carrier.faces[face];
        let other = &self.pair.other.faces[piece.other];
        std::array::from_fn(|k| match k {
            0..NODES => Vector::Node(own.nodes[k]),
            NODES..OTHER => Vector::Normal(own.normals[k - NODES]),
            _ => Vector::Node(other.nodes[k - OTHER]),
        })
    }

    /// Second derivatives of sum_j factor_j G_j of a part of a face.
    pub(super) fn face_bend(&self, part: &Part<'_>, factors: [f64; NODES]) -> FaceBend {
        let meeting = part.meeting;
        let pieces = part.pieces();
        let of_piece = |k: usize| self.vectors(meeting.face, &meeting.pieces[k]);
        let rims = pieces.iter().flat_map(|piece| {
            let points = self.rim_points(meeting.face, piece).into_iter();
            points.map(|point| point.bend(self, (meeting.face, piece), factors))
        });
        let rims: Vec<RimBend> = rims.collect();
        let beyond = part.borders.iter().map(|border| border.pieces[1]);
        let of_pieces = part.pieces.clone().chain(beyond).flat_map(of_piece);
        let of_rims = rims.iter().flat_map(|rim| &rim.motion);
        let of_rims = of_rims.map(|(vector, _)| *vector);
        let mut sum = FaceBend::of(of_pieces.chain(of_rims).collect());
        for (piece, k) in pieces.iter().zip(part.pieces.clone()) {
            let bend = self.bend((meeting.face, piece), factors, &mut sum.by_normals);
            sum.add_piece(&of_piece(k), &bend);
        }
        for &border in &part.borders {
            let [first, second] = border.pieces.map(of_piece);
            for kink in self.kinks((meeting, border), factors) {
                sum.add_kink([&first, &second], &kink);
            }
        }
        rims.iter().for_each(|rim| sum.add_rim(rim));
        sum
    }

    fn kinks(&self, (meeting, border): (&Meeting, Border), factors: [f64; NODES]) -> Vec<Kink> {
        let partners = border.pieces.map(|k| &self.others[meeting.pieces[k].other]);
        border.kinks(&self.own[meeting.face], partners, factors)
    }

    /// Second derivatives on a piece of a face; adds the first ones by its normals.
    fn bend(
        &self,
        (face, piece): (usize, &Piece),
        factors: [f64; NODES],
        by_normals: &mut [[f64; 3]; 3],
    ) -> Box<Bend> {
        let mut sums: Box<Bend> = Box::new([[Block::default(); VECTORS]; VECTORS]);
        let other = &self.others[piece.other];
        self.each_point((face, piece), &mut |point, weight| {
            let values = bernstein(point.at).into_iter().zip(factors);
            let factor: f64 = values.map(|(value, factor)| value * factor).sum();
            let factor = weight * factor;
            point.add_bend(other, factor, &mut sums);
            let slopes = point.gradient(other);
            for (sum, slope) in by_normals.iter_mut().zip(&slopes[NODES..OTHER]) {
                *sum = add(*sum, scale(factor, *slope));
            }
        });
        completed(&mut sums);
        sums
    }
}

impl FaceBend {
    /// Nothing, by those vectors.
    pub(super) fn of(mut vectors: Vec<Vector>) -> Self {
        vectors.sort_unstable();
        vectors.dedup();
        Self {
            entries: vec![0.0; 9 * vectors.len() * vectors.len()],
            vectors,
            by_normals: [[0.0; 3]; 3],
        }
    }

    fn place(&self, vector: Vector) -> usize {
        self.vectors.partition_point(|own| *own < vector)
    }

    pub(super) fn add_piece(&mut self, own: &[Vector; VECTORS], bend: &Bend) {
        let places = own.map(|vector| self.place(vector));
        let width = 3 * self.vectors.len();
        for (&first, of_vector) in places.iter().zip(bend) {
            for i in 0..3 {
                let row = &mut self.entries[(3 * first + i) * width..][..width];
                for (&second, block) in places.iter().zip(of_vector) {
                    let entries = row[3 * second..][..3].iter_mut();
                    entries.zip(block[i]).for_each(|(sum, own)| *sum += own);
                }
            }
        }
    }

    /// A row of coordinates by vectors, of which some come twice.
    fn row(&self, entries: &[(Vector, [f64; 3])]) -> Vec<f64> {
        let mut row = vec![0.0; 3 * self.vectors.len()];
        for (vector, own) in entries {
            let place = 3 * self.place(*vector);
            let sums = row[place..][..3].iter_mut();
            sums.zip(own).for_each(|(sum, own)| *sum += own);
        }
        row
    }

    fn add_rim(&mut self, rim: &RimBend) {
        self.add_product(rim.factor, [&rim.change, &rim.motion]);
        self.add_product(rim.factor, [&rim.motion, &rim.change]);
    }

    /// Adds factor p q of two rows of coordinates by vectors.
    pub(super) fn add_product(&mut self, factor: f64, both: [&[(Vector, [f64; 3])]; 2]) {
        let [p, q] = both.map(|own| self.row(own));
        let rows = self.entries.chunks_exact_mut(p.len());
        for (row, first) in rows.zip(&p).filter(|(_, first)| **first != 0.0) {
            let factor = factor * first;
            let entries = row.iter_mut().zip(&q);
            entries.for_each(|(sum, second)| *sum += factor * second);
        }
    }

    fn add_kink(&mut self, both: [&[Vector; VECTORS]; 2], kink: &Kink) {
        let width = 3 * self.vectors.len();
        let mut slope = vec![0.0; width];
        for (k, own) in kink.slope.iter().enumerate() {
            let vector = if k < kinks::VECTORS - NODES {
                both[0][k]
            } else {
                both[1][k - NODES]
            };
            let place = 3 * self.place(vector);
            let entries = slope[place..][..3].iter_mut();
            entries.zip(own).for_each(|(sum, own)| *sum += own);
        }
        let rows = self.entries.chunks_exact_mut(width);
        for (row, first) in rows.zip(&slope).filter(|(_, first)| **first != 0.0) {
            let factor = kink.factor * first;
            let entries = row.iter_mut().zip(&slope);
            entries.for_each(|(sum, second)| *sum += factor * second);
        }
    }
}
