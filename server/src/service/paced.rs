//! Answers of many messages: a reader that takes none for a while loses the rest, and what
//! they hold is given back.

use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use tokio::sync::mpsc;
use tokio::sync::mpsc::error::SendTimeoutError;
use tokio_stream::wrappers::ReceiverStream;
use tokio_stream::{Stream, StreamExt as _};
use tonic::Status;
use tracing::Instrument as _;

use crate::fault::Fault;

/// How long one message waits for its reader.
const PATIENCE: Duration = Duration::from_secs(60);

pub(super) type Messages<T> = Pin<Box<dyn Stream<Item = Result<T, Status>> + Send>>;

/// The messages, as fast as they are read.
pub(super) fn paced<T: Send + 'static>(
    messages: impl Iterator<Item = T> + Send + 'static,
) -> Messages<T> {
    paced_within(PATIENCE, messages)
}

fn paced_within<T: Send + 'static>(
    patience: Duration,
    messages: impl Iterator<Item = T> + Send + 'static,
) -> Messages<T> {
    let (sender, receiver) = mpsc::channel(1);
    let is_late = Arc::new(AtomicBool::new(false));
    let late = Arc::clone(&is_late);
    let sending = async move {
        for message in messages {
            match sender.send_timeout(Ok(message), patience).await {
                Ok(()) => {}
                Err(SendTimeoutError::Timeout(_)) => {
                    tracing::info!("an answer is given up: nobody reads it");
                    return late.store(true, Ordering::SeqCst);
                }
                // The client has left.
                Err(SendTimeoutError::Closed(_)) => return,
            }
        }
    };
    tokio::spawn(sending.in_current_span());
    // Looked at when the last message is out.
    let end = std::iter::from_fn(move || is_late.swap(false, Ordering::SeqCst).then_some(()));
    let end = end.map(|()| Err(Fault::StreamDeadline.into()));
    Box::pin(ReceiverStream::new(receiver).chain(tokio_stream::iter(end)))
}

#[cfg(test)]
mod tests {
    use tonic::Code;

    use super::*;

    #[tokio::test]
    async fn a_reader_gets_all_in_order() {
        let all: Vec<_> = paced(0..100).map(Result::unwrap).collect().await;
        assert_eq!(all, (0..100).collect::<Vec<_>>());
    }

    #[tokio::test]
    async fn messages_that_nobody_reads_are_given_up() {
        let held = Arc::new(());
        let kept = Arc::clone(&held);
        let endless = std::iter::repeat_with(move || Arc::clone(&kept));
        let mut stream = paced_within(Duration::from_millis(20), endless);
        assert!(stream.next().await.unwrap().is_ok());
        // One message waits in the channel, another for its place: both but the first go.
        let given_up = async {
            while Arc::strong_count(&held) > 2 {
                tokio::time::sleep(Duration::from_millis(5)).await;
            }
        };
        let given_up = tokio::time::timeout(Duration::from_secs(20), given_up).await;
        given_up.unwrap();
        assert!(stream.next().await.unwrap().is_ok());
        let end = stream.next().await.unwrap().unwrap_err();
        assert_eq!(end.code(), Code::DeadlineExceeded);
        assert!(stream.next().await.is_none());
    }
}
