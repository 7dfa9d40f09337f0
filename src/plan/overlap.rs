//! How far obstacles lie in the body before anything has moved:
//!
//! ```text
//! depth = max -d(x) over the vertices x that an obstacle may touch,   d in its first pose
//! ```
//!
//! Cost: one distance a vertex that may be touched.

use std::fmt;

use super::surfaces::vertices_of;
use super::units::ScaledMesh;
use crate::assembly::load::facet_measure;
use crate::obstacle::Contact;
use crate::proximity::points;
use crate::scene::validate::{Faults, ResolvedObstacle};
use crate::scene::{self, PenetrationPolicy, SceneError};

/// Depth over the length of the body from which on an obstacle is refused that shall not begin
/// inside it: above what coordinates in single precision leave of a touch.
pub(super) const REFUSED: f64 = 1e-6;
/// Depth over the length of the body from which on an obstacle begins inside it.
pub(super) const DEEP: f64 = 0.01;

/// An obstacle that begins inside the body, in the caller's units.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Overlap {
    /// Name of the obstacle.
    obstacle: String,
    /// Depth of the deepest vertex, length.
    depth: f64,
    /// Where that vertex lies.
    place: [f64; 3],
    /// Vertices inside, and all that the obstacle may touch.
    vertices: [usize; 2],
    /// Surface that these vertices stand for; of flat bodies its length.
    area: f64,
}

impl fmt::Display for Overlap {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            obstacle,
            depth,
            place: [x, y, z],
            vertices: [inside, all],
            area,
        } = self;
        // A depth that is refused may be small.
        let depth = if *depth < 1e-3 {
            format!("{depth:.2e}")
        } else {
            format!("{depth:.4}")
        };
        write!(
            out,
            "obstacle `{obstacle}` begins up to {depth} inside the body, at ({x:.4}, {y:.4}, {z:.4}), with {inside} of {all} vertices that it may touch, {area:.4} of the surface"
        )
    }
}

/// How an obstacle begins inside the body, deeper than some lengths of it somewhere.
pub(super) fn overlap(
    obstacle: &ResolvedObstacle,
    beyond: f64,
    ScaledMesh { mesh, units }: ScaledMesh<'_>,
) -> Option<Overlap> {
    let vertices = vertices_of(mesh, std::iter::once(&obstacle.facets));
    let place = |&vertex: &u32| mesh.coordinates()[vertex as usize];
    let scaled = |vertex: &u32| place(vertex).map(|x| x * units.coordinate_scale);
    let points: Vec<[f64; 3]> = vertices.iter().map(scaled).collect();
    let found = points::contacts(&*obstacle.shape, &points);
    let is_deep = |one: &Contact| one.distance < -beyond;
    let inside = found.iter().filter(|one| is_deep(one)).count();
    let by_depth = |a: &(_, &Contact), b: &(_, &Contact)| a.1.distance.total_cmp(&b.1.distance);
    let (vertex, deepest) = vertices.iter().zip(&found).min_by(by_depth)?;
    let is_inside = |vertex: &u32| {
        let place = vertices.binary_search(vertex);
        place.is_ok_and(|place| is_deep(&found[place]))
    };
    let area = |&facet: &u32| {
        let corners = mesh.facet(facet as usize);
        let share = corners.iter().filter(|one| is_inside(one)).count() as f64;
        let scale = units.coordinate_scale * units.length;
        facet_measure(mesh, corners, scale).0 * share / corners.len() as f64
    };
    (inside > 0).then(|| Overlap {
        obstacle: obstacle.name.clone(),
        depth: -deepest.distance * units.length,
        place: units.of_mesh(place(vertex)),
        vertices: [inside, vertices.len()],
        area: obstacle.facets.iter().map(area).sum(),
    })
}

/// Refuses obstacles that begin inside the body where the scene says so.
///
/// # Errors
/// [`SceneError::Invalid`] with every such obstacle.
pub(super) fn refuse(
    (given, built): (&[scene::Obstacle], &[ResolvedObstacle]),
    body: ScaledMesh<'_>,
) -> Result<(), SceneError> {
    let mut faults = Faults::default();
    let refused = given
        .iter()
        .zip(built)
        .filter(|(given, _)| given.initial_penetration == PenetrationPolicy::Reject);
    for (_, obstacle) in refused {
        if let Some(found) = overlap(obstacle, REFUSED, body) {
            let path = format!("obstacle.{}.initial_penetration", obstacle.name);
            faults.add(
                path,
                format!("{found}: move it out of the body, or `resolve` it"),
            );
        }
    }
    faults.result()
}
