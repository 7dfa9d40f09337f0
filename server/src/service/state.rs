//! `ExportState` and `ImportState`.

use std::sync::Arc;
use std::time::Duration;

use bytes::Bytes;
use prost::Message as _;
use signorini_proto::CHUNK_BYTES;
use signorini_proto::v1 as wire;
use tonic::Streaming;

use crate::data::states::{self, State, States};
use crate::door::client_name::ClientName;
use crate::door::transport;
use crate::fault::Fault;
use crate::session::{Handle, Services};
use crate::uploads::store::Reservation;

/// An import that sends nothing for so long gives its memory back.
const IDLE: Duration = Duration::from_secs(60);

/// The state of a session in slices.
pub(super) async fn export(
    handle: Handle,
) -> Result<impl Iterator<Item = wire::ExportStateResponse> + Send, Fault> {
    let saved = handle.export().await?;
    let all = State {
        scene: handle.scene().encode_to_vec().into(),
        state: saved.state,
        since: saved.since,
    };
    let bytes = Bytes::from(all.to_bytes());
    let digest = states::digest(&bytes);
    let starts = (0..bytes.len()).step_by(CHUNK_BYTES);
    Ok(starts.map(move |start| {
        let end = bytes.len().min(start + CHUNK_BYTES);
        let last = end == bytes.len();
        wire::ExportStateResponse {
            offset: i64::try_from(start).unwrap_or(i64::MAX),
            data: bytes.slice(start..end),
            last,
            digest: if last { digest.clone() } else { String::new() },
        }
    }))
}

/// Takes slices into a reservation, checks them and keeps the state.
pub(super) async fn import(
    services: &Arc<Services>,
    (kept, owner): (&States, Option<ClientName>),
    (mut inbound, reservation): (Streaming<wire::ImportStateRequest>, Reservation),
) -> Result<wire::ImportStateResponse, Fault> {
    let mut upload = Upload {
        declared: String::new(),
        bytes: Vec::new(),
        reservation,
    };
    while let Some(slice) = next(&mut inbound).await? {
        upload.push(&slice)?;
    }
    let computed = states::digest(&upload.bytes);
    if computed != upload.declared {
        let declared = upload.declared;
        return Err(Fault::DigestMismatch { declared, computed });
    }
    State::from_bytes(&upload.bytes)?;
    let held = (Bytes::from(upload.bytes), upload.reservation);
    kept.keep(services.journal.as_ref(), (&computed, owner), held)
        .await?;
    let state = states::name(&computed);
    Ok(wire::ImportStateResponse { state })
}

/// A state that is still growing.
struct Upload {
    declared: String,
    bytes: Vec<u8>,
    /// Taken before the bytes are kept.
    reservation: Reservation,
}

impl Upload {
    fn push(&mut self, slice: &wire::ImportStateRequest) -> Result<(), Fault> {
        if self.bytes.is_empty() {
            self.declared.clone_from(&slice.digest);
        }
        if usize::try_from(slice.offset) != Ok(self.bytes.len()) {
            let expected = self.bytes.len();
            return Err(Fault::request("offset", format!("must be {expected}")));
        }
        if slice.data.len() > CHUNK_BYTES {
            return Err(Fault::MessageLimit {
                what: "bytes in `data`".to_owned(),
                limit: CHUNK_BYTES as u64,
            });
        }
        let after = (self.bytes.len() + slice.data.len()) as u64;
        // Growing keeps the bytes twice for a moment.
        let lacking = |lacking| Fault::MemoryBudget {
            predicted: lacking,
            held: after,
            budget: after,
        };
        self.reservation.resize(2 * after).map_err(lacking)?;
        self.bytes.extend_from_slice(&slice.data);
        Ok(())
    }
}

async fn next(
    inbound: &mut Streaming<wire::ImportStateRequest>,
) -> Result<Option<wire::ImportStateRequest>, Fault> {
    let silent = |_| {
        let text = format!("nothing came for {} seconds", IDLE.as_secs());
        Fault::request("import", text)
    };
    let arrived = tokio::time::timeout(IDLE, inbound.message()).await;
    arrived.map_err(silent)?.map_err(|status| {
        transport::fault_of(&status).unwrap_or_else(|| Fault::request("import", status.message()))
    })
}
