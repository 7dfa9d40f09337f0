//! HTTP/2 frame by frame, for what no library sends (RFC 9113, RFC 7541).

use std::time::Duration;

use bytes::{Buf as _, Bytes, BytesMut};
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::TcpStream;

use crate::common::Server;

const PREFACE: &[u8] = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";
const HEAD_BYTES: usize = 9;
const DATA: u8 = 0;
const HEADERS: u8 = 1;
const RST_STREAM: u8 = 3;
const SETTINGS: u8 = 4;
const PING: u8 = 6;
const WINDOW_UPDATE: u8 = 8;
const END_STREAM: u8 = 1;
const END_HEADERS: u8 = 4;
const ACK: u8 = 1;
const INITIAL_WINDOW_SIZE: u16 = 4;

/// A frame that the server sent.
pub(crate) struct Received {
    pub(crate) kind: u8,
    pub(crate) flags: u8,
    pub(crate) stream: u32,
}

impl Received {
    /// Whether nothing more comes on its stream.
    pub(crate) fn ends_stream(&self) -> bool {
        let is_end = [DATA, HEADERS].contains(&self.kind) && self.flags & END_STREAM != 0;
        self.stream > 0 && (is_end || self.kind == RST_STREAM)
    }
}

/// One connection.
pub(crate) struct Raw {
    socket: TcpStream,
    received: BytesMut,
}

impl Raw {
    /// Connects; each of its streams may be sent so many bytes.
    pub(crate) async fn connect(server: &Server, window: u32) -> Self {
        let address = server.url.trim_start_matches("http://");
        let mut raw = Self {
            socket: TcpStream::connect(address).await.unwrap(),
            received: BytesMut::new(),
        };
        raw.socket.write_all(PREFACE).await.unwrap();
        let mut settings = INITIAL_WINDOW_SIZE.to_be_bytes().to_vec();
        settings.extend(window.to_be_bytes());
        assert!(raw.frame((SETTINGS, 0), 0, &settings).await);
        raw
    }

    /// Whether the frame could be sent.
    async fn frame(&mut self, (kind, flags): (u8, u8), stream: u32, payload: &[u8]) -> bool {
        let length = u32::try_from(payload.len()).unwrap().to_be_bytes();
        let mut bytes = length[1..].to_vec();
        bytes.extend([kind, flags]);
        bytes.extend(stream.to_be_bytes());
        bytes.extend(payload);
        self.socket.write_all(&bytes).await.is_ok()
    }

    /// Begins a call.
    pub(crate) async fn call(&mut self, stream: u32, path: &str) -> bool {
        let mut block = Vec::new();
        for (name, value) in [
            (":method", "POST"),
            (":scheme", "http"),
            (":path", path),
            (":authority", "localhost"),
            ("content-type", "application/grpc"),
            ("te", "trailers"),
        ] {
            // A literal without index, its name and its value as they are.
            block.push(0);
            for text in [name, value] {
                assert!(text.len() < 127, "one byte of length");
                block.push(text.len() as u8);
                block.extend(text.as_bytes());
            }
        }
        self.frame((HEADERS, END_HEADERS), stream, &block).await
    }

    pub(crate) async fn data(&mut self, stream: u32, bytes: &[u8]) -> bool {
        self.frame((DATA, 0), stream, bytes).await
    }

    /// Ends what the client sends of a call.
    pub(crate) async fn end(&mut self, stream: u32, bytes: &[u8]) -> bool {
        self.frame((DATA, END_STREAM), stream, bytes).await
    }

    pub(crate) async fn window(&mut self, stream: u32, more: u32) -> bool {
        self.frame((WINDOW_UPDATE, 0), stream, &more.to_be_bytes())
            .await
    }

    /// The next frame but those of the connection itself, which are answered; none at the end. Nothing
    /// is lost when the future is dropped.
    pub(crate) async fn next(&mut self, patience: Duration) -> Option<Received> {
        let received = async {
            loop {
                while let Some((received, payload)) = self.parse() {
                    match received.kind {
                        SETTINGS | PING if received.flags & ACK == 0 => {
                            let back = if received.kind == PING {
                                &payload[..]
                            } else {
                                &[]
                            };
                            self.frame((received.kind, ACK), 0, back).await;
                        }
                        SETTINGS | PING | WINDOW_UPDATE => {}
                        _ => return Some(received),
                    }
                }
                match self.socket.read_buf(&mut self.received).await {
                    Ok(0) | Err(_) => return None,
                    Ok(_) => {}
                }
            }
        };
        let received = tokio::time::timeout(patience, received).await;
        received.expect("a frame or the end in time")
    }

    /// A frame that is there as a whole.
    fn parse(&mut self) -> Option<(Received, Bytes)> {
        let head = self.received.get(..HEAD_BYTES)?;
        let length = u32::from_be_bytes([0, head[0], head[1], head[2]]) as usize;
        let received = Received {
            kind: head[3],
            flags: head[4],
            stream: u32::from_be_bytes([head[5], head[6], head[7], head[8]]),
        };
        self.received.get(..HEAD_BYTES + length)?;
        self.received.advance(HEAD_BYTES);
        Some((received, self.received.split_to(length).freeze()))
    }
}
