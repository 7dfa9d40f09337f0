//! The factor of a body, stable and not, and its step against dense inverses.

use std::sync::atomic::{AtomicU32, Ordering};

use super::*;
use crate::inequality::QpStatus;
use crate::inequality::samples::Exact;
use crate::linalg::samples::{Scaled, rows};
use crate::linalg::vector::{dot, reproducible_noise};
use crate::linalg::{
    DenseLu, DenseMatrix, LinearOperator, SparseRows, SparseRowsBuilder, Workspace,
};
use crate::saddle::{BlockStep, EqualityBlock};

const SIZE: usize = 12;

/// Springs in a row to walls at both ends, less `geometric` on the diagonal of the middle.
fn springs(geometric: f64) -> Vec<Vec<f64>> {
    let entry = |i: usize, j: usize| match i.abs_diff(j) {
        0 if i == SIZE / 2 => 2.0 - geometric,
        0 => 2.0,
        1 => -1.0,
        _ => 0.0,
    };
    (0..SIZE)
        .map(|i| (0..SIZE).map(|j| entry(i, j)).collect())
        .collect()
}

/// The two ends move together.
fn coupling() -> Vec<Vec<f64>> {
    let mut row = vec![0.0; SIZE];
    (row[0], row[SIZE - 1]) = (1.0, -1.0);
    vec![row]
}

fn factor(stiffness: &[Vec<f64>], most: usize) -> Result<BodyFactor, QpStatus> {
    let none: SparseRows = SparseRowsBuilder::new(SIZE).finish();
    let matrices = Matrices {
        stiffness: rows(stiffness),
        coupling: Some(rows(&coupling())),
        stabilisation: None,
        contact: &none,
        places: (0..SIZE as u32).collect(),
        has_rigid_modes: false,
        most_flops: f64::INFINITY,
    };
    BodyFactor::stable(&matrices, most, &mut Workspace::new())
}

/// The saddle point of `stiffness`, with further `rows` below.
fn saddle(stiffness: &[Vec<f64>], further: &[Vec<f64>]) -> DenseMatrix {
    let all: Vec<Vec<f64>> = coupling().into_iter().chain(further.to_vec()).collect();
    let mut matrix = DenseMatrix::zeros(SIZE + all.len(), SIZE + all.len());
    for (i, row) in stiffness.iter().enumerate() {
        for (j, value) in row.iter().enumerate() {
            *matrix.at_mut(i, j) = *value;
        }
    }
    for (i, row) in all.iter().enumerate() {
        for (j, value) in row.iter().enumerate() {
            *matrix.at_mut(SIZE + i, j) = *value;
            *matrix.at_mut(j, SIZE + i) = *value;
        }
    }
    matrix
}

#[test]
fn a_stable_body_is_solved_as_it_is() {
    let body = factor(&springs(0.0), 0).unwrap();
    assert!(body.is_exact());
    let load = reproducible_noise(SIZE + 1);
    let (mut solution, mut expected) = (load.clone(), load);
    body.solve(&mut solution, &mut Workspace::new());
    DenseLu::new(&saddle(&springs(0.0), &[]))
        .unwrap()
        .solve(&mut expected);
    for (own, other) in solution.iter().zip(&expected) {
        assert!((own - other).abs() < 1e-7, "{own} {other}");
    }
}

#[test]
fn a_motion_that_lowers_the_energy_raises_it_on_the_factor_and_others_do_as_before() {
    let stiffness = springs(3.0);
    assert_eq!(
        factor(&stiffness, 0).unwrap_err(),
        QpStatus::IndefiniteMetric
    );
    let body = factor(&stiffness, 1).unwrap();
    assert!(!body.is_exact());
    let mut work = Workspace::new();
    let exact = DenseLu::new(&saddle(&stiffness, &[])).unwrap();
    let mut lowered = 0;
    for k in 0..SIZE {
        let mut load = vec![0.0; SIZE + 1];
        let noise = reproducible_noise(SIZE * (k + 1));
        load[..SIZE].copy_from_slice(&noise[SIZE * k..]);
        let (mut turned, mut own) = (load.clone(), load.clone());
        body.solve(&mut turned, &mut work);
        exact.solve(&mut own);
        // What the load does is work on a stable body.
        assert!(dot(&load, &turned) > 0.0);
        lowered += usize::from(dot(&load, &own) < 0.0);
        // It keeps to the constraint, too.
        assert!((turned[0] - turned[SIZE - 1]).abs() < 1e-6);
    }
    assert!(lowered > 0, "the body has a motion that lowers its energy");
    // Both differ by one column, the same for all loads.
    let difference = |load: &[f64]| {
        let (mut turned, mut own) = (load.to_vec(), load.to_vec());
        body.solve(&mut turned, &mut Workspace::new());
        exact.solve(&mut own);
        let pairs = turned.iter().zip(&own);
        pairs.map(|(a, b)| a - b).collect::<Vec<f64>>()
    };
    let noise = reproducible_noise(2 * (SIZE + 1));
    let [a, b] = [&noise[..=SIZE], &noise[SIZE + 1..]].map(difference);
    let cosine = dot(&a, &b).abs() / (dot(&a, &a) * dot(&b, &b)).sqrt();
    assert!((cosine - 1.0).abs() < 1e-6, "{cosine}");
}

#[test]
fn the_step_is_the_inverse_where_the_compliance_is() {
    let stiffness = springs(0.0);
    let body = factor(&stiffness, 0).unwrap();
    let mut contact = vec![vec![0.0; SIZE]];
    (contact[0][4], contact[0][5]) = (1.0, 0.5);
    let mut load = contact[0].clone();
    load.push(0.0);
    let mut work = Workspace::new();
    body.solve(&mut load, &mut work);
    let compliance = dot(&contact[0], &load[..SIZE]);
    let metric = Exact::new(&[vec![compliance]]);
    let (pressure, gaps) = (rows(&coupling()), rows(&contact));
    let block = |rows, metric| EqualityBlock {
        rows,
        columns: rows,
        stabilisation: None,
        metric,
        shared: None,
        joint: None,
    };
    let unused = Scaled(1.0);
    let blocks = [
        block(&pressure as &dyn LinearOperator, &unused as _),
        block(&gaps as &dyn LinearOperator, &metric as _),
    ];
    let solutions = AtomicU32::new(0);
    let step = FactorStep {
        body: &body,
        solutions: &solutions,
    };
    let operator = rows(&stiffness);
    let inverse = step.preconditioner(&operator, &unused, &blocks);
    let mut expected = reproducible_noise(SIZE + 2);
    let (r, mut z) = (expected.clone(), vec![0.0; SIZE + 2]);
    inverse.apply(&r, &mut z, &mut work);
    DenseLu::new(&saddle(&stiffness, &contact))
        .unwrap()
        .solve(&mut expected);
    for (own, other) in z.iter().zip(&expected) {
        assert!((own - other).abs() < 1e-6, "{own} {other}");
    }
    assert_eq!(solutions.load(Ordering::Relaxed), 2);
}
