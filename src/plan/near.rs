//! Which vertices the compliance knows where it cannot know all that may be touched: those
//! nearest to the tools on their way through the steps of the plan.
//!
//! Elsewhere the metric has what single nodes do alone, which keeps it regular; the true gaps
//! decide there as everywhere, and pressure that comes up there all the same costs iterations,
//! not correctness. Cost: a distance a vertex for each of some poses.

use std::collections::HashMap;

use super::Units;
use crate::mesh::Mesh;
use crate::obstacle::{Contact, Moving, Obstacle, What};
use crate::scene::Step;
use crate::scene::validate::ResolvedObstacle;

/// Distance over the length of the body within which a vertex may come to be pressed.
const NEAR: f64 = 0.03;
/// Vertices that are known for each that is so near.
const HALO: usize = 2;
/// Vertices that are known at least.
const FEWEST: usize = 600;
/// Poses that are looked at, of each obstacle.
const MOST_POSES: usize = 32;

/// The vertices of `guided` surfaces and those of obstacles nearest to them, `most` in all,
/// ascending; none where more than that may be pressed.
pub(super) fn near(
    (mesh, units): (&Mesh, &Units),
    (obstacles, steps): (&[ResolvedObstacle], &[Step]),
    guided: &[u32],
    most: usize,
) -> Option<Vec<u32>> {
    let mut least: HashMap<u32, f64> = HashMap::new();
    for obstacle in obstacles {
        for (vertex, distance) in distances(obstacle, steps, (mesh, units)) {
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
    (mesh, units): (&Mesh, &Units),
) -> Vec<(u32, f64)> {
    let vertices = super::surfaces::vertices_of(mesh, std::iter::once(&obstacle.facets));
    let scaled =
        |&vertex: &u32| mesh.coordinates()[vertex as usize].map(|x| x * units.coordinate_scale);
    let points: Vec<[f64; 3]> = vertices.iter().map(scaled).collect();
    let mut least = vec![f64::INFINITY; points.len()];
    let mut found = vec![Contact::default(); points.len()];
    for [translation, rotation] in poses(&obstacle.name, steps) {
        let translation = translation.map(|x| x / units.length);
        let placed = Moving::new(obstacle.shape.clone(), translation, rotation);
        placed.probe(&points, What::Gap, &mut found);
        let pairs = least.iter_mut().zip(&found);
        pairs.for_each(|(least, contact)| *least = least.min(contact.distance));
    }
    vertices.into_iter().zip(least).collect()
}

/// Poses of an obstacle through the steps: the first one, ends and middles.
fn poses(name: &str, steps: &[Step]) -> Vec<[[f64; 3]; 2]> {
    let mut all = vec![[[0.0; 3]; 2]];
    for target in steps.iter().flat_map(|step| &step.obstacles) {
        if target.name != name {
            continue;
        }
        let from = all[all.len() - 1];
        let to = [
            target.translation.unwrap_or(from[0]),
            target.rotation.unwrap_or(from[1]),
        ];
        let middle = [0, 1]
            .map(|part| std::array::from_fn(|axis| 0.5 * (from[part][axis] + to[part][axis])));
        all.extend([middle, to]);
    }
    let stride = all.len().div_ceil(MOST_POSES).max(1);
    // The last pose is among them, whatever the stride.
    all.reverse();
    all.into_iter().step_by(stride).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::ObstacleTarget;

    /// A step that leads an obstacle there.
    fn moved(name: &str, translation: [f64; 3]) -> Step {
        Step {
            obstacles: vec![ObstacleTarget {
                name: name.to_owned(),
                translation: Some(translation),
                ..ObstacleTarget::default()
            }],
            ..Step::default()
        }
    }

    #[test]
    fn tools_are_followed_through_the_poses_of_their_steps() {
        let steps = [
            moved("ball", [2.0, 0.0, 0.0]),
            moved("other", [9.0; 3]),
            moved("ball", [2.0, 4.0, 0.0]),
        ];
        let ways = poses("ball", &steps).into_iter();
        let ways: Vec<[f64; 3]> = ways.map(|[translation, _]| translation).collect();
        let expected = [[2.0, 4.0], [2.0, 2.0], [2.0, 0.0], [1.0, 0.0], [0.0, 0.0]];
        assert_eq!(ways, expected.map(|[x, y]| [x, y, 0.0]));
        let steps: Vec<Step> = (0..500)
            .map(|i| moved("ball", [f64::from(i), 0.0, 0.0]))
            .collect();
        let long = poses("ball", &steps);
        assert!(long.len() <= MOST_POSES, "{}", long.len());
        let far = long.iter().map(|[translation, _]| translation[0]);
        assert!(far.fold(0.0, f64::max) >= 499.0);
    }
}
