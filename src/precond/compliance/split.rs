//! The factor of a principal part of the compliance by what it is made of:
//!
//! ```text
//! K = s (M - W W^T),   M = N + V G V^T
//! M^-1 = N^-1 - N^-1 V (G^-1 + V^T N^-1 V)^-1 V^T N^-1
//! K^-1 = M^-1 (1 + W (1 - W^T M^-1 W)^-1 W^T M^-1) / s
//! ```
//!
//! N `[part, part]`: nodes that move alone, sparse; G `[traces, traces]`: the inverse at the
//! vertices that the part touches, V its rows there; W `[part, volumes]` (M. Woodbury, 1950).
//! With T = G^-1 + V^T N^-1 V and H = V^T N^-1 W a solution takes two solves with N:
//! `q = N^-1 x, t = T^-1 V^T q, a = (1 - W^T M^-1 W)^-1 (W^T q - H^T t)`, then
//! `N^-1 (x + W a - V (t + T^-1 H a))`.
//! Quadratic multipliers are two to four times as many as vertices: on n of them that touch v
//! traces the factor takes about v^3 and v sparse solves instead of n^3 / 3, a solution
//! 2 v^2 instead of 2 n^2, and no matrix of n rows is stored. Where N is nearly singular
//! digits are lost: a factor that misses a known solution is not used.

use super::Compliance;
use super::part::Touched;
use crate::linalg::cholesky::{LowerColumns, Precision};
use crate::linalg::vector::{add_scaled, dot, norm, reproducible_noise, scale};
use crate::linalg::{
    DenseCholesky, DenseMatrix, PartFactor, SparseCholesky, SymmetricMatrix, Workspace,
};
use crate::parallel::{self, Scratch};

/// Rows of the smallest part that is worth it.
const LEAST: usize = 256;
/// Traces over rows up to which it is.
const SHARE: f64 = 0.6;
/// Relative error of a known solution up to which the factor serves.
const MISS: f64 = 1e-7;
/// Right-hand sides that are solved together.
const PANEL: usize = 32;

/// The factor of a part by its parts.
pub(super) struct SplitFactor {
    /// Of N.
    nodes: SparseCholesky,
    /// V: each row on the traces of the part `[part]`.
    rows: Vec<Vec<(u32, f64)>>,
    /// Of G^-1 + V^T N^-1 V `[traces, traces]`.
    traces: DenseCholesky,
    /// What volumes take off.
    volumes: Volumes,
    /// s.
    scale: f64,
}

/// The volumes' part.
struct Volumes {
    /// W `[part, volumes]`.
    seen: DenseMatrix,
    /// H `[traces, volumes]`.
    on_traces: DenseMatrix,
    /// T^-1 H `[traces, volumes]`.
    moved: DenseMatrix,
    /// Of 1 - W^T M^-1 W `[volumes, volumes]`.
    factor: DenseCholesky,
}

impl SplitFactor {
    /// Of the part on `selected`, ascending; none where the part is better formed.
    pub(super) fn new(of: &Compliance, selected: &[usize]) -> Option<Self> {
        if selected.len() < LEAST {
            return None;
        }
        let touched = Touched::new(of, selected);
        let is_worth = touched.traces.len() as f64 <= SHARE * selected.len() as f64;
        is_worth
            .then(|| Self::of_part(of, selected, touched))
            .flatten()
    }

    /// The same, whatever it costs.
    pub(super) fn of_part(of: &Compliance, selected: &[usize], touched: Touched) -> Option<Self> {
        let stiffness = of.stiffness_at(&touched.traces)?;
        let nodes =
            SparseCholesky::by_least_degree(&nodes_on(of, selected), Precision::Double).ok()?;
        let mut on_traces = on_traces(&nodes, &touched);
        for column in 0..touched.traces.len() {
            add_scaled(on_traces.column_mut(column), 1.0, stiffness.column(column));
        }
        let traces = DenseCholesky::new(&on_traces).ok()?;
        let volumes = Volumes::new(of, selected, (&nodes, &touched, &traces))?;
        let factor = Self {
            nodes,
            rows: touched.rows,
            traces,
            volumes,
            scale: of.scale,
        };
        factor.is_right(of, selected).then_some(factor)
    }

    /// Whether it finds a known solution again.
    fn is_right(&self, of: &Compliance, selected: &[usize]) -> bool {
        let known = reproducible_noise(selected.len());
        let mut all = vec![0.0; of.size()];
        for (&row, value) in selected.iter().zip(&known) {
            all[row] = *value;
        }
        let mut product = vec![0.0; all.len()];
        of.product(&all, &mut product);
        let mut found: Vec<f64> = selected.iter().map(|&row| product[row]).collect();
        self.solve_part(&mut found, &mut Workspace::new());
        add_scaled(&mut found, -1.0, &known);
        norm(&found) <= MISS * norm(&known)
    }
}

impl PartFactor for SplitFactor {
    fn solve_part(&self, x: &mut [f64], work: &mut Workspace) {
        let volumes = &self.volumes;
        let mut alone = work.copy(x);
        self.nodes.solve(&mut alone, 1, work);
        let mut on_traces = work.zeros(self.traces.size());
        gather(&self.rows, &alone, &mut on_traces);
        self.traces.solve(&mut on_traces);
        let mut shares: Vec<f64> = (0..volumes.seen.columns())
            .map(|volume| {
                let seen = dot(volumes.seen.column(volume), &alone);
                seen - dot(volumes.on_traces.column(volume), &on_traces)
            })
            .collect();
        work.give(alone);
        volumes.factor.solve(&mut shares);
        for (volume, &share) in shares.iter().enumerate() {
            add_scaled(x, share, volumes.seen.column(volume));
            add_scaled(&mut on_traces, share, volumes.moved.column(volume));
        }
        for (value, row) in x.iter_mut().zip(&self.rows) {
            let taken = row.iter().map(|&(t, v)| v * on_traces[t as usize]);
            *value -= taken.sum::<f64>();
        }
        work.give(on_traces);
        self.nodes.solve(x, 1, work);
        scale(x, 1.0 / self.scale);
    }

    fn bytes(&self) -> u64 {
        let volumes = &self.volumes;
        let rows = self.rows.iter().map(|row| 16 * row.len() as u64 + 24);
        self.nodes.bytes()
            + rows.sum::<u64>()
            + self.traces.bytes()
            + volumes.seen.bytes()
            + volumes.on_traces.bytes()
            + volumes.moved.bytes()
            + volumes.factor.bytes()
    }
}

impl Volumes {
    /// What the volumes of `of` take off a part whose N has the factor `nodes` and whose T has
    /// `traces`; none where they leave it indefinite.
    fn new(
        of: &Compliance,
        selected: &[usize],
        (nodes, touched, traces): (&SparseCholesky, &Touched, &DenseCholesky),
    ) -> Option<Self> {
        let count = of.volumes.rows();
        let mut seen = DenseMatrix::zeros(selected.len(), count);
        for volume in 0..count {
            let entries = seen.column_mut(volume).iter_mut().zip(selected);
            entries.for_each(|(entry, &row)| *entry = of.volumes.at(volume, row));
        }
        let (on_traces, mut left) = solved(&seen, (nodes, touched), traces.size());
        let mut moved = on_traces.clone();
        traces.solve_all(&mut moved);
        let through_traces = on_traces.transposed_times(&moved);
        for volume in 0..count {
            let entries = left.column_mut(volume).iter_mut();
            entries
                .zip(through_traces.column(volume))
                .for_each(|(entry, through)| *entry = through - *entry);
            *left.at_mut(volume, volume) += 1.0;
        }
        Some(Self {
            factor: DenseCholesky::new(&left).ok()?,
            seen,
            on_traces,
            moved,
        })
    }
}

/// `V^T N^-1 W` `[traces, volumes]` and `W^T N^-1 W` `[volumes, volumes]`, W being `seen`.
fn solved(
    seen: &DenseMatrix,
    (nodes, touched): (&SparseCholesky, &Touched),
    size: usize,
) -> (DenseMatrix, DenseMatrix) {
    let count = seen.columns();
    let numbers: Vec<usize> = (0..count).collect();
    let panel = |work: &mut Workspace, panel: &[usize]| {
        let mut alone = DenseMatrix::zeros(seen.rows(), panel.len());
        let mut on_traces = DenseMatrix::zeros(size, panel.len());
        for (column, &volume) in panel.iter().enumerate() {
            let own = alone.column_mut(column);
            own.copy_from_slice(seen.column(volume));
        }
        nodes.solve(alone.entries_mut(), panel.len(), work);
        for column in 0..panel.len() {
            let place = on_traces.column_mut(column);
            gather(&touched.rows, alone.column(column), place);
        }
        (on_traces, seen.transposed_times(&alone))
    };
    let scratch = Scratch::new(&Workspace::new);
    let panels = parallel::map(numbers.len().div_ceil(PANEL), 1, &|k| {
        let numbers = &numbers[k * PANEL..numbers.len().min((k + 1) * PANEL)];
        scratch.lend(|work| panel(work, numbers))
    });
    let mut on_traces = DenseMatrix::zeros(size, count);
    let mut products = DenseMatrix::zeros(count, count);
    for (panel, (traces, seen)) in panels.iter().enumerate() {
        for column in 0..traces.columns() {
            let volume = panel * PANEL + column;
            let own = on_traces.column_mut(volume);
            own.copy_from_slice(traces.column(column));
            let own = products.column_mut(volume);
            own.copy_from_slice(seen.column(column));
        }
    }
    (on_traces, products)
}

/// N with its lift on the part, lower triangle.
fn nodes_on(of: &Compliance, selected: &[usize]) -> LowerColumns {
    let mut places = vec![u32::MAX; of.size()];
    for (place, &row) in (0..).zip(selected) {
        places[row] = place;
    }
    let mut lower = LowerColumns {
        offsets: vec![0],
        ..LowerColumns::default()
    };
    for (place, &column) in (0..).zip(selected) {
        let (rows, values) = of.nodes.row(column);
        let diagonal = match rows.binary_search(&(column as u32)) {
            Ok(at) => values[at],
            Err(_) => 0.0,
        };
        lower.rows.push(place);
        lower.values.push(diagonal + of.lift);
        for (&row, &value) in rows.iter().zip(values) {
            let row = places[row as usize];
            if row != u32::MAX && row > place {
                lower.rows.push(row);
                lower.values.push(value);
            }
        }
        lower.offsets.push(lower.rows.len() as u32);
    }
    lower
}

/// V^T N^-1 V `[traces, traces]`, some columns at a time.
fn on_traces(nodes: &SparseCholesky, touched: &Touched) -> DenseMatrix {
    let (part, traces) = (touched.rows.len(), touched.traces.len());
    let mut columns: Vec<Vec<(u32, f64)>> = vec![Vec::new(); traces];
    for (row, entries) in (0..).zip(&touched.rows) {
        for &(trace, value) in entries {
            columns[trace as usize].push((row, value));
        }
    }
    let panel = |work: &mut Workspace, columns: &[Vec<(u32, f64)>]| {
        let mut moved = work.zeros(part * columns.len());
        for (moved, column) in moved.chunks_exact_mut(part).zip(columns) {
            for &(row, value) in column {
                moved[row as usize] += value;
            }
        }
        nodes.solve(&mut moved, columns.len(), work);
        let mut out = vec![0.0; traces * columns.len()];
        let pairs = out.chunks_exact_mut(traces).zip(moved.chunks_exact(part));
        pairs.for_each(|(sums, moved)| gather(&touched.rows, moved, sums));
        work.give(moved);
        out
    };
    let scratch = Scratch::new(&Workspace::new);
    let panels = parallel::map(columns.len().div_ceil(PANEL), 1, &|k| {
        let columns = &columns[k * PANEL..columns.len().min((k + 1) * PANEL)];
        scratch.lend(|work| panel(work, columns))
    });
    let mut whole = DenseMatrix::zeros(traces, traces);
    for (column, values) in panels
        .iter()
        .flat_map(|p| p.chunks_exact(traces))
        .enumerate()
    {
        whole.column_mut(column).copy_from_slice(values);
    }
    whole
}

/// `sums += V^T x`.
fn gather(rows: &[Vec<(u32, f64)>], x: &[f64], sums: &mut [f64]) {
    for (row, value) in rows.iter().zip(x) {
        for &(trace, entry) in row {
            sums[trace as usize] += entry * value;
        }
    }
}
