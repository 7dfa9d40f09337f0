//! A set of indices below a fixed length: one bit each, touched only where set.

/// The set.
#[derive(Debug)]
pub(super) struct Bits {
    /// 64 members a word, the lowest number in the lowest bit.
    words: Vec<u64>,
}

impl Bits {
    /// The empty set of indices below `length`.
    pub(super) fn new(length: usize) -> Self {
        Self {
            words: vec![0; length.div_ceil(64)],
        }
    }

    /// Whether `index` was not there before.
    pub(super) fn insert(&mut self, index: usize) -> bool {
        let word = &mut self.words[index / 64];
        let bit = 1 << (index % 64);
        let is_new = *word & bit == 0;
        *word |= bit;
        is_new
    }

    /// Takes `index` out of the set.
    pub(super) fn remove(&mut self, index: usize) {
        self.words[index / 64] &= !(1 << (index % 64));
    }

    /// Whether `index` is in the set.
    pub(super) fn contains(&self, index: usize) -> bool {
        self.words[index / 64] & (1 << (index % 64)) != 0
    }

    /// Number of members. Cost: one pass over the words.
    pub(super) fn count(&self) -> usize {
        let ones = self.words.iter().map(|word| word.count_ones() as usize);
        ones.sum()
    }

    /// The indices in ascending order.
    pub(super) fn iter(&self) -> impl Iterator<Item = usize> {
        let words = self.words.iter().enumerate();
        words.flat_map(|(position, &word)| {
            let rest = |&word: &u64| Some(word & (word - 1)).filter(|&rest| rest != 0);
            std::iter::successors(Some(word).filter(|&word| word != 0), rest)
                .map(move |word| 64 * position + word.trailing_zeros() as usize)
        })
    }

    /// For each block of 64 indices the number of members before it. The number
    /// before any index then takes one look, see [`Bits::rank`].
    pub(super) fn ranks(&self) -> Vec<u32> {
        let mut before = 0;
        let ranks = self.words.iter().map(|word| {
            let rank = before;
            before += word.count_ones();
            rank
        });
        ranks.collect()
    }

    /// Members below `index`; `ranks` are those of this set.
    pub(super) fn rank(&self, ranks: &[u32], index: usize) -> u32 {
        let below = self.words[index / 64] & ((1 << (index % 64)) - 1);
        ranks[index / 64] + below.count_ones()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MEMBERS: [usize; 6] = [0, 1, 63, 64, 130, 199];

    fn sample() -> Bits {
        let mut bits = Bits::new(200);
        for member in MEMBERS {
            assert!(bits.insert(member));
            assert!(!bits.insert(member));
        }
        bits
    }

    #[test]
    fn members_come_in_order_and_leave() {
        let mut bits = sample();
        assert_eq!(bits.iter().collect::<Vec<_>>(), MEMBERS);
        assert_eq!(bits.count(), 6);
        bits.remove(64);
        assert!(!bits.contains(64) && bits.contains(63));
    }

    #[test]
    fn rank_counts_the_members_below() {
        let bits = sample();
        let ranks = bits.ranks();
        for index in 0..200 {
            let below = MEMBERS.iter().filter(|&&member| member < index).count();
            assert_eq!(bits.rank(&ranks, index) as usize, below);
        }
    }
}
