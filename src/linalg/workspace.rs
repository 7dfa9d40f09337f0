//! Scratch vectors that are handed out and given back, so that an iteration
//! allocates nothing once its first round has passed.

/// A pool of vectors. Not shared: each session owns one.
#[derive(Debug, Default)]
pub struct Workspace {
    free: Vec<Vec<f64>>,
}

impl Workspace {
    /// An empty pool.
    pub fn new() -> Self {
        Self::default()
    }

    /// A vector of `length` zeros.
    pub fn zeros(&mut self, length: usize) -> Vec<f64> {
        let mut vector = self.reuse(length);
        vector.clear();
        vector.resize(length, 0.0);
        vector
    }

    /// A vector of `length` unspecified finite values, for callers that
    /// overwrite it.
    pub fn scratch(&mut self, length: usize) -> Vec<f64> {
        let mut vector = self.reuse(length);
        vector.resize(length, 0.0);
        vector
    }

    /// A copy of `values`.
    pub fn copy(&mut self, values: &[f64]) -> Vec<f64> {
        let mut vector = self.reuse(values.len());
        vector.clear();
        vector.extend_from_slice(values);
        vector
    }

    fn reuse(&mut self, length: usize) -> Vec<f64> {
        let fitting = self
            .free
            .iter()
            .enumerate()
            .filter(|(_, vector)| vector.capacity() >= length)
            .min_by_key(|(_, vector)| vector.capacity())
            .map(|(index, _)| index);
        match fitting {
            Some(index) => self.free.swap_remove(index),
            None => Vec::with_capacity(length),
        }
    }

    /// Takes a vector back for later use.
    pub fn give(&mut self, vector: Vec<f64>) {
        self.free.push(vector);
    }

    /// Bytes held by the pool.
    pub fn bytes(&self) -> u64 {
        self.free.iter().map(|v| 8 * v.capacity() as u64).sum()
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // These values are exact.
mod tests {
    use super::*;

    #[test]
    fn a_vector_given_back_is_used_again() {
        let mut work = Workspace::new();
        let first = work.zeros(100);
        let address = first.as_ptr();
        work.give(first);
        let second = work.zeros(50);
        assert_eq!(second.as_ptr(), address);
        assert!(second.iter().all(|&x| x == 0.0));
        assert_eq!(second.len(), 50);
    }
}
