//! Work on vertices, divided among threads.

use rayon::prelude::*;
use std::ops::Range;

/// The vertices 0 to `count` in one run for each thread.
///
/// What a face does to its vertices is done by going through all faces once for each run and leaving alone the vertices
/// of other runs: reading faces is the least of the work, and each vertex meets its faces in their order.
pub(super) fn shares(count: usize) -> impl IndexedParallelIterator<Item = Range<usize>> {
    let share = share(count);
    (0..count.div_ceil(share)).into_par_iter().map(move |i| i * share..count.min((i + 1) * share))
}

/// The length of such a run.
pub(super) fn share(count: usize) -> usize {
    count.div_ceil(rayon::current_num_threads()).max(1)
}
