//! A server that is alone has nothing of a fleet: no series, and without the feature no line.

use crate::common::{Server, page};
use signorini_server::Config;

/// What the manifest says of itself.
fn manifest() -> toml::Table {
    let text = include_str!("../../Cargo.toml");
    text.parse().unwrap()
}

#[tokio::test]
async fn a_server_alone_counts_nothing_of_a_fleet() {
    let config = Config {
        metrics_listen: "127.0.0.1:0".to_owned(),
        ..Config::embedded()
    };
    let server = Server::with(config).await;
    let page = page(server.metrics_url.as_deref().unwrap()).await;
    assert!(page.contains("signorini_sessions"));
    assert_eq!(page.matches("signorini_fleet").count(), 0);
}

#[test]
fn the_default_build_has_no_line_of_a_fleet() {
    let manifest = manifest();
    let features = manifest["features"].as_table().unwrap();
    // Without a list nothing is on by default.
    let of = |name: &str| match features.get(name) {
        Some(list) => list.as_array().unwrap().clone(),
        None => Vec::new(),
    };
    assert!(
        of("default")
            .iter()
            .all(|one| one.as_str() != Some("fleet"))
    );
    // Everything that the feature takes is there for it alone.
    for dependency in of("fleet") {
        let name = dependency.as_str().unwrap().strip_prefix("dep:").unwrap();
        assert_eq!(
            manifest["dependencies"][name]["optional"].as_bool(),
            Some(true),
            "{name}"
        );
        let users = features
            .values()
            .filter(|users| users.as_array().unwrap().contains(&dependency));
        assert_eq!(users.count(), 1, "{name}");
    }
}

#[cfg(not(feature = "fleet"))]
#[tokio::test]
async fn a_fleet_is_refused_with_what_it_takes() {
    let config = Config {
        fleet_nats: "nats://127.0.0.1:4222".to_owned(),
        fleet_store: "store".to_owned(),
        data: crate::common::folder("no-fleet")
            .join("data")
            .to_str()
            .unwrap()
            .to_owned(),
        ..Config::embedded()
    };
    let refused = Server::listening(config).await.stopped().await.unwrap_err();
    assert!(
        refused.to_string().contains("the feature `fleet`"),
        "{refused}"
    );
}
