//! What supports prescribe: the held components of the displacement under a drive,
//!
//! ```text
//! u(X) = value profile(X) + given(X) + m(X) - X
//! ```
//!
//! given the values of another code at the node, m the rigid motion of the support; at edges the correction that makes the midpoint
//! take its value. Non-dimensional. Cost: some 20 flops a held entry.

use super::Model;
use super::carry::carried_stiff;
use super::drive::Drive;
use super::state::State;
use crate::geometry::vector3::{add, dot, scale, sub};
use crate::linalg::vector::add_scaled;
use crate::linalg::{LinearOperator, SparseRows, Workspace};
use crate::plan::Plan;
use crate::plan::held_nodes::HeldPlane;

/// Motion of a support, over the body's length, that rounding leaves.
const SETTLED: f64 = 1e-14;

/// A motion of the supports.
pub(crate) struct Motion {
    /// Of the held entries, zero elsewhere `[displacement]`.
    pub(crate) held: Vec<f64>,
    /// Of what they carry along `[displacement]`; none where that is nothing.
    pub(crate) carried: Option<Vec<f64>>,
}

impl Motion {
    /// Both parts `[displacement]`.
    pub(crate) fn whole(&self) -> Vec<f64> {
        let mut whole = self.held.clone();
        if let Some(carried) = &self.carried {
            add_scaled(&mut whole, 1.0, carried);
        }
        whole
    }

    /// Moves gaps by what is carried, to first order by their `rows`.
    pub(crate) fn move_gaps(&self, rows: &SparseRows, gaps: &mut [f64], work: &mut Workspace) {
        if let Some(carried) = &self.carried {
            rows.subtract_product(carried, gaps, work);
        }
    }
}

/// Sets the held components of `displacement` to the values of `drive`.
pub(crate) fn prescribe(model: &Model<'_>, drive: &Drive, displacement: &mut [f64]) {
    let space = &model.prepared.space;
    let c = space.components;
    for &(unknown, support) in &model.plan.problem.held {
        let (node, i) = (unknown as usize / c, unknown as usize % c);
        let position = || space.node_place(model.mesh, node as u32);
        let value = prescribed_value(model.plan, drive, (usize::from(support), i), &position);
        let given = drive.given.supports.get(usize::from(support));
        let given = given.map_or(0.0, |spread| spread.nodes.at(node as u32)[i]);
        let value = value + given / model.plan.problem.units.length;
        displacement[unknown as usize] = match node.checked_sub(space.vertices) {
            None => value,
            // Both ends are held too and, being vertices, already set.
            Some(edge) => {
                let [a, b] = space.edges[edge].map(|v| displacement[v as usize * c + i]);
                value - 0.5 * (a + b)
            }
        };
    }
    prescribe_planes(model, drive, displacement);
}

/// Sets what planes across no axis hold; components that are held have their values already.
fn prescribe_planes(model: &Model<'_>, drive: &Drive, displacement: &mut [f64]) {
    let space = &model.prepared.space;
    let c = space.components;
    for one in &model.plan.problem.held_nodes {
        let node = one.held.node as usize;
        let wanted = one
            .planes
            .iter()
            .map(|plane| value_of_plane(model, drive, plane));
        let wanted: Vec<f64> = wanted.collect();
        let row = |all: &[f64], node: usize| -> [f64; 3] {
            std::array::from_fn(|i| if i < c { all[node * c + i] } else { 0.0 })
        };
        let mean = match node.checked_sub(space.vertices) {
            None => [0.0; 3],
            Some(edge) => {
                let [a, b] = space.edges[edge].map(|v| row(displacement, v as usize));
                scale(0.5, add(a, b))
            }
        };
        let mut own = add(row(displacement, node), mean);
        let targets = one.targets(&wanted, own);
        for (direction, target) in one.held.directions().iter().zip(targets) {
            own = add(own, scale(target - dot(own, *direction), *direction));
        }
        let own = sub(own, mean);
        displacement[node * c..(node + 1) * c].copy_from_slice(&own[..c]);
    }
}

/// n . u on a plane, non-dimensional: supports of planes do not rotate.
fn value_of_plane(model: &Model<'_>, drive: &Drive, plane: &HeldPlane) -> f64 {
    let support = usize::from(plane.support);
    let value = drive.supports.get(support).map_or(0.0, |values| values[0]);
    let motion = drive.motions.get(support).copied().unwrap_or_default();
    (value + dot(plane.normal, motion.translation)) / model.plan.problem.units.length
}

/// How far held entries still are from where `drive` wants them; none where they are there, and
/// always for linear bodies.
pub(crate) fn remaining_motion(model: &Model<'_>, state: &State, drive: &Drive) -> Option<Motion> {
    model.prepared.strain.as_ref()?;
    let mut goal = state.displacement.clone();
    prescribe(model, drive, &mut goal);
    goal.iter_mut()
        .zip(&state.displacement)
        .for_each(|(goal, u)| *goal -= u);
    let mut motion = vec![0.0; goal.len()];
    model.prepared.held.add_held(1.0, &goal, &mut motion);
    let largest = motion.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    (largest > SETTLED).then(|| Motion {
        carried: carried_stiff(model, &motion),
        held: motion,
    })
}

/// What `support` prescribes for component `i` at a position in the coordinates
/// of the mesh, non-dimensional; zero for what the axis holds.
pub(crate) fn prescribed_value(
    plan: &Plan,
    drive: &Drive,
    (support, i): (usize, usize),
    position: &dyn Fn() -> [f64; 3],
) -> f64 {
    let length = plan.problem.units.length;
    let scale = plan.problem.units.coordinate_scale * length;
    let (Some(values), Some(held)) = (
        drive.supports.get(support),
        plan.problem.resolved.supports.get(support),
    ) else {
        return 0.0;
    };
    let is_plane = !held.planes.is_empty();
    let value = match (&plan.problem.resolved.manufactured, &held.profile) {
        // The sum takes its sign from a zero.
        _ if is_plane => 0.0 + values[0] * held.normal_at(i, position()[i]).unwrap_or(0.0),
        (Some(field), _) => drive.load * field.displacement(position().map(|x| x * scale))[i],
        (None, Some(profile)) => values[i] * profile.at(position()),
        (None, None) => values[i],
    };
    let motion = &drive.motions[support];
    if motion.is_rest() {
        value / length
    } else {
        (value + motion.displacement(position().map(|x| x * scale))[i]) / length
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
                normal: None,
                displacement: [Some(0.5), Some(0.0), Some(0.0)],
                profile: Default::default(),
                values: None,
                load: Default::default(),
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
        let mut drive = Drive::first_target(&plan);
        drive.motions[0] = motion;
        let point = [0.0, 0.25, 0.75];
        let moved = motion.apply(point.map(|x| 3.0 * x));
        for i in 0..3 {
            let value =
                prescribed_value(&plan, &drive, (0, i), &|| point) * plan.problem.units.length;
            let held = [0.5, 0.0, 0.0][i];
            assert!((value - (moved[i] - 3.0 * point[i] + held)).abs() < 1e-14);
            let on_axis = prescribed_value(&plan, &drive, (usize::from(u16::MAX), i), &|| point);
            assert!(on_axis.abs() < f64::MIN_POSITIVE);
        }
    }
}
