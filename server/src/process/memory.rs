//! Whether the system still gives memory, and what goes back to it.
//!
//! An allocation that fails in the middle of a solve would end the process, so
//! large ones are tried beforehand: address space is reserved and given back,
//! nothing is touched.

use std::time::Duration;

/// How often freed memory is given back.
const RETURN: Duration = Duration::from_secs(2);

/// The system refuses memory.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the system has no {0} bytes left")]
pub(crate) struct OutOfMemory(pub(crate) u64);

/// Tries whether `bytes` can be had now.
pub(crate) fn probe(bytes: u64) -> Result<(), OutOfMemory> {
    fail::fail_point!("memory", |_| Err(OutOfMemory(bytes)));
    let refused = || OutOfMemory(bytes);
    let size = usize::try_from(bytes).map_err(|_| refused())?;
    let mut trial: Vec<u8> = Vec::new();
    trial.try_reserve_exact(size).map_err(|_| refused())?;
    // Without this the whole trial may be optimised away.
    std::hint::black_box(&trial);
    Ok(())
}

/// Makes the allocator give back what is freed, for a process that serves for days. It is set
/// at once, before threads allocate; the future gives back from time to time and never ends.
///
/// By itself the allocator of glibc has 64 MiB of addresses for each thread, keeps the places of
/// large buffers, and gives back only what lies at an end: beside hostile messages a server then
/// holds three times its budget.
pub fn return_freed_memory() -> impl Future<Output = ()> {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    glibc::set();
    async {
        let mut ticks = tokio::time::interval(RETURN);
        loop {
            ticks.tick().await;
            #[cfg(all(target_os = "linux", target_env = "gnu"))]
            // It fails in a process that ends only.
            drop(tokio::task::spawn_blocking(glibc::trim).await);
        }
    }
}

#[cfg(all(target_os = "linux", target_env = "gnu"))]
#[allow(unsafe_code)]
mod glibc {
    /// Heaps that threads share: enough, because solves allocate little while they iterate.
    const HEAPS: libc::c_int = 2;
    /// Buffers from this size on go back as soon as they are freed.
    const LARGE_BYTES: libc::c_int = 1 << 20;

    pub(super) fn set() {
        for (what, value) in [
            (libc::M_ARENA_MAX, HEAPS),
            (libc::M_MMAP_THRESHOLD, LARGE_BYTES),
            (libc::M_TRIM_THRESHOLD, LARGE_BYTES),
        ] {
            // SAFETY: it takes two numbers and locks the allocator itself.
            unsafe { libc::mallopt(what, value) };
        }
    }

    /// Gives back all free pages, also those between others.
    pub(super) fn trim() {
        // SAFETY: it takes a number and locks the allocator itself.
        unsafe { libc::malloc_trim(0) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_machine_has_is_refused_with_its_number() {
        assert_eq!(probe(1 << 20), Ok(()));
        assert_eq!(probe(1 << 62), Err(OutOfMemory(1 << 62)));
        assert_eq!(probe(u64::MAX), Err(OutOfMemory(u64::MAX)));
    }
}
