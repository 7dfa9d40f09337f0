//! Surfaces that end over the middle of faces: derivatives with the lines that end them.

use super::super::patch::EDGES;
use super::*;

/// A plate of `count`^2 squares of two faces each over `size` from `start` on, rough by `rough`, that
/// looks up or down.
fn plate(
    (count, sense): (usize, f64),
    (start, size): ([f64; 3], f64),
    rough: f64,
    places: &mut Vec<[f64; 3]>,
) -> Skin {
    let first = places.len();
    let step = size / count as f64;
    for k in 0..(count + 1) * (count + 1) {
        let [x, y] = [(k % (count + 1)) as f64, (k / (count + 1)) as f64];
        let off = [0, 1, 2].map(|i| rough * scattered(3 * (k + first) + i));
        places.push([
            start[0] + step * x + off[0],
            start[1] + step * y + off[1],
            start[2] + off[2],
        ]);
    }
    let vertex = |x: usize, y: usize| (first + y * (count + 1) + x) as u32;
    let mut edges = BTreeMap::new();
    let mut skin = Skin::default();
    for square in 0..count * count {
        let (x, y) = (square % count, square / count);
        let [a, b] = [vertex(x, y), vertex(x + 1, y)];
        let [c, d] = [vertex(x + 1, y + 1), vertex(x, y + 1)];
        for [p, q, r] in [[a, b, c], [a, c, d]] {
            let corners = if sense > 0.0 { [p, q, r] } else { [p, r, q] };
            let mut nodes = [0; NODES];
            nodes[..3].copy_from_slice(&corners);
            for (edge, [i, j]) in EDGES.into_iter().enumerate() {
                let ends = [corners[i].min(corners[j]), corners[i].max(corners[j])];
                nodes[3 + edge] = *edges.entry(ends).or_insert_with(|| {
                    let k = places.len();
                    places.push([0, 1, 2].map(|i| 0.2 * rough * scattered(3 * k + i)));
                    k as u32
                });
            }
            skin.faces.push(SkinFace {
                nodes,
                normals: [0; 3],
                rims: [true; 3],
                is_turned: false,
            });
        }
    }
    let at = |node: u32| places[node as usize];
    skin.join(&at);
    skin
}

/// A small plate above a wide one that carries, with the places of the nodes.
pub(super) fn plates(open: f64, rough: f64) -> Bodies {
    let mut places = Vec::new();
    let carrier = plate((3, 1.0), ([0.0; 3], 1.0), rough, &mut places);
    let other = plate((2, -1.0), ([0.27, 0.31, open], 0.4), rough, &mut places);
    Bodies {
        pair: Pair {
            carrier,
            other,
            fold: None,
        },
        places,
    }
}

/// sum_j factor_j G_j, and its derivative.
fn sum(bodies: &Bodies) -> (f64, Vec<f64>) {
    bodies.see(|gaps| {
        let found = gaps.derivatives();
        let mut slope = vec![0.0; 3 * bodies.places.len()];
        let mut value = 0.0;
        for (k, (row, gap)) in found.rows.iter().zip(&found.values).enumerate() {
            let factor = 1.0 + 0.5 * scattered(k);
            value += factor * gap;
            for (unknown, own) in row {
                slope[*unknown as usize] += factor * own;
            }
        }
        (value, slope)
    })
}

/// But for what parabolas are off the lines as rays see them, at most 1e-5 of a face.
#[test]
fn gaps_that_end_over_faces_have_the_derivatives_of_differences() {
    let bodies = plates(0.1, 0.01);
    let (_, slope) = sum(&bodies);
    let size = slope.iter().fold(0.0, |size: f64, x| size.max(x.abs()));
    let h = 1e-5;
    for unknown in 0..slope.len() {
        let [before, after] = [-h, h].map(|by| sum(&bodies.moved(unknown, by)).0);
        let change = (after - before) / (2.0 * h);
        let miss = (change - slope[unknown]).abs();
        assert!(miss < 1e-3 * size, "{unknown} {change} {}", slope[unknown]);
    }
}

/// Where the gap is small: parts with the gap itself at the lines are left out.
#[test]
fn gaps_that_end_over_faces_have_second_derivatives_with_the_motion_of_these_lines() {
    let bodies = plates(0.0, 1e-3);
    let factors: Vec<f64> = (0..6 * bodies.pair.carrier.faces.len())
        .map(|k| 1.0 + 0.5 * scattered(k))
        .collect();
    let rows = bodies.see(|gaps| gaps.curvature(&factors));
    let (h, mut miss, mut size) = (1e-5, 0.0_f64, 0.0_f64);
    for unknown in (0..rows.len()).step_by(7) {
        let mut own = vec![0.0; rows.len()];
        for (k, value) in &rows[unknown] {
            own[*k as usize] += value;
        }
        let [before, after] = [-h, h].map(|by| sum(&bodies.moved(unknown, by)).1);
        for k in 0..own.len() {
            let change = (after[k] - before[k]) / (2.0 * h);
            miss = miss.max((change - own[k]).abs());
            size = size.max(own[k].abs());
        }
    }
    assert!(miss < 1e-2 * size, "{miss:e} of {size:e}");
}
