//! Meshes: uploaded once, named by their content, refused with a reason.

use std::time::Duration;

use crate::common::{Block, Server, reason};
use signorini_proto::array::Assembler;
use signorini_proto::v1::mesh_service_client::MeshServiceClient;
use signorini_proto::v1::{self as wire, read_mesh_response, upload_mesh_request::Part};
use signorini_server::Config;
use tokio_stream::StreamExt as _;

/// Ends a test that would wait for ever.
const PATIENCE: Duration = Duration::from_secs(30);

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

async fn reading(server: &Server, name: &str) -> tonic::Streaming<wire::ReadMeshResponse> {
    let request = wire::ReadMeshRequest {
        name: name.into(),
        ..Default::default()
    };
    server
        .meshes()
        .read_mesh(request)
        .await
        .unwrap()
        .into_inner()
}

/// A mesh as `ReadMesh` sends it.
struct Read {
    header: wire::MeshHeader,
    coordinates: Vec<f64>,
    cells: Vec<i32>,
    facets: Vec<i32>,
    curved_edges: Vec<i32>,
    edge_offsets: Vec<f64>,
    members: Vec<Vec<i32>>,
}

async fn read(server: &Server, name: &str) -> Read {
    let mut parts = reading(server, name).await;
    let first = parts.message().await.unwrap().unwrap();
    let Some(read_mesh_response::Part::Header(header)) = first.part else {
        panic!("the header comes first");
    };
    let mut coordinates = Assembler::new(3 * header.vertex_count as usize);
    let mut cells = Assembler::new(4 * header.cell_count as usize);
    let mut facets = Assembler::new(3 * header.facet_count as usize);
    let mut curved_edges = Assembler::new(2 * header.curved_edge_count as usize);
    let mut edge_offsets = Assembler::new(3 * header.curved_edge_count as usize);
    let groups = header.groups.iter();
    let mut members: Vec<_> = groups
        .map(|group| Assembler::new(group.member_count as usize))
        .collect();
    while let Some(message) = parts.message().await.unwrap() {
        let Some(read_mesh_response::Part::Chunk(chunk)) = message.part else {
            panic!("one header is enough");
        };
        let (offset, data) = (chunk.offset_elements, &chunk.data);
        match chunk.array() {
            wire::MeshArray::Coordinates => coordinates.push(offset, data),
            wire::MeshArray::Cells => cells.push(offset, data),
            wire::MeshArray::Facets => facets.push(offset, data),
            wire::MeshArray::GroupMembers => members[chunk.group_index as usize].push(offset, data),
            wire::MeshArray::CurvedEdges => curved_edges.push(offset, data),
            wire::MeshArray::EdgeOffsets => edge_offsets.push(offset, data),
            other @ (wire::MeshArray::Unspecified
            | wire::MeshArray::Edges
            | wire::MeshArray::CellEdges) => panic!("{other:?}"),
        }
        .unwrap();
    }
    let members = members.into_iter().map(|one| one.finish().unwrap());
    Read {
        header,
        coordinates: coordinates.finish().unwrap(),
        cells: cells.finish().unwrap(),
        facets: facets.finish().unwrap(),
        curved_edges: curved_edges.finish().unwrap(),
        edge_offsets: edge_offsets.finish().unwrap(),
        members: members.collect(),
    }
}

/// The facets' vertices, whatever their order.
fn corners(facets: &[i32]) -> Vec<Vec<i32>> {
    let sorted = |facet: &[i32]| {
        let mut facet = facet.to_vec();
        facet.sort_unstable();
        facet
    };
    facets.chunks(3).map(sorted).collect()
}

/// z component of the facet's normal.
fn normal(mesh: &Read, facet: i32) -> f64 {
    let row = &mesh.facets[3 * facet as usize..][..3];
    let [a, b, c] = [0, 1, 2].map(|corner| &mesh.coordinates[3 * row[corner] as usize..][..2]);
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

#[tokio::test]
async fn a_mesh_comes_back_as_it_was_uploaded() {
    // Large enough for several chunks of cells.
    let (server, block) = (Server::start().await, Block::new(24));
    let name = server.upload(&block).await;
    let mesh = read(&server, &name).await;
    assert_eq!(mesh.header, block.header());
    assert_eq!(mesh.coordinates, block.coordinates);
    assert_eq!(mesh.cells, block.cells);
    let expected = [&block.body, &block.bottom, &block.top];
    assert!(mesh.members.iter().eq(expected));
    assert_eq!(corners(&mesh.facets), corners(&block.facets));
    assert!(block.top.iter().all(|facet| normal(&mesh, *facet) > 0.0));
    assert!(block.bottom.iter().all(|facet| normal(&mesh, *facet) < 0.0));
}

#[tokio::test]
async fn vertices_that_no_cell_uses_come_back_at_the_origin() {
    let (server, mut block) = (Server::start().await, Block::new(2));
    block.coordinates.splice(0..0, [7.0, 8.0, 9.0]);
    block.coordinates.extend([7.0, 8.0, 9.0]);
    let vertices = block.cells.iter_mut().chain(&mut block.facets);
    vertices.for_each(|vertex| *vertex += 1);
    let name = server.upload(&block).await;
    let mesh = read(&server, &name).await;
    let last = block.coordinates.len() - 3;
    assert_eq!(mesh.header, block.header());
    assert_eq!(mesh.cells, block.cells);
    assert_eq!(corners(&mesh.facets), corners(&block.facets));
    assert_eq!(mesh.coordinates[3..last], block.coordinates[3..last]);
    assert_eq!(mesh.coordinates[..3], [0.0; 3]);
    assert_eq!(mesh.coordinates[last..], [0.0; 3]);
}

#[tokio::test]
async fn curved_edges_come_back_as_they_were_uploaded() {
    let (server, mut block) = (Server::start().await, Block::new(1));
    // An edge of the bottom and one of the top.
    block.curved_edges = vec![0, 1, 6, 7];
    block.edge_offsets = vec![0.0, -0.125, 0.0, 0.0, 0.25, 0.125];
    let name = server.upload(&block).await;
    let mesh = read(&server, &name).await;
    assert_eq!(mesh.header, block.header());
    assert_eq!(mesh.curved_edges, block.curved_edges);
    assert_eq!(mesh.edge_offsets, block.edge_offsets);
    block.edge_offsets[1] = -5.0;
    let status = refused(&server, block.messages()).await;
    assert_eq!(reason(&status), "MESH_INVALID");
    assert!(status.message().contains("edge offset 0"), "{status}");
}

#[tokio::test]
async fn a_mesh_that_is_being_read_is_kept() {
    let (server, block) = (Server::start().await, Block::new(24));
    let name = server.upload(&block).await;
    // A reader with a small window, so that most of the mesh has to wait.
    let slow = tonic::transport::Endpoint::new(server.url.clone()).unwrap();
    let slow = slow.initial_stream_window_size(1 << 16).connect().await;
    let mut slow = MeshServiceClient::new(slow.unwrap());
    let request = wire::ReadMeshRequest {
        name: name.clone(),
        ..Default::default()
    };
    let mut parts = slow.read_mesh(request).await.unwrap().into_inner();
    parts.message().await.unwrap().unwrap();
    let delete = || async {
        let request = wire::DeleteMeshRequest { name: name.clone() };
        server.meshes().delete_mesh(request).await
    };
    assert_eq!(reason(&delete().await.unwrap_err()), "MESH_IN_USE");
    drop(parts);
    let gone = async { while delete().await.is_err() {} };
    tokio::time::timeout(PATIENCE, gone)
        .await
        .expect("the end of a reading frees the mesh");
    let request = wire::ReadMeshRequest {
        name,
        ..Default::default()
    };
    let status = server.meshes().read_mesh(request).await.unwrap_err();
    assert_eq!(reason(&status), "MESH_NOT_FOUND");
}

#[tokio::test]
async fn an_announced_upload_beyond_the_budget_is_refused_before_a_chunk_is_read() {
    let (server, block) = (with_budget(4 << 30).await, Block::new(1));
    // 5 GB of arrays.
    let announced = wire::MeshHeader {
        vertex_count: 100_000_000,
        cell_count: 162_500_000,
        ..block.header()
    };
    // The stream stays open: the answer waits for nothing behind the header.
    let parts = tokio_stream::once(header(announced)).chain(tokio_stream::pending());
    let answer = server.meshes().upload_mesh(parts).await;
    let status = answer.unwrap_err();
    assert_eq!(status.code(), tonic::Code::ResourceExhausted);
    assert_eq!(reason(&status), "MEMORY_BUDGET");
    server.upload(&block).await;
}

async fn with_budget(bytes: i64) -> Server {
    let config = Config {
        memory_budget_bytes: bytes as u64,
        ..Config::embedded()
    };
    Server::with(config).await
}

#[tokio::test]
async fn an_upload_takes_little_more_than_its_mesh_from_the_budget() {
    let (server, block) = (Server::start().await, Block::new(12));
    let name = server.upload(&block).await;
    let request = wire::GetMeshRequest { name };
    let answer = server.meshes().get_mesh(request).await.unwrap();
    let bytes = answer.into_inner().mesh.unwrap().memory_bytes;
    with_budget(bytes + bytes / 8).await.upload(&block).await;
    let status = refused(&with_budget(bytes - 1).await, block.messages()).await;
    assert_eq!(reason(&status), "MEMORY_BUDGET");
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
async fn an_upload_without_a_digest_is_answered_with_it() {
    let (server, block) = (Server::start().await, Block::new(2));
    let without = || {
        let mut parts = block.messages();
        parts[0] = header(wire::MeshHeader {
            digest: String::new(),
            ..block.header()
        });
        tokio_stream::iter(parts)
    };
    for already_present in [false, true] {
        let answer = server.meshes().upload_mesh(without()).await.unwrap();
        let answer = answer.into_inner();
        assert_eq!(answer.already_present, already_present);
        assert_eq!(answer.mesh.unwrap().digest, block.digest());
    }
}

/// The chunks of one array, put together.
async fn read_array<E: signorini_proto::array::Element>(
    server: &Server,
    name: &str,
    array: wire::MeshArray,
    length: usize,
) -> Vec<E> {
    let request = wire::ReadMeshRequest {
        name: name.into(),
        arrays: vec![array.into()],
    };
    let answer = server.meshes().read_mesh(request).await.unwrap();
    let mut parts = answer.into_inner();
    let mut values = Assembler::new(length);
    while let Some(message) = parts.message().await.unwrap() {
        if let Some(read_mesh_response::Part::Chunk(chunk)) = message.part {
            assert_eq!(chunk.array(), array);
            values.push(chunk.offset_elements, &chunk.data).unwrap();
        }
    }
    values.finish().unwrap()
}

#[tokio::test]
async fn edges_come_where_they_are_asked_for_and_number_the_rows_of_displacement() {
    use wire::MeshArray::{CellEdges, Edges};
    let (server, block) = (Server::start().await, Block::new(3));
    let name = server.upload(&block).await;
    let mut expected: Vec<[i32; 2]> = Vec::new();
    let local = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];
    let pairs = |cell: &[i32]| local.map(|(a, b)| [cell[a].min(cell[b]), cell[a].max(cell[b])]);
    for cell in block.cells.chunks(4) {
        expected.extend(pairs(cell));
    }
    expected.sort_unstable();
    expected.dedup();
    let edges: Vec<i32> = read_array(&server, &name, Edges, 2 * expected.len()).await;
    assert_eq!(edges, expected.concat());
    let of_cells: Vec<i32> = read_array(&server, &name, CellEdges, 6 * block.cells.len() / 4).await;
    for (cell, edges) in block.cells.chunks(4).zip(of_cells.chunks(6)) {
        let found: Vec<[i32; 2]> = edges.iter().map(|edge| expected[*edge as usize]).collect();
        assert_eq!(found, pairs(cell));
    }
    let unknown = wire::ReadMeshRequest {
        name,
        arrays: vec![99],
    };
    let status = server.meshes().read_mesh(unknown).await.unwrap_err();
    assert_eq!(reason(&status), "REQUEST_INVALID");
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

    let mut flat = Block::new(1);
    flat.cells[1] = flat.cells[0];
    let status = refused(&server, flat.messages()).await;
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
