//! Rigid modes that supports leave free, part by part of a disconnected body.
//!
//! A mode is free when it vanishes at every held component. Rank by Gaussian
//! elimination of the 6 by 6 (plane: 3 by 3) moment matrix of the held rows. Of
//! the plane modes only the translation along its axis is rigid in a body of
//! revolution: the others stretch its hoops.

use super::Faults;
use crate::mesh::Mesh;
use crate::scene::{Scene, SceneKind};

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

/// Names of the free modes; adds a fault when nothing can ever hold them.
pub(crate) fn check(
    scene: &Scene,
    kind: SceneKind,
    mesh: &Mesh,
    support_facets: &[Vec<u32>],
    faults: &mut Faults,
) -> Vec<String> {
    let parts = parts(mesh);
    let count = parts.iter().max().map_or(0, |&last| last as usize + 1);
    let frames = frames(mesh, &parts, count);
    let mut moments = moments(scene, mesh, support_facets, &parts, &frames);
    let names: &[&str] = match kind {
        SceneKind::Solid => &NAMES_3,
        SceneKind::PlaneStrain | SceneKind::Axisymmetric => &NAMES_2,
    };
    if kind == SceneKind::Axisymmetric {
        moments.iter_mut().for_each(hold_by_hoops);
    }
    let mut free = Vec::new();
    for (part, moments) in moments.into_iter().enumerate() {
        let label = match count {
            1 => String::new(),
            _ => format!(" of part {part}"),
        };
        let found = name_null_space(moments, names);
        free.extend(found.into_iter().map(|name| format!("{name}{label}")));
    }
    if !free.is_empty() && scene.obstacles.is_empty() {
        let list = free.join(", ");
        faults.add("support", format!("nothing holds the body against {list}"));
    }
    if !free.is_empty() && !scene.obstacles.is_empty() && count > 1 {
        let list = free.join(", ");
        faults.unsupported(
            "support",
            format!("several bodies of which some are free ({list})"),
        );
    }
    free
}

/// Holds the modes that stretch the hoops of a body of revolution.
fn hold_by_hoops(moments: &mut Moments) {
    for mode in [0, 2] {
        moments[mode][mode] += 1.0;
    }
}

/// Connected part of each vertex.
fn parts(mesh: &Mesh) -> Vec<u32> {
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

type Moments = [[f64; 6]; 6];

/// Moment matrix of the held rows of each part.
fn moments(
    scene: &Scene,
    mesh: &Mesh,
    support_facets: &[Vec<u32>],
    parts: &[u32],
    frames: &[([f64; 3], f64)],
) -> Vec<Moments> {
    let dimension = mesh.cell_kind().dimension();
    let mut moments = vec![[[0.0; 6]; 6]; frames.len()];
    for (support, facets) in scene.supports.iter().zip(support_facets) {
        for &facet in facets {
            for &vertex in mesh.facet(facet as usize) {
                let part = parts[vertex as usize] as usize;
                let (centre, radius) = frames[part];
                let x = mesh.coordinates()[vertex as usize];
                let arm: [f64; 3] = std::array::from_fn(|i| (x[i] - centre[i]) / radius);
                for component in (0..dimension).filter(|&i| support.displacement[i].is_some()) {
                    let row = mode_row(dimension, component, arm);
                    for (i, a) in row.iter().enumerate() {
                        for (j, b) in row.iter().enumerate() {
                            moments[part][i][j] += a * b;
                        }
                    }
                }
            }
        }
    }
    moments
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
