//! Slips along the other surface in space by functions and multipliers, their rows, and how both change:
//!
//! ```text
//! S_ma = t0_ma . V_m,   R_ma = t_ma . W_m,   T_m = sum_a s_ma t_ma
//! d(sum_ma s_ma R_ma) = sum_m T_m . dW_m + dT_m . W_m
//! ```
//!
//! V and W those of functions ([`super::slips`]), gathered to multipliers, t the tangents of the
//! function of a multiplier now, t0 when the increment began ([`super::frames`]): both turn with the
//! carrier, so that motions of all bodies together are no slip. Shapes: rows `[multipliers * 2]`, V and W
//! `[functions * 3]`. Cost: W some three times the rows of gaps.

use super::bends::{FaceBend, Part, parts};
use super::frames::{Frame, IsMoved, TangentsAt, held_alike, is_moved};
use super::normals::Row;
use super::pair::Meeting;
use super::patch::Patch;
use super::sides::SpaceSides;
use super::slips::{Before, Blocks};
use super::sums::{AT_ONCE, FEW, SpaceGaps, shorten};
use crate::contact::shares::add_equal_columns;
use crate::contact::{ContactSurface, Deformed};
use crate::geometry::vector3::dot;
use crate::pairs::between::Gaps;
use crate::pairs::slip::Sliding;
use crate::pairs::surface::uncovered;
use crate::parallel;

/// Tangents of a point.
const TANGENTS: usize = 2;

/// Where slips begin.
#[derive(Clone, Copy)]
pub(in crate::pairs) enum From<'a> {
    /// Displacements when the increment began.
    Start(&'a [f64]),
    /// Nowhere: rows of linear bodies at rest.
    Rest,
}

impl SpaceGaps<'_> {
    /// V `[functions][3]`.
    pub(super) fn slid(&self, before: &Before) -> Vec<[f64; 3]> {
        let meetings = &self.placed().meetings;
        let found = parallel::map(meetings.len(), FEW, &|k| {
            self.placed().slid(&meetings[k], before)
        });
        let mut sums = vec![[0.0; 3]; self.count()];
        for (meeting, own) in meetings.iter().zip(found) {
            for (&function, own) in self.functions_of(meeting.face).iter().zip(own) {
                let sum = sums[function as usize].iter_mut();
                sum.zip(own).for_each(|(sum, own)| *sum += own);
            }
        }
        sums
    }

    /// Rows of W `[functions * 3]`.
    pub(super) fn pulls(&self, from: From<'_>) -> Vec<Row> {
        match from {
            From::Start(_) => self.block_rows(&|face, piece| self.placed().pulls((face, piece))),
            From::Rest => {
                self.block_rows(&|face, piece| self.placed().pulls_at_rest((face, piece)))
            }
        }
    }

    /// Rows of dV `[functions * 3]`.
    pub(super) fn slid_slopes(&self, before: &Before) -> Vec<Row> {
        let slopes = |face: usize, piece: &_| self.placed().slid_slopes((face, piece), before);
        let mut rows = self.raw_block_rows(&slopes);
        for meeting in &self.placed().meetings {
            self.add_slid_rims((meeting, before), &mut rows);
        }
        self.put_in_all(&mut rows);
        rows
    }

    /// Adds what lines beyond rims do.
    fn add_slid_rims(&self, (meeting, before): (&Meeting, &Before), rows: &mut [Row]) {
        for piece in &meeting.pieces {
            for point in self.placed().rim_points(meeting.face, piece) {
                let slid = point.slid([meeting.face, piece.other], before);
                for (&function, slid) in self.functions_of(meeting.face).iter().zip(slid) {
                    for (i, factor) in slid.into_iter().enumerate() {
                        let entries = point.motion.iter().flat_map(|&(vector, own)| {
                            let first = self.column(vector);
                            (0..3).map(move |k| (first + k, factor * own[k as usize]))
                        });
                        rows[3 * function as usize + i].extend(entries);
                    }
                }
            }
        }
    }

    fn block_rows(&self, of_piece: &PieceBlocks<'_>) -> Vec<Row> {
        let mut rows = self.raw_block_rows(of_piece);
        self.put_in_all(&mut rows);
        rows
    }

    /// Rows of what pieces have, by nodes and normals `[functions * 3]`.
    fn raw_block_rows(&self, of_piece: &PieceBlocks<'_>) -> Vec<Row> {
        let mut rows = vec![Row::new(); 3 * self.count()];
        let mut settled = vec![0; rows.len()];
        for meetings in self.placed().meetings.chunks(AT_ONCE) {
            let found = parallel::map(meetings.len(), 1, &|k| {
                let pieces = meetings[k].pieces.iter();
                let blocks = pieces.map(|piece| of_piece(meetings[k].face, piece));
                blocks.collect::<Vec<_>>()
            });
            for (meeting, own) in meetings.iter().zip(found) {
                self.add_blocks((meeting, &own), (&mut rows, &mut settled));
            }
        }
        rows
    }

    /// Adds what the pieces of a meeting have.
    fn add_blocks(
        &self,
        (meeting, found): (&Meeting, &[Box<Blocks>]),
        (rows, settled): (&mut [Row], &mut [usize]),
    ) {
        let functions = self.functions_of(meeting.face);
        for (piece, own) in meeting.pieces.iter().zip(found) {
            let vectors = self.placed().vectors(meeting.face, piece);
            let columns = vectors.map(|vector| self.column(vector));
            for (&function, own) in functions.iter().zip(own.iter()) {
                for i in 0..3 {
                    let entries = columns.iter().zip(own).flat_map(|(&first, block)| {
                        (0..3).map(move |k| (first + k, block[i][k as usize]))
                    });
                    let entries = entries.filter(|(_, value)| *value != 0.0);
                    rows[3 * function as usize + i].extend(entries);
                }
            }
        }
        for row in functions
            .iter()
            .flat_map(|&function| 3 * function..3 * function + 3)
        {
            shorten(&mut rows[row as usize], &mut settled[row as usize]);
        }
    }

    /// Change of the forces of vectors T `[functions][3]` that keep their directions.
    pub(super) fn pull_changes(&self, tractions: &[[f64; 3]]) -> Vec<Row> {
        let of_face = |face: usize| self.functions_of(face).map(|k| tractions[k as usize]);
        let meetings = self.placed().meetings.iter();
        let loaded = meetings.filter(|meeting| {
            let own = of_face(meeting.face);
            own.as_flattened().iter().any(|value| *value != 0.0)
        });
        let parts: Vec<Part<'_>> = loaded.flat_map(parts).collect();
        let bend = |part: &Part<'_>| -> FaceBend {
            self.placed().pull_bend(part, &of_face(part.meeting.face))
        };
        self.bent(&parts, &bend)
    }
}

/// What a piece of a face has.
type PieceBlocks<'a> = dyn Fn(usize, &super::choice::Piece) -> Box<Blocks> + Sync + 'a;

impl SpaceSides {
    /// Slips from where they begin, with their rows.
    pub(in crate::pairs) fn sliding(
        &self,
        body: &Deformed<'_>,
        from: From<'_>,
        surface: &ContactSurface,
    ) -> Sliding {
        self.gaps_of(body, surface.carriers.len(), |gaps| {
            let patches = &gaps.placed().patches;
            let (frames, slips) = match from {
                From::Start(start) => {
                    let is_moved = is_moved(start, body.displacement);
                    let slips = self.slips((gaps, surface), body, start);
                    (self.frames(patches, surface, &is_moved), slips)
                }
                From::Rest => {
                    let frames = self.all_frames(patches, surface);
                    let none = vec![0.0; TANGENTS * frames.len()];
                    (frames, none)
                }
            };
            let [covered, _] = gaps.covered();
            Sliding {
                weights: surface.shares.gather(covered),
                rows: projected(gaps.pulls(from), &frames, (gaps, surface)),
                slips,
                frames,
            }
        })
    }

    /// S.
    fn slips(
        &self,
        (gaps, surface): (&SpaceGaps<'_>, &ContactSurface),
        body: &Deformed<'_>,
        start: &[f64],
    ) -> Vec<f64> {
        let (before, frames) = self.before(body, start, surface);
        let by_function = gaps.slid(&before);
        let axes = [0, 1, 2].map(|i: usize| {
            let own = by_function.iter().map(|slid| slid[i]);
            surface.shares.gather(own.collect())
        });
        let slid = |m: usize| [0, 1, 2].map(|i: usize| axes[i][m]);
        let along = frames.iter().enumerate();
        along
            .flat_map(|(m, frame)| frame.map(|tangent| dot(tangent, slid(m))))
            .collect()
    }

    /// dS.
    pub(in crate::pairs) fn sliding_change(
        &self,
        (body, surface): (&Deformed<'_>, &ContactSurface),
        start: &[f64],
    ) -> Vec<Row> {
        let (before, frames) = self.before(body, start, surface);
        self.gaps_of(body, surface.carriers.len(), |gaps| {
            projected(gaps.slid_slopes(&before), &frames, (gaps, surface))
        })
    }

    /// Rows of what `tractions` `[multipliers * 2]` take off the stiffness.
    pub(in crate::pairs) fn traction_change(
        &self,
        (body, surface): (&Deformed<'_>, &ContactSurface),
        tractions: &[f64],
    ) -> Vec<Row> {
        self.gaps_of(body, surface.carriers.len(), |gaps| {
            let patches = &gaps.placed().patches;
            let frames = self.all_frames(patches, surface);
            let spread = spread((&frames, tractions), surface);
            let mut rows = gaps.pull_changes(&spread);
            let pulls = gathered(gaps.pulls(From::Start(&[])), surface);
            for (m, parts) in tractions.chunks_exact(TANGENTS).enumerate() {
                let (Some(k), [s1, s2]) = (surface.shares.function(m as u32), [parts[0], parts[1]])
                else {
                    continue;
                };
                if s1 == 0.0 && s2 == 0.0 {
                    continue;
                }
                let tangents = TangentsAt::new(self.tangents(k), patches);
                let turned = tangents.rows(&self.pair.carrier, [s1, s2]);
                add_products((&pulls, m), &turned, &mut rows);
            }
            rows
        })
    }

    /// Both surfaces where `start` has them, and the tangents there.
    fn before(
        &self,
        body: &Deformed<'_>,
        start: &[f64],
        surface: &ContactSurface,
    ) -> (Before, Vec<Frame>) {
        let at = body.displaced(start);
        let place = |node: u32| at.place(node as usize);
        let patches = self.pair.carrier.patches(&place);
        let before = Before {
            own: self.pair.carrier.rayed(&patches).1,
            others: self.pair.other.patches(&place),
        };
        let is_moved = is_moved(start, body.displacement);
        (before, self.frames(&patches, surface, &is_moved))
    }

    /// Tangents of the multipliers where faces of the carrier are `patches`.
    fn frames(
        &self,
        patches: &[Patch],
        surface: &ContactSurface,
        is_moved: &IsMoved<'_>,
    ) -> Vec<Frame> {
        let all = 0..surface.multipliers() as u32;
        let frame = |m: u32| {
            let tangents = surface.shares.function(m).map(|k| self.tangents(k));
            let at = tangents.map(|tangents| TangentsAt::new(tangents, patches));
            at.map_or([[0.0; 3]; 2], |at| at.frame(is_moved))
        };
        all.map(frame).collect()
    }

    /// Both tangents, whatever holds the surfaces.
    fn all_frames(&self, patches: &[Patch], surface: &ContactSurface) -> Vec<Frame> {
        self.frames(patches, surface, &|_, _| true)
    }

    /// Takes tangents off the slips of linear bodies along which both surfaces are held and moved alike from
    /// `start` to `now`.
    pub(in crate::pairs) fn hold(
        &self,
        (sliding, surface): (&mut Sliding, &ContactSurface),
        [start, now]: [&[f64]; 2],
    ) {
        let is_moved = is_moved(start, now);
        for m in 0..sliding.frames.len() {
            let Some(k) = surface.shares.function(m as u32) else {
                continue;
            };
            for place in held_alike(self.tangents(k), sliding.frames[m], &is_moved) {
                sliding.frames[m][place] = [0.0; 3];
                sliding.rows[TANGENTS * m + place].clear();
                sliding.slips[TANGENTS * m + place] = 0.0;
            }
        }
    }

    /// Tangents of the multipliers where `body` is.
    pub(in crate::pairs) fn frames_at(
        &self,
        body: &Deformed<'_>,
        surface: &ContactSurface,
    ) -> Vec<Frame> {
        let place = |node: u32| body.place(node as usize);
        self.all_frames(&self.pair.carrier.patches(&place), surface)
    }
}

/// Vectors of functions from `tractions` along the tangents of multipliers `[functions][3]`.
fn spread((frames, tractions): (&[Frame], &[f64]), surface: &ContactSurface) -> Vec<[f64; 3]> {
    let pairs = frames.iter().zip(tractions.chunks_exact(TANGENTS));
    let vectors: Vec<[f64; 3]> = pairs
        .map(|([first, second], own)| {
            [0, 1, 2].map(|i: usize| own[0] * first[i] + own[1] * second[i])
        })
        .collect();
    let axes = [0, 1, 2].map(|i: usize| {
        let own: Vec<f64> = vectors.iter().map(|vector| vector[i]).collect();
        surface.shares.spread(&own).into_owned()
    });
    let all = 0..axes[0].len();
    all.map(|k| [0, 1, 2].map(|i: usize| axes[i][k])).collect()
}

/// Rows by axes of the multipliers `[3][multipliers]` from those of functions `[functions * 3]`.
fn gathered(rows: Vec<Row>, surface: &ContactSurface) -> [Vec<Row>; 3] {
    let mut axes: [Vec<Row>; 3] = Default::default();
    for (place, row) in rows.into_iter().enumerate() {
        axes[place % 3].push(row);
    }
    axes.map(|rows| surface.shares.gather_rows(rows))
}

/// Rows of the multipliers along their tangents; nothing in those without a partner.
fn projected(
    rows: Vec<Row>,
    frames: &[Frame],
    (gaps, surface): (&SpaceGaps<'_>, &ContactSurface),
) -> Vec<Row> {
    let axes = gathered(rows, surface);
    let far = uncovered(gaps, surface);
    let mut all = Vec::with_capacity(TANGENTS * frames.len());
    for (m, (frame, far)) in frames.iter().zip(&far).enumerate() {
        for tangent in frame {
            let is_any = far.is_none() && tangent.iter().any(|part| *part != 0.0);
            let parts = axes.iter().zip(tangent).filter(|_| is_any);
            let mut row: Row = parts
                .flat_map(|(rows, factor)| rows[m].iter().map(move |&(k, x)| (k, factor * x)))
                .collect();
            add_equal_columns(&mut row);
            all.push(row);
        }
    }
    all
}

/// Adds dT.W of a multiplier.
fn add_products((pulls, m): (&[Vec<Row>; 3], usize), turned: &[Row; 3], rows: &mut [Row]) {
    for (own, turned) in pulls.iter().zip(turned) {
        for &(row, factor) in &own[m] {
            let entries = turned.iter();
            rows[row as usize].extend(entries.map(|&(k, value)| (k, factor * value)));
        }
    }
}
