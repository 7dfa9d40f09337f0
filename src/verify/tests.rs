//! The independent path against energies and the solver's own follower load, in
//! bodies of space, of the plane, and about an axis.

use std::sync::Arc;

use super::*;
use crate::assembly::follower::{
    FollowerPressure, PressedBody, PressureValues, SurfaceMeasure, add_follower_load,
};
use crate::element::quadrature::{Simplex, rule};
use crate::linalg::vector::reproducible_noise;
use crate::mesh::{GroupKind, Mesh, samples};
use crate::model::conditions::Conditions;
use crate::model::interfaces::Interfaces;
use crate::plan::Plan;
use crate::prepare::TaylorHoodData;
use crate::report::CancelToken;
use crate::scene::validate::ResolvedPressure;
use crate::scene::{
    Formulation, Material, MaterialModel, Profile, RubberModel, Scene, Step, Support,
};

/// Everything of a session but its solves.
struct Body {
    mesh: Arc<Mesh>,
    plan: Plan,
    prepared: TaylorHoodData,
    interfaces: Interfaces,
    load: Vec<f64>,
}

impl Body {
    fn new(mesh: Mesh, kind: SceneKind) -> Self {
        let across = (mesh.cell_kind().dimension() == 3).then_some(0.0);
        let scene = Scene {
            supports: vec![Support {
                name: "wall".to_owned(),
                on: vec!["x0".to_owned()],
                normal: None,
                displacement: [Some(0.0), Some(0.0), across],
                profile: Profile::Constant,
                values: None,
                load: Default::default(),
            }],
            mesh_scale: Some(0.5),
            materials: vec![Material {
                group: "body".to_owned(),
                model: MaterialModel::Rubber {
                    model: RubberModel::Yeoh {
                        c10: 0.9,
                        c20: 0.2,
                        c30: 0.1,
                    },
                    bulk_modulus: Some(30.0),
                    formulation: Formulation::Auto,
                },
            }],
            ..Scene::default()
        };
        let mesh = Arc::new(mesh);
        let mut plan = Plan::new(&scene, &[Step::default()], &mesh).expect("a valid scene");
        let prepared =
            TaylorHoodData::build(&plan, &mesh, &CancelToken::new()).expect("a solvable body");
        let interfaces = Interfaces::new(&plan, &mesh, &prepared.space);
        // Only the independent path reads what is set from here on.
        plan.problem.resolved.kind = kind;
        let facets = ["x1", "y0"].map(|name| mesh.group(name, GroupKind::Facets));
        let facets = facets.iter().flatten().flat_map(|group| &group.members);
        plan.problem.resolved.pressures = vec![ResolvedPressure {
            facets: facets.copied().collect(),
            value: 0.7,
        }];
        let load = vec![0.0; prepared.space.displacement_unknowns()];
        Self {
            mesh,
            plan,
            prepared,
            interfaces,
            load,
        }
    }

    fn model(&self) -> Model<'_> {
        Model {
            plan: &self.plan,
            mesh: &self.mesh,
            prepared: &self.prepared,
            interfaces: &self.interfaces,
            load: &self.load,
            conditions: Conditions::to(1e-8),
        }
    }

    /// A state with strains of some ten percent and its displacement on nodes.
    fn state(&self) -> (State, Vec<[f64; 3]>) {
        let mut state = State::undeformed(&self.plan);
        state.drive.load = 1.0;
        let noise = reproducible_noise(state.displacement.len());
        let into = state.displacement.iter_mut().zip(&noise);
        into.for_each(|(u, x)| *u = 0.03 * x);
        let into = state.pressure.iter_mut().zip(&noise);
        into.for_each(|(p, x)| *p = 0.3 + 0.2 * x);
        let nodal = nodal_displacement(&self.model(), &state);
        (state, nodal)
    }

    /// int W - p (J - 1) - p^2 / 2K by the solver's rule.
    fn energy(&self, state: &State, nodal: &[[f64; 3]]) -> f64 {
        let model = self.model();
        let kind = self.mesh.cell_kind();
        let simplex = match kind.dimension() {
            2 => Simplex::Triangle,
            _ => Simplex::Tetrahedron,
        };
        let rule = rule(simplex, self.plan.strain_degree());
        let rubber = self.plan.problem.resolved.materials[0].rubber.as_ref();
        let rubber = rubber.expect("a rubber");
        let length = self.plan.problem.units.length * self.plan.problem.units.coordinate_scale;
        let mut energy = 0.0;
        for number in 0..self.mesh.cell_count() {
            let cell = cell::Cell::new(&model, number);
            let corners = self.mesh.corners(number).map(|x| x.map(|x| x * length));
            let vertices = self.mesh.cell(number);
            for (l, weight) in rule.points.iter().zip(&rule.weights) {
                let h = cell.point(&l[..vertices.len()], nodal).gradient;
                let at = vertices.iter().zip(l);
                let pressure: f64 = at.map(|(&v, l)| l * state.pressure[v as usize]).sum();
                let radius = l.iter().zip(&corners).map(|(l, x)| l * x[0]).sum();
                let measure = weight * kind.signed_measure(&corners) * turn(&model, radius);
                energy += measure * rubber.energy(&h, pressure * self.plan.problem.units.stress);
            }
        }
        energy
    }
}

fn bodies() -> [(Body, SurfaceMeasure); 3] {
    [
        (
            Body::new(samples::cube(2), SceneKind::Solid),
            SurfaceMeasure::Solid,
        ),
        (
            Body::new(samples::rectangle(3, 2), SceneKind::PlaneStrain),
            SurfaceMeasure::Plane,
        ),
        (
            Body::new(samples::rectangle(3, 2), SceneKind::Axisymmetric),
            SurfaceMeasure::Axisymmetric,
        ),
    ]
}

#[test]
fn forces_and_volume_defects_are_slopes_of_the_energy() {
    for (body, _) in bodies() {
        let (mut state, nodal) = body.state();
        let model = body.model();
        let (force, constraint) = volume::residuals(&model, &state, (&nodal, &nodal));
        let load = loads::external_load(&model, &state, &nodal);
        let (node, vertex) = (nodal.len() - 2, 3);
        for i in 0..body.mesh.cell_kind().dimension() {
            let energy = |length: f64| {
                let mut moved = nodal.clone();
                moved[node][i] += length;
                body.energy(&state, &moved)
            };
            let slope =
                (8.0 * (energy(1e-4) - energy(-1e-4)) - (energy(2e-4) - energy(-2e-4))) / 12e-4;
            let internal = load[node][i] - force[node][i];
            assert!((slope - internal).abs() < 1e-10, "{slope} {internal}");
            assert!(slope.abs() > 1e-3);
        }
        let mut energy = |length: f64| {
            state.pressure[vertex] += length;
            let energy = body.energy(&state, &nodal);
            state.pressure[vertex] -= length;
            energy
        };
        let slope = (energy(1e-3) - energy(-1e-3)) / (2e-3 * body.plan.problem.units.stress);
        assert!((slope + constraint[vertex]).abs() < 1e-12);
        assert!(slope.abs() > 1e-5);
    }
}

#[test]
fn the_formula_of_nanson_gives_the_load_of_deformed_faces() {
    for (body, measure) in bodies() {
        let (state, nodal) = body.state();
        let found = loads::external_load(&body.model(), &state, &nodal);
        let units = &body.plan.problem.units;
        let pressed = PressedBody {
            mesh: &body.mesh,
            scale: units.coordinate_scale,
            space: &body.prepared.space,
            measure,
            displacement: &state.displacement,
        };
        let pressures = [FollowerPressure {
            facets: &body.plan.problem.resolved.pressures[0].facets,
            pressure: PressureValues::Uniform(
                body.plan.problem.resolved.pressures[0].value / units.stress,
            ),
        }];
        let mut load = vec![0.0; state.displacement.len()];
        add_follower_load(&pressed, &pressures, &mut load);
        let load = body.prepared.space.node_forces(&load);
        let unit = match measure {
            SurfaceMeasure::Solid | SurfaceMeasure::Plane => units.force(),
            SurfaceMeasure::Axisymmetric => units.force() * units.length,
        };
        let c = body.prepared.space.components;
        for (found, expected) in found.iter().zip(load.chunks_exact(c)) {
            for i in 0..c {
                assert!((found[i] - expected[i] * unit).abs() < 1e-14);
            }
        }
        assert!(load.iter().any(|force| force.abs() > 1e-2));
    }
}
