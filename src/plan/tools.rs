//! What tools are to do on their way through the steps, before anything is solved: how many
//! faces may touch each and how far it goes, and in sentences
//!
//! | doubt | found by |
//! |---|---|
//! | coarse for the contact | the half width a = sqrt(R d) of Hertz, from the depth d of the body at rest and the radius R of the tool there, below all edges that may touch it |
//! | beyond the heights | vertices that may touch a height field outside its nodes, in some pose |
//!
//! Poses are those that steps name; what follows from pushes is not known here. Cost: one
//! distance a vertex and pose.

use super::poses::{Pose, poses, some};
use super::report::PlanEntry;
use super::surfaces::{ContactLayout, vertices_of};
use super::{Units, doubts};
use crate::geometry::vector3::{norm, sub};
use crate::geometry::{RigidMotion, rigid_motion};
use crate::mesh::Mesh;
use crate::obstacle::grid::HeightField;
use crate::obstacle::{Contact, Obstacle, Shape, What, larger_curvature};
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
            (false, false) => "is not led".to_owned(),
            (true, false) => format!("goes {way:.3} lengths of the body"),
            (false, true) => format!("turns by {turn:.0} degrees"),
            (true, true) => {
                format!("goes {way:.3} lengths of the body, turns by {turn:.0} degrees")
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
    (mesh, units): (&Mesh, &Units),
) -> Vec<String> {
    let mut all = Vec::new();
    for (given, obstacle) in shapes.iter().zip(obstacles) {
        let poses = some(&poses(&obstacle.name, steps));
        all.extend(coarse(obstacle, &poses, (mesh, units)));
        if let Shape::HeightField(field) = &given.shape {
            all.extend(beyond(obstacle, (field, &poses), (mesh, units)));
        }
    }
    all
}

/// A contact that is narrower than the faces.
fn coarse(
    obstacle: &ResolvedObstacle,
    poses: &[Pose],
    (mesh, units): (&Mesh, &Units),
) -> Option<String> {
    if obstacle.shape.is_flat() {
        return None;
    }
    let scaled =
        |vertex: u32| mesh.coordinates()[vertex as usize].map(|x| x * units.coordinate_scale);
    let points: Vec<[f64; 3]> = vertices_of(mesh, std::iter::once(&obstacle.facets))
        .into_iter()
        .map(scaled)
        .collect();
    let deepest = poses
        .iter()
        .filter_map(|pose| deepest(obstacle, *pose, (&points, units)));
    let (depth, radius) = deepest.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let half_width = (radius * depth).sqrt() * units.length;
    let face = doubts::finest_face(obstacle, (mesh, units));
    // A tool that is smaller than the faces is doubted as such.
    (half_width < face && face <= radius * units.length).then(|| {
        format!(
            "obstacle `{}` may touch over a half width of {half_width:.3}, all edges there are longer, from {face:.3} on: a finer mesh sees the contact",
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
    let mut found = vec![Contact::default(); points.len()];
    moved.probe(points, What::Gap, &mut found);
    let by_depth = |a: &(_, &Contact), b: &(_, &Contact)| a.1.distance.total_cmp(&b.1.distance);
    let (point, contact) = points.iter().zip(&found).min_by(by_depth)?;
    let depth = -contact.distance;
    let bent = moved.distance(*point).curvature;
    let largest = larger_curvature(&bent);
    // That of the surface outside the point.
    (depth > TOUCH && largest > 0.0).then(|| (depth, 1.0 / largest + depth))
}

/// Vertices beside the nodes of a height field.
fn beyond(
    obstacle: &ResolvedObstacle,
    (field, poses): (&HeightField, &[Pose]),
    (mesh, units): (&Mesh, &Units),
) -> Option<String> {
    let lattice = field.lattice();
    let vertices = vertices_of(mesh, std::iter::once(&obstacle.facets));
    let is_beyond = |pose: &Pose, vertex: u32| {
        let motion = RigidMotion {
            translation: pose.translation,
            rotation: pose.rotation,
            about: [0.0; 3],
        };
        let place = units.of_mesh(mesh.coordinates()[vertex as usize]);
        let back =
            rigid_motion::multiply_transposed(&motion.matrix(), sub(place, pose.translation));
        (0..2).any(|axis| {
            let last = (lattice.counts[axis] - 1) as f64;
            let share = (back[axis] - lattice.origin[axis]) / lattice.spacing[axis];
            !(0.0..=last).contains(&share)
        })
    };
    let count = |pose: &Pose| {
        vertices
            .iter()
            .filter(|&&vertex| is_beyond(pose, vertex))
            .count()
    };
    let most = poses.iter().map(count).max()?;
    (most > 0).then(|| {
        format!(
            "{most} of {} vertices that may touch obstacle `{}` lie beside the nodes of its heights, where it goes on as it ends",
            vertices.len(),
            obstacle.name
        )
    })
}
