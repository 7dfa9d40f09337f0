//! Five-point Laplacians.

use super::*;

/// Five-point Laplacian on an n by n grid.
fn laplacian(n: usize) -> LowerColumns {
    let mut matrix = LowerColumns {
        offsets: vec![0],
        ..LowerColumns::default()
    };
    for column in 0..n * n {
        let mut push = |row: usize, value: f64| {
            matrix.rows.push(row as u32);
            matrix.values.push(value);
        };
        push(column, 4.0);
        if column % n + 1 < n {
            push(column + 1, -1.0);
        }
        if column + n < n * n {
            push(column + n, -1.0);
        }
        matrix.offsets.push(matrix.rows.len() as u32);
    }
    matrix
}

fn product(matrix: &LowerColumns, x: &[f64]) -> Vec<f64> {
    let mut y = vec![0.0; x.len()];
    for column in 0..matrix.size() {
        for k in matrix.offsets[column] as usize..matrix.offsets[column + 1] as usize {
            let row = matrix.rows[k] as usize;
            y[row] += matrix.values[k] * x[column];
            if row != column {
                y[column] += matrix.values[k] * x[row];
            }
        }
    }
    y
}

#[test]
fn a_factor_solves_several_right_hand_sides() {
    let matrix = laplacian(9);
    let order: Vec<u32> = (0..81).rev().collect();
    let factor =
        SparseCholesky::new(&matrix, &order, Precision::Double).expect("positive definite");
    let x = super::super::vector::reproducible_noise(162);
    let mut b = product(&matrix, &x[..81]);
    b.extend(product(&matrix, &x[81..]));
    factor.solve(&mut b, 2, &mut Workspace::new());
    for (value, exact) in b.iter().zip(&x) {
        assert!((value - exact).abs() < 1e-12);
    }
}

#[test]
fn a_factor_in_single_precision_solves_to_its_rounding() {
    let matrix = laplacian(9);
    let order: Vec<u32> = (0..81).rev().collect();
    let factor =
        SparseCholesky::new(&matrix, &order, Precision::Single).expect("positive definite");
    let x = super::super::vector::reproducible_noise(81);
    let mut b = product(&matrix, &x);
    factor.solve(&mut b, 1, &mut Workspace::new());
    for (value, exact) in b.iter().zip(&x) {
        assert!((value - exact).abs() < 1e-5);
    }
    let double = SparseCholesky::new(&matrix, &order, Precision::Double).expect("as above");
    let trees = 2 * factor.tree.as_ref().map_or(0, Tree::bytes);
    let trees_of_double = double.tree.as_ref().map_or(0, Tree::bytes);
    assert_eq!(2 * factor.bytes() - trees, double.bytes() - trees_of_double);
}

#[test]
fn the_trailing_block_gives_the_inverse_on_the_last_unknowns() {
    let matrix = laplacian(7);
    let last = [3_u32, 4, 24, 40];
    let order: Vec<u32> = (0..49).filter(|i| !last.contains(i)).chain(last).collect();
    let factor =
        SparseCholesky::new(&matrix, &order, Precision::Double).expect("positive definite");
    let inverse = factor.trailing_block(4).inverse_of_product();
    for (j, &column) in last.iter().enumerate() {
        let mut unit = vec![0.0; 49];
        unit[column as usize] = 1.0;
        factor.solve(&mut unit, 1, &mut Workspace::new());
        for (i, &row) in last.iter().enumerate() {
            assert!((inverse.at(i, j) - unit[row as usize]).abs() < 1e-13);
        }
    }
}

#[test]
fn an_indefinite_matrix_is_refused() {
    let mut matrix = laplacian(3);
    matrix.values[0] = -4.0;
    let order: Vec<u32> = (0..9).collect();
    assert!(matches!(
        SparseCholesky::new(&matrix, &order, Precision::Double),
        Err(FactoriseError::NotPositiveDefinite)
    ));
}

/// Two grids that know nothing of each other.
fn two_grids(n: usize) -> LowerColumns {
    let one = laplacian(n);
    let size = one.size();
    let mut both = LowerColumns {
        offsets: vec![0],
        ..LowerColumns::default()
    };
    for column in 0..2 * size {
        let (part, own) = (column / size, column % size);
        for k in one.offsets[own] as usize..one.offsets[own + 1] as usize {
            both.rows.push(one.rows[k] + (part * size) as u32);
            both.values.push(one.values[k]);
        }
        both.offsets.push(both.rows.len() as u32);
    }
    both
}

/// What `entries` say below a diagonal of fours.
fn with_entries(size: usize, entries: impl Fn(usize, usize) -> bool) -> LowerColumns {
    let mut matrix = LowerColumns {
        offsets: vec![0],
        ..LowerColumns::default()
    };
    for column in 0..size {
        for row in (column..size).filter(|&row| row == column || entries(row, column)) {
            matrix.rows.push(row as u32);
            matrix.values.push(if row == column { 4.0 } else { -0.01 });
        }
        matrix.offsets.push(matrix.rows.len() as u32);
    }
    matrix
}

#[test]
fn one_right_hand_side_along_the_branches_is_solved_as_among_several() {
    let (nothing, diagonal) = (with_entries(0, |_, _| true), with_entries(50, |_, _| false));
    let (chain, arrow) = (
        with_entries(400, |row, column| row == column + 1),
        with_entries(90, |row, _| row == 89),
    );
    let special = [nothing, diagonal, chain, arrow];
    let grids = [laplacian(1), laplacian(2), laplacian(30), two_grids(17)];
    for matrix in special.into_iter().chain(grids) {
        let size = matrix.size();
        let natural: Vec<u32> = (0..size as u32).collect();
        let factors = [
            SparseCholesky::by_least_degree(&matrix, Precision::Double),
            SparseCholesky::new(&matrix, &natural, Precision::Double),
        ];
        for factor in factors {
            let factor = factor.expect("positive definite");
            let b = super::super::vector::reproducible_noise(size);
            let (mut one, mut two) = (b.clone(), [&b[..], &b[..]].concat());
            factor.solve(&mut one, 1, &mut Workspace::new());
            factor.solve(&mut two, 2, &mut Workspace::new());
            for (one, two) in one.iter().zip(&two) {
                assert!((one - two).abs() < 1e-13, "{one} {two}");
            }
        }
    }
}

#[test]
fn branches_on_any_threads_give_the_same_bits() {
    let matrix = two_grids(120);
    for precision in [Precision::Single, Precision::Double] {
        let factor = SparseCholesky::by_least_degree(&matrix, precision).expect("definite");
        assert!(factor.tree.as_ref().is_some_and(|tree| tree.splits() > 5));
        let b = super::super::vector::reproducible_noise(matrix.size());
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let pool = pool.build().expect("a pool of a few threads");
            let mut x = b.clone();
            pool.install(|| factor.solve(&mut x, 1, &mut Workspace::new()));
            x
        };
        let x = with(1);
        assert!(
            x.iter()
                .zip(with(3))
                .all(|(a, b)| a.to_bits() == b.to_bits())
        );
        let product = product(&matrix, &x);
        let tolerance = if precision == Precision::Single {
            1e-4
        } else {
            1e-11
        };
        assert!(
            product
                .iter()
                .zip(&b)
                .all(|(a, b)| (a - b).abs() < tolerance)
        );
    }
}
