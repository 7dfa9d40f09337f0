//! Held unknowns: u = given on the facets of supports, u_x = 0 on the axis of a
//! body of revolution. One visit per node of a held facet.

use std::collections::BTreeMap;

use crate::mesh::Mesh;
use crate::plan::surfaces::vertices_of;
use crate::scene::validate::{ON_AXIS, Resolved, rotates};
use crate::scene::{SceneError, SceneKind, Step, Violation};
use crate::space::TaylorHood;

/// In the place of a support: the axis of a body of revolution, where u_x = 0.
pub(crate) const AXIS: u16 = u16::MAX;

/// Held unknowns; where supports overlap, the first one named holds, those that name components
/// before those that hold planes.
pub(crate) fn held_unknowns(
    resolved: &Resolved,
    mesh: &Mesh,
    space: &TaylorHood,
) -> Vec<(u32, u16)> {
    let mut held = BTreeMap::new();
    let c = space.components as u32;
    for (index, support) in resolved.supports.iter().enumerate() {
        for &facet in &support.facets {
            for node in space.facet_nodes(mesh.facet(facet as usize)) {
                for i in 0..space.components {
                    if support.displacement[i].is_some() {
                        held.entry(node * c + i as u32).or_insert(index as u16);
                    }
                }
            }
        }
    }
    for (index, support) in resolved.supports.iter().enumerate() {
        for plane in &support.planes {
            let facets = plane.facets.iter();
            for node in facets.flat_map(|&f| space.facet_nodes(mesh.facet(f as usize))) {
                let unknown = node * c + plane.axis as u32;
                held.entry(unknown).or_insert(index as u16);
            }
        }
    }
    if resolved.kind == SceneKind::Axisymmetric {
        for node in nodes_on_axis(mesh, space) {
            // Of all supports and the axis, the axis holds.
            held.insert(node * space.components as u32, AXIS);
        }
    }
    held.into_iter().collect()
}

/// Vertices on x = 0, and midpoints between two of them.
pub(crate) fn nodes_on_axis(mesh: &Mesh, space: &TaylorHood) -> Vec<u32> {
    let most = ON_AXIS * mesh.extent();
    let is_on_axis = |vertex: u32| mesh.coordinates()[vertex as usize][0] <= most;
    let vertices = (0..space.vertices as u32).filter(|&vertex| is_on_axis(vertex));
    let edges = space.edges.iter().zip(space.vertices as u32..);
    let edges = edges.filter(|([a, b], _)| is_on_axis(*a) && is_on_axis(*b));
    vertices.chain(edges.map(|(_, node)| node)).collect()
}

/// Relative difference of prescribed values that counts as none.
const SAME: f64 = 1e-9;

/// A component that a support holds on some vertices.
struct Held {
    support: usize,
    component: usize,
    vertices: Vec<u32>,
    /// The caller's length, before any variation over the surface.
    value: f64,
}

/// What supports hold, in the order in which [`held_unknowns`] gives it to them: named
/// components, then planes.
fn held(resolved: &Resolved, mesh: &Mesh) -> Vec<Held> {
    let supports = || resolved.supports.iter().enumerate();
    let named = supports().flat_map(|(index, support)| {
        let values = support.displacement.into_iter().enumerate();
        values.filter_map(move |(component, value)| {
            Some(Held {
                support: index,
                component,
                vertices: vertices_of(mesh, std::iter::once(&support.facets)),
                value: value?,
            })
        })
    });
    let planes = supports().flat_map(|(index, support)| {
        support.planes.iter().map(move |plane| Held {
            support: index,
            component: plane.axis,
            vertices: vertices_of(mesh, std::iter::once(&plane.facets)),
            value: plane.outward * support.normal.unwrap_or(0.0),
        })
    });
    named.chain(planes).collect()
}

/// Supports that prescribe different values on shared vertices.
pub(crate) fn conflicts(resolved: &Resolved, mesh: &Mesh) -> Vec<String> {
    let mut holders: BTreeMap<(u32, usize), (usize, f64)> = BTreeMap::new();
    let mut found: BTreeMap<(usize, usize), usize> = BTreeMap::new();
    let supports = &resolved.supports;
    for held in held(resolved, mesh) {
        let profile = supports[held.support].profile.as_ref();
        for &vertex in &held.vertices {
            let point = mesh.coordinates()[vertex as usize];
            let value = profile.map_or(held.value, |profile| held.value * profile.at(point));
            let key = (vertex, held.component);
            let &mut (first, known) = holders.entry(key).or_insert((held.support, value));
            if (known - value).abs() > SAME * known.abs().max(value.abs()) {
                *found.entry((first, held.support)).or_default() += 1;
            }
        }
    }
    let name = |index: usize| &supports[index].name;
    found
        .into_iter()
        .map(|((first, second), count)| {
            format!(
                "supports `{}` and `{}` prescribe different values {count} times; `{}` holds",
                name(first),
                name(second),
                name(first)
            )
        })
        .collect()
}

impl crate::plan::Plan {
    /// Refuses a step that rotates planes which are held as components.
    ///
    /// # Errors
    /// [`SceneError::Unsupported`] with the key.
    pub(crate) fn check_turned_planes(&self, step: &Step) -> Result<(), SceneError> {
        let supports = self.problem.resolved.supports.iter();
        let mut held =
            supports.filter(|support| !support.planes.is_empty() || !support.oblique.is_empty());
        match held.find(|support| rotates(step, &support.name)) {
            None => Ok(()),
            Some(support) => Err(SceneError::Unsupported(Violation {
                path: format!("step.support.{}.rotation", support.name),
                message: "its planes are held at each node: give a step that rotates them with \
                          the scene"
                    .to_owned(),
            })),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::samples;
    use crate::plan::Plan;
    use crate::scene::{
        Formulation, Material, MaterialModel, Profile, RubberModel, Scene, Support, SupportTarget,
    };

    fn support(name: &str, normal: Option<f64>, x: Option<f64>) -> Support {
        Support {
            name: name.to_owned(),
            on: vec!["x0".to_owned()],
            normal,
            displacement: [x, None, None],
            profile: Profile::Constant,
            values: None,
            load: Default::default(),
        }
    }

    /// A clamped body of rubber with those supports besides.
    fn plan(others: Vec<Support>) -> Plan {
        let mut clamp = support("clamp", None, Some(0.0));
        clamp.on = vec!["x1".to_owned()];
        clamp.displacement = [Some(0.0); 3];
        let scene = Scene {
            materials: vec![Material {
                group: "body".to_owned(),
                model: MaterialModel::Rubber {
                    model: RubberModel::NeoHookean { shear_modulus: 1.0 },
                    bulk_modulus: None,
                    formulation: Formulation::Auto,
                },
            }],
            supports: [vec![clamp], others].concat(),
            ..Scene::default()
        };
        Plan::new(&scene, &[], &samples::cube(2)).expect("a valid scene")
    }

    #[test]
    fn planes_that_are_held_at_two_places_are_told() {
        let mesh = samples::cube(2);
        // Outwards is down the axis: 0.05 along the normal is -0.05 along x.
        for (first, second, is_told) in [
            ((Some(0.05), None), (Some(-0.05), None), true),
            ((None, Some(-0.05)), (Some(-0.05), None), true),
            ((Some(-0.05), None), (None, Some(-0.05)), true),
            ((None, Some(-0.05)), (Some(0.05), None), false),
            ((Some(0.05), None), (Some(0.05), None), false),
        ] {
            let two = vec![
                support("a", first.0, first.1),
                support("b", second.0, second.1),
            ];
            let told = conflicts(&plan(two).problem.resolved, &mesh);
            assert_eq!(!told.is_empty(), is_told, "{first:?} {second:?}: {told:?}");
        }
    }

    #[test]
    fn a_later_step_that_rotates_a_held_plane_is_refused_by_name() {
        let plan = plan(vec![support("wall", Some(0.0), None)]);
        let turned = |name: &str, rotation| Step {
            supports: vec![SupportTarget {
                name: name.to_owned(),
                rotation: Some(rotation),
                ..SupportTarget::default()
            }],
            ..Step::default()
        };
        assert!(plan.check_turned_planes(&turned("wall", [0.0; 3])).is_ok());
        assert!(plan.check_turned_planes(&turned("clamp", [0.1; 3])).is_ok());
        match plan.check_turned_planes(&turned("wall", [0.0, 0.0, 0.1])) {
            Err(SceneError::Unsupported(fault)) => {
                assert_eq!(fault.path, "step.support.wall.rotation");
            }
            other => panic!("{other:?}"),
        }
    }
}
