//! Whether the system tells this process which of the machine's users is which.
//!
//! In a user namespace that maps few users, as `PrivateUsers=yes` of systemd or a container
//! without privileges has, the kernel shows all others by one number, the overflow number
//! (user_namespaces(7)).

/// What a process with all users of the machine has in `uid_map`: as many as there can be.
const ALL: u64 = u32::MAX as u64;

/// Whether each user of the machine has a number of its own for this process; also where the
/// system has no such namespaces.
pub(crate) fn are_told_apart() -> bool {
    std::fs::read_to_string("/proc/self/uid_map").map_or(true, |map| maps_all(&map))
}

/// Whether lines of first number inside, first outside, and count map every number.
fn maps_all(map: &str) -> bool {
    let counts = map.lines().filter_map(|line| {
        let count = line.split_ascii_whitespace().nth(2)?;
        count.parse::<u64>().ok()
    });
    counts.fold(0, u64::saturating_add) >= ALL
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_namespace_with_few_users_tells_them_not_apart() {
        assert!(maps_all("         0          0 4294967295\n"));
        assert!(maps_all("0 0 1\n1 1 4294967294\n"));
        for few in ["", "0 1000 1\n", "0 1000 1\n1 100000 65536\n", "a b c\n"] {
            assert!(!maps_all(few), "{few}");
        }
    }
}
