//! Gaps of two surfaces against areas of closed curves, differences and balances of forces.

use super::super::piece::{point, slope};
use super::*;
use crate::element::quadrature::{Simplex, rule};

/// Area that a closed chain encloses, and its derivative by the places of the nodes, by Green.
fn area(chain: &Chain, places: &[[f64; 2]]) -> f64 {
    let rule = [
        [0.5 - 0.6_f64.sqrt() / 2.0, 5.0],
        [0.5, 8.0],
        [0.5 + 0.6_f64.sqrt() / 2.0, 5.0],
    ];
    let faces = chain.faces.iter().map(|face| {
        let nodes = face.nodes.map(|node| places[node as usize]);
        let points = rule.iter().map(|[s, weight]| {
            let (x, t) = (point(nodes, *s), slope(nodes, *s));
            weight / 18.0 * 0.5 * (x[0] * t[1] - x[1] * t[0])
        });
        points.sum::<f64>()
    });
    faces.sum()
}

pub(super) fn volume(bodies: &Bodies) -> f64 {
    -area(&bodies.pair.other, &bodies.places) - area(&bodies.pair.carrier, &bodies.places)
}

/// Volume of the full turn that a closed chain encloses, int pi x^2 dy.
fn turned_volume(chain: &Chain, places: &[[f64; 2]]) -> f64 {
    let rule = rule(Simplex::Segment, 9);
    let faces = chain.faces.iter().map(|face| {
        let nodes = face.nodes.map(|node| places[node as usize]);
        let values = rule.points.iter().zip(&rule.weights).map(|(l, weight)| {
            let (x, t) = (point(nodes, l[1]), slope(nodes, l[1]));
            weight * 0.5 * TAU * x[0] * x[0] * t[1]
        });
        values.sum::<f64>()
    });
    faces.sum()
}

#[test]
fn gaps_of_revolution_add_up_to_the_volume_between_the_surfaces() {
    for (core, ring) in [(60, 41), (41, 60)] {
        let bodies = turned(rings(core, ring));
        let sum: f64 = bodies.gaps().iter().flatten().sum();
        let of = |chain: &Chain| turned_volume(chain, &bodies.places);
        let exact = -of(&bodies.pair.other) - of(&bodies.pair.carrier);
        let error = sum / exact - 1.0;
        assert!(exact > 0.5 && error.abs() < 1e-12, "{exact} {error:e}");
    }
}

#[test]
fn gaps_add_up_to_the_area_between_the_surfaces() {
    for (core, ring) in [(60, 41), (41, 60), (48, 48)] {
        let bodies = rings(core, ring);
        let sum: f64 = bodies.gaps().iter().flatten().sum();
        let exact = volume(&bodies);
        assert!(
            exact > 0.1 && (sum - exact).abs() < 1e-13,
            "{core} {ring} {:e}",
            sum - exact
        );
    }
}

#[test]
fn the_force_of_an_even_pressure_is_the_change_of_the_area_between_the_surfaces() {
    let bodies = rings(60, 41);
    let forces = bodies.all_forces();
    for node in (0..bodies.places.len()).step_by(7) {
        for i in 0..2 {
            // The area is quadratic in the places: central differences are exact.
            let at = |by: f64| volume(&bodies.moved(node, i, by));
            let exact = (at(0.25) - at(-0.25)) / 0.5;
            assert!((forces[node][i] - exact).abs() < 1e-12, "{node} {i}");
        }
    }
}

#[test]
fn forces_of_every_gap_add_up_to_nothing_and_have_no_moment() {
    for bodies in [
        rings(30, 23),
        lines([5, 7], 0.05, 0.02),
        lines([7, 3], -0.02, 0.01),
    ] {
        let vertices = vertices(&bodies);
        for face in 0..bodies.pair.carrier.faces.len() {
            for j in 0..3 {
                let forces = bodies.forces(face, j);
                let size = forces.iter().flatten().map(|f| f.abs()).sum::<f64>();
                let along = |i: usize| vertices.iter().map(|&v| forces[v][i]).sum::<f64>();
                let moment = bodies.places.iter().zip(&forces);
                let moment: f64 = moment.map(|(x, f)| x[0] * f[1] - x[1] * f[0]).sum();
                for sum in [along(0), along(1), moment] {
                    assert!(sum.abs() <= 1e-13 * size.max(1e-3), "{face} {j} {sum:e}");
                }
            }
        }
    }
}

#[test]
fn first_derivatives_are_those_of_differences() {
    let h = 1e-6;
    for bodies in five() {
        for (node, i) in [
            (1, 0),
            (2, 1),
            (9, 0),
            (13, 1),
            (bodies.places.len() - 2, 1),
        ] {
            let (before, after) = (
                bodies.moved(node, i, -h).gaps(),
                bodies.moved(node, i, h).gaps(),
            );
            for (face, (before, after)) in before.iter().zip(&after).enumerate() {
                for j in 0..3 {
                    let slope = (after[j] - before[j]) / (2.0 * h);
                    let exact = bodies.forces(face, j)[node][i];
                    assert!(
                        (slope - exact).abs() < 1e-8,
                        "{face} {j} {node} {i}: {slope} {exact}"
                    );
                }
            }
        }
    }
}

#[test]
fn second_derivatives_are_those_of_differences_with_the_motion_of_the_segments() {
    let h = 1e-6;
    for bodies in five() {
        let count = bodies.pair.carrier.faces.len();
        let factors: Vec<[f64; 3]> = (0..count)
            .map(|k| [0, 1, 2].map(|j| 1.0 + 0.5 * scattered(3 * k + j)))
            .collect();
        let weighted = |bodies: &Bodies| {
            let mut sum = vec![[0.0; 2]; bodies.places.len()];
            for (face, factors) in factors.iter().enumerate() {
                for (j, factor) in factors.iter().enumerate() {
                    for (sum, own) in sum.iter_mut().zip(bodies.forces(face, j)) {
                        (0..2).for_each(|i| sum[i] += factor * own[i]);
                    }
                }
            }
            sum
        };
        for (node, i) in [
            (1, 0),
            (2, 1),
            (9, 0),
            (13, 1),
            (bodies.places.len() - 2, 1),
        ] {
            let (before, after) = (
                weighted(&bodies.moved(node, i, -h)),
                weighted(&bodies.moved(node, i, h)),
            );
            let exact = bodies.bend(&factors, (node as u32, i));
            for (other, (before, after)) in before.iter().zip(&after).enumerate() {
                for j in 0..2 {
                    let bend = (after[j] - before[j]) / (2.0 * h);
                    let miss = (bend - exact[other][j]).abs();
                    assert!(
                        miss < 1e-8,
                        "{node} {i} {other} {j}: {bend} {}",
                        exact[other][j]
                    );
                }
            }
        }
    }
}

#[test]
fn an_even_pressure_on_flat_surfaces_loads_both_by_their_lengths() {
    for counts in [[7, 3], [5, 5], [3, 7], [12, 5]] {
        let bodies = lines(counts, 0.0, 0.0);
        let forces = bodies.all_forces();
        let mut exact = vec![[0.0; 2]; bodies.places.len()];
        for chain in [&bodies.pair.carrier, &bodies.pair.other] {
            for face in &chain.faces {
                let [a, b, edge] = face.nodes.map(|node| node as usize);
                let along = bodies.places[b][0] - bodies.places[a][0];
                // n = (0, -1) times along; to close the gap the upper body moves down.
                for (node, share) in [(a, 0.5), (b, 0.5), (edge, 2.0 / 3.0)] {
                    exact[node][1] += share * along;
                }
            }
        }
        for (node, (force, exact)) in forces.iter().zip(&exact).enumerate() {
            let miss = (force[1] - exact[1]).abs().max(force[0].abs());
            assert!(miss < 1e-13, "{counts:?} {node} {force:?} {exact:?}");
        }
    }
}

/// int p N dx of the functions of a face over its way along x, for p = 1 + 2 x, by Gauss.
fn consistent(nodes: [[f64; 2]; 3]) -> [f64; 3] {
    let rule = rule(Simplex::Segment, 5);
    let mut sums = [0.0; 3];
    for (l, weight) in rule.points.iter().zip(&rule.weights) {
        let s = l[1];
        let pressure = 1.0 + 2.0 * point(nodes, s)[0];
        let along = weight * pressure * slope(nodes, s)[0];
        let shapes = [1.0 - s, s, 4.0 * s * (1.0 - s)];
        (0..3).for_each(|k| sums[k] += along * shapes[k]);
    }
    sums
}

#[test]
fn a_pressure_that_grows_along_flat_surfaces_loads_both_by_its_moments() {
    for counts in [[7, 3], [3, 7], [12, 5]] {
        let bodies = lines(counts, 0.0, 0.0);
        let mut forces = vec![0.0; bodies.places.len()];
        for (face, own) in bodies.pair.carrier.faces.iter().enumerate() {
            let [a, b, _] = own
                .nodes
                .map(|node| 1.0 + 2.0 * bodies.places[node as usize][0]);
            for (j, factor) in [a, b, 0.5 * (a + b)].into_iter().enumerate() {
                let own = bodies.forces(face, j);
                forces
                    .iter_mut()
                    .zip(own)
                    .for_each(|(sum, own)| *sum += factor * own[1]);
            }
        }
        for chain in [&bodies.pair.carrier, &bodies.pair.other] {
            for face in &chain.faces {
                let nodes = face.nodes.map(|node| bodies.places[node as usize]);
                for (node, own) in face.nodes.iter().zip(consistent(nodes)) {
                    forces[*node as usize] -= own;
                }
            }
        }
        let largest = forces
            .iter()
            .fold(0.0_f64, |most, force| most.max(force.abs()));
        assert!(largest < 1e-13, "{counts:?} {largest:e}");
    }
}
