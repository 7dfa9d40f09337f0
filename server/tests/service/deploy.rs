//! What is shipped in `deploy/` matches the program.

use signorini_server::Config;

const SHIPPED: &str = include_str!("../../../deploy/server.toml");

#[test]
fn the_shipped_settings_are_the_defaults() {
    assert_eq!(Config::from_toml(SHIPPED), Ok(Config::default()));
}

#[test]
fn the_shipped_settings_name_every_key() {
    let defaults = format!("{:?}", Config::default());
    let inner = defaults
        .trim_start_matches("Config { ")
        .trim_end_matches(" }");
    for field in inner.split(", ") {
        let key = field.split(": ").next().unwrap_or_default();
        // Methods come with the program, not with its settings.
        if key == "compared" {
            continue;
        }
        let named = SHIPPED
            .lines()
            .any(|line| line.starts_with(&format!("{key} = ")));
        assert!(named, "{key} is missing");
    }
}
