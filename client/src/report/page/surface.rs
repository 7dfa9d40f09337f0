//! The surface of the last body of a series, its fields, and the obstacles around it.
//!
//! Of tetrahedra the faces that one cell has alone; of triangles all of them. Each
//! quadratic face becomes four triangles.

use std::path::Path;

use serde::Serialize;

use super::encode::{self, Coded};
use super::shape::{Surface, Vector};
use super::thin;
use super::vtk::{self, Array, Arrays};

/// Nodes of the surface, and triangles of all obstacles, that fit into a page: fewer
/// than 16 bits count.
const MOST_NODES: usize = 40_000;
const MOST_OBSTACLE_TRIANGLES: usize = 12_000;
/// Fields that a page shows at most.
const MOST_FIELDS: usize = 8;
/// Rows of a quadratic triangle and a quadratic tetrahedron.
const TRIANGLE: usize = 6;
const TETRAHEDRON: usize = 10;

/// Faces of a quadratic tetrahedron: three vertices, then the middles between them.
const FACES: [[usize; 6]; 4] = [
    [0, 1, 2, 4, 5, 6],
    [0, 1, 3, 4, 8, 7],
    [1, 2, 3, 5, 9, 8],
    [0, 2, 3, 6, 9, 7],
];
/// The four triangles of a quadratic one.
const PARTS: [[usize; 3]; 4] = [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]];

/// What the page draws, numbers as base64.
#[derive(Debug, Serialize)]
pub(super) struct Picture {
    /// 2 for a section, 3 for a solid.
    dimension: usize,
    pub(super) time: f64,
    /// Nodes before and after thinning.
    nodes: [usize; 2],
    /// Undeformed, [nodes, 3].
    points: Coded,
    /// [nodes, 3]; none where the run wrote no displacement.
    displacement: Option<Coded>,
    triangles: String,
    fields: Vec<NamedField>,
    obstacles: Vec<Drawn>,
    /// Of a section: its rim as pairs of nodes.
    rim: String,
}

/// A number at each node.
#[derive(Debug, Serialize)]
struct NamedField {
    name: String,
    values: Coded,
}

/// An obstacle where it stands.
#[derive(Debug, Serialize)]
struct Drawn {
    points: Coded,
    triangles: String,
}

/// The picture of a folder's last files; none where it has no series.
pub(super) fn last_picture(folder: &Path) -> Option<Picture> {
    let entries = vtk::series(&series(folder)?);
    let mut bodies = entries.iter().rev().filter(|(_, part, _)| *part == 0);
    let (time, _, body) = bodies.next()?;
    let arrays = file(folder, body)?;
    let is_now = |at: &f64| at.total_cmp(time).is_eq();
    let others = entries
        .iter()
        .filter(|(at, part, _)| is_now(at) && *part > 0);
    let drawn = others.filter_map(|(_, _, name)| file(folder, name));
    picture(*time, &arrays, drawn)
}

/// The text of the folder's only series.
fn series(folder: &Path) -> Option<String> {
    let entries = std::fs::read_dir(folder).ok()?;
    let mut paths: Vec<_> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "pvd"));
    // Of two runs into one folder the newer one.
    let changed = |path: &std::path::PathBuf| path.metadata().and_then(|file| file.modified()).ok();
    let newest = paths.into_iter().max_by_key(changed)?;
    std::fs::read_to_string(newest).ok()
}

/// A file that the series names beside itself.
fn file(folder: &Path, name: &str) -> Option<Arrays> {
    let name = Path::new(name).file_name()?;
    vtk::read(&std::fs::read(folder.join(name)).ok()?)
}

fn picture(time: f64, arrays: &Arrays, obstacles: impl Iterator<Item = Arrays>) -> Option<Picture> {
    let (surface, dimension) = surface(arrays)?;
    let whole = surface.points.len();
    let surface = thin::to(surface, MOST_NODES);
    let mut room = MOST_OBSTACLE_TRIANGLES;
    let obstacles = obstacles.filter_map(|arrays| drawn(&arrays, &surface, &mut room));
    let obstacles = obstacles.collect();
    let fields = surface.fields.iter().map(|(name, values)| NamedField {
        name: name.clone(),
        values: encode::scalars(values),
    });
    Some(Picture {
        dimension,
        time,
        nodes: [whole, surface.points.len()],
        points: encode::vectors(&surface.points),
        displacement: surface.displacement.as_deref().map(encode::vectors),
        triangles: encode::indices(surface.triangles.as_flattened()),
        fields: fields.collect(),
        obstacles,
        rim: encode::indices(surface.rim.as_flattened()),
    })
}

/// An obstacle near the body, while there is room.
fn drawn(arrays: &Arrays, body: &Surface, room: &mut usize) -> Option<Drawn> {
    let points = rows(arrays.get("Points", "Points")?);
    let corners = indices(arrays.get("Polys", "connectivity")?, points.len())?;
    let triangles: Vec<[u32; 3]> = corners.as_chunks().0.to_vec();
    let triangles = near(&points, triangles, body);
    let is_counted = u16::try_from(points.len()).is_ok();
    if triangles.is_empty() || triangles.len() > *room || !is_counted {
        return None;
    }
    *room -= triangles.len();
    Some(Drawn {
        points: encode::vectors(&points),
        triangles: encode::indices(triangles.as_flattened()),
    })
}

/// The triangles that come as near to the body's middle as it is large; planes whole.
fn near(points: &[Vector], triangles: Vec<[u32; 3]>, body: &Surface) -> Vec<[u32; 3]> {
    if triangles.len() <= 2 {
        return triangles;
    }
    let (low, high) = thin::bounds(&body.points);
    let middle = [0, 1, 2].map(|axis| 0.5 * (at(low, axis) + at(high, axis)));
    let distance = |a: Vector| {
        let squares = [0, 1, 2].map(|axis| (at(a, axis) - at(middle, axis)).powi(2));
        squares.iter().sum::<f64>().sqrt()
    };
    let reach = 2.0 * distance(high);
    let is_near = |triangle: &[u32; 3]| {
        let corners = triangle
            .iter()
            .filter_map(|node| points.get(*node as usize));
        corners.copied().any(|corner| distance(corner) <= reach)
    };
    triangles.into_iter().filter(is_near).collect()
}

/// The surface of the cells of a file, and the dimension of the body.
fn surface(arrays: &Arrays) -> Option<(Surface, usize)> {
    let points = rows(arrays.get("Points", "Points")?);
    let connectivity = indices(arrays.get("Cells", "connectivity")?, points.len())?;
    let types = arrays.get("Cells", "types")?;
    let size = connectivity.len() / types.rows().max(1);
    let (faces, rim) = match size {
        TRIANGLE => (connectivity.as_chunks().0.to_vec(), rim(&connectivity)),
        TETRAHEDRON => (skin(&connectivity), Vec::new()),
        _ => return None,
    };
    let triangles = faces.iter().flat_map(|face: &[u32; 6]| {
        PARTS.map(|part| part.map(|corner| face.get(corner).copied().unwrap_or_default()))
    });
    let displacement = arrays.get("PointData", "displacement").map(rows);
    let whole = Surface {
        displacement: displacement.filter(|rows| rows.len() == points.len()),
        fields: fields(arrays, &connectivity, size, points.len()),
        points,
        triangles: triangles.collect(),
        rim,
    };
    let dimension = if size == TRIANGLE { 2 } else { 3 };
    Some((thin::used(whole), dimension))
}

/// Faces that one cell has alone, by their nodes.
fn skin(cells: &[u32]) -> Vec<[u32; 6]> {
    let mut faces: Vec<([u32; 3], [u32; 6])> = Vec::with_capacity(cells.len() / TETRAHEDRON * 4);
    for cell in cells.chunks_exact(TETRAHEDRON) {
        for local in FACES {
            let face = local.map(|node| cell.get(node).copied().unwrap_or_default());
            let mut corners = [face[0], face[1], face[2]];
            corners.sort_unstable();
            faces.push((corners, face));
        }
    }
    faces.sort_unstable();
    let groups = faces.chunk_by(|a, b| a.0 == b.0);
    groups
        .filter_map(|group| match group {
            [(_, face)] => Some(*face),
            _ => None,
        })
        .collect()
}

/// Edges that one triangle has alone, each as its two halves.
fn rim(cells: &[u32]) -> Vec<[u32; 2]> {
    let mut edges: Vec<([u32; 2], [u32; 3])> = Vec::new();
    for [a, b, c, ab, bc, ca] in cells.as_chunks().0 {
        for (from, to, middle) in [(a, b, ab), (b, c, bc), (c, a, ca)] {
            edges.push(([*from.min(to), *from.max(to)], [*from, *middle, *to]));
        }
    }
    edges.sort_unstable();
    let groups = edges.chunk_by(|a, b| a.0 == b.0);
    let alone = groups.filter_map(|group| match group {
        [(_, edge)] => Some(*edge),
        _ => None,
    });
    alone
        .flat_map(|[from, middle, to]| [[from, middle], [middle, to]])
        .collect()
}

/// Numbers at nodes: scalars, sizes of vectors, means of what cells have.
fn fields(arrays: &Arrays, cells: &[u32], size: usize, nodes: usize) -> Vec<(String, Vec<f64>)> {
    let of_points = arrays.section("PointData").filter_map(|(name, array)| {
        let values = sizes(array)?;
        (values.len() == nodes && name != "displacement").then(|| (name.to_owned(), values))
    });
    let of_cells = arrays.section("CellData").filter_map(|(name, array)| {
        let (name, values) = match (name, array.components) {
            ("stress", 6) => ("von_mises".to_owned(), von_mises(array)),
            (_, 1) => (name.to_owned(), array.values.clone()),
            _ => return None,
        };
        Some((name, at_nodes(&values, cells, size, nodes)))
    });
    of_points.chain(of_cells).take(MOST_FIELDS).collect()
}

/// Scalars as they are, vectors by their length.
fn sizes(array: &Array) -> Option<Vec<f64>> {
    match array.components {
        1 => Some(array.values.clone()),
        3 => {
            let rows = rows(array);
            let length = |row: &Vector| row.iter().map(|x| x * x).sum::<f64>().sqrt();
            Some(rows.iter().map(length).collect())
        }
        _ => None,
    }
}

/// Of stresses in the order xx yy zz xy yz zx.
fn von_mises(stress: &Array) -> Vec<f64> {
    let rows = stress.values.as_chunks().0.iter();
    rows.map(|[xx, yy, zz, xy, yz, zx]| {
        let normal = (xx - yy).powi(2) + (yy - zz).powi(2) + (zz - xx).powi(2);
        let shear = xy * xy + yz * yz + zx * zx;
        (0.5 * normal + 3.0 * shear).sqrt()
    })
    .collect()
}

/// The mean of the cells around each node.
fn at_nodes(values: &[f64], cells: &[u32], size: usize, nodes: usize) -> Vec<f64> {
    let mut sums = vec![(0.0, 0_u32); nodes];
    for (value, cell) in values.iter().zip(cells.chunks_exact(size)) {
        for node in cell {
            if let Some((sum, count)) = sums.get_mut(*node as usize) {
                *sum += value;
                *count += 1;
            }
        }
    }
    let mean = |(sum, count): (f64, u32)| sum / f64::from(count.max(1));
    sums.into_iter().map(mean).collect()
}

fn rows(array: &Array) -> Vec<Vector> {
    array.values.as_chunks().0.to_vec()
}

/// Indices below a bound; none where one is not.
fn indices(array: &Array, bound: usize) -> Option<Vec<u32>> {
    let index = |value: &f64| (*value >= 0.0 && *value < bound as f64).then_some(*value as u32);
    array.values.iter().map(index).collect()
}

fn at(vector: Vector, axis: usize) -> f64 {
    vector.get(axis).copied().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_tetrahedra_have_the_six_faces_that_they_do_not_share() {
        let first = [0, 1, 2, 3, 10, 11, 12, 13, 14, 15];
        let second = [1, 2, 3, 4, 11, 15, 14, 16, 17, 18];
        let faces = skin(&[first, second].concat());
        assert_eq!(faces.len(), 6);
        let is_shared = |face: &[u32; 6]| face[..3] == [1, 2, 3];
        assert!(!faces.iter().any(is_shared), "{faces:?}");
    }

    #[test]
    fn the_rim_of_two_triangles_has_four_edges_in_halves() {
        let rim = rim(&[0, 1, 2, 5, 6, 7, 0, 2, 3, 7, 8, 9]);
        assert_eq!(rim.len(), 8);
        assert!(!rim.contains(&[0, 7]) && rim.contains(&[0, 5]));
    }

    #[test]
    fn uniaxial_and_shear_stress_have_their_mises_stress() {
        let array = Array {
            components: 6,
            values: vec![3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 2.0, 0.0, 0.0],
        };
        let [uniaxial, shear] = von_mises(&array).try_into().unwrap();
        assert!((uniaxial - 3.0).abs() < 1e-14);
        assert!((shear - 2.0 * 3_f64.sqrt()).abs() < 1e-14);
    }

    #[test]
    fn indices_beyond_the_points_are_refused() {
        let array = |values: Vec<f64>| Array {
            components: 1,
            values,
        };
        assert_eq!(indices(&array(vec![0.0, 2.0]), 3), Some(vec![0, 2]));
        assert_eq!(indices(&array(vec![3.0]), 3), None);
        assert_eq!(indices(&array(vec![-1.0]), 3), None);
        assert_eq!(indices(&array(vec![f64::NAN]), 3), None);
    }
}
