//! Work done a few items at a time, so that Ctrl-C is noticed on the way.

use pyo3::prelude::*;
use rayon::prelude::*;

/// Items handed to each thread before Python is asked whether Ctrl-C was pressed.
const ITEMS_PER_THREAD: usize = 4;

/// What `work` makes of every item, in order: in parallel, without the GIL, and looking for Ctrl-C between batches.
pub fn map_in_batches<I: Sync, T: Send>(
    py: Python<'_>,
    items: &[I],
    work: impl Fn(&I) -> T + Sync,
) -> PyResult<Vec<T>> {
    let mut results = Vec::with_capacity(items.len());
    for batch in items.chunks(ITEMS_PER_THREAD * rayon::current_num_threads()) {
        results.extend(py.detach(|| batch.par_iter().map(&work).collect::<Vec<_>>()));
        py.check_signals()?;
    }
    Ok(results)
}

/// As [`map_in_batches`], for work that leaves its results in the items.
pub fn for_each_in_batches<I: Send>(py: Python<'_>, items: &mut [I], work: impl Fn(&mut I) + Sync) -> PyResult<()> {
    for batch in items.chunks_mut(ITEMS_PER_THREAD * rayon::current_num_threads()) {
        py.detach(|| batch.par_iter_mut().for_each(&work));
        py.check_signals()?;
    }
    Ok(())
}
