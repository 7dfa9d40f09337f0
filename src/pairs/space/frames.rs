//! Tangents of the functions of a carrier, which move and turn with its faces:
//!
//! ```text
//! N = M / |M|,   M = sum over the faces of a function of (b - a) x (c - a)
//! q = d - N (N.d),   t_1 = q / |q|,   t_2 = N x t_1
//! t_1 = M x h / |M x h|,   t_2 = 0     where a wall across h holds both surfaces
//! ```
//!
//! d runs along an edge of the first of them. Shapes: by functions; of vectors T = s_1 t_1 + s_2 t_2
//! derivatives by displacement unknowns, vertices alone. Cost: some 50 flops an entry.

use super::normals::Row;
use super::patch::{EDGES, NODES, Patch};
use super::skin::Skin;
use crate::contact::shares::add_equal_columns;
use crate::geometry::vector3::{add, cross, dot, norm, scale, sub};
use crate::pairs::ground::Ground;

/// Cosine between a normal and what is held from which on that says nothing about tangents; chosen.
const ALONG: f64 = 0.9;
/// Difference of coordinates over the extent of the mesh that is rounding, without unit; chosen.
const SAME: f64 = 1e-9;

/// t_1 and t_2; zero where there is none.
pub(crate) type Frame = [[f64; 3]; 2];

/// What tangents of a function follow.
#[derive(Clone, Debug, Default)]
pub(super) struct Home {
    /// Its faces.
    pub(super) faces: Vec<u32>,
    /// Two corners of the first of them.
    pub(super) ends: [usize; 2],
    /// Axes along which both surfaces are held there.
    pub(super) walls: [bool; 3],
}

/// The functions of a carrier with faces that have the `functions`, of `count`; `other` is what it meets.
pub(super) fn homes(
    ground: Ground<'_>,
    [carrier, other]: [&Skin; 2],
    (functions, count): (&[[u32; NODES]], usize),
) -> Vec<Home> {
    let mut homes = vec![Home::default(); count];
    let planes = held_planes(ground, other);
    for (number, (face, own)) in (0..).zip(carrier.faces.iter().zip(functions)) {
        for (k, &function) in own.iter().enumerate() {
            let Some(home) = homes.get_mut(function as usize) else {
                continue;
            };
            if home.faces.is_empty() {
                home.ends = k
                    .checked_sub(3)
                    .map_or([k, (k + 1) % 3], |edge| EDGES[edge]);
                home.walls = walls(ground, face.nodes[k], &planes);
            }
            home.faces.push(number);
        }
    }
    homes
}

/// Where a displacement node is at rest.
fn at_rest(ground: Ground<'_>, node: u32) -> [f64; 3] {
    let (mesh, node) = (ground.mesh, node as usize);
    match node.checked_sub(ground.space.vertices) {
        None => mesh.coordinates()[node],
        Some(edge) => {
            let [a, b] = mesh.edges()[edge].map(|k| mesh.coordinates()[k as usize]);
            scale(0.5, add(a, b))
        }
    }
}

/// Coordinates along each axis at which nodes of a surface are held along it, ascending.
fn held_planes(ground: Ground<'_>, skin: &Skin) -> [Vec<f64>; 3] {
    let nodes = || skin.faces.iter().flat_map(|face| face.nodes);
    [0, 1, 2].map(|axis: usize| {
        let held = nodes().filter(|node| (ground.is_held)(3 * node + axis as u32));
        let mut places: Vec<f64> = held.map(|node| at_rest(ground, node)[axis]).collect();
        places.sort_by(f64::total_cmp);
        places
    })
}

/// Axes along which a node is held, and the other surface on the same plane.
fn walls(ground: Ground<'_>, node: u32, planes: &[Vec<f64>; 3]) -> [bool; 3] {
    let place = at_rest(ground, node);
    [0, 1, 2].map(|axis: usize| {
        let near = SAME * (1.0 + place[axis].abs());
        let first = planes[axis].partition_point(|x| *x < place[axis] - near);
        let is_met = planes[axis]
            .get(first)
            .is_some_and(|x| *x <= place[axis] + near);
        is_met && (ground.is_held)(3 * node + axis as u32)
    })
}

/// Tangents where faces are, with what their derivatives ask for.
#[derive(Clone, Copy, Debug)]
pub(super) struct HomeAt<'a> {
    home: &'a Home,
    patches: &'a [Patch],
    /// N and |M|.
    normal: ([f64; 3], f64),
    kind: Kind,
}

/// How tangents are found.
#[derive(Clone, Copy, Debug)]
enum Kind {
    /// Along an edge: t_1, d, |q|.
    Edge([f64; 3], [f64; 3], f64),
    /// Along a wall: t_1, h, |M x h|.
    Wall([f64; 3], [f64; 3], f64),
    /// None.
    Held,
}

impl<'a> HomeAt<'a> {
    /// Of a function on a surface whose faces are `patches`.
    pub(super) fn new(home: &'a Home, patches: &'a [Patch]) -> Self {
        let areas = home.faces.iter().map(|&face| {
            let [u, v] = sides(&patches[face as usize]);
            cross(u, v)
        });
        let sum = areas.fold([0.0; 3], add);
        let size = norm(sum);
        let normal = scale(size.recip(), sum);
        Self {
            kind: kind(home, patches, (normal, size)),
            normal: (normal, size),
            home,
            patches,
        }
    }

    /// t_1 and t_2.
    pub(super) fn frame(&self) -> Frame {
        match self.kind {
            Kind::Edge(first, ..) => [first, cross(self.normal.0, first)],
            Kind::Wall(first, ..) => [first, [0.0; 3]],
            Kind::Held => [[0.0; 3]; 2],
        }
    }

    /// Rows of dT `[3]`.
    pub(super) fn rows(&self, skin: &Skin, parts: [f64; 2]) -> [Row; 3] {
        let mut rows: [Row; 3] = Default::default();
        let mut note = |node: u32, by: &dyn Fn([f64; 3]) -> [[f64; 3]; 2]| {
            for axis in 0..3 {
                let mut step = [0.0; 3];
                step[axis as usize] = 1.0;
                let change = self.turned(by(step), parts);
                let entries = rows.iter_mut().zip(change);
                entries.for_each(|(row, value)| row.push((3 * node + axis, value)));
            }
        };
        for &face in &self.home.faces {
            let [u, v] = sides(&self.patches[face as usize]);
            let [a, b, c, ..] = skin.faces[face as usize].nodes;
            note(a, &|x| [cross(x, sub(u, v)), [0.0; 3]]);
            note(b, &|x| [cross(x, v), [0.0; 3]]);
            note(c, &|x| [cross(u, x), [0.0; 3]]);
        }
        if let Some(&face) = self.home.faces.first() {
            let nodes = skin.faces[face as usize].nodes;
            let [from, to] = self.home.ends.map(|end| nodes[end]);
            note(from, &|x| [[0.0; 3], scale(-1.0, x)]);
            note(to, &|x| [[0.0; 3], x]);
        }
        rows.iter_mut().for_each(add_equal_columns);
        rows
    }

    /// dT by dM and dd.
    fn turned(&self, [by_sum, along]: [[f64; 3]; 2], [s1, s2]: [f64; 2]) -> [f64; 3] {
        let (n, size) = self.normal;
        match self.kind {
            Kind::Edge(first, d, length) => {
                let turn = scale(size.recip(), without(by_sum, n));
                let bent = add(scale(dot(n, d), turn), scale(dot(turn, d), n));
                let q = sub(without(along, n), bent);
                let slope = scale(length.recip(), without(q, first));
                let second = add(cross(turn, first), cross(n, slope));
                add(scale(s1, slope), scale(s2, second))
            }
            Kind::Wall(first, h, length) => {
                let slope = without(cross(by_sum, h), first);
                scale(s1 / length, slope)
            }
            Kind::Held => [0.0; 3],
        }
    }
}

fn kind(home: &Home, patches: &[Patch], (normal, size): ([f64; 3], f64)) -> Kind {
    let axis = |i: usize| [0, 1, 2].map(|j: usize| f64::from(u8::from(i == j)));
    let is_across = |i: &usize| home.walls[*i] && normal[*i].abs() < ALONG;
    let mut walls = (0..3).filter(is_across);
    let first = home.faces.first().map(|&face| &patches[face as usize]);
    match (first, walls.next(), walls.next()) {
        (Some(patch), None, _) => {
            let [from, to] = home.ends.map(|end| patch.nodes[end]);
            let d = sub(to, from);
            let q = without(d, normal);
            let length = norm(q);
            Kind::Edge(scale(length.recip(), q), d, length)
        }
        (Some(_), Some(wall), None) => {
            let h = axis(wall);
            let along = cross(scale(size, normal), h);
            let length = norm(along);
            Kind::Wall(scale(length.recip(), along), h, length)
        }
        _ => Kind::Held,
    }
}

/// b - a and c - a.
fn sides(patch: &Patch) -> [[f64; 3]; 2] {
    let [a, b, c, ..] = patch.nodes;
    [sub(b, a), sub(c, a)]
}

/// v without its part along a unit vector.
fn without(v: [f64; 3], unit: [f64; 3]) -> [f64; 3] {
    sub(v, scale(dot(v, unit), unit))
}
