//! What the transport lets through and what it refuses, with reasons; and what
//! one connection bears.

use std::time::Duration;

use crate::common::{Block, Server, reason};
use bytes::{Buf as _, BufMut as _};
use prost::Message as _;
use signorini_proto::CHUNK_BYTES;
use signorini_proto::v1::{self as wire, upload_mesh_request::Part};
use tonic::codec::{Codec, DecodeBuf, Decoder, EncodeBuf, Encoder};
use tonic::codegen::http::uri::PathAndQuery;
use tonic::{Code, Request, Status};
use tonic_health::pb::health_check_response::ServingStatus;
use tonic_health::pb::health_client::HealthClient;
use tonic_health::pb::{HealthCheckRequest, HealthCheckResponse};
use tonic_types::StatusExt;

/// Ends a test that would wait for ever.
const PATIENCE: Duration = Duration::from_secs(10);
const MESSAGE_BYTES: usize = 4 << 20;
const GET_MESH: &str = "/signorini.v1.MeshService/GetMesh";
const UPLOAD_MESH: &str = "/signorini.v1.MeshService/UploadMesh";
const SOLVE: &str = "/signorini.v1.SessionService/Solve";

/// Messages as the bytes that they are.
struct Raw;

impl Codec for Raw {
    type Encode = Vec<u8>;
    type Decode = Vec<u8>;
    type Encoder = Self;
    type Decoder = Self;

    fn encoder(&mut self) -> Self {
        Self
    }

    fn decoder(&mut self) -> Self {
        Self
    }
}

impl Encoder for Raw {
    type Item = Vec<u8>;
    type Error = Status;

    fn encode(&mut self, item: Vec<u8>, out: &mut EncodeBuf<'_>) -> Result<(), Status> {
        out.put_slice(&item);
        Ok(())
    }
}

impl Decoder for Raw {
    type Item = Vec<u8>;
    type Error = Status;

    fn decode(&mut self, bytes: &mut DecodeBuf<'_>) -> Result<Option<Vec<u8>>, Status> {
        Ok(Some(bytes.copy_to_bytes(bytes.remaining()).to_vec()))
    }
}

async fn grpc(server: &Server) -> tonic::client::Grpc<tonic::transport::Channel> {
    let mut grpc = tonic::client::Grpc::new(server.channel.clone());
    grpc.ready().await.unwrap();
    grpc
}

async fn call(server: &Server, path: &'static str, message: Vec<u8>) -> Result<Vec<u8>, Status> {
    let path = PathAndQuery::from_static(path);
    let mut grpc = grpc(server).await;
    let answer = grpc.unary(Request::new(message), path, Raw).await?;
    Ok(answer.into_inner())
}

/// The status that ends a stream with this one message.
async fn stream_refusal(server: &Server, path: &'static str, message: Vec<u8>) -> Status {
    let path = PathAndQuery::from_static(path);
    let messages = Request::new(tokio_stream::once(message));
    match grpc(server).await.streaming(messages, path, Raw).await {
        Err(status) => status,
        Ok(answers) => answers.into_inner().message().await.unwrap_err(),
    }
}

/// A question for `name` with a field that the service does not know, so that
/// the message has `length` bytes.
fn padded(name: &str, length: usize) -> Vec<u8> {
    let mut bytes = wire::GetMeshRequest { name: name.into() }.encode_to_vec();
    // Field 15, length-delimited; a length of four bytes follows.
    bytes.push(15 << 3 | 2);
    let padding = length - bytes.len() - 4;
    prost::encoding::encode_varint(padding as u64, &mut bytes);
    bytes.resize(bytes.len() + padding, 0);
    assert_eq!(bytes.len(), length);
    bytes
}

fn assert_too_large(status: &Status, limit: usize) {
    assert_eq!(status.code(), Code::ResourceExhausted);
    assert_eq!(reason(status), "MESSAGE_LIMIT");
    let metadata = status.get_details_error_info().unwrap().metadata;
    assert_eq!(metadata["limit"], limit.to_string());
}

fn assert_no_message(status: &Status) {
    assert_eq!(status.code(), Code::InvalidArgument);
    assert_eq!(reason(status), "REQUEST_INVALID");
}

#[tokio::test]
async fn the_largest_legal_message_passes_and_one_byte_more_is_refused_with_its_reason() {
    let server = Server::start().await;
    let name = server.upload(&Block::new(1)).await;
    let answer = call(&server, GET_MESH, padded(&name, MESSAGE_BYTES)).await;
    let answer = wire::GetMeshResponse::decode(&answer.unwrap()[..]).unwrap();
    assert_eq!(answer.mesh.unwrap().name, name);
    let beyond = padded(&name, MESSAGE_BYTES + 1);
    let status = call(&server, GET_MESH, beyond.clone()).await.unwrap_err();
    assert_too_large(&status, MESSAGE_BYTES);
    for path in [UPLOAD_MESH, SOLVE] {
        let status = stream_refusal(&server, path, beyond.clone()).await;
        assert_too_large(&status, MESSAGE_BYTES);
    }
}

#[tokio::test]
async fn bytes_that_are_no_message_are_refused_with_a_reason() {
    let server = Server::start().await;
    let garbage = vec![0xff; 10];
    let status = call(&server, GET_MESH, garbage.clone()).await.unwrap_err();
    assert_no_message(&status);
    for path in [UPLOAD_MESH, SOLVE] {
        assert_no_message(&stream_refusal(&server, path, garbage.clone()).await);
    }
}

#[tokio::test]
async fn a_chunk_has_one_mebibyte_and_not_an_element_more() {
    // Cells for more than one full chunk.
    let (server, block) = (Server::start().await, Block::new(23));
    let is_full = |message: &wire::UploadMeshRequest| match &message.part {
        Some(Part::Chunk(chunk)) => chunk.data.len() == CHUNK_BYTES,
        Some(Part::Header(_)) | None => false,
    };
    assert!(block.messages().iter().any(is_full));
    server.upload(&block).await;

    let other = wire::MeshHeader {
        digest: "0".repeat(64),
        ..block.header()
    };
    let large = wire::MeshChunk {
        array: wire::MeshArray::Cells.into(),
        data: vec![0; CHUNK_BYTES + 4].into(),
        ..Default::default()
    };
    let parts = [Part::Header(other), Part::Chunk(large)];
    let parts = parts.map(|part| wire::UploadMeshRequest { part: Some(part) });
    let answer = server.meshes().upload_mesh(tokio_stream::iter(parts)).await;
    assert_too_large(&answer.unwrap_err(), CHUNK_BYTES);
}

async fn watch_health(server: &Server) -> tonic::Streaming<HealthCheckResponse> {
    let request = HealthCheckRequest::default();
    let mut client = HealthClient::new(server.channel.clone());
    let mut stream = client.watch(request).await.unwrap().into_inner();
    let first = stream.message().await.unwrap().unwrap();
    assert_eq!(first.status(), ServingStatus::Serving);
    stream
}

#[tokio::test]
async fn a_thousand_streams_share_one_connection() {
    let (server, block) = (Server::start().await, Block::new(1));
    server.upload(&block).await;
    let name = server.session(block.scene()).await;
    let open = async {
        let mut streams = Vec::new();
        for _ in 0..1000 {
            let request = wire::WatchRequest {
                name: name.clone(),
                ..Default::default()
            };
            streams.push(server.watch(request).await);
        }
        streams
    };
    let streams = tokio::time::timeout(PATIENCE, open).await;
    assert_eq!(streams.expect("no stream waits for another").len(), 1000);
}

#[tokio::test]
async fn a_watcher_of_the_health_service_does_not_hold_up_the_shutdown() {
    let mut server = Server::start().await;
    let mut watcher = watch_health(&server).await;
    server.signal_stop();
    let told = watcher.message().await.unwrap().unwrap();
    assert_eq!(told.status(), ServingStatus::NotServing);
    let stopped = tokio::time::timeout(PATIENCE, server.stopped()).await;
    stopped.expect("the server stops").unwrap();
}
