//! Whether the system still gives memory.
//!
//! An allocation that fails in the middle of a solve would end the process, so
//! large ones are tried beforehand: address space is reserved and given back,
//! nothing is touched.

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
