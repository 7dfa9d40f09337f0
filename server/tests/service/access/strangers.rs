//! Who proves no name: what the server keeps and writes for strangers.

use signorini_proto::v1 as wire;
use signorini_server::{Config, Role};
use tonic::Code;
use tonic_health::pb::HealthCheckRequest;
use tonic_health::pb::health_client::HealthClient;

use super::{Client, GET, Tokens, soon};
use crate::common::{Server, page, reason, sample};

fn stranger(server: &Server) -> Client {
    Client {
        channel: server.channel.clone(),
        token: None,
    }
}

/// Asks for a session without a token; the reason of the refusal.
async fn refusal(client: &Client) -> String {
    let request = wire::GetSessionRequest::default();
    let answer = client.first::<_, wire::GetSessionResponse>(GET, request);
    reason(&answer.await.unwrap_err())
}

#[tokio::test(flavor = "multi_thread")]
async fn strangers_hold_few_watches_of_health_and_probes_get_through() {
    let tokens = Tokens::new("watchers");
    let server = Server::with(tokens.config()).await;
    let (mut held, mut refused) = (Vec::new(), 0);
    for connection in 0..40 {
        let mut health = HealthClient::new(server.connect().await);
        let before = held.len();
        for _ in 0..40 {
            match health.watch(HealthCheckRequest::default()).await {
                Ok(answers) => held.push(answers.into_inner()),
                Err(status) => {
                    assert_eq!(status.code(), Code::ResourceExhausted);
                    assert_eq!(reason(&status), "MESSAGE_LIMIT");
                    refused += 1;
                }
            }
        }
        let own = held.len() - before;
        assert_eq!(own, if connection < 16 { 16 } else { 0 }, "{connection}");
        health.check(HealthCheckRequest::default()).await.unwrap();
    }
    assert_eq!((held.len(), refused), (256, 1600 - 256));
    for watch in &mut held {
        assert!(watch.message().await.unwrap().is_some());
    }
    drop(held);
    let again = async || {
        let mut health = HealthClient::new(server.connect().await);
        health.watch(HealthCheckRequest::default()).await.is_ok()
    };
    soon("room for another watch", again).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn refusals_of_strangers_are_counted_where_the_log_leaves_them_out() {
    let tokens = Tokens::new("refusals");
    let server = Server::with(Config {
        metrics_listen: "127.0.0.1:0".to_owned(),
        ..tokens.config()
    })
    .await;
    let client = stranger(&server);
    for _ in 0..400 {
        assert_eq!(refusal(&client).await, "UNAUTHENTICATED");
    }
    let page = page(server.metrics_url.as_ref().unwrap()).await;
    let refused = sample(&page, "signorini_refused_total{reason=\"UNAUTHENTICATED\"}");
    let left_out = |whose| {
        let series = format!("signorini_log_lines_left_out_total{{whose=\"{whose}\"}}");
        sample(&page, &series)
    };
    assert_eq!(refused, 400);
    // Forty at once, and four in each second that it took.
    assert!((200..=360).contains(&left_out("strangers")));
    assert_eq!(left_out("clients"), 0);
}

#[tokio::test(flavor = "multi_thread")]
async fn strangers_have_a_rate_by_where_they_come_from_and_names_one_of_their_own() {
    let mut tokens = Tokens::new("rate");
    let token = tokens.add("line-1", Role::Solve);
    let server = Server::with(Config {
        maximum_client_calls_per_second: 5,
        ..tokens.config()
    })
    .await;
    let (client, mut tries) = (stranger(&server), 0);
    while refusal(&client).await == "UNAUTHENTICATED" {
        tries += 1;
        assert!(tries < 1000);
    }
    assert!(tries >= 10, "{tries}");
    assert_eq!(refusal(&client).await, "CALL_RATE");
    assert!(Client::of(&server, &token).sessions().await.is_ok());
}
