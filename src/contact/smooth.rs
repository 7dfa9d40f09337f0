//! The smooth surface that flat facets stand for: normals fitted at the vertices, and the
//! offset of each edge whose arc is normal to both,
//!
//! ```text
//! n_a ~ sum over facets at a of (e_1 x e_2) / (|e_1|^2 |e_2|^2)     (in the plane: of normal / length)
//! o_e = m |d| / 2 tan(t / 4),   tan(t / 2) = (n_b - n_a) . d / (|d| |n_a + n_b|),   m ~ n_a + n_b
//! ```
//!
//! d from a to b, t the angle between the normals: exact where the vertices lie on a circle
//! or a sphere (Max, Journal of Graphics Tools 4 (1999), on the weights). Facets are joined
//! where their normals differ by at most 30 degrees; beyond, each side has its own normals.
//! At the rim of a patch, where facets are missing, the normal is the one that makes arcs
//! with those of the neighbours, (n_a + n_b) . d = 0 in the mean of squares: exact on circles,
//! spheres and cylinders, so that a rim on a symmetry plane does not tilt.
//! Cost: one sort of the edges of the facets.

use std::collections::BTreeMap;

use super::patches::{outward, smooth_patches};
use crate::assembly::load::facet_measure;
use crate::geometry::vector3::{add, cross, dot, norm, normalised, scale, sub};
use crate::mesh::{EdgeOffset, Mesh};

/// Offset over the length of its edge below which the edge is a line.
const STRAIGHT: f64 = 1e-9;
/// Turns of a normal at the rim: each cubes what is left of its tilt.
const TURNS: usize = 3;
/// Determinant over squared trace of the directions to neighbours that fix a normal; 1/4
/// where they are at right angles.
const SPREAD: f64 = 0.02;

/// Offsets of the edges of `facets` in units of the mesh, ascending by their ends. Where
/// two patches meet, the larger one counts.
pub fn smooth_offsets(mesh: &Mesh, facets: &[u32]) -> Vec<EdgeOffset> {
    let mut found: BTreeMap<[u32; 2], [f64; 3]> = BTreeMap::new();
    for patch in smooth_patches(mesh, facets) {
        let patch = Patch::new(mesh, &patch);
        let normals = patch.normals();
        for &ends in patch.edges.keys() {
            let [Some(of_a), Some(of_b)] = ends.map(|end| normals.get(&end)) else {
                continue;
            };
            let along = patch.along(ends);
            let Some(offset) = arc(along, *of_a, *of_b) else {
                continue;
            };
            let kept = found.entry(ends).or_insert(offset);
            if norm(offset) > norm(*kept) {
                *kept = offset;
            }
        }
    }
    let offsets = found.into_iter();
    offsets
        .map(|(ends, offset)| EdgeOffset { ends, offset })
        .collect()
}

/// Of each facet the largest distance of an edge from its arc, in units of the mesh; empty
/// where all edges are lines.
pub fn sagittas(mesh: &Mesh, facets: &[u32]) -> Vec<f64> {
    let normals = facets.iter().map(|&facet| {
        let vertices = outward(mesh, facet);
        facet_measure(mesh, &vertices, 1.0).1
    });
    if is_flat(normals) {
        return Vec::new();
    }
    let offsets = smooth_offsets(mesh, facets);
    if offsets.is_empty() {
        return Vec::new();
    }
    let sagitta = |a: u32, b: u32| {
        let ends = [a.min(b), a.max(b)];
        let found = offsets.binary_search_by_key(&ends, |one| one.ends);
        found.map_or(0.0, |place| norm(offsets[place].offset))
    };
    let of_facet = |&facet: &u32| {
        let vertices = mesh.facet(facet as usize).iter().enumerate();
        let pairs = vertices.flat_map(|(i, a)| {
            let later = &mesh.facet(facet as usize)[i + 1..];
            later.iter().map(move |b| (*a, *b))
        });
        pairs.map(|(a, b)| sagitta(a, b)).fold(0.0, f64::max)
    };
    facets.iter().map(of_facet).collect()
}

/// Whether all normals are the same to rounding, so that there is nothing to fit.
fn is_flat(mut normals: impl Iterator<Item = [f64; 3]>) -> bool {
    let first = normals.next();
    first.is_none_or(|first| normals.all(|normal| norm(sub(normal, first)) < STRAIGHT))
}

/// Middle of the arc over `along` with those normals at its ends, less the middle of the
/// line; none for a line.
fn arc(along: [f64; 3], of_a: [f64; 3], of_b: [f64; 3]) -> Option<[f64; 3]> {
    let both = add(of_a, of_b);
    let length = norm(along);
    let half = dot(sub(of_b, of_a), along) / (length * norm(both));
    let quarter = half / (1.0 + (1.0 + half * half).sqrt());
    // The mean normal has a part along the edge where the arc is not symmetric.
    let unit = scale(1.0 / length, along);
    let across = normalised(sub(both, scale(dot(both, unit), unit)))?;
    let offset = scale(0.5 * length * quarter, across);
    (norm(offset) > STRAIGHT * length).then_some(offset)
}

/// Facets whose normals go over into each other.
struct Patch<'a> {
    mesh: &'a Mesh,
    /// Vertices of the facets, normals outwards.
    facets: Vec<Vec<u32>>,
    /// Number of facets at each edge, lower vertex first.
    edges: BTreeMap<[u32; 2], u32>,
}

impl<'a> Patch<'a> {
    fn new(mesh: &'a Mesh, facets: &[u32]) -> Self {
        let facets: Vec<Vec<u32>> = facets.iter().map(|&f| outward(mesh, f)).collect();
        let mut edges = BTreeMap::new();
        for facet in &facets {
            for (i, &a) in facet.iter().enumerate() {
                for &b in &facet[i + 1..] {
                    *edges.entry([a.min(b), a.max(b)]).or_insert(0) += 1;
                }
            }
        }
        Self {
            mesh,
            facets,
            edges,
        }
    }

    fn along(&self, [a, b]: [u32; 2]) -> [f64; 3] {
        let at = |vertex: u32| self.mesh.coordinates()[vertex as usize];
        sub(at(b), at(a))
    }

    /// Unit normals by vertex.
    fn normals(&self) -> BTreeMap<u32, [f64; 3]> {
        let fitted = self.fitted();
        let rim = self.rim();
        let mut normals = fitted.clone();
        normals.retain(|vertex, _| !rim.contains_key(vertex));
        let mut open: Vec<u32> = rim.keys().copied().collect();
        // From the inside outwards, a layer of vertices at a time; those whose neighbours
        // leave a direction open wait for more of them.
        while !open.is_empty() {
            let turn = |vertex: &u32| {
                let own = (*vertex, *fitted.get(vertex)?);
                Some((*vertex, self.settled(own, rim.get(vertex)?, &normals)?))
            };
            let found: Vec<(u32, Turned)> = open.iter().filter_map(turn).collect();
            let is_any_sure = found.iter().any(|(_, turned)| turned.is_sure);
            let taken = found
                .iter()
                .filter(|(_, turned)| turned.is_sure || !is_any_sure);
            if found.is_empty() {
                break;
            }
            normals.extend(taken.map(|(vertex, turned)| (*vertex, turned.normal)));
            open.retain(|vertex| !normals.contains_key(vertex));
        }
        for vertex in open {
            normals.extend(fitted.get(&vertex).map(|normal| (vertex, *normal)));
        }
        normals
    }

    /// Means of the normals of the facets around each vertex.
    fn fitted(&self) -> BTreeMap<u32, [f64; 3]> {
        let mut sums: BTreeMap<u32, [f64; 3]> = BTreeMap::new();
        for facet in &self.facets {
            for (place, &vertex) in facet.iter().enumerate() {
                let next = facet[(place + 1) % facet.len()];
                let part = match facet[..] {
                    [a, b] => {
                        let along = self.along([a, b]);
                        scale(1.0 / dot(along, along), [along[1], -along[0], 0.0])
                    }
                    _ => {
                        let last = facet[(place + 2) % facet.len()];
                        let (first, second) =
                            (self.along([vertex, next]), self.along([vertex, last]));
                        let weight = dot(first, first) * dot(second, second);
                        scale(1.0 / weight, cross(first, second))
                    }
                };
                let sum = sums.entry(vertex).or_default();
                *sum = add(*sum, part);
            }
        }
        let unit = |(vertex, sum)| Some((vertex, normalised(sum)?));
        sums.into_iter().filter_map(unit).collect()
    }

    /// The vertices around which facets are missing, with their neighbours.
    fn rim(&self) -> BTreeMap<u32, Vec<u32>> {
        let mut count: BTreeMap<u32, usize> = BTreeMap::new();
        let is_plane = self.mesh.cell_kind().dimension() == 2;
        let mut rim: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for (&[a, b], &facets) in &self.edges {
            for end in [a, b] {
                *count.entry(end).or_default() += 1;
                if !is_plane && facets == 1 {
                    rim.entry(end).or_default();
                }
            }
        }
        if is_plane {
            let ends = count.iter().filter(|(_, edges)| **edges == 1);
            rim = ends.map(|(&end, _)| (end, Vec::new())).collect();
        }
        for &[a, b] in self.edges.keys() {
            for (end, other) in [(a, b), (b, a)] {
                if let Some(neighbours) = rim.get_mut(&end) {
                    neighbours.push(other);
                }
            }
        }
        rim
    }

    /// [`Patch::turned`] until it stays.
    fn settled(
        &self,
        (vertex, normal): (u32, [f64; 3]),
        neighbours: &[u32],
        known: &BTreeMap<u32, [f64; 3]>,
    ) -> Option<Turned> {
        let mut turned = self.turned((vertex, normal), neighbours, known)?;
        // A tilt leaves the sphere of unit vectors to second order.
        for _ in 1..TURNS {
            turned = self.turned((vertex, turned.normal), neighbours, known)?;
        }
        Some(turned)
    }

    /// `normal` of a vertex turned so that it makes arcs with the normals of its known
    /// neighbours; none without any.
    fn turned(
        &self,
        (vertex, normal): (u32, [f64; 3]),
        neighbours: &[u32],
        known: &BTreeMap<u32, [f64; 3]>,
    ) -> Option<Turned> {
        let [first, second] = tangents(normal);
        let (mut matrix, mut right) = ([0.0; 3], [0.0; 2]);
        let mut is_known = false;
        for &other in neighbours {
            let Some(&of_other) = known.get(&other) else {
                continue;
            };
            is_known = true;
            let unit = normalised(self.along([vertex, other]))?;
            let (a, b) = (dot(first, unit), dot(second, unit));
            let miss = dot(add(normal, of_other), unit);
            matrix = [matrix[0] + a * a, matrix[1] + a * b, matrix[2] + b * b];
            right = [right[0] - a * miss, right[1] - b * miss];
        }
        // A direction along which no neighbour lies keeps its tilt.
        let floor = 1e-9 * (matrix[0] + matrix[2]);
        let [aa, ab, bb] = [matrix[0] + floor, matrix[1], matrix[2] + floor];
        let size = aa * bb - ab * ab;
        let tilt = add(
            scale((bb * right[0] - ab * right[1]) / size, first),
            scale((aa * right[1] - ab * right[0]) / size, second),
        );
        let is_plane = self.mesh.cell_kind().dimension() == 2;
        let spread = matrix[0] * matrix[2] - ab * ab;
        let turned = Turned {
            normal: normalised(add(normal, tilt))?,
            is_sure: is_plane || spread > SPREAD * (matrix[0] + matrix[2]).powi(2),
        };
        is_known.then_some(turned)
    }
}

/// A normal at the rim.
struct Turned {
    normal: [f64; 3],
    /// Whether the neighbours fix it in every direction.
    is_sure: bool,
}

/// Two unit vectors across `normal` and each other; in the plane one of them leaves it.
fn tangents(normal: [f64; 3]) -> [[f64; 3]; 2] {
    let axis = if normal[2].abs() < 0.7 {
        [0.0, 0.0, 1.0]
    } else {
        [1.0, 0.0, 0.0]
    };
    let first = normalised(cross(axis, normal)).unwrap_or(axis);
    [first, cross(normal, first)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{GroupKind, MeshParts, samples};

    fn facets(mesh: &Mesh, names: &[&str]) -> Vec<u32> {
        let groups = names.iter().map(|name| {
            let group = mesh.group(name, GroupKind::Facets).expect("a side");
            group.members.clone()
        });
        groups.flatten().collect()
    }

    fn bent(mut parts: MeshParts, place: impl Fn([f64; 3]) -> [f64; 3]) -> Mesh {
        parts.coordinates.iter_mut().for_each(|x| *x = place(*x));
        Mesh::new(parts).expect("a valid mesh")
    }

    /// Distance of the middle of each edge from the origin, by the first `axes`.
    fn radii(mesh: &Mesh, offsets: &[EdgeOffset], axes: usize) -> Vec<f64> {
        let radius = |one: &EdgeOffset| {
            let [a, b] = one.ends.map(|end| mesh.coordinates()[end as usize]);
            let middle = add(scale(0.5, add(a, b)), one.offset);
            norm(std::array::from_fn(
                |i| if i < axes { middle[i] } else { 0.0 },
            ))
        };
        offsets.iter().map(radius).collect()
    }

    #[test]
    fn the_sides_of_a_cube_are_flat() {
        let mesh = samples::cube(3);
        let all = facets(&mesh, &["z1", "x0", "y1"]);
        assert!(smooth_offsets(&mesh, &all).is_empty());
        let plane = samples::rectangle(3, 3);
        assert!(smooth_offsets(&plane, &facets(&plane, &["y0", "x1"])).is_empty());
    }

    #[test]
    fn an_arc_of_unequal_segments_is_its_circle_up_to_the_rim() {
        let mesh = bent(samples::rectangle_parts(5, 1), |[x, y, _]| {
            let angle = 0.3 + 1.1 * x + 0.2 * x * x;
            [(2.0 - y) * angle.cos(), (2.0 - y) * angle.sin(), 0.0]
        });
        let offsets = smooth_offsets(&mesh, &facets(&mesh, &["y0"]));
        assert_eq!(offsets.len(), 5);
        for radius in radii(&mesh, &offsets, 2) {
            assert!((radius - 2.0).abs() < 1e-6, "{radius}");
        }
    }

    #[test]
    fn a_part_of_a_sphere_is_its_sphere_up_to_the_rim() {
        let mesh = bent(samples::cube_parts(4), |[x, y, z]| {
            let direction = [0.6 * (x - 0.3), 0.5 * (y - 0.4) + 0.1 * x, 1.0];
            let size = norm(direction);
            direction.map(|d| (1.0 + z) * d / size)
        });
        let top = facets(&mesh, &["z1"]);
        let offsets = smooth_offsets(&mesh, &top);
        assert_eq!(offsets.len(), 16 * 3 + 8);
        for radius in radii(&mesh, &offsets, 3) {
            assert!((radius - 2.0).abs() < 1e-6, "{radius}");
        }
    }

    #[test]
    fn a_rounded_end_keeps_its_flat_neighbour_flat() {
        // A cylinder wall over z, between two flat ends.
        let mesh = bent(samples::cube_parts(4), |[x, y, z]| {
            let (radius, angle) = (1.0 + x, 0.2 + y);
            [radius * angle.cos(), radius * angle.sin(), z]
        });
        let offsets = smooth_offsets(&mesh, &facets(&mesh, &["x1", "z1"]));
        assert!(offsets.iter().all(|one| one.offset[2].abs() < 1e-6));
        let error = radii(&mesh, &offsets, 2).into_iter();
        let error = error.map(|radius| (radius - 2.0).abs()).fold(0.0, f64::max);
        assert!(error < 4e-4, "{error}");
    }
}
