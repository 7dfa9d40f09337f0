//! What the system lets this process have: memory and descriptors; and how large a message is.

use std::path::{Path, PathBuf};

/// Largest message, bytes.
pub(crate) const MESSAGE_BYTES: usize = 4 << 20;

/// Memory that this process may use: that of the machine, or less where a control
/// group (a container, a systemd unit) or `ulimit -v` sets a limit. That one counts what is set
/// aside and never touched, too: half a gigabyte before a server does anything.
pub(crate) fn memory_bytes() -> Option<u64> {
    System::here().memory_bytes()
}

/// Descriptors that this process may have open.
pub(crate) fn descriptors() -> Option<u64> {
    System::here().limit("Max open files")
}

/// Where the system tells what there is.
struct System {
    processes: PathBuf,
    groups: PathBuf,
}

impl System {
    fn here() -> Self {
        Self {
            processes: "/proc".into(),
            groups: "/sys/fs/cgroup".into(),
        }
    }

    fn memory_bytes(&self) -> Option<u64> {
        let of_groups = group_limits(&self.table("self/cgroup"), &self.groups);
        let space = self.limit("Max address space");
        let space = space.map(|limit| limit.saturating_sub(self.set_aside()));
        let installed = figure(&self.table("meminfo"), "MemTotal:");
        let single = [installed, space];
        single.into_iter().flatten().chain(of_groups).min()
    }

    fn limit(&self, name: &str) -> Option<u64> {
        soft_limit(&self.table("self/limits"), name)
    }

    /// Address space that this process has already.
    fn set_aside(&self) -> u64 {
        figure(&self.table("self/status"), "VmSize:").unwrap_or(0)
    }

    /// Empty where the system has no such table.
    fn table(&self, name: &str) -> String {
        std::fs::read_to_string(self.processes.join(name)).unwrap_or_default()
    }
}

/// The soft limit of that name; `None` for `unlimited`.
fn soft_limit(table: &str, name: &str) -> Option<u64> {
    let line = table.lines().find_map(|line| line.strip_prefix(name))?;
    line.split_ascii_whitespace().next()?.parse().ok()
}

/// Bytes in the line of that name, which has kibibytes.
fn figure(table: &str, name: &str) -> Option<u64> {
    let line = table.lines().find_map(|line| line.strip_prefix(name))?;
    let kibibytes: u64 = line.split_whitespace().next()?.parse().ok()?;
    kibibytes.checked_mul(1024)
}

/// Limits of the control groups of the process and of all groups around them:
/// version 2 by `memory.max`, version 1 by `memory.limit_in_bytes`. Inside a container
/// the root is the group itself, whether the table names it `/` or as the machine does.
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
        assert!(System::here().set_aside() > 1 << 20);
    }

    /// A machine of 16 GB with those files of control groups, below the table of the process.
    fn machine(name: &str, table: &str, files: &[(&str, &str)]) -> System {
        let root = std::env::temp_dir().join(format!("signorini-{name}-{}", std::process::id()));
        let put = |path: &Path, text: &str| {
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        };
        let (processes, groups) = (root.join("proc"), root.join("groups"));
        put(&processes.join("meminfo"), "MemTotal:       15625000 kB\n");
        put(&processes.join("self/status"), "VmSize:\t     500000 kB\n");
        let limits =
            "Max address space         unlimited            unlimited            bytes     \n";
        put(&processes.join("self/limits"), limits);
        put(&processes.join("self/cgroup"), table);
        for (file, text) in files {
            put(&groups.join(file), text);
        }
        System { processes, groups }
    }

    fn memory(name: &str, table: &str, files: &[(&str, &str)]) -> Option<u64> {
        let system = machine(name, table, files);
        let found = system.memory_bytes();
        std::fs::remove_dir_all(system.processes.parent().unwrap()).unwrap();
        found
    }

    const ALL: Option<u64> = Some(16_000_000_000);
    const LITTLE: Option<u64> = Some(600_000_000);

    #[test]
    fn memory_is_that_of_the_least_group_around_in_version_2() {
        let table = "0::/pod.slice/pod-7.slice/unit.scope\n";
        let around = [
            ("pod.slice/memory.max", "600000000\n"),
            ("pod.slice/pod-7.slice/memory.max", "max\n"),
            ("pod.slice/pod-7.slice/unit.scope/memory.max", "900000000\n"),
        ];
        assert_eq!(memory("nested", table, &around), LITTLE);
        let own = [("pod.slice/pod-7.slice/unit.scope/memory.max", "600000000\n")];
        assert_eq!(memory("own", table, &own), LITTLE);
        assert_eq!(memory("free", table, &around[1..2]), ALL);
    }

    #[test]
    fn memory_is_that_of_the_least_group_around_in_version_1() {
        let table = "9:name=systemd:/\n4:cpu,memory:/jobs/7\n3:pids:/pids\n0::/\n";
        let none = (
            "memory/jobs/7/memory.limit_in_bytes",
            "9223372036854771712\n",
        );
        let around = ("memory/jobs/memory.limit_in_bytes", "600000000\n");
        assert_eq!(memory("jobs", table, &[none, around]), LITTLE);
        let own = ("memory/jobs/7/memory.limit_in_bytes", "600000000\n");
        assert_eq!(memory("job", table, &[own]), LITTLE);
        assert_eq!(memory("none", table, &[none]), ALL);
        // Another controller's path is none of memory's.
        let other = ("memory/pids/memory.limit_in_bytes", "600000000\n");
        assert_eq!(memory("pids", table, &[other]), ALL);
    }

    #[test]
    fn inside_a_container_the_root_is_the_group() {
        let new = ("memory.max", "600000000\n");
        let old = ("memory/memory.limit_in_bytes", "600000000\n");
        for (name, table, file) in [
            ("namespace", "0::/\n", new),
            ("mounted", "0::/docker/0123abcd\n", new),
            ("outside", "0::/../../docker/0123abcd\n", new),
            ("old", "4:memory:/\n", old),
            ("old-mounted", "4:memory:/docker/0123abcd\n", old),
        ] {
            assert_eq!(memory(name, table, &[file]), LITTLE, "{name}");
        }
    }

    #[test]
    fn memory_is_that_of_the_address_space_less_what_is_set_aside_or_of_the_machine() {
        let system = machine("space", "0::/\n", &[]);
        assert_eq!(system.memory_bytes(), ALL);
        let limits =
            "Max address space         1112000000           unlimited            bytes     \n";
        std::fs::write(system.processes.join("self/limits"), limits).unwrap();
        assert_eq!(system.memory_bytes(), LITTLE);
        std::fs::remove_dir_all(system.processes.parent().unwrap()).unwrap();
        // A system that tells nothing.
        assert_eq!(system.memory_bytes(), None);
        assert!(memory_bytes().is_some());
    }
}
