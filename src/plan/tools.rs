//! What tools are to do on their way through the steps, before anything is solved: how many
//! faces may touch each and how far it goes, and in sentences
//!
//! | doubt | found by |
//! |---|---|
//! | coarse for the contact | the half width a = sqrt(R d) of Hertz, from the depth d of the body at rest and the radius R of the tool there, below all edges that may touch it |
//! | away from the body, beside its nodes | [`reach`] |
//!
//! Poses are those that steps name; what follows from pushes is not known here. Cost: one
//! distance a vertex and pose.

use super::poses::{Pose, poses, some};
use super::report::PlanEntry;
use super::surfaces::{ContactLayout, vertices_of};
use super::units::ScaledMesh;
use super::{Units, doubts, reach};
use crate::geometry::vector3::{norm, sub};
use crate::mesh::Mesh;
use crate::obstacle::{Obstacle, larger_curvature};
use crate::proximity::points;
use crate::scene::validate::ResolvedObstacle;
use crate::scene::{self, Step};

/// Depth in lengths of the body up to which a tool lies at the body only.
const TOUCH: f64 = 1e-6;

/// One entry an obstacle: what may touch it, and its way.
pub(super) fn entries(
    obstacles: &[ResolvedObstacle],
    layouts: &[ContactLayout],
    (steps, units): (&[Step], &Units),
) -> Vec<PlanEntry> {
    let entry = |(obstacle, layout): (&ResolvedObstacle, &ContactLayout)| {
        let poses = poses(&obstacle.name, steps);
        let between = |of: fn(&Pose) -> [f64; 3]| -> f64 {
            let parts = poses
                .windows(2)
                .map(|pair| norm(sub(of(&pair[1]), of(&pair[0]))));
            parts.sum()
        };
        let way = between(|pose| pose.translation) / units.length;
        let turn = between(|pose| pose.rotation).to_degrees();
        let way = match (way > 0.0, turn > 0.0) {
            (false, false) => "no prescribed motion".to_owned(),
            (true, false) => format!("moves by {way:.3} lengths of the body"),
            (false, true) => format!("turns by {turn:.0} degrees"),
            (true, true) => {
                format!("moves by {way:.3} lengths of the body, turns by {turn:.0} degrees")
            }
        };
        PlanEntry {
            what: format!("obstacle {}", obstacle.name),
            choice: format!(
                "{} faces, {} pressures",
                obstacle.facets.len(),
                layout.multipliers.len()
            ),
            reason: way,
        }
    };
    obstacles.iter().zip(layouts).map(entry).collect()
}

/// All doubts about the tools of a scene.
pub(super) fn doubts(
    (shapes, obstacles): (&[scene::Obstacle], &[ResolvedObstacle]),
    steps: &[Step],
    ScaledMesh { mesh, units }: ScaledMesh<'_>,
) -> Vec<String> {
    let mut all = Vec::new();
    for (given, obstacle) in shapes.iter().zip(obstacles) {
        let way = poses(&obstacle.name, steps);
        let poses = some(&way);
        let vertices = vertices_of(mesh, std::iter::once(&obstacle.facets)).into_iter();
        let places: Vec<[f64; 3]> = vertices
            .map(|vertex| mesh.coordinates()[vertex as usize])
            .collect();
        let scaled = |place: &[f64; 3]| place.map(|x| x * units.coordinate_scale);
        let points: Vec<[f64; 3]> = places.iter().map(scaled).collect();
        all.extend(coarse(obstacle, &poses, (mesh, &points, units)));
        all.extend(reach::away(obstacle, (&way, steps), (&points, units)));
        let places: Vec<[f64; 3]> = places.into_iter().map(|x| units.of_mesh(x)).collect();
        all.extend(reach::beyond(
            (given.name.as_str(), &given.shape),
            &poses,
            &places,
        ));
    }
    all
}

/// A contact that is narrower than the faces.
fn coarse(
    obstacle: &ResolvedObstacle,
    poses: &[Pose],
    (mesh, points, units): (&Mesh, &[[f64; 3]], &Units),
) -> Option<String> {
    if obstacle.shape.is_flat() {
        return None;
    }
    let deepest = poses
        .iter()
        .filter_map(|pose| deepest(obstacle, *pose, (points, units)));
    let (depth, radius) = deepest.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let half_width = (radius * depth).sqrt() * units.length;
    let face = doubts::finest_face(obstacle, ScaledMesh { mesh, units });
    // A tool that is smaller than the faces is doubted as such.
    (half_width < face && face <= radius * units.length).then(|| {
        format!(
            "contact with obstacle `{}` may end {half_width:.3} from its middle, inside the facets there, the smallest of size {face:.3}: refine them, or take its pressures as rough",
            obstacle.name
        )
    })
}

/// Depth of the deepest point inside the obstacle in a pose, and the radius of the obstacle
/// there; none without either.
fn deepest(
    obstacle: &ResolvedObstacle,
    pose: Pose,
    (points, units): (&[[f64; 3]], &Units),
) -> Option<(f64, f64)> {
    let moved = pose.of(obstacle, units);
    let (point, distance) = points::nearest(&moved, points)?;
    let depth = -distance;
    let bent = moved.distance(points[point]).curvature;
    let largest = larger_curvature(&bent);
    // That of the surface outside the point.
    (depth > TOUCH && largest > 0.0).then(|| (depth, 1.0 / largest + depth))
}
