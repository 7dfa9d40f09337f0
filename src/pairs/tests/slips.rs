//! Slips of two surfaces, and what tractions do: differences and balances.

use super::*;

/// Bodies with where they were when the increment began: slid along each other by a bit.
fn slid() -> [(Bodies, Vec<[f64; 2]>); 5] {
    let all = [
        rings(12, 9),
        lines([4, 6], 0.01, 0.02),
        turned(lines([6, 4], -0.02, 0.02)),
        narrow(lines([3, 5], 0.01, 0.02)),
        turned(narrow(lines([3, 5], -0.02, 0.02))),
    ];
    all.map(|bodies| {
        let shaken = |(k, &[x, y]): (usize, &[f64; 2])| {
            let by = |i: usize| 0.01 * scattered(2 * k + i);
            [x + by(0) + 0.03, y + by(1)]
        };
        let start = bodies.places.iter().enumerate().map(shaken).collect();
        (bodies, start)
    })
}

/// The same with an other surface that ends under faces of the carrier.
fn narrow(mut bodies: Bodies) -> Bodies {
    let faces = bodies.pair.other.faces.iter();
    let mut own: Vec<u32> = faces
        .flat_map(|face| [face.nodes[0], face.nodes[1]])
        .collect();
    own.sort_unstable();
    own.dedup();
    for vertex in own {
        let x = &mut bodies.places[vertex as usize][0];
        *x = 0.23 + 0.51 * *x;
    }
    bodies
}

/// Some nodes of both surfaces and a direction each, the ends of the other one among them.
fn some_motions(bodies: &Bodies) -> Vec<(usize, usize)> {
    let faces = &bodies.pair.other.faces;
    let ends = faces.iter().filter(|face| face.beside.contains(&None));
    let ends = ends.flat_map(|face| [face.nodes[0], face.nodes[1]]);
    let ends = ends.flat_map(|node| [(node as usize, 0), (node as usize, 1)]);
    let inside = [(1, 0), (2, 1), (bodies.places.len() - 2, 1)];
    inside.into_iter().chain(ends).collect()
}

/// S of all faces.
fn slips(bodies: &Bodies, start: &[[f64; 2]]) -> Vec<[f64; 3]> {
    bodies.at(|placed| {
        let mut sums = vec![[0.0; 3]; bodies.pair.carrier.faces.len()];
        for part in placed.slid(&|node| start[node as usize]) {
            (0..3).for_each(|j| sums[part.face][j] += part.slips[j]);
        }
        sums
    })
}

/// Forces of tractions on all nodes.
fn pulls(bodies: &Bodies, tractions: &[[f64; 3]]) -> Vec<[f64; 2]> {
    bodies.at(|placed| {
        let mut forces = vec![[0.0; 2]; bodies.places.len()];
        for part in placed.slid(&|node| bodies.places[node as usize]) {
            for (own, factor) in part.rows.iter().zip(tractions[part.face]) {
                for (k, &node) in part.nodes.iter().enumerate() {
                    (0..2).for_each(|i| forces[node as usize][i] += factor * own[2 * k + i]);
                }
            }
        }
        forces
    })
}

fn some_tractions(bodies: &Bodies) -> Vec<[f64; 3]> {
    let faces = 0..bodies.pair.carrier.faces.len();
    let own = |face: usize| [0, 1, 2].map(|j| 1.0 + 0.5 * scattered(3 * face + j));
    faces.map(own).collect()
}

#[test]
fn nothing_has_slid_where_the_same_points_are_opposite() {
    for (bodies, _) in slid() {
        let none = slips(&bodies, &bodies.places);
        let largest = none
            .as_flattened()
            .iter()
            .fold(0.0_f64, |m, s| m.max(s.abs()));
        assert!(largest < 1e-14, "{largest:e}");
        // A common turn and way of both bodies at the start are no slip either, nor a change of one.
        let (sine, cosine) = 0.7_f64.sin_cos();
        let carried = |&[x, y]: &[f64; 2]| [cosine * x - sine * y, sine * x + cosine * y];
        let start: Vec<[f64; 2]> = bodies.places.iter().map(carried).collect();
        let largest = slips(&bodies, &start);
        let largest = largest
            .as_flattened()
            .iter()
            .fold(0.0_f64, |m, s| m.max(s.abs()));
        assert!(largest < 1e-13, "{largest:e}");
    }
}

#[test]
fn derivatives_of_slips_are_those_of_differences() {
    let h = 1e-6;
    for (bodies, start) in slid() {
        for (node, i) in some_motions(&bodies) {
            let [before, after] = [-h, h].map(|by| slips(&bodies.moved(node, i, by), &start));
            let mut exact = vec![[0.0; 3]; before.len()];
            bodies.at(|placed| {
                for part in placed.slips_first(&|node| start[node as usize]) {
                    for (k, _) in
                        (part.nodes.iter().enumerate()).filter(|(_, n)| **n as usize == node)
                    {
                        (0..3).for_each(|j| exact[part.face][j] += part.gaps[j].first[2 * k + i]);
                    }
                }
            });
            for (face, (before, after)) in before.iter().zip(&after).enumerate() {
                for j in 0..3 {
                    let slope = (after[j] - before[j]) / (2.0 * h);
                    assert!(
                        (slope - exact[face][j]).abs() < 1e-8,
                        "{face} {j} {node} {i}"
                    );
                }
            }
        }
    }
}

#[test]
fn tractions_pull_both_surfaces_alike_and_without_a_moment() {
    for (bodies, _) in slid() {
        let forces = pulls(&bodies, &some_tractions(&bodies));
        let size = forces.as_flattened().iter().map(|f| f.abs()).sum::<f64>();
        let vertices = vertices(&bodies);
        let along = |i: usize| vertices.iter().map(|&v| forces[v][i]).sum::<f64>();
        let moment = bodies.places.iter().zip(&forces);
        let moment: f64 = moment.map(|(x, f)| x[0] * f[1] - x[1] * f[0]).sum();
        for sum in [along(0), along(1), moment] {
            assert!(sum.abs() <= 1e-13 * size, "{sum:e} {size}");
        }
    }
}

#[test]
fn changes_of_tractions_are_those_of_differences() {
    let h = 1e-6;
    for (bodies, _) in slid() {
        let tractions = some_tractions(&bodies);
        for (node, i) in some_motions(&bodies) {
            let [before, after] = [-h, h].map(|by| pulls(&bodies.moved(node, i, by), &tractions));
            let mut exact = vec![[0.0; 2]; before.len()];
            bodies.at(|placed| {
                for (nodes, change) in placed.traction_changes(&tractions) {
                    for (l, _) in nodes
                        .iter()
                        .enumerate()
                        .filter(|(_, n)| **n as usize == node)
                    {
                        for (k, &own) in nodes.iter().enumerate() {
                            (0..2).for_each(|a| {
                                exact[own as usize][a] += change[2 * k + a][2 * l + i]
                            });
                        }
                    }
                }
            });
            for (own, (before, after)) in before.iter().zip(&after).enumerate() {
                for a in 0..2 {
                    let slope = (after[a] - before[a]) / (2.0 * h);
                    let miss = (slope - exact[own][a]).abs();
                    // Points of the rule move along with the pieces, over what is smooth: its own error.
                    assert!(
                        miss < 1e-5,
                        "{own} {a} {node} {i} {slope} {}",
                        exact[own][a]
                    );
                }
            }
        }
    }
}
