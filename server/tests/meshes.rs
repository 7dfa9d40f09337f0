//! Meshes: uploaded once, named by their content, refused with a reason.

mod common;

use common::{Block, Server, reason};
use signorini_proto::v1::{self as wire, upload_mesh_request::Part};
use signorini_server::Config;

async fn refused(server: &Server, parts: Vec<wire::UploadMeshRequest>) -> tonic::Status {
    server
        .meshes()
        .upload_mesh(tokio_stream::iter(parts))
        .await
        .unwrap_err()
}

fn header(header: wire::MeshHeader) -> wire::UploadMeshRequest {
    wire::UploadMeshRequest {
        part: Some(Part::Header(header)),
    }
}

#[tokio::test]
async fn a_second_upload_of_the_same_mesh_is_a_no_op() {
    let (server, block) = (Server::start().await, Block::new(2));
    let name = server.upload(&block).await;
    assert_eq!(name, format!("meshes/{}", block.digest()));
    let only_header = tokio_stream::iter(vec![header(block.header())]);
    let again = server
        .meshes()
        .upload_mesh(only_header)
        .await
        .unwrap()
        .into_inner();
    assert!(again.already_present);
    let mesh = again.mesh.unwrap();
    assert_eq!(
        (mesh.vertex_count, mesh.cell_count, mesh.facet_count),
        (27, 48, 16)
    );
    assert_eq!(mesh.groups.len(), 3);
}

#[tokio::test]
async fn meshes_are_listed_in_pages_and_deleted() {
    let server = Server::start().await;
    let mut names = Vec::new();
    for n in 1..=3 {
        names.push(server.upload(&Block::new(n)).await);
    }
    names.sort();
    let mut listed = Vec::new();
    let mut request = wire::ListMeshesRequest {
        page_size: 2,
        ..Default::default()
    };
    loop {
        let page = server
            .meshes()
            .list_meshes(request.clone())
            .await
            .unwrap()
            .into_inner();
        listed.extend(page.meshes.into_iter().map(|mesh| mesh.name));
        if page.next_page_token.is_empty() {
            break;
        }
        request.page_token = page.next_page_token;
    }
    assert_eq!(listed, names);
    let delete = wire::DeleteMeshRequest {
        name: names[0].clone(),
    };
    server.meshes().delete_mesh(delete.clone()).await.unwrap();
    let gone = server.meshes().delete_mesh(delete).await.unwrap_err();
    assert_eq!(reason(&gone), "MESH_NOT_FOUND");
}

#[tokio::test]
async fn wrong_digest_missing_chunks_and_bad_cells_are_refused() {
    let (server, block) = (Server::start().await, Block::new(1));
    let mut wrong = block.messages();
    wrong[0] = header(wire::MeshHeader {
        digest: "0".repeat(64),
        ..block.header()
    });
    assert_eq!(
        reason(&refused(&server, wrong).await),
        "MESH_DIGEST_MISMATCH"
    );

    let mut short = block.messages();
    short.truncate(2);
    let status = refused(&server, short).await;
    assert_eq!(reason(&status), "REQUEST_INVALID");
    assert!(status.message().contains("group"), "{}", status.message());

    let mut inverted = Block::new(1);
    inverted.cells.swap(0, 1);
    let status = refused(&server, inverted.messages()).await;
    assert_eq!(reason(&status), "MESH_INVALID");
    assert!(status.message().contains("cell 0"), "{}", status.message());

    let mut negative = Block::new(1);
    negative.cells[5] = -1;
    assert_eq!(
        reason(&refused(&server, negative.messages()).await),
        "MESH_INVALID"
    );
}

#[tokio::test]
async fn declared_sizes_are_refused_before_any_data() {
    let config = Config {
        memory_budget_bytes: 1 << 20,
        ..Config::embedded()
    };
    let (server, block) = (Server::with(config).await, Block::new(1));
    let large = wire::MeshHeader {
        vertex_count: 100_000_000,
        ..block.header()
    };
    let status = refused(&server, vec![header(large)]).await;
    assert_eq!(reason(&status), "MEMORY_BUDGET");
    let beyond = wire::MeshHeader {
        cell_count: i64::MAX,
        ..block.header()
    };
    assert_eq!(
        reason(&refused(&server, vec![header(beyond)]).await),
        "MESSAGE_LIMIT"
    );
    let negative = wire::MeshHeader {
        facet_count: -1,
        ..block.header()
    };
    assert_eq!(
        reason(&refused(&server, vec![header(negative)]).await),
        "REQUEST_INVALID"
    );
    server.upload(&block).await;
}
