//! `mesh info`: what a mesh file holds, without a server.

use std::path::Path;

use serde_json::{Value, json};
use signorini_client::WireMesh;
use signorini_client::formats::msh::MeshFile;

use crate::arguments::input;
use crate::commands::mesh_shape::{Quality, Shape, group_box};
use crate::terminal::exit::{Exit, Failure};
use crate::terminal::stdout::print;
use crate::terminal::text::{number, one_line, vector};

pub(super) fn run(file: &Path, json: bool) -> Result<Exit, Failure> {
    let mesh = input::load_mesh(file)?;
    let digest = WireMesh::new(&mesh)?.name();
    let shape = Shape::of(&mesh);
    let text = if json {
        format!("{}\n", object(&mesh, &shape, &digest))
    } else {
        table(file, &mesh, &shape)
    };
    print(&text)?;
    Ok(Exit::Ok)
}

fn cells(mesh: &MeshFile) -> &'static str {
    match mesh.vertices_per_cell {
        3 => "triangles",
        _ => "tetrahedra",
    }
}

fn table(file: &Path, mesh: &MeshFile, shape: &Shape) -> String {
    let mut text = String::new();
    let mut add = |label: &str, value: &str| {
        text.push_str(&format!("{label:<18} {}\n", one_line(value)));
    };
    add("mesh", &file.display().to_string());
    add(
        "cells",
        &format!(
            "{} {}, {} vertices, {} facets in groups",
            mesh.cell_count(),
            cells(mesh),
            mesh.coordinates.len(),
            mesh.facet_count()
        ),
    );
    add("surface", &order(mesh));
    add("from", &vector(&shape.low));
    add("to", &vector(&shape.high));
    let [shortest, longest] = shape.edges.map(number);
    add("edges", &format!("{shortest} to {longest} long"));
    let Quality {
        worst,
        worst_cell,
        mean,
    } = &shape.quality;
    add(
        "quality",
        &format!(
            "mean ratio {mean:.2}, {worst:.3} at least (cell {worst_cell}); 1 is regular, 0 is flat"
        ),
    );
    for group in &mesh.groups {
        let what = match (
            group.dimension + 1 == mesh.vertices_per_cell,
            group.dimension,
        ) {
            (true, _) => cells(mesh),
            (false, 1) => "lines",
            (false, _) => "faces",
        };
        let (low, high) = group_box(mesh, group);
        add(
            &format!("group {}", one_line(&group.name)),
            &format!(
                "{} {what}, from {} to {}",
                group.members.len(),
                vector(&low),
                vector(&high)
            ),
        );
    }
    if mesh.groups.is_empty() {
        add("warning", input::WITHOUT_GROUPS);
    }
    for warning in &mesh.warnings {
        add("warning", warning);
    }
    text
}

/// Whether the surface is bent.
fn order(mesh: &MeshFile) -> String {
    match mesh.curved.len() {
        0 => "straight edges".to_owned(),
        count => format!("{count} edges are curved (second order)"),
    }
}

fn object(mesh: &MeshFile, shape: &Shape, digest: &str) -> Value {
    let groups = mesh.groups.iter().map(|group| {
        let (low, high) = group_box(mesh, group);
        json!({
            "name": group.name,
            "dimension": group.dimension,
            "members": group.members.len(),
            "low": low,
            "high": high,
        })
    });
    json!({
        "name": digest,
        "cell_kind": cells(mesh),
        "vertices": mesh.coordinates.len(),
        "cells": mesh.cell_count(),
        "facets": mesh.facet_count(),
        "curved_edges": mesh.curved.len(),
        "low": shape.low,
        "high": shape.high,
        "shortest_edge": shape.edges[0],
        "longest_edge": shape.edges[1],
        "min_mean_ratio": shape.quality.worst,
        "worst_cell": shape.quality.worst_cell,
        "mean_mean_ratio": shape.quality.mean,
        "groups": groups.collect::<Vec<_>>(),
        "warnings": mesh.warnings,
    })
}
