//! How deep an obstacle lies inside the body:
//!
//! ```text
//! max over points of cells of -d(x + u),   zero where no point is inside
//! ```
//!
//! Faces feel an obstacle only while it overlaps them, and where the scene lets it press: one
//! that has slipped in between their nodes, or beside them, is met by cells alone. Points are the centroids, and a lattice of the cells that are
//! larger than their distance; a distance changes by no more than the point moves, which leaves most of
//! them out. Cost: a pass over the nodes where the obstacle is away, one distance a cell where it is
//! near, some more in cells at it.

use crate::assembly::load::shape_values;
use crate::contact::Deformed;
use crate::contact::surface::ContactSurface;
use crate::geometry::vector3::{add, cross, dot, sub};
use crate::linalg::vector::norm;
use crate::mesh::Mesh;
use crate::obstacle::{Contact, Derivatives, Obstacle};
use crate::parallel;

/// Share of a unit normal, squared, that is left to a vertex which supports hold along it.
const FREE: f64 = 1e-6;
/// Intervals of the lattice on an edge of a cell.
const INTERVALS: u32 = 6;
/// Distance of a centroid over the size of its cell beyond which no point of it is inside.
const NEAR: f64 = 1.5;
/// Cells that one thread looks at one after the other.
const CELLS_AT_ONCE: usize = 256;
/// Above one by more than all rounding.
const CAREFUL: f64 = 1.01;

/// Cells without a face on `surface`.
pub fn beside(mesh: &Mesh, surface: &ContactSurface) -> Vec<usize> {
    let mut is_on = vec![false; mesh.coordinates().len()];
    for face in &surface.faces {
        face.corners
            .iter()
            .for_each(|&corner| is_on[corner as usize] = true);
    }
    let corners = corners_of(mesh);
    let cells = mesh.cells().chunks_exact(corners).enumerate();
    let beside = cells.filter(|(_, cell)| {
        let on = cell.iter().filter(|&&vertex| is_on[vertex as usize]);
        on.count() < corners - 1
    });
    beside.map(|(cell, _)| cell).collect()
}

/// Greatest depth of a point of `cells` inside `obstacle`, or how far this has to move to come
/// out where it fits between those points, `nearest` its distance from the faces. In units of the
/// scaled body.
pub fn depth_inside(
    body: &Deformed<'_>,
    (obstacle, cells): (&dyn Obstacle, &[usize]),
    nearest: f64,
) -> f64 {
    if is_away(body, obstacle) {
        return 0.0;
    }
    let corners = corners_of(body.mesh);
    let shapes = lattice(corners).into_iter();
    let shapes = shapes.map(|at| shape_values(&at[..corners]));
    let search = Search {
        shapes: shapes.collect(),
        body,
        obstacle,
        nearest,
    };
    let depths = parallel::map(cells.len().div_ceil(CELLS_AT_ONCE), 1, &|k| {
        let end = cells.len().min((k + 1) * CELLS_AT_ONCE);
        search.deepest(&cells[k * CELLS_AT_ONCE..end])
    });
    depths.into_iter().fold(0.0, f64::max)
}

/// What is asked of cells.
struct Search<'a> {
    /// Values of the functions of a cell at the points of its lattice `[points][nodes]`.
    shapes: Vec<Vec<f64>>,
    body: &'a Deformed<'a>,
    obstacle: &'a dyn Obstacle,
    nearest: f64,
}

impl Search<'_> {
    /// The greatest depth in some cells, zero without any.
    fn deepest(&self, cells: &[usize]) -> f64 {
        let mut deepest = 0.0_f64;
        // A distance changes by no more than the point moves: most cells are away by that of one
        // before.
        let mut last = ([0.0; 3], f64::NEG_INFINITY);
        for &cell in cells {
            let (middle, size) = self.middle_and_size(cell);
            if last.1 - CAREFUL * norm(&sub(middle, last.0)) > NEAR * size {
                continue;
            }
            let mut contact = [Contact::default()];
            self.obstacle
                .probe(&[middle], Derivatives::Gap, &mut contact);
            last = (middle, contact[0].distance);
            if contact[0].distance <= NEAR * size {
                deepest = deepest.max(self.depth_in(cell, last));
            }
        }
        deepest
    }

    /// The deformed centroid of a cell, and the largest distance of a corner from it.
    fn middle_and_size(&self, cell: usize) -> ([f64; 3], f64) {
        let corners = self.body.mesh.cell(cell);
        let mut places = [[0.0; 3]; 4];
        for (place, &corner) in places.iter_mut().zip(corners) {
            *place = self.body.place(corner as usize);
        }
        let share = 1.0 / corners.len() as f64;
        let edges = edges_of(self.body, cell);
        let bent = edges.fold([0.0; 3], add);
        let places = &places[..corners.len()];
        let middle: [f64; 3] = std::array::from_fn(|i| {
            let sum: f64 = places.iter().map(|place| place[i]).sum();
            share * sum + 4.0 * share * share * bent[i]
        });
        let distances = places.iter().map(|&place| norm(&sub(place, middle)));
        (middle, distances.fold(0.0, f64::max))
    }

    /// How deep the obstacle lies inside a cell near it, `last` being a place with its distance.
    fn depth_in(&self, cell: usize, mut last: ([f64; 3], f64)) -> f64 {
        let body = self.body;
        let corners = body.mesh.cell(cell).iter();
        let corners = corners.map(|&corner| body.place(corner as usize));
        let edges = edges_of(body, cell);
        let values: Vec<[f64; 3]> = corners.chain(edges).collect();
        let middle = last;
        let mut deepest = 0.0_f64;
        for at in &self.shapes {
            let point = sum(at, &values);
            let is_outside = |known| is_outside(point, known);
            if self.obstacle.has_exact_distances() && [middle, last].iter().any(is_outside) {
                continue;
            }
            let mut contact = [Contact::default()];
            self.obstacle
                .probe(&[point], Derivatives::Gap, &mut contact);
            last = (point, contact[0].distance);
            deepest = deepest.max(-last.1);
        }
        match self.obstacle.inner_ball() {
            Some(ball) if contains(body, (cell, ball.centre)) => {
                deepest.max(2.0 * ball.radius + self.nearest.max(0.0))
            }
            Some(_) | None => deepest,
        }
    }
}

/// What the middles of the edges of a deformed cell are off the means of their ends, each `[3]`.
fn edges_of<'a>(body: &'a Deformed<'_>, cell: usize) -> impl Iterator<Item = [f64; 3]> + 'a {
    let nodes = body.space.edge_nodes_of(body.mesh, cell);
    nodes.map(|(node, _)| body.place(node))
}

/// Whether a point is outside by the distance of another one.
fn is_outside(point: [f64; 3], (place, distance): &([f64; 3], f64)) -> bool {
    distance - CAREFUL * norm(&sub(point, *place)) > 0.0
}

/// `sum w_i x_i`.
fn sum(weights: &[f64], points: &[[f64; 3]]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (weight, point) in weights.iter().zip(points) {
        (0..3).for_each(|i| sum[i] += weight * point[i]);
    }
    sum
}

/// Greatest depth of a vertex of `surface` inside `obstacle` that supports hold along the
/// normal, in units of the scaled body.
pub fn depth_where_held(
    body: &Deformed<'_>,
    is_held: &[bool],
    (obstacle, surface): (&dyn Obstacle, &ContactSurface),
) -> f64 {
    let components = body.space.components;
    let corners = surface
        .faces
        .iter()
        .flat_map(|face| face.corners.iter().copied());
    let depths = corners.map(|corner| {
        let first = corner as usize * components;
        let own = first..first + components;
        let held = is_held.get(own).unwrap_or(&[]);
        if !held.contains(&true) {
            return 0.0;
        }
        let place = body.place(corner as usize);
        let mut contact = [Contact::default()];
        obstacle.probe(&[place], Derivatives::Normal, &mut contact);
        let normal = contact[0].normal;
        let free = normal.iter().zip(held).filter(|(_, held)| !**held);
        let share: f64 = free.map(|(n, _)| n * n).sum();
        if share < FREE {
            -contact[0].distance
        } else {
            0.0
        }
    });
    depths.fold(0.0, f64::max)
}

/// Corners of a cell.
fn corners_of(mesh: &Mesh) -> usize {
    mesh.cell_kind().vertices()
}

/// Whether a point is in a cell, whose sides are taken straight between its deformed corners.
fn contains(body: &Deformed<'_>, (cell, point): (usize, [f64; 3])) -> bool {
    let corners = corners_of(body.mesh);
    let own = body.mesh.cell(cell).iter();
    let own = own.map(|&corner| body.place(corner as usize));
    let places: Vec<[f64; 3]> = own.collect();
    // On the inner side of every side, as the corner opposite is.
    (0..corners).all(|opposite| {
        let others: Vec<[f64; 3]> = (0..corners)
            .filter(|&corner| corner != opposite)
            .map(|corner| places[corner])
            .collect();
        let side = |of: [f64; 3]| volume(&others, of);
        side(point) * side(places[opposite]) >= 0.0
    })
}

/// Twice the area, or six times the volume, of the cell over a side `[corners]` with its tip at
/// `tip`.
fn volume(side: &[[f64; 3]], tip: [f64; 3]) -> f64 {
    let edges: Vec<[f64; 3]> = side.iter().map(|&corner| sub(corner, tip)).collect();
    match edges[..] {
        [a, b] => a[0] * b[1] - a[1] * b[0],
        [a, b, c] => dot(a, cross(b, c)),
        _ => 0.0,
    }
}

/// Whether the obstacle is beyond the ball around the body, at rest and as it has moved.
fn is_away(body: &Deformed<'_>, obstacle: &dyn Obstacle) -> bool {
    let scale = body.scale;
    let points = body.mesh.coordinates();
    let mut middle = [0.0; 3];
    for point in points {
        let terms = middle.iter_mut().zip(point);
        terms.for_each(|(sum, x)| *sum += scale * x / points.len() as f64);
    }
    let square = |point: &[f64; 3]| -> f64 {
        let offsets = point.iter().zip(middle).map(|(x, m)| scale * x - m);
        offsets.map(|offset| offset * offset).sum()
    };
    let radius = points.iter().map(square).fold(0.0, f64::max).sqrt();
    let moved = body.displacement.chunks_exact(body.space.components);
    let moved = moved.map(norm);
    let mut contact = [Contact::default()];
    obstacle.probe(&[middle], Derivatives::Gap, &mut contact);
    // Corners, and what the middles of edges move beside them.
    contact[0].distance > radius + 2.0 * moved.fold(0.0, f64::max)
}

/// Barycentric coordinates of the lattice of a cell with that many corners `[points][4]`.
fn lattice(corners: usize) -> Vec<[f64; 4]> {
    let share = |count: u32| f64::from(count) / f64::from(INTERVALS);
    let mut points = Vec::new();
    for i in 0..=INTERVALS {
        for j in 0..=INTERVALS - i {
            let layers = if corners == 3 {
                0..=0
            } else {
                0..=INTERVALS - i - j
            };
            for k in layers {
                let [a, b, c] = [share(i), share(j), share(k)];
                points.push([1.0 - a - b - c, a, b, c]);
            }
        }
    }
    points
}
