//! What lies opposite to the nodes of the surface of a contact that does not carry its pressure: the
//! nearest place on the one that does, by the nodes beside it,
//!
//! ```text
//! foot = sum over k of s_k x_k,   s_k >= 0,   sum of s_k = 1
//! ```
//!
//! x_k the places of the nodes of the part of a face that holds it, a face parted by its middles into
//! straight parts. Surfaces have to face each other, and be no farther than a face of either is long.
//! Where meshes match the foot is a node: shares of rounding are none. Places in any one unit. Cost:
//! a tree of the faces, and a few of them a node.

use std::collections::BTreeMap;

use super::tree::{Bounds, BoxTree};
use crate::contact::patches::outward;
use crate::geometry::vector3::{add, cross, dot, norm, normalised, scale, sub};
use crate::mesh::Mesh;
use crate::space::TaylorHood;

/// Parts of a segment's nodes: corners, then the middle.
const SEGMENT: &[&[usize]] = &[&[0, 2], &[2, 1]];
/// Parts of a triangle's: corners, then the middles of (0, 1), (0, 2), (1, 2).
const TRIANGLE: &[&[usize]] = &[&[0, 3, 4], &[3, 1, 5], &[4, 5, 2], &[3, 5, 4]];
/// Shares, and ways over the size of a face, that are rounding; chosen.
const ROUNDING: f64 = 1e-6;
/// Depth inside the carrier over the size of a face up to which a node is at its surface, not behind
/// the wall; chosen.
const DEEPEST: f64 = 0.25;

/// A node of the surface that does not carry, and where it is on the one that does.
#[derive(Clone, Debug, PartialEq)]
pub struct Opposite {
    /// The node.
    pub node: u32,
    /// Nodes of the carrier beside the foot, with their shares above zero.
    pub on: Vec<(u32, f64)>,
    /// Whether it lies before the carrier, not beyond an end of it.
    pub is_before: bool,
}

/// Places of nodes.
type Place<'a> = &'a dyn Fn(u32) -> [f64; 3];

/// A face where it is.
struct Face {
    /// Corners, then edges.
    nodes: Vec<u32>,
    /// Unit normal; zero where it has no extent.
    outward: [f64; 3],
    bounds: Bounds,
    size: f64,
}

impl Face {
    fn new((mesh, space): (&Mesh, &TaylorHood), facet: u32, place: Place<'_>) -> Self {
        let vertices = outward(mesh, facet);
        let nodes = space.facet_nodes(&vertices);
        let corners: Vec<[f64; 3]> = vertices.iter().map(|&vertex| place(vertex)).collect();
        let normal = match corners[..] {
            [a, b] => {
                let along = sub(b, a);
                [along[1], -along[0], 0.0]
            }
            [a, b, c] => cross(sub(b, a), sub(c, a)),
            _ => [0.0; 3],
        };
        let bounds = Bounds::of(nodes.iter().map(|&node| place(node)));
        Self {
            outward: normalised(normal).unwrap_or_default(),
            size: bounds.diagonal(),
            bounds,
            nodes,
        }
    }

    fn parts(&self) -> impl Iterator<Item = Vec<u32>> + '_ {
        let parts = if self.nodes.len() == 3 {
            SEGMENT
        } else {
            TRIANGLE
        };
        let parts = parts.iter();
        parts.map(|own| own.iter().map(|&k| self.nodes[k]).collect())
    }
}

/// How a node looks for what is opposite.
#[derive(Clone, Copy, Debug, Default)]
struct Look {
    /// Sum of the normals of its faces.
    normal: [f64; 3],
    /// Size of the largest of them.
    size: f64,
}

/// What lies opposite to the nodes of the facets `other`, on the facets `carrier`, ascending by node.
pub fn opposite(
    ground: (&Mesh, &TaylorHood),
    [carrier, other]: [&[u32]; 2],
    place: Place<'_>,
) -> Vec<Opposite> {
    let faces = |facets: &[u32]| -> Vec<Face> {
        let facets = facets.iter();
        facets
            .map(|&facet| Face::new(ground, facet, place))
            .collect()
    };
    let [carrier, other] = [carrier, other].map(faces);
    let mut looks: BTreeMap<u32, Look> = BTreeMap::new();
    for face in &other {
        for &node in &face.nodes {
            let look = looks.entry(node).or_default();
            look.normal = add(look.normal, face.outward);
            look.size = look.size.max(face.size);
        }
    }
    let widest = carrier.iter().map(|face| face.size).fold(0.0, f64::max);
    let tree = BoxTree::new(carrier.iter().map(|face| face.bounds).collect());
    let found = looks.into_iter().filter_map(|(node, look)| {
        let at = place(node);
        let reach = [look.size.max(widest); 3];
        let region = Bounds {
            low: sub(at, reach),
            high: add(at, reach),
        };
        let near = tree.meeting(&region).into_iter();
        let near = near.filter_map(|face| carrier.get(face as usize));
        nearest((node, at), look, near, place)
    });
    found.collect()
}

/// The nearest place on faces that face the node.
fn nearest<'a>(
    (node, at): (u32, [f64; 3]),
    look: Look,
    faces: impl Iterator<Item = &'a Face>,
    place: Place<'_>,
) -> Option<Opposite> {
    let facing = faces.filter(|face| dot(face.outward, look.normal) < 0.0);
    let parts = facing.flat_map(|face| face.parts().map(move |part| (face, part)));
    let feet = parts.map(|(face, part)| {
        let corners: Vec<[f64; 3]> = part.iter().map(|&node| place(node)).collect();
        let shares = foot(at, &corners);
        let pairs = shares.iter().zip(&corners);
        let point = pairs.fold([0.0; 3], |sum, (&s, &x)| add(sum, scale(s, x)));
        (face, part, shares, sub(at, point))
    });
    let (face, part, shares, way) = feet
        .filter(|(face, _, _, way)| {
            let size = look.size.max(face.size);
            norm(*way) <= size && dot(*way, face.outward) >= -DEEPEST * size
        })
        .min_by(|a, b| norm(a.3).total_cmp(&norm(b.3)))?;
    let along = dot(way, face.outward);
    let beside = norm(sub(way, scale(along, face.outward)));
    let on = part.into_iter().zip(shares);
    Some(Opposite {
        node,
        on: on.filter(|(_, share)| *share > ROUNDING).collect(),
        is_before: beside <= along.abs().max(ROUNDING * face.size),
    })
}

/// Shares of the corners of a segment or a triangle in its nearest place to `x`.
fn foot(x: [f64; 3], corners: &[[f64; 3]]) -> Vec<f64> {
    match *corners {
        [a, b] => on_segment(x, [a, b]).to_vec(),
        [a, b, c] => on_triangle(x, [a, b, c]).to_vec(),
        _ => vec![1.0; corners.len().min(1)],
    }
}

fn on_segment(x: [f64; 3], [a, b]: [[f64; 3]; 2]) -> [f64; 2] {
    let along = sub(b, a);
    let length = dot(along, along);
    let share = if length > 0.0 {
        (dot(sub(x, a), along) / length).clamp(0.0, 1.0)
    } else {
        0.0
    };
    [1.0 - share, share]
}

/// Inside by the areas opposite to the corners, else on the nearest side.
fn on_triangle(x: [f64; 3], corners: [[f64; 3]; 3]) -> [f64; 3] {
    let [a, b, c] = corners;
    let normal = cross(sub(b, a), sub(c, a));
    let doubled = dot(normal, normal);
    let area = |p: [f64; 3], q: [f64; 3]| dot(cross(sub(q, p), sub(x, p)), normal) / doubled;
    let areas = [area(b, c), area(c, a), area(a, b)];
    if doubled > 0.0 && areas.iter().all(|area| *area >= 0.0) {
        return areas;
    }
    let sides = [[0, 1], [1, 2], [2, 0]].map(|[i, j]: [usize; 2]| {
        let [s, t] = on_segment(x, [corners[i], corners[j]]);
        let mut shares = [0.0; 3];
        shares[i] = s;
        shares[j] = t;
        let point = add(scale(s, corners[i]), scale(t, corners[j]));
        (norm(sub(x, point)), shares)
    });
    let least = sides.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    least.map_or([1.0, 0.0, 0.0], |(_, shares)| shares)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::vector::reproducible_noise;
    use crate::mesh::{GroupKind, samples};

    fn group(mesh: &Mesh, name: &str) -> Vec<u32> {
        let group = mesh.group(name, GroupKind::Facets).expect("a side");
        group.members.clone()
    }

    #[test]
    fn a_foot_is_the_nearest_of_many_places() {
        for numbers in reproducible_noise(12 * 200).chunks_exact(12) {
            let points: Vec<[f64; 3]> = numbers.chunks(3).map(|p| [p[0], p[1], p[2]]).collect();
            let (x, corners) = (points[0], &points[1..]);
            let at = |shares: &[f64]| {
                let pairs = shares.iter().zip(corners);
                let point = pairs.fold([0.0; 3], |sum, (&s, &c)| add(sum, scale(s, c)));
                norm(sub(x, point))
            };
            let found = foot(x, corners);
            assert!((found.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            let grid = (0..=20).flat_map(|i| (0..=20 - i).map(move |j| (i, j)));
            let all = grid.map(|(i, j)| [i, j, 20 - i - j].map(|k| f64::from(k) / 20.0));
            let least = all.map(|shares| at(&shares)).fold(f64::INFINITY, f64::min);
            assert!(at(&found) <= least + 1e-12, "{} {least}", at(&found));
        }
    }

    /// Top and bottom of a strip, which do not meet as they are, but where the top is moved below.
    #[test]
    fn nodes_that_match_have_one_node_opposite_where_surfaces_face_each_other() {
        let mesh = samples::rectangle(4, 1);
        let space = TaylorHood::new(&mesh);
        let [bottom, top] = ["y0", "y1"].map(|name| group(&mesh, name));
        let still = |node: u32| space.node_place(&mesh, node);
        let sides = [&bottom[..], &top[..]];
        assert!(opposite((&mesh, &space), sides, &still).is_empty());
        // The top a little under the bottom looks up at it.
        let folded = |node: u32| {
            let [x, y, z] = still(node);
            if y > 0.99 { [x, -1e-3, z] } else { [x, y, z] }
        };
        let found = opposite((&mesh, &space), sides, &folded);
        assert_eq!(found.len(), 9);
        for one in &found {
            assert!(one.is_before && one.on.len() == 1, "{one:?}");
            let [x, foot] = [one.node, one.on[0].0].map(|node| still(node)[0]);
            assert!((x - foot).abs() < 1e-12);
        }
    }

    #[test]
    fn what_lies_beyond_an_end_is_not_before_it() {
        let mesh = samples::rectangle(4, 1);
        let space = TaylorHood::new(&mesh);
        let [bottom, top] = ["y0", "y1"].map(|name| group(&mesh, name));
        let moved = |node: u32| {
            let [x, y, z] = space.node_place(&mesh, node);
            if y > 0.99 {
                [x + 0.1, 0.0, z]
            } else {
                [x, y, z]
            }
        };
        let found = opposite((&mesh, &space), [&bottom, &top], &moved);
        let beyond: Vec<f64> = found
            .iter()
            .filter(|one| !one.is_before)
            .map(|one| moved(one.node)[0])
            .collect();
        assert_eq!(beyond.len(), 1, "{beyond:?}");
        let shares = found
            .iter()
            .map(|one| one.on.iter().map(|(_, s)| s).sum::<f64>());
        assert!(shares.into_iter().all(|sum| (sum - 1.0).abs() < 1e-5));
    }
}
