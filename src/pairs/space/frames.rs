//! Tangents of the functions of a carrier, which move and turn with its faces:
//!
//! ```text
//! N = M / |M|,   M = sum over the faces of a function of (b - a) x (c - a)
//! q = d - N (N.d),   t_1 = q / |q|,   t_2 = N x t_1
//! t_1 = M x h / |M x h|                where supports hold both surfaces along h in one plane
//! ```
//!
//! d runs along an edge of the first of them. A tangent along which both surfaces are held has no traction
//! while the supports move them alike, as those of a plane of symmetry do: what is opposite there cannot slip,
//! and its traction would be undetermined. Shapes: by functions; of vectors T = s_1 t_1 + s_2 t_2
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
pub(super) struct Tangents {
    /// Its faces.
    pub(super) faces: Vec<u32>,
    /// Two corners of the first of them.
    pub(super) ends: [usize; 2],
    /// Along which axes both surfaces are held there.
    pub(super) walls: [Option<Wall>; 3],
}

/// A plane in which both surfaces are held along an axis: a vertex of the carrier and one of the other surface.
pub(super) type Wall = [u32; 2];

/// Whether supports move both surfaces apart along an axis.
pub(super) type IsMoved<'a> = dyn Fn(usize, Wall) -> bool + 'a;

/// In an increment between displacements `start` and `now`: once supports have moved the sides of a common plane
/// apart friction has been built up along it, which the next increment goes on from.
pub(super) fn is_moved<'a>(start: &'a [f64], now: &'a [f64]) -> impl Fn(usize, Wall) -> bool + 'a {
    let is_apart = |at: &[f64], axis: usize, wall: Wall| {
        let [own, other] = wall.map(|vertex| at[3 * vertex as usize + axis]);
        (own - other).abs() > SAME * (own.abs() + other.abs())
    };
    move |axis, wall| is_apart(start, axis, wall) || is_apart(now, axis, wall)
}

/// Of the functions of a carrier with faces that have the `functions`, of `count`; `other` is what it meets.
pub(super) fn tangents(
    ground: Ground<'_>,
    [carrier, other]: [&Skin; 2],
    (functions, count): (&[[u32; NODES]], usize),
) -> Vec<Tangents> {
    let mut all = vec![Tangents::default(); count];
    let planes = held_planes(ground, other);
    let near = SAME * ground.mesh.extent();
    for (number, (face, functions)) in (0..).zip(carrier.faces.iter().zip(functions)) {
        for (k, &function) in functions.iter().enumerate() {
            let Some(own) = all.get_mut(function as usize) else {
                continue;
            };
            if own.faces.is_empty() {
                own.ends = k
                    .checked_sub(3)
                    .map_or([k, (k + 1) % 3], |edge| EDGES[edge]);
                own.walls = walls(ground, (face.nodes[k], near), &planes);
            }
            own.faces.push(number);
        }
    }
    all
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

/// A vertex that moves as a held node does: what is held of an edge is its middle less the mean of its ends.
fn vertex(ground: Ground<'_>, node: u32) -> u32 {
    match (node as usize).checked_sub(ground.space.vertices) {
        None => node,
        Some(edge) => ground.mesh.edges()[edge][0],
    }
}

/// Nodes of a surface that are held along each axis, with their places along it, ascending.
fn held_planes(ground: Ground<'_>, skin: &Skin) -> [Vec<(f64, u32)>; 3] {
    let nodes = || skin.faces.iter().flat_map(|face| face.nodes);
    [0, 1, 2].map(|axis: usize| {
        let held = nodes().filter(|node| (ground.is_held)(3 * node + axis as u32));
        let mut places: Vec<_> = held
            .map(|node| (at_rest(ground, node)[axis], node))
            .collect();
        places.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        places
    })
}

/// Along which axes a node is held, and the other surface in the same plane.
fn walls(
    ground: Ground<'_>,
    (node, near): (u32, f64),
    planes: &[Vec<(f64, u32)>; 3],
) -> [Option<Wall>; 3] {
    let place = at_rest(ground, node);
    [0, 1, 2].map(|axis: usize| {
        if !(ground.is_held)(3 * node + axis as u32) {
            return None;
        }
        let first = planes[axis].partition_point(|(x, _)| *x < place[axis] - near);
        let met = planes[axis][first..].iter();
        let met = met.take_while(|(x, _)| *x <= place[axis] + near);
        // Of several bodies the one that is nearest, the first of equal ones.
        let distance = |&(_, other): &(f64, u32)| norm(sub(at_rest(ground, other), place));
        let nearest = met.min_by(|a, b| distance(a).total_cmp(&distance(b)));
        nearest.map(|&(_, other)| [node, other].map(|node| vertex(ground, node)))
    })
}

/// Tangents where faces are, with what their derivatives ask for.
#[derive(Clone, Copy, Debug)]
pub(super) struct TangentsAt<'a> {
    tangents: &'a Tangents,
    patches: &'a [Patch],
    /// N and |M|.
    normal: ([f64; 3], f64),
    kind: Kind,
}

/// How t_1 is found.
#[derive(Clone, Copy, Debug)]
enum Kind {
    /// Along an edge: t_1, d, |q|.
    Edge([f64; 3], [f64; 3], f64),
    /// In a plane that holds both surfaces along h: t_1, h, |M x h|.
    Wall([f64; 3], [f64; 3], f64),
    /// There is no face, or its edge runs along the normal.
    None,
}

impl<'a> TangentsAt<'a> {
    /// Of a function on a surface whose faces are `patches`.
    pub(super) fn new(tangents: &'a Tangents, patches: &'a [Patch]) -> Self {
        let areas = tangents.faces.iter().map(|&face| {
            let [u, v] = sides(&patches[face as usize]);
            cross(u, v)
        });
        let sum = areas.fold([0.0; 3], add);
        let size = norm(sum);
        let normal = scale(size.recip(), sum);
        Self {
            kind: kind(tangents, patches, (normal, size)),
            normal: (normal, size),
            tangents,
            patches,
        }
    }

    /// t_1 and t_2, zero along what holds both surfaces and does not move them apart.
    pub(super) fn frame(&self, is_moved: &IsMoved<'_>) -> Frame {
        let (Kind::Edge(first, ..) | Kind::Wall(first, ..)) = self.kind else {
            return [[0.0; 3]; 2];
        };
        let mut frame = [first, cross(self.normal.0, first)];
        for place in held_alike(self.tangents, frame, is_moved) {
            frame[place] = [0.0; 3];
        }
        frame
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
        for &face in &self.tangents.faces {
            let [u, v] = sides(&self.patches[face as usize]);
            let [a, b, c, ..] = skin.faces[face as usize].nodes;
            note(a, &|x| [cross(x, sub(u, v)), [0.0; 3]]);
            note(b, &|x| [cross(x, v), [0.0; 3]]);
            note(c, &|x| [cross(u, x), [0.0; 3]]);
        }
        if let Some(&face) = self.tangents.faces.first() {
            let nodes = skin.faces[face as usize].nodes;
            let [from, to] = self.tangents.ends.map(|end| nodes[end]);
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
                let slope = scale(length.recip(), without(cross(by_sum, h), first));
                let turn = scale(size.recip(), without(by_sum, n));
                let second = add(cross(turn, first), cross(n, slope));
                add(scale(s1, slope), scale(s2, second))
            }
            Kind::None => [0.0; 3],
        }
    }
}

/// Numbers of the tangents of a `frame` along which both surfaces are held and not moved apart.
pub(super) fn held_alike(
    tangents: &Tangents,
    [first, second]: Frame,
    is_moved: &IsMoved<'_>,
) -> impl Iterator<Item = usize> {
    let walls = across(tangents, cross(first, second));
    let held = [1, 0].into_iter().zip(walls);
    held.filter_map(|(place, (axis, wall))| (!is_moved(axis, wall)).then_some(place))
}

/// The axes across a normal along which both surfaces are held: of t_2, then of t_1.
fn across(tangents: &Tangents, normal: [f64; 3]) -> impl Iterator<Item = (usize, Wall)> {
    let walls = (0..).zip(tangents.walls);
    walls.filter_map(move |(axis, wall)| {
        let wall = wall.filter(|_| normal[axis].abs() < ALONG);
        wall.map(|wall| (axis, wall))
    })
}

fn kind(tangents: &Tangents, patches: &[Patch], (normal, size): ([f64; 3], f64)) -> Kind {
    let axis = |i: usize| [0, 1, 2].map(|j: usize| f64::from(u8::from(i == j)));
    let first = tangents.faces.first().map(|&face| &patches[face as usize]);
    match (first, across(tangents, normal).next()) {
        (Some(patch), None) => {
            let [from, to] = tangents.ends.map(|end| patch.nodes[end]);
            let d = sub(to, from);
            let q = without(d, normal);
            let length = norm(q);
            if length <= SAME * norm(d) {
                return Kind::None;
            }
            Kind::Edge(scale(length.recip(), q), d, length)
        }
        (Some(_), Some((wall, _))) => {
            let h = axis(wall);
            let along = cross(scale(size, normal), h);
            let length = norm(along);
            Kind::Wall(scale(length.recip(), along), h, length)
        }
        (None, _) => Kind::None,
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
