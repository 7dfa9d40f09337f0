//! What an upload takes while it comes, and how long it may take.

use std::future::Future;
use std::time::Duration;

use signorini_proto::v1::{self as wire, upload_mesh_request};
use tokio::time::Instant;
use tonic::{Status, Streaming};

use crate::convert::mesh::Header;
use crate::door::client_key::ClientIdentity;
use crate::door::gates::UploadShare;
use crate::door::transport;
use crate::fault::Fault;
use crate::session::Services;
use crate::uploads::store::Reservation;

/// Time that every upload has; one that sends nothing for so long gives its memory back.
const IDLE: Duration = Duration::from_secs(60);

/// An upload slower than this after that time counts as abandoned.
const LEAST_BYTES_PER_SECOND: u64 = 64 << 10;
/// What an upload has taken of the budget: as much as its chunks that have come are of
/// all, held until the mesh itself is counted.
pub(super) struct Taken {
    reservation: Reservation,
    share: UploadShare,
    begun: Instant,
    received: u64,
    /// Of the arrays on the wire, and of the upload with the mesh made of it.
    announced: u64,
    predicted: u64,
}

impl Taken {
    pub(super) fn new(services: &Services, client: ClientIdentity) -> Result<Self, Fault> {
        Ok(Self {
            reservation: services.store.reserve(0)?,
            share: services.gates.uploads.begin(client),
            begun: Instant::now(),
            received: 0,
            announced: 0,
            predicted: 0,
        })
    }

    /// Refuses at once what can never fit.
    pub(super) fn expect(&mut self, header: &Header) -> Result<(), Fault> {
        (self.announced, self.predicted) = (header.array_bytes(), header.predicted_bytes());
        self.take(self.predicted)?;
        self.take(0)
    }

    fn take(&mut self, bytes: u64) -> Result<(), Fault> {
        self.share.grow(bytes)?;
        self.reservation.claim(bytes)
    }

    /// Takes the part of a chunk before it is stored.
    pub(super) fn grow(&mut self, bytes: u64) -> Result<(), Fault> {
        self.received = self.received.saturating_add(bytes);
        let part = u128::from(self.predicted) * u128::from(self.received);
        let part = part / u128::from(self.announced.max(1));
        // More than was announced is refused where it is stored.
        let part = u64::try_from(part).unwrap_or(u64::MAX).min(self.predicted);
        self.take(part)
    }

    /// When the upload has become too slow: it has a minute, and more for what has come.
    pub(super) fn end(&self) -> Instant {
        self.begun + IDLE + Duration::from_secs(self.received / LEAST_BYTES_PER_SECOND)
    }

    pub(super) fn bytes(&self) -> u64 {
        self.reservation.bytes()
    }
}

pub(super) async fn next(
    inbound: &mut Streaming<wire::UploadMeshRequest>,
    end: Instant,
) -> Result<Option<upload_mesh_request::Part>, Fault> {
    let broken = |status: Status| {
        transport::fault_of_stream(&status)
            .unwrap_or_else(|| Fault::request("upload", status.message()))
    };
    match by(end, inbound.message()).await?.map_err(broken)? {
        None => Ok(None),
        Some(message) => message.part.map(Some).ok_or_else(|| {
            Fault::unsupported("upload", "a message that this version does not know")
        }),
    }
}

/// The outcome of `arrival`, if it comes before an upload counts as abandoned.
async fn by<T>(end: Instant, arrival: impl Future<Output = T>) -> Result<T, Fault> {
    let arrived = tokio::time::timeout_at(end, arrival).await;
    arrived.map_err(|_| {
        let text = format!(
            "came slower than {LEAST_BYTES_PER_SECOND} bytes a second after its first {} seconds",
            IDLE.as_secs()
        );
        Fault::request("upload", text)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn an_upload_that_goes_silent_ends_with_a_reason() {
        let silent = std::future::pending::<()>();
        let fault = by(Instant::now(), silent).await.unwrap_err();
        assert!(matches!(fault, Fault::RequestInvalid(_)), "{fault}");
    }
}
