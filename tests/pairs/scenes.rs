//! Scenes of two bodies.

use signorini::scene::{
    ContactPair, Formulation, Material, MaterialModel, Modulus, RubberModel, Support, ValuePlace,
    Values,
};
use signorini::{GroupKind, Mesh, Scene};

pub(crate) use crate::common::meshes::joined;
use crate::common::node_positions;
use crate::common::scenes::support;

/// Incompressible linear bodies of those shear moduli.
pub(crate) fn linear<const N: usize>(bodies: [(&str, f64); N]) -> Scene {
    linear_of(0.5, bodies)
}

/// Linear bodies of one Poisson's ratio and those shear moduli.
pub(crate) fn linear_of<const N: usize>(poisson_ratio: f64, bodies: [(&str, f64); N]) -> Scene {
    scene(bodies, |shear| MaterialModel::LinearElastic {
        modulus: Modulus::Shear(shear),
        poisson_ratio,
        formulation: Formulation::Auto,
    })
}

/// Rubber of those shear moduli.
pub(crate) fn rubber<const N: usize>(bodies: [(&str, f64); N], bulk_modulus: Option<f64>) -> Scene {
    scene(bodies, |shear_modulus| MaterialModel::Rubber {
        model: RubberModel::NeoHookean { shear_modulus },
        bulk_modulus,
        formulation: Formulation::Auto,
    })
}

fn scene<const N: usize>(bodies: [(&str, f64); N], law: impl Fn(f64) -> MaterialModel) -> Scene {
    let material = |(group, shear): (&str, f64)| Material {
        group: group.to_owned(),
        model: law(shear),
    };
    let mut scene = Scene {
        name: "pair".to_owned(),
        materials: bodies.map(material).into(),
        ..Scene::default()
    };
    scene.solver.verify = true;
    scene
}

/// A contact named `pair` whose first group carries.
pub(crate) fn between(first: &str, second: &str) -> Vec<ContactPair> {
    vec![ContactPair {
        name: "pair".to_owned(),
        between: [first.to_owned(), second.to_owned()],
        carries: Some(first.to_owned()),
        ..ContactPair::default()
    }]
}

/// A support of all components with the values of a field at its nodes.
pub(crate) fn carried_along(
    mesh: &Mesh,
    on: &str,
    field: impl Fn([f64; 3]) -> [f64; 3],
) -> Support {
    let places = node_positions(mesh);
    let nodes = nodes_of(mesh, on);
    let z = (mesh.cell_kind().dimension() == 3).then_some(0.0);
    Support {
        values: Some(Values {
            place: ValuePlace::Nodes,
            rows: nodes.iter().map(|&node| field(places[node])).collect(),
            numbers: nodes.iter().map(|&node| node as u32).collect(),
        }),
        ..support(on, [Some(0.0), Some(0.0), z])
    }
}

/// Which displacement nodes belong to a group of cells.
pub(crate) fn is_of(mesh: &Mesh, cells: &str) -> Vec<bool> {
    let group = mesh.group(cells, GroupKind::Cells).expect("a body");
    let mut found = vec![false; mesh.vertex_count() + mesh.edges().len()];
    for &cell in &group.members {
        let corners = mesh.cell(cell as usize);
        for (i, &a) in corners.iter().enumerate() {
            found[a as usize] = true;
            for &b in &corners[i + 1..] {
                let edge = mesh.edge_between(a, b).expect("an edge") as usize;
                found[mesh.vertex_count() + edge] = true;
            }
        }
    }
    found
}

/// Displacement nodes of a group of facets.
fn nodes_of(mesh: &Mesh, group: &str) -> Vec<usize> {
    let group = mesh.group(group, GroupKind::Facets).expect("a side");
    let mut nodes = Vec::new();
    for &facet in &group.members {
        let corners = mesh.facet(facet as usize);
        for (i, &a) in corners.iter().enumerate() {
            nodes.push(a as usize);
            for &b in &corners[i + 1..] {
                let edge = mesh.edge_between(a, b).expect("an edge");
                nodes.push(mesh.vertex_count() + edge as usize);
            }
        }
    }
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}
