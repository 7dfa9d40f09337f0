//! Values of other codes: every node, facet or cell that they act on has its finite row.
//!
//! The first thing that is wrong of one key is told, with the number and the row, so that no
//! message is as long as a file. Cost: one sort of the nodes and one search a row.

use super::spread::{Spread, Table};
use super::{Faults, names};
use crate::mesh::{CellKind, Mesh};
use crate::scene::{Scene, Step, Support, Traction, ValuePlace, Values};

/// What values act on.
#[derive(Clone, Copy)]
pub(crate) enum Ground<'a> {
    /// The nodes of facets, ascending.
    Surface(&'a [u32]),
    /// Facets, ascending, and their nodes.
    Facets(&'a [u32]),
    /// All cells and nodes.
    Body,
}

/// The values over `ground`; faults are told under `path`, and leave no values.
pub(crate) fn resolve(
    values: &Values,
    (ground, mesh): (Ground<'_>, &Mesh),
    path: &str,
    faults: &mut Faults,
) -> Spread {
    let resolved = match (values.place, ground) {
        (ValuePlace::Nodes, ground) => at_nodes(values, ground, mesh).map(|nodes| Spread {
            nodes,
            ..Spread::default()
        }),
        (ValuePlace::Facets, Ground::Facets(facets)) => at_parts(values, facets.to_vec()),
        (ValuePlace::Cells, Ground::Body) => {
            at_parts(values, (0..mesh.cell_count() as u32).collect())
        }
        (place, _) => Err(format!(
            "come by {}, which they have no place for here: give them by node{}",
            place.name(),
            match ground {
                Ground::Surface(_) => "",
                Ground::Facets(_) => " or facet",
                Ground::Body => " or cell",
            }
        )),
    };
    let resolved = resolved.and_then(|spread| in_its_plane(spread, mesh));
    resolved.unwrap_or_else(|fault| {
        faults.add(path, fault);
        Spread::default()
    })
}

/// Values of a plane scene have no third component.
fn in_its_plane(spread: Spread, mesh: &Mesh) -> Result<Spread, String> {
    let mut rows = spread.nodes.rows.iter().chain(&*spread.parts.rows);
    if mesh.cell_kind() == CellKind::Triangle && rows.any(|row| row[2] != 0.0) {
        Err("the z component must be zero in a plane scene".to_owned())
    } else {
        Ok(spread)
    }
}

/// One row a facet or cell.
fn at_parts(values: &Values, parts: Vec<u32>) -> Result<Spread, String> {
    let counts = format!("{} {}s", parts.len(), values.place.name());
    let rows = sorted(values, &parts, &counts)?;
    let parts = Table {
        keys: parts.into(),
        rows: rows.into(),
    };
    Ok(Spread {
        parts,
        ..Spread::default()
    })
}

/// One row a vertex, and one an edge or the means of the ends.
fn at_nodes(values: &Values, ground: Ground<'_>, mesh: &Mesh) -> Result<Table, String> {
    let [vertices, edges] = nodes_of(ground, mesh);
    let counts = format!("{} vertices and {} edges", vertices.len(), edges.len());
    let first = mesh.vertex_count() as u32;
    let uploaded = |&vertex: &u32| mesh.used_vertices()[vertex as usize];
    let mut numbers: Vec<u32> = vertices.iter().map(uploaded).collect();
    let has_edges = if values.numbers.is_empty() {
        values.rows.len() > vertices.len()
    } else {
        values.numbers.iter().any(|&number| number >= first)
    };
    if has_edges {
        numbers.extend(edges.iter().map(|&edge| first + edge));
    }
    let mut rows = sorted(values, &numbers, &counts)?;
    if !has_edges {
        let at = |vertex: u32| match vertices.binary_search(&vertex) {
            Ok(place) => rows[place],
            Err(_) => [0.0; 3],
        };
        let middle = |&edge: &u32| {
            let [a, b] = mesh.edges()[edge as usize].map(at);
            std::array::from_fn(|i| 0.5 * (a[i] + b[i]))
        };
        let middles: Vec<[f64; 3]> = edges.iter().map(middle).collect();
        rows.extend(middles);
    }
    let behind = mesh.coordinates().len() as u32;
    let keys = vertices.into_iter();
    Ok(Table {
        keys: keys
            .chain(edges.iter().map(|&edge| behind + edge))
            .collect(),
        rows: rows.into(),
    })
}

/// Used vertices and edges of the ground, ascending.
fn nodes_of(ground: Ground<'_>, mesh: &Mesh) -> [Vec<u32>; 2] {
    let facets = match ground {
        Ground::Surface(facets) | Ground::Facets(facets) => facets,
        Ground::Body => {
            let all = [mesh.coordinates().len(), mesh.edges().len()];
            return all.map(|count| (0..count as u32).collect());
        }
    };
    let (mut vertices, mut edges) = (Vec::new(), Vec::new());
    for &facet in facets {
        let corners = mesh.facet(facet as usize);
        vertices.extend_from_slice(corners);
        for (i, &a) in corners.iter().enumerate() {
            let others = corners[i + 1..].iter();
            edges.extend(others.filter_map(|&b| mesh.edge_between(a, b)));
        }
    }
    [vertices, edges].map(|mut nodes| {
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    })
}

/// The rows in the order of `known`, ascending numbers, each of which has one.
fn sorted(values: &Values, known: &[u32], counts: &str) -> Result<Vec<[f64; 3]>, String> {
    let what = values.place.name();
    let given = values.rows.len();
    if !values.numbers.is_empty() && values.numbers.len() != given {
        let numbers = values.numbers.len();
        return Err(format!("has {given} rows, but numbers {numbers} of them"));
    }
    let mut rows = vec![None; known.len()];
    if values.numbers.is_empty() {
        if given != known.len() {
            return Err(format!("has {given} rows; there are {counts}"));
        }
        rows = values.rows.iter().copied().map(Some).collect();
    }
    for (row, (&number, value)) in values.numbers.iter().zip(&values.rows).enumerate() {
        let Ok(place) = known.binary_search(&number) else {
            let message = format!("row {row}: {what} {number} is none of the {counts} of this key");
            return Err(message);
        };
        if rows[place].replace(*value).is_some() {
            return Err(format!("row {row}: {what} {number} has a row already"));
        }
    }
    let filled = known.iter().zip(rows).map(|(number, row)| match row {
        Some(row) if row.iter().all(|value| value.is_finite()) => Ok(row),
        Some(row) => Err(format!("{what} {number} must be finite, not {row:?}")),
        None => Err(format!("{what} {number} has no row; there are {counts}")),
    });
    filled.collect()
}

/// The values of a support of the scene.
pub(crate) fn of_support(
    support: &Support,
    (facets, mesh): (&[u32], &Mesh),
    faults: &mut Faults,
) -> Spread {
    let Some(values) = &support.values else {
        return Spread::default();
    };
    let path = format!("support.{}.values", support.name);
    refuse_beside(support, &path, faults);
    resolve(values, (Ground::Surface(facets), mesh), &path, faults)
}

/// Values vary components of their own.
fn refuse_beside(support: &Support, path: &str, faults: &mut Faults) {
    if support.normal.is_some() {
        faults.add(path, "stand beside `normal`: they vary components");
    }
    if support.profile != crate::scene::Profile::Constant {
        faults.add(path, "stand beside `profile`: give one of the two");
    }
}

/// The values of a traction of the scene.
pub(crate) fn of_traction(
    (traction, path): (&Traction, &str),
    (facets, mesh): (&[u32], &Mesh),
    faults: &mut Faults,
) -> Spread {
    let Some(values) = &traction.values else {
        return Spread::default();
    };
    let path = format!("{path}.values");
    resolve(values, (Ground::Facets(facets), mesh), &path, faults)
}

/// The values of the body force of the scene.
pub(crate) fn of_body(scene: &Scene, mesh: &Mesh, faults: &mut Faults) -> Spread {
    let Some(values) = &scene.body_force_values else {
        return Spread::default();
    };
    resolve(values, (Ground::Body, mesh), "body_force.values", faults)
}

/// Checks the values of a step, whose key is `path`, against the scene.
pub(crate) fn check_step(
    (scene, step): (&Scene, &Step),
    mesh: &Mesh,
    path: &str,
    faults: &mut Faults,
) {
    for target in &step.supports {
        let mut supports = scene.supports.iter();
        let support = supports.find(|one| one.name == target.name);
        if let (Some(values), Some(support)) = (&target.values, support) {
            let path = format!("{path}.support.{}.values", target.name);
            refuse_beside(support, &path, faults);
            let facets = names::facets(mesh, &path, &support.on, &mut Faults::default());
            resolve(values, (Ground::Surface(&facets), mesh), &path, faults);
        }
    }
    for target in &step.tractions {
        let path = format!("{path}.traction.{}", target.name);
        let known = scene.tractions.iter().filter_map(|one| one.name.as_deref());
        let mut tractions = scene.tractions.iter();
        match tractions.find(|one| one.name.as_ref() == Some(&target.name)) {
            Some(traction) => {
                let facets = names::facets(mesh, &path, &traction.on, &mut Faults::default());
                let path = format!("{path}.values");
                resolve(
                    &target.values,
                    (Ground::Facets(&facets), mesh),
                    &path,
                    faults,
                );
            }
            None => {
                let hint = crate::scene::names::hint(&target.name, known);
                let message = format!("the scene has no traction `{}`{hint}", target.name);
                faults.add(path, message);
            }
        }
    }
    if let Some(values) = &step.body_force {
        let path = format!("{path}.body_force.values");
        resolve(values, (Ground::Body, mesh), &path, faults);
    }
    refuse_manufactured((scene, step), path, faults);
}

/// An analytic field brings its own loads and values.
fn refuse_manufactured((scene, step): (&Scene, &Step), path: &str, faults: &mut Faults) {
    let supports = step.supports.iter().any(|one| one.values.is_some());
    let any = supports || !step.tractions.is_empty() || step.body_force.is_some();
    if any && scene.manufactured.is_some() {
        faults.add(
            path,
            "the manufactured field brings its own loads and values",
        );
    }
}
