//! Thread pools for the nets, one per thread count, made on first use and kept.

use std::collections::BTreeMap;
use std::sync::{Arc, LazyLock, Mutex, PoisonError};

use rayon::{ThreadPool, ThreadPoolBuilder};

use super::EngineError;

static POOLS: LazyLock<Mutex<BTreeMap<usize, Arc<ThreadPool>>>> = LazyLock::new(Mutex::default);

/// The pool with `threads` threads; 0 means one per processor core.
pub(crate) fn pool(threads: usize) -> Result<Arc<ThreadPool>, EngineError> {
    let mut pools = POOLS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(pool) = pools.get(&threads) {
        return Ok(Arc::clone(pool));
    }
    let pool = ThreadPoolBuilder::new()
        .num_threads(threads)
        .thread_name(|i| format!("net-{i}"))
        .build()
        .map_err(|source| EngineError::Threads { source })?;
    Ok(Arc::clone(pools.entry(threads).or_insert(Arc::new(pool))))
}
