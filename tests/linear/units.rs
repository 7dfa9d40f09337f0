//! The caller's units do not matter: powers of two change no bit, other factors
//! change counts by at most one and results by rounding.

use crate::common::meshes::{cube, file_parts, irregular, mesh, moved, square};
use crate::common::scenes::{
    cube_bend, elastic, hertz_plane, hertz_sphere, mooney_rivlin, obstacle, push, rubber,
    small_indentation, support, traction,
};
use crate::common::solve_one;
use signorini::scene::{MaterialModel, Modulus, RubberModel, Shape};
use signorini::{MeshParts, Scene, Step, StepReport};

/// New units: factors of lengths and of stresses.
#[derive(Clone, Copy, Debug)]
struct Factors {
    length: f64,
    stress: f64,
}

fn scaled(vector: [f64; 3], factor: f64) -> [f64; 3] {
    vector.map(|x| x * factor)
}

impl Factors {
    fn scene(self, scene: &Scene) -> Scene {
        let mut scene = scene.clone();
        for material in &mut scene.materials {
            match &mut material.model {
                MaterialModel::LinearElastic {
                    modulus: Modulus::Shear(value) | Modulus::Young(value),
                    ..
                }
                | MaterialModel::Stokes {
                    viscosity: value, ..
                } => *value *= self.stress,
                MaterialModel::Rubber {
                    model,
                    bulk_modulus,
                    ..
                } => {
                    bulk_modulus.iter_mut().for_each(|k| *k *= self.stress);
                    self.law(model);
                }
            }
        }
        for support in &mut scene.supports {
            support.displacement = support.displacement.map(|x| x.map(|x| x * self.length));
        }
        for traction in &mut scene.tractions {
            traction.value = scaled(traction.value, self.stress);
        }
        scene.body_force = scaled(scene.body_force, self.stress / self.length);
        for obstacle in &mut scene.obstacles {
            match &mut obstacle.shape {
                Shape::HalfSpace { point, .. } => *point = scaled(*point, self.length),
                Shape::Sphere { centre, radius } => {
                    *centre = scaled(*centre, self.length);
                    *radius *= self.length;
                }
                Shape::Cylinder { point, radius, .. } => {
                    *point = scaled(*point, self.length);
                    *radius *= self.length;
                }
                Shape::CappedCylinder { .. }
                | Shape::Box { .. }
                | Shape::Torus { .. }
                | Shape::Cone { .. }
                | Shape::Surface(_)
                | Shape::HeightField(_)
                | Shape::DistanceGrid(_)
                | Shape::Cavity(_) => panic!("no scene here has such a tool"),
            }
        }
        for probe in &mut scene.probes {
            probe.point = scaled(probe.point, self.length);
        }
        scene
    }

    fn law(self, law: &mut RubberModel) {
        match law {
            RubberModel::MooneyRivlin { c10, c01 } => {
                [c10, c01].into_iter().for_each(|c| *c *= self.stress);
            }
            RubberModel::NeoHookean { shear_modulus } => *shear_modulus *= self.stress,
            RubberModel::Yeoh { c10, c20, c30 } => {
                [c10, c20, c30].into_iter().for_each(|c| *c *= self.stress);
            }
            RubberModel::Polynomial { coefficients } => {
                coefficients.iter_mut().for_each(|c| *c *= self.stress);
            }
            RubberModel::Gent { shear_modulus, .. } => *shear_modulus *= self.stress,
            RubberModel::ArrudaBoyce { mu, .. } => *mu *= self.stress,
            RubberModel::VanDerWaals { shear_modulus, .. }
            | RubberModel::BlatzKo { shear_modulus } => *shear_modulus *= self.stress,
            RubberModel::Ogden { mu, .. } | RubberModel::Hyperfoam { mu, .. } => {
                mu.iter_mut().for_each(|mu| *mu *= self.stress)
            }
        }
    }

    fn step(self, step: &Step) -> Step {
        let mut step = step.clone();
        for target in &mut step.obstacles {
            target.translation = target.translation.map(|t| scaled(t, self.length));
        }
        step
    }

    fn mesh(self, parts: &MeshParts) -> MeshParts {
        moved(parts.clone(), |x| scaled(x, self.length))
    }
}

/// Values of one kind in a report, the powers of length and stress in their
/// unit, and their size.
struct Quantity {
    name: &'static str,
    values: Vec<f64>,
    length: i32,
    stress: i32,
    size: f64,
}

fn norm(values: &[f64]) -> f64 {
    values.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn quantities(report: &StepReport, dimension: i32) -> Vec<Quantity> {
    let mut all = Vec::new();
    let mut push = |name, values: &[f64], length, stress, size: Option<f64>| {
        let values = values.to_vec();
        let size = size.unwrap_or(norm(&values));
        all.push(Quantity {
            name,
            values,
            length,
            stress,
            size,
        });
    };
    push("energy", &[report.strain_energy], dimension, 1, None);
    push("volume", &[report.volume_ratio], 0, 0, None);
    let jacobian: Vec<f64> = report.min_jacobian.into_iter().collect();
    push("jacobian", &jacobian, 0, 0, None);
    push("penetration", &[report.max_penetration], 1, 0, None);
    for obstacle in report.obstacles.values() {
        let area = dimension - 1;
        push("force", &obstacle.force, area, 1, None);
        // The moment of a frictionless sphere about its centre is rounding.
        push(
            "moment",
            &obstacle.moment,
            dimension,
            1,
            Some(norm(&obstacle.force)),
        );
        push("area", &[obstacle.contact_area], area, 0, None);
        push("peak", &[obstacle.max_pressure], 0, 1, None);
        push("centre", &obstacle.centre_of_pressure, 1, 0, None);
        push("extent", &[obstacle.deformed_contact_area], area, 0, None);
        let mean: Vec<f64> = obstacle.mean_pressure.into_iter().collect();
        push("mean", &mean, 0, 1, None);
        push("highest", &[obstacle.peak_pressure], 0, 1, None);
        for interval in &obstacle.contact_intervals {
            push("width", &[interval.width], 1, 0, None);
            push("start", &interval.start, 1, 0, None);
            push("end", &interval.end, 1, 0, None);
            push("force of the interval", &interval.force, area, 1, None);
        }
    }
    for support in report.supports.values() {
        push("reaction", &support.force, dimension - 1, 1, None);
    }
    for probe in report.probes.values() {
        push("displacement", &probe.displacement, 1, 0, None);
        push(
            "pressure",
            &probe.pressure.into_iter().collect::<Vec<_>>(),
            0,
            1,
            None,
        );
    }
    all
}

fn cases() -> Vec<(Scene, Step, MeshParts)> {
    let plane = || {
        let mut scene = elastic(0.5);
        scene.supports = vec![support("y0", [Some(0.0), Some(0.0), None])];
        scene.body_force = [0.1, -0.2, 0.0];
        scene.tractions = vec![traction("x1", [0.03, 0.01, 0.0])];
        let shape = Shape::Cylinder {
            point: [0.5, 1.7, 0.0],
            axis: [0.0, 0.0, 1.0],
            radius: 0.75,
        };
        scene.obstacles = vec![obstacle("roll", "y1", shape)];
        scene
    };
    let with = |(scene, step): (Scene, Step), parts| (scene, step, parts);
    let of_rubber = |scene: Scene, law, bulk_modulus| Scene {
        materials: rubber(law, bulk_modulus).materials,
        ..scene
    };
    let neo_hookean = RubberModel::NeoHookean { shear_modulus: 1.3 };
    vec![
        (cube_bend(0.5), Step::default(), irregular(cube(3), 3)),
        (cube_bend(0.3), Step::default(), irregular(cube(3), 3)),
        with(hertz_sphere(0.5), file_parts("indent_l1")),
        with(hertz_plane(0.3), file_parts("hemi_l1")),
        (plane(), Step::default(), irregular(square(6), 6)),
        (
            of_rubber(small_indentation(3).0, mooney_rivlin(), None),
            push("ball", [0.0, 0.0, -0.1]),
            irregular(cube(3), 3),
        ),
        (
            of_rubber(plane(), neo_hookean, Some(40.0)),
            Step::default(),
            irregular(square(6), 6),
        ),
    ]
}

fn dimension(parts: &MeshParts) -> i32 {
    parts.cell_kind.dimension() as i32
}

/// Everything countable, and the residuals, must be the same.
fn assert_bits(report: &StepReport, base: &StepReport, factors: Factors, dimension: i32) {
    assert_eq!(report.krylov_iterations, base.krylov_iterations);
    assert_eq!(report.active_vertices, base.active_vertices);
    assert_eq!(report.active_set_changes, base.active_set_changes);
    assert_eq!(report.residuals, base.residuals);
    for (new, old) in quantities(report, dimension)
        .iter()
        .zip(quantities(base, dimension))
    {
        let unit = factors.length.powi(old.length) * factors.stress.powi(old.stress);
        for (value, old_value) in new.values.iter().zip(&old.values) {
            let expected = (old_value * unit).to_bits();
            assert_eq!(value.to_bits(), expected, "{} {factors:?}", old.name);
        }
    }
}

#[test]
fn powers_of_two_change_no_bit() {
    let choices = [(1024.0, 1.0), (1.0, 1.0 / 128.0), (0.0625, 4096.0)];
    for (scene, step, parts) in cases() {
        let base = solve_one(&scene, &step, &mesh(parts.clone()));
        for (length, stress) in choices {
            let factors = Factors { length, stress };
            let (scene, step) = (factors.scene(&scene), factors.step(&step));
            let report = solve_one(&scene, &step, &mesh(factors.mesh(&parts)));
            assert_bits(&report, &base, factors, dimension(&parts));
        }
    }
}

#[test]
fn scaling_the_mesh_in_the_scene_is_scaling_its_coordinates() {
    let factors = Factors {
        length: 8.0,
        stress: 1.0,
    };
    for (scene, step, parts) in cases() {
        let base = solve_one(&scene, &step, &mesh(parts.clone()));
        let mut scene = factors.scene(&scene);
        scene.mesh_scale = Some(factors.length);
        let report = solve_one(&scene, &factors.step(&step), &mesh(parts.clone()));
        assert_bits(&report, &base, factors, dimension(&parts));
    }
}

#[test]
fn pascals_and_metres_give_what_megapascals_and_millimetres_do() {
    // From MPa and mm to Pa and m; to micrometres; and to both at once.
    let choices = [(1e-3, 1e6), (1e-6, 1.0), (1e6, 1e-9)];
    for (mut scene, step, parts) in cases() {
        scene.solver.tolerance = 1e-11;
        let base = solve_one(&scene, &step, &mesh(parts.clone()));
        for (length, stress) in choices {
            let factors = Factors { length, stress };
            let (scene, step) = (factors.scene(&scene), factors.step(&step));
            let report = solve_one(&scene, &step, &mesh(factors.mesh(&parts)));
            assert!(report.krylov_iterations.abs_diff(base.krylov_iterations) <= 1);
            assert_eq!(report.active_vertices, base.active_vertices);
            let dimension = dimension(&parts);
            for (new, old) in quantities(&report, dimension)
                .iter()
                .zip(quantities(&base, dimension))
            {
                let unit = length.powi(old.length) * stress.powi(old.stress);
                let pairs = new.values.iter().zip(&old.values);
                let difference: Vec<f64> = pairs.map(|(new, old)| new / unit - old).collect();
                let error = norm(&difference);
                assert!(
                    error <= 1e-9 * old.size,
                    "{} {factors:?} {error:e}",
                    old.name
                );
            }
        }
    }
}
