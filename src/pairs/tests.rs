//! Gaps of two surfaces against areas of closed curves, differences and balances of forces.

use std::f64::consts::TAU;

use super::choice::{Partner, Reach, pieces};
use super::number::Second;
use super::pair::PlaceOf;
use super::piece::{Face, INPUTS, point, slope};
use super::*;
use crate::element::quadrature::{Simplex, rule};

/// Two surfaces with the places of their nodes: vertices, then edges by their bulges.
struct Bodies {
    pair: Pair,
    places: Vec<[f64; 2]>,
}

/// Faces through `corners` with bulges at their middles, nodes from `first` on; closed or open.
fn chain(
    (corners, bulges): (&[[f64; 2]], &[[f64; 2]]),
    first: u32,
    places: &mut Vec<[f64; 2]>,
) -> Chain {
    let count = bulges.len();
    let vertices = corners.len();
    let is_closed = vertices == count;
    places.extend(corners);
    places.extend(bulges);
    let vertex = |k: usize| first + (k % vertices) as u32;
    let edge = |k: usize| first + (vertices + k % count) as u32;
    let face = |k: usize| ChainFace {
        nodes: [vertex(k), vertex(k + 1), edge(k)],
        beside: [
            (is_closed || k > 0).then(|| [vertex(k + vertices - 1), edge(k + count - 1)]),
            (is_closed || k + 1 < count).then(|| [vertex(k + 2), edge(k + 1)]),
        ],
        walls: [None, None],
        is_turned: false,
    };
    Chain {
        faces: (0..count).map(face).collect(),
    }
}

/// Numbers in \[-1, 1\] that follow each other without order.
fn scattered(k: usize) -> f64 {
    2.0 * ((k as f64 + 1.0) * 0.618_033_988_749_895).fract() - 1.0
}

/// A round surface, wavy by `wave`, run against the clock or with it.
fn round(count: usize, radius: f64, wave: f64, sense: f64) -> (Vec<[f64; 2]>, Vec<[f64; 2]>) {
    let at = |k: f64| {
        // No vertex of one surface opposite to one of the other, where second derivatives jump.
        let angle = 0.05 * sense + sense * TAU * k / count as f64;
        let r = radius * (1.0 + wave * (5.0 * angle).cos());
        [r * angle.cos(), r * angle.sin()]
    };
    let corners: Vec<[f64; 2]> = (0..count).map(|k| at(k as f64)).collect();
    let bulge = |k: usize| {
        let ends = [at(k as f64), at(k as f64 + 1.0)];
        [0, 1].map(|i| at(k as f64 + 0.5)[i] - 0.5 * (ends[0][i] + ends[1][i]))
    };
    let bulges = (0..count).map(bulge).collect();
    (corners, bulges)
}

/// A core in a ring, the core in the first place.
fn rings(core: usize, ring: usize) -> Bodies {
    let mut places = Vec::new();
    let own = round(core, 1.0, 0.01, 1.0);
    let first = chain((&own.0, &own.1), 0, &mut places);
    let next = places.len() as u32;
    let other = round(ring, 1.03, 0.004, -1.0);
    let second = chain((&other.0, &other.1), next, &mut places);
    Bodies {
        pair: Pair {
            carrier: first,
            other: second,
            section: Section::Plane,
        },
        places,
    }
}

/// A body above another: an uneven line of `counts` faces each, `open` apart, bent by `bend`.
fn lines(counts: [usize; 2], open: f64, bend: f64) -> Bodies {
    let mut places = Vec::new();
    let mut made = Vec::new();
    for (body, &count) in counts.iter().enumerate() {
        let first = places.len() as u32;
        let (start, end, height) = [(0.0, 1.0, open), (1.0, 0.0, 0.0)][body];
        let corner = |k: usize| {
            let inside = k > 0 && k < count;
            let shift = if inside {
                0.2 * scattered(k + 7 * body)
            } else {
                0.0
            };
            let x = start + (end - start) * (k as f64 + shift) / count as f64;
            [x, height + bend * scattered(3 * k + body)]
        };
        let corners: Vec<[f64; 2]> = (0..=count).map(corner).collect();
        let bulge = |k: usize| [0, 1].map(|i| 0.3 * bend * scattered(5 * k + 2 * i + body));
        let bulges: Vec<[f64; 2]> = (0..count).map(bulge).collect();
        made.push(chain((&corners, &bulges), first, &mut places));
    }
    let other = made.remove(1);
    Bodies {
        pair: Pair {
            carrier: made.remove(0),
            other,
            section: Section::Plane,
        },
        places,
    }
}

impl Bodies {
    fn at<T>(&self, see: impl FnOnce(&Placed<'_>) -> T) -> T {
        let place: &PlaceOf<'_> = &|node: u32| self.places[node as usize];
        see(&self.pair.placed(place))
    }

    /// Gaps of all faces.
    fn gaps(&self) -> Vec<[f64; 3]> {
        self.at(|placed| {
            let mut gaps = vec![[0.0; 3]; self.pair.carrier.faces.len()];
            for part in placed.gaps() {
                (0..3).for_each(|j| gaps[part.face][j] += part.gaps[j]);
            }
            gaps
        })
    }

    /// Derivatives of gap `j` of a face by all coordinates.
    fn forces(&self, face: usize, j: usize) -> Vec<[f64; 2]> {
        self.at(|placed| {
            let mut forces = vec![[0.0; 2]; self.places.len()];
            for part in placed.first().iter().filter(|part| part.face == face) {
                for (k, &node) in part.nodes.iter().enumerate() {
                    (0..2).for_each(|i| {
                        forces[node as usize][i] += part.gaps[j].first[2 * k + i];
                    });
                }
            }
            forces
        })
    }

    /// Derivatives of the sum of all gaps.
    fn all_forces(&self) -> Vec<[f64; 2]> {
        let mut sum = vec![[0.0; 2]; self.places.len()];
        for face in 0..self.pair.carrier.faces.len() {
            for j in 0..3 {
                for (sum, own) in sum.iter_mut().zip(self.forces(face, j)) {
                    (0..2).for_each(|i| sum[i] += own[i]);
                }
            }
        }
        sum
    }

    /// Second derivatives of the sum of gaps with those factors, a row of `node` and `i`.
    fn bend(&self, factors: &[[f64; 3]], (node, i): (u32, usize)) -> Vec<[f64; 2]> {
        let mut row = vec![[0.0; 2]; self.places.len()];
        self.at(|placed| {
            for (nodes, sum) in placed.second(factors) {
                add_row(&nodes, &sum, (node, i), &mut row);
            }
        });
        row
    }

    fn moved(&self, node: usize, i: usize, by: f64) -> Self {
        let mut places = self.places.clone();
        places[node][i] += by;
        Self {
            pair: self.pair.clone(),
            places,
        }
    }
}

fn add_row(nodes: &[u32], sum: &Second<INPUTS>, (node, i): (u32, usize), row: &mut [[f64; 2]]) {
    for (own, _) in nodes.iter().enumerate().filter(|(_, one)| **one == node) {
        for (k, &other) in nodes.iter().enumerate() {
            (0..2).for_each(|j| {
                row[other as usize][j] += sum.second_by(2 * own + i, 2 * k + j);
            });
        }
    }
}

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

fn volume(bodies: &Bodies) -> f64 {
    -area(&bodies.pair.other, &bodies.places) - area(&bodies.pair.carrier, &bodies.places)
}

/// The same about an axis two units to the left.
fn turned(mut bodies: Bodies) -> Bodies {
    bodies.pair.section = Section::AboutAxis;
    // Edges are known by what they are off the mean of their ends.
    for vertex in vertices(&bodies) {
        bodies.places[vertex][0] += 2.0;
    }
    bodies
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

/// The nodes that a translation moves: an edge is known by its middle less the mean of its ends.
fn vertices(bodies: &Bodies) -> Vec<usize> {
    let chains = [&bodies.pair.carrier, &bodies.pair.other];
    let faces = chains.into_iter().flat_map(|chain| &chain.faces);
    let ends = faces.flat_map(|face| [face.nodes[0], face.nodes[1]]);
    let mut vertices: Vec<usize> = ends.map(|node| node as usize).collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices
}

#[test]
fn first_derivatives_are_those_of_differences() {
    let h = 1e-6;
    for bodies in [
        rings(12, 9),
        lines([4, 6], 0.06, 0.02),
        lines([6, 4], -0.03, 0.02),
        turned(lines([4, 6], 0.06, 0.02)),
        turned(lines([6, 4], -0.03, 0.02)),
    ] {
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
    for bodies in [
        rings(12, 9),
        lines([4, 6], 0.06, 0.02),
        lines([6, 4], -0.03, 0.02),
        turned(lines([4, 6], 0.06, 0.02)),
        turned(lines([6, 4], -0.03, 0.02)),
    ] {
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

#[test]
fn the_tree_finds_the_partners_that_a_look_at_all_faces_finds() {
    for bodies in [
        rings(30, 23),
        lines([5, 17], 0.05, 0.02),
        lines([17, 3], -0.02, 0.01),
    ] {
        let all: Vec<Partner> = (bodies.pair.other.faces.iter())
            .map(|face| Partner {
                nodes: face.nodes.map(|node| bodies.places[node as usize]),
                range: face.range(),
            })
            .collect();
        bodies.at(|placed| {
            let mut twins = Vec::new();
            for face in &bodies.pair.carrier.faces {
                let beside = face.sides();
                let [before, after] = face.beside.map(|one| one.unwrap_or([0, 0]));
                let [a, b, edge] = face.nodes;
                let nodes = [
                    a, b, edge, before[0], before[1], after[0], after[1], 0, 0, 0,
                ];
                let at = Face::new(&nodes.map(|node| bodies.places[node as usize]), beside);
                let reach = Reach {
                    open: placed.reach,
                    inside: placed.reach,
                };
                twins.extend(pieces(&at, beside, &all, reach));
            }
            let found = placed.meetings.iter();
            let found: Vec<_> = found.map(|one| (one.other, one.piece.ends)).collect();
            let twins: Vec<_> = twins
                .iter()
                .map(|(other, piece)| (*other, piece.ends))
                .collect();
            assert_eq!(found, twins);
        });
    }
}

#[test]
fn a_face_beyond_the_end_of_the_other_surface_has_no_partner() {
    let mut bodies = lines([10, 2], 0.01, 0.0);
    let first = bodies.pair.carrier.faces.len() * 2 + 1;
    // The lower body is half as long: its end goes on by 0.3 of its face.
    for place in &mut bodies.places[first..] {
        place[0] *= 0.5;
    }
    let end = bodies.pair.other.faces[0]
        .nodes
        .map(|node| bodies.places[node as usize]);
    let reach = end[0][0] + 0.3 * (end[0][0] - end[1][0]);
    bodies.at(|placed| {
        let covered: f64 = placed.covered().iter().flat_map(|own| own[0]).sum();
        assert!((covered - reach).abs() < 1e-12, "{covered} {reach}");
        let whole: f64 = placed.covered().iter().flat_map(|own| own[1]).sum();
        assert!((whole - 1.0).abs() < 1e-12);
        let probes = placed
            .meetings
            .iter()
            .flat_map(|meeting| placed.probes(meeting));
        assert!(
            probes
                .into_iter()
                .all(|one| (one.distance - 0.01).abs() < 1e-14)
        );
    });
}

/// Bodies with where they were when the increment began: slid along each other by a bit.
fn slid() -> [(Bodies, Vec<[f64; 2]>); 3] {
    let all = [
        rings(12, 9),
        lines([4, 6], 0.01, 0.02),
        turned(lines([6, 4], -0.02, 0.02)),
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
        for (node, i) in [(1, 0), (2, 1), (bodies.places.len() - 2, 1)] {
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
        for (node, i) in [(1, 0), (2, 1), (bodies.places.len() - 2, 1)] {
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
