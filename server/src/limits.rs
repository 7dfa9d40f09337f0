//! What the system lets this process have: memory and descriptors; and how large a message is.

use std::path::Path;

/// Largest message, bytes.
pub(crate) const MESSAGE_BYTES: usize = 4 << 20;

/// Memory that this process may use: that of the machine, or less where a control
/// group (a container, a systemd unit) or `ulimit -v` sets a limit. That one counts what is set
/// aside and never touched, too: half a gigabyte before a server does anything.
pub(crate) fn memory_bytes() -> Option<u64> {
    let groups = std::fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
    let of_groups = group_limits(&groups, Path::new("/sys/fs/cgroup"));
    let space = own("Max address space").map(|limit| limit.saturating_sub(set_aside()));
    let single = [installed_bytes(), space];
    single.into_iter().flatten().chain(of_groups).min()
}

/// Descriptors that this process may have open.
pub(crate) fn descriptors() -> Option<u64> {
    own("Max open files")
}

fn own(name: &str) -> Option<u64> {
    soft_limit(&std::fs::read_to_string("/proc/self/limits").ok()?, name)
}

/// The soft limit of that name; `None` for `unlimited`.
fn soft_limit(table: &str, name: &str) -> Option<u64> {
    let line = table.lines().find_map(|line| line.strip_prefix(name))?;
    line.split_ascii_whitespace().next()?.parse().ok()
}

fn installed_bytes() -> Option<u64> {
    figure(&std::fs::read_to_string("/proc/meminfo").ok()?, "MemTotal:")
}

/// Address space that this process has already.
fn set_aside() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    figure(&status, "VmSize:").unwrap_or(0)
}

/// Bytes in the line of that name, which has kibibytes.
fn figure(table: &str, name: &str) -> Option<u64> {
    let line = table.lines().find_map(|line| line.strip_prefix(name))?;
    let kibibytes: u64 = line.split_whitespace().next()?.parse().ok()?;
    kibibytes.checked_mul(1024)
}

/// Limits of the control groups of the process and of all groups around them:
/// version 2 by `memory.max`, version 1 by `memory.limit_in_bytes`. Inside a container
/// the root is the group itself.
fn group_limits(groups: &str, root: &Path) -> Vec<u64> {
    let mut found = Vec::new();
    for line in groups.lines() {
        let mut parts = line.splitn(3, ':');
        let (_, controllers, group) = (parts.next(), parts.next(), parts.next());
        let (Some(controllers), Some(group)) = (controllers, group) else {
            continue;
        };
        let is_memory = controllers.split(',').any(|one| one == "memory");
        let (root, file) = match controllers {
            "" => (root.to_owned(), "memory.max"),
            _ if is_memory => (root.join("memory"), "memory.limit_in_bytes"),
            _ => continue,
        };
        for around in Path::new(group.trim_start_matches('/')).ancestors() {
            // `max` is no number: no limit.
            let text = std::fs::read_to_string(root.join(around).join(file));
            found.extend(text.ok().and_then(|text| text.trim().parse::<u64>().ok()));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_soft_limit_is_found_by_its_name() {
        let table = "Limit                     Soft Limit           Hard Limit           Units     \n\
            Max address space         unlimited            unlimited            bytes     \n\
            Max open files            1024                 524288               files     \n";
        assert_eq!(soft_limit(table, "Max open files"), Some(1024));
        assert_eq!(soft_limit(table, "Max address space"), None);
        assert_eq!(soft_limit(table, "Max nothing"), None);
        assert!(descriptors().is_some());
    }

    #[test]
    fn figures_of_the_system_are_kibibytes() {
        let table = "MemTotal:       24105 kB\nVmSize:\t     578 kB\nVmData: many\n";
        assert_eq!(figure(table, "VmSize:"), Some(578 << 10));
        assert_eq!(figure(table, "VmData:"), None);
        assert!(set_aside() > 1 << 20);
    }

    #[test]
    fn limits_of_both_versions_and_of_the_groups_around_are_found() {
        let root = std::env::temp_dir().join(format!("signorini-groups-{}", std::process::id()));
        let files = [
            ("pod/memory.max", "600000000\n"),
            ("pod/unit/memory.max", "max\n"),
            ("memory/old/memory.limit_in_bytes", "500000000\n"),
        ];
        for (file, text) in files {
            let path = root.join(file);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        let groups = "4:cpu,memory:/old\n3:pids:/pod\n0::/pod/unit\n";
        let mut found = group_limits(groups, &root);
        found.sort_unstable();
        std::fs::remove_dir_all(&root).unwrap();
        assert_eq!(found, [500_000_000, 600_000_000]);
    }
}
