//! Names of sessions: those that clients choose, and those that the server makes.

use std::hash::{BuildHasher, Hasher, RandomState};

use crate::fault::Fault;

const PREFIX: &str = "sessions/";
const SHORTEST_ID: usize = 4;
const LONGEST_ID: usize = 63;

pub(super) fn new_name() -> String {
    // Random keys of the standard hasher: enough for names nobody guesses by accident.
    let number = RandomState::new().build_hasher().finish();
    format!("{PREFIX}s{number:016x}")
}

pub(super) fn checked_name(id: &str) -> Result<String, Fault> {
    let allowed = |byte: u8| byte.is_ascii_lowercase() || byte.is_ascii_digit() || byte == b'-';
    let starts = id
        .bytes()
        .next()
        .is_some_and(|byte| byte.is_ascii_lowercase());
    let fits = (SHORTEST_ID..=LONGEST_ID).contains(&id.len());
    if starts && fits && id.bytes().all(allowed) {
        return Ok(format!("{PREFIX}{id}"));
    }
    let rule = "must be 4 to 63 characters of a-z, 0-9 and hyphen, starting with a letter";
    Err(Fault::request("session_id", rule))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_follow_their_rule() {
        assert_eq!(checked_name("ball-1"), Ok("sessions/ball-1".into()));
        for bad in ["abc", "1abc", "Ball", "a/../b", "ba ll", &"a".repeat(64)] {
            assert!(checked_name(bad).is_err(), "{bad}");
        }
        assert!(checked_name(new_name().strip_prefix(PREFIX).unwrap()).is_ok());
        assert_ne!(new_name(), new_name());
    }
}
