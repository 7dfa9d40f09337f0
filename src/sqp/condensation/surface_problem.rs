//! Contact on the surface alone, by dense cone problems with frozen normals:
//!
//! ```text
//! l' = argmin 1/2 x.H x + (g - C G q).x over the set,   H = C G C^T,   q' = C^T l',   u' = u0 - G q'
//! ```
//!
//! with gap g and coupling C at u = u0 - G q. H is made once: after the first problem normals have
//! hardly turned, and its error meets what pressures still change alone,
//!
//! ```text
//! l' = argmin 1/2 x.H x + (g + C G (C^T l - q) - H l).x
//! ```
//!
//! Multipliers that neither press nor would be
//! negative take no part. It ends where `C(u')^T l'` is q' and the gaps hold, both well within the
//! tolerance.

use crate::parallel;
use std::sync::Arc;

use super::columns::Columns;
use super::kept::{BodyResponse, Free};
use super::near::Near;
use crate::inequality::dense_cone;
use crate::linalg::vector::{norm, ratio};
use crate::linalg::{DenseMatrix, LinearOperator, SparseRows, Workspace};
use crate::model::evaluate::{Evaluation, evaluate_contact};
use crate::model::state::State;
use crate::saddle::{AdmissibleSet, ProductSet, SetPart, Status};
use crate::sqp::run::Run;

constants! {
    /// Problems at most.
    const MOST: usize = 30;
    /// Share of the tolerance that is left to what follows, and of what is left that a problem takes
    /// off at least.
    const SHARE: f64 = 0.5;
    /// Share of the mean diagonal that keeps redundant constraints solvable.
    const LIFT: f64 = 1e-12;
    /// Share of what is left that a problem with an H of earlier normals has to leave at most.
    const FRESH: f64 = 0.2;
    /// What may be left where problems take no more off: programs do.
    const ROUNDING: f64 = 1e-7;
}

/// Contact on the surface of a body.
pub(super) struct SurfaceProblem<'a> {
    /// G and K.
    pub(super) body: &'a BodyResponse,
    /// G where contact presses.
    pub(super) near: &'a mut Near,
    /// u0.
    pub(super) free: &'a Free,
}

/// Where the problems have come to.
pub(super) struct Iterate {
    /// Displacement, of which only the surface is true, multipliers and statuses.
    pub(super) state: State,
    /// q, the contact load `[displacement]`.
    pub(super) load: Vec<f64>,
    /// Gaps and coupling there.
    pub(super) now: Evaluation,
}

/// H of a problem before.
struct Compliance {
    /// The multipliers that it knows, ascending.
    known: Vec<usize>,
    /// C G C^T of these.
    matrix: DenseMatrix,
}

impl Compliance {
    /// H of multipliers that are all known.
    fn part(&self, taking_part: &[usize]) -> Option<DenseMatrix> {
        let places = taking_part.iter().map(|i| self.known.binary_search(i).ok());
        let places: Option<Vec<usize>> = places.collect();
        places.map(|places| self.matrix.principal(&places))
    }
}

impl SurfaceProblem<'_> {
    /// From the run's state, where that evaluation holds, to where contact holds; the load that
    /// has moved the surface there, where it is known. None where the problems
    /// do not end, or are stopped.
    pub(super) fn solve(
        mut self,
        run: &mut Run<'_>,
        start: (Evaluation, Option<Arc<[f64]>>),
    ) -> Option<Iterate> {
        let mut at = self.start(run, start)?;
        let mut before = f64::INFINITY;
        let mut compliance = None;
        for _ in 0..MOST {
            let load = pressing(&at.now, &at.state, run.work);
            let left = left_over(run, &at, &load);
            let is_rounding = left <= ROUNDING && left > SHARE * before;
            if left <= SHARE * run.model.conditions.tolerance || is_rounding {
                return Some(at);
            }
            if left > FRESH * before {
                compliance = None;
            }
            before = left;
            let changed = self.improve(run, &mut at, (&load, &mut compliance))?;
            run.counters.set_changes += u32::from(changed);
        }
        None
    }

    /// The surface where it is by the known load, or under the multipliers of the state, pressing
    /// along the normals of where they press now.
    fn start(
        &self,
        run: &mut Run<'_>,
        (now, known): (Evaluation, Option<Arc<[f64]>>),
    ) -> Option<Iterate> {
        let state = run.state.clone();
        if let Some(load) = known {
            let load = load.to_vec();
            return Some(Iterate { state, load, now });
        }
        let load = pressing(&now, run.state, run.work);
        let mut at = Iterate { state, load, now };
        self.move_surface(run, &mut at)?;
        Some(at)
    }

    /// Moves the surface to where the load brings it.
    fn move_surface(&self, run: &Run<'_>, at: &mut Iterate) -> Option<()> {
        let pressed: Vec<usize> = self.body.columns.pressed(&at.load);
        self.ask_for(run, &pressed)?;
        let load = self.body.columns.values(&pressed, &at.load);
        let mut surface: Vec<f64> = (self.body.columns.unknowns.iter())
            .map(|&unknown| self.free.displacement[unknown as usize])
            .collect();
        self.body
            .columns
            .subtract_product((&pressed, &load), &mut surface);
        for (&unknown, value) in self.body.columns.unknowns.iter().zip(surface) {
            at.state.displacement[unknown as usize] = value;
        }
        at.now = evaluate_contact(&run.model, &at.state);
        Some(())
    }

    /// Makes columns known; none where that is stopped.
    fn ask_for(&self, run: &Run<'_>, places: &[usize]) -> Option<()> {
        let stopped = || run.stopped().is_some();
        self.body
            .columns
            .ask_for(places, &self.body.factor, &stopped)
    }

    /// One problem, `pressing_now` being the load of the present multipliers; whether the set has
    /// changed. None where it has no solution.
    fn improve(
        &mut self,
        run: &mut Run<'_>,
        at: &mut Iterate,
        (pressing_now, compliance): (&[f64], &mut Option<Compliance>),
    ) -> Option<bool> {
        let taking_part = taking_part(at);
        let known = compliance.as_ref();
        let (matrix, linear) = match known.and_then(|known| known.part(&taking_part)) {
            Some(matrix) => {
                let about = (&taking_part[..], pressing_now, &matrix);
                let linear = self.linear_term_about(run, at, about)?;
                (matrix, linear)
            }
            None => {
                let made = self.compliance(run, at, &taking_part)?;
                let matrix = compliance.insert(made).matrix.clone();
                (matrix, self.linear_term(at, &taking_part))
            }
        };
        let sets = sets(&at.now, &taking_part);
        let own = |values: &[f64]| -> Vec<f64> { taking_part.iter().map(|&i| values[i]).collect() };
        let status: Vec<Status> = taking_part.iter().map(|&i| at.state.status[i]).collect();
        let near = (&status[..], &own(&at.state.multiplier)[..]);
        let solution = dense_cone::solve(&matrix, &linear, ProductSet::Parts(&sets), near).ok()?;
        let before = at.state.status.clone();
        at.state.multiplier.fill(0.0);
        at.state.status.fill(Status::Open);
        for (place, &index) in taking_part.iter().enumerate() {
            at.state.multiplier[index] = solution.values[place];
            at.state.status[index] = solution.status[place];
        }
        at.load = pressing(&at.now, &at.state, run.work);
        self.move_surface(run, at)?;
        Some(before != at.state.status)
    }

    /// H of those that take part; none where its columns are stopped.
    fn compliance(
        &mut self,
        run: &Run<'_>,
        at: &Iterate,
        taking_part: &[usize],
    ) -> Option<Compliance> {
        let rows = Rows::new(&at.now.coupling, taking_part, &self.body.columns);
        self.ask_for(run, &rows.places)?;
        self.near.cover(&rows.places, &self.body.columns);
        Some(Compliance {
            known: taking_part.to_vec(),
            matrix: rows.compliance(self.near),
        })
    }

    /// g - C G q of those that take part.
    fn linear_term(&self, at: &Iterate, taking_part: &[usize]) -> Vec<f64> {
        let free = &self.free.displacement;
        let moved = |&i: &usize| -> f64 {
            let (columns, values) = at.now.coupling.row(i);
            let entries = columns.iter().zip(values);
            let way =
                |&column: &u32| free[column as usize] - at.state.displacement[column as usize];
            entries.map(|(column, value)| value * way(column)).sum()
        };
        let gaps = taking_part.iter();
        gaps.map(|i| at.now.gap[*i] - moved(i)).collect()
    }

    /// g + C G (C^T l - q) - H l of those that take part, C^T l being `pressing`; none where its
    /// columns are stopped.
    fn linear_term_about(
        &self,
        run: &Run<'_>,
        at: &Iterate,
        (taking_part, pressing, matrix): (&[usize], &[f64], &DenseMatrix),
    ) -> Option<Vec<f64>> {
        let columns = &self.body.columns;
        let turned: Vec<f64> = at.load.iter().zip(pressing).map(|(q, l)| q - l).collect();
        let places = columns.pressed(&turned);
        self.ask_for(run, &places)?;
        let mut moved = vec![0.0; columns.unknowns.len()];
        columns.subtract_product((&places, &columns.values(&places, &turned)), &mut moved);
        let own: Vec<f64> = taking_part
            .iter()
            .map(|&i| at.state.multiplier[i])
            .collect();
        let mut known = vec![0.0; own.len()];
        matrix.multiply(&own, &mut known);
        let gap = |(&i, known): (&usize, &f64)| {
            let (unknowns, values) = at.now.coupling.row(i);
            let entries = unknowns.iter().zip(values);
            let entries =
                entries.filter_map(|(&unknown, value)| Some((columns.place(unknown)?, value)));
            let way: f64 = entries.map(|(place, value)| value * moved[place]).sum();
            at.now.gap[i] + way - known
        };
        Some(taking_part.iter().zip(&known).map(gap).collect())
    }
}

/// C(u)^T l, the load of the multipliers along the normals there `[displacement]`.
pub(super) fn pressing(now: &Evaluation, state: &State, work: &mut Workspace) -> Vec<f64> {
    let mut load = vec![0.0; state.displacement.len()];
    now.coupling
        .apply_transposed(&state.multiplier, &mut load, work);
    load
}

/// What is left of equilibrium and gaps: how far the load that presses there is from the one that
/// moved the surface, and the gaps over their scale.
fn left_over(run: &Run<'_>, at: &Iterate, pressing: &[f64]) -> f64 {
    let wrong = pressing.iter().zip(&at.load).map(|(a, b)| (a - b).powi(2));
    let gap = ratio(at.now.gap_norm(&at.state), run.state.scales.gap);
    ratio(wrong.sum::<f64>().sqrt(), norm(&at.load)).max(gap)
}

/// Multipliers that press, that would be negative, or that hold both ways.
fn taking_part(at: &Iterate) -> Vec<usize> {
    let takes_part = |i: usize, is_free: bool| {
        let acts = !at.now.coupling.row(i).0.is_empty();
        acts && (is_free || at.state.status[i].is_closed() || at.now.gap[i] < 0.0)
    };
    let mut first = 0;
    let mut all = Vec::new();
    for part in &at.now.sets {
        let is_free = matches!(part.set, AdmissibleSet::Free);
        all.extend((first..first + part.size).filter(|&i| takes_part(i, is_free)));
        first += part.size;
    }
    all
}

/// Their sets.
fn sets(now: &Evaluation, taking_part: &[usize]) -> Vec<SetPart<'static>> {
    let mut first = 0;
    let parts = now.sets.iter().map(|part| {
        let own = first..first + part.size;
        first = own.end;
        SetPart {
            size: taking_part.iter().filter(|&i| own.contains(i)).count(),
            set: part.set,
        }
    });
    parts.collect()
}

/// Rows of C that take part, by the places that they see.
struct Rows {
    /// Places on the surface that any row sees, ascending.
    places: Vec<usize>,
    /// Entries of each row by their place.
    rows: Vec<Vec<(usize, f64)>>,
}

impl Rows {
    fn new(coupling: &SparseRows, taking_part: &[usize], columns: &Columns) -> Self {
        let row = |&index: &usize| {
            let (unknowns, values) = coupling.row(index);
            let entries = unknowns.iter().zip(values);
            let placed = |(&unknown, &value)| Some((columns.place(unknown)?, value));
            entries.filter_map(placed).collect::<Vec<(usize, f64)>>()
        };
        let rows: Vec<Vec<(usize, f64)>> = taking_part.iter().map(row).collect();
        let mut places: Vec<usize> = rows.iter().flatten().map(|&(place, _)| place).collect();
        places.sort_unstable();
        places.dedup();
        Self { places, rows }
    }

    /// C G C^T, from G near contact.
    fn compliance(mut self, near: &Near) -> DenseMatrix {
        let entries = self.rows.iter_mut().flatten();
        entries.for_each(|(place, _)| *place = near.index(*place));
        let size = self.rows.len();
        let rows = &self.rows;
        let column = |index: usize| below_diagonal(rows, index, near);
        let columns = parallel::map(size, 1, &column);
        let mut matrix = DenseMatrix::zeros(size, size);
        for (j, column) in columns.iter().enumerate() {
            matrix.column_mut(j)[j..].copy_from_slice(column);
            (j..)
                .zip(column)
                .for_each(|(i, value)| *matrix.at_mut(j, i) = *value);
        }
        let trace: f64 = (0..size).map(|i| matrix.at(i, i)).sum();
        let lift = LIFT * trace / size.max(1) as f64;
        (0..size).for_each(|i| *matrix.at_mut(i, i) += lift);
        matrix
    }
}

/// Column `index` of C G C^T from its diagonal down, rows on places near contact.
fn below_diagonal(rows: &[Vec<(usize, f64)>], index: usize, near: &Near) -> Vec<f64> {
    let mut moved = vec![0.0; near.size()];
    for &(place, value) in &rows[index] {
        let entries = moved.iter_mut().zip(near.column(place));
        entries.for_each(|(y, g)| *y += value * g);
    }
    let entry = |other: &Vec<(usize, f64)>| -> f64 {
        let terms = other.iter();
        terms.map(|&(place, value)| value * moved[place]).sum()
    };
    rows[index..].iter().map(entry).collect()
}
