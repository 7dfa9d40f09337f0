//! Numbers grouped by a key: a counting sort that keeps the order of arrival.

/// One group of numbers per key.
pub(super) struct Buckets {
    /// Start of each key's group in `members` `[keys + 1]`.
    starts: Vec<u32>,
    /// Members of all groups, one group after the other; within a group in the order
    /// given.
    members: Vec<u32>,
}

impl Buckets {
    /// Groups the positions of `keys`, of which there are fewer than 2^32, by key;
    /// each key is below `key_count`.
    pub(super) fn new<Keys: Iterator<Item = u32> + Clone>(key_count: usize, keys: Keys) -> Self {
        // Counts stand two places after their keys: filling moves each start
        // one place on, to where it belongs.
        let mut starts = vec![0_u32; key_count + 2];
        for key in keys.clone() {
            starts[key as usize + 2] += 1;
        }
        let mut total = 0;
        for count in &mut starts {
            total += *count;
            *count = total;
        }
        let mut members = vec![0; total as usize];
        for (key, position) in keys.zip(0..) {
            let next = &mut starts[key as usize + 1];
            members[*next as usize] = position;
            *next += 1;
        }
        starts.pop();
        Self { starts, members }
    }

    /// The members of the group of `key`.
    pub(super) fn group(&self, key: usize) -> &[u32] {
        &self.members[self.starts[key] as usize..self.starts[key + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_keep_the_order_of_arrival() {
        let buckets = Buckets::new(4, [2, 0, 2, 3, 0].into_iter());
        let groups: Vec<_> = (0..4).map(|key| buckets.group(key)).collect();
        assert_eq!(groups, [&[1, 4][..], &[], &[0, 2], &[3]]);
    }
}
