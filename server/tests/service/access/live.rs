//! Whom the live page tells what.

use signorini_server::{Config, Role};

use super::{Client, Tokens, soon};
use crate::common::{Block, Server, answer_to};
use crate::live::data;

const ASKED: &str = "GET /live.json";

/// Names of the sessions that the page shows to a token; none where it is refused.
async fn shown(server: &Server, token: &str) -> Option<Vec<String>> {
    let url = server.metrics_url.as_ref().unwrap();
    let bearer = format!("Bearer {token}");
    let answer = answer_to(url, ASKED, &[("Authorization", &bearer)]).await;
    if answer.starts_with("HTTP/1.1 401") {
        assert!(answer.contains("www-authenticate: Bearer"), "{answer}");
        return None;
    }
    let live = data(&answer);
    let sessions = live["sessions"].as_array().unwrap().iter();
    let names = sessions.map(|one| one["name"].as_str().unwrap().to_owned());
    assert_eq!(live["left_out"], 0);
    Some(names.collect())
}

#[tokio::test(flavor = "multi_thread")]
async fn the_live_page_asks_for_a_token_and_shows_what_is_its_own() {
    let mut tokens = Tokens::new("live");
    let line_1 = tokens.add("line-1", Role::Solve);
    let watcher = tokens.add("line-1", Role::Read);
    let line_2 = tokens.add("line-2", Role::Read);
    let ops = tokens.add("ops", Role::Admin);
    let config = Config {
        metrics_listen: "127.0.0.1:0".into(),
        ..tokens.config()
    };
    let server = Server::with(config).await;
    let (client, block) = (Client::of(&server, &line_1), Block::new(1));
    client.upload(&block).await.unwrap();
    let session = client.create(&block, "secret-part").await.unwrap();
    for own in [&line_1, &watcher, &ops] {
        assert_eq!(shown(&server, own).await.unwrap(), [session.as_str()]);
    }
    assert!(shown(&server, &line_2).await.unwrap().is_empty());
    assert_eq!(shown(&server, "signorini_guessed").await, None);
    let url = server.metrics_url.as_ref().unwrap();
    for headers in [&[][..], &[("Authorization", "Basic b3BzOm9wcw==")][..]] {
        let refused = answer_to(url, ASKED, headers).await;
        assert!(refused.starts_with("HTTP/1.1 401"), "{refused}");
        assert!(!refused.contains("secret-part"), "{refused}");
    }
    tokens.revoke("ops");
    soon("the refusal", async || shown(&server, &ops).await.is_none()).await;
}
