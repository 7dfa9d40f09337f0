//! Slips of a surface of multipliers along the other surface ([`super::slip`]), with what tractions do
//! on both, as friction asks for them.
//!
//! ```text
//! slip_j = S_j,   rows R_j (columns on both surfaces),   force of tractions - sum_j t_j R_j
//! ```
//!
//! Shapes: `[multipliers * tangents]`, one in the plane and about an axis, two in space, rows by
//! displacement unknowns, non-dimensional. A linear body has R where
//! it is at rest (`rest`) and S = R (u - u0). Functions without a partner have no slip and no row.

use super::pair::Placed;
use super::piece::NODES;
use super::plane::{PlaneGaps, PlaneSides, unknowns};
use super::slip::{Sliding, SlipPart};
use super::space::sliding::From;
use super::surface::{PairSurface, Sides, free_matrix, keep_free, uncovered};
use crate::contact::shares::add_equal_columns;
use crate::contact::{ContactSurface, Deformed, Measure};
use crate::linalg::SparseRows;

/// Entries by unknown.
type Row = Vec<(u32, f64)>;

impl PairSurface {
    /// Takes the rows of slips where surfaces of the linear `body` touch.
    pub fn freeze_sliding(&mut self, body: &Deformed<'_>, surface: &ContactSurface) {
        let moved = self.touching(body, surface);
        let at = Deformed {
            displacement: &moved,
            ..*body
        };
        self.sliding_at_rest = Some(match &self.sides {
            Sides::Plane(sides) => {
                let rest = |placed: &Placed<'_>| placed.slips_at_rest();
                sides.sliding_of(&at, &rest, surface)
            }
            Sides::Space(sides) => sides.sliding(&at, From::Rest, surface),
        });
    }

    /// Slips since nodes were displaced by `start` `[displacement unknowns]`.
    pub fn sliding(&self, body: &Deformed<'_>, start: &[f64], surface: &ContactSurface) -> Sliding {
        let Some(rest) = &self.sliding_at_rest else {
            return match &self.sides {
                Sides::Plane(sides) => {
                    let place = place_at(body, start);
                    sides.sliding_of(body, &|placed| placed.slid(&place), surface)
                }
                Sides::Space(sides) => sides.sliding(body, From::Start(start), surface),
            };
        };
        let change = |row: &Row| -> f64 {
            let by = |&(k, value): &(u32, f64)| {
                let k = k as usize;
                value * (body.displacement[k] - start[k])
            };
            row.iter().map(by).sum()
        };
        let mut sliding = Sliding {
            slips: rest.rows.iter().map(change).collect(),
            ..rest.clone()
        };
        if let Sides::Space(sides) = &self.sides {
            sides.hold((&mut sliding, surface), [start, body.displacement]);
        }
        sliding
    }

    /// dS `[multipliers * tangents]` without `held` columns; none of a linear body, whose rows are dS.
    pub fn sliding_change(
        &self,
        (body, surface): (&Deformed<'_>, &ContactSurface),
        start: &[f64],
        held: &[bool],
    ) -> Option<Vec<Row>> {
        if body.measure != Measure::Deformed {
            return None;
        }
        let mut rows = match &self.sides {
            Sides::Plane(sides) => sides.sliding_change((body, surface), start),
            Sides::Space(sides) => sides.sliding_change((body, surface), start),
        };
        rows.iter_mut().for_each(|row| keep_free(row, held));
        Some(rows)
    }

    /// What `tractions` `[multipliers * tangents]` take off the stiffness, without `held` rows and columns; none
    /// of a linear body.
    pub fn traction_change(
        &self,
        body: &Deformed<'_>,
        (surface, tractions): (&ContactSurface, &[f64]),
        held: &[bool],
    ) -> Option<SparseRows> {
        if body.measure != Measure::Deformed {
            return None;
        }
        let rows = match &self.sides {
            Sides::Plane(sides) => sides.traction_change((body, surface), tractions),
            Sides::Space(sides) => sides.traction_change((body, surface), tractions),
        };
        Some(free_matrix(rows, held))
    }

    /// Tangents of the multipliers where they are known without slips: of linear bodies, and in space.
    pub fn frames(
        &self,
        body: &Deformed<'_>,
        surface: &ContactSurface,
    ) -> Option<Vec<[[f64; 3]; 2]>> {
        match (&self.sliding_at_rest, &self.sides) {
            (Some(rest), _) => Some(rest.frames.clone()),
            (None, Sides::Plane(_)) => None,
            (None, Sides::Space(sides)) => Some(sides.frames_at(body, surface)),
        }
    }
}

impl PlaneSides {
    /// Slips and rows of functions from what `parts` tells of the pieces.
    fn sliding_of(
        &self,
        body: &Deformed<'_>,
        parts: &dyn Fn(&Placed<'_>) -> Vec<SlipPart>,
        surface: &ContactSurface,
    ) -> Sliding {
        let count = surface.carriers.len();
        self.placed((body, surface), |placed| {
            let [mut slips, mut weights, mut x, mut y] = [0; 4].map(|_| vec![0.0; count]);
            let mut rows: Vec<Row> = vec![Vec::new(); count];
            for part in parts(placed) {
                self.add(part.face, part.slips, &mut slips);
                self.add(part.face, part.areas, &mut weights);
                self.add(part.face, part.tangents[0], &mut x);
                self.add(part.face, part.tangents[1], &mut y);
                self.add_rows((part.face, &part.nodes), &part.rows, &mut rows);
            }
            let shares = &surface.shares;
            let [x, y] = [x, y].map(|own| shares.gather(own));
            Sliding {
                frames: x.into_iter().zip(y).map(frame).collect(),
                slips: shares.gather(slips),
                weights: shares.gather(weights),
                rows: self.finished(rows, (placed, surface)),
            }
        })
    }

    /// Adds rows of the three functions of a face to those of all `[functions]`.
    fn add_rows<const N: usize>(
        &self,
        (face, nodes): (usize, &[u32; NODES]),
        own: &[[f64; N]; 3],
        rows: &mut [Row],
    ) {
        for (function, own) in self.functions_of(face).into_iter().zip(own) {
            let entries = unknowns(nodes).zip(own.iter().copied());
            rows[function as usize].extend(entries);
        }
    }

    /// dS `[multipliers]`.
    fn sliding_change(
        &self,
        (body, surface): (&Deformed<'_>, &ContactSurface),
        start: &[f64],
    ) -> Vec<Row> {
        let place = place_at(body, start);
        self.placed((body, surface), |placed| {
            let mut rows: Vec<Row> = vec![Vec::new(); surface.carriers.len()];
            for part in placed.slips_first(&place) {
                let own = part.gaps.map(|gap| gap.first);
                self.add_rows((part.face, &part.nodes), &own, &mut rows);
            }
            self.finished(rows, (placed, surface))
        })
    }

    /// Rows of what `tractions` `[multipliers]` take off the stiffness.
    fn traction_change(
        &self,
        (body, surface): (&Deformed<'_>, &ContactSurface),
        tractions: &[f64],
    ) -> Vec<Row> {
        let coefficients = surface.shares.spread(tractions);
        let factors: Vec<[f64; 3]> = self.of_faces(&coefficients);
        let mut rows: Vec<Row> = vec![Vec::new(); body.space.displacement_unknowns()];
        self.placed((body, surface), |placed| {
            for (nodes, change) in placed.traction_changes(&factors) {
                let columns: Vec<u32> = unknowns(&nodes).collect();
                for (&row, entries) in columns.iter().zip(change.iter()) {
                    let own = columns.iter().copied().zip(entries.iter().copied());
                    rows[row as usize].extend(own);
                }
            }
        });
        rows
    }

    /// Rows of the multipliers; nothing in those without a partner.
    fn finished(
        &self,
        mut rows: Vec<Row>,
        (placed, surface): (&Placed<'_>, &ContactSurface),
    ) -> Vec<Row> {
        rows.iter_mut().for_each(add_equal_columns);
        let mut rows = surface.shares.gather_rows(rows);
        let found = PlaneGaps {
            sides: self,
            placed,
            count: surface.carriers.len(),
            unknowns: 0,
        };
        let uncovered = uncovered(&found, surface);
        for (row, _) in rows
            .iter_mut()
            .zip(&uncovered)
            .filter(|(_, far)| far.is_some())
        {
            row.clear();
        }
        rows
    }
}

/// The unit tangent of a mean one.
fn frame((x, y): (f64, f64)) -> [[f64; 3]; 2] {
    let size = x.hypot(y);
    let along = if size > 0.0 {
        [x / size, y / size, 0.0]
    } else {
        [0.0; 3]
    };
    [along, [0.0; 3]]
}

/// Where nodes are that `start` displaces.
fn place_at<'a>(body: &Deformed<'a>, start: &'a [f64]) -> impl Fn(u32) -> [f64; 2] + Sync + 'a {
    let at = body.displaced(start);
    move |node| {
        let [x, y, _] = at.place(node as usize);
        [x, y]
    }
}
