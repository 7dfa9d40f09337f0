//! Small systems whose directions are known.

use super::*;
use crate::krylov::samples::Below;
use crate::linalg::SparseRows;
use crate::linalg::samples::{Scaled, rows};

const PLAIN: Scaled = Scaled(1.0);

/// Indefinite.
fn saddle() -> SparseRows {
    rows(&[[2.0, 0.0, 1.0], [0.0, 3.0, 1.0], [1.0, 1.0, 0.0]])
}

#[test]
fn an_indefinite_system_of_three_takes_three_directions() {
    let mut work = Workspace::new();
    let (mut x, mut r) = (vec![0.0; 3], vec![1.0, 2.0, 3.0]);
    let outcome = Gcr {
        operator: &saddle(),
        preconditioner: &PLAIN,
        directions: &mut Directions::default(),
        iterations: 4,
    }
    .solve((&mut x, &mut r), &mut Below::new(1e-12), &mut work);
    assert_eq!(outcome, Outcome::Stopped);
    let mut product = vec![0.0; 3];
    saddle().apply(&x, &mut product, &mut work);
    for (value, exact) in product.iter().zip([1.0, 2.0, 3.0]) {
        assert!((value - exact).abs() < 1e-12);
    }
}

#[test]
fn a_direction_that_changes_nothing_ends_as_stagnation() {
    struct Orthogonal;
    impl Preconditioner for Orthogonal {
        fn apply(&self, _r: &[f64], z: &mut [f64], _work: &mut Workspace) {
            // Its image (1, -3/2 + ..) is orthogonal to the residual below.
            z.copy_from_slice(&[0.0, 0.0, 1.0]);
        }
    }
    let (mut x, mut r) = (vec![0.0; 3], vec![0.0, 0.0, 1.0]);
    let outcome = Gcr {
        operator: &saddle(),
        preconditioner: &Orthogonal,
        directions: &mut Directions::default(),
        iterations: 50,
    }
    .solve(
        (&mut x, &mut r),
        &mut Below::new(1e-12),
        &mut Workspace::new(),
    );
    assert_eq!(outcome, Outcome::Stagnation);
}

#[test]
fn a_turned_plane_is_solved_from_the_last_product() {
    // Every residual is orthogonal to its own image: no step from it helps.
    let quarter = rows(&[
        [0.0, -1.0, 0.0, 0.0],
        [1.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, -2.0],
        [0.0, 0.0, 2.0, 0.0],
    ]);
    let (mut x, mut r) = (vec![0.0; 4], vec![1.0, 2.0, 3.0, -1.0]);
    let outcome = Gcr {
        operator: &quarter,
        preconditioner: &PLAIN,
        directions: &mut Directions::default(),
        iterations: 8,
    }
    .solve(
        (&mut x, &mut r),
        &mut Below::new(1e-12),
        &mut Workspace::new(),
    );
    assert_eq!(outcome, Outcome::Stopped);
    for (value, exact) in x.iter().zip([2.0, -1.0, -0.5, -1.5]) {
        assert!((value - exact).abs() < 1e-12);
    }
}

#[test]
fn kept_directions_solve_the_same_system_again_at_once() {
    let mut directions = Directions::default();
    let mut work = Workspace::new();
    let mut solve_for = |rhs: [f64; 3], most: usize, directions: &mut Directions| {
        let (mut x, mut r) = (vec![0.0; 3], rhs.to_vec());
        let stop = &mut Below::new(1e-12);
        Gcr {
            operator: &saddle(),
            preconditioner: &PLAIN,
            directions,
            iterations: most,
        }
        .solve((&mut x, &mut r), stop, &mut work);
        norm(&r)
    };
    assert!(solve_for([1.0, 2.0, 3.0], 4, &mut directions) < 1e-12);
    assert!(solve_for([-2.0, 0.5, 1.0], 0, &mut directions) < 1e-12);
}

/// Entries between 0.001 and one.
struct Graded;

impl LinearOperator for Graded {
    fn rows(&self) -> usize {
        300
    }

    fn columns(&self) -> usize {
        300
    }

    fn apply(&self, x: &[f64], y: &mut [f64], _work: &mut Workspace) {
        for (k, (y, x)) in y.iter_mut().zip(x).enumerate() {
            *y = (1.0 + k as f64) / 300.0 * x * 0.3_f64.powi((k % 3) as i32);
        }
    }

    fn apply_transposed(&self, y: &[f64], x: &mut [f64], work: &mut Workspace) {
        self.apply(y, x, work);
    }
}

#[test]
fn directions_of_an_earlier_load_cost_the_next_one_nothing() {
    let mut work = Workspace::new();
    let mut solve_for = |rhs: Vec<f64>, directions: &mut Directions| {
        let (mut x, mut r) = (vec![0.0; rhs.len()], rhs);
        let mut stop = Below::new(1e-9);
        Gcr {
            operator: &Graded,
            preconditioner: &PLAIN,
            directions,
            iterations: 2000,
        }
        .solve((&mut x, &mut r), &mut stop, &mut work);
        stop.iterations
    };
    let noise = crate::linalg::vector::reproducible_noise(300);
    let fresh = solve_for(noise.clone(), &mut Directions::default());
    let mut kept = Directions::default();
    solve_for(vec![1.0; 300], &mut kept);
    let warm = solve_for(noise, &mut kept);
    assert!(warm <= fresh, "{warm} against {fresh}");
}

#[test]
fn adapted_directions_belong_to_the_new_operator() {
    let mut directions = Directions::default();
    let mut work = Workspace::new();
    let (mut x, mut r) = (vec![0.0; 3], vec![1.0, 2.0, 3.0]);
    let stop = &mut Below::new(1e-12);
    Gcr {
        operator: &saddle(),
        preconditioner: &PLAIN,
        directions: &mut directions,
        iterations: 4,
    }
    .solve((&mut x, &mut r), stop, &mut work);
    let kept = directions.pairs.len();
    assert_eq!(kept, 3);
    // The new operator is the old one plus e_1 e_3^T.
    directions.adapt(&mut work, |direction, product| product[0] += direction[2]);
    assert_eq!(directions.pairs.len(), kept);
    for (index, (direction, product)) in directions.pairs.iter().enumerate() {
        let mut image = vec![0.0; 3];
        saddle().apply(direction, &mut image, &mut work);
        image[0] += direction[2];
        for (a, b) in image.iter().zip(product) {
            assert!((a - b).abs() < 1e-12);
        }
        for (other, (_, its_product)) in directions.pairs.iter().enumerate() {
            let expected = f64::from(u8::from(index == other));
            assert!((dot(product, its_product) - expected).abs() < 1e-12);
        }
    }
}

#[test]
fn directions_that_become_dependent_are_dropped() {
    let mut directions = Directions::default();
    let mut work = Workspace::new();
    let unit = |i: usize| {
        (0..3)
            .map(|j| f64::from(u8::from(i == j)))
            .collect::<Vec<_>>()
    };
    (0..3).for_each(|i| directions.push(unit(i), unit(i), &mut work));
    directions.adapt(&mut work, |_, product| {
        product[0] += product[2];
        product[2] = 0.0;
    });
    assert_eq!(directions.pairs.len(), 2);
}

#[test]
fn no_more_than_ten_directions_are_kept() {
    let mut directions = Directions::default();
    let mut work = Workspace::new();
    (0..15).for_each(|_| directions.push(vec![0.0; 4], vec![0.0; 4], &mut work));
    assert_eq!(directions.pairs.len(), KEPT);
    assert_eq!(directions.bytes(), 16 * 4 * KEPT as u64);
    directions.clear(&mut work);
    assert_eq!(directions.bytes(), 0);
}

#[test]
fn a_few_directions_become_ten_where_a_solve_takes_long() {
    let mut directions = Directions::starting_with(5);
    let mut work = Workspace::new();
    for iteration in 0..2 * USUAL {
        directions.grow(iteration);
        directions.push(vec![0.0; 4], vec![0.0; 4], &mut work);
        assert!(iteration >= USUAL || directions.pairs.len() <= 5);
    }
    assert_eq!(directions.pairs.len(), KEPT);
}
