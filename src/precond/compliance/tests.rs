use super::*;
use crate::linalg::SparseRowsBuilder;
use crate::linalg::vector::reproducible_noise;

/// Rows of the sample.
const ROWS: usize = 60;
/// Traces of the sample.
const TRACES: usize = 20;

/// A metric with a chain of nodes that move alone, every third of which is at a trace.
fn sample(volumes: usize) -> Compliance {
    let mut vertex_inverse = DenseMatrix::zeros(TRACES, TRACES);
    for (i, j) in (0..TRACES).flat_map(|i| (0..TRACES).map(move |j| (i, j))) {
        *vertex_inverse.at_mut(i, j) = 1.0 / (1.0 + i.abs_diff(j) as f64);
    }
    let mut nodes = SparseRowsBuilder::new(ROWS);
    for row in 0..ROWS {
        let mut entries = vec![(row as u32, 0.5 + 0.01 * row as f64)];
        for other in [row.wrapping_sub(1), row + 1] {
            if other < ROWS {
                entries.push((other as u32, 0.2));
            }
        }
        nodes.push_row(&mut entries);
    }
    let row = |row: usize| {
        let first = (row * TRACES / ROWS) as u32;
        let second = (first + 1).min(TRACES as u32 - 1);
        vec![(first, 0.7), (second, 0.3)]
    };
    let volume = |volume: usize| -> Vec<f64> {
        let mut seen = reproducible_noise(ROWS * (volume + 1))[ROWS * volume..].to_vec();
        scale(&mut seen, 0.05);
        seen
    };
    let mut orthonormal = DenseMatrix::zeros(volumes, ROWS);
    for (k, values) in (0..volumes).map(volume).enumerate() {
        for (row, value) in values.into_iter().enumerate() {
            *orthonormal.at_mut(k, row) = value;
        }
    }
    Compliance {
        vertex_inverse: Arc::new(vertex_inverse),
        vertex_rows: (0..ROWS).map(row).collect(),
        nodes: nodes.finish(),
        volumes: orthonormal,
        seen: SparseRowsBuilder::new(ROWS).finish(),
        lift: 1e-10,
        scale: OF_MIXED,
        diagonal: OnceLock::new(),
        last: Mutex::default(),
        stiffness: Mutex::new(None),
        known: Mutex::default(),
    }
}

/// Solutions of a part by its parts and by its dense factor.
fn both(metric: &Compliance, selected: &[usize]) -> [Vec<f64>; 2] {
    let touched = part::Touched::new(metric, selected);
    let split = SplitFactor::of_part(metric, selected, touched).expect("regular");
    let dense = DenseCholesky::new(&metric.principal_part(selected)).expect("regular");
    let right = reproducible_noise(selected.len());
    let (mut a, mut b) = (right.clone(), right);
    split.solve_part(&mut a, &mut Workspace::new());
    dense.solve(&mut b);
    [a, b]
}

#[test]
fn a_factor_by_parts_solves_as_the_dense_one() {
    let every_second: Vec<usize> = (3..ROWS).step_by(2).collect();
    let all: Vec<usize> = (0..ROWS).collect();
    for volumes in [0, 1, 3] {
        let metric = sample(volumes);
        for selected in [&all[..], &every_second, &all[20..45], &all[59..]] {
            let [split, dense] = both(&metric, selected);
            let largest = dense.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
            for (split, dense) in split.iter().zip(&dense) {
                assert!((split - dense).abs() < 1e-11 * largest, "{split} {dense}");
            }
        }
    }
}

#[test]
fn nodes_that_leave_a_row_without_stiffness_are_left_to_the_dense_factor() {
    let mut metric = sample(0);
    let mut nodes = SparseRowsBuilder::new(ROWS);
    for row in 0..ROWS {
        let value = if row < 2 { 0.0 } else { 1.0 };
        nodes.push_row(&mut [(row as u32, value)]);
    }
    metric.nodes = nodes.finish();
    metric.lift = 1e-16;
    let selected: Vec<usize> = (0..ROWS).collect();
    let touched = part::Touched::new(&metric, &selected);
    assert!(SplitFactor::of_part(&metric, &selected, touched).is_none());
}

#[test]
fn a_part_that_comes_back_is_not_factorised_again() {
    let metric = sample(0);
    let parts: Vec<Vec<usize>> = (0..MOST_PARTS + 1).map(|k| (k..ROWS).collect()).collect();
    let factor = |part: &[usize]| metric.factor_of_part(part).expect("regular");
    let first = factor(&parts[0]);
    let mut others = Vec::new();
    for part in &parts[1..MOST_PARTS] {
        others.push(factor(part));
        assert!(Arc::ptr_eq(&first, &factor(&parts[0])));
    }
    assert!(Arc::ptr_eq(&others[0], &factor(&parts[1])));
    // One more than are kept: the one that was asked for longest ago goes.
    factor(&parts[MOST_PARTS]);
    assert!(Arc::ptr_eq(&others[0], &factor(&parts[1])));
    assert!(!Arc::ptr_eq(&others[1], &factor(&parts[2])));
    assert!(metric.last.lock().expect("not poisoned").len() <= MOST_PARTS);
}
