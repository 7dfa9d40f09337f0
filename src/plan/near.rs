//! Which vertices the compliance knows where it cannot know all that may be touched: those
//! nearest to the tools on their way through the steps of the plan.
//!
//! Elsewhere the metric has what single nodes do alone, which keeps it regular; the true gaps
//! decide there as everywhere, and pressure that comes up there all the same costs iterations,
//! not correctness. Cost: a distance a vertex for each of some poses.

use std::collections::HashMap;

use super::poses::{poses, some, with_middles};
use super::surfaces::vertices_of;
use super::units::ScaledMesh;
use crate::proximity::points;
use crate::scene::Step;
use crate::scene::validate::ResolvedObstacle;

/// Distance over the length of the body within which a vertex may come to be pressed.
const NEAR: f64 = 0.03;
/// Vertices that are known for each that is so near.
const HALO: usize = 2;
/// Vertices that are known at least.
const FEWEST: usize = 600;

/// The vertices of `guided` surfaces and those of obstacles nearest to them, `most` in all,
/// ascending; none where more than that may be pressed.
pub(super) fn near(
    body: ScaledMesh<'_>,
    obstacles: &[ResolvedObstacle],
    steps: &[Step],
    guided: &[u32],
    most: usize,
) -> Option<Vec<u32>> {
    let mut least: HashMap<u32, f64> = HashMap::new();
    for obstacle in obstacles {
        for (vertex, distance) in distances(obstacle, steps, body) {
            let known = least.entry(vertex).or_insert(f64::INFINITY);
            *known = known.min(distance);
        }
    }
    guided.iter().for_each(|&vertex| {
        least.insert(vertex, f64::NEG_INFINITY);
    });
    let mut all: Vec<(u32, f64)> = least.into_iter().collect();
    all.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
    let pressed = all.iter().filter(|(_, distance)| *distance <= NEAR).count();
    if pressed > most {
        return None;
    }
    all.truncate((HALO * pressed).max(FEWEST).min(most));
    let mut vertices: Vec<u32> = all.into_iter().map(|(vertex, _)| vertex).collect();
    vertices.sort_unstable();
    Some(vertices)
}

/// Vertices that an obstacle may touch, with their least signed distance over its poses, in
/// lengths of the body.
fn distances(
    obstacle: &ResolvedObstacle,
    steps: &[Step],
    ScaledMesh { mesh, units }: ScaledMesh<'_>,
) -> Vec<(u32, f64)> {
    let vertices = vertices_of(mesh, std::iter::once(&obstacle.facets));
    let scaled =
        |&vertex: &u32| mesh.coordinates()[vertex as usize].map(|x| x * units.coordinate_scale);
    let points: Vec<[f64; 3]> = vertices.iter().map(scaled).collect();
    let mut least = vec![f64::INFINITY; points.len()];
    for pose in some(&with_middles(&poses(&obstacle.name, steps))) {
        let found = points::contacts(&pose.of(obstacle, units), &points);
        let pairs = least.iter_mut().zip(&found);
        pairs.for_each(|(least, contact)| *least = least.min(contact.distance));
    }
    vertices.into_iter().zip(least).collect()
}
