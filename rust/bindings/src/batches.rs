//! Work done a few items at a time: in parallel, without the GIL, and with a look for Ctrl-C after each batch.

use std::sync::OnceLock;
use std::time::{Duration, Instant};

use pyo3::prelude::*;
use rayon::prelude::*;

/// How long a batch should take: Ctrl-C waits for the end of one.
const BATCH_TIME: Duration = Duration::from_millis(50);
/// Items for each thread in the first batch, when nothing is known of how long they take.
const FIRST_ITEMS_PER_THREAD: usize = 1;
/// A batch has at most so many times the items of the one before: those to come may take longer.
const LARGEST_GROWTH: f64 = 16.0;
/// The process whose threads rayon's are: none of them is there in a forked one, which would wait for them forever.
static PROCESS: OnceLock<u32> = OnceLock::new();

/// What `work` makes of every item, in order.
pub fn map_in_batches<I: Send, T: Send>(
    py: Python<'_>,
    items: impl IntoIterator<Item = I>,
    work: impl Fn(I) -> T + Sync,
) -> PyResult<Vec<T>> {
    filter_map_in_batches(py, items, |item| Some(work(item)))
}

/// As [`map_in_batches`], without the items of which `work` makes nothing.
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
        results.extend(py.detach(|| match threads {
            // On this thread: waking the only other one takes as long as many an item, and a forked process has none.
            1 => batch.into_iter().filter_map(&work).collect::<Vec<T>>(),
            _ => batch.into_par_iter().filter_map(&work).collect(),
        }));
        py.check_signals()?;
        let growth = BATCH_TIME.as_secs_f64() / started.elapsed().as_secs_f64().max(1e-9);
        size = ((size as f64 * growth.min(LARGEST_GROWTH)) as usize).max(threads);
    }
    Ok(results)
}

/// How many threads share the work.
fn threads() -> usize {
    let process = std::process::id();
    if *PROCESS.get_or_init(|| process) == process { rayon::current_num_threads() } else { 1 }
}
