//! Scratch vectors that are handed out and given back, so that an iteration
//! allocates nothing once its first round has passed.

use std::mem::MaybeUninit;

use super::vector::assign;

/// A pool of vectors. Not shared: each session owns one.
#[derive(Debug, Default)]
pub struct Workspace {
    free: Vec<Vec<f64>>,
    free_f32: Vec<Vec<f32>>,
    free_memory: Vec<Vec<MaybeUninit<f64>>>,
}

impl Workspace {
    /// An empty pool.
    pub fn new() -> Self {
        Self::default()
    }

    /// A vector of `length` zeros.
    pub fn zeros(&mut self, length: usize) -> Vec<f64> {
        match reuse(&mut self.free, length) {
            Some(mut vector) => {
                vector.clear();
                vector.resize(length, 0.0);
                vector
            }
            None => vec![0.0; length],
        }
    }

    /// A vector of `length` unspecified finite values, for callers that
    /// overwrite it.
    pub fn scratch(&mut self, length: usize) -> Vec<f64> {
        sized(&mut self.free, length)
    }

    /// A copy of `values`.
    pub fn copy(&mut self, values: &[f64]) -> Vec<f64> {
        let mut vector = sized(&mut self.free, values.len());
        assign(&mut vector, values);
        vector
    }

    /// Takes a vector back for later use.
    pub fn give(&mut self, vector: Vec<f64>) {
        self.free.push(vector);
    }

    /// [`Self::scratch`] in single precision.
    pub fn scratch_f32(&mut self, length: usize) -> Vec<f32> {
        sized(&mut self.free_f32, length)
    }

    /// [`Self::give`] in single precision.
    pub fn give_f32(&mut self, vector: Vec<f32>) {
        self.free_f32.push(vector);
    }

    /// At least `bytes` of memory for a factor's solve.
    pub(super) fn memory(&mut self, bytes: usize) -> Vec<MaybeUninit<f64>> {
        let mut memory = reuse(&mut self.free_memory, bytes.div_ceil(8)).unwrap_or_default();
        memory.resize(bytes.div_ceil(8), MaybeUninit::uninit());
        memory
    }

    /// [`Self::give`] of memory.
    pub(super) fn give_memory(&mut self, memory: Vec<MaybeUninit<f64>>) {
        self.free_memory.push(memory);
    }

    /// Bytes held by the pool.
    pub fn bytes(&self) -> u64 {
        let double: usize = self.free.iter().map(Vec::capacity).sum();
        let single: usize = self.free_f32.iter().map(Vec::capacity).sum();
        let memory: usize = self.free_memory.iter().map(Vec::capacity).sum();
        (8 * (double + memory) + 4 * single) as u64
    }
}

/// A vector of `length` unspecified values. A new one comes zeroed from the system, which clears
/// its pages where they are first used, and so by all threads.
fn sized<T: Copy + Default>(free: &mut Vec<Vec<T>>, length: usize) -> Vec<T> {
    match reuse(free, length) {
        Some(mut vector) => {
            vector.resize(length, T::default());
            vector
        }
        None => vec![T::default(); length],
    }
}

/// The smallest free vector that holds `length`.
fn reuse<T>(free: &mut Vec<Vec<T>>, length: usize) -> Option<Vec<T>> {
    let fitting = free
        .iter()
        .enumerate()
        .filter(|(_, vector)| vector.capacity() >= length)
        .min_by_key(|(_, vector)| vector.capacity())
        .map(|(index, _)| index);
    fitting.map(|index| free.swap_remove(index))
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
