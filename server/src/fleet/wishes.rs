//! Wishes for sessions from server to server: a session that nobody writes to goes where somebody
//! wants to. A proxy that has forgotten where it is, or leads by other rules since, is met so.
//!
//! They are questions that may be lost: who gets no answer tells its client who has the session.

use std::time::Duration;

use async_nats::Client;
use tokio::sync::{mpsc, oneshot};
use tokio_stream::StreamExt as _;

use super::Wished;

const SUBJECT: &str = "signorini.wishes";
const YES: &str = "yes";
/// Wishes that may wait.
const WAITING: usize = 64;

/// Asks the holder of a session for it; whether it has given it back.
pub(super) async fn ask((client, process): (&Client, &str), id: &str, patience: Duration) -> bool {
    let subject = format!("{SUBJECT}.{process}");
    let asked = client.request(subject, id.to_owned().into());
    let answer = tokio::time::timeout(patience, asked).await;
    answer.is_ok_and(|answer| answer.is_ok_and(|answer| answer.payload == YES))
}

/// The wishes that others have of this process.
pub(super) async fn of_others(
    client: &Client,
    process: &str,
) -> Result<mpsc::Receiver<Wished>, async_nats::Error> {
    let mut asked = client.subscribe(format!("{SUBJECT}.{process}")).await?;
    let (sender, wishes) = mpsc::channel(WAITING);
    let client = client.clone();
    tokio::spawn(async move {
        while let Some(message) = asked.next().await {
            let (Some(reply), Ok(id)) = (message.reply, std::str::from_utf8(&message.payload))
            else {
                continue;
            };
            let (answer, answered) = oneshot::channel();
            if sender
                .send((format!("sessions/{id}"), answer))
                .await
                .is_err()
            {
                return;
            }
            let client = client.clone();
            tokio::spawn(async move {
                if answered.await == Ok(true) {
                    // Who asked may have left.
                    let _left = client.publish(reply, YES.into()).await;
                }
            });
        }
    });
    Ok(wishes)
}
