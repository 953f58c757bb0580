//! Thread pools for the nets, one per thread count, made on first use and kept.

use std::collections::BTreeMap;
use std::sync::{Arc, LazyLock, Mutex, PoisonError};

use rayon::{ThreadPool, ThreadPoolBuilder};

use super::EngineError;
use crate::kernel::team::Team;

static POOLS: LazyLock<Mutex<BTreeMap<usize, Arc<Pool>>>> = LazyLock::new(Mutex::default);

/// Threads that do one job at a time.
///
/// tract keeps scratch memory per thread while it waits for other threads. If such a thread took up a second net in the
/// meantime, it would find its scratch memory in use. And two light fields at once would be no faster.
pub(crate) struct Pool {
    threads: ThreadPool,
    /// What the kernel does is done by these; they stay awake from layer to layer.
    team: Team,
    turn: Mutex<()>,
}

impl Pool {
    /// Runs `job` on the pool, after the jobs that came before it. On a thread of the pool it is part of the job that
    /// runs there.
    pub(crate) fn install<R: Send>(&self, job: impl FnOnce() -> R + Send) -> R {
        if self.threads.current_thread_index().is_some() {
            return job();
        }
        let _turn = self.turn.lock().unwrap_or_else(PoisonError::into_inner);
        self.threads.install(|| self.team.lead(job))
    }

    /// How many they are.
    pub(crate) fn current_num_threads(&self) -> usize {
        self.threads.current_num_threads()
    }
}

/// The pool with `threads` threads; 0 means one per processor core.
pub(crate) fn pool(threads: usize) -> Result<Arc<Pool>, EngineError> {
    let mut pools = POOLS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(pool) = pools.get(&threads) {
        return Ok(Arc::clone(pool));
    }
    let made = ThreadPoolBuilder::new()
        .num_threads(threads)
        .thread_name(|i| format!("net-{i}"))
        .build()
        .map_err(|source| EngineError::Threads { source })?;
    let team = Team::new(made.current_num_threads());
    let pool = Arc::new(Pool { threads: made, team, turn: Mutex::default() });
    pools.insert(threads, Arc::clone(&pool));
    Ok(pool)
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use rayon::prelude::*;

    use super::*;

    #[test]
    fn jobs_of_one_pool_take_turns_and_may_be_nested() {
        let (inside, most) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let job = || {
            most.fetch_max(inside.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
            let sum: usize = pool(3).unwrap().install(|| (0..10_000usize).into_par_iter().with_max_len(1).sum());
            inside.fetch_sub(1, Ordering::SeqCst);
            sum
        };
        std::thread::scope(|scope| {
            let runs: Vec<_> = (0..8).map(|_| scope.spawn(|| pool(3).unwrap().install(job))).collect();
            assert!(runs.into_iter().all(|run| run.join().unwrap() == 49_995_000));
        });
        assert_eq!(most.into_inner(), 1);
    }
}
