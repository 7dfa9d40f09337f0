//! The scene message into the library's scene.

mod accuracy;
mod boundary;
mod fluid;
mod questions;
mod solver;

use signorini::Plan;
use signorini::mesh::{Mesh, MeshId};
use signorini::report::FieldName;
use signorini::scene::{Probe, Scene, SceneError, SceneKind, Step, Violation};
use signorini_proto::v1 as wire;

use super::uploaded::SurfacesByName;
use super::values::values;
use super::{Faults, MOST_FAULTS, field, material, mesh, named, step};
use crate::config::Compared;
use crate::fault::Fault;
pub(crate) use accuracy::take_accuracy;
use boundary::{contact, obstacle, pressure, support, tie, traction};
use fluid::fluid;
use questions::questions;
use solver::solver;

const MAXIMUM_LIST: usize = 4096;
const MAXIMUM_OBSTACLES: usize = 1000;
const MAXIMUM_FLUIDS: usize = 64;
const MAXIMUM_GRADIENTS: usize = 100;
const MAXIMUM_GOALS: usize = 1000;
const MAXIMUM_CONTACTS: usize = 256;
const MAXIMUM_TIES: usize = 256;
const MAXIMUM_PROBES: usize = 10_000;
const MAXIMUM_STEPS: usize = 10_000;
const MAXIMUM_EVERY: u32 = 100_000;

/// Everything that a scene message says.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SceneRequest {
    pub(crate) mesh: MeshId,
    pub(crate) scene: Scene,
    pub(crate) steps: Vec<Step>,
    pub(crate) output: Output,
    /// Methods that nobody knows; the scene leaves these choices to the plan.
    misnamed: Vec<Violation>,
}

impl SceneRequest {
    /// The scene and its steps.
    ///
    /// # Errors
    /// `SceneInvalid` with the methods that nobody knows.
    pub(crate) fn into_parts(self) -> Result<(Scene, Vec<Step>), Fault> {
        if self.misnamed.is_empty() {
            Ok((self.scene, self.steps))
        } else {
            Err(Fault::SceneInvalid(self.misnamed))
        }
    }

    /// Plans on `mesh`, by the solver's own methods and those `compared`. Whatever is wrong is told at once, unknown methods after
    /// the faults that the library finds.
    ///
    /// # Errors
    /// `SceneInvalid`, `Unsupported`.
    pub(crate) fn plan(&self, mesh: &Mesh, compared: &Compared) -> Result<Plan, Fault> {
        let methods = compared.methods();
        let planned = Plan::with_comparisons(&self.scene, &self.steps, mesh, methods);
        if self.misnamed.is_empty() {
            return Ok(planned?);
        }
        let mut faults = match planned {
            Err(SceneError::Invalid(faults)) => faults,
            Ok(_) | Err(SceneError::Unsupported(_)) => Vec::new(),
        };
        faults.extend_from_slice(&self.misnamed);
        faults.truncate(MOST_FAULTS);
        Err(Fault::SceneInvalid(faults))
    }
}

/// Fields that come with results.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Output {
    pub(crate) fields: Vec<FieldName>,
    /// Every n-th increment, 1 to [`MAXIMUM_EVERY`].
    pub(crate) every: u32,
}

/// Converts a scene.
///
/// # Errors
/// `SceneInvalid` with the paths of all malformed keys, `Unsupported` for a key
/// of a later version, `RequestInvalid` for a malformed mesh name.
pub(crate) fn scene(
    message: wire::Scene,
    surfaces: &SurfacesByName,
) -> Result<SceneRequest, Fault> {
    let mesh = mesh::id_from_name(&message.mesh, "mesh")?;
    let mut faults = Faults::default();
    limits(&message, &mut faults);
    faults.refuse()?;
    unit_names(message.units.as_ref(), &mut faults);
    let output = output(message.output.as_ref(), &mut faults);
    if let Some(asked) = &message.accuracy {
        accuracy::of_session(asked, &mut faults);
    }
    let steps = steps(message.steps.iter(), &mut faults);
    let scene = body(message, surfaces, &mut faults);
    let misnamed = std::mem::take(&mut faults.misnamed);
    faults.outcome()?;
    Ok(SceneRequest {
        mesh,
        scene,
        steps,
        output,
        misnamed,
    })
}

fn limits(message: &wire::Scene, faults: &mut Faults) {
    faults.at_most(&message.materials, MAXIMUM_LIST, "material");
    faults.at_most(&message.supports, MAXIMUM_LIST, "support");
    faults.at_most(&message.tractions, MAXIMUM_LIST, "traction");
    faults.at_most(&message.pressures, MAXIMUM_LIST, "pressure");
    faults.at_most(&message.fluids, MAXIMUM_FLUIDS, "fluid");
    faults.at_most(&message.obstacles, MAXIMUM_OBSTACLES, "obstacle");
    faults.at_most(&message.contacts, MAXIMUM_CONTACTS, "contact");
    faults.at_most(&message.ties, MAXIMUM_TIES, "tie");
    faults.at_most(&message.probes, MAXIMUM_PROBES, "probe");
    faults.at_most(&message.gradients, MAXIMUM_GRADIENTS, "gradient");
    for (index, gradient) in message.gradients.iter().enumerate() {
        faults.at_most(
            &gradient.of,
            MAXIMUM_GOALS,
            &format!("gradient[{index}].of"),
        );
        faults.at_most(
            &gradient.to,
            MAXIMUM_GOALS,
            &format!("gradient[{index}].to"),
        );
    }
    if let Some(accuracy) = &message.accuracy {
        faults.at_most(&accuracy.bound, MAXIMUM_GOALS, "accuracy.bound");
        faults.at_most(&accuracy.targets, MAXIMUM_GOALS, "accuracy");
    }
    faults.at_most(&message.steps, MAXIMUM_STEPS, "step");
}

/// Units are for the caller's pictures: their names are not too long, and nothing else.
fn unit_names(units: Option<&wire::UnitNames>, faults: &mut Faults) {
    let Some(units) = units else { return };
    for (name, path) in [
        (&units.length, "units.length"),
        (&units.force, "units.force"),
        (&units.stress, "units.stress"),
    ] {
        faults.name(name, path);
    }
}

fn body(message: wire::Scene, surfaces: &SurfacesByName, faults: &mut Faults) -> Scene {
    Scene {
        name: faults.name(&message.name, "name"),
        mesh_scale: message.mesh_scale,
        kind: kind(message.kind, faults),
        materials: collect(message.materials, faults, |one, _, faults| {
            material::material(one, faults)
        }),
        supports: collect(message.supports, faults, support),
        tractions: collect(message.tractions, faults, traction),
        pressures: collect(message.pressures, faults, pressure),
        fluids: collect(message.fluids, faults, fluid),
        body_force: faults
            .optional_vector(&message.body_force, "body_force.value")
            .unwrap_or_default(),
        body_force_values: values(
            message.body_force_values.as_ref(),
            "body_force.values",
            faults,
        ),
        obstacles: collect(message.obstacles, faults, |one, index, faults| {
            obstacle(one, index, (surfaces, faults))
        }),
        contacts: collect(message.contacts, faults, contact),
        ties: collect(message.ties, faults, tie),
        manufactured: (!message.manufactured.is_empty())
            .then(|| faults.name(&message.manufactured, "manufactured.field")),
        probes: collect(message.probes, faults, probe),
        questions: questions(message.gradients, message.accuracy, faults),
        solver: solver(message.solver.unwrap_or_default(), faults),
    }
}

fn collect<W, D>(
    list: Vec<W>,
    faults: &mut Faults,
    convert: impl Fn(W, usize, &mut Faults) -> D,
) -> Vec<D> {
    let numbered = list.into_iter().enumerate();
    numbered
        .map(|(index, one)| convert(one, index, faults))
        .collect()
}

fn kind(number: i32, faults: &mut Faults) -> Option<SceneKind> {
    match wire::SceneKind::try_from(number) {
        Ok(wire::SceneKind::Unspecified) => None,
        Ok(wire::SceneKind::Solid) => Some(SceneKind::Solid),
        Ok(wire::SceneKind::PlaneStrain) => Some(SceneKind::PlaneStrain),
        Ok(wire::SceneKind::PlaneStress) => Some(SceneKind::PlaneStress),
        Ok(wire::SceneKind::Axisymmetric) => Some(SceneKind::Axisymmetric),
        Err(_) => {
            faults.later("kind", format!("kind number {number} is not known here"));
            None
        }
    }
}

fn probe(message: wire::Probe, index: usize, faults: &mut Faults) -> Probe {
    let path = named("probe", &message.name, index);
    Probe {
        name: faults.name(&message.name, &path),
        point: faults.vector(&message.point, &format!("{path}.point")),
    }
}

fn steps<'a>(list: impl Iterator<Item = &'a wire::LoadStep>, faults: &mut Faults) -> Vec<Step> {
    let numbered = list.enumerate();
    numbered
        .map(|(index, one)| step::step(one, &format!("step[{index}]"), faults))
        .collect()
}

fn output(message: Option<&wire::Output>, faults: &mut Faults) -> Output {
    let numbers = message.map_or(&[][..], |output| &output.fields);
    let fields = field::names(numbers, "output.fields").unwrap_or_else(|fault| {
        if let Fault::RequestInvalid(one) = fault {
            faults.add(one.path, one.message);
        }
        Vec::new()
    });
    let every = message.and_then(|output| output.every).unwrap_or(1);
    let every = u32::try_from(every)
        .ok()
        .filter(|every| (1..=MAXIMUM_EVERY).contains(every))
        .unwrap_or_else(|| {
            let message = format!("must lie between 1 and {MAXIMUM_EVERY}, not {every}");
            faults.add("output.every", message);
            1
        });
    Output { fields, every }
}

#[cfg(test)]
mod tests {
    use signorini::mesh::{CellKind, MeshParts};
    use signorini::scene::{
        Choice, ElementKind, Formulation, MaterialModel, PenetrationPolicy, Profile,
    };

    use super::*;

    #[test]
    fn names_of_units_are_names_and_nothing_else() {
        let convert = |stress: &str| {
            let mut faults = Faults::default();
            let units = wire::UnitNames {
                length: "mm".into(),
                stress: stress.into(),
                ..Default::default()
            };
            unit_names(Some(&units), &mut faults);
            faults.outcome()
        };
        assert!(convert("").is_ok());
        assert!(convert("N/mm\u{b2}").is_ok());
        for wrong in ["x".repeat(257), "MPa\n".to_owned()] {
            let Err(Fault::SceneInvalid(violations)) = convert(&wrong) else {
                unreachable!("{wrong}");
            };
            assert_eq!(violations[0].path, "units.stress");
        }
    }

    fn flow() -> wire::Scene {
        wire::Scene {
            mesh: format!("meshes/{}", "0".repeat(64)),
            materials: vec![wire::Material {
                group: "body".into(),
                model: Some(wire::material::Model::Stokes(wire::Stokes {
                    viscosity: Some(0.5),
                })),
                ..Default::default()
            }],
            supports: vec![wire::Support {
                name: "inflow".into(),
                on: vec!["x0".into()],
                profile: wire::SupportProfile::Parabolic.into(),
                ..Default::default()
            }],
            solver: Some(wire::SolverOptions {
                element: "taylor-hood".into(),
                ..Default::default()
            }),
            ..Default::default()
        }
    }

    #[test]
    fn flow_profile_and_element_reach_the_library() {
        let scene = scene(flow(), &SurfacesByName::default()).unwrap().scene;
        let law = MaterialModel::Stokes {
            viscosity: 0.5,
            formulation: Formulation::Auto,
        };
        assert_eq!(scene.materials[0].model, law);
        assert_eq!(scene.supports[0].profile, Profile::Parabolic);
        assert_eq!(scene.solver.element, Choice::Named(ElementKind::TaylorHood));
    }

    #[test]
    fn unknown_methods_are_told_with_the_faults_that_planning_finds() {
        let mut message = flow();
        message.solver = Some(wire::SolverOptions {
            saddle: "gccr".into(),
            contact: "auto".into(),
            ..Default::default()
        });
        let cell = MeshParts {
            coordinates: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            cell_kind: CellKind::Triangle,
            cells: vec![0, 1, 2],
            facets: Vec::new(),
            groups: Vec::new(),
        };
        let mesh = Mesh::new(cell).unwrap();
        match scene(message, &SurfacesByName::default())
            .unwrap()
            .plan(&mesh, &Compared::default())
        {
            Err(Fault::SceneInvalid(all)) => {
                let last = all.last().expect("a fault");
                assert_eq!(last.path, "solver.saddle");
                assert_eq!(last.message, "unknown method `gccr`; did you mean `gcr`?");
                assert!(all.iter().any(|one| one.path == "material.body"), "{all:?}");
            }
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_profile_of_a_later_contract_is_refused_by_its_key() {
        let mut message = flow();
        message.supports[0].profile = 7;
        match scene(message, &SurfacesByName::default()) {
            Err(Fault::Unsupported(one)) => assert_eq!(one.path, "support.inflow.profile"),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn what_follows_a_start_inside_the_body_reaches_the_library_or_is_refused_by_its_key() {
        let convert = |policy: i32| {
            let mut message = flow();
            let sphere = wire::Sphere {
                centre: vec![0.0; 3],
                radius: Some(1.0),
            };
            message.obstacles = vec![wire::Obstacle {
                name: "ball".into(),
                on: vec!["x1".into()],
                shape: Some(wire::Shape {
                    kind: Some(wire::shape::Kind::Sphere(sphere)),
                    inside: false,
                }),
                initial_penetration: policy,
                ..Default::default()
            }];
            scene(message, &SurfacesByName::default())
        };
        let expected = [
            PenetrationPolicy::Resolve,
            PenetrationPolicy::Resolve,
            PenetrationPolicy::Reject,
        ];
        for (number, policy) in (0..).zip(expected) {
            let found = convert(number).unwrap().scene;
            assert_eq!(found.obstacles[0].initial_penetration, policy);
        }
        match convert(3) {
            Err(Fault::Unsupported(one)) => {
                assert_eq!(one.path, "obstacle.ball.initial_penetration");
            }
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_viscosity_is_required() {
        let mut message = flow();
        message.materials[0].model = Some(wire::material::Model::Stokes(wire::Stokes::default()));
        match scene(message, &SurfacesByName::default()) {
            Err(Fault::SceneInvalid(all)) => assert_eq!(all[0].path, "material.body.viscosity"),
            other => panic!("{other:?}"),
        }
    }
}
