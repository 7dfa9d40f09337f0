//! Gaps in space by functions, their coupling and curvature by displacement unknowns.
//!
//! ```text
//! dG = G_x dx + G_n dn,   d2G = G_xx + G_xn dn + dn' G_nx + dn' G_nn dn + G_n.d2n
//! ```
//!
//! What pieces give is by nodes and normals; normals stand as unknowns after those of the displacement
//! until all pieces are summed, and are then put in by their own derivatives. Cost: one sort of the
//! entries of each row.

use std::sync::OnceLock;

use super::bends::{FaceBend, Part, parts};
use super::normals::{FanAt, Row, Vector};
use super::pair::{Gradients, Placed, Totals};
use super::patch::NODES;
use super::skin::Skin;
use crate::contact::shares::add_equal_columns;
use crate::geometry::vector3::max_norm;
use crate::pairs::between::{Derivatives, Gaps, raise};
use crate::parallel::{self, Pieces};

/// Fewer rows are not worth a second thread.
pub(super) const FEW: usize = 16;
/// Parts of faces whose second derivatives are held at once: 45 MB at most; 8 faces on 4,608 take 1.2 GB
/// in all so, 2.8 without.
pub(super) const AT_ONCE: usize = 64;
/// Entries of a row over what is left of it where equal columns are summed, without unit; chosen.
const LONG: usize = 4;

/// Two surfaces where they are, function by function.
pub(in crate::pairs) struct SpaceGaps<'a> {
    placed: &'a Placed<'a>,
    /// Functions of each face of the carrier `[faces]`.
    functions: &'a [[u32; NODES]],
    /// Number of functions.
    count: usize,
    /// Displacement unknowns.
    unknowns: usize,
    /// Sums of the meetings, once they are asked for.
    totals: OnceLock<Vec<Totals>>,
}

impl<'a> SpaceGaps<'a> {
    /// Of surfaces with the functions of the carrier's faces, and numbers of functions and of
    /// displacement unknowns.
    pub(super) fn new(
        placed: &'a Placed<'a>,
        functions: &'a [[u32; NODES]],
        [count, unknowns]: [usize; 2],
    ) -> Self {
        Self {
            placed,
            functions,
            count,
            unknowns,
            totals: OnceLock::new(),
        }
    }
}

impl SpaceGaps<'_> {
    /// The surfaces.
    pub(super) fn placed(&self) -> &Placed<'_> {
        self.placed
    }

    /// Number of functions.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// Functions of a face.
    pub(super) fn functions_of(&self, face: usize) -> [u32; NODES] {
        self.functions[face]
    }

    fn skin(&self) -> &Skin {
        &self.placed.pair.carrier
    }

    /// Sums of what faces give.
    fn summed<'b>(&self, of_faces: impl Iterator<Item = (usize, &'b [f64; NODES])>) -> Vec<f64> {
        let mut sums = vec![0.0; self.count];
        for (face, own) in of_faces {
            for (&function, own) in self.functions[face].iter().zip(own) {
                sums[function as usize] += own;
            }
        }
        sums
    }

    fn of_meetings(&self, part: impl Fn(&Totals) -> &[f64; NODES]) -> Vec<f64> {
        let meetings = self.placed.meetings.iter().zip(self.totals());
        self.summed(meetings.map(|(meeting, own)| (meeting.face, part(own))))
    }

    /// Sums of the meetings, made once.
    fn totals(&self) -> &[Totals] {
        self.totals.get_or_init(|| self.placed.totals())
    }

    /// First column of a vector; those of normals are after the displacement.
    pub(super) fn column(&self, vector: Vector) -> u32 {
        match vector {
            Vector::Node(node) => 3 * node,
            Vector::Normal(normal) => self.unknowns as u32 + 3 * normal,
        }
    }

    fn fan(&self, number: usize) -> FanAt<'_> {
        let placed = self.placed;
        FanAt::new((self.skin(), &placed.patches, &placed.normals), number)
    }

    /// Rows of dn of all normals `[normals][3]`.
    fn normal_rows(&self) -> Vec<[Row; 3]> {
        parallel::map(self.skin().fans.len(), FEW, &|k| self.fan(k).rows())
    }

    /// Puts in the motion of the normals.
    fn put_in(&self, row: &mut Row, normals: &[[Row; 3]]) {
        add_equal_columns(row);
        let first = row.partition_point(|&(k, _)| (k as usize) < self.unknowns);
        for (k, value) in row.split_off(first) {
            let k = k as usize - self.unknowns;
            let own = normals[k / 3][k % 3].iter();
            row.extend(own.map(|&(column, one)| (column, value * one)));
        }
        add_equal_columns(row);
    }

    /// Adds what lines beyond rims do to the rows of gaps by nodes and normals.
    fn add_rims(&self, rows: &mut [Row]) {
        let placed = self.placed;
        let found = parallel::map(placed.meetings.len(), FEW, &|k| {
            let meeting = &placed.meetings[k];
            let pieces = meeting.pieces.iter();
            let points = pieces.flat_map(|piece| placed.rim_points(meeting.face, piece));
            points.collect::<Vec<_>>()
        });
        for (meeting, points) in placed.meetings.iter().zip(found) {
            for point in points {
                let functions = self.functions[meeting.face].iter();
                for (&function, factor) in functions.zip(point.swept()) {
                    let entries = point.motion.iter().flat_map(|&(vector, own)| {
                        let first = self.column(vector);
                        (0..3).map(move |i| (first + i, factor * own[i as usize]))
                    });
                    rows[function as usize].extend(entries);
                }
            }
        }
    }

    /// Rows of gaps by nodes and normals `[functions]`.
    fn raw_rows(&self, found: Vec<Vec<Gradients>>) -> Vec<Row> {
        let mut rows = vec![Row::new(); self.count];
        for (meeting, gradients) in self.placed.meetings.iter().zip(found) {
            for (piece, own) in meeting.pieces.iter().zip(gradients) {
                let vectors = self.placed.vectors(meeting.face, piece);
                let columns = vectors.map(|vector| self.column(vector));
                for (&function, own) in self.functions[meeting.face].iter().zip(&own) {
                    let entries = columns.iter().zip(own);
                    rows[function as usize].extend(
                        entries.flat_map(|(&k, own)| (0..3).map(move |i| (k + i, own[i as usize]))),
                    );
                }
            }
        }
        rows
    }

    /// Second derivatives by nodes and normals, and derivatives by normals `[normals][3]`.
    fn raw_bend(
        &self,
        parts: &[Part<'_>],
        bend: &(dyn Fn(&Part<'_>) -> FaceBend + Sync),
    ) -> (Vec<Row>, Vec<[f64; 3]>) {
        let fans = self.skin().fans.len();
        let mut rows = vec![Row::new(); self.unknowns + 3 * fans];
        let mut by_normals = vec![[0.0; 3]; fans];
        let mut settled = vec![0; rows.len()];
        for parts in parts.chunks(AT_ONCE) {
            let found = parallel::map(parts.len(), 1, &|k| bend(&parts[k]));
            for (part, bend) in parts.iter().zip(found) {
                let normals = self.skin().faces[part.meeting.face].normals;
                for (normal, own) in normals.into_iter().zip(bend.by_normals) {
                    (0..3).for_each(|i| by_normals[normal as usize][i] += own[i]);
                }
                self.add_bend(&bend, &mut rows);
            }
            for (row, settled) in rows.iter_mut().zip(&mut settled) {
                shorten(row, settled);
            }
        }
        (rows, by_normals)
    }

    /// Second derivatives of parts by displacement unknowns: normals put in.
    pub(super) fn bent(
        &self,
        parts: &[Part<'_>],
        bend: &(dyn Fn(&Part<'_>) -> FaceBend + Sync),
    ) -> Vec<Row> {
        let (mut rows, by_normals) = self.raw_bend(parts, bend);
        let normals = self.normal_rows();
        self.put_in_with(&mut rows, &normals);
        let of_normals = rows.split_off(self.unknowns);
        for (k, own) in of_normals.into_iter().enumerate() {
            for &(row, factor) in &normals[k / 3][k % 3] {
                let entries = own.iter();
                rows[row as usize].extend(entries.map(|&(column, one)| (column, factor * one)));
            }
        }
        for (k, by_normal) in by_normals.into_iter().enumerate() {
            if max_norm(by_normal) > 0.0 {
                self.fan(k).add_bend(by_normal, &mut rows);
            }
        }
        rows
    }

    /// Puts the motion of the normals into rows.
    pub(super) fn put_in_all(&self, rows: &mut [Row]) {
        self.put_in_with(rows, &self.normal_rows());
    }

    fn put_in_with(&self, rows: &mut [Row], normals: &[[Row; 3]]) {
        parallel::each(Pieces::of(rows, 1), FEW, &|_, rows| {
            rows.iter_mut().for_each(|row| self.put_in(row, normals));
        });
    }

    fn add_bend(&self, bend: &FaceBend, rows: &mut [Row]) {
        let firsts = bend.vectors.iter().map(|&vector| self.column(vector));
        let columns: Vec<u32> = firsts
            .flat_map(|first| [first, first + 1, first + 2])
            .collect();
        let entries = bend.entries.chunks_exact(columns.len());
        for (&row, entries) in columns.iter().zip(entries) {
            let entries = columns.iter().copied().zip(entries.iter().copied());
            rows[row as usize].extend(entries.filter(|(_, value)| *value != 0.0));
        }
    }
}

/// Sums equal columns of a row that has grown to many times what was left of it before.
pub(super) fn shorten(row: &mut Row, settled: &mut usize) {
    if row.len() > LONG * (1 + *settled) {
        add_equal_columns(row);
        *settled = row.len();
    }
}

impl Gaps for SpaceGaps<'_> {
    fn values(&self) -> Vec<f64> {
        self.of_meetings(|totals| &totals.gaps)
    }

    fn derivatives(&self) -> Derivatives {
        let mut rows = self.raw_rows(self.placed.gradients());
        self.add_rims(&mut rows);
        self.put_in_all(&mut rows);
        Derivatives {
            values: self.values(),
            rows,
        }
    }

    fn at_rest(&self) -> Derivatives {
        let found = self.placed.at_rest().into_iter();
        let (gaps, gradients): (Vec<[f64; NODES]>, Vec<_>) = found.unzip();
        let faces = self.placed.meetings.iter().map(|meeting| meeting.face);
        let values = self.summed(faces.zip(&gaps));
        let mut rows = self.raw_rows(gradients);
        for row in &mut rows {
            // Normals stay where they are.
            row.retain(|&(column, _)| (column as usize) < self.unknowns);
            add_equal_columns(row);
        }
        Derivatives { values, rows }
    }

    fn curvature(&self, factors: &[f64]) -> Vec<Row> {
        let of_face = |face: usize| self.functions[face].map(|k| factors[k as usize]);
        let loaded = self.placed.meetings.iter();
        let loaded =
            loaded.filter(|meeting| of_face(meeting.face).iter().any(|factor| *factor != 0.0));
        let parts: Vec<Part<'_>> = loaded.flat_map(parts).collect();
        self.bent(&parts, &|part| {
            self.placed.face_bend(part, of_face(part.meeting.face))
        })
    }

    fn covered(&self) -> [Vec<f64>; 2] {
        let whole = self.placed.whole();
        [
            self.of_meetings(|totals| &totals.covered),
            self.summed(whole.iter().enumerate()),
        ]
    }

    fn shares(&self) -> Vec<f64> {
        let whole = self.placed.whole();
        let mut shares = vec![0.0; self.count];
        for (meeting, own) in self.placed.meetings.iter().zip(self.totals()) {
            let (functions, whole) = (&self.functions[meeting.face], &whole[meeting.face]);
            raise(&mut shares, functions, [&own.covered, whole]);
        }
        shares
    }

    fn deepest(&self) -> f64 {
        let totals = self.totals().iter();
        totals.map(|own| own.deepest).fold(0.0, f64::max)
    }

    fn reach(&self) -> f64 {
        self.placed.reach
    }
}
