//! Scenes of tied bodies.

use signorini::scene::{
    Formulation, Material, MaterialModel, Modulus, RubberModel, Support, Tie, ValuePlace, Values,
};
use signorini::{Group, GroupKind, Mesh, MeshParts, Scene};

use crate::common::scenes::support;

/// Bodies as parts of one mesh, their groups with the names of the bodies before their own.
pub(crate) fn joined<const N: usize>(bodies: [(&str, MeshParts); N]) -> MeshParts {
    let mut all: Option<MeshParts> = None;
    for (name, mut body) in bodies {
        let named = |group: &Group, by: u32| Group {
            name: format!("{name}_{}", group.name),
            kind: group.kind,
            members: group.members.iter().map(|member| member + by).collect(),
        };
        let Some(whole) = &mut all else {
            body.groups = body.groups.iter().map(|group| named(group, 0)).collect();
            all = Some(body);
            continue;
        };
        let kind = body.cell_kind;
        let vertices = whole.coordinates.len() as u32;
        let [cells, facets] = [
            whole.cells.len() / kind.vertices(),
            whole.facets.len() / kind.facet_vertices(),
        ];
        let by = |kind: GroupKind| match kind {
            GroupKind::Cells => cells as u32,
            GroupKind::Facets => facets as u32,
        };
        let groups = body.groups.iter();
        let groups = groups.map(|group| named(group, by(group.kind)));
        whole.groups.extend(groups);
        whole.coordinates.append(&mut body.coordinates);
        let shifted = |list: &[u32]| list.iter().map(|v| v + vertices).collect::<Vec<u32>>();
        whole.cells.extend(shifted(&body.cells));
        whole.facets.extend(shifted(&body.facets));
    }
    all.expect("a body")
}

/// Linear bodies of those shear moduli, in groups `NAME_body`.
pub(crate) fn linear(bodies: &[(&str, f64)], poisson_ratio: f64) -> Scene {
    scene(bodies, |shear| MaterialModel::LinearElastic {
        modulus: Modulus::Shear(shear),
        poisson_ratio,
        formulation: Formulation::Auto,
    })
}

/// Rubber of those shear moduli, and of bulk moduli by that factor.
pub(crate) fn rubber(bodies: &[(&str, f64)], bulk: f64) -> Scene {
    scene(bodies, |shear_modulus| MaterialModel::Rubber {
        model: RubberModel::NeoHookean { shear_modulus },
        bulk_modulus: Some(bulk * shear_modulus),
        formulation: Formulation::Auto,
    })
}

fn scene(bodies: &[(&str, f64)], law: impl Fn(f64) -> MaterialModel) -> Scene {
    let material = |&(name, shear): &(&str, f64)| Material {
        group: format!("{name}_body"),
        model: law(shear),
    };
    let mut scene = Scene {
        name: "tied".to_owned(),
        materials: bodies.iter().map(material).collect(),
        ..Scene::default()
    };
    scene.solver.verify = true;
    scene
}

/// A tie whose first group carries.
pub(crate) fn tie(name: &str, first: &str, second: &str) -> Tie {
    Tie {
        name: name.to_owned(),
        between: [first.to_owned(), second.to_owned()],
        carries: Some(first.to_owned()),
    }
}

/// Place of each displacement node, on curved edges too.
pub(crate) fn places_of(mesh: &Mesh) -> Vec<[f64; 3]> {
    let middle = |&[a, b]: &[u32; 2]| {
        let ends = [a, b].map(|vertex| mesh.coordinates()[vertex as usize]);
        let offset = mesh.offset_between(a, b).unwrap_or_default();
        [0, 1, 2].map(|i| 0.5 * (ends[0][i] + ends[1][i]) + offset[i])
    };
    let vertices = mesh.coordinates().iter().copied();
    vertices.chain(mesh.edges().iter().map(middle)).collect()
}

/// A support of all components with the values of a field at its nodes.
pub(crate) fn carried_along(
    mesh: &Mesh,
    on: &str,
    field: impl Fn([f64; 3]) -> [f64; 3],
) -> Support {
    let places = places_of(mesh);
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
