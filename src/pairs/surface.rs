//! A surface of multipliers that meets another surface of the body: weighted gaps, their coupling and
//! their curvature, as the contact integrals of obstacles give them.
//!
//! ```text
//! gap_j = G_j,   C = -dG/du   (columns on both surfaces),   K = sum_j Lam_j Hess G_j
//! ```
//!
//! Shapes: gaps and rows `[multipliers]`, K `[unknowns, unknowns]`, all non-dimensional. At finite
//! strain about the deformed surfaces; a linear body has G and dG where it is at rest, so that G is
//! linear in u. A function of which less than `LEAST_COVERED` has a partner has no row, and a gap as
//! wide as the search. Cost: see [`super::pair`].

use std::collections::BTreeSet;

use super::chain::Chain;
use super::number::Second;
use super::pair::{Pair, Placed};
use super::piece::{INPUTS, NODES, Section};
use super::probing::Probing;
use super::slip::Sliding;
use crate::contact::shares::add_equal_columns;
use crate::contact::{ContactSurface, Deformed, Linearisation, Measure};
use crate::linalg::{SparseRows, SparseRowsBuilder};
use crate::mesh::Mesh;
use crate::space::TaylorHood;

/// Share of a function that must have a partner for it to press.
const LEAST_COVERED: f64 = 1e-3;

/// The functions of a surface and what they meet.
#[derive(Clone, Debug)]
pub struct PairSurface {
    pub(super) pair: Pair,
    /// Functions of each face of the carrier: of its ends a and b and its edge `[faces]`.
    functions: Vec<[u32; 3]>,
    /// Gaps and rows of all columns at rest, of a linear body.
    at_rest: Option<Linearisation>,
    /// Rows of slips at rest, of a linear body with friction.
    pub(super) sliding_at_rest: Option<Sliding>,
}

/// What surfaces lie on.
#[derive(Clone, Copy)]
pub struct Ground<'a> {
    /// The mesh.
    pub mesh: &'a Mesh,
    /// Numbering of the displacement.
    pub space: &'a TaylorHood,
    /// Whether supports hold a displacement unknown.
    pub is_held: &'a dyn Fn(u32) -> bool,
}

/// Force and moment of a contact.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PairForce {
    /// Force on the body that carries the pressures `[2]`, non-dimensional.
    pub on_carrier: [f64; 2],
    /// Its moment about the origin.
    pub moment: f64,
    /// Force on the other body `[2]`.
    pub on_other: [f64; 2],
    /// Its moment about the origin.
    pub other_moment: f64,
}

impl PairForce {
    /// Adds the force on a node of the carrier or of the other surface.
    fn add(&mut self, body: &Deformed<'_>, (node, force): (u32, [f64; 2]), is_other: bool) {
        let [x, y, _] = body.place(node as usize);
        let (total, turn) = if is_other {
            (&mut self.on_other, &mut self.other_moment)
        } else {
            (&mut self.on_carrier, &mut self.moment)
        };
        *turn += x * force[1] - y * force[0];
        // An even motion moves vertices alone: edges have what they are off the mean of these.
        if (node as usize) < body.space.vertices {
            total
                .iter_mut()
                .zip(force)
                .for_each(|(sum, own)| *sum += own);
        }
    }

    /// The part along the axis of a body of revolution, which bears the rest itself.
    fn along_axis(self) -> Self {
        Self {
            on_carrier: [0.0, self.on_carrier[1]],
            on_other: [0.0, self.on_other[1]],
            ..Self::default()
        }
    }
}

impl PairSurface {
    /// Of the facets `carrier`, those of `surface` in their order, and `other`.
    pub fn new(
        ground: Ground<'_>,
        [carrier, other]: [&[u32]; 2],
        (surface, section): (&ContactSurface, Section),
    ) -> Self {
        let Ground { mesh, space, .. } = ground;
        let pair = Pair {
            carrier: Chain::new(mesh, space, carrier).between_walls(mesh, ground.is_held),
            other: Chain::new(mesh, space, other),
            section,
        };
        let faces = pair.carrier.faces.iter().zip(&surface.faces);
        let functions = faces.map(|(face, own)| {
            let [a, b, edge] = [0, 1, 2].map(|k| own.functions.get(k).copied().unwrap_or(0));
            if face.is_turned {
                [b, a, edge]
            } else {
                [a, b, edge]
            }
        });
        Self {
            functions: functions.collect(),
            pair,
            at_rest: None,
            sliding_at_rest: None,
        }
    }

    /// Takes gaps and their derivative where the linear `body` is at rest.
    pub fn freeze(&mut self, body: &Deformed<'_>, surface: &ContactSurface) {
        let free = vec![false; body.space.displacement_unknowns()];
        self.at_rest = Some(self.linearise(body, surface, &free));
    }

    /// What `task` makes of the surfaces where `body` has them.
    pub(super) fn placed<T>(&self, body: &Deformed<'_>, task: impl FnOnce(&Placed<'_>) -> T) -> T {
        let place = |node: u32| {
            let [x, y, _] = body.place(node as usize);
            [x, y]
        };
        task(&self.pair.placed(&place))
    }

    /// Weighted gaps `[multipliers]`, and the deepest penetration.
    pub fn gaps(&self, body: &Deformed<'_>, surface: &ContactSurface) -> (Vec<f64>, f64) {
        if let Some(rest) = &self.at_rest {
            let moved = from_rest(rest, body.displacement, surface);
            return (moved.gap, moved.max_penetration);
        }
        self.placed(body, |placed| {
            let mut gaps = vec![0.0; surface.carriers.len()];
            for part in placed.gaps() {
                self.add_gaps(part.face, part.gaps, &mut gaps);
            }
            let mut gaps = surface.shares.gather(gaps);
            for (gap, open) in gaps.iter_mut().zip(self.uncovered(placed, surface)) {
                *gap = open.unwrap_or(*gap);
            }
            (gaps, deepest(placed))
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
            None => self.placed(body, |placed| self.linearised(placed, surface)),
        };
        part.rows.iter_mut().for_each(|row| keep_free(row, held));
        part
    }

    /// Gaps and coupling to all columns.
    fn linearised(&self, placed: &Placed<'_>, surface: &ContactSurface) -> Linearisation {
        let mut gap = vec![0.0; surface.carriers.len()];
        let mut rows = vec![Vec::new(); gap.len()];
        for part in placed.first() {
            self.add_gaps(part.face, part.gaps.map(|own| own.value), &mut gap);
            for (&function, own) in self.functions[part.face].iter().zip(&part.gaps) {
                let row: &mut Vec<(u32, f64)> = &mut rows[function as usize];
                let entries = unknowns(&part.nodes).zip(&own.first);
                row.extend(entries.map(|(unknown, change)| (unknown, -change)));
            }
        }
        rows.iter_mut().for_each(add_equal_columns);
        let mut rows = surface.shares.gather_rows(rows);
        let mut gap = surface.shares.gather(gap);
        let uncovered = self.uncovered(placed, surface);
        for ((gap, row), open) in gap.iter_mut().zip(&mut rows).zip(uncovered) {
            if let Some(open) = open {
                *gap = open;
                row.clear();
            }
        }
        Linearisation {
            gap,
            rows,
            max_penetration: deepest(placed),
        }
    }

    /// Values of functions by the faces `[faces]`.
    pub(super) fn of_faces(&self, values: &[f64]) -> Vec<[f64; 3]> {
        let faces = self.functions.iter();
        let of_face = |own: &[u32; 3]| own.map(|function| values[function as usize]);
        faces.map(of_face).collect()
    }

    /// The functions of a face.
    pub(super) fn functions_of(&self, face: usize) -> [u32; 3] {
        self.functions[face]
    }

    pub(super) fn add_gaps(&self, face: usize, own: [f64; 3], gaps: &mut [f64]) {
        for (&function, gap) in self.functions[face].iter().zip(own) {
            gaps[function as usize] += gap;
        }
    }

    /// Gaps of multipliers without a partner `[multipliers]`; none of others.
    pub(super) fn uncovered(
        &self,
        placed: &Placed<'_>,
        surface: &ContactSurface,
    ) -> Vec<Option<f64>> {
        let mut sums = [0, 1].map(|_| vec![0.0; surface.carriers.len()]);
        for (face, own) in placed.covered().into_iter().enumerate() {
            for (sums, own) in sums.iter_mut().zip(own) {
                self.add_gaps(face, own, sums);
            }
        }
        let [covered, whole] = sums.map(|sums| surface.shares.gather(sums));
        let pairs = covered.into_iter().zip(whole);
        pairs
            .map(|(covered, whole)| {
                (covered < LEAST_COVERED * whole).then_some(placed.reach * whole)
            })
            .collect()
    }

    /// K under `pressures` `[multipliers]`, without `held` rows and columns; nothing for linear bodies.
    pub fn curvature(
        &self,
        body: &Deformed<'_>,
        (surface, pressures): (&ContactSurface, &[f64]),
        held: &[bool],
    ) -> SparseRows {
        let mut rows = vec![Vec::new(); body.space.displacement_unknowns()];
        if body.measure == Measure::Deformed {
            let coefficients = surface.shares.spread(pressures);
            let factors = self.of_faces(&coefficients);
            self.placed(body, |placed| {
                for (nodes, sum) in placed.second(&factors) {
                    add_block(&nodes, &sum, held, &mut rows);
                }
            });
        }
        let mut builder = SparseRowsBuilder::new(rows.len());
        for mut row in rows {
            add_equal_columns(&mut row);
            row.retain(|&(_, value)| value != 0.0);
            builder.push_row(&mut row);
        }
        builder.finish()
    }

    /// Forces of `pressures` `[multipliers]` on both bodies: derivatives of the gaps.
    pub fn forces(
        &self,
        body: &Deformed<'_>,
        (surface, pressures): (&ContactSurface, &[f64]),
    ) -> PairForce {
        let free = vec![false; body.space.displacement_unknowns()];
        let rows = self.linearise(body, surface, &free).rows;
        let pushing: Vec<f64> = pressures.iter().map(|pressure| -pressure).collect();
        self.forces_of(body, &rows, &pushing)
    }

    /// Forces of multipliers `values` along `rows` of unknowns on both bodies.
    pub fn forces_of(
        &self,
        body: &Deformed<'_>,
        rows: &[Vec<(u32, f64)>],
        values: &[f64],
    ) -> PairForce {
        let mut forces = vec![[0.0; 2]; body.space.nodes()];
        for (row, factor) in rows.iter().zip(values) {
            for &(unknown, value) in row {
                forces[unknown as usize / 2][unknown as usize % 2] += value * factor;
            }
        }
        let others = self.pair.other.faces.iter().flat_map(|face| face.nodes);
        let others: BTreeSet<u32> = others.collect();
        let mut sum = PairForce::default();
        for (node, force) in (0..).zip(&forces) {
            sum.add(body, (node, *force), others.contains(&node));
        }
        match self.pair.section {
            Section::Plane => sum,
            Section::AboutAxis => sum.along_axis(),
        }
    }

    /// What points of the carrier's faces are to the other surface.
    pub fn probing(&self, body: &Deformed<'_>) -> Probing {
        self.placed(body, |placed| Probing::new(&self.pair, placed))
    }
}

/// The two unknowns of each node of a piece.
pub(super) fn unknowns(nodes: &[u32; NODES]) -> impl Iterator<Item = u32> + '_ {
    nodes.iter().flat_map(|&node| [2 * node, 2 * node + 1])
}

/// Adds the second derivatives of a piece to free rows, at free columns.
fn add_block(
    nodes: &[u32; NODES],
    sum: &Second<INPUTS>,
    held: &[bool],
    rows: &mut [Vec<(u32, f64)>],
) {
    let columns: Vec<u32> = unknowns(nodes).collect();
    for (i, &row) in columns.iter().enumerate() {
        if held[row as usize] {
            continue;
        }
        let entries = columns.iter().enumerate();
        let entries = entries.map(|(j, &column)| (column, sum.second_by(i, j)));
        rows[row as usize].extend(entries.filter(|&(column, _)| !held[column as usize]));
    }
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

/// The deepest penetration at a point of the rule.
fn deepest(placed: &Placed<'_>) -> f64 {
    let probes = placed.meetings.iter();
    let probes = probes.flat_map(|meeting| placed.probes(meeting));
    probes.map(|probe| -probe.distance).fold(0.0, f64::max)
}
