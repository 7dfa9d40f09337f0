//! Sorting what belongs to vertices: counted into the places of its vertex, then the few of each
//! among themselves, in parallel. Cost: two passes over all, and a number a vertex.

use rayon::prelude::*;

/// Vertices that a thread takes at a time.
const AT_A_TIME: usize = 4096;

/// Sorts what belongs to vertices, the `first` of which is what it is sorted by first: by vertex
/// in one pass, then the few of each.
pub(super) fn sorted_by_vertex<T: Ord + Copy + Default + Send>(
    all: impl Iterator<Item = T> + Clone,
    vertices: usize,
    first: impl Fn(&T) -> u32,
) -> Vec<T> {
    let mut next = vec![0_u32; vertices + 1];
    for one in all.clone() {
        next[first(&one) as usize + 1] += 1;
    }
    for vertex in 0..vertices {
        next[vertex + 1] += next[vertex];
    }
    let count = next[vertices] as usize;
    let mut sorted = vec![T::default(); count];
    for one in all {
        let place = &mut next[first(&one) as usize];
        sorted[*place as usize] = one;
        *place += 1;
    }
    // Now `next` holds where each vertex ends.
    let mut rest = &mut sorted[..];
    let mut parts = Vec::with_capacity(vertices.div_ceil(AT_A_TIME));
    let mut start = 0;
    for ends in next[..vertices].chunks(AT_A_TIME) {
        let end = ends.last().copied().unwrap_or(start);
        let (part, behind) = rest.split_at_mut((end - start) as usize);
        parts.push((part, start, ends));
        (rest, start) = (behind, end);
    }
    parts.into_par_iter().for_each(|(part, start, ends)| {
        let mut from = 0;
        for end in ends.iter().map(|end| (end - start) as usize) {
            part[from..end].sort_unstable();
            from = end;
        }
    });
    sorted
}
