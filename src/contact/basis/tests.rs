//! What every basis of the contact pressure promises.

use super::*;
use crate::element::quadrature::{Simplex, rule};

const BASES: [&dyn ContactBasis; 2] = [&Hats, &Bernstein];

/// A flat triangle, a segment and a segment turned about the axis.
fn faces() -> [ContactFace; 3] {
    let face = |corners: u32, radii: Option<[f64; 2]>| ContactFace {
        corners: (0..corners).collect(),
        functions: Vec::new(),
        nodes: Vec::new(),
        area: radii.map_or(0.7, |[a, b]| std::f64::consts::PI * 0.7 * (a + b)),
        radii,
        flat_area: 0.7,
        point: [0.0; 3],
        normal: [0.0, 0.0, 1.0],
        curve: None,
    };
    [face(3, None), face(2, None), face(2, Some([0.2, 0.9]))]
}

fn values(basis: &dyn ContactBasis, l: &[f64]) -> Vec<f64> {
    let mut out = vec![f64::NAN; basis.functions(l.len())];
    basis.values(l, &mut out);
    out
}

/// int f dS over `face` by a rule; `f` takes the functions at a point.
fn integral(basis: &dyn ContactBasis, face: &ContactFace, f: impl Fn(&[f64]) -> f64) -> f64 {
    let corners = face.corners.len();
    let simplex = match corners {
        2 => Simplex::Segment,
        _ => Simplex::Triangle,
    };
    let rule = rule(simplex, 8);
    let points = rule.points.iter().zip(&rule.weights);
    points
        .map(|(l, weight)| {
            let l = &l[..corners];
            weight * face.area_at(l) * f(&values(basis, l))
        })
        .sum()
}

#[test]
fn functions_are_positive_and_sum_to_one() {
    for basis in BASES {
        for corners in [2, 3] {
            for (a, b) in (0..=10).flat_map(|a| (0..=10 - a).map(move |b| (a, b))) {
                let (a, b) = (f64::from(a) / 10.0, f64::from(b) / 10.0);
                let l = match corners {
                    2 => vec![1.0 - a, a],
                    _ => vec![1.0 - a - b, a, b],
                };
                let found = values(basis, &l);
                assert!(found.iter().all(|&value| value >= -1e-16), "{found:?}");
                assert!((found.iter().sum::<f64>() - 1.0).abs() < 1e-14);
            }
        }
    }
}

#[test]
fn a_function_of_a_vertex_is_one_there_and_others_vanish() {
    for basis in BASES {
        let found = values(basis, &[0.0, 1.0, 0.0]);
        for (k, value) in found.iter().enumerate() {
            let expected = if k == 1 { 1.0 } else { 0.0 };
            assert!((value - expected).abs() < 1e-15, "{basis:?} {k}");
        }
    }
}

#[test]
fn hats_are_a_cone_within_the_quadratic_functions() {
    let (l, corner) = ([0.5, 0.3, 0.2], [1.0, 4.0, 2.0]);
    let edges = [(0, 1), (0, 2), (1, 2)].map(|(a, b)| 0.5 * (corner[a] + corner[b]));
    let coefficients = corner.iter().chain(&edges);
    let functions = values(&Bernstein, &l);
    let quadratic: f64 = coefficients.zip(&functions).map(|(c, psi)| c * psi).sum();
    let linear: f64 = corner.iter().zip(&l).map(|(c, l)| c * l).sum();
    assert!((quadratic - linear).abs() < 1e-15);
}

#[test]
fn weights_and_masses_are_the_integrals_of_the_functions() {
    for basis in BASES {
        for face in &faces() {
            for i in 0..basis.functions(face.corners.len()) {
                let weight = integral(basis, face, |psi| psi[i]);
                assert!(
                    (basis.weight(face, i) - weight).abs() < 1e-15,
                    "{basis:?} {i}"
                );
                for j in 0..basis.functions(face.corners.len()) {
                    // At the mean radius, where the face is turned.
                    let flat = ContactFace {
                        radii: None,
                        ..face.clone()
                    };
                    let mass = integral(basis, &flat, |psi| psi[i] * psi[j]);
                    assert!((basis.mass(face, i, j) - mass).abs() < 1e-15);
                }
            }
        }
    }
}

#[test]
fn the_weights_of_a_flat_face_are_equal() {
    for basis in BASES {
        for face in &faces()[..2] {
            let count = basis.functions(face.corners.len());
            for k in 0..count {
                assert!((basis.weight(face, k) - face.area / count as f64).abs() < 1e-15);
            }
        }
    }
}

/// Slopes of the barycentric coordinates of the triangle (0,0), (2,0), (0.5,1).
const SLOPES: [[f64; 2]; 3] = [[-0.5, -0.75], [0.5, -0.25], [0.0, 1.0]];

#[test]
fn laplacians_are_the_integrals_of_the_slopes() {
    let (rule, area, step) = (rule(Simplex::Triangle, 6), 1.0, 1e-6);
    let product = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
    let hats = |a: usize, b: usize| area * product(SLOPES[a], SLOPES[b]);
    for basis in BASES {
        let count = basis.functions(3);
        let mut expected = vec![0.0; count * count];
        for (l, weight) in rule.points.iter().zip(&rule.weights) {
            let moved = |axis: usize, by: f64| {
                let l: Vec<f64> = (0..3).map(|c| l[c] + by * SLOPES[c][axis]).collect();
                values(basis, &l)
            };
            let ends = [0, 1].map(|axis| (moved(axis, step), moved(axis, -step)));
            let slope = |k: usize| {
                [0, 1].map(|axis: usize| (ends[axis].0[k] - ends[axis].1[k]) / (2.0 * step))
            };
            for (k, sum) in expected.iter_mut().enumerate() {
                *sum += weight * area * product(slope(k / count), slope(k % count));
            }
        }
        for (k, sum) in expected.iter().enumerate() {
            let found = basis.laplacian(3, &hats, [k / count, k % count]);
            assert!((found - sum).abs() < 1e-9, "{basis:?} {k}: {found} {sum}");
        }
    }
}

proptest::proptest! {
    #[test]
    fn the_largest_value_is_that_of_fine_sampling(
        coefficients in proptest::array::uniform6(0.0..1.0_f64),
        corners in 2..=3_usize,
    ) {
        for basis in BASES {
            let own = &coefficients[..basis.functions(corners)];
            let at = |l: &[f64]| -> f64 {
                values(basis, l).iter().zip(own).map(|(psi, c)| psi * c).sum()
            };
            let (found, place) = basis.largest(corners, own);
            let lattice = (0..=60).flat_map(|a| (0..=60 - a).map(move |b| [a, b]));
            let points = lattice.map(|ab| ab.map(|x| f64::from(x) / 60.0));
            let sampled = points.filter(|[a, b]| corners == 3 || (a + b - 1.0).abs() < 1e-9);
            let sampled = sampled.map(|[a, b]| at(&[a, b, 1.0 - a - b][..corners]));
            let sampled = sampled.fold(0.0, f64::max);
            proptest::prop_assert!(found >= sampled - 1e-12 && found < sampled + 1e-3);
            proptest::prop_assert!((at(&place[..corners]) - found).abs() < 1e-12);
            proptest::prop_assert!((place.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        }
    }
}
