//! Obstacles without a bound that hold the whole body, which lies on the side that is not free:
//!
//! ```text
//! max d(x) <= 0 in the first pose,   max d(x) + min d(x) < 0 in each,   x the vertices of the body at rest
//! ```
//!
//! Cost: one distance a vertex that may be touched; where none of them is free, one a vertex and
//! pose.

use super::Units;
use super::overlap::{DEEP, REFUSED};
use super::poses::{Pose, poses, some};
use super::surfaces::vertices_of;
use super::units::ScaledMesh;
use crate::obstacle::Shape;
use crate::proximity::points;
use crate::scene::validate::{Faults, ResolvedObstacle};
use crate::scene::{self, SceneError, Step};

/// What is wrong with an obstacle that holds the whole body.
pub(super) struct Behind {
    /// Key that is to be changed, below that of the obstacle.
    key: &'static str,
    /// The fault and its cure.
    pub(super) message: String,
}

/// That an obstacle holds the whole body, in its first pose and nearly so in all others.
pub(super) fn behind(
    (given, obstacle): (&scene::Obstacle, &ResolvedObstacle),
    steps: &[Step],
    ScaledMesh { mesh, units }: ScaledMesh<'_>,
) -> Option<Behind> {
    let (key, cure) = cure(&given.shape)?;
    let scaled = |place: &[f64; 3]| place.map(|x| x * units.coordinate_scale);
    let holds = |points: &[[f64; 3]]| {
        let [least, most] = extremes((obstacle, units), Pose::default(), points);
        most <= REFUSED && least < -DEEP
    };
    let touching = vertices_of(mesh, std::iter::once(&obstacle.facets)).into_iter();
    let touching: Vec<[f64; 3]> = touching
        .map(|vertex| scaled(&mesh.coordinates()[vertex as usize]))
        .collect();
    // Few vertices, and a tool of many facets is asked for each.
    let [_, most] = extremes((obstacle, units), Pose::default(), &touching);
    if most > REFUSED {
        return None;
    }
    let body: Vec<[f64; 3]> = mesh.coordinates().iter().map(scaled).collect();
    let stays = |pose: Pose| extremes((obstacle, units), pose, &body).iter().sum::<f64>() < 0.0;
    let mut way = some(&poses(&obstacle.name, steps)).into_iter();
    (holds(&body) && way.all(stays)).then(|| Behind {
        key,
        message: format!(
            "all of the body lies inside obstacle `{}`, which has no end: {cure}",
            obstacle.name
        ),
    })
}

/// Least and largest distance of points `[points][3]` from an obstacle in a pose.
fn extremes(
    (obstacle, units): (&ResolvedObstacle, &Units),
    pose: Pose,
    points: &[[f64; 3]],
) -> [f64; 2] {
    let found = points::contacts(&pose.of(obstacle, units), points);
    let start = [f64::INFINITY, f64::NEG_INFINITY];
    found.iter().fold(start, |[least, most], one| {
        [least.min(one.distance), most.max(one.distance)]
    })
}

/// The key of a shape without a bound that decides which of its sides is free, and what to do.
fn cure(shape: &Shape) -> Option<(&'static str, String)> {
    match shape {
        Shape::HalfSpace { normal, .. } => {
            // Zeros keep their sign.
            let [x, y, z] = normal.map(|component| 0.0 - component);
            let turned = format!(
                "its normal points to the free side, where the body has to be; turn it to [{x}, {y}, {z}]"
            );
            Some(("shape.normal", turned))
        }
        Shape::HeightField(_) => {
            let above = "its free side is above the heights; move the body there, or lower them";
            Some(("shape", above.to_owned()))
        }
        Shape::Cavity(_) => {
            let outside = "`inside = true` makes all outside of the shape solid; leave it out, or put the shape around the body";
            Some(("shape.inside", outside.to_owned()))
        }
        Shape::Sphere { .. }
        | Shape::Cylinder { .. }
        | Shape::CappedCylinder { .. }
        | Shape::Box { .. }
        | Shape::Torus { .. }
        | Shape::Cone { .. }
        | Shape::Surface(_)
        | Shape::DistanceGrid(_) => None,
    }
}

/// Refuses half-spaces that hold the whole body, where steps are known and move no support: what
/// a session does to its obstacles later is not known when it begins, nor is it for what is wider
/// than the body and may be led over it.
///
/// # Errors
/// [`SceneError::Invalid`] with every such obstacle.
pub(super) fn refuse(
    (given, built): (&[scene::Obstacle], &[ResolvedObstacle]),
    steps: &[Step],
    body: ScaledMesh<'_>,
) -> Result<(), SceneError> {
    let mut faults = Faults::default();
    let is_known = !steps.is_empty() && steps.iter().all(|step| step.supports.is_empty());
    let all = given.iter().zip(built).filter(|_| is_known);
    for pair in all.filter(|(given, _)| matches!(given.shape, Shape::HalfSpace { .. })) {
        if let Some(found) = behind(pair, steps, body) {
            faults.add(
                format!("obstacle.{}.{}", pair.1.name, found.key),
                found.message,
            );
        }
    }
    faults.result()
}
