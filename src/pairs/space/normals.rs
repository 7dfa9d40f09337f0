//! Normals that faces share, and their derivatives by the nodes:
//!
//! ```text
//! N = P sum over the faces of t_1 x t_2,   n = N / |N|,   t_k = x_k - x_0 + 4 m_k at the corner
//! dn = (1 - n n') dN / |N|
//! c.d2n = gamma.d2N + dN' S dN,   gamma = P (c - n (c.n)) / |N|
//! S = -(c n' + n c' + (c.n) (1 - 3 n n')) / |N|^2
//! ```
//!
//! P leaves out the components across walls. Shapes: rows of dn `[3]` by displacement unknowns, three
//! a node. Cost: some 300 entries a normal.

use super::patch::Patch;
use super::skin::{Fan, Skin, corner_tangents, edge_between};
use crate::contact::shares::add_equal_columns;
use crate::geometry::vector3::{add, cross, dot, norm, scale};

/// Entries by unknown.
pub(super) type Row = Vec<(u32, f64)>;
type Matrix = [[f64; 3]; 3];

/// What a vector of a face is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Vector {
    /// A displacement node.
    Node(u32),
    /// A normal.
    Normal(u32),
}

/// A normal with its size before it has unit length.
#[derive(Clone, Copy, Debug, Default)]
pub struct Normal {
    /// n.
    pub unit: [f64; 3],
    /// |N|.
    pub size: f64,
}

/// Without the components across walls.
fn along_walls(v: [f64; 3], walls: [bool; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| if walls[i] { 0.0 } else { v[i] })
}

/// All normals of a surface whose faces are `patches`.
pub(super) fn normals(skin: &Skin, patches: &[Patch]) -> Vec<Normal> {
    let one = |fan: &Fan| {
        let corners = fan.corners.iter();
        let sum = corners.fold([0.0; 3], |sum, &[face, corner]| {
            let [first, second] = corner_tangents(&patches[face as usize], corner as usize);
            add(sum, cross(first, second))
        });
        let sum = along_walls(sum, fan.walls);
        let size = norm(sum);
        Normal {
            unit: scale(size.recip(), sum),
            size,
        }
    };
    skin.fans.iter().map(one).collect()
}

/// dt_1 and dt_2 of a corner by its nodes: node, and factor of both.
fn motions(skin: &Skin, [face, corner]: [u32; 2]) -> [(u32, [f64; 2]); 5] {
    let corner = corner as usize;
    let [b, c] = [(corner + 1) % 3, (corner + 2) % 3];
    let nodes = skin.faces[face as usize].nodes;
    [
        (nodes[corner], [-1.0, -1.0]),
        (nodes[b], [1.0, 0.0]),
        (nodes[c], [0.0, 1.0]),
        (nodes[edge_between(corner, b)], [4.0, 0.0]),
        (nodes[edge_between(corner, c)], [0.0, 4.0]),
    ]
}

/// The matrix of v -> a x v.
fn turning([x, y, z]: [f64; 3]) -> Matrix {
    [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]
}

/// A fan where it is.
#[derive(Clone, Copy)]
pub(super) struct FanAt<'a> {
    skin: &'a Skin,
    patches: &'a [Patch],
    fan: &'a Fan,
    normal: Normal,
}

impl<'a> FanAt<'a> {
    /// Of a surface whose faces and normals are there, by its number.
    pub(super) fn new(
        (skin, patches, normals): (&'a Skin, &'a [Patch], &[Normal]),
        number: usize,
    ) -> Self {
        Self {
            skin,
            patches,
            fan: &skin.fans[number],
            normal: normals[number],
        }
    }

    /// Rows of dN `[3]`.
    fn sum_rows(&self) -> [Row; 3] {
        let mut rows: [Row; 3] = Default::default();
        let walls = self.fan.walls;
        for &at in &self.fan.corners {
            let [first, second] = corner_tangents(&self.patches[at[0] as usize], at[1] as usize);
            // d(t_1 x t_2) = t_1 x dt_2 - t_2 x dt_1
            let [of_second, of_first] = [turning(first), turning(second)];
            for (node, [f, s]) in motions(self.skin, at) {
                for (i, row) in rows.iter_mut().enumerate().filter(|(i, _)| !walls[*i]) {
                    let entry = |j: usize| s * of_second[i][j] - f * of_first[i][j];
                    row.extend((0..3).map(|j| (3 * node + j as u32, entry(j))));
                }
            }
        }
        rows.iter_mut().for_each(add_equal_columns);
        rows
    }

    /// Rows of dn `[3]`.
    pub(super) fn rows(&self) -> [Row; 3] {
        let of_sum = self.sum_rows();
        let n = self.normal.unit;
        [0, 1, 2].map(|i| {
            let mut row = Row::new();
            for (j, own) in of_sum.iter().enumerate() {
                let factor = (f64::from(u8::from(i == j)) - n[i] * n[j]) / self.normal.size;
                row.extend(own.iter().map(|&(k, value)| (k, factor * value)));
            }
            add_equal_columns(&mut row);
            row
        })
    }

    /// Adds second derivatives of c.n to `rows` of displacement unknowns.
    pub(super) fn add_bend(&self, c: [f64; 3], rows: &mut [Row]) {
        let (n, size) = (self.normal.unit, self.normal.size);
        let along = dot(c, n);
        let free = [0, 1, 2].map(|i| c[i] - n[i] * along);
        let gamma = scale(size.recip(), along_walls(free, self.fan.walls));
        self.add_products(gamma, rows);
        let of_sum = self.sum_rows();
        for (i, own) in of_sum.iter().enumerate() {
            for (j, other) in of_sum.iter().enumerate() {
                let same = f64::from(u8::from(i == j));
                let s = c[i] * n[j] + n[i] * c[j] + along * (same - 3.0 * n[i] * n[j]);
                let s = -s / (size * size);
                for &(row, value) in own {
                    let entries = other.iter();
                    rows[row as usize].extend(entries.map(|&(k, one)| (k, s * value * one)));
                }
            }
        }
    }

    /// Adds those of gamma.N.
    fn add_products(&self, gamma: [f64; 3], rows: &mut [Row]) {
        // gamma.(dt_1 x dt_2), and the same with both exchanged.
        let turn = turning(gamma);
        for &at in &self.fan.corners {
            let own = motions(self.skin, at);
            for &(node, [f, s]) in &own {
                for &(other, [g, t]) in &own {
                    let factor = s * g - f * t;
                    for (i, turn) in turn.iter().enumerate() {
                        let row = &mut rows[3 * node as usize + i];
                        row.extend((0..3).map(|j| (3 * other + j as u32, factor * turn[j])));
                    }
                }
            }
        }
    }
}
