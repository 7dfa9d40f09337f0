//! What is reported balances: forces, work, and pressure against force.

use crate::common::meshes::{cube, file, irregular, mesh, square};
use crate::common::scenes::{
    cube_bend, elastic, hertz_plane, hertz_sphere, mooney_rivlin, obstacle, rubber,
    small_indentation, support, traction,
};
use crate::common::{close, run_one, values};
use signorini::scene::{Choice, ContactSpace, Pressure, Shape};
use signorini::{FieldName, GroupKind, Mesh, Scene, Step, StepReport};

/// Obstacles, supports and `applied` must cancel to ten times the tolerance of
/// the largest.
fn assert_balanced(report: &StepReport, applied: [f64; 3], tolerance: f64) {
    let supports = report.supports.values().map(|support| support.force);
    let obstacles = report.obstacles.values().map(|obstacle| obstacle.force);
    let forces: Vec<[f64; 3]> = supports.chain(obstacles).chain([applied]).collect();
    let size = |force: &[f64; 3]| force.iter().map(|x| x * x).sum::<f64>().sqrt();
    let largest = forces.iter().map(size).fold(0.0, f64::max);
    assert!(largest > 0.0);
    for i in 0..3 {
        let sum: f64 = forces.iter().map(|force| force[i]).sum();
        assert!(sum.abs() <= 10.0 * tolerance * largest, "{forces:?}");
    }
}

fn check(scene: &Scene, step: &Step, mesh: &std::sync::Arc<Mesh>, applied: [f64; 3]) {
    let (_, report) = run_one(scene, step, mesh);
    assert_balanced(&report, applied, scene.solver.tolerance);
}

#[test]
fn forces_balance_under_dead_loads() {
    for poisson_ratio in [0.5, 0.48, 0.3] {
        let mut scene = cube_bend(poisson_ratio);
        scene.body_force = [0.2, -0.1, 0.3];
        scene.tractions.push(traction("y1", [0.0, 0.4, 0.1]));
        let mesh = mesh(irregular(cube(4), 4));
        check(&scene, &Step::default(), &mesh, [0.2, 0.3, -0.6]);
    }
}

#[test]
fn forces_balance_with_obstacles() {
    let (scene, step) = hertz_plane(0.5);
    check(&scene, &step, &file("hemi_l1"), [0.0; 3]);
    let (scene, step) = hertz_sphere(0.5);
    check(&scene, &step, &file("indent_l1"), [0.0; 3]);
    let (mut scene, mesh) = small_indentation(4);
    scene.tractions = vec![traction("x1", [0.02, 0.01, 0.0])];
    let step = crate::common::scenes::push("ball", [0.0, 0.0, -0.06]);
    check(&scene, &step, &mesh, [0.02, 0.01, 0.0]);
}

#[test]
fn forces_balance_in_the_plane() {
    let mut scene = elastic(0.5);
    scene.supports = vec![support("y0", [Some(0.0), Some(0.0), None])];
    scene.body_force = [0.1, -0.2, 0.0];
    let shape = Shape::Sphere {
        centre: [0.5, 1.7, 0.0],
        radius: 0.75,
    };
    scene.obstacles = vec![obstacle("roll", "y1", shape)];
    let mesh = mesh(irregular(square(8), 8));
    let (_, report) = run_one(&scene, &Step::default(), &mesh);
    assert!(report.obstacles["roll"].force[1] < -1e-3);
    assert_balanced(&report, [0.1, -0.2, 0.0], scene.solver.tolerance);
}

#[test]
fn forces_balance_under_a_pressure_that_follows() {
    let mut scene = rubber(mooney_rivlin(), None);
    scene.supports = vec![support("x0", [Some(0.0); 3])];
    scene.pressures = vec![Pressure {
        on: ["x1", "y0", "y1", "z0", "z1"].map(str::to_owned).to_vec(),
        value: 0.2,
    }];
    let ball = Shape::Sphere {
        centre: [0.6, 0.5, 1.5],
        radius: 0.5,
    };
    scene.obstacles = vec![obstacle("ball", "z1", ball)];
    let step = crate::common::scenes::push("ball", [0.0, 0.0, -0.1]);
    // On a closed surface a pressure has no resultant: what is left is that on the
    // bonded side.
    check(
        &scene,
        &step,
        &mesh(irregular(cube(4), 4)),
        [-0.2, 0.0, 0.0],
    );
}

/// Vertices and area of each facet of a group.
fn facets<'a>(mesh: &'a Mesh, group: &str) -> impl Iterator<Item = (&'a [u32], f64)> {
    let group = mesh.group(group, GroupKind::Facets).expect("a side");
    group.members.iter().map(|&facet| {
        let v = mesh.facet(facet as usize);
        let [a, b, c] = [v[0], v[1], v[2]].map(|v| mesh.coordinates()[v as usize]);
        let (p, q): ([f64; 3], [f64; 3]) = (
            std::array::from_fn(|i| b[i] - a[i]),
            std::array::from_fn(|i| c[i] - a[i]),
        );
        let cross = [
            p[1] * q[2] - p[2] * q[1],
            p[2] * q[0] - p[0] * q[2],
            p[0] * q[1] - p[1] * q[0],
        ];
        (v, 0.5 * cross.iter().map(|x| x * x).sum::<f64>().sqrt())
    })
}

/// Nodes in the middle of the edges of a facet.
fn middles(mesh: &Mesh, v: &[u32]) -> [usize; 3] {
    [(0, 1), (0, 2), (1, 2)].map(|(i, j)| {
        let edge = mesh.edge_between(v[i], v[j]).expect("an edge of the mesh");
        mesh.vertex_count() + edge as usize
    })
}

/// int u_z over the facets of a group: edge midpoints carry a third each.
fn integral_of_deflection(mesh: &Mesh, displacement: &[f64], group: &str) -> f64 {
    let mut sum = 0.0;
    for (v, area) in facets(mesh, group) {
        for node in middles(mesh, v) {
            sum += area / 3.0 * displacement[3 * node + 2];
        }
    }
    sum
}

#[test]
fn the_strain_energy_is_half_the_work_of_the_load() {
    for poisson_ratio in [0.5, 0.48, 0.3] {
        let mut scene = cube_bend(poisson_ratio);
        scene.solver.tolerance = 1e-11;
        let mesh = mesh(irregular(cube(4), 4));
        let (session, report) = run_one(&scene, &Step::default(), &mesh);
        let field = values(&session, FieldName::Displacement);
        let work = -integral_of_deflection(&mesh, &field, "x1");
        assert!(
            close(report.strain_energy, 0.5 * work, 1e-9),
            "{poisson_ratio}"
        );
    }
}

#[test]
fn the_contact_pressure_integrates_to_the_obstacle_force() {
    let mesh = file("hemi_l1");
    for space in [ContactSpace::Linear, ContactSpace::Quadratic] {
        let (mut scene, step) = hertz_plane(0.5);
        scene.solver.contact_space = Choice::Named(space);
        let (session, report) = run_one(&scene, &step, &mesh);
        let pressure = values(&session, FieldName::ContactPressure);
        let integrals = facets(&mesh, "contact").map(|(corners, area)| match space {
            ContactSpace::Linear => {
                let sum: f64 = corners.iter().map(|&v| pressure[v as usize]).sum();
                area / 3.0 * sum
            }
            // Of a quadratic its values in the middle of the edges count.
            ContactSpace::Quadratic => {
                let sum: f64 = middles(&mesh, corners)
                    .map(|node| pressure[node])
                    .iter()
                    .sum();
                area / 3.0 * sum
            }
        });
        let sum: f64 = integrals.sum();
        let floor = &report.obstacles["floor"];
        assert!(close(floor.force[2], sum, 1e-12), "{sum}");
        let largest = pressure.iter().copied().fold(0.0, f64::max);
        assert!(close(floor.max_pressure, largest, 1e-14), "{largest}");
    }
}
