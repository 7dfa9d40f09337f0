//! The body's constraints: candidate surfaces with their obstacles, and
//! prescribed displacements.

use std::sync::Arc;

use super::contact_metric::SurfaceMetric;
use super::drive::Drive;
use crate::contact::ContactSurface;
use crate::element::quadrature::{Rule, Simplex, rule};
use crate::mesh::Mesh;
use crate::obstacle::{Moving, Obstacle};
use crate::plan::{Plan, TaylorHoodData as Prepared};
use crate::scene::Shape;
use crate::scene::validate::shape;
use crate::space::TaylorHood;

/// Degree of the rule on contact faces: the distance to a curved obstacle
/// along a quadratic face is integrated to far below the tolerance.
const CONTACT_DEGREE: u32 = 8;

/// One obstacle and the surface that may touch it.
#[derive(Debug)]
pub(crate) struct Interface {
    pub(crate) name: String,
    pub(crate) surface: ContactSurface,
    shape: Arc<dyn Obstacle>,
    is_flat: bool,
    /// First multiplier.
    pub(crate) offset: usize,
}

impl Interface {
    /// Its multipliers among all.
    pub(crate) fn range(&self) -> std::ops::Range<usize> {
        self.offset..self.offset + self.surface.multipliers()
    }
}

/// All interfaces of a scene.
#[derive(Debug)]
pub(crate) struct Interfaces {
    pub(crate) list: Vec<Interface>,
    pub(crate) rule: Rule,
    /// Of the undeformed surfaces.
    pub(crate) metric: SurfaceMetric,
}

impl Interfaces {
    pub(crate) fn new(plan: &Plan, mesh: &Mesh, space: &TaylorHood) -> Self {
        let mut list = Vec::new();
        let mut offset = 0;
        for (obstacle, facets) in plan
            .scene
            .obstacles
            .iter()
            .zip(&plan.resolved.obstacle_facets)
        {
            // The plan has checked the parameters.
            let Ok(shape) = shape(&obstacle.shape, plan.units.length) else {
                continue;
            };
            let facets: Vec<Vec<u32>> = facets
                .iter()
                .map(|&f| mesh.facet(f as usize).to_vec())
                .collect();
            let scale = plan.units.coordinate_scale;
            let surface = match plan.is_axisymmetric() {
                true => ContactSurface::about_axis(mesh, space, scale, &facets),
                false => ContactSurface::new(mesh, space, scale, &facets),
            };
            let multipliers = surface.multipliers();
            list.push(Interface {
                name: obstacle.name.clone(),
                surface,
                shape,
                is_flat: matches!(obstacle.shape, Shape::HalfSpace { .. }),
                offset,
            });
            offset += multipliers;
        }
        let simplex = match plan.units.dimension {
            2 => Simplex::Segment,
            _ => Simplex::Triangle,
        };
        Self {
            metric: SurfaceMetric::new(plan, mesh, &list),
            list,
            rule: rule(simplex, CONTACT_DEGREE),
        }
    }

    /// Whether every gap is linear in the displacement.
    pub(crate) fn are_flat(&self) -> bool {
        self.list.iter().all(|interface| interface.is_flat)
    }

    /// The obstacles in the poses of `drive`, non-dimensional.
    pub(crate) fn obstacles(&self, drive: &Drive, length: f64) -> Vec<Moving> {
        self.list
            .iter()
            .zip(&drive.poses)
            .map(|(interface, pose)| {
                let translation = pose.translation.map(|x| x / length);
                Moving::new(interface.shape.clone(), translation, pose.rotation)
            })
            .collect()
    }
}

/// Sets the held components of `displacement` to the values of `drive`.
pub(crate) fn prescribe(
    plan: &Plan,
    mesh: &Mesh,
    prepared: &Prepared,
    drive: &Drive,
    displacement: &mut [f64],
) {
    let c = prepared.space.components;
    for &(unknown, support) in &plan.held {
        let (node, i) = (unknown as usize / c, unknown as usize % c);
        let position = || mesh_position(mesh, prepared, node);
        let value = prescribed_value(plan, drive, usize::from(support), i, &position);
        displacement[unknown as usize] = match node.checked_sub(prepared.space.vertices) {
            None => value,
            // Both ends are held too and, being vertices, already set.
            Some(edge) => {
                let [a, b] = prepared.space.edges[edge].map(|v| displacement[v as usize * c + i]);
                value - 0.5 * (a + b)
            }
        };
    }
}

/// What `support` prescribes for component `i` at a position in the coordinates
/// of the mesh, non-dimensional; zero for what the axis holds.
pub(crate) fn prescribed_value(
    plan: &Plan,
    drive: &Drive,
    support: usize,
    i: usize,
    position: &dyn Fn() -> [f64; 3],
) -> f64 {
    let length = plan.units.length;
    let scale = plan.units.coordinate_scale * length;
    let Some(values) = drive.supports.get(support) else {
        return 0.0;
    };
    let value = match (
        &plan.resolved.manufactured,
        &plan.resolved.profiles[support],
    ) {
        (Some(field), _) => drive.load * field.displacement(position().map(|x| x * scale))[i],
        (None, Some(profile)) => values[i] * profile.at(position()),
        (None, None) => values[i],
    };
    let motion = &drive.motions[support];
    match motion.is_rest() {
        true => value / length,
        false => (value + motion.displacement(position().map(|x| x * scale))[i]) / length,
    }
}

/// Position of a node in the coordinates of the mesh.
fn mesh_position(mesh: &Mesh, prepared: &Prepared, node: usize) -> [f64; 3] {
    let at = |vertex: usize| mesh.coordinates()[vertex];
    match node.checked_sub(prepared.space.vertices) {
        None => at(node),
        Some(edge) => {
            let [a, b] = prepared.space.edges[edge].map(|v| at(v as usize));
            std::array::from_fn(|i| 0.5 * (a[i] + b[i]))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::rigid_motion::RigidMotion;
    use crate::mesh::samples;
    use crate::scene::{Formulation, Material, MaterialModel, Modulus, Scene, Support};

    #[test]
    fn a_moving_support_carries_its_points_rigidly() {
        let scene = Scene {
            mesh_scale: Some(3.0),
            materials: vec![Material {
                group: "body".to_owned(),
                model: MaterialModel::LinearElastic {
                    modulus: Modulus::Shear(1.0),
                    poisson_ratio: 0.5,
                    formulation: Formulation::Auto,
                },
            }],
            supports: vec![Support {
                name: "wall".to_owned(),
                on: vec!["x0".to_owned()],
                displacement: [Some(0.5), Some(0.0), Some(0.0)],
                profile: Default::default(),
            }],
            ..Scene::default()
        };
        let mesh = samples::cube(1);
        let plan = Plan::new(&scene, &[], &mesh).expect("a valid scene");
        let motion = RigidMotion {
            translation: [0.1, 0.2, 0.3],
            rotation: [7.0, -1.0, 2.0],
            about: [0.0, 1.0, 0.0],
        };
        let mut drive = Drive::first_target(&scene);
        drive.motions[0] = motion;
        let point = [0.0, 0.25, 0.75];
        let moved = motion.apply(point.map(|x| 3.0 * x));
        for i in 0..3 {
            let value = prescribed_value(&plan, &drive, 0, i, &|| point) * plan.units.length;
            let held = [0.5, 0.0, 0.0][i];
            assert!((value - (moved[i] - 3.0 * point[i] + held)).abs() < 1e-14);
            let on_axis = prescribed_value(&plan, &drive, usize::from(u16::MAX), i, &|| point);
            assert!(on_axis.abs() < f64::MIN_POSITIVE);
        }
    }
}
