//! Rigid modes that supports leave free, part by part of a disconnected body.
//!
//! A mode is free when it vanishes at every held component. Rank by Gaussian
//! elimination of the 6 by 6 (plane: 3 by 3) moment matrix of the held rows. Of
//! the plane modes only the translation along its axis is rigid in a body of
//! revolution: the others stretch its hoops.

use std::collections::BTreeSet;

use super::{Faults, ResolvedPair, ResolvedSupport};
use crate::assembly::load::facet_measure;
use crate::contact::patches::outward;
use crate::mesh::{GroupKind, Mesh};
use crate::scene::{ContactPair, Scene, SceneKind};

const NAMES_3: [&str; 6] = [
    "translation along x",
    "translation along y",
    "translation along z",
    "rotation about x",
    "rotation about y",
    "rotation about z",
];
const NAMES_2: [&str; 3] = [
    "translation along x",
    "translation along y",
    "rotation about z",
];
/// Squared cosine under which a mode counts as free.
const ZERO: f64 = 1e-16;

/// What holds bodies.
#[derive(Clone, Copy)]
pub(crate) struct Held<'a> {
    pub(crate) supports: &'a [ResolvedSupport],
    pub(crate) ties: &'a [ResolvedPair],
}

impl<'a> Held<'a> {
    pub(crate) fn by(supports: &'a [ResolvedSupport], ties: &'a [ResolvedPair]) -> Self {
        Self { supports, ties }
    }
}

/// Names of free modes.
pub(crate) struct Free {
    /// Those that neither supports nor ties hold.
    pub(crate) modes: Vec<String>,
    /// Those that ties alone hold, body by body, and the others; empty without ties.
    pub(crate) alone: Vec<String>,
}

/// Names of the free modes; adds a fault when nothing can ever hold them.
pub(crate) fn check(
    (scene, kind): (&Scene, SceneKind),
    mesh: &Mesh,
    held: Held<'_>,
    faults: &mut Faults,
) -> Free {
    let supports = held.supports;
    let apart = Parts::new(mesh, &[]);
    let alone = match held.ties {
        [] => Vec::new(),
        _ => labelled(apart.free_of_parts(kind, apart.moments(supports))),
    };
    let parts = Parts::new(mesh, held.ties);
    let count = parts.frames.len();
    let moments = parts.moments(supports);
    let mut guided = moments.clone();
    parts.add_normals(supports, &mut guided);
    let meeting = meeting(scene, &parts);
    if !meeting.is_empty() {
        let of_parts = parts.free_of_parts(kind, moments.clone());
        refuse_loose((scene, &meeting), (&parts, of_parts), faults);
    }
    let free = labelled(parts.free_of_parts(kind, moments));
    let unguided = labelled(parts.free_of_parts(kind, guided));
    let has_contact = !scene.obstacles.is_empty() || !meeting.is_empty();
    if !unguided.is_empty() && !has_contact {
        let list = unguided.join(", ");
        faults.add("support", format!("nothing holds the body against {list}"));
    }
    let has_multipliers =
        has_contact || !scene.contacts.is_empty() || supports.iter().any(|s| !s.patches.is_empty());
    let may_meet = !meeting.is_empty();
    if !free.is_empty() && has_multipliers && count > 1 && !may_meet {
        let list = free.join(", ");
        faults.unsupported(
            "support",
            format!(
                "several bodies of which some are free ({list}): bodies that contact alone holds beside others are not solved yet; tie them, mesh them with common nodes, or hold each by supports of its own"
            ),
        );
    }
    Free { modes: free, alone }
}

/// Contacts between different parts: others hold nothing.
fn meeting<'a>(scene: &'a Scene, parts: &Parts<'_>) -> Vec<&'a ContactPair> {
    let of = |name: &String| -> BTreeSet<u32> {
        let group = parts.mesh.group(name, GroupKind::Facets);
        let facets = group.iter().flat_map(|group| &group.members);
        let corners = facets.filter_map(|&facet| parts.mesh.facet(facet as usize).first());
        let parts = corners.map(|&vertex| parts.of_vertex[vertex as usize]);
        parts.collect()
    };
    let is_within = |[first, second]: [BTreeSet<u32>; 2]| first.len() == 1 && first == second;
    let contacts = scene.contacts.iter();
    let apart =
        contacts.filter(|contact| !is_within([0, 1].map(|side: usize| of(&contact.between[side]))));
    apart.collect()
}

/// Refuses bodies with free modes `[parts]` that no contact and no obstacle meets.
fn refuse_loose(
    (scene, meeting): (&Scene, &[&ContactPair]),
    (parts, free): (&Parts<'_>, Vec<Vec<String>>),
    faults: &mut Faults,
) {
    let between = meeting.iter().flat_map(|contact| &contact.between);
    let obstacles = scene.obstacles.iter().flat_map(|obstacle| &obstacle.on);
    let groups = between.chain(obstacles);
    let facets = groups.filter_map(|name| parts.mesh.group(name, GroupKind::Facets));
    let facets = facets.flat_map(|group| &group.members);
    let corners = facets.filter_map(|&facet| parts.mesh.facet(facet as usize).first());
    let met: BTreeSet<u32> = corners
        .map(|&vertex| parts.of_vertex[vertex as usize])
        .collect();
    for (part, free) in (0..).zip(free) {
        if !free.is_empty() && !met.contains(&part) {
            let list = free.join(", ");
            let message =
                format!("nothing holds or meets part {part} of the mesh, which is free ({list})");
            faults.add("support", message);
        }
    }
}

/// Names of the free modes of all parts, which say of which one.
fn labelled(parts: Vec<Vec<String>>) -> Vec<String> {
    let count = parts.len();
    let of_part = |(part, found): (usize, Vec<String>)| {
        let label = match count {
            1 => String::new(),
            _ => format!(" of part {part}"),
        };
        found.into_iter().map(move |name| format!("{name}{label}"))
    };
    parts.into_iter().enumerate().flat_map(of_part).collect()
}

/// Holds the modes that stretch the hoops of a body of revolution.
fn hold_by_hoops(moments: &mut Moments) {
    for mode in [0, 2] {
        moments[mode][mode] += 1.0;
    }
}

/// Connected part of each vertex.
pub(crate) fn parts(mesh: &Mesh) -> Vec<u32> {
    let vertices = mesh.coordinates().len();
    let mut parent: Vec<u32> = (0..vertices as u32).collect();
    fn root(parent: &mut [u32], mut vertex: u32) -> u32 {
        while parent[vertex as usize] != vertex {
            let up = parent[parent[vertex as usize] as usize];
            parent[vertex as usize] = up;
            vertex = up;
        }
        vertex
    }
    for &[a, b] in mesh.edges() {
        let (a, b) = (root(&mut parent, a), root(&mut parent, b));
        let (low, high) = (a.min(b), a.max(b));
        parent[high as usize] = low;
    }
    let mut label = vec![u32::MAX; vertices];
    let mut next = 0;
    (0..vertices as u32)
        .map(|vertex| {
            let root = root(&mut parent, vertex) as usize;
            if label[root] == u32::MAX {
                label[root] = next;
                next += 1;
            }
            label[root]
        })
        .collect()
}

/// The same, tied parts being one.
pub(crate) fn joined_parts(mesh: &Mesh, ties: &[ResolvedPair]) -> Vec<u32> {
    joined(parts(mesh), mesh, ties)
}

/// Parts of vertices, tied ones with the lowest number among them, numbered without gaps.
fn joined(mut of_vertex: Vec<u32>, mesh: &Mesh, ties: &[ResolvedPair]) -> Vec<u32> {
    for tie in ties {
        let facets = tie.sides.iter().flatten();
        let vertices = facets.filter_map(|&facet| mesh.facet(facet as usize).first());
        let tied: BTreeSet<u32> = vertices.map(|&vertex| of_vertex[vertex as usize]).collect();
        if let Some(&first) = tied.first() {
            let own = of_vertex.iter_mut().filter(|part| tied.contains(*part));
            own.for_each(|part| *part = first);
        }
    }
    if ties.is_empty() {
        return of_vertex;
    }
    let mut left = of_vertex.clone();
    left.sort_unstable();
    left.dedup();
    let place = |part: &u32| left.partition_point(|other| other < part) as u32;
    of_vertex.iter().map(place).collect()
}

type Moments = [[f64; 6]; 6];

/// The connected parts of a body.
struct Parts<'a> {
    mesh: &'a Mesh,
    /// Part of each vertex.
    of_vertex: Vec<u32>,
    /// Centre and size of each part.
    frames: Vec<([f64; 3], f64)>,
}

impl<'a> Parts<'a> {
    /// Of `mesh`, those that are tied being one.
    fn new(mesh: &'a Mesh, ties: &[ResolvedPair]) -> Self {
        let of_vertex = joined_parts(mesh, ties);
        let count = of_vertex.iter().max().map_or(0, |&last| last as usize + 1);
        Self {
            mesh,
            frames: frames(mesh, &of_vertex, count),
            of_vertex,
        }
    }

    /// Names of the free modes of each part by the moment matrices of what is held.
    fn free_of_parts(&self, kind: SceneKind, mut moments: Vec<Moments>) -> Vec<Vec<String>> {
        let names: &[&str] = match kind {
            SceneKind::Solid => &NAMES_3,
            SceneKind::PlaneStrain | SceneKind::PlaneStress | SceneKind::Axisymmetric => &NAMES_2,
        };
        if kind == SceneKind::Axisymmetric {
            moments.iter_mut().for_each(hold_by_hoops);
        }
        let each = moments.into_iter();
        each.map(|own| name_null_space(own, names)).collect()
    }

    /// The part of a vertex and where in its frame the vertex lies.
    fn arm(&self, vertex: u32) -> (usize, [f64; 3]) {
        let part = self.of_vertex[vertex as usize] as usize;
        let (centre, radius) = self.frames[part];
        let x = self.mesh.coordinates()[vertex as usize];
        (part, std::array::from_fn(|i| (x[i] - centre[i]) / radius))
    }

    /// Moment matrix of the held rows of each part.
    fn moments(&self, supports: &[ResolvedSupport]) -> Vec<Moments> {
        let dimension = self.mesh.cell_kind().dimension();
        let mut moments = vec![[[0.0; 6]; 6]; self.frames.len()];
        for support in supports {
            for &facet in &support.facets {
                for &vertex in self.mesh.facet(facet as usize) {
                    let (part, arm) = self.arm(vertex);
                    for component in (0..dimension).filter(|&i| support.displacement[i].is_some()) {
                        add_product(&mode_row(dimension, component, arm), &mut moments[part]);
                    }
                }
            }
            for plane in &support.planes {
                let corners = plane.facets.iter();
                for &vertex in corners.flat_map(|&facet| self.mesh.facet(facet as usize)) {
                    let (part, arm) = self.arm(vertex);
                    add_product(&mode_row(dimension, plane.axis, arm), &mut moments[part]);
                }
            }
            for plane in &support.oblique {
                let corners = plane.facets.iter();
                for &vertex in corners.flat_map(|&facet| self.mesh.facet(facet as usize)) {
                    self.add_along(plane.normal, vertex, &mut moments);
                }
            }
        }
        moments
    }

    /// Adds the rows of supports that hold a normal component.
    fn add_normals(&self, supports: &[ResolvedSupport], moments: &mut [Moments]) {
        for &facet in supports.iter().flat_map(|support| {
            let oblique = support.oblique.iter().map(|plane| &plane.facets);
            support.patches.iter().chain(oblique).flatten()
        }) {
            let corners = outward(self.mesh, facet);
            let (_, normal) = facet_measure(self.mesh, &corners, 1.0);
            for &vertex in &corners {
                self.add_along(normal, vertex, moments);
            }
        }
    }

    /// Adds the row of a vertex that is held along `normal`.
    fn add_along(&self, normal: [f64; 3], vertex: u32, moments: &mut [Moments]) {
        let dimension = self.mesh.cell_kind().dimension();
        let (part, arm) = self.arm(vertex);
        let mut row = vec![0.0; moments[part].len()];
        for (component, along) in normal.iter().enumerate().take(dimension) {
            for (sum, value) in row.iter_mut().zip(mode_row(dimension, component, arm)) {
                *sum += along * value;
            }
        }
        add_product(&row, &mut moments[part]);
    }
}

/// Adds the product of a row with itself.
fn add_product(row: &[f64], moments: &mut Moments) {
    for (i, a) in row.iter().enumerate() {
        for (j, b) in row.iter().enumerate() {
            moments[i][j] += a * b;
        }
    }
}

/// Values of all modes at one component.
fn mode_row(dimension: usize, component: usize, arm: [f64; 3]) -> Vec<f64> {
    if dimension == 2 {
        let mut row = vec![0.0; 3];
        row[component] = 1.0;
        row[2] = if component == 0 { -arm[1] } else { arm[0] };
        return row;
    }
    let mut row = vec![0.0; 6];
    row[component] = 1.0;
    for axis in 0..3 {
        // e_axis x arm, component `component`.
        let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
        row[3 + axis] = match component {
            c if c == j => -arm[k],
            c if c == k => arm[j],
            _ => 0.0,
        };
    }
    row
}

/// Centre and size of the bounding box of each part.
fn frames(mesh: &Mesh, parts: &[u32], count: usize) -> Vec<([f64; 3], f64)> {
    let mut boxes = vec![([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]); count];
    for (x, &part) in mesh.coordinates().iter().zip(parts) {
        let (low, high) = &mut boxes[part as usize];
        for i in 0..3 {
            low[i] = low[i].min(x[i]);
            high[i] = high[i].max(x[i]);
        }
    }
    let frame = |(low, high): ([f64; 3], [f64; 3])| {
        let centre = std::array::from_fn(|i| 0.5 * (low[i] + high[i]));
        let radius = (0..3).map(|i| high[i] - low[i]).fold(0.0, f64::max);
        (centre, if radius > 0.0 { radius } else { 1.0 })
    };
    boxes.into_iter().map(frame).collect()
}

/// Axis-aligned free modes by name, further ones by number.
fn name_null_space(mut moments: Moments, names: &[&str]) -> Vec<String> {
    let size = names.len();
    let largest = (0..size).map(|i| moments[i][i]).fold(0.0, f64::max);
    let threshold = ZERO.max(1e-12 * largest);
    let mut free: Vec<String> = (0..size)
        .filter(|&i| moments[i][i] <= threshold)
        .map(|i| names[i].to_owned())
        .collect();
    let mut rank = 0;
    let mut left: Vec<usize> = (0..size).collect();
    while let Some(position) = (0..left.len())
        .max_by(|&a, &b| moments[left[a]][left[a]].total_cmp(&moments[left[b]][left[b]]))
    {
        let pivot = left.swap_remove(position);
        let value = moments[pivot][pivot];
        if value <= threshold {
            break;
        }
        rank += 1;
        for &i in &left {
            let factor = moments[i][pivot] / value;
            for &j in &left {
                moments[i][j] -= factor * moments[pivot][j];
            }
        }
    }
    let unnamed = (size - rank).saturating_sub(free.len());
    if unnamed > 0 {
        free.push(format!("{unnamed} combined rigid mode(s)"));
    }
    free
}
