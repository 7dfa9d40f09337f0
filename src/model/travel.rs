//! How far obstacles move beside the faces that may touch them, and how near they come, where
//! drives put them and displacements the body ([`crate::proximity`]). Cost: a pass over the faces,
//! and some distances a face.

use super::Model;
use super::drive::Drive;
use super::interfaces::Interface;
use crate::geometry::vector3::{norm, sub};
use crate::proximity::faces;
use crate::proximity::path;

/// How far `interface`'s obstacle moves between two drives at most, over its faces as each of
/// `displacements` `[displacement]` puts them.
pub(crate) fn travel(
    model: &Model<'_>,
    interface: &Interface,
    [start, end]: [&Drive; 2],
    displacements: &[&[f64]],
) -> f64 {
    let motion = |drive: &Drive| {
        let mut placed = model.placed(drive);
        let own = placed.find(|(other, _)| other.name == interface.name);
        own.and_then(|(_, met)| met.obstacle().map(|obstacle| obstacle.motion()))
    };
    let (Some(start), Some(end)) = (motion(start), motion(end)) else {
        return 0.0;
    };
    let reach = |centre: [f64; 3]| {
        let bodies = displacements.iter();
        let reaches = bodies.map(|displacement| reach(model, interface, displacement, centre));
        reaches.fold(0.0, f64::max)
    };
    path::length([start, end], reach)
}

/// Distance of the farthest node of the faces from `centre`; edges bend by less than their middles are off.
fn reach(model: &Model<'_>, interface: &Interface, displacement: &[f64], centre: [f64; 3]) -> f64 {
    let (mut farthest, mut bent) = (0.0_f64, 0.0_f64);
    for face in &interface.surface.faces {
        for &corner in &face.corners {
            let place = model.place(corner as usize, displacement);
            farthest = farthest.max(norm(sub(place, centre)));
        }
        for &node in face.nodes.iter().skip(face.corners.len()) {
            bent = bent.max(norm(model.place(node as usize, displacement)));
        }
    }
    farthest + bent
}

/// Signed distance of an obstacle from the body where `drive` puts it and `displacement` the
/// body.
pub(crate) fn least_distance(
    model: &Model<'_>,
    (drive, displacement): (&Drive, &[f64]),
    interface: &Interface,
) -> f64 {
    let mut placed = model.placed(drive);
    let met = placed.find(|(other, _)| other.name == interface.name);
    let body = model.deformed(displacement);
    let met = met.as_ref().and_then(|(_, met)| met.obstacle());
    met.map_or(f64::INFINITY, |obstacle| {
        let distances = faces::distances(&body, &interface.surface, obstacle);
        distances.into_iter().fold(f64::INFINITY, f64::min)
    })
}
