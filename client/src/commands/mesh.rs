//! `mesh info|put|list|delete`.

mod info;

use serde_json::{Value, json};
use signorini_client::WireMesh;
use signorini_proto::v1;

use crate::arguments::input;
use crate::arguments::{MeshCommand, RemoteArguments};
use crate::terminal::exit::{Exit, Failure};
use crate::terminal::stdout::print;
use crate::terminal::text::{bytes, note, one_line};

pub(super) async fn run(command: MeshCommand) -> Result<Exit, Failure> {
    match command {
        MeshCommand::Info { file, json } => info::run(&file, json),
        MeshCommand::Put { file, remote } => {
            let mesh = input::load_mesh(&file)?;
            put(&mesh, &remote).await
        }
        MeshCommand::List { remote } => {
            let client = remote.connect().await?;
            let meshes = client.list_meshes().await?;
            if meshes.is_empty() {
                note(&format!("{} has no meshes\n", remote.server));
            }
            show(&meshes, &remote)
        }
        MeshCommand::Delete { digest, remote } => {
            let client = remote.connect().await?;
            client.delete_mesh(&digest).await?;
            Ok(Exit::Ok)
        }
    }
}

async fn put(
    mesh: &signorini_client::formats::msh::MeshFile,
    remote: &RemoteArguments,
) -> Result<Exit, Failure> {
    let wire = WireMesh::new(mesh)?;
    let client = remote.connect().await?;
    let uploaded = client.upload_mesh(wire).await?;
    for warning in mesh.warnings.iter().chain(&uploaded.mesh.warnings) {
        note(&format!("warning: {warning}\n"));
    }
    if uploaded.already_present {
        note("already present\n");
    }
    show(&[uploaded.mesh], remote)
}

fn show(meshes: &[v1::StoredMesh], remote: &RemoteArguments) -> Result<Exit, Failure> {
    for mesh in meshes {
        let line = if remote.json {
            object(mesh).to_string()
        } else {
            line(mesh)
        };
        print(&format!("{line}\n"))?;
    }
    Ok(Exit::Ok)
}

fn line(mesh: &v1::StoredMesh) -> String {
    let groups: Vec<&str> = mesh
        .groups
        .iter()
        .map(|group| group.name.as_str())
        .collect();
    let curved = match mesh.curved_edge_count {
        0 => String::new(),
        count => format!("{count} curved edges, "),
    };
    format!(
        "{}  {} vertices, {} cells, {} facets, {curved}{}, groups {}",
        mesh.digest,
        mesh.vertex_count,
        mesh.cell_count,
        mesh.facet_count,
        bytes(mesh.memory_bytes),
        one_line(&groups.join(" ")),
    )
}

fn object(mesh: &v1::StoredMesh) -> Value {
    let groups: Vec<&str> = mesh
        .groups
        .iter()
        .map(|group| group.name.as_str())
        .collect();
    json!({
        "digest": mesh.digest,
        "vertices": mesh.vertex_count,
        "cells": mesh.cell_count,
        "facets": mesh.facet_count,
        "curved_edges": mesh.curved_edge_count,
        "groups": groups,
        "memory_bytes": mesh.memory_bytes,
        "sessions": mesh.session_count,
        "min_mean_ratio": mesh.quality.map(|quality| quality.min_mean_ratio),
    })
}
