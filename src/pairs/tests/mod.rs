//! Gaps of two surfaces against areas of closed curves, differences and balances of forces; whom faces
//! meet; slips.

use std::f64::consts::TAU;

use super::chain::PlaceOf;
use super::number::Second;
use super::piece::INPUTS;
use super::*;

mod folds;
mod gaps;
mod meetings;
mod rest;
mod slips;

/// Two surfaces with the places of their nodes: vertices, then edges by their bulges.
#[derive(Clone)]
struct Bodies {
    pair: Pair,
    places: Vec<[f64; 2]>,
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
            fold: None,
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
            fold: None,
        },
        places,
    }
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

/// Bodies with next to all that happens: round and open, apart and inside each other, in the plane and
/// about an axis.
fn five() -> [Bodies; 5] {
    [
        rings(12, 9),
        lines([4, 6], 0.06, 0.02),
        lines([6, 4], -0.03, 0.02),
        turned(lines([4, 6], 0.06, 0.02)),
        turned(lines([6, 4], -0.03, 0.02)),
    ]
}
