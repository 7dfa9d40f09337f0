//! The two sides of a contact in the plane or about an axis, function by function.
//!
//! Shapes: of each face of the carrier the functions of its ends a and b and its edge; sums
//! `[functions]`, rows by displacement unknowns, two a node. Cost: see [`super::pair`].

use super::between::{Derivatives, Gaps, Row, raise};
use super::chain::Chain;
use super::fading::{Known, parts};
use super::fold::{Fold, Meets};
use super::ground::Ground;
use super::number::{First, Second};
use super::pair::{Pair, Part, Placed};
use super::piece::{INPUTS, NODES, Section};

use crate::contact::shares::add_equal_columns;
use crate::contact::{ContactSurface, Deformed};

/// Two surfaces and the functions of the first one.
#[derive(Clone, Debug)]
pub(super) struct PlaneSides {
    pub(super) pair: Pair,
    /// Functions of each face of the carrier `[faces]`.
    functions: Vec<[u32; 3]>,
    /// The part that each face of the other surface is of; empty where there is one, and on one body.
    parts: Vec<u32>,
}

impl PlaneSides {
    /// Of the facets `carrier`, those of `surface` in their order, and `other`, which it `meets`.
    pub(super) fn new(
        ground: Ground<'_>,
        ([carrier, other], meets): ([&[u32]; 2], Meets),
        (surface, section): (&ContactSurface, Section),
    ) -> Self {
        let Ground { mesh, space, .. } = ground;
        let carrier = Chain::new(mesh, space, carrier).between_walls(mesh, ground.is_held);
        let other = Chain::new(mesh, space, other);
        let pair = Pair {
            fold: Fold::new((mesh, space), [&carrier, &other], meets),
            carrier,
            other,
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
        let mut parts = parts(mesh, space, &pair.other);
        if pair.fold.is_some() || parts.iter().all(|part| *part == 0) {
            parts.clear();
        }
        Self {
            functions: functions.collect(),
            parts,
            pair,
        }
    }

    /// What `task` makes of the surfaces where `body` has them.
    pub(super) fn placed<T>(
        &self,
        (body, surface): (&Deformed<'_>, &ContactSurface),
        task: impl FnOnce(&Placed<'_>) -> T,
    ) -> T {
        let place = |node: u32| {
            let [x, y, _] = body.place(node as usize);
            [x, y]
        };
        let placed = self.pair.placed(&place);
        if self.parts.is_empty() {
            return task(&placed);
        }
        let of = Known {
            functions: &self.functions,
            parts: &self.parts,
            shares: &surface.shares,
        };
        task(&placed.fading(of))
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

    /// Adds what a face gives to sums `[functions]`.
    pub(super) fn add(&self, face: usize, own: [f64; 3], sums: &mut [f64]) {
        for (&function, own) in self.functions[face].iter().zip(own) {
            sums[function as usize] += own;
        }
    }
}

/// The sides where they are.
pub(super) struct PlaneGaps<'a> {
    pub(super) sides: &'a PlaneSides,
    pub(super) placed: &'a Placed<'a>,
    /// Number of functions.
    pub(super) count: usize,
    /// Displacement unknowns.
    pub(super) unknowns: usize,
}

impl PlaneGaps<'_> {
    /// Gaps and rows of functions from those of pieces.
    fn summed(&self, parts: &[Part<First<INPUTS>>]) -> Derivatives {
        let mut values = vec![0.0; self.count];
        let mut rows = vec![Row::new(); self.count];
        for part in parts {
            let own = part.gaps.map(|own| own.value);
            self.sides.add(part.face, own, &mut values);
            let functions = self.sides.functions_of(part.face);
            for (function, own) in functions.into_iter().zip(&part.gaps) {
                let entries = unknowns(&part.nodes).zip(own.first);
                rows[function as usize].extend(entries);
            }
        }
        rows.iter_mut().for_each(add_equal_columns);
        Derivatives { values, rows }
    }
}

impl Gaps for PlaneGaps<'_> {
    fn values(&self) -> Vec<f64> {
        let mut gaps = vec![0.0; self.count];
        for part in self.placed.gaps() {
            self.sides.add(part.face, part.gaps, &mut gaps);
        }
        gaps
    }

    fn derivatives(&self) -> Derivatives {
        self.summed(&self.placed.first())
    }

    fn at_rest(&self) -> Derivatives {
        self.summed(&self.placed.gaps_at_rest())
    }

    fn curvature(&self, factors: &[f64]) -> Vec<Row> {
        let mut rows = vec![Row::new(); self.unknowns];
        let factors = self.sides.of_faces(factors);
        for (nodes, sum) in self.placed.second(&factors) {
            add_block(&nodes, &sum, &mut rows);
        }
        rows
    }

    fn covered(&self) -> [Vec<f64>; 2] {
        let mut sums = [0, 1].map(|_| vec![0.0; self.count]);
        for (face, own) in self.placed.covered().into_iter().enumerate() {
            for (sums, own) in sums.iter_mut().zip(own) {
                self.sides.add(face, own, sums);
            }
        }
        sums
    }

    fn shares(&self) -> Vec<f64> {
        let mut shares = vec![0.0; self.count];
        for (face, [covered, whole]) in self.placed.covered().iter().enumerate() {
            let functions = self.sides.functions_of(face);
            raise(&mut shares, &functions, [covered, whole]);
        }
        shares
    }

    fn deepest(&self) -> f64 {
        let meetings = self.placed.meetings.iter();
        let probes = meetings.flat_map(|meeting| self.placed.probes(meeting));
        probes.map(|probe| -probe.distance).fold(0.0, f64::max)
    }

    fn reach(&self) -> f64 {
        self.placed.reach
    }
}

/// The two unknowns of each node of a piece.
pub(super) fn unknowns(nodes: &[u32; NODES]) -> impl Iterator<Item = u32> + '_ {
    nodes.iter().flat_map(|&node| [2 * node, 2 * node + 1])
}

/// Adds the second derivatives of a piece.
fn add_block(nodes: &[u32; NODES], sum: &Second<INPUTS>, rows: &mut [Row]) {
    let columns: Vec<u32> = unknowns(nodes).collect();
    for (i, &row) in columns.iter().enumerate() {
        let entries = columns.iter().enumerate();
        let entries = entries.map(|(j, &column)| (column, sum.second_by(i, j)));
        rows[row as usize].extend(entries);
    }
}
