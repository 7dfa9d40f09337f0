//! `doctor`: what this machine gives a server, and what will hold it up.
//!
//! Looks at processor, memory, descriptors, loopback, clock and disk, and changes nothing but a
//! file that it removes again. A fault keeps a server from working; an advice says what would
//! serve it better. Cost: some dozens of writes to the disk.

mod proxy;

use std::fmt;
use std::fs::File;
use std::io::Write as _;
use std::net::{Ipv4Addr, TcpListener};
use std::path::Path;
use std::time::{Duration, Instant, SystemTime};

use signorini::assembly::simd::InstructionSet;

use crate::process::limits;

/// Fewer descriptors leave little for connections beside files.
const FEW_DESCRIPTORS: u64 = 4096;
/// Less memory holds small scenes only.
const LITTLE_MEMORY: u64 = 1 << 30;
/// A disk that takes longer holds up every accepted update.
const SLOW_DISK: Duration = Duration::from_millis(20);
/// A server journals until less than this is left.
const LITTLE_ROOM: u64 = 1 << 30;
/// Writes that are timed.
const WRITES: usize = 15;
/// Seconds after 1970 before which no machine has built this program: the start of 2025.
const THE_PAST: u64 = 1_735_689_600;

/// How something is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Health {
    /// As it should be.
    Good,
    /// It works; what would serve better.
    Advice(String),
    /// It keeps a server from working, and why.
    Fault(String),
}

/// One thing that was looked at.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// What was looked at, a word or two.
    pub what: &'static str,
    /// What it is, with units.
    pub found: String,
    /// How that is.
    pub health: Health,
}

/// All that was looked at.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Doctor {
    /// In the order in which they are shown.
    pub findings: Vec<Finding>,
}

impl Doctor {
    /// Whether nothing keeps a server from working here.
    pub fn is_fit(&self) -> bool {
        let mut findings = self.findings.iter();
        !findings.any(|one| matches!(one.health, Health::Fault(_)))
    }
}

impl fmt::Display for Doctor {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        for Finding {
            what,
            found,
            health,
        } in &self.findings
        {
            let (mark, words) = match health {
                Health::Good => ("ok", None),
                Health::Advice(words) => ("advice", Some(words)),
                Health::Fault(words) => ("fault", Some(words)),
            };
            write!(formatter, "{mark:7} {what:16} {found}")?;
            match words {
                Some(words) => writeln!(formatter, ": {words}")?,
                None => writeln!(formatter)?,
            }
        }
        Ok(())
    }
}

/// Looks at this machine, at the disk of `folder`, where a server shall keep its data, and at the
/// program of a proxy that shall stand in front, where there is to be one.
pub fn doctor(folder: &Path, proxy: Option<&Path>) -> Doctor {
    let mut findings = machine(folder);
    findings.extend(proxy.map(proxy::proxy));
    Doctor { findings }
}

fn machine(folder: &Path) -> Vec<Finding> {
    vec![
        instruction_set(InstructionSet::of_this_machine().name()),
        cores(std::thread::available_parallelism().map_or(0, usize::from)),
        memory(limits::memory_bytes()),
        descriptors(limits::descriptors()),
        loopback(),
        clock(SystemTime::now()),
        room(folder),
        disk(folder),
    ]
}

fn finding(what: &'static str, found: String, health: Health) -> Finding {
    Finding {
        what,
        found,
        health,
    }
}

/// Advice where something is `poor`.
fn unless(poor: bool, advice: &str) -> Health {
    if poor {
        Health::Advice(advice.to_owned())
    } else {
        Health::Good
    }
}

fn instruction_set(name: &str) -> Finding {
    let advice =
        "kernels run without vectors; results of other instruction sets differ by rounding";
    finding(
        "instruction set",
        name.to_owned(),
        unless(name == "portable", advice),
    )
}

fn cores(count: usize) -> Finding {
    let advice = "one solve at a time, and health beside it: give the server two";
    finding("cores", count.to_string(), unless(count < 2, advice))
}

fn memory(bytes: Option<u64>) -> Finding {
    let advice = "small scenes only: raise the limit of the container or the unit";
    match bytes {
        Some(bytes) => finding(
            "memory",
            format!("{} MiB for this process", bytes >> 20),
            unless(bytes < LITTLE_MEMORY, advice),
        ),
        None => {
            let advice = "say memory_budget_bytes: three quarters of the memory where that is known, else 8 GiB";
            finding("memory", "unknown".to_owned(), unless(true, advice))
        }
    }
}

fn descriptors(limit: Option<u64>) -> Finding {
    let few = limit.is_some_and(|limit| limit < FEW_DESCRIPTORS);
    let found = limit.map_or("unlimited".to_owned(), |limit| limit.to_string());
    let advice = "raise `ulimit -n`, or LimitNOFILE of the unit, to 65536";
    finding("descriptors", found, unless(few, advice))
}

fn loopback() -> Finding {
    let bound = TcpListener::bind((Ipv4Addr::LOCALHOST, 0));
    let (found, health) = match bound.and_then(|listener| listener.local_addr()) {
        Ok(_) => ("127.0.0.1 can be listened on".to_owned(), Health::Good),
        Err(error) => ("127.0.0.1".to_owned(), Health::Fault(error.to_string())),
    };
    finding("loopback", found, health)
}

fn clock(now: SystemTime) -> Finding {
    let since = now.duration_since(SystemTime::UNIX_EPOCH);
    let seconds = since.map_or(0, |since| since.as_secs());
    let advice = "it stands in the past: certificates and the ages of sessions go by it";
    let found = format!("{seconds} seconds since 1970");
    finding("clock", found, unless(seconds < THE_PAST, advice))
}

fn room(folder: &Path) -> Finding {
    match rustix::fs::statvfs(folder) {
        Ok(found) => {
            let free = found.f_bavail.saturating_mul(found.f_frsize);
            let advice = "a server keeps meshes, updates and results there: make room";
            finding(
                "room on disk",
                format!("{} MiB free in {}", free >> 20, folder.display()),
                unless(free < LITTLE_ROOM, advice),
            )
        }
        Err(error) => finding(
            "room on disk",
            folder.display().to_string(),
            Health::Fault(error.to_string()),
        ),
    }
}

fn disk(folder: &Path) -> Finding {
    match time_of_a_write(folder) {
        Ok(time) => finding(
            "writes to disk",
            format!("{:.2} ms each, with fsync", 1e3 * time.as_secs_f64()),
            unless(time > SLOW_DISK, "each accepted update waits for one"),
        ),
        Err(error) => finding(
            "writes to disk",
            folder.display().to_string(),
            Health::Fault(error.to_string()),
        ),
    }
}

/// Median time of a small write that the disk has when it returns.
fn time_of_a_write(folder: &Path) -> std::io::Result<Duration> {
    let path = folder.join(format!(".signorini-doctor-{}", std::process::id()));
    let mut file = File::options().write(true).create_new(true).open(&path)?;
    let timed = timed_writes(&mut file);
    std::fs::remove_file(&path)?;
    timed
}

fn timed_writes(file: &mut File) -> std::io::Result<Duration> {
    let mut times = Vec::with_capacity(WRITES);
    for _ in 0..WRITES {
        let start = Instant::now();
        file.write_all(&[0; 4096])?;
        file.sync_data()?;
        times.push(start.elapsed());
    }
    times.sort_unstable();
    Ok(times.get(WRITES / 2).copied().unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn this_machine_is_fit_and_the_folder_is_left_as_it_was() {
        let folder = std::env::temp_dir().join(format!("signorini-doctor-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let found = doctor(&folder, None);
        assert!(found.is_fit(), "{found}");
        assert_eq!(found.findings.len(), 8);
        assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 0);
        std::fs::remove_dir_all(&folder).unwrap();
        let gone = doctor(&folder, None);
        assert!(!gone.is_fit());
        assert!(
            gone.to_string().contains("fault   writes to disk"),
            "{gone}"
        );
    }

    #[test]
    fn what_is_scarce_is_said_with_what_to_do() {
        let advised = |finding: Finding| matches!(finding.health, Health::Advice(_));
        assert!(advised(cores(1)) && !advised(cores(2)));
        assert!(advised(memory(Some(600 << 20))) && !advised(memory(Some(4 << 30))));
        assert!(advised(memory(None)));
        assert!(advised(descriptors(Some(1024))) && !advised(descriptors(None)));
        assert!(advised(instruction_set("portable")) && !advised(instruction_set("avx2")));
        assert!(advised(clock(SystemTime::UNIX_EPOCH)) && !advised(clock(SystemTime::now())));
    }
}
