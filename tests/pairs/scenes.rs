//! Scenes of two bodies.

use signorini::scene::{
    ContactPair, Formulation, Material, MaterialModel, Modulus, RubberModel, Support, ValuePlace,
    Values,
};
use signorini::{Group, GroupKind, Mesh, MeshParts, Scene};

use crate::common::node_positions;
use crate::common::scenes::support;

/// Incompressible linear bodies of those shear moduli.
pub(crate) fn linear<const N: usize>(bodies: [(&str, f64); N]) -> Scene {
    scene(bodies, |shear| MaterialModel::LinearElastic {
        modulus: Modulus::Shear(shear),
        poisson_ratio: 0.5,
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

/// Some bodies of triangles as one mesh; the groups of each have their names with its prefix.
pub(crate) fn joined(bodies: &[(&str, MeshParts)]) -> MeshParts {
    let mut all = MeshParts {
        coordinates: Vec::new(),
        cells: Vec::new(),
        facets: Vec::new(),
        groups: Vec::new(),
        ..bodies[0].1.clone()
    };
    for (prefix, own) in bodies {
        let first = all.coordinates.len() as u32;
        let [cells, facets] = [all.cells.len() as u32 / 3, all.facets.len() as u32 / 2];
        all.coordinates.extend(&own.coordinates);
        all.cells.extend(own.cells.iter().map(|v| v + first));
        all.facets.extend(own.facets.iter().map(|v| v + first));
        let named = |group: &Group| {
            let by = match group.kind {
                GroupKind::Cells => cells,
                GroupKind::Facets => facets,
            };
            Group {
                name: format!("{prefix}{}", group.name),
                kind: group.kind,
                members: group.members.iter().map(|member| member + by).collect(),
            }
        };
        all.groups.extend(own.groups.iter().map(named));
    }
    all
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
    Support {
        values: Some(Values {
            place: ValuePlace::Nodes,
            rows: nodes.iter().map(|&node| field(places[node])).collect(),
            numbers: nodes.iter().map(|&node| node as u32).collect(),
        }),
        ..support(on, [Some(0.0), Some(0.0), None])
    }
}

/// Displacement nodes of a group of facets.
fn nodes_of(mesh: &Mesh, group: &str) -> Vec<usize> {
    let group = mesh.group(group, GroupKind::Facets).expect("a side");
    let mut nodes = Vec::new();
    for &facet in &group.members {
        let ends = mesh.facet(facet as usize);
        let edge = mesh.edge_between(ends[0], ends[1]).expect("an edge");
        nodes.extend(ends.iter().map(|&vertex| vertex as usize));
        nodes.push(mesh.vertex_count() + edge as usize);
    }
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}
