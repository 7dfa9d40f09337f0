//! Percentiles and memory.

use std::time::Duration;

/// Prints count, median, 90th, 99th percentile and largest of `times`.
pub(crate) fn percentiles(what: &str, times: &mut [Duration]) {
    times.sort_unstable();
    let at = |part: f64| {
        let index = ((times.len() as f64 * part) as usize).min(times.len() - 1);
        times[index].as_secs_f64() * 1e3
    };
    println!(
        "{what}: {} samples, ms: p50 {:.2}  p90 {:.2}  p99 {:.2}  max {:.2}",
        times.len(),
        at(0.5),
        at(0.9),
        at(0.99),
        at(1.0)
    );
}

/// Resident memory of this process, MiB.
pub(crate) fn resident() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let kibibytes =
        line.and_then(|line| line.trim().strip_suffix("kB")?.trim().parse::<f64>().ok());
    kibibytes.unwrap_or(f64::NAN) / 1024.0
}
