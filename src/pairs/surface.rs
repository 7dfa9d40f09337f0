//! A surface of multipliers that meets another surface of the body: weighted gaps, their coupling and
//! their curvature, as the contact integrals of obstacles give them.
//!
//! ```text
//! gap_j = G_j,   C = -dG/du   (columns on both surfaces),   K = sum_j Lam_j Hess G_j
//! ```
//!
//! Shapes: gaps and rows `[multipliers]`, K `[unknowns, unknowns]`, all non-dimensional. At finite
//! strain about the deformed surfaces; of a linear body they are taken once, where the surfaces touch
//! (`touching`), by how these move against each other alone (`rest`), so that G is
//! linear in u. A function of which less than `LEAST_COVERED` has a partner, and one that others take
//! over, has no row, and a gap as wide as the search. Cost: see [`super::pair`] and [`super::space`].

use std::collections::BTreeSet;

use super::between::{Derivatives, Gaps};
use super::fold::Meets;
use super::ground::Ground;
use super::piece::Section;
use super::plane::{PlaneGaps, PlaneSides};
use super::probing::Probing;
use super::slip::Sliding;
use super::space::SpaceSides;
use crate::contact::shares::add_equal_columns;
use crate::contact::{ContactSurface, Counterpart, Deformed, Linearisation, Measure};
use crate::geometry::vector3::{add, cross};
use crate::linalg::{SparseRows, SparseRowsBuilder};

/// Share of a function that must have a partner for it to press.
const LEAST_COVERED: f64 = 1e-3;

/// The functions of a surface and what they meet.
#[derive(Clone, Debug)]
pub struct PairSurface {
    pub(super) sides: Sides,
    /// Components that supports hold at the node of each multiplier `[multipliers]`.
    pub(super) held: Vec<[bool; 3]>,
    /// Gaps and rows of all columns at rest, of a linear body.
    pub(super) at_rest: Option<Linearisation>,
    /// Rows of slips at rest, of a linear body with friction.
    pub(super) sliding_at_rest: Option<Sliding>,
}

/// Both surfaces.
#[derive(Clone, Debug)]
pub(super) enum Sides {
    Plane(PlaneSides),
    Space(SpaceSides),
}

/// Force and moment of a contact.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PairForce {
    /// Force on the body that carries the pressures `[3]`, non-dimensional.
    pub on_carrier: [f64; 3],
    /// Its moment about the origin `[3]`.
    pub moment: [f64; 3],
    /// Force on the other body `[3]`.
    pub on_other: [f64; 3],
    /// Its moment about the origin `[3]`.
    pub other_moment: [f64; 3],
}

impl PairForce {
    /// Adds the force on a node of the carrier or of the other surface.
    pub(super) fn add(
        &mut self,
        body: &Deformed<'_>,
        (node, force): (u32, [f64; 3]),
        is_other: bool,
    ) {
        let (total, turn) = if is_other {
            (&mut self.on_other, &mut self.other_moment)
        } else {
            (&mut self.on_carrier, &mut self.moment)
        };
        *turn = add(*turn, cross(body.place(node as usize), force));
        // An even motion moves vertices alone: edges have what they are off the mean of these.
        if (node as usize) < body.space.vertices {
            *total = add(*total, force);
        }
    }

    /// The same of a body of revolution: radial forces are summed over the full turn, moments cancel.
    pub(super) fn about_axis(self) -> Self {
        Self {
            moment: [0.0; 3],
            other_moment: [0.0; 3],
            ..self
        }
    }
}

impl PairSurface {
    /// Of the facets of the carrier, those of `surface` in their order, and of what it `meets`.
    pub fn new(
        ground: Ground<'_>,
        (facets, meets): ([&[u32]; 2], Meets),
        (surface, section): (&ContactSurface, Section),
    ) -> Self {
        let components = ground.space.components as u32;
        let held = |&node: &u32| {
            let is_held = |i: u32| i < components && (ground.is_held)(components * node + i);
            [0, 1, 2].map(is_held)
        };
        let carriers = (0..surface.multipliers() as u32).map(|multiplier| {
            let function = surface.shares.function(multiplier);
            function.and_then(|k| surface.carriers.get(k as usize))
        });
        let held = carriers.map(|node| node.map_or([false; 3], held)).collect();
        let sides = match ground.space.components {
            2 => Sides::Plane(PlaneSides::new(ground, (facets, meets), (surface, section))),
            _ => Sides::Space(SpaceSides::new(ground, (facets, meets), surface)),
        };
        Self {
            sides,
            held,
            at_rest: None,
            sliding_at_rest: None,
        }
    }

    /// Both sides in the plane or about an axis; none in space.
    pub(super) fn plane(&self) -> Option<&PlaneSides> {
        match &self.sides {
            Sides::Plane(plane) => Some(plane),
            Sides::Space(_) => None,
        }
    }

    /// Takes gaps and their derivative where surfaces of the linear `body` touch, for where it is at
    /// rest.
    pub fn freeze(&mut self, body: &Deformed<'_>, surface: &ContactSurface) {
        let moved = self.touching(body, surface);
        let at = Deformed {
            displacement: &moved,
            ..*body
        };
        let mut rest = self.where_it_is(&at, surface);
        for (gap, row) in rest.gap.iter_mut().zip(&rest.rows) {
            let back = row.iter().map(|&(k, value)| value * moved[k as usize]);
            *gap += back.sum::<f64>();
        }
        self.at_rest = Some(rest);
    }

    /// Gaps of linear bodies and how they change, where `body` has the surfaces.
    pub(super) fn where_it_is(
        &self,
        body: &Deformed<'_>,
        surface: &ContactSurface,
    ) -> Linearisation {
        self.gaps_of((body, surface), |found| {
            linearised(found, found.at_rest(), surface)
        })
    }

    /// Whether both surfaces are of one body.
    pub(super) fn is_folded(&self) -> bool {
        match &self.sides {
            Sides::Plane(plane) => plane.pair.fold.is_some(),
            Sides::Space(space) => space.pair.fold.is_some(),
        }
    }

    /// What `task` makes of the gaps of functions where `body` has the surfaces.
    pub(super) fn gaps_of<T>(
        &self,
        (body, surface): (&Deformed<'_>, &ContactSurface),
        task: impl FnOnce(&dyn Gaps) -> T,
    ) -> T {
        let (count, unknowns) = (surface.carriers.len(), body.space.displacement_unknowns());
        match &self.sides {
            Sides::Plane(sides) => sides.placed((body, surface), |placed| {
                task(&PlaneGaps {
                    sides,
                    placed,
                    count,
                    unknowns,
                })
            }),
            Sides::Space(sides) => sides.gaps_of(body, count, |gaps| task(gaps)),
        }
    }

    /// Weighted gaps `[multipliers]`, and the deepest penetration.
    pub fn gaps(&self, body: &Deformed<'_>, surface: &ContactSurface) -> (Vec<f64>, f64) {
        if let Some(rest) = &self.at_rest {
            let moved = from_rest(rest, body.displacement, surface);
            return (moved.gap, moved.max_penetration);
        }
        self.gaps_of((body, surface), |found| {
            let mut gaps = surface.shares.gather(found.values());
            for (gap, open) in gaps.iter_mut().zip(uncovered(found, surface)) {
                *gap = open.unwrap_or(*gap);
            }
            (gaps, found.deepest())
        })
    }

    /// Gaps and coupling without `held` columns.
    pub fn linearise(
        &self,
        body: &Deformed<'_>,
        surface: &ContactSurface,
        held: &[bool],
    ) -> Linearisation {
        let mut part = match &self.at_rest {
            Some(rest) => from_rest(rest, body.displacement, surface),
            None => self.gaps_of((body, surface), |found| {
                linearised(found, found.derivatives(), surface)
            }),
        };
        part.rows.iter_mut().for_each(|row| keep_free(row, held));
        part
    }

    /// K under `pressures` `[multipliers]`, without `held` rows and columns; nothing for linear bodies.
    pub fn curvature(
        &self,
        body: &Deformed<'_>,
        (surface, pressures): (&ContactSurface, &[f64]),
        held: &[bool],
    ) -> SparseRows {
        let size = body.space.displacement_unknowns();
        let rows = if body.measure == Measure::Deformed {
            let coefficients = surface.shares.spread(pressures);
            self.gaps_of((body, surface), |found| found.curvature(&coefficients))
        } else {
            vec![Vec::new(); size]
        };
        free_matrix(rows, held)
    }

    /// Forces of multipliers `values` along `rows` of unknowns on both bodies.
    pub(super) fn forces_of(
        &self,
        body: &Deformed<'_>,
        rows: &[Vec<(u32, f64)>],
        values: &[f64],
    ) -> PairForce {
        let components = body.space.components;
        let mut forces = vec![[0.0; 3]; body.space.nodes()];
        for (row, factor) in rows.iter().zip(values) {
            for &(unknown, value) in row {
                forces[unknown as usize / components][unknown as usize % components] +=
                    value * factor;
            }
        }
        let others = self.other_nodes();
        let mut sum = PairForce::default();
        for (node, force) in (0..).zip(&forces) {
            sum.add(body, (node, *force), others.contains(&node));
        }
        match &self.sides {
            Sides::Plane(plane) if plane.pair.section == Section::AboutAxis => sum.about_axis(),
            Sides::Plane(_) | Sides::Space(_) => sum,
        }
    }

    /// Displacement nodes of the other surface.
    pub(super) fn other_nodes(&self) -> BTreeSet<u32> {
        match &self.sides {
            Sides::Plane(plane) => {
                let faces = plane.pair.other.faces.iter();
                faces.flat_map(|face| face.nodes).collect()
            }
            Sides::Space(space) => {
                let faces = space.pair.other.faces.iter();
                faces.flat_map(|face| face.nodes).collect()
            }
        }
    }

    /// What points of the carrier's faces are to the other surface.
    pub fn probing(&self, body: &Deformed<'_>, surface: &ContactSurface) -> Box<dyn Counterpart> {
        match &self.sides {
            Sides::Plane(sides) => sides.placed((body, surface), |placed| {
                Box::new(Probing::new(&sides.pair, placed)) as Box<dyn Counterpart>
            }),
            Sides::Space(sides) => Box::new(sides.probing(body)),
        }
    }
}

/// Gaps and coupling to all columns.
fn linearised(
    found: &dyn Gaps,
    mut derivatives: Derivatives,
    surface: &ContactSurface,
) -> Linearisation {
    let entries = derivatives.rows.iter_mut().flatten();
    entries.for_each(|(_, value)| *value = -*value);
    let mut rows = surface.shares.gather_rows(derivatives.rows);
    let mut gap = surface.shares.gather(derivatives.values);
    let uncovered = uncovered(found, surface);
    for ((gap, row), open) in gap.iter_mut().zip(&mut rows).zip(uncovered) {
        if let Some(open) = open {
            *gap = open;
            row.clear();
        }
    }
    Linearisation {
        gap,
        rows,
        max_penetration: found.deepest(),
    }
}

/// Gaps of multipliers without a partner `[multipliers]`; none of others.
pub(super) fn uncovered(found: &dyn Gaps, surface: &ContactSurface) -> Vec<Option<f64>> {
    let [covered, whole] = found.covered().map(|sums| surface.shares.gather(sums));
    let pairs = covered.into_iter().zip(whole);
    let is_away = |covered: f64, whole: f64| covered < LEAST_COVERED * whole || whole <= 0.0;
    pairs
        .zip(&surface.weights)
        .map(|((covered, whole), weight)| {
            // One that others take over has no area left.
            let area = if whole > 0.0 { whole } else { *weight };
            is_away(covered, whole).then_some(found.reach() * area)
        })
        .collect()
}

/// The matrix of `rows` without `held` rows and columns.
pub(super) fn free_matrix(rows: Vec<Vec<(u32, f64)>>, held: &[bool]) -> SparseRows {
    let mut builder = SparseRowsBuilder::new(rows.len());
    for (mut row, &is_held) in rows.into_iter().zip(held) {
        if is_held {
            row.clear();
        }
        keep_free(&mut row, held);
        add_equal_columns(&mut row);
        row.retain(|&(_, value)| value != 0.0);
        builder.push_row(&mut row);
    }
    builder.finish()
}

pub(super) fn keep_free(row: &mut Vec<(u32, f64)>, held: &[bool]) {
    row.retain(|&(unknown, _)| !held[unknown as usize]);
}

/// Gaps of a linear body displaced from rest, their coupling there, and the deepest mean penetration
/// of a function.
fn from_rest(
    rest: &Linearisation,
    displacement: &[f64],
    surface: &ContactSurface,
) -> Linearisation {
    let change = |row: &Vec<(u32, f64)>| -> f64 {
        let terms = row.iter();
        terms
            .map(|&(unknown, value)| value * displacement[unknown as usize])
            .sum()
    };
    let pairs = rest.gap.iter().zip(&rest.rows);
    let gap: Vec<f64> = pairs.map(|(gap, row)| gap - change(row)).collect();
    let depths = gap.iter().zip(&surface.weights);
    let depths = depths.map(|(gap, weight)| -gap / weight);
    Linearisation {
        max_penetration: depths.fold(0.0, f64::max),
        gap,
        rows: rest.rows.clone(),
    }
}
