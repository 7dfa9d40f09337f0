//! Whether a proxy can stand in front of servers, by the version that it tells of itself.
//!
//! HAProxy before 3.2 turns a reset without an error, with which a server ends an upload that it
//! needs no more of and a stream that it refuses, into a cancellation: the reason is lost
//! (issue 1219 of HAProxy).

use std::path::Path;
use std::process::Command;

use super::{Finding, Health, finding};

/// The first HAProxy that hands a reset without an error on.
const HAPROXY: (u32, u32) = (3, 2);
/// The first nginx with `grpc_pass`.
const NGINX: (u32, u32) = (1, 13);

const HAPROXY_FAULT: &str = "before 3.2 it loses why a stream was refused or an upload not needed \
     (CANCELLED in place of the reason): take 3.2 or later, or nginx";
const NGINX_FAULT: &str = "before 1.13 it knows no gRPC";

/// Runs `program -v`.
pub(super) fn proxy(program: &Path) -> Finding {
    match Command::new(program).arg("-v").output() {
        Ok(told) => {
            // nginx tells it on stderr.
            let text = [told.stdout, told.stderr].concat();
            judged(&String::from_utf8_lossy(&text))
        }
        Err(error) => finding(
            "proxy",
            program.display().to_string(),
            Health::Fault(error.to_string()),
        ),
    }
}

fn judged(told: &str) -> Finding {
    let first = told.lines().next().unwrap_or_default().trim();
    let shown: String = first.chars().take(80).collect();
    let words = [
        ("HAProxy version ", HAPROXY, HAPROXY_FAULT),
        ("nginx version: nginx/", NGINX, NGINX_FAULT),
    ];
    let known = words
        .into_iter()
        .find_map(|(word, least, fault)| Some((version(first.strip_prefix(word)?)?, least, fault)));
    let health = match known {
        Some((found, least, fault)) if found < least => Health::Fault(fault.to_owned()),
        Some(_) => Health::Good,
        None => {
            let advice = "neither HAProxy nor nginx: not tried in front of this server";
            Health::Advice(advice.to_owned())
        }
    };
    finding("proxy", shown, health)
}

/// The first two numbers of a version.
fn version(text: &str) -> Option<(u32, u32)> {
    let mut numbers = text.split(|one: char| !one.is_ascii_digit());
    let mut next = || numbers.next()?.parse().ok();
    Some((next()?, next()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_proxy_that_loses_the_reasons_of_refusals_is_a_fault() {
        for (told, health) in [
            (
                "HAProxy version 2.6.12-1+deb12u2 2025/04/14 - https://haproxy.org/",
                HAPROXY_FAULT,
            ),
            ("HAProxy version 3.1.9 2025/09/01", HAPROXY_FAULT),
            ("nginx version: nginx/1.12.2", NGINX_FAULT),
        ] {
            assert_eq!(
                judged(told).health,
                Health::Fault(health.to_owned()),
                "{told}"
            );
        }
        for told in [
            "HAProxy version 3.2.0 2025/05/28",
            "HAProxy version 3.5-dev5-50872daa6 2026/08/21 - https://haproxy.org/",
            "nginx version: nginx/1.22.1",
        ] {
            assert_eq!(judged(told).health, Health::Good, "{told}");
        }
        let other = judged("envoy 1.30").health;
        assert!(matches!(other, Health::Advice(_)));
        let missing = proxy(Path::new("/nowhere/haproxy"));
        assert!(matches!(missing.health, Health::Fault(_)));
    }
}
