//! Parallel work in batches, without the GIL, with a check for Ctrl-C after each batch.

use std::sync::OnceLock;
use std::time::{Duration, Instant};

use pyo3::prelude::*;
use rayon::prelude::*;

/// Target duration of a batch. Ctrl-C waits for the end of the running batch.
const BATCH_TIME: Duration = Duration::from_millis(50);
/// Items per thread in the first batch, before any duration is known.
const FIRST_ITEMS_PER_THREAD: usize = 1;
/// Largest growth from one batch to the next. Later items may take longer than earlier ones.
const MAX_GROWTH: f64 = 16.0;
/// Id of the process that owns rayon's threads. A forked process has none of them and would wait for them forever.
static PROCESS: OnceLock<u32> = OnceLock::new();

/// Results of `work` for every item, in order.
///
/// An error is a Python exception raised by a signal handler, such as `KeyboardInterrupt`.
pub fn map_in_batches<I: Send, T: Send>(
    py: Python<'_>,
    items: impl IntoIterator<Item = I>,
    work: impl Fn(I) -> T + Sync,
) -> PyResult<Vec<T>> {
    filter_map_in_batches(py, items, |item| Some(work(item)))
}

/// Results of `work` for every item, in order, without the items for which it returns `None`.
pub fn filter_map_in_batches<I: Send, T: Send>(
    py: Python<'_>,
    items: impl IntoIterator<Item = I>,
    work: impl Fn(I) -> Option<T> + Sync,
) -> PyResult<Vec<T>> {
    let threads = threads();
    let mut items = items.into_iter().peekable();
    let mut results = Vec::with_capacity(items.size_hint().0);
    let mut size = FIRST_ITEMS_PER_THREAD * threads;
    while items.peek().is_some() {
        let batch: Vec<I> = items.by_ref().take(size).collect();
        let started = Instant::now();
        results.extend(py.detach(|| match threads.min(batch.len()) {
            // The work stays on this thread. Waking a single other thread costs as much as many items, and a forked
            // process has no other.
            1 => batch.into_iter().filter_map(&work).collect::<Vec<T>>(),
            _ => batch.into_par_iter().filter_map(&work).collect(),
        }));
        py.check_signals()?;
        let growth = BATCH_TIME.as_secs_f64() / started.elapsed().as_secs_f64().max(1e-9);
        size = ((size as f64 * growth.min(MAX_GROWTH)) as usize).max(threads);
    }
    Ok(results)
}

/// Number of threads that share the work; 1 in a forked process.
fn threads() -> usize {
    let process = std::process::id();
    if *PROCESS.get_or_init(|| process) == process { rayon::current_num_threads() } else { 1 }
}
