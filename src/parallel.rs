//! Parallel loops over pieces of slices and over numbers.
//!
//! The body of a loop is a borrowed closure, so that a loop is compiled once for each type of a
//! piece: with one for each loop the library had 360 copies of a thread pool's code, a quarter of
//! what was compiled. A call through a pointer is paid once a piece. Results do not depend on the
//! number of threads: pieces are cut by their size alone.

use std::sync::{Mutex, MutexGuard, PoisonError};

use rayon::prelude::*;

/// Blocks of a map at most: well above the threads of a machine, so that these end together. Not
/// measured: results do not depend on it.
const MOST_BLOCKS: usize = 256;

/// Values in pieces of `size`, the last one shorter where they do not divide.
pub struct Pieces<'a, T> {
    /// All of them.
    pub values: &'a mut [T],
    /// Values of a piece, at least 1.
    pub size: usize,
}

impl<'a, T: Send> Pieces<'a, T> {
    /// Those of `size`.
    pub fn of(values: &'a mut [T], size: usize) -> Self {
        Self { values, size }
    }

    fn each(self) -> rayon::slice::ChunksMut<'a, T> {
        self.values.par_chunks_mut(self.size.max(1))
    }
}

/// `body(k, piece)` for each piece k; a thread takes `least` pieces or more.
pub fn each<T: Send>(pieces: Pieces<'_, T>, least: usize, body: &(dyn Fn(usize, &mut [T]) + Sync)) {
    let all = pieces.each().enumerate().with_min_len(least);
    all.for_each(|(k, piece)| body(k, piece));
}

/// What is done with the pieces of two slices of one number.
type OfTwo<'b, A, B> = dyn Fn(usize, &mut [A], &mut [B]) + Sync + 'b;
/// The same of three slices.
type OfThree<'b, A, B> = dyn Fn(usize, &mut [A], [&mut [B]; 2]) + Sync + 'b;

/// The same of two slices with as many pieces.
pub fn each_of_two<A: Send, B: Send>(
    first: Pieces<'_, A>,
    second: Pieces<'_, B>,
    least: usize,
    body: &OfTwo<'_, A, B>,
) {
    let all = first.each().zip(second.each()).enumerate();
    all.with_min_len(least)
        .for_each(|(k, (first, second))| body(k, first, second));
}

/// The same of three slices.
pub fn each_of_three<A: Send, B: Send>(
    first: Pieces<'_, A>,
    [second, third]: [Pieces<'_, B>; 2],
    least: usize,
    body: &OfThree<'_, A, B>,
) {
    let all = first
        .each()
        .zip(second.each())
        .zip(third.each())
        .enumerate();
    all.with_min_len(least)
        .for_each(|(k, ((first, second), third))| body(k, first, [second, third]));
}

/// `make(k)` for k below `count`, in their order; a thread makes `least` or more.
pub fn map<T: Send>(count: usize, least: usize, make: &(dyn Fn(usize) -> T + Sync)) -> Vec<T> {
    let size = count.div_ceil(MOST_BLOCKS).max(least).max(1);
    let made: Vec<Mutex<Vec<T>>> = (0..count.div_ceil(size))
        .map(|_| Mutex::default())
        .collect();
    numbered(made.len(), &|block| {
        let own = (block * size..count.min((block + 1) * size)).map(make);
        let own: Vec<T> = own.collect();
        *locked(&made[block]) = own;
    });
    let mut all = Vec::with_capacity(count);
    for slot in made {
        all.append(&mut slot.into_inner().unwrap_or_else(PoisonError::into_inner));
    }
    all
}

/// The value of a lock under which nothing can panic.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// `body(k)` for k below `count`: compiled once.
fn numbered(count: usize, body: &(dyn Fn(usize) + Sync)) {
    (0..count).into_par_iter().for_each(body);
}

/// Scratch space for bodies of loops: about as many as threads at work, each lent again and again.
pub struct Scratch<'f, W> {
    spare: Mutex<Vec<W>>,
    fresh: &'f (dyn Fn() -> W + Sync),
}

impl<'f, W> Scratch<'f, W> {
    /// None yet; `fresh` makes one.
    pub fn new(fresh: &'f (dyn Fn() -> W + Sync)) -> Self {
        let spare = Mutex::default();
        Self { spare, fresh }
    }

    /// Runs `body` with one of them.
    pub fn lend<T>(&self, body: impl FnOnce(&mut W) -> T) -> T {
        let spare = locked(&self.spare).pop();
        let mut own = spare.unwrap_or_else(|| (self.fresh)());
        let made = body(&mut own);
        locked(&self.spare).push(own);
        made
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_is_met_once_with_the_number_of_its_piece() {
        for size in [1, 7, 100, 1000] {
            let (mut a, mut b, mut c) = (vec![0; 100], vec![0; 200], vec![0; 300]);
            each(Pieces::of(&mut a, size), 1, &|k, piece| {
                piece.iter_mut().for_each(|value| *value += k);
            });
            assert!((0..100).all(|i| a[i] == i / size));
            let two = Pieces::of(&mut b, 2 * size);
            each_of_two(Pieces::of(&mut a, size), two, 2, &|k, a, b| {
                assert_eq!(2 * a.len(), b.len());
                b.fill(k);
            });
            assert!((0..200).all(|i| b[i] == i / (2 * size)));
            let others = [Pieces::of(&mut b, 2 * size), Pieces::of(&mut c, 3 * size)];
            each_of_three(Pieces::of(&mut a, size), others, 1, &|k, a, [b, c]| {
                assert_eq!(2 * a.len(), b.len());
                c.fill(k);
            });
            assert!((0..300).all(|i| c[i] == i / (3 * size)));
        }
    }

    #[test]
    fn maps_keep_the_order_and_give_scratch_on() {
        assert_eq!(map(5, 1, &|k| k * k), [0, 1, 4, 9, 16]);
        let scratch = Scratch::new(&|| 0);
        let seen = map(50, 1, &|_| {
            scratch.lend(|seen| std::mem::replace(seen, *seen + 1))
        });
        let lent = |count| seen.iter().filter(|seen| **seen == count).count();
        assert!(lent(0) >= 1 && (1..50).all(|count| lent(count) <= lent(count - 1)));
    }
}
