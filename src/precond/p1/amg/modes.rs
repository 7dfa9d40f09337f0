//! Rigid-body modes: what the stiffness of a free body maps to zero.
//!
//! K = 3 (2D) or 6 (3D) modes; the unknowns of a vertex at x, relative to the
//! centroid, move by the rows of `[I | rotations]`. Held components carry none.

use crate::linalg::Held;

/// Modes at each node: `[nodes][components][modes]`.
pub(super) type Modes<const N: usize, const K: usize> = Vec<[[f64; K]; N]>;

/// Rigid-body modes at vertices; `held` are unknowns, others than those of
/// the vertices are passed over.
pub(super) fn rigid_modes<const N: usize, const K: usize>(
    coordinates: &[[f64; 3]],
    held: &Held,
) -> Modes<N, K> {
    let (centre, radius) = centre_and_radius(coordinates);
    let mut modes: Modes<N, K> = coordinates
        .iter()
        .map(|x| at([0, 1, 2].map(|axis| (x[axis] - centre[axis]) / radius)))
        .collect();
    for &unknown in held.entries.iter() {
        if let Some(vertex) = modes.get_mut(unknown as usize / N) {
            vertex[unknown as usize % N] = [0.0; K];
        }
    }
    for one in held.nodes.iter() {
        if let Some(vertex) = modes.get_mut(one.node as usize) {
            for mode in 0..K {
                let mut moved: [f64; N] = std::array::from_fn(|i| vertex[i][mode]);
                one.project(&mut moved);
                (0..N).for_each(|i| vertex[i][mode] = moved[i]);
            }
        }
    }
    modes
}

/// Mean vertex, and the largest distance from it along an axis.
fn centre_and_radius(coordinates: &[[f64; 3]]) -> ([f64; 3], f64) {
    let mut centre = [0.0; 3];
    for x in coordinates {
        for axis in 0..3 {
            centre[axis] += x[axis] / coordinates.len() as f64;
        }
    }
    let distances = coordinates
        .iter()
        .flat_map(|x| (0..3).map(move |axis| (x[axis] - centre[axis]).abs()));
    (centre, distances.fold(f64::MIN_POSITIVE, f64::max))
}

/// Translations, then the rotations in the planes (x, y), (y, z), (z, x).
fn at<const N: usize, const K: usize>(x: [f64; 3]) -> [[f64; K]; N] {
    const PLANES: [(usize, usize); 3] = [(0, 1), (1, 2), (2, 0)];
    let mut modes = [[0.0; K]; N];
    for i in 0..N {
        modes[i][i] = 1.0;
    }
    for (mode, &(from, to)) in (N..K).zip(&PLANES) {
        modes[from][mode] = -x[to];
        modes[to][mode] = x[from];
    }
    modes
}
