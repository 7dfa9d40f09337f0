//! Ways of tools on which they never come to the body, and places of it that lie beyond what is
//! known of a tool.
//!
//! ```text
//! least d over the path,   next pose as far on as d
//! ```
//!
//! d the least distance of the vertices that may touch, of the body at rest, in its lengths; the
//! march along the path is that of [`crate::proximity::path`]. Cost: a distance a vertex for each of some poses, one of them where the tool begins at the body.

use super::Units;
use super::poses::Pose;
use crate::geometry::vector3::{norm, sub};
use crate::geometry::{RigidMotion, rigid_motion};
use crate::obstacle::Shape;
use crate::obstacle::grid::Lattice;
use crate::proximity::path::{self, March};
use crate::proximity::points;
use crate::scene::Step;
use crate::scene::validate::ResolvedObstacle;

/// Distance in lengths of the body beyond which a tool is away from it, whatever else bends it.
const AWAY: f64 = 0.1;
/// Share of a way between two poses at least.
const SPACING: f64 = 0.01;

/// A tool that is led along a way which never comes to the body; `points` of the body at rest
/// `[vertices][3]` may touch it, scaled.
pub(super) fn away(
    obstacle: &ResolvedObstacle,
    (poses, steps): (&[Pose], &[Step]),
    (points, units): (&[[f64; 3]], &Units),
) -> Option<String> {
    let is_led = poses.windows(2).any(|pair| pair[0] != pair[1]);
    if !is_led || !alone_decides(obstacle, steps) {
        return None;
    }
    let distance = |pose: Pose| points::least(&pose.of(obstacle, units), points);
    let mut least = f64::INFINITY;
    for pair in poses.windows(2) {
        let way = length([pair[0], pair[1]], obstacle, (points, units));
        let mut march = March::new(way, SPACING * way, 1);
        let mut share = 0.0;
        while share < 1.0 && least > AWAY {
            let here = distance(pair[0].towards(pair[1], share));
            least = least.min(here);
            share = march.next(here).unwrap_or(1.0);
        }
    }
    let [first, last] = [poses.first()?, poses.last()?].map(|pose| distance(*pose));
    let least = least.min(last);
    (least > AWAY).then(|| {
        let what = if first.min(last) > least * (1.0 + SPACING) { "passes the body by" } else { "does not come to the body" };
        format!(
            "obstacle `{}` {what} on its way: it is {least:.2} lengths away where it is nearest; are its axes and units those of the mesh?",
            obstacle.name
        )
    })
}

/// Whether the steps say all of where tool and body are beside each other.
fn alone_decides(obstacle: &ResolvedObstacle, steps: &[Step]) -> bool {
    let mut targets = steps.iter().flat_map(|step| &step.obstacles);
    let is_pushed = targets.any(|target| target.name == obstacle.name && target.names_push());
    !is_pushed && steps.iter().all(|step| step.supports.is_empty())
}

/// Length of the path of a tool from one pose to the other.
fn length(
    poses: [Pose; 2],
    obstacle: &ResolvedObstacle,
    (points, units): (&[[f64; 3]], &Units),
) -> f64 {
    let motions = poses.map(|pose| pose.of(obstacle, units).motion());
    path::length(motions, |centre| {
        let reaches = points.iter().map(|&point| norm(sub(point, centre)));
        reaches.fold(0.0, f64::max)
    })
}

/// Vertices beside the nodes of a tool that is known at nodes only, and goes on beyond them;
/// places of the body at rest `[vertices][3]`, in the caller's units.
pub(super) fn beyond(
    (name, shape): (&str, &Shape),
    poses: &[Pose],
    places: &[[f64; 3]],
) -> Option<String> {
    let most = match shape {
        Shape::HeightField(field) => most_beside(field.lattice(), poses, places),
        Shape::DistanceGrid(grid) if !grid.is_enclosed() => {
            most_beside(grid.lattice(), poses, places)
        }
        Shape::Cavity(shape) => return beyond((name, &**shape), poses, places),
        Shape::DistanceGrid(_)
        | Shape::HalfSpace { .. }
        | Shape::Sphere { .. }
        | Shape::Cylinder { .. }
        | Shape::CappedCylinder { .. }
        | Shape::Box { .. }
        | Shape::Torus { .. }
        | Shape::Cone { .. }
        | Shape::Surface(_) => 0,
    };
    (most > 0).then(|| {
        format!(
            "{most} of {} vertices that may touch obstacle `{name}` lie beside the nodes of its grid, where it goes on as it ends",
            places.len()
        )
    })
}

/// Places beside a lattice that is moved, in the pose where they are most.
fn most_beside<const N: usize>(lattice: &Lattice<N>, poses: &[Pose], places: &[[f64; 3]]) -> usize {
    let is_beside = |pose: &Pose, place: [f64; 3]| {
        let motion = RigidMotion {
            translation: pose.translation,
            rotation: pose.rotation,
            about: [0.0; 3],
        };
        let back =
            rigid_motion::multiply_transposed(&motion.matrix(), sub(place, pose.translation));
        (0..N).any(|axis| {
            let last = (lattice.counts[axis] - 1) as f64;
            let share = (back[axis] - lattice.origin[axis]) / lattice.spacing[axis];
            !(0.0..=last).contains(&share)
        })
    };
    let count = |pose: &Pose| {
        let places = places.iter();
        places.filter(|&&place| is_beside(pose, place)).count()
    };
    poses.iter().map(count).max().unwrap_or(0)
}
