//! The force at every node: its sums are the reported forces.

use std::sync::Arc;

use signorini::scene::Shape;
use signorini::{FieldName, GroupKind, Mesh, Scene, Session, Step, StepReport};

use crate::common::meshes::{cube, file, irregular, mesh};
use crate::common::scenes::{
    cube_bend, elastic, hertz_sphere, mooney_rivlin, obstacle, push, rubber, support,
};
use crate::common::{close, run_one, values};

type Vector = [f64; 3];

/// The nodes of the facets of a group, each once.
pub(crate) fn nodes_of(mesh: &Mesh, group: &str) -> Vec<usize> {
    let group = mesh.group(group, GroupKind::Facets).expect("a side");
    let mut nodes = Vec::new();
    for &facet in &group.members {
        let corners = mesh.facet(facet as usize);
        nodes.extend(corners.iter().map(|&vertex| vertex as usize));
        for (i, &a) in corners.iter().enumerate() {
            for &b in &corners[i + 1..] {
                let edge = mesh.edge_between(a, b).expect("an edge of the mesh");
                nodes.push(mesh.vertex_count() + edge as usize);
            }
        }
    }
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

fn forces(session: &Session) -> Vec<Vector> {
    let field = values(session, FieldName::NodalForce);
    field.as_chunks().0.to_vec()
}

fn sum<'a>(forces: impl Iterator<Item = &'a Vector>) -> Vector {
    forces.fold([0.0; 3], |sum, force| {
        std::array::from_fn(|i| sum[i] + force[i])
    })
}

fn size(force: Vector) -> f64 {
    force.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn assert_same(found: Vector, expected: Vector, of: f64, what: &str) {
    let difference = size(std::array::from_fn(|i| found[i] - expected[i]));
    assert!(
        difference <= 1e-12 * of,
        "{what}: {found:?}, not {expected:?}"
    );
}

/// All nodes together have the forces of all supports and obstacles.
fn check_total(session: &Session, report: &StepReport) {
    let supports = report.supports.values().map(|one| &one.force);
    let obstacles = report.obstacles.values().map(|one| &one.force);
    let reported: Vec<Vector> = supports.chain(obstacles).copied().collect();
    let largest = reported.iter().copied().map(size).fold(0.0, f64::max);
    let found = sum(forces(session).iter());
    assert_same(found, sum(reported.iter()), largest, "total");
}

fn solved(scene: &Scene, step: &Step, mesh: &Arc<Mesh>) -> (Session, StepReport) {
    let (session, report) = run_one(scene, step, mesh);
    check_total(&session, &report);
    (session, report)
}

#[test]
fn the_nodes_of_a_support_have_its_reaction() {
    for poisson_ratio in [0.5, 0.3] {
        let scene = cube_bend(poisson_ratio);
        let mesh = mesh(irregular(cube(3), 3));
        let (session, report) = solved(&scene, &Step::default(), &mesh);
        let forces = forces(&session);
        for (name, reaction) in &report.supports {
            let own = nodes_of(&mesh, name);
            let found = sum(own.iter().map(|&node| &forces[node]));
            assert_same(found, reaction.force, size(reaction.force), name);
        }
        let held = nodes_of(&mesh, "x0");
        let mut others = (0..forces.len()).filter(|node| held.binary_search(node).is_err());
        assert!(others.all(|node| size(forces[node]) == 0.0));
    }
}

#[test]
fn the_nodes_under_an_obstacle_have_its_force() {
    let (scene, step) = hertz_sphere(0.5);
    let mesh = file("indent_l1");
    let (session, report) = solved(&scene, &step, &mesh);
    let forces = forces(&session);
    let ball = &report.obstacles["ball"];
    // The symmetry planes hold x and y only: along z all is the ball's.
    let own = nodes_of(&mesh, "z1");
    let along: f64 = own.iter().map(|&node| forces[node][2]).sum();
    assert!(close(along, ball.force[2], 1e-12), "{along}");
    let pressed = own.iter().filter(|&node| forces[*node][2] != 0.0).count();
    assert!(pressed > 3 && pressed < own.len());
}

#[test]
fn normal_supports_and_rubber_have_their_forces_at_nodes_too() {
    let mut scene = rubber(mooney_rivlin(), None);
    scene.supports = vec![support("z0", [Some(0.0); 3])];
    let mut wall = support("x0", [None; 3]);
    wall.normal = Some(-0.01);
    scene.supports.push(wall);
    let ball = Shape::Sphere {
        centre: [0.6, 0.5, 1.5],
        radius: 0.5,
    };
    scene.obstacles = vec![obstacle("ball", "z1", ball)];
    scene.obstacles[0].friction = 0.3;
    scene.body_force = [0.0, 0.02, 0.0];
    let step = push("ball", [0.02, 0.0, -0.08]);
    solved(&scene, &step, &mesh(irregular(cube(3), 3)));
}

#[test]
fn a_body_without_supports_that_hold_has_no_force_at_its_nodes() {
    let mut scene = elastic(0.3);
    scene.supports = vec![support("x0", [Some(0.0); 3])];
    let (session, _) = solved(&scene, &Step::default(), &mesh(cube(2)));
    assert!(forces(&session).iter().all(|force| size(*force) == 0.0));
}
