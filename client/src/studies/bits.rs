//! One bit for each case of a study.

/// Which cases are done.
#[derive(Debug)]
pub(crate) struct Bits {
    words: Vec<u64>,
    set: u64,
}

impl Bits {
    /// For so many cases, none done.
    pub(crate) fn new(count: u64) -> Self {
        let words = usize::try_from(count.div_ceil(64)).unwrap_or(usize::MAX);
        Self {
            words: vec![0; words],
            set: 0,
        }
    }

    /// Whether a case is done.
    pub(crate) fn has(&self, index: u64) -> bool {
        let word = usize::try_from(index / 64)
            .ok()
            .and_then(|at| self.words.get(at));
        word.is_some_and(|word| word >> (index % 64) & 1 == 1)
    }

    /// Notes a case; whether it is one that was not done.
    pub(crate) fn insert(&mut self, index: u64) -> bool {
        let word = usize::try_from(index / 64).ok();
        let Some(word) = word.and_then(|at| self.words.get_mut(at)) else {
            return false;
        };
        let bit = 1 << (index % 64);
        let is_new = *word & bit == 0;
        *word |= bit;
        self.set += u64::from(is_new);
        is_new
    }

    /// How many are done.
    pub(crate) fn count(&self) -> u64 {
        self.set
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_case_counts_once_and_none_beyond_the_last() {
        let mut bits = Bits::new(65);
        assert!(bits.insert(0) && bits.insert(64) && !bits.insert(64) && !bits.insert(1000));
        assert!(bits.has(64) && !bits.has(63) && !bits.has(1000));
        assert_eq!(bits.count(), 2);
    }
}
