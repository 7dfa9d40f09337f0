//! Sizes and quality of a mesh file: one pass over its cells.
//!
//! The quality is the mean ratio of the service, 12 (3 V)^(2/3) / sum of squared edges
//! of a tetrahedron and 4 sqrt(3) A / sum of squared edges of a triangle.

use signorini_client::formats::msh::{MeshFile, MeshGroup};

type Vector = [f64; 3];

/// Sizes of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Shape {
    /// Corner of the bounding box.
    pub(crate) low: Vector,
    /// The corner across.
    pub(crate) high: Vector,
    /// Lengths of the shortest and the longest edge.
    pub(crate) edges: [f64; 2],
    pub(crate) quality: Quality,
}

/// Mean ratios of the cells: 1 is regular, 0 is flat.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Quality {
    pub(crate) worst: f64,
    /// The first cell of that ratio, from 0.
    pub(crate) worst_cell: usize,
    pub(crate) mean: f64,
}

impl Shape {
    /// Measures a mesh.
    pub(crate) fn of(mesh: &MeshFile) -> Self {
        let (low, high) = bounds(mesh.coordinates.iter().copied());
        let mut edges = [f64::INFINITY, 0.0_f64];
        let (mut worst, mut worst_cell, mut sum) = (f64::INFINITY, 0, 0.0);
        for (index, cell) in mesh.cells.chunks_exact(mesh.vertices_per_cell).enumerate() {
            let corners: Vec<Vector> = corners(mesh, cell).collect();
            let mut squares = 0.0;
            for (number, a) in corners.iter().enumerate() {
                for b in corners.iter().skip(number + 1) {
                    let edge = subtract(*b, *a);
                    let square = dot(edge, edge);
                    squares += square;
                    edges = [edges[0].min(square.sqrt()), edges[1].max(square.sqrt())];
                }
            }
            let ratio = mean_ratio(&corners, squares);
            sum += ratio;
            if ratio < worst {
                (worst, worst_cell) = (ratio, index);
            }
        }
        let mean = sum / mesh.cell_count().max(1) as f64;
        let quality = Quality {
            worst,
            worst_cell,
            mean,
        };
        Self {
            low,
            high,
            edges,
            quality,
        }
    }
}

fn mean_ratio(corners: &[Vector], squares: f64) -> f64 {
    let ratio = match corners {
        [a, b, c] => {
            let normal = cross(subtract(*b, *a), subtract(*c, *a));
            2.0 * 3_f64.sqrt() * dot(normal, normal).sqrt() / squares
        }
        [a, b, c, d] => {
            let normal = cross(subtract(*b, *a), subtract(*c, *a));
            let volume = dot(normal, subtract(*d, *a)).abs() / 6.0;
            12.0 * (3.0 * volume).cbrt().powi(2) / squares
        }
        _ => 0.0,
    };
    if ratio.is_finite() { ratio } else { 0.0 }
}

/// The box around the members of a group.
pub(crate) fn group_box(mesh: &MeshFile, group: &MeshGroup) -> (Vector, Vector) {
    bounds(group_points(mesh, group))
}

/// The vertices of a group's members, as often as they occur.
pub(crate) fn group_points<'a>(
    mesh: &'a MeshFile,
    group: &'a MeshGroup,
) -> impl Iterator<Item = Vector> + 'a {
    let size = group.dimension + 1;
    let elements = if size == mesh.vertices_per_cell {
        &mesh.cells
    } else {
        &mesh.facets
    };
    let members = group.members.iter();
    members.flat_map(move |member| {
        let first = *member as usize * size;
        let element = elements.get(first..first + size).unwrap_or_default();
        corners(mesh, element)
    })
}

fn corners<'a>(mesh: &'a MeshFile, element: &'a [u32]) -> impl Iterator<Item = Vector> + 'a {
    let vertices = element.iter();
    vertices.filter_map(|vertex| mesh.coordinates.get(*vertex as usize).copied())
}

fn bounds(points: impl Iterator<Item = Vector>) -> (Vector, Vector) {
    let empty = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    points.fold(empty, |(mut low, mut high), point| {
        for ((low, high), x) in low.iter_mut().zip(&mut high).zip(point) {
            *low = low.min(x);
            *high = high.max(x);
        }
        (low, high)
    })
}

fn subtract([ax, ay, az]: Vector, [bx, by, bz]: Vector) -> Vector {
    [ax - bx, ay - by, az - bz]
}

fn dot([ax, ay, az]: Vector, [bx, by, bz]: Vector) -> f64 {
    ax * bx + ay * by + az * bz
}

fn cross([ax, ay, az]: Vector, [bx, by, bz]: Vector) -> Vector {
    [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh(coordinates: Vec<Vector>, vertices_per_cell: usize) -> MeshFile {
        MeshFile {
            vertices_per_cell,
            cells: (0..vertices_per_cell as u32).collect(),
            facets: vec![0, 1, 2],
            groups: vec![MeshGroup {
                name: "top".to_owned(),
                dimension: vertices_per_cell - 2,
                members: vec![0],
            }],
            coordinates,
            curved: Vec::new(),
            warnings: Vec::new(),
        }
    }

    #[test]
    fn regular_cells_have_ratio_one_and_flat_ones_none() {
        let triangle = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.5, 0.75_f64.sqrt(), 0.0]];
        let regular = Shape::of(&mesh(triangle, 3));
        assert!((regular.quality.worst - 1.0).abs() < 1e-14);
        assert!((regular.edges[1] - 1.0).abs() < 1e-14);
        let corners = vec![
            [1.0, 1.0, 1.0],
            [1.0, -1.0, -1.0],
            [-1.0, 1.0, -1.0],
            [-1.0, -1.0, 1.0],
        ];
        let regular = Shape::of(&mesh(corners, 4));
        assert!((regular.quality.mean - 1.0).abs() < 1e-14);
        let flat = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
        assert!(Shape::of(&mesh(flat, 4)).quality.worst.abs() < 1e-14);
    }

    #[test]
    fn a_group_has_the_box_of_its_members() {
        let corners = vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 4.0]];
        let mesh = mesh(corners, 4);
        let (low, high) = group_box(&mesh, &mesh.groups[0]);
        assert_eq!((low, high), ([0.0; 3], [2.0, 3.0, 0.0]));
    }
}
